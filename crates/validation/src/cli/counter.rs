//! An emulated gauge behind a pseudo-terminal that sends its count at a steady rate.

use stiffbench::analysis::ArgumentError;

#[cfg(unix)]
pub(crate) use on_unix::Counter;

fn no_pseudo_terminal(problem: &str) -> ArgumentError {
    ArgumentError::new(
        "sustain",
        format!("no pseudo-terminal is available: {problem}"),
        "run it on Linux or macOS",
    )
}

#[cfg(unix)]
mod on_unix {
    use std::io::{ErrorKind, Read, Write};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
    use std::thread::{self, JoinHandle};
    use std::time::Duration;

    use serialport::{SerialPort, TTYPort};

    use stiffbench::clock::Clock;

    use super::{ArgumentError, no_pseudo_terminal};

    /// The gauge; dropped, it stops.
    pub(crate) struct Counter {
        /// Path of its port.
        pub(crate) path: String,
        sent: Arc<AtomicU64>,
        stop: Arc<AtomicBool>,
        thread: Option<JoinHandle<()>>,
    }

    /// What the gauge does.
    struct Work {
        master: TTYPort,
        unit: &'static str,
        per_s: u32,
        total: u64,
        sent: Arc<AtomicU64>,
        stop: Arc<AtomicBool>,
    }

    impl Counter {
        /// A gauge that sends `total` values in `unit` once it is told to, `per_s` a second.
        pub(crate) fn start(
            unit: &'static str,
            per_s: u32,
            total: u64,
        ) -> Result<Self, ArgumentError> {
            let refused = |error: serialport::Error| no_pseudo_terminal(&error.to_string());
            let (mut master, slave) = TTYPort::pair().map_err(refused)?;
            master
                .set_timeout(Duration::from_millis(50))
                .map_err(refused)?;
            let path = slave.name().unwrap_or_default();
            let (sent, stop) = (Arc::<AtomicU64>::default(), Arc::<AtomicBool>::default());
            let mut work = Work {
                master,
                unit,
                per_s,
                total,
                sent: Arc::clone(&sent),
                stop: Arc::clone(&stop),
            };
            let thread = thread::spawn(move || {
                // The other side stays open, whoever comes and goes.
                let _slave = slave;
                if work.starts_on_command() {
                    work.send();
                }
            });
            Ok(Self {
                path,
                sent,
                stop,
                thread: Some(thread),
            })
        }

        /// Values sent so far.
        pub(crate) fn sent(&self) -> u64 {
            self.sent.load(Ordering::Relaxed)
        }
    }

    impl Drop for Counter {
        fn drop(&mut self) {
            self.stop.store(true, Ordering::Relaxed);
            if let Some(thread) = self.thread.take() {
                // One that panicked has stopped.
                let _ = thread.join();
            }
        }
    }

    impl Work {
        fn is_stopped(&self) -> bool {
            self.stop.load(Ordering::Relaxed)
        }

        fn starts_on_command(&mut self) -> bool {
            let mut heard = Vec::new();
            let mut buffer = [0; 64];
            while !self.is_stopped() {
                match self.master.read(&mut buffer) {
                    Ok(count) => heard.extend_from_slice(&buffer[..count]),
                    Err(error) if error.kind() == ErrorKind::TimedOut => {}
                    Err(_) => return false,
                }
                if heard.windows(3).any(|command| command == b"ON\r") {
                    return true;
                }
            }
            false
        }

        fn send(&mut self) {
            let clock = Clock::default();
            for count in 1..=self.total {
                let ahead_s = count as f64 / f64::from(self.per_s) - clock.now_s();
                thread::sleep(Duration::try_from_secs_f64(ahead_s).unwrap_or_default());
                let packet = format!("+{count} {}\r", self.unit);
                if self.is_stopped() {
                    return;
                }
                // Counted first: the other end may have it, and have done, before this thread goes on.
                self.sent.store(count, Ordering::Relaxed);
                if self.master.write_all(packet.as_bytes()).is_err() {
                    return;
                }
            }
            // The port stays until everything was taken.
            while !self.is_stopped() {
                thread::sleep(Duration::from_millis(20));
            }
        }
    }
}

/// Without pseudo-terminals there is no such gauge.
#[cfg(not(unix))]
pub(crate) struct Counter {
    pub(crate) path: String,
}

#[cfg(not(unix))]
impl Counter {
    pub(crate) fn start(_: &'static str, _: u32, _: u64) -> Result<Self, ArgumentError> {
        Err(no_pseudo_terminal("it has none"))
    }

    pub(crate) fn sent(&self) -> u64 {
        0
    }
}
