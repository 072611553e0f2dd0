//! Which port is meant, by what stays when cables are pulled and machines are restarted.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::error::PortError;
use super::list::PortInfo;

/// The USB descriptors of an adapter, and where it is plugged in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct UsbIdentity {
    /// Vendor, four hexadecimal digits.
    pub vendor: String,
    /// Product, four hexadecimal digits.
    pub product: String,
    /// Serial number; many adapters have none, some share one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Physical location: bus, the sockets on the way, and the interface of the adapter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub location: Option<String>,
}

impl UsbIdentity {
    fn same_kind(&self, other: &Self) -> bool {
        self.vendor.eq_ignore_ascii_case(&other.vendor)
            && self.product.eq_ignore_ascii_case(&other.product)
    }
}

impl fmt::Display for UsbIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "USB {}:{}", self.vendor, self.product)?;
        if let Some(serial) = &self.serial {
            write!(f, " serial {serial}")?;
        }
        if let Some(location) = &self.location {
            write!(f, " at {location}")?;
        }
        Ok(())
    }
}

/// Which port is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PortIdentity {
    /// A USB adapter, wherever the system puts it.
    Usb(UsbIdentity),
    /// A path as the user named it: built-in ports, pseudo-terminals, links.
    Path(String),
}

impl fmt::Display for PortIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usb(usb) => usb.fmt(f),
            Self::Path(path) => f.write_str(path),
        }
    }
}

/// The port that an identity stands for now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Resolved {
    /// Path to open.
    pub path: String,
    /// What the operator should know, for example that the adapter is in another socket.
    pub note: Option<String>,
}

impl PortIdentity {
    /// The identity of the port that a user named by its path: that of its adapter where the listing knows it, else the path.
    #[must_use]
    pub fn of_path(path: &str, ports: &[PortInfo]) -> Self {
        let named = |port: &&PortInfo| port.answers_to(path);
        match ports.iter().find(named).and_then(|port| port.usb.clone()) {
            Some(usb) => Self::Usb(usb),
            None => Self::Path(path.to_owned()),
        }
    }

    /// The port that is meant among those there are.
    ///
    /// The serial number decides where it is unique. Without one, or where two adapters share one, only the socket can distinguish them: another
    /// adapter of the same kind in another socket is never taken.
    ///
    /// # Errors
    /// [`PortError::Absent`], or [`PortError::WrongDevice`] where an adapter is there that could be mistaken for it.
    pub fn resolve(&self, ports: &[PortInfo]) -> Result<Resolved, PortError> {
        let usb = match self {
            Self::Path(path) => {
                return Ok(Resolved {
                    path: path.clone(),
                    note: None,
                });
            }
            Self::Usb(usb) => usb,
        };
        let alike: Vec<(&PortInfo, &UsbIdentity)> = ports
            .iter()
            .filter_map(|port| Some((port, port.usb.as_ref()?)))
            .filter(|(_, other)| other.same_kind(usb))
            .collect();
        let same_serial: Vec<_> = alike
            .iter()
            .filter(|(_, other)| other.serial == usb.serial)
            .collect();
        let in_place = same_serial
            .iter()
            .find(|(_, other)| usb.location.is_some() && other.location == usb.location);
        if let Some((port, _)) = in_place {
            return Ok(found(port, None));
        }
        match same_serial.as_slice() {
            [(port, other)] if usb.serial.is_some() => Ok(found(port, moved(usb, other))),
            // No means to identify a second adapter: only where the listing knows no sockets at all.
            [(port, other)] if usb.location.is_none() && other.location.is_none() => {
                Ok(found(port, None))
            }
            _ if alike.is_empty() => Err(PortError::Absent {
                port: self.to_string(),
                near: names(ports),
            }),
            _ => Err(PortError::WrongDevice {
                port: self.to_string(),
                problem: mistaken(&alike),
                help: "plug the gauge into its former socket, or bind it again with stiffbench gauge bind".to_owned(),
            }),
        }
    }
}

fn found(port: &PortInfo, note: Option<String>) -> Resolved {
    Resolved {
        path: port.stable_path().to_owned(),
        note,
    }
}

fn moved(usb: &UsbIdentity, other: &UsbIdentity) -> Option<String> {
    let (from, to) = (usb.location.as_ref()?, other.location.as_ref()?);
    (from != to).then(|| {
        format!("the adapter was at {from} and is now at {to}; its serial number is the same")
    })
}

fn mistaken(alike: &[(&PortInfo, &UsbIdentity)]) -> String {
    let there: Vec<String> = alike
        .iter()
        .map(|(port, other)| format!("{other} ({})", port.path))
        .collect();
    format!(
        "this adapter is absent; others of its kind are present and not used in its place: {}",
        there.join(", ")
    )
}

/// The ports there are, in one line.
pub(super) fn names(ports: &[PortInfo]) -> Option<String> {
    let names: Vec<&str> = ports.iter().map(|port| port.path.as_str()).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usb(serial: Option<&str>, location: &str) -> UsbIdentity {
        UsbIdentity {
            vendor: "0403".to_owned(),
            product: "6001".to_owned(),
            serial: serial.map(str::to_owned),
            location: Some(location.to_owned()),
        }
    }

    fn port(path: &str, usb: UsbIdentity) -> PortInfo {
        PortInfo {
            usb: Some(usb),
            ..PortInfo::of_path(path)
        }
    }

    fn resolve(wanted: UsbIdentity, ports: &[PortInfo]) -> Result<Resolved, PortError> {
        PortIdentity::Usb(wanted).resolve(ports)
    }

    #[test]
    fn a_serial_number_is_followed_to_another_name_and_socket() {
        let ports = [
            port("/dev/ttyUSB4", usb(Some("A"), "1-2:1.0")),
            port("/dev/ttyUSB0", usb(Some("B"), "1-1:1.0")),
        ];
        let resolved = resolve(usb(Some("A"), "1-1:1.0"), &ports).unwrap();
        assert_eq!(resolved.path, "/dev/ttyUSB4");
        assert!(resolved.note.unwrap().contains("1-1:1.0"));
        let resolved = resolve(usb(Some("B"), "1-1:1.0"), &ports).unwrap();
        assert_eq!(
            (resolved.path.as_str(), resolved.note),
            ("/dev/ttyUSB0", None)
        );
    }

    #[test]
    fn adapters_without_serial_number_are_identified_by_socket() {
        // The names are the other way round than when they were bound.
        let ports = [
            port("/dev/ttyUSB0", usb(None, "1-2:1.0")),
            port("/dev/ttyUSB1", usb(None, "1-1:1.0")),
        ];
        assert_eq!(
            resolve(usb(None, "1-1:1.0"), &ports).unwrap().path,
            "/dev/ttyUSB1"
        );
        // One alone in the other socket is not taken for the missing one.
        let error = resolve(usb(None, "1-1:1.0"), &ports[..1]).unwrap_err();
        assert!(matches!(error, PortError::WrongDevice { .. }), "{error}");
        assert!(error.to_string().contains("1-2:1.0"), "{error}");
    }

    #[test]
    fn a_serial_number_that_two_adapters_share_does_not_decide() {
        let ports = [
            port("/dev/ttyUSB0", usb(Some("0001"), "1-2:1.0")),
            port("/dev/ttyUSB1", usb(Some("0001"), "1-3:1.0")),
        ];
        assert_eq!(
            resolve(usb(Some("0001"), "1-3:1.0"), &ports).unwrap().path,
            "/dev/ttyUSB1"
        );
        let error = resolve(usb(Some("0001"), "1-1:1.0"), &ports).unwrap_err();
        assert!(matches!(error, PortError::WrongDevice { .. }), "{error}");
    }

    #[test]
    fn what_is_not_there_is_absent() {
        let ports = [PortInfo::of_path("/dev/ttyS0")];
        let error = resolve(usb(Some("A"), "1-1:1.0"), &ports).unwrap_err();
        assert!(matches!(error, PortError::Absent { .. }), "{error}");
        assert!(error.to_string().contains("/dev/ttyS0"), "{error}");
    }

    #[test]
    fn a_path_is_taken_as_it_is_and_known_adapters_are_recognised() {
        let ports = [port("/dev/ttyUSB0", usb(None, "1-1:1.0"))];
        let named = PortIdentity::of_path("/dev/pts/7", &ports);
        assert_eq!(named, PortIdentity::Path("/dev/pts/7".to_owned()));
        assert_eq!(named.resolve(&ports).unwrap().path, "/dev/pts/7");
        assert_eq!(
            PortIdentity::of_path("/dev/ttyUSB0", &ports),
            PortIdentity::Usb(usb(None, "1-1:1.0"))
        );
    }
}
