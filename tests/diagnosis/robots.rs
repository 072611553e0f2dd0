//! Robots that a test writes, and commands on them.

use serde_json::Value;
use stiffbench_test_files::text;
use tempfile::TempDir;

use super::load_cases::SPRINGS;
use crate::support::tables::Table;

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

    pub(super) fn fit(&self, table: &Table, options: &str) -> Value {
        table.data("fit", &format!("{} {options}", self.option()))
    }

    /// The whole JSON of a command on the table.
    pub(super) fn json(&self, table: &Table, command: &str) -> Value {
        table.json(command, &self.option())
    }

    pub(super) fn diagnose(&self, table: &Table) -> Value {
        table.data("diagnose", &self.option())
    }

    /// Load cases of the FANUC with [`SPRINGS`].
    ///
    /// # Arguments
    /// - `options`: how many, how large, and how they scatter.
    /// - `further`: springs beside those about the axes.
    pub(super) fn load_cases(&self, options: &str, further: &[(&str, f64)], seed: u64) -> Table {
        let own = (1..=6).map(|joint| format!("joint.J{joint}"));
        let own = own.zip(SPRINGS);
        let further = further.iter().map(|(name, c)| ((*name).to_owned(), *c));
        let springs: Vec<String> = own
            .chain(further)
            .map(|(name, c)| format!("{name}={c:e}"))
            .collect();
        let options = format!(
            "{} {options} --true-factor {} --seed {seed}",
            self.option(),
            springs.join(",")
        );
        Table::simulated(&options, &[])
    }
}
