//! Keeps the machine from falling asleep while a session runs.

use std::process::{Child, Command, Stdio};

/// A machine that is kept awake as long as this lives.
#[derive(Debug)]
pub struct KeptAwake {
    helper: Child,
}

impl KeptAwake {
    /// Starts what keeps the machine awake.
    ///
    /// The helper ends with this process, also if that is killed.
    ///
    /// # Errors
    /// Why the machine may fall asleep, in words; a session goes on all the same.
    pub fn start() -> Result<Self, String> {
        let pid = std::process::id().to_string();
        let (program, arguments): (&str, Vec<String>) = if cfg!(target_os = "macos") {
            ("caffeinate", vec!["-i".to_owned(), "-w".to_owned(), pid])
        } else if cfg!(target_os = "linux") {
            let words = [
                "--what=sleep:idle",
                "--who=stiffbench",
                "--why=a measurement runs",
            ];
            let mut words = words.map(str::to_owned).to_vec();
            words.extend(["tail".to_owned(), format!("--pid={pid}"), "-f".to_owned()]);
            words.push("/dev/null".to_owned());
            ("systemd-inhibit", words)
        } else {
            return Err("switch off sleep in the system's settings for the time being".to_owned());
        };
        let started = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        match started {
            Ok(helper) => Ok(Self { helper }),
            Err(error) => Err(format!(
                "{program} could not be started ({error}): the machine may fall asleep"
            )),
        }
    }
}

impl Drop for KeptAwake {
    fn drop(&mut self) {
        // If it is gone already, there is nothing left to end.
        let _ = self.helper.kill();
        let _ = self.helper.wait();
    }
}
