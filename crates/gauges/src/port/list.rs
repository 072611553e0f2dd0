//! The serial ports of this machine.

use serde::Serialize;
use serialport::{SerialPortInfo, SerialPortType};

use super::error::PortError;
use super::identity::UsbIdentity;

/// One serial port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PortInfo {
    /// Path by which the system names it now.
    pub path: String,
    /// Name that stays with the adapter, where the system gives one (`/dev/serial/by-id/…`) and no other port has the same.
    pub by_id: Option<String>,
    /// Name that stays with the socket (`/dev/serial/by-path/…`).
    pub by_path: Option<String>,
    /// The adapter, if it is one.
    pub usb: Option<UsbIdentity>,
    /// What the adapter calls itself.
    pub label: Option<String>,
    /// How long the adapter holds short packets, ms, where its driver reports it.
    pub latency_ms: Option<u32>,
}

impl PortInfo {
    /// A port of which nothing is known but its path.
    #[must_use]
    pub fn of_path(path: &str) -> Self {
        Self {
            path: path.to_owned(),
            by_id: None,
            by_path: None,
            usb: None,
            label: None,
            latency_ms: None,
        }
    }

    /// The name that is least likely to mean another port tomorrow.
    #[must_use]
    pub fn stable_path(&self) -> &str {
        self.by_id.as_deref().unwrap_or(&self.path)
    }

    /// Whether `path` is one of its names, links followed.
    #[must_use]
    pub fn answers_to(&self, path: &str) -> bool {
        let names = [Some(&self.path), self.by_id.as_ref(), self.by_path.as_ref()];
        if names.into_iter().flatten().any(|name| name == path) {
            return true;
        }
        let real = |path: &str| std::path::Path::new(path).canonicalize().ok();
        real(path).is_some_and(|file| real(&self.path) == Some(file))
    }
}

/// The serial ports of this machine, ordered by path. None is opened.
///
/// # Errors
/// [`PortError::NoLine`] if the system does not report it.
pub fn list_ports() -> Result<Vec<PortInfo>, PortError> {
    #[cfg(target_os = "linux")]
    let mut ports = super::sysfs::list(
        std::path::Path::new("/sys/class/tty"),
        std::path::Path::new("/dev"),
    );
    #[cfg(not(target_os = "linux"))]
    let mut ports =
        of_library(
            serialport::available_ports().map_err(|error| PortError::NoLine {
                port: "the list of ports".to_owned(),
                problem: error.to_string(),
            })?,
        );
    ports.sort_by_key(|port| natural(&port.path));
    Ok(ports)
}

/// What the serial library lists, on systems where it asks the system itself.
///
/// On macOS each port has two names: `tty.…` waits for a carrier that gauges do not give, so only `cu.…` is listed.
#[cfg_attr(
    target_os = "linux",
    allow(
        dead_code,
        reason = "Linux tells more in its own listing; the tests run everywhere"
    )
)]
fn of_library(ports: Vec<SerialPortInfo>) -> Vec<PortInfo> {
    ports
        .into_iter()
        .filter(|port| !port.port_name.starts_with("/dev/tty."))
        .map(|port| match port.port_type {
            SerialPortType::UsbPort(usb) => PortInfo {
                label: usb.product.clone(),
                usb: Some(UsbIdentity {
                    vendor: format!("{:04x}", usb.vid),
                    product: format!("{:04x}", usb.pid),
                    serial: usb
                        .serial_number
                        .clone()
                        .filter(|serial| !serial.is_empty()),
                    location: usb.location.as_ref().map(|location| {
                        let sockets: Vec<String> = location
                            .port_chain()
                            .iter()
                            .map(ToString::to_string)
                            .collect();
                        format!("{}-{}", location.bus_id(), sockets.join("."))
                    }),
                }),
                ..PortInfo::of_path(&port.port_name)
            },
            _ => PortInfo::of_path(&port.port_name),
        })
        .collect()
}

/// The ports of `after` that were not there `before`: what was plugged in between.
#[must_use]
pub fn newly_plugged(before: &[PortInfo], after: &[PortInfo]) -> Vec<PortInfo> {
    let was_there = |port: &PortInfo| {
        before
            .iter()
            .any(|old| old.path == port.path && old.usb == port.usb)
    };
    after
        .iter()
        .filter(|port| !was_there(port))
        .cloned()
        .collect()
}

/// Order of names with numbers: ttyUSB2 before ttyUSB10.
fn natural(path: &str) -> (String, u64) {
    let name = path.trim_end_matches(|c: char| c.is_ascii_digit());
    (name.to_owned(), path[name.len()..].parse().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use serialport::UsbPortInfo;

    use super::*;

    #[test]
    fn call_out_names_are_listed_with_their_usb_identity() {
        let usb = || {
            SerialPortType::UsbPort(UsbPortInfo {
                vid: 0x10c4,
                pid: 0xea60,
                serial_number: Some("0001".to_owned()),
                manufacturer: None,
                product: Some("bridge".to_owned()),
                location: Some(serialport::Location::new("20".to_owned(), vec![1, 4])),
            })
        };
        let port = |name: &str, port_type| SerialPortInfo {
            port_name: name.to_owned(),
            port_type,
        };
        let ports = of_library(vec![
            port("/dev/tty.usbserial-1", usb()),
            port("/dev/cu.usbserial-1", usb()),
            port("COM11", SerialPortType::Unknown),
        ]);
        assert_eq!(
            ports
                .iter()
                .map(|port| port.path.as_str())
                .collect::<Vec<_>>(),
            ["/dev/cu.usbserial-1", "COM11"]
        );
        let usb = ports[0].usb.as_ref().unwrap();
        assert_eq!(usb.to_string(), "USB 10c4:ea60 serial 0001 at 20-1.4");
        assert_eq!(ports[1].usb, None);
    }

    #[test]
    fn a_newly_plugged_port_is_one_that_was_absent() {
        let [a, b] = ["/dev/ttyUSB0", "/dev/ttyUSB1"].map(PortInfo::of_path);
        let both = [a.clone(), b.clone()];
        assert_eq!(newly_plugged(&both[..1], &both), both[1..]);
        assert!(newly_plugged(&[a, b.clone()], &[b]).is_empty());
    }

    #[test]
    fn names_are_ordered_by_their_number() {
        assert!(natural("/dev/ttyUSB2") < natural("/dev/ttyUSB10"));
        assert!(natural("/dev/ttyACM10") < natural("/dev/ttyUSB0"));
    }
}
