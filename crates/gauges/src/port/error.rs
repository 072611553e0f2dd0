//! What can be in the way of a port, each with its own remedy.

use miette::Diagnostic;

use super::holder::Holder;

/// Why a port cannot be used. Absent, not allowed, busy and wrong device are four faults with four remedies.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum PortError {
    /// There is no such port.
    #[error("port {port} does not exist{}", .near.as_ref().map_or_else(String::new, |near| format!("; existing ports: {near}")))]
    #[diagnostic(
        code(stiffbench::port::absent),
        help(
            "plug the gauge in and switch it on; stiffbench gauge ports lists the ports of the system, stiffbench gauge bind waits for the one that is plugged in next"
        )
    )]
    Absent {
        /// Path or identity.
        port: String,
        /// What there is instead.
        near: Option<String>,
    },
    /// The port is there and this user may not open it.
    #[error("port {port} may not be opened by this user: it belongs to the group {group}")]
    #[diagnostic(code(stiffbench::port::not_allowed))]
    NotAllowed {
        /// Path.
        port: String,
        /// Group that it belongs to, usually dialout or uucp.
        group: String,
        /// What to do.
        #[help]
        help: String,
    },
    /// Another program has the port.
    #[error("port {port} is in use{}", Holder::sentence(.holders))]
    #[diagnostic(code(stiffbench::port::busy))]
    Busy {
        /// Path.
        port: String,
        /// Who has it open, where the system reports it.
        holders: Vec<Holder>,
        /// How long was waited for it, s.
        waited_s: f64,
        /// What to do.
        #[help]
        help: String,
    },
    /// On the port answers another instrument, or the adapter is another one.
    #[error("{port}: {problem}")]
    #[diagnostic(code(stiffbench::port::wrong_device))]
    WrongDevice {
        /// Path or identity.
        port: String,
        /// What was expected and what is there.
        problem: String,
        /// What to do.
        #[help]
        help: String,
    },
    /// The path leads to something that is no serial line.
    #[error("{port} is not a serial port: {problem}")]
    #[diagnostic(
        code(stiffbench::port::no_line),
        help("stiffbench gauge ports lists the serial ports of this machine")
    )]
    NoLine {
        /// Path.
        port: String,
        /// What it is.
        problem: String,
    },
    /// The system does not come back from opening.
    #[error("opening {port} has not returned for {waited_s:.0} s")]
    #[diagnostic(
        code(stiffbench::port::hangs),
        help("pull the adapter and plug it in again: its driver or the sleeping device is stuck")
    )]
    Hangs {
        /// Path.
        port: String,
        /// How long was waited, s.
        waited_s: f64,
    },
    /// The port cannot do what the line needs.
    #[error("port {port} does not take {settings}: {problem}")]
    #[diagnostic(
        code(stiffbench::port::settings),
        help(
            "not every adapter can do every speed and parity: use another adapter, or choose another speed at the gauge and in its description"
        )
    )]
    Settings {
        /// Path.
        port: String,
        /// The line settings.
        settings: String,
        /// The error of the operating system.
        problem: String,
    },
    /// The port was open and is gone.
    #[error("port {port} is lost: {problem}")]
    #[diagnostic(
        code(stiffbench::port::lost),
        help("check cable and adapter, plug it in again; what was recorded before is safe")
    )]
    Lost {
        /// Path.
        port: String,
        /// The error of the operating system.
        problem: String,
    },
    /// The gauge does not answer.
    #[error("nothing answers on {port} within {waited_s:.1} s")]
    #[diagnostic(
        code(stiffbench::port::silent),
        help(
            "switch the gauge on, choose its serial output in its menu, and compare speed and parity there with the instrument description; stiffbench gauge probe {port} also tries the other speeds that the description names"
        )
    )]
    Silent {
        /// Path.
        port: String,
        /// How long was waited, s.
        waited_s: f64,
    },
}

/// What the system's answer to opening distinguishes, before more is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    Absent,
    NotAllowed,
    Busy,
    NoLine,
    Settings,
}

/// What the system's answer means.
///
/// The library reports a lock that another program holds, and a port that another program opened exclusively, as "no device": here both are
/// busy. On Windows a port in use is answered by "access denied".
pub(super) fn refusal(error: &serialport::Error, exists: bool) -> Refusal {
    use serialport::ErrorKind as Kind;
    use std::io::ErrorKind as Io;
    let text = error.description.to_lowercase();
    match error.kind {
        Kind::NoDevice if exists || text.contains("lock") || text.contains("busy") => Refusal::Busy,
        Kind::NoDevice | Kind::Io(Io::NotFound) => Refusal::Absent,
        Kind::Io(Io::PermissionDenied) if cfg!(windows) => Refusal::Busy,
        Kind::Io(Io::PermissionDenied) => Refusal::NotAllowed,
        Kind::Io(Io::ResourceBusy | Io::WouldBlock) => Refusal::Busy,
        // ENXIO and ENODEV: the node is there and its device is not.
        _ if text.contains("no such device") => Refusal::Absent,
        // ENOTTY and, for ports without hardware, EIO.
        _ if text.contains("not a typewriter")
            || text.contains("inappropriate ioctl")
            || text.contains("i/o error")
            || text.contains("input/output error") =>
        {
            Refusal::NoLine
        }
        _ => Refusal::Settings,
    }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind as Io;

    use serialport::{Error, ErrorKind};

    use super::*;

    #[test]
    fn errors_of_the_serial_library_are_distinguished() {
        #[rustfmt::skip]
        let cases = [
            (ErrorKind::NoDevice, "Unable to acquire exclusive lock on serial port", true, Refusal::Busy),
            (ErrorKind::NoDevice, "Device or resource busy", true, Refusal::Busy),
            (ErrorKind::NoDevice, "No such file or directory", false, Refusal::Absent),
            (ErrorKind::Io(Io::NotFound), "No such file or directory", false, Refusal::Absent),
            (ErrorKind::Io(Io::PermissionDenied), "Permission denied", true, Refusal::NotAllowed),
            (ErrorKind::Unknown, "No such device or address", true, Refusal::Absent),
            (ErrorKind::Unknown, "Not a typewriter", true, Refusal::NoLine),
            (ErrorKind::Unknown, "I/O error", true, Refusal::NoLine),
            (ErrorKind::Unknown, "Settings did not apply correctly", true, Refusal::Settings),
        ];
        for (kind, text, exists, expected) in cases {
            assert_eq!(
                refusal(&Error::new(kind, text), exists),
                expected,
                "{kind:?} {text}"
            );
        }
    }
}
