//! Emulated gauges behind pseudo-terminals, which any program opens as it opens a serial port.
//!
//! A thread a gauge; it waits for bytes and for what is due, and for nothing else. The other end of a line is the outside world: this module
//! makes and removes the links under which it is found.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use crate::clock::Clock;
use crate::instrument::Channel;

use super::fault::Fault;
use super::fault_runner::FaultRunner;
use super::fault_script::{FaultScript, Lasts, ScriptedFault};
use super::gauge::{EmulatorError, Panel};
use super::line::{Line, Until};

/// Longest wait for bytes before the host looks for faults and its own end again.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// How long a line that nobody has opened is left alone.
const NOBODY_THERE: Duration = Duration::from_millis(5);

/// After how many such waits it is looked whether somebody left a lock behind; a program that closes a port and opens it again is faster.
const WAITS_BEFORE_LOOKING: u32 = 20;

/// Speed written into a pseudo-terminal; it has none.
const BAUD: u32 = 9600;

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
    #[error("the system gives no pseudo-terminal for the {channel} gauge")]
    #[diagnostic(
        code(stiffbench::emulator::pseudo_terminal),
        help("check that /dev/ptmx and /dev/pts are there and may be used")
    )]
    PseudoTerminal {
        /// Which gauge.
        channel: Channel,
        /// What the system says.
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
        /// What the system says.
        source: std::io::Error,
    },
    /// A thread that does not start.
    #[error("no thread could be started for the {channel} gauge")]
    #[diagnostic(code(stiffbench::emulator::thread))]
    Thread {
        /// Which gauge.
        channel: Channel,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Hosts emulated gauges until it is dropped.
#[derive(Debug)]
pub struct PtyHost {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    slots: Vec<Mutex<Slot>>,
    runner: Mutex<FaultRunner>,
    session: Clock,
    line: Clock,
    links: Option<PathBuf>,
    /// Nothing is served before this time of the lines, s.
    suspended_until_s: Mutex<f64>,
    stop: AtomicBool,
    stopped: (Mutex<()>, Condvar),
}

/// A gauge, its line, and the name under which that is found.
#[derive(Debug)]
struct Slot {
    line: Line,
    /// The adapter is out until this time of the line, s.
    unplugged_until_s: Option<f64>,
    /// Under whose name it is found when it is plugged in.
    found_as: Channel,
    /// Path of the pseudo-terminal; empty while it is out.
    terminal: String,
    /// Faults at the gauge that end, with their time, s.
    ending: Vec<(f64, Panel)>,
}

impl PtyHost {
    /// Lays a line to each gauge and serves it. The lines are there when this returns.
    ///
    /// # Errors
    /// [`HostError`].
    pub fn start(lines: Vec<Line>, options: HostOptions) -> Result<Self, HostError> {
        let slots = lines.into_iter().map(|line| {
            let found_as = line.gauge().channel();
            Mutex::new(Slot {
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

    /// Somebody does something at a gauge; nothing if it is not hosted.
    ///
    /// # Errors
    /// As [`Line::press`].
    pub fn press(&self, channel: Channel, panel: &Panel) -> Result<(), EmulatorError> {
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

impl Shared {
    /// Serves a gauge to the end.
    fn serve(&self, place: usize, terminal: TTYPort) {
        let mut terminal = Some(terminal);
        let mut waits = 0_u32;
        while !self.stop.load(Ordering::SeqCst) {
            let due = lock(&self.runner).at_time(self.session.now_s());
            self.begin(&due);
            let now_s = self.line.now_s();
            if now_s < *lock(&self.suspended_until_s) {
                self.wait(NOBODY_THERE);
                continue;
            }
            self.end_faults(place, now_s);
            if !self.is_plugged_in(place, now_s) {
                terminal = None;
                self.wait(NOBODY_THERE);
                continue;
            }
            let Some(plugged) = terminal.as_mut() else {
                // A system without a terminal to give is asked again; the line stays away meanwhile.
                terminal = self.plug_in(place).ok();
                self.wait(NOBODY_THERE);
                continue;
            };
            waits = if self.serve_once(place, plugged) {
                0
            } else {
                waits.saturating_add(1)
            };
            if waits == WAITS_BEFORE_LOOKING && self.is_left_locked(place, plugged) {
                terminal = None;
            }
        }
    }

    /// Waits for bytes, at most until something is due, and hands on both ways; whether somebody has the line open.
    fn serve_once(&self, place: usize, terminal: &mut TTYPort) -> bool {
        let due_s = lock(&self.slots[place]).line.next_due_s();
        let wait = due_s.map_or(LONGEST_WAIT, |due_s| {
            self.line.real(due_s - self.line.now_s())
        });
        let mut bytes = [0; 1024];
        let read = terminal
            .set_timeout(wait.min(LONGEST_WAIT))
            .map_err(std::io::Error::from)
            .and_then(|()| terminal.read(&mut bytes));
        let mut slot = lock(&self.slots[place]);
        let sent = slot.line.packets_sent();
        let channel = slot.line.gauge().channel();
        let due = lock(&self.runner).before_packet(channel, sent);
        if !due.is_empty() {
            drop(slot);
            self.begin(&due);
            slot = lock(&self.slots[place]);
        }
        let now_s = self.line.now_s();
        let (answer, somebody) = match read {
            Ok(count) => (slot.line.receive(&bytes[..count], now_s), true),
            Err(error) if error.kind() == ErrorKind::TimedOut => (slot.line.tick(now_s), true),
            Err(_) => (slot.line.tick(now_s), false),
        };
        drop(slot);
        if somebody {
            // A host that does not read loses what does not fit, as on any line without flow control.
            let _ = terminal.set_timeout(LONGEST_WAIT);
            let _ = terminal.write_all(&answer);
        } else {
            self.wait(NOBODY_THERE);
        }
        somebody
    }

    /// Whether nobody has the line open and yet nobody can open it: a program that was killed left its lock on the terminal. The adapter of a
    /// real line would not know of that; a new terminal does not either.
    fn is_left_locked(&self, place: usize, terminal: &mut TTYPort) -> bool {
        if self.links.is_none() {
            return false;
        }
        let path = lock(&self.slots[place]).terminal.clone();
        let opened = serialport::new(path, BAUD).exclusive(false).open_native();
        let _ = terminal.set_timeout(Duration::ZERO);
        opened.is_err()
            && terminal
                .read(&mut [])
                .is_err_and(|error| error.kind() != ErrorKind::TimedOut)
    }

    /// Lays the line of a gauge under the name it is found by.
    fn plug_in(&self, place: usize) -> Result<TTYPort, HostError> {
        let mut slot = lock(&self.slots[place]);
        let channel = slot.found_as;
        let (terminal, other_end) =
            TTYPort::pair().map_err(|source| HostError::PseudoTerminal { channel, source })?;
        slot.terminal = other_end.name().unwrap_or_default();
        if let Some(folder) = &self.links {
            let link = link_of(folder, channel);
            point(&link, Path::new(&slot.terminal))
                .map_err(|source| HostError::Link { link, source })?;
        }
        Ok(terminal)
    }

    /// Whether the adapter is in, or has just come back; however short it was out, its terminal is another one then.
    fn is_plugged_in(&self, place: usize, now_s: f64) -> bool {
        let mut slot = lock(&self.slots[place]);
        let Some(until_s) = slot.unplugged_until_s else {
            return true;
        };
        if slot.terminal.is_empty() && now_s >= until_s {
            slot.unplugged_until_s = None;
        }
        slot.line.cut();
        slot.terminal.clear();
        false
    }

    fn end_faults(&self, place: usize, now_s: f64) {
        let mut slot = lock(&self.slots[place]);
        let ended = slot.ending.extract_if(.., |(at_s, _)| *at_s <= now_s);
        let ended: Vec<Panel> = ended.map(|(_, panel)| panel).collect();
        for panel in ended {
            // What ends a fault names no unit, and only a unit can be refused.
            let _ = slot.line.press(&panel, now_s);
        }
    }

    /// Begins faults.
    fn begin(&self, faults: &[ScriptedFault]) {
        let now_s = self.line.now_s();
        for scripted in faults {
            let until_s = match scripted.lasts {
                Lasts::Seconds(seconds) => Some(now_s + seconds),
                Lasts::Packets(_) | Lasts::Ever => None,
            };
            match scripted.fault {
                Fault::Suspend => {
                    *lock(&self.suspended_until_s) = until_s.unwrap_or(f64::INFINITY);
                }
                Fault::Swap => self.swap(until_s.unwrap_or(now_s)),
                _ => {
                    for slot in &self.slots {
                        let mut slot = lock(slot);
                        if scripted.concerns(slot.line.gauge().channel()) {
                            self.begin_at(&mut slot, scripted, now_s, until_s);
                        }
                    }
                }
            }
        }
    }

    /// Begins a fault of one gauge.
    fn begin_at(
        &self,
        slot: &mut Slot,
        scripted: &ScriptedFault,
        now_s: f64,
        until_s: Option<f64>,
    ) {
        match &scripted.fault {
            Fault::Line(fault) => {
                let until = match scripted.lasts {
                    Lasts::Packets(packets) => Until::Packets(packets),
                    Lasts::Seconds(seconds) => Until::Time(now_s + seconds),
                    Lasts::Ever => Until::Mended,
                };
                slot.line.fail(fault.clone(), until);
            }
            Fault::Gauge(panel) => {
                // A unit that the gauge does not have cannot be set at its panel: nothing happens.
                let _ = slot.line.press(panel, now_s);
                let undone = scripted.fault.undone();
                slot.ending.extend(until_s.zip(undone));
            }
            Fault::Unplug | Fault::Swap | Fault::Suspend => {
                slot.unplugged_until_s = Some(until_s.unwrap_or(f64::INFINITY));
                self.remove_link(slot.found_as);
            }
        }
    }

    /// Both adapters out, and back under each other's name.
    fn swap(&self, until_s: f64) {
        for slot in &self.slots {
            let mut slot = lock(slot);
            slot.unplugged_until_s = Some(until_s);
            self.remove_link(slot.found_as);
            slot.found_as = match slot.found_as {
                Channel::Force => Channel::Displacement,
                Channel::Displacement => Channel::Force,
            };
        }
    }

    fn remove_link(&self, channel: Channel) {
        if let Some(folder) = &self.links {
            // A link that is not there is what is wanted.
            let _ = std::fs::remove_file(link_of(folder, channel));
        }
    }

    /// Waits, but not for the end.
    fn wait(&self, real: Duration) {
        let (mutex, stopped) = &self.stopped;
        let _ =
            stopped.wait_timeout_while(lock(mutex), real, |()| !self.stop.load(Ordering::SeqCst));
    }
}

/// Points a link at a path in one step: at no time is there no link, or half of one.
fn point(link: &Path, at: &Path) -> std::io::Result<()> {
    let beside = link.with_extension("new");
    let _ = std::fs::remove_file(&beside);
    std::os::unix::fs::symlink(at, &beside)?;
    std::fs::rename(&beside, link)
}

fn link_of(folder: &Path, channel: Channel) -> PathBuf {
    folder.join(channel.to_string())
}

/// What a mutex guards; the state behind one of a thread that panicked is whole, as no step leaves it halfway.
fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
