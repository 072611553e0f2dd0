//! Inputs with a known right answer: each row of `fixtures/cases/*.toml` is a command line, where to look, and what must stand there.
//!
//! Rows begin in an empty folder with the files of their case. A row that asks for a number says within which distance.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use stiffbench_test_files::repository;
use tempfile::TempDir;

/// A row of the table.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    /// What the row shows.
    name: String,
    /// Folder beside the table whose content is copied to where the command runs.
    files: Option<String>,
    /// Shell commands that prepare the input; `stiffbench` is the program.
    prepare: Option<String>,
    /// Arguments of the program, divided as a shell does.
    run: String,
    /// Exit code.
    #[serde(default)]
    exit: i32,
    /// Files that must be afterwards what they were before the command.
    #[serde(default)]
    unchanged: Vec<String>,
    /// What must be found.
    check: Vec<Check>,
}

/// One place and what stands there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Check {
    /// JSON pointer into what is printed on standard output; without it both outputs are searched as text.
    at: Option<String>,
    /// The value itself.
    is: Option<Value>,
    /// A number, and how far from it is right.
    near: Option<[f64; 2]>,
    /// Text that is part of it, without regard to case.
    contains: Option<String>,
    /// Text that is not part of it, without regard to case.
    lacks: Option<String>,
    /// Nothing, or null, stands there.
    #[serde(default)]
    absent: bool,
}

impl Check {
    /// What is wrong, if anything.
    fn complaint(&self, json: Option<&Value>, printed: &str) -> Option<String> {
        let place = self.at.as_deref().unwrap_or("output");
        let found = match &self.at {
            None => Some(Value::from(printed)),
            Some(at) => match json {
                Some(json) => json.pointer(at).filter(|value| !value.is_null()).cloned(),
                None => return Some(format!("{place}: standard output is no JSON")),
            },
        };
        let text = found
            .as_ref()
            .map(|value| {
                value
                    .as_str()
                    .map_or_else(|| value.to_string(), str::to_owned)
            })
            .unwrap_or_default();
        // Words are found wherever a line ends.
        let in_one_line = |text: &str| -> String {
            let words: Vec<&str> = text.split_whitespace().collect();
            words.join(" ").to_lowercase()
        };
        let one_line = in_one_line(&text);
        let mut asked = usize::from(self.absent);
        let mut right = !self.absent || found.is_none();
        if let Some(value) = &self.is {
            asked += 1;
            right &= found.as_ref() == Some(value);
        }
        if let Some([value, within]) = self.near {
            asked += 1;
            let number = found.as_ref().and_then(Value::as_f64);
            right &= number.is_some_and(|number| (number - value).abs() <= within);
        }
        if let Some(part) = &self.contains {
            asked += 1;
            right &= one_line.contains(&in_one_line(part));
        }
        if let Some(part) = &self.lacks {
            asked += 1;
            right &= found.is_some() && !text.to_lowercase().contains(&part.to_lowercase());
        }
        assert!(asked > 0, "a check of {place} asks for nothing");
        let shown = text.chars().take(1500).collect::<String>();
        (!right).then(|| format!("{place}: not {self:?}, found: {shown}"))
    }
}

impl Row {
    /// Runs the row in a folder of its own; what is wrong with it.
    fn complaints(&self, tables: &Path) -> Vec<String> {
        let folder = TempDir::new().unwrap();
        let desk = folder.path().canonicalize().unwrap();
        let program = Path::new(env!("CARGO_BIN_EXE_stiffbench"));
        let path = format!(
            "{}:{}",
            program.parent().unwrap().display(),
            std::env::var("PATH").unwrap()
        );
        let shell = |script: &str| {
            let mut command = Command::new("sh");
            command.args(["-ec", script]).current_dir(&desk);
            command.env("PATH", &path).output().unwrap()
        };
        if let Some(files) = &self.files {
            let from = tables.join(files);
            let copied = shell(&format!("cp -r '{}/.' .", from.display()));
            assert!(copied.status.success(), "{}: {copied:?}", self.name);
        }
        if let Some(script) = &self.prepare {
            let ran = shell(script);
            assert!(ran.status.success(), "{}: {ran:?}", self.name);
        }
        let contents = || -> Vec<_> {
            let files = self.unchanged.iter();
            files.map(|file| fs::read(desk.join(file)).ok()).collect()
        };
        let before = contents();
        let ran = shell(&format!("stiffbench {}", self.run));
        let out = String::from_utf8_lossy(&ran.stdout);
        let printed = format!("{out}{}", String::from_utf8_lossy(&ran.stderr));
        let json = serde_json::from_str(&out).ok();
        let mut complaints: Vec<String> = self
            .check
            .iter()
            .filter_map(|check| check.complaint(json.as_ref(), &printed))
            .collect();
        if ran.status.code() != Some(self.exit) {
            complaints.push(format!("ends with {:?}: {printed}", ran.status.code()));
        }
        if contents() != before {
            complaints.push(format!("{:?} changed", self.unchanged));
        }
        let named = |text| format!("{}\n    stiffbench {}\n    {text}", self.name, self.run);
        complaints.into_iter().map(named).collect()
    }
}

#[test]
fn every_input_with_a_known_answer_gets_it() {
    let tables = repository().join("fixtures/cases");
    let files = fs::read_dir(&tables)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let rows: Vec<Row> = files
        .filter(|file| file.extension().is_some_and(|ending| ending == "toml"))
        .flat_map(|file| {
            let text = fs::read_to_string(&file).unwrap();
            let table: BTreeMap<String, Vec<Row>> =
                toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            table.into_values().flatten()
        })
        .collect();
    let only = std::env::var("STIFFBENCH_CASE").unwrap_or_default();
    let complaints: Vec<String> = rows
        .par_iter()
        .filter(|row| row.name.contains(&only))
        .flat_map_iter(|row| row.complaints(&tables))
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
