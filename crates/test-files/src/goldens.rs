//! The text that every command of a program prints on shipped and simulated data, against what is kept.
//!
//! `cases.toml` in the folder lists the cases; each runs in a folder of its own. The test compares words exactly and numbers as closely
//! as machines with other instruction sets agree. `just goldens` writes the kept texts again, and `git diff` then shows every byte
//! that has changed: that is the comparison before and after a change that means to change nothing, on one machine.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use serde::Deserialize;
use tempfile::TempDir;

use super::repository;

/// Relative difference of two numbers that counts as none. AVX-512 and AVX2 round sums otherwise; a search that stops where nothing decisive is
/// left to gain then stops elsewhere, by up to 3e-3 of a variance or of a share in the kept outputs.
const RELATIVE: f64 = 5e-3;

/// Absolute difference that counts as none: the rounding of a sum that is zero, in SI.
const ABSOLUTE: f64 = 1e-15;

/// A case: commands that run one after the other in an empty folder.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Case {
    /// Arguments of the program, separated by blanks; `DATA` is the repository's `data`, `< FILE` gives a file as input.
    run: Vec<String>,
    /// Files of the repository that are copied into the folder first.
    #[serde(default)]
    with: Vec<String>,
    /// Lines that contain one of these are not kept: how long something took.
    #[serde(default)]
    without_lines: Vec<String>,
    /// Lines that contain one of these differ from machine to machine: what is compared is that they are there.
    #[serde(default)]
    of_machine: Vec<String>,
    /// Emulated gauges and the clock at hand took part: hashes of what they wrote are masked.
    #[serde(default)]
    timed: bool,
}

/// A program and the folder with what it is known to print.
#[derive(Debug, Clone, Copy)]
pub struct Goldens<'a> {
    /// Path of the program.
    pub program: &'a str,
    /// Its name.
    pub name: &'a str,
    /// The folder, from that of the repository.
    pub folder: &'a str,
    /// The commit it names as its own; empty if it names none.
    pub commit: &'a str,
}

impl Goldens<'_> {
    /// Runs every case and compares, or keeps the texts where `STIFFBENCH_GOLDENS` is `write`.
    ///
    /// # Panics
    /// With all differences.
    pub fn check(&self) {
        let folder = repository().join(self.folder);
        let text = fs::read_to_string(folder.join("cases.toml")).unwrap();
        let cases: BTreeMap<String, Case> = toml::from_str(&text).unwrap();
        let write = super::schemas::are_written();
        let texts = fs::read_dir(&folder).unwrap().filter_map(|file| {
            let name = file.unwrap().file_name().into_string().unwrap();
            name.strip_suffix(".txt").map(str::to_owned)
        });
        let unused = texts.filter(|name| !cases.contains_key(name));
        let unused: Vec<String> = unused.map(|name| format!("{name}.txt: no case")).collect();
        let complaint = |(name, case): (&String, &Case)| {
            let now = self.printed(case);
            let file = folder.join(format!("{name}.txt"));
            if write {
                fs::write(file, now).unwrap();
                return None;
            }
            let Ok(golden) = fs::read_to_string(file) else {
                return Some(format!("{name}: nothing is kept"));
            };
            let difference = difference(&golden, &now, &case.of_machine)?;
            Some(format!("{name}: {difference}"))
        };
        let mut complaints: Vec<String> = cases.par_iter().filter_map(complaint).collect();
        complaints.extend(unused);
        assert!(
            complaints.is_empty(),
            "\n{}\nIf the change is meant: just goldens, and say why in the commit.",
            complaints.join("\n")
        );
    }

    /// What the commands of a case print.
    fn printed(&self, case: &Case) -> String {
        let folder = TempDir::new().unwrap();
        // A name without a link in it, as the program prints it.
        let desk = folder.path().canonicalize().unwrap();
        for file in &case.with {
            let source = repository().join(file);
            copy(&source, &desk.join(source.file_name().unwrap()));
        }
        let mut printed = String::new();
        for line in &case.run {
            let (words, input) = match line.split_once(" < ") {
                Some((words, input)) => (words, Some(input.trim())),
                None => (line.as_str(), None),
            };
            let mut command = Command::new(self.program);
            let data = repository().join("data");
            let word = |word: &str| word.replace("DATA", data.to_str().unwrap());
            command
                .env_remove(super::schemas::MODE)
                .current_dir(&desk)
                .args(words.split_whitespace().map(word));
            if let Some(input) = input {
                command.stdin(fs::File::open(repository().join(input)).unwrap());
            }
            let ran = command.output().unwrap();
            let code = ran.status.code().expect("not stopped by a signal");
            writeln!(printed, "$ {} {line}\nexit code {code}", self.name).unwrap();
            printed += &String::from_utf8(ran.stdout).unwrap();
            for note in String::from_utf8(ran.stderr).unwrap().lines() {
                writeln!(printed, "2> {note}").unwrap();
            }
        }
        self.masked(&printed, desk.to_str().unwrap(), case)
    }

    /// A text without what differs from run to run and from machine to machine: paths, version, and what depends on a clock.
    fn masked(&self, text: &str, desk: &str, case: &Case) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let (name, commit) = (self.name, self.commit);
        let printed = if commit.is_empty() {
            "not recorded"
        } else {
            commit
        };
        let text = text
            .replace(&format!("{version} ({commit})"), version)
            .replace(&format!("commit {printed}"), "commit COMMIT")
            .replace(desk, "DESK")
            .replace(repository().to_str().unwrap(), "REPOSITORY")
            .replace(&format!("{name} {version}"), &format!("{name} VERSION"));
        let out = |line: &str| case.without_lines.iter().any(|part| line.contains(part));
        let lines = text.lines().filter(|line| !out(line));
        let text = lines.fold(String::new(), |text, line| text + line + "\n");
        if case.timed {
            without_hashes(&text)
        } else {
            text
        }
    }
}

/// Copies a file, or a folder with all that is in it.
pub(crate) fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        fs::copy(from, to).unwrap();
    }
}

/// A text whose hashes, in full or the first twelve digits in brackets, are masked: those of readings with times are never the same.
fn without_hashes(text: &str) -> String {
    let is_hex = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
    let mut masked = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(is_hex) {
        let length = rest[start..]
            .find(|c| !is_hex(c))
            .unwrap_or(rest.len() - start);
        let (before, word) = (&rest[..start], &rest[start..start + length]);
        rest = &rest[start + length..];
        let short = length == 12 && before.ends_with('(') && rest.starts_with(')');
        masked += before;
        masked += if length == 64 || short { "HASH" } else { word };
    }
    masked + rest
}

/// Where two texts differ in more than the last digits of their numbers; `None` if nowhere.
fn difference(golden: &str, now: &str, of_machine: &[String]) -> Option<String> {
    let is_of_machine = |line: &str| of_machine.iter().any(|part| line.contains(part));
    let (mut old, mut new) = (golden.lines(), now.lines());
    let mut number = 0;
    loop {
        number += 1;
        match (old.next(), new.next()) {
            (None, None) => return None,
            (Some(old), Some(new)) if is_of_machine(old) && is_of_machine(new) => {}
            (Some(old), Some(new)) if same(old, new) => {}
            (old, new) => {
                let show = |line: Option<&str>| line.unwrap_or("(end)").to_owned();
                return Some(format!(
                    "line {number}\n  kept: {}\n  now:  {}",
                    show(old),
                    show(new)
                ));
            }
        }
    }
}

fn same(old: &str, new: &str) -> bool {
    if old == new {
        return true;
    }
    let (old, new) = (tokens(old), tokens(new));
    old.len() == new.len()
        && old.iter().zip(&new).all(|pair| match pair {
            (Token::Number(a, one), Token::Number(b, other)) => {
                let relative = RELATIVE * a.abs().max(b.abs());
                (a - b).abs() <= ABSOLUTE.max(relative).max(one.max(*other))
            }
            (Token::Text(a), Token::Text(b)) => a == b,
            _ => false,
        })
}

#[derive(Debug, PartialEq)]
enum Token<'a> {
    /// A number, and how much rounding may have moved its last digit: one and a bit, if it has decimals.
    Number(f64, f64),
    /// Runs of blanks are one: a column is as wide as its numbers.
    Text(Vec<&'a str>),
}

/// A line as numbers and what stands between them. A digit inside a word (`P1`) belongs to the word.
fn tokens(line: &str) -> Vec<Token<'_>> {
    let bytes = line.as_bytes();
    let text = |from: usize, to: usize| Token::Text(line[from..to].split_whitespace().collect());
    let (mut tokens, mut start, mut at) = (Vec::new(), 0, 0);
    while at < bytes.len() {
        let in_word = at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || bytes[at - 1] == b'_');
        let signed = bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit);
        if in_word || !(signed || bytes[at].is_ascii_digit()) {
            at += 1;
            continue;
        }
        let end = number_end(bytes, at + usize::from(signed));
        tokens.push(text(start, at));
        let number = &line[at..end];
        tokens.push(Token::Number(number.parse().unwrap(), last_digit(number)));
        (start, at) = (end, end);
    }
    tokens.push(text(start, bytes.len()));
    tokens
}

/// 1.01 units of the last decimal of a number; of an integer zero, for it may be a count.
fn last_digit(number: &str) -> f64 {
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let Some((_, decimals)) = digits.split_once('.') else {
        return 0.0;
    };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let places = i32::try_from(decimals.len()).unwrap_or(i32::MAX);
    1.01 * 10.0_f64.powi(exponent - places)
}

/// Where the number ends whose first digit stands at `at`.
fn number_end(bytes: &[u8], at: usize) -> usize {
    let digits = |from: usize| {
        from + bytes[from..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit())
            .count()
    };
    let mut end = digits(at);
    if bytes.get(end) == Some(&b'.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = end + 1 + sign;
        if exponent <= bytes.len() && digits(exponent) > exponent {
            end = digits(exponent);
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_compared_and_words_are_not_taken_for_numbers() {
        assert!(same("K 0.5000 N/um", "K  0.5024 N/um"));
        assert!(!same("K 0.5000 N/um", "K 0.5026 N/um"));
        assert!(same("27.3 %", "27.4 %") && !same("27.3 %", "27.5 %"));
        assert!(!same("100 runs", "101 runs"));
        assert!(!same("P1 0.5", "P2 0.5"));
        assert!(!same("-3e-7", "3e-7"));
        assert!(same("a 1e-21,2", "a -4e-22,2"));
        assert!(!same("1,2", "1,2,3"));
        assert_eq!(tokens("P1 x"), [Token::Text(vec!["P1", "x"])]);
        assert!(difference("1\n2\n", "1\n", &[]).is_some());
        let machine = [String::from("set")];
        assert_eq!(difference("set A", "set B", &machine), None);
        assert!(difference("set A", "", &machine).is_some());
    }
}
