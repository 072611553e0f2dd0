//! Opening a port: with a deadline, exclusively, every setting made, the input cleared.

use std::io;
use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use serialport::{ClearBuffer, SerialPort};

use stiffbench_units_and_text::clock::Clock;

use super::error::{PortError, Refusal, refusal};
use super::holder::holders;
use super::identity::names;
use super::list::list_ports;
use super::settings::PortSettings;

/// The port type of this system, from which both blocking and asynchronous reading start.
#[cfg(unix)]
pub type NativePort = serialport::TTYPort;
/// The port type of this system, from which both blocking and asynchronous reading start.
#[cfg(windows)]
pub type NativePort = serialport::COMPort;

/// An open port.
#[derive(Debug)]
pub struct OpenPort {
    /// The port.
    pub port: NativePort,
    /// The path that was opened.
    pub path: String,
    /// What was set.
    pub settings: PortSettings,
}

/// How long is waited for a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortTimeouts {
    /// For the system to come back from opening; a sleeping device or a stuck driver can block it for ever.
    pub opening: Duration,
    /// For a port that another program has: a service that tries modem commands on new ports lets go of them after some ten seconds.
    pub busy: Duration,
    /// Between two tries at a busy port.
    pub pause: Duration,
}

impl Default for PortTimeouts {
    fn default() -> Self {
        Self {
            opening: Duration::from_secs(10),
            busy: Duration::from_secs(15),
            pause: Duration::from_millis(250),
        }
    }
}

impl PortTimeouts {
    /// Not to wait for a busy port, as when many ports are checked.
    #[must_use]
    pub fn without_waiting() -> Self {
        Self {
            busy: Duration::ZERO,
            ..Self::default()
        }
    }
}

/// Opens the port at `path`, makes all settings, waits for it to settle and clears what came before.
///
/// `note` receives what the operator should know while it goes on: that a busy port is waited for, that a setting was not taken. Blocks as long as
/// `timeouts` and the settle time allow.
///
/// # Errors
/// [`PortError`]: absent, not allowed, busy, no serial line, settings that the port does not take, a system that does not come back.
pub fn open(
    path: &str,
    settings: &PortSettings,
    timeouts: &PortTimeouts,
    note: &mut dyn FnMut(String),
) -> Result<OpenPort, PortError> {
    inspect(path)?;
    let clock = Clock::default();
    let mut told = false;
    loop {
        let error = match open_by_deadline(path, settings, timeouts.opening)? {
            Ok(port) => return prepare(port, path, settings, note),
            Err(error) => error,
        };
        let refused = refusal(&error, Path::new(path).exists());
        if refused != Refusal::Busy || clock.now_s() >= timeouts.busy.as_secs_f64() {
            return Err(explain(path, settings, refused, &error, clock.now_s()));
        }
        if !told {
            told = true;
            note(format!(
                "port {path} is in use; waiting up to {} s for it",
                timeouts.busy.as_secs()
            ));
        }
        thread::sleep(timeouts.pause);
    }
}

/// What is known of a path without opening it.
fn inspect(path: &str) -> Result<(), PortError> {
    // Names like COM3 are no files.
    if cfg!(windows) {
        return Ok(());
    }
    match std::fs::metadata(path) {
        Ok(found) if is_device(&found) => Ok(()),
        Ok(found) => Err(PortError::NoLine {
            port: path.to_owned(),
            problem: if found.is_dir() {
                "it is a folder"
            } else {
                "it is a file"
            }
            .to_owned(),
        }),
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {
            Err(not_allowed(path, COMMON_GROUP.to_owned(), None))
        }
        Err(_) => Err(absent(path)),
    }
}

#[cfg(unix)]
fn is_device(found: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_device(_: &std::fs::Metadata) -> bool {
    true
}

fn absent(path: &str) -> PortError {
    PortError::Absent {
        port: path.to_owned(),
        near: list_ports().ok().as_deref().and_then(names),
    }
}

/// Opens on a worker, so that a system that does not come back costs only the deadline; a port that comes later is closed by the worker.
fn open_by_deadline(
    path: &str,
    settings: &PortSettings,
    deadline: Duration,
) -> Result<serialport::Result<NativePort>, PortError> {
    let (report, reported) = mpsc::channel();
    let builder = settings.builder(path);
    thread::spawn(move || {
        // If no receiver waits, the port goes out of scope here and is closed.
        let _ = report.send(builder.open_native());
    });
    reported
        .recv_timeout(deadline)
        .map_err(|_| PortError::Hangs {
            port: path.to_owned(),
            waited_s: deadline.as_secs_f64(),
        })
}

/// Modem lines, settle time, clearing.
fn prepare(
    mut port: NativePort,
    path: &str,
    settings: &PortSettings,
    note: &mut dyn FnMut(String),
) -> Result<OpenPort, PortError> {
    let faults = set_modem_lines(&mut port, settings);
    // A pseudo-terminal has no modem lines and keeps no parity: neither is a fault there.
    if !is_pseudo_terminal(path) {
        for fault in faults {
            note(format!("port {path}: {fault}"));
        }
        if let Some(difference) = not_taken(&port, settings) {
            note(format!(
                "port {path} was set to {settings} and has {difference}: bytes may come garbled"
            ));
        }
    }
    thread::sleep(settings.settle);
    port.clear(ClearBuffer::Input)
        .map_err(|error| PortError::Lost {
            port: path.to_owned(),
            problem: error.to_string(),
        })?;
    Ok(OpenPort {
        port,
        path: path.to_owned(),
        settings: settings.clone(),
    })
}

/// Sets the modem lines that the settings name; what could not be set.
fn set_modem_lines(port: &mut NativePort, settings: &PortSettings) -> Vec<String> {
    let dtr = settings
        .dtr
        .map(|level| port.write_data_terminal_ready(level));
    let rts = settings.rts.map(|level| port.write_request_to_send(level));
    let fault = |(name, set): (&str, Option<serialport::Result<()>>)| {
        let error = set?.err()?;
        Some(format!(
            "{name} cannot be set ({error}); a cable that is powered by it stays dead"
        ))
    };
    [("DTR", dtr), ("RTS", rts)]
        .into_iter()
        .filter_map(fault)
        .collect()
}

/// Settings that read back differently: adapters that cannot do a speed or seven bits do not always report it.
fn not_taken(port: &NativePort, settings: &PortSettings) -> Option<String> {
    let mut differences = Vec::new();
    if let Ok(baud) = port.baud_rate()
        // Real clocks divide to within two percent of a standard speed, which a line tolerates.
        && baud.abs_diff(settings.baud) > settings.baud / 50
    {
        differences.push(format!("{baud} bit/s"));
    }
    if let Ok(bits) = port.data_bits()
        && bits != settings.data_bits
    {
        differences.push(format!("{} data bits", u8::from(bits)));
    }
    if let Ok(parity) = port.parity()
        && parity != settings.parity
    {
        differences.push(format!("parity {parity}"));
    }
    (!differences.is_empty()).then(|| differences.join(", "))
}

fn is_pseudo_terminal(path: &str) -> bool {
    Path::new(path)
        .canonicalize()
        .is_ok_and(|real| real.starts_with("/dev/pts"))
}

fn explain(
    path: &str,
    settings: &PortSettings,
    refused: Refusal,
    error: &serialport::Error,
    waited_s: f64,
) -> PortError {
    let port = path.to_owned();
    match refused {
        Refusal::Absent => absent(path),
        Refusal::NotAllowed => {
            let group = group_of(Path::new(path), Path::new("/etc/group"));
            not_allowed(path, group, mode(Path::new(path)))
        }
        Refusal::Busy => busy(path, waited_s),
        Refusal::NoLine => PortError::NoLine {
            port,
            problem: error.to_string(),
        },
        Refusal::Settings => PortError::Settings {
            port,
            settings: settings.to_string(),
            problem: error.to_string(),
        },
    }
}

fn busy(path: &str, waited_s: f64) -> PortError {
    let holders = holders(Path::new("/proc"), Path::new(path));
    let help = match holders.as_slice() {
        [] => "close the other program that uses it (a terminal program, another session)",
        programs
            if programs
                .iter()
                .all(|holder| holder.pid == std::process::id()) =>
        {
            "both gauges have the same port: name another port for one of them"
        }
        programs
            if programs
                .iter()
                .any(|holder| holder.name.starts_with("ModemManager")) =>
        {
            "ModemManager tries modem commands on new ports: wait, or keep it away with the udev property ID_MM_DEVICE_IGNORE=1"
        }
        _ => "close that program",
    };
    PortError::Busy {
        port: path.to_owned(),
        holders,
        waited_s,
        help: help.to_owned(),
    }
}

/// What lets this user open a port that is there, without opening it.
#[must_use]
pub fn permission_remedy(port: &Path) -> String {
    remedy(&group_of(port, Path::new("/etc/group")), mode(port))
}

/// A group helps only where the port lets its group read and write.
fn remedy(group: &str, mode: Option<u32>) -> String {
    match mode.filter(|mode| mode & 0o060 != 0o060) {
        None => format!(
            "put the user into that group (sudo usermod -aG {group} $USER) and log in again: the group applies from the next login on"
        ),
        Some(mode) => format!(
            "the port does not let its group in (mode {:03o}): a udev rule with GROUP=\"{group}\", MODE=\"0660\" does; then the user needs to be in that group",
            mode & 0o777
        ),
    }
}

fn not_allowed(port: &str, group: String, mode: Option<u32>) -> PortError {
    PortError::NotAllowed {
        port: port.to_owned(),
        help: remedy(&group, mode),
        group,
    }
}

#[cfg(unix)]
fn mode(port: &Path) -> Option<u32> {
    use std::os::unix::fs::MetadataExt;
    Some(std::fs::metadata(port).ok()?.mode())
}

#[cfg(not(unix))]
fn mode(_: &Path) -> Option<u32> {
    None
}

/// Group that most Linux systems give their serial ports.
const COMMON_GROUP: &str = "dialout";

/// The group that a port belongs to, by name from the list of groups (`/etc/group`).
#[cfg(unix)]
fn group_of(port: &Path, groups: &Path) -> String {
    use std::os::unix::fs::MetadataExt;
    let named = || {
        let gid = std::fs::metadata(port).ok()?.gid();
        let text = std::fs::read_to_string(groups).ok()?;
        group_name(&text, gid)
    };
    named().unwrap_or_else(|| COMMON_GROUP.to_owned())
}

#[cfg(not(unix))]
fn group_of(_: &Path, _: &Path) -> String {
    COMMON_GROUP.to_owned()
}

/// Name of a group in the text of a list of groups; `None` for root, which no user should join, and where it is not listed.
#[cfg_attr(not(unix), expect(dead_code, reason = "groups are of Unix"))]
fn group_name(text: &str, gid: u32) -> Option<String> {
    let of_line = |line: &str| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        let number: u32 = fields.nth(1)?.parse().ok()?;
        (number == gid && number != 0).then(|| name.to_owned())
    };
    text.lines().find_map(of_line)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::io::Write;

    use serialport::{DataBits, FlowControl, Parity, StopBits, TTYPort};

    use miette::Diagnostic as _;

    use super::*;

    fn settings() -> PortSettings {
        PortSettings {
            baud: 9600,
            data_bits: DataBits::Eight,
            parity: Parity::None,
            stop_bits: StopBits::One,
            flow: FlowControl::None,
            dtr: Some(true),
            rts: Some(false),
            settle: Duration::ZERO,
        }
    }

    fn open_quietly(path: &str) -> Result<OpenPort, PortError> {
        let mut notes = Vec::new();
        let opened = open(
            path,
            &settings(),
            &PortTimeouts::without_waiting(),
            &mut |note| {
                notes.push(note);
            },
        );
        assert_eq!(notes, [""; 0]);
        opened
    }

    #[test]
    fn a_pseudo_terminal_is_opened_by_name_and_cleared() {
        let (mut master, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        master.write_all(b"left over").unwrap();
        let opened = open_quietly(&path).unwrap();
        assert_eq!(opened.path, path);
        assert_eq!(opened.port.bytes_to_read().unwrap(), 0);
    }

    #[test]
    fn a_port_that_is_open_is_busy_and_its_holder_named() {
        let (_master, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        let _first = open_quietly(&path).unwrap();
        let error = open_quietly(&path).unwrap_err();
        let PortError::Busy { holders, help, .. } = &error else {
            panic!("{error}")
        };
        if cfg!(target_os = "linux") {
            assert!(
                holders
                    .iter()
                    .any(|holder| holder.pid == std::process::id())
            );
            assert!(help.contains("both gauges"), "{help}");
        }
    }

    #[test]
    fn a_busy_port_is_waited_for_and_that_is_said_once() {
        let (_master, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        let first = open_quietly(&path).unwrap();
        let timeouts = PortTimeouts {
            busy: Duration::from_secs(20),
            pause: Duration::from_millis(5),
            ..PortTimeouts::default()
        };
        let mut first = Some(first);
        let mut notes = Vec::new();
        let opened = open(&path, &settings(), &timeouts, &mut |note| {
            notes.push(note);
            // The other program lets go.
            first = None;
        });
        assert!(opened.is_ok());
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(notes[0].contains("waiting up to 20 s"));
    }

    #[test]
    fn absent_ports_and_other_files_are_distinguished() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("ttyUSB9");
        let error = open_quietly(missing.to_str().unwrap()).unwrap_err();
        assert!(matches!(error, PortError::Absent { .. }), "{error}");
        let error = open_quietly(folder.path().to_str().unwrap()).unwrap_err();
        assert!(error.to_string().contains("it is a folder"), "{error}");
        let error = open_quietly("/dev/null").unwrap_err();
        assert!(matches!(error, PortError::NoLine { .. }), "{error}");
    }

    #[test]
    fn the_group_of_a_port_is_named_but_never_root() {
        let groups = "root:x:0:\nuucp:x:14:\ndialout:x:20:ann,bob\n";
        assert_eq!(group_name(groups, 20).as_deref(), Some("dialout"));
        assert_eq!(group_name(groups, 14).as_deref(), Some("uucp"));
        assert_eq!(group_name(groups, 0), None);
        assert_eq!(group_name(groups, 99), None);
        assert_eq!(
            explain(
                "/dev/ttyUSB0",
                &settings(),
                Refusal::NotAllowed,
                &serialport::Error::new(serialport::ErrorKind::Unknown, ""),
                0.0
            )
            .to_string(),
            "port /dev/ttyUSB0 may not be opened by this user: it belongs to the group dialout"
        );
        for (mode, remedy) in [
            (0o020_660, "usermod -aG uucp"),
            (0o020_600, "(mode 600): a udev rule with GROUP=\"uucp\""),
        ] {
            let error = not_allowed("/dev/ttyUSB0", "uucp".to_owned(), Some(mode));
            let help = error.help().unwrap().to_string();
            assert!(help.contains(remedy), "{help}");
        }
    }
}
