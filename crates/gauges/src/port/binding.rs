//! Which gauge is on which adapter: the file of a bench, schema `stiffbench/bindings/1` (docs/bindings-file.md).

use std::fmt::Write;

use miette::Diagnostic;
use serde::{Deserialize, Serialize};

use crate::Channel;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlError, quoted, read};

use super::identity::{PortIdentity, UsbIdentity};

/// Schema of the file.
pub const BINDINGS_SCHEMA: &str = "stiffbench/bindings/1";

/// The gauges of a bench.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Bindings {
    /// `stiffbench/bindings/1`.
    pub schema: String,
    /// The force gauge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Binding>,
    /// The dial or length gauge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Binding>,
    /// The displacement gauge along the base axis x, of a bench with several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_x: Option<Binding>,
    /// The displacement gauge along the base axis y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_y: Option<Binding>,
    /// The displacement gauge along the base axis z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_z: Option<Binding>,
}

/// One gauge and the port it is on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Binding {
    /// Name of the instrument description, or path of the user's own.
    pub instrument: String,
    /// Unit, where the gauge does not send one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Speed that the gauge is set to, bit/s, where it is not the description's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baud: Option<u32>,
    /// The identity that the gauge reported; another identity is another gauge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identity: Option<String>,
    /// Path of the port, where it is no USB adapter, and as a reminder where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// The USB adapter; it is followed wherever the system puts it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usb: Option<UsbIdentity>,
}

impl Binding {
    /// Which port is meant; `None` if the file names none.
    #[must_use]
    pub fn port(&self) -> Option<PortIdentity> {
        match (&self.usb, &self.path) {
            (Some(usb), _) => Some(PortIdentity::Usb(usb.clone())),
            (None, Some(path)) => Some(PortIdentity::Path(path.clone())),
            (None, None) => None,
        }
    }
}

/// A bindings file that is not one.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum BindingError {
    /// No TOML, or a value of a wrong kind.
    #[error("{file} cannot be read as bindings: {problem}")]
    #[diagnostic(
        code(stiffbench::bindings::syntax),
        help("stiffbench gauge bind writes a new one; docs/bindings-file.md describes the format")
    )]
    Syntax {
        /// The file, with line and column.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// Another format.
    #[error("{file} is {found}, not {BINDINGS_SCHEMA}")]
    #[diagnostic(
        code(stiffbench::bindings::schema),
        help("it may be the file of a newer version; this one reads {BINDINGS_SCHEMA}")
    )]
    Schema {
        /// The file.
        file: String,
        /// Its content.
        found: String,
    },
    /// A gauge without a port.
    #[error("{file}: the {channel} gauge has neither usb nor path")]
    #[diagnostic(
        code(stiffbench::bindings::port),
        help(
            "name its port as path = \"/dev/serial/by-id/…\", or bind it with stiffbench gauge bind"
        )
    )]
    Port {
        /// The file.
        file: String,
        /// Which gauge.
        channel: Channel,
    },
    /// Two gauges on one port.
    #[error("{file}: two gauges are on {port}")]
    #[diagnostic(
        code(stiffbench::bindings::same_port),
        help(
            "each gauge needs a port of its own; bind one of them again with stiffbench gauge bind"
        )
    )]
    SamePort {
        /// The file.
        file: String,
        /// The port.
        port: String,
    },
}

impl Bindings {
    /// Reads a bindings file; unknown keys come back as warnings.
    ///
    /// # Errors
    /// [`BindingError`] for what is no bindings file, a gauge without a port, two gauges on one.
    pub fn parse(source: &SourceText) -> Result<(Self, Vec<String>), BindingError> {
        let file = source.name.clone();
        let (bindings, unknown) =
            read::<Self>(source).map_err(|TomlError(error)| BindingError::Syntax {
                file: error.place(),
                problem: error.problem.to_string(),
            })?;
        if bindings.schema != BINDINGS_SCHEMA {
            return Err(BindingError::Schema {
                file,
                found: bindings.schema,
            });
        }
        bindings.check(&file)?;
        let warnings = unknown.iter().map(|key| key.warning(&file));
        Ok((bindings, warnings.collect()))
    }

    fn check(&self, file: &str) -> Result<(), BindingError> {
        let mut ports: Vec<(Channel, PortIdentity)> = Vec::new();
        for channel in Channel::EVERY {
            let Some(binding) = self.of(channel) else {
                continue;
            };
            let port = binding.port().ok_or_else(|| BindingError::Port {
                file: file.to_owned(),
                channel,
            })?;
            // The one displacement gauge may be one of the three of another arrangement.
            let clashes = ports.iter().any(|(of, taken)| {
                let alone = *of == Channel::Displacement && channel.axis().is_some();
                *taken == port && !alone
            });
            if clashes {
                return Err(BindingError::SamePort {
                    file: file.to_owned(),
                    port: port.to_string(),
                });
            }
            ports.push((channel, port));
        }
        Ok(())
    }

    /// The gauge of a channel.
    #[must_use]
    pub fn of(&self, channel: Channel) -> Option<&Binding> {
        match channel {
            Channel::Force => self.force.as_ref(),
            Channel::Displacement => self.displacement.as_ref(),
            Channel::DisplacementX => self.displacement_x.as_ref(),
            Channel::DisplacementY => self.displacement_y.as_ref(),
            Channel::DisplacementZ => self.displacement_z.as_ref(),
        }
    }

    fn slot(&mut self, channel: Channel) -> &mut Option<Binding> {
        match channel {
            Channel::Force => &mut self.force,
            Channel::Displacement => &mut self.displacement,
            Channel::DisplacementX => &mut self.displacement_x,
            Channel::DisplacementY => &mut self.displacement_y,
            Channel::DisplacementZ => &mut self.displacement_z,
        }
    }

    /// The same with another gauge on a channel. A gauge of another channel that had its port is unbound, and that is reported.
    #[must_use]
    pub fn with(mut self, channel: Channel, binding: Binding) -> (Self, Option<String>) {
        BINDINGS_SCHEMA.clone_into(&mut self.schema);
        let port = binding.port();
        let mut note = None;
        for other in Channel::EVERY.into_iter().filter(|other| *other != channel) {
            let taken = port.is_some() && self.of(other).and_then(Binding::port) == port;
            if taken {
                *self.slot(other) = None;
                note = Some(format!(
                    "this port was bound to the {other} gauge, which is unbound now"
                ));
            }
        }
        *self.slot(channel) = Some(binding);
        (self, note)
    }

    /// The file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("schema = {}\n", quoted(BINDINGS_SCHEMA));
        for channel in Channel::EVERY {
            let Some(binding) = self.of(channel) else {
                continue;
            };
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "\n[{}]\ninstrument = {}\n",
                channel.key(),
                quoted(&binding.instrument)
            );
            if let Some(baud) = binding.baud {
                let _ = writeln!(text, "baud = {baud}");
            }
            let lines = [
                ("unit", &binding.unit),
                ("identity", &binding.identity),
                ("path", &binding.path),
            ];
            for (key, value) in lines {
                if let Some(value) = value {
                    let _ = writeln!(text, "{key} = {}", quoted(value));
                }
            }
            if let Some(usb) = &binding.usb {
                let fields = [
                    ("vendor", Some(&usb.vendor)),
                    ("product", Some(&usb.product)),
                    ("serial", usb.serial.as_ref()),
                    ("location", usb.location.as_ref()),
                ];
                let fields: Vec<String> = fields
                    .into_iter()
                    .filter_map(|(key, value)| Some(format!("{key} = {}", quoted(value?))))
                    .collect();
                let _ = writeln!(text, "usb = {{ {} }}", fields.join(", "));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<(Bindings, Vec<String>), BindingError> {
        Bindings::parse(&SourceText::new("bench.toml", text))
    }

    fn adapter(location: &str) -> UsbIdentity {
        UsbIdentity {
            vendor: "0403".to_owned(),
            product: "6001".to_owned(),
            serial: None,
            location: Some(location.to_owned()),
        }
    }

    fn binding(location: &str) -> Binding {
        Binding {
            instrument: "sauter-fh".to_owned(),
            unit: Some("N".to_owned()),
            baud: Some(19_200),
            identity: Some("a \"quoted\" name\\".to_owned()),
            path: Some("/dev/ttyUSB0".to_owned()),
            usb: Some(adapter(location)),
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let (bindings, _) = Bindings::default().with(Channel::Force, binding("1-1:1.0"));
        let (bindings, note) = bindings.with(Channel::Displacement, binding("1-2:1.0"));
        assert_eq!(note, None);
        let (read, warnings) = parse(&bindings.to_toml()).unwrap();
        assert_eq!(read, bindings);
        assert_eq!(warnings, [""; 0]);
    }

    #[test]
    fn a_port_serves_one_gauge() {
        let (bindings, _) = Bindings::default().with(Channel::Force, binding("1-1:1.0"));
        let (bindings, note) = bindings.with(Channel::Displacement, binding("1-1:1.0"));
        assert!(note.unwrap().contains("force"));
        assert_eq!(bindings.force, None);
        let twice = "schema = \"stiffbench/bindings/1\"\n[force]\ninstrument = \"a\"\npath = \"/dev/x\"\n[displacement]\ninstrument = \"b\"\npath = \"/dev/x\"\n";
        assert!(matches!(parse(twice), Err(BindingError::SamePort { .. })));
    }

    #[test]
    fn what_is_no_bindings_file_is_refused_and_unknown_keys_are_named() {
        assert!(matches!(
            parse("schema = 3"),
            Err(BindingError::Syntax { .. })
        ));
        assert!(matches!(parse("force ="), Err(BindingError::Syntax { .. })));
        let newer = parse("schema = \"stiffbench/bindings/2\"");
        assert!(matches!(newer, Err(BindingError::Schema { .. })));
        let portless = "schema = \"stiffbench/bindings/1\"\n[force]\ninstrument = \"a\"\n";
        assert!(matches!(parse(portless), Err(BindingError::Port { .. })));
        let odd = "schema = \"stiffbench/bindings/1\"\ncolour = 1\n[force]\ninstrument = \"a\"\npath = \"/dev/x\"\n";
        let (bindings, warnings) = parse(odd).unwrap();
        assert_eq!(
            warnings,
            ["bench.toml:2:1: key `colour` is not known and was not used"]
        );
        let port = bindings.force.unwrap().port().unwrap();
        assert_eq!(port, PortIdentity::Path("/dev/x".to_owned()));
    }
}
