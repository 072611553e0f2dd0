//! Robots that a test writes.

use stiffbench_test_files::text;
use tempfile::TempDir;

/// A robot file in a folder of its own.
#[derive(Debug)]
pub(super) struct RobotFile {
    folder: TempDir,
}

impl RobotFile {
    pub(super) fn new(text: &str) -> Self {
        let folder = TempDir::new().unwrap();
        std::fs::write(folder.path().join("robot.toml"), text).unwrap();
        Self { folder }
    }

    /// The FANUC with springs of which the file states no compliance: a fit begins at the rigid robot.
    pub(super) fn fanuc() -> Self {
        let mut robot = String::new();
        for line in text("data/robots/fanuc-r2000ic.toml").lines() {
            let stated = line.split_once(", compliance_urad_per_Nm");
            robot += &stated.map_or_else(|| line.to_owned(), |(before, _)| format!("{before} }}"));
            robot.push('\n');
        }
        Self::new(&robot)
    }

    /// The option that names it.
    pub(super) fn option(&self) -> String {
        let file = self.folder.path().join("robot.toml");
        format!("--robot {}", file.display())
    }
}
