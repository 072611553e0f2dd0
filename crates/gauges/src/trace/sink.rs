//! Writing traces beside the lines, so that a slow disk never makes a byte late.

use std::io::{self, Write};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use stiffbench_units_and_text::clock::Clock;

use super::{TraceEntry, TraceWriter, What};

/// How often what was written is handed to the file, s.
const FLUSH_EVERY_S: f64 = 1.0;

/// Where the entries of one line go.
pub trait Sink: Send {
    /// Takes an entry.
    fn take(&mut self, entry: TraceEntry);
}

impl Sink for Vec<TraceEntry> {
    fn take(&mut self, entry: TraceEntry) {
        self.push(entry);
    }
}

/// A trace that is written by a thread of its own, flushed every second and ended by an end mark when this is dropped.
#[derive(Debug)]
pub struct TraceSink {
    entries: Option<Sender<TraceEntry>>,
    writer: Option<JoinHandle<()>>,
    last_s: f64,
}

impl TraceSink {
    /// Starts the writer. `failed` is called once if the file takes no more; the line goes on without its trace then.
    pub fn start<W>(writer: TraceWriter<W>, failed: impl FnOnce(io::Error) + Send + 'static) -> Self
    where
        W: Write + Send + 'static,
    {
        let (entries, incoming) = mpsc::channel();
        let writer = thread::spawn(move || {
            if let Err(error) = write_all(writer, &incoming) {
                failed(error);
            }
        });
        Self {
            entries: Some(entries),
            writer: Some(writer),
            last_s: 0.0,
        }
    }
}

fn write_all<W: Write>(
    mut writer: TraceWriter<W>,
    incoming: &mpsc::Receiver<TraceEntry>,
) -> io::Result<()> {
    let clock = Clock::default();
    let mut flush_at_s = FLUSH_EVERY_S;
    let mut pending = false;
    loop {
        match incoming.recv_timeout(Duration::from_secs_f64(FLUSH_EVERY_S)) {
            Ok(entry) => {
                writer.write(&entry)?;
                pending = true;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return writer.flush(),
        }
        if pending && clock.now_s() >= flush_at_s {
            writer.flush()?;
            pending = false;
            flush_at_s = clock.now_s() + FLUSH_EVERY_S;
        }
    }
}

impl Sink for TraceSink {
    fn take(&mut self, entry: TraceEntry) {
        self.last_s = entry.at_s;
        if let Some(entries) = &self.entries {
            // A writer that failed has reported it.
            let _ = entries.send(entry);
        }
    }
}

impl Drop for TraceSink {
    fn drop(&mut self) {
        self.take(TraceEntry {
            at_s: self.last_s,
            what: What::End,
        });
        self.entries = None;
        if let Some(writer) = self.writer.take() {
            // A writer that panicked has nothing left to write.
            let _ = writer.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use crate::trace::{GaugeTrace, TraceHeader};

    use super::*;

    /// A file that takes so many bytes.
    #[derive(Clone)]
    struct Disk {
        written: Arc<Mutex<Vec<u8>>>,
        room: usize,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut written = self.written.lock().unwrap();
            if written.len() + bytes.len() > self.room {
                return Err(io::ErrorKind::StorageFull.into());
            }
            written.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn record(room: usize) -> (Vec<u8>, bool) {
        let disk = Disk {
            written: Arc::default(),
            room,
        };
        let failed = Arc::new(Mutex::new(false));
        let told = Arc::clone(&failed);
        let writer = TraceWriter::begin(disk.clone(), &TraceHeader::default()).unwrap();
        let mut sink = TraceSink::start(writer, move |_| *told.lock().unwrap() = true);
        for i in 0..100 {
            sink.take(TraceEntry {
                at_s: f64::from(i),
                what: What::Received(b"+1.0\r".to_vec()),
            });
        }
        drop(sink);
        (
            disk.written.lock().unwrap().clone(),
            *failed.lock().unwrap(),
        )
    }

    #[test]
    fn all_is_written_when_the_sink_is_dropped() {
        let (written, failed) = record(usize::MAX);
        let trace = GaugeTrace::parse(&written, "t").unwrap();
        assert!(trace.complete && !failed);
        assert_eq!(trace.entries.len(), 101);
    }

    #[test]
    fn a_full_disk_is_reported_and_written_lines_stay() {
        let (written, failed) = record(300);
        let trace = GaugeTrace::parse(&written, "t").unwrap();
        assert!(failed && !trace.complete);
        assert!(trace.entries.len() > 5 && trace.damage.is_empty());
    }
}
