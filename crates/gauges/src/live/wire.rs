//! An open port in the event loop.

use std::io;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_serial::SerialStream;

use crate::port::{OpenPort, PortError};

/// Zero bytes from a line that reports some: the end of it, unless it is one of a few that adapters give while they wake up.
const ZERO_READS: u32 = 5;
/// Pause after such a read.
const ZERO_PAUSE: Duration = Duration::from_millis(10);
/// A write that takes longer does not get through: the other end holds the line.
const WRITE_DEADLINE: Duration = Duration::from_secs(2);

/// An open port in the event loop.
pub(super) struct Wire {
    stream: SerialStream,
    path: String,
    zero_reads: u32,
}

impl Wire {
    /// Takes a port that was opened and prepared.
    #[cfg(unix)]
    pub(super) fn of(open: OpenPort) -> Result<Self, PortError> {
        let stream = SerialStream::try_from(open.port).map_err(|error| PortError::Lost {
            port: open.path.clone(),
            problem: error.to_string(),
        })?;
        Ok(Self {
            stream,
            path: open.path,
            zero_reads: 0,
        })
    }

    /// Takes a port that was opened and prepared. The event loop of Windows needs a handle that was opened for it: the port is opened once more,
    /// with the same settings.
    #[cfg(windows)]
    pub(super) fn of(open: OpenPort) -> Result<Self, PortError> {
        use tokio_serial::SerialPort;
        let OpenPort {
            port,
            path,
            settings,
        } = open;
        drop(port);
        let again = || {
            let mut stream = SerialStream::open(&settings.builder(&path))?;
            if let Some(level) = settings.dtr {
                stream.write_data_terminal_ready(level)?;
            }
            if let Some(level) = settings.rts {
                stream.write_request_to_send(level)?;
            }
            Ok(stream)
        };
        let stream = again().map_err(|error: tokio_serial::Error| PortError::Lost {
            port: path.clone(),
            problem: error.to_string(),
        })?;
        Ok(Self {
            stream,
            path,
            zero_reads: 0,
        })
    }

    /// The path that was opened.
    pub(super) fn path(&self) -> &str {
        &self.path
    }

    /// Waits for bytes.
    ///
    /// Reading a tty that is gone gives zero bytes at once, for ever: a few are taken for a hiccup, more for the end.
    pub(super) async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, PortError> {
        loop {
            match self.stream.read(buffer).await {
                Ok(0) if self.zero_reads < ZERO_READS => {
                    self.zero_reads += 1;
                    tokio::time::sleep(ZERO_PAUSE).await;
                }
                Ok(0) => return Err(self.lost("the system delivers no more bytes")),
                Ok(count) => {
                    self.zero_reads = 0;
                    return Ok(count);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(self.lost(&error.to_string())),
            }
        }
    }

    /// Writes all bytes.
    pub(super) async fn write(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        match tokio::time::timeout(WRITE_DEADLINE, self.stream.write_all(bytes)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => Err(self.lost(&error.to_string())),
            Err(_) => Err(self.lost("it accepts no bytes")),
        }
    }

    fn lost(&self, problem: &str) -> PortError {
        PortError::Lost {
            port: self.path.clone(),
            problem: problem.to_owned(),
        }
    }
}
