//! Serial ports: which there are, which of them is meant, and opening it without surprises.
//!
//! A port is named by what stays: the USB identity of its adapter (vendor, product, serial number, the socket it is plugged into), not by
//! `ttyUSB0`, which changes when a cable is pulled. Whatever path a user names is taken, listed or not. Opening sets every line setting and
//! every modem line that the instrument description states, exclusively, with a deadline, and clears what came before.

mod binding;
mod error;
mod holder;
mod identity;
mod list;
mod open;
mod settings;
#[cfg(any(target_os = "linux", test))]
mod sysfs;

pub use binding::{BINDINGS_SCHEMA, Binding, BindingError, Bindings};
pub use error::PortError;
pub use holder::Holder;
pub use identity::{PortIdentity, Resolved, UsbIdentity};
pub use list::{PortInfo, list_ports, newly_plugged};
pub use open::{NativePort, OpenPort, PortTimeouts, open, permission_remedy};
pub use settings::PortSettings;
