//! Emulated gauges behind pseudo-terminals, which any program opens as it opens a serial port.
//!
//! A thread a gauge; it waits for bytes and for what is due, and for nothing else.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;

use crate::Channel;
use stiffbench_units_and_text::clock::Clock;

use super::fault_runner::FaultRunner;
use super::fault_script::{FaultScript, ScriptedFault};
use super::gauge::{EmulatorError, PanelAction};
use super::line::EmulatedLine;
use super::served::{ServedGauge, Shared, link_of, lock};

/// How emulated gauges are hosted.
#[derive(Debug, Default)]
pub struct HostOptions {
    /// Session time, for faults that begin at one.
    pub session: Clock,
    /// Time of the lines: streams, delays, how long faults last. Real unless it is to run faster.
    pub line: Clock,
    /// Folder for a link to each line, `force` and `displacement`, which stays the same when a line is unplugged and comes back. It must exist.
    pub links: Option<PathBuf>,
    /// What goes wrong.
    pub faults: FaultScript,
}

/// Why emulated gauges cannot be hosted.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum HostError {
    /// No pseudo-terminal.
    #[error("no pseudo-terminal is available for the {channel} gauge")]
    #[diagnostic(
        code(stiffbench::emulator::pseudo_terminal),
        help("check that /dev/ptmx and /dev/pts are there and may be used")
    )]
    PseudoTerminal {
        /// Which gauge.
        channel: Channel,
        /// The error of the operating system.
        source: serialport::Error,
    },
    /// No link.
    #[error("{link} cannot be made")]
    #[diagnostic(
        code(stiffbench::output::link),
        help("name a folder that exists and may be written to, without files of these names")
    )]
    Link {
        /// The link.
        link: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A thread that does not start.
    #[error("no thread could be started for the {channel} gauge")]
    #[diagnostic(code(stiffbench::emulator::thread))]
    Thread {
        /// Which gauge.
        channel: Channel,
        /// The error of the operating system.
        source: std::io::Error,
    },
}

/// Hosts emulated gauges until it is dropped.
#[derive(Debug)]
pub struct PtyHost {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

impl PtyHost {
    /// Lays a line to each gauge and serves it. The lines are there when this returns.
    ///
    /// # Errors
    /// [`HostError`].
    pub fn start(lines: Vec<EmulatedLine>, options: HostOptions) -> Result<Self, HostError> {
        let slots = lines.into_iter().map(|line| {
            let found_as = line.gauge().channel();
            Mutex::new(ServedGauge {
                line,
                unplugged_until_s: None,
                found_as,
                terminal: String::new(),
                ending: Vec::new(),
            })
        });
        let shared = Arc::new(Shared {
            slots: slots.collect(),
            runner: Mutex::new(FaultRunner::new(options.faults)),
            session: options.session,
            line: options.line,
            links: options.links,
            suspended_until_s: Mutex::new(0.0),
            stop: AtomicBool::new(false),
            stopped: (Mutex::new(()), Condvar::new()),
        });
        let mut host = Self {
            shared: Arc::clone(&shared),
            threads: Vec::new(),
        };
        for place in 0..shared.slots.len() {
            let terminal = shared.plug_in(place)?;
            let served = Arc::clone(&shared);
            let channel = lock(&shared.slots[place]).line.gauge().channel();
            let thread = std::thread::Builder::new()
                .name(format!("emulated {channel} gauge"))
                .spawn(move || served.serve(place, terminal))
                .map_err(|source| HostError::Thread { channel, source })?;
            host.threads.push(thread);
        }
        Ok(host)
    }

    /// The port under which a gauge is found: its link, or its pseudo-terminal; `None` if it is not hosted, or without a link while it is out.
    #[must_use]
    pub fn port(&self, channel: Channel) -> Option<PathBuf> {
        let mut slots = self.shared.slots.iter().map(lock);
        let slot = slots.find(|slot| slot.found_as == channel)?;
        match &self.shared.links {
            Some(folder) => Some(link_of(folder, channel)),
            None if slot.terminal.is_empty() => None,
            None => Some(PathBuf::from(&slot.terminal)),
        }
    }

    /// An operator action at a gauge; nothing if it is not hosted.
    ///
    /// # Errors
    /// As [`EmulatedLine::press`].
    pub fn press(&self, channel: Channel, panel: &PanelAction) -> Result<(), EmulatorError> {
        let now_s = self.shared.line.now_s();
        for slot in &self.shared.slots {
            let mut slot = lock(slot);
            if slot.line.gauge().channel() == channel {
                slot.line.press(panel, now_s)?;
            }
        }
        Ok(())
    }

    /// Adds a fault; it begins at its moment.
    pub fn fail(&self, fault: ScriptedFault) {
        lock(&self.shared.runner).add(fault);
    }

    /// A load is set: faults that wait for it begin.
    pub fn reading(&self) {
        let due = lock(&self.shared.runner).reading();
        self.shared.begin(&due);
    }

    /// A phase of the session begins: faults that wait for it begin.
    pub fn phase(&self, name: &str) {
        let due = lock(&self.shared.runner).phase(name);
        self.shared.begin(&due);
    }

    /// Packets that a gauge has sent.
    #[must_use]
    pub fn packets_sent(&self, channel: Channel) -> u64 {
        let slots = self.shared.slots.iter().map(lock);
        let of_gauge = slots.filter(|slot| slot.line.gauge().channel() == channel);
        of_gauge.map(|slot| slot.line.packets_sent()).sum()
    }
}

impl Drop for PtyHost {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.stopped.1.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked has nothing left to close.
            let _ = thread.join();
        }
        for slot in &self.shared.slots {
            self.shared.remove_link(lock(slot).found_as);
        }
    }
}
