//! A device behind a pseudo-terminal, under a name of its own.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

/// A device that answers each command with bytes, possibly in several pieces, until it is dropped: then its port is gone.
pub(crate) struct Device {
    name: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Device {
    /// A device under `name`; `answer` is given a command without its end and tells what is sent back, piece by piece.
    pub(crate) fn at(
        name: &Path,
        answer: impl FnMut(&str) -> Vec<Vec<u8>> + Send + 'static,
    ) -> Self {
        Self::set_to(None, name, answer)
    }

    /// The same, set to a speed: at another it understands nothing.
    pub(crate) fn set_to(
        baud: Option<u32>,
        name: &Path,
        mut answer: impl FnMut(&str) -> Vec<Vec<u8>> + Send + 'static,
    ) -> Self {
        let (mut master, slave) = TTYPort::pair().unwrap();
        symlink(slave.name().unwrap(), name).unwrap();
        master.set_timeout(Duration::from_millis(2)).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = thread::spawn(move || {
            // Held open so that the device does not notice who comes and goes.
            let _slave = slave;
            let mut command = Vec::new();
            let mut buffer = [0; 64];
            while !stopped.load(Ordering::Relaxed) {
                let count = match master.read(&mut buffer) {
                    Ok(count) => count,
                    Err(error) if error.kind() == ErrorKind::TimedOut => 0,
                    Err(error) => panic!("{error}"),
                };
                // A pseudo-terminal hands bytes on at any speed, and both of its ends know which one was set.
                let understood = baud.is_none_or(|baud| master.baud_rate().unwrap() == baud);
                for byte in buffer[..count].iter().filter(|_| understood) {
                    if *byte != b'\r' {
                        command.push(*byte);
                        continue;
                    }
                    let text = String::from_utf8_lossy(&command).into_owned();
                    command.clear();
                    for piece in answer(&text) {
                        master.write_all(&piece).unwrap();
                        master.flush().unwrap();
                    }
                }
            }
        });
        Self {
            name: name.to_owned(),
            stop,
            thread: Some(thread),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
            && !thread::panicking()
        {
            panic!("the device of the test failed");
        }
        std::fs::remove_file(&self.name).unwrap();
    }
}
