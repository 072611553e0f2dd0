//! The threads behind emulated lines: bytes both ways, cables in and out, faults begun and ended.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

use crate::Channel;
use stiffbench_units_and_text::clock::Clock;

use super::fault::Fault;
use super::fault_runner::FaultRunner;
use super::fault_script::{FaultDuration, ScriptedFault};
use super::gauge::PanelAction;
use super::host::HostError;
use super::line::{EmulatedLine, Until};

/// Longest wait for bytes before the host looks for faults and its own end again.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// How long a line that is not open is left alone.
const NOBODY_THERE: Duration = Duration::from_millis(10);

/// After how many such waits it is checked whether a lock was left behind; a program that closes a port and opens it again is faster.
const WAITS_BEFORE_LOOKING: u32 = 10;

/// Speed written into a pseudo-terminal; it has none.
const BAUD: u32 = 9600;

/// What all threads of a host share.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) slots: Vec<Mutex<ServedGauge>>,
    pub(super) runner: Mutex<FaultRunner>,
    pub(super) session: Clock,
    pub(super) line: Clock,
    pub(super) links: Option<PathBuf>,
    /// Nothing is served before this time of the lines, s.
    pub(super) suspended_until_s: Mutex<f64>,
    pub(super) stop: AtomicBool,
    pub(super) stopped: (Mutex<()>, Condvar),
}

/// A gauge, its line, and the name under which that is found.
#[derive(Debug)]
pub(super) struct ServedGauge {
    pub(super) line: EmulatedLine,
    /// The adapter is out until this time of the line, s.
    pub(super) unplugged_until_s: Option<f64>,
    /// Under whose name it is found when it is plugged in.
    pub(super) found_as: Channel,
    /// Path of the pseudo-terminal; empty while it is out.
    pub(super) terminal: String,
    /// Faults at the gauge that end, with their time, s.
    pub(super) ending: Vec<(f64, PanelAction)>,
}

impl Shared {
    /// Serves a gauge to the end.
    pub(super) fn serve(&self, place: usize, terminal: TTYPort) {
        let mut terminal = Some(terminal);
        let mut waits = 0_u32;
        while !self.stop.load(Ordering::SeqCst) {
            let due = lock(&self.runner).at_time(self.session.now_s());
            self.begin(&due);
            if self.is_suspended() {
                self.wait(NOBODY_THERE);
                continue;
            }
            let now_s = self.line.now_s();
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

    /// Whether the machine sleeps.
    fn is_suspended(&self) -> bool {
        self.line.now_s() < *lock(&self.suspended_until_s)
    }

    /// Waits for bytes, at most until something is due, and forwards both ways; returns whether a program has the line open.
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
        // It may have fallen asleep over them.
        while self.is_suspended() && !self.stop.load(Ordering::SeqCst) {
            self.wait(NOBODY_THERE);
        }
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

    /// Whether no program has the line open and yet none can open it: a program that was killed left its lock on the terminal. The adapter of a
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
    pub(super) fn plug_in(&self, place: usize) -> Result<TTYPort, HostError> {
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
        let ended: Vec<PanelAction> = ended.map(|(_, panel)| panel).collect();
        for panel in ended {
            // What ends a fault names no unit, and only a unit can be refused.
            let _ = slot.line.press(&panel, now_s);
        }
    }

    /// Begins faults.
    pub(super) fn begin(&self, faults: &[ScriptedFault]) {
        let now_s = self.line.now_s();
        for scripted in faults {
            let until_s = match scripted.lasts {
                FaultDuration::Seconds(seconds) => Some(now_s + seconds),
                FaultDuration::Packets(_) | FaultDuration::Ever => None,
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
        slot: &mut ServedGauge,
        scripted: &ScriptedFault,
        now_s: f64,
        until_s: Option<f64>,
    ) {
        match &scripted.fault {
            Fault::Line(fault) => {
                let until = match scripted.lasts {
                    FaultDuration::Packets(packets) => Until::Packets(packets),
                    FaultDuration::Seconds(seconds) => Until::Time(now_s + seconds),
                    FaultDuration::Ever => Until::Mended,
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

    /// The adapters out, and back under each other's name.
    fn swap(&self, until_s: f64) {
        let mut names: Vec<Channel> = self.slots.iter().map(|slot| lock(slot).found_as).collect();
        // Of three or more adapters each comes back under the name of the next.
        names.rotate_left(1);
        for (slot, found_as) in self.slots.iter().zip(names) {
            let mut slot = lock(slot);
            slot.unplugged_until_s = Some(until_s);
            self.remove_link(slot.found_as);
            slot.found_as = found_as;
        }
    }

    pub(super) fn remove_link(&self, channel: Channel) {
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

pub(super) fn link_of(folder: &Path, channel: Channel) -> PathBuf {
    folder.join(channel.to_string())
}

/// What a mutex guards; the state behind one of a thread that panicked is whole, as no step leaves it halfway.
pub(super) fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
