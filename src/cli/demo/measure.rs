//! The session of the demonstration: measured with emulated gauges, through the very command that measures with real ones.

use std::path::Path;

use crate::cli::{Failure, Global};

/// Measures a session in a folder that did not exist, and shows how far it is.
#[cfg(unix)]
pub(super) fn measure(folder: &Path, global: &Global) -> Result<(), Failure> {
    use crate::cli::session::run_command;

    let name = folder.display().to_string();
    let command = [COMMAND_BEGINS, &[name.as_str()], COMMAND_GOES_ON].concat();
    run_command(&command, watch::Watcher::boxed(global), global)
}

/// How the session is run: the paper's procedure, at a speed at which a line still has time for a dozen values while a load settles.
#[cfg(unix)]
const COMMAND_BEGINS: &[&str] = &["session", "run"];
#[cfg(unix)]
const COMMAND_GOES_ON: &[&str] = &[
    "--emulated",
    "--robot",
    "hp-robot",
    "--procedure",
    "paper",
    "--speed",
    "200",
    "--seed",
    "7",
    "--no-input",
    "--operator",
    "stiffbench demo",
    "--answer",
    "temperature=21",
    "--answer",
    "drift=keep",
];

/// There are no pseudo-terminals on this system: the shipped session, which was simulated, takes their place.
#[cfg(not(unix))]
pub(super) fn measure(folder: &Path, _global: &Global) -> Result<(), Failure> {
    use crate::cli::figure_files::write;

    const READINGS: &str = include_str!("../../../data/sessions/demo/readings.csv");
    const HEADER: &str = include_str!("../../../data/sessions/demo/session.toml");
    write(&folder.join("readings.csv"), READINGS.as_bytes())?;
    write(&folder.join("session.toml"), HEADER.as_bytes())?;
    Ok(())
}

#[cfg(unix)]
mod watch {
    use crate::cli::args::Global;
    use crate::cli::progress::{JobProgress, progress};
    use crate::session::{Operator, SessionView};

    /// An operator who only looks how far the session is.
    pub(super) struct Watcher {
        bar: JobProgress,
    }

    impl Watcher {
        pub(super) fn boxed(global: &Global) -> Box<dyn Operator> {
            Box::new(Self {
                bar: progress(global, "measuring", 0),
            })
        }
    }

    impl Operator for Watcher {
        fn show(&mut self, view: &SessionView) {
            let place = view.place.as_ref().map_or_else(String::new, |place| {
                format!("{} {}", place.pose, place.direction)
            });
            let [accepted, planned] =
                [view.progress.accepted, view.progress.planned].map(|count| count as u64);
            self.bar.set(accepted, planned, &place);
        }
    }

    impl Drop for Watcher {
        fn drop(&mut self) {
            self.bar.finish_and_clear();
        }
    }
}
