//! The serial ports of Linux, from what the kernel shows under `/sys/class/tty` and udev under `/dev/serial`.
//!
//! Read by hand because it is more than the serial library reports without a system library: the interface of an adapter with several ports,
//! adapters without a known location, and no panic where the folder is missing (containers).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::identity::UsbIdentity;
use super::list::PortInfo;

/// The ports under `class` (`/sys/class/tty`) that have hardware and a device file in `dev` (`/dev`); none where the folder is missing.
pub(super) fn list(class: &Path, dev: &Path) -> Vec<PortInfo> {
    let Ok(entries) = class.read_dir() else {
        return Vec::new();
    };
    let by_id = links(&dev.join("serial/by-id"));
    let by_path = links(&dev.join("serial/by-path"));
    entries
        .flatten()
        .filter_map(|entry| {
            let tty = entry.path();
            let device = tty.join("device").canonicalize().ok()?;
            // Serial ports that the kernel reserves without hardware have type 0.
            if read(&tty, "type").is_some_and(|kind| kind == "0") {
                return None;
            }
            let file = dev.join(entry.file_name());
            let real = file.canonicalize().ok()?;
            let (usb, label) = usb(&device);
            Some(PortInfo {
                path: file.to_str()?.to_owned(),
                by_id: by_id.get(&real).cloned(),
                by_path: by_path.get(&real).cloned(),
                usb,
                label,
                latency_ms: read(&device, "latency_timer").and_then(|text| text.parse().ok()),
            })
        })
        .collect()
}

/// The links of a folder by the file they lead to.
fn links(folder: &Path) -> BTreeMap<PathBuf, String> {
    let Ok(entries) = folder.read_dir() else {
        return BTreeMap::new();
    };
    let link = |path: PathBuf| Some((path.canonicalize().ok()?, path.to_str()?.to_owned()));
    entries
        .flatten()
        .filter_map(|entry| link(entry.path()))
        .collect()
}

/// The USB device that a tty belongs to, and what it calls itself.
///
/// The folder of the interface (`1-1.4:1.0`) names bus, sockets and interface; its parent holds what the device says of itself.
fn usb(device: &Path) -> (Option<UsbIdentity>, Option<String>) {
    let Some(folder) = device
        .ancestors()
        .find(|folder| folder.join("idVendor").is_file())
    else {
        return (None, None);
    };
    let interface = device
        .ancestors()
        .take_while(|ancestor| *ancestor != folder)
        .last();
    let location = interface
        .unwrap_or(folder)
        .file_name()
        .and_then(|name| name.to_str())
        .map(str::to_owned);
    let identity =
        read(folder, "idVendor")
            .zip(read(folder, "idProduct"))
            .map(|(vendor, product)| UsbIdentity {
                vendor,
                product,
                serial: read(folder, "serial"),
                location,
            });
    let words: Vec<String> = ["manufacturer", "product"]
        .iter()
        .filter_map(|name| read(folder, name))
        .collect();
    (identity, (!words.is_empty()).then(|| words.join(" ")))
}

/// The text of a small file, trimmed; `None` if it is missing or empty.
fn read(folder: &Path, name: &str) -> Option<String> {
    let text = fs::read_to_string(folder.join(name)).ok()?;
    let text = text.trim();
    (!text.is_empty()).then(|| text.to_owned())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    /// A tree as the kernel and udev make it: two adapters without serial number, a built-in port, one without hardware.
    fn tree(root: &Path) {
        let file = |path: &str, text: &str| {
            let path = root.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let link = |to: &str, path: &str| {
            let path = root.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            symlink(root.join(to), path).unwrap();
        };
        for (socket, name) in [("1-1.4", "ttyUSB0"), ("1-2", "ttyUSB1")] {
            let usb = format!("devices/usb1/{socket}");
            file(&format!("{usb}/idVendor"), "0403\n");
            file(&format!("{usb}/idProduct"), "6001\n");
            file(&format!("{usb}/product"), "FT232R USB UART\n");
            let tty = format!("{usb}/{socket}:1.0/{name}");
            file(&format!("{tty}/tty/{name}/dev"), "188:0\n");
            link(&tty, &format!("{tty}/tty/{name}/device"));
            link(&format!("{tty}/tty/{name}"), &format!("class/tty/{name}"));
            file(&format!("dev/{name}"), "");
        }
        file("devices/usb1/1-2/1-2:1.0/ttyUSB1/latency_timer", "16\n");
        file("devices/usb1/1-2/serial", "A50285BI\n");
        link(
            "dev/ttyUSB1",
            "dev/serial/by-id/usb-FTDI_A50285BI-if00-port0",
        );
        for (name, kind) in [("ttyS0", "4"), ("ttyS1", "0")] {
            file(&format!("devices/platform/{name}/type"), kind);
            fs::create_dir_all(root.join("devices/platform/8250")).unwrap();
            link(
                "devices/platform/8250",
                &format!("devices/platform/{name}/device"),
            );
            link(
                &format!("devices/platform/{name}"),
                &format!("class/tty/{name}"),
            );
            file(&format!("dev/{name}"), "");
        }
        // A virtual terminal has no device.
        fs::create_dir_all(root.join("class/tty/tty1")).unwrap();
        file("dev/tty1", "");
    }

    #[test]
    fn adapters_are_listed_with_serial_number_socket_and_lasting_name() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        tree(&root);
        let mut ports = list(&root.join("class/tty"), &root.join("dev"));
        ports.sort_by(|a, b| a.path.cmp(&b.path));
        let names: Vec<&str> = ports
            .iter()
            .map(|port| port.path.rsplit('/').next().unwrap())
            .collect();
        assert_eq!(names, ["ttyS0", "ttyUSB0", "ttyUSB1"]);
        assert_eq!(ports[0].usb, None);
        let usb = |i: usize| ports[i].usb.as_ref().unwrap();
        assert_eq!(usb(1).location.as_deref(), Some("1-1.4:1.0"));
        assert_eq!(usb(1).serial, None);
        assert_eq!(usb(2).serial.as_deref(), Some("A50285BI"));
        assert_eq!(ports[2].label.as_deref(), Some("FT232R USB UART"));
        assert!(
            ports[2]
                .stable_path()
                .ends_with("usb-FTDI_A50285BI-if00-port0")
        );
        assert_eq!(ports[1].stable_path(), ports[1].path);
        assert_eq!((ports[1].latency_ms, ports[2].latency_ms), (None, Some(16)));
    }

    #[test]
    fn a_machine_without_the_folder_has_no_ports() {
        let folder = tempfile::tempdir().unwrap();
        assert!(list(&folder.path().join("class/tty"), folder.path()).is_empty());
    }
}
