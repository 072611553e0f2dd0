//! Who has a port open, where the system reports it.

use std::fmt::Write;
use std::path::Path;

/// A program that has a port open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Number of its process.
    pub pid: u32,
    /// Name of its process.
    pub name: String,
}

impl Holder {
    /// `: ` and the programs, nothing if none is known.
    pub(super) fn sentence(holders: &[Self]) -> String {
        let mut text = String::new();
        for (place, holder) in holders.iter().enumerate() {
            let start = if place == 0 { ": " } else { ", " };
            let own = if holder.pid == std::process::id() {
                " (this program itself)"
            } else {
                ""
            };
            // Writing to a string cannot fail.
            let _ = write!(text, "{start}{} (process {}){own}", holder.name, holder.pid);
        }
        text
    }
}

/// Who has `port` open, by the open files of all processes that this user may look into.
///
/// `proc` is the folder of the processes (`/proc` on Linux); where there is none, no process is found.
pub(super) fn holders(proc: &Path, port: &Path) -> Vec<Holder> {
    let Ok(device) = port.canonicalize() else {
        return Vec::new();
    };
    let Ok(processes) = proc.read_dir() else {
        return Vec::new();
    };
    let mut found: Vec<Holder> = processes
        .flatten()
        .filter_map(|process| {
            let pid = process.file_name().to_str()?.parse().ok()?;
            let mut files = process.path().join("fd").read_dir().ok()?.flatten();
            files
                .any(|file| file.path().read_link().is_ok_and(|link| link == device))
                .then(|| Holder {
                    pid,
                    name: name(&process.path()),
                })
        })
        .collect();
    found.sort_by_key(|holder| holder.pid);
    found
}

fn name(process: &Path) -> String {
    std::fs::read_to_string(process.join("comm")).map_or_else(
        |_| "a program without a name".to_owned(),
        |text| text.trim().to_owned(),
    )
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn holders_are_found_by_their_open_files() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        let port = root.join("ttyUSB0");
        fs::write(&port, "").unwrap();
        symlink(&port, root.join("by-id")).unwrap();
        for (pid, name, open) in [(7, "minicom", &port), (12, "bash", &root)] {
            let process = root.join(format!("proc/{pid}"));
            fs::create_dir_all(process.join("fd")).unwrap();
            fs::write(process.join("comm"), format!("{name}\n")).unwrap();
            symlink(open, process.join("fd/3")).unwrap();
        }
        fs::create_dir_all(root.join("proc/self")).unwrap();
        let found = holders(&root.join("proc"), &root.join("by-id"));
        assert_eq!(
            found,
            [Holder {
                pid: 7,
                name: "minicom".to_owned()
            }]
        );
        assert_eq!(Holder::sentence(&found), ": minicom (process 7)");
        assert!(holders(&root.join("none"), &port).is_empty());
        assert!(holders(&root.join("proc"), &root.join("absent")).is_empty());
    }
}
