//! Every command of the README and of the pages runs as it stands there, in a folder with what the reader of its page has by then, and prints what
//! stands below it there.
//!
//! `pages.toml` says what a reader has, and which commands cannot run to their end in a test.

#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

use serde::Deserialize;
use stiffbench_test_files::{documentation, repository};

/// Pages whose commands run at the same time.
const AT_A_TIME: usize = 2;

#[derive(Deserialize)]
struct Pages {
    /// Beginnings of blocks for other programs.
    other_programs: Vec<String>,
    /// Beginnings of commands of which only words and options are checked.
    words_only: Vec<String>,
    /// Shell lines that run before the blocks of a page.
    given: BTreeMap<String, String>,
}

/// A line of a page that stands for lines that it leaves out.
const LEFT_OUT: &str = "...";

/// A block of commands.
#[derive(Debug, Default, PartialEq)]
struct Block<'p> {
    /// Its commands: of ```sh all lines, of ```console what stands behind `$ `.
    commands: Vec<&'p str>,
    /// What the page says that they print.
    shown: Vec<&'p str>,
}

fn blocks(markdown: &str) -> Vec<Block<'_>> {
    let mut blocks = Vec::new();
    let mut language = None;
    let mut indent = 0;
    for line in markdown.lines() {
        match (line.trim_start().strip_prefix("```"), language) {
            (Some(begun), None) => {
                language = Some(begun);
                indent = line.len() - line.trim_start().len();
                blocks.push(Block::default());
            }
            (Some(_), Some(_)) => language = None,
            (None, Some("sh")) => {
                let commands = &mut blocks.last_mut().unwrap().commands;
                commands.push(line.get(indent..).unwrap_or(""));
            }
            (None, Some("console")) => {
                let block = blocks.last_mut().unwrap();
                match line.strip_prefix("$ ") {
                    Some(command) => block.commands.push(command),
                    None if line != LEFT_OUT => block.shown.push(line),
                    None => {}
                }
            }
            (None, _) => {}
        }
    }
    blocks.retain(|block| !block.commands.is_empty());
    blocks
}

impl Pages {
    /// A block as it is run: commands that are not to run to their end print their help instead, for which every word and option must be known.
    fn script(&self, block: &[&str]) -> Option<String> {
        let begins = |line: &str, with: &[String]| with.iter().any(|start| line.starts_with(start));
        if begins(block[0], &self.other_programs) {
            return None;
        }
        let line = |line: &&str| {
            if begins(line, &self.words_only) {
                let command = line.split(" #").next().unwrap_or(line);
                format!("{command} --help > help.txt\n")
            } else {
                format!("{line}\n")
            }
        };
        Some(block.iter().map(line).collect())
    }

    /// Runs the blocks of a page one after another in one new folder: which failed, and how.
    fn failures(&self, page: &Path) -> Vec<String> {
        let markdown = fs::read_to_string(repository().join(page)).unwrap();
        let desk = tempfile::tempdir().unwrap();
        let folder = desk.path().join("desk");
        fs::create_dir(&folder).unwrap();
        let given = self.given.get(page.to_str().unwrap()).cloned();
        let blocks = blocks(&markdown);
        let given = given.map(|script| (script, Vec::new())).into_iter();
        let failed = given
            .chain(
                blocks
                    .into_iter()
                    .filter_map(|block| Some((self.script(&block.commands)?, block.shown))),
            )
            .filter_map(|(script, shown)| {
                let failure = run(&script, &shown, &folder, desk.path())?;
                Some(format!("{}:\n{script}\n{failure}", page.display()))
            });
        failed.collect()
    }
}

/// What a script printed as an error, if it failed, or what it did not print.
fn run(script: &str, shown: &[&str], folder: &Path, home: &Path) -> Option<String> {
    let programs = Path::new(env!("CARGO_BIN_EXE_stiffbench")).parent()?;
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let output = Command::new("sh")
        .args(["-eu", "-c", script])
        .current_dir(folder)
        .stdin(Stdio::null())
        .env("PATH", path)
        .env("HOME", home)
        .env("ROOT", repository())
        .output()
        .unwrap();
    let [printed, errors] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    if !output.status.success() {
        return Some(format!("{}\n{errors}", output.status));
    }
    let is_printed = |line: &&&str| printed.lines().any(|own| own == **line);
    let missing = shown.iter().find(|line| !is_printed(line))?;
    Some(format!("it does not print\n{missing}\nbut\n{printed}"))
}

#[test]
fn every_command_of_the_pages_runs() {
    let text = fs::read_to_string(repository().join("tests/pages.toml")).unwrap();
    let settings: Pages = toml::from_str(&text).unwrap();
    let known = documentation();
    for page in settings.given.keys() {
        assert!(known.iter().any(|one| one == Path::new(page)), "{page}");
    }
    let has_python = Command::new("python3").arg("--version").output().is_ok();
    let runs = |page: &PathBuf| {
        let needs_python = || {
            fs::read_to_string(repository().join(page))
                .unwrap()
                .contains("python3 - ")
        };
        if !has_python && needs_python() {
            eprintln!("{}: skipped for want of python3", page.display());
            return false;
        }
        true
    };
    let waiting: Mutex<Vec<PathBuf>> = Mutex::new(known.into_iter().filter(runs).collect());
    let failures = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(|| {
                loop {
                    let next = waiting.lock().unwrap().pop();
                    let Some(page) = next else { break };
                    let failed = settings.failures(&page);
                    failures.lock().unwrap().extend(failed);
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn blocks_of_commands_are_found() {
    let markdown = "1. a\n   ```sh\n   fit a \\\n     --b  # c\n   ```\n```console\n$ one\nwhat it prints\n$ two\n```\n```toml\n$ no\n```\n$ no\n";
    assert_eq!(
        blocks(markdown),
        [
            Block {
                commands: vec!["fit a \\", "  --b  # c"],
                shown: Vec::new()
            },
            Block {
                commands: vec!["one", "two"],
                shown: vec!["what it prints"]
            }
        ]
    );
}

#[test]
fn a_command_that_is_not_run_to_its_end_is_checked_for_its_words() {
    let settings = Pages {
        other_programs: vec!["cargo ".to_owned()],
        words_only: vec!["stiffbench gauge bind".to_owned()],
        given: BTreeMap::new(),
    };
    assert_eq!(settings.script(&["cargo test", "stiffbench demo"]), None);
    let script = settings.script(&["stiffbench gauge bind --bnid force  # plug it in"]);
    let folder = tempfile::tempdir().unwrap();
    let failure = run(&script.unwrap(), &[], folder.path(), folder.path());
    assert!(failure.is_some_and(|failure| failure.contains("--bnid")));
}
