//! What every command of a program prints and writes on shipped and simulated data, against what is kept.
//!
//! `cases.toml` in the folder lists the cases; each runs in a folder of its own. The test compares structure exactly and numbers as closely
//! as machines with other instruction sets agree. `just goldens` writes the kept outputs again, and `git diff` then shows every byte
//! that has changed: that is the comparison before and after a change that means to change nothing, on one machine.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use super::repository;

/// `write`: the outputs are kept instead of compared. `all`: long cases too.
const MODE: &str = "STIFFBENCH_GOLDENS";

/// Relative difference of two numbers that counts as none. AVX-512 and AVX2 round sums otherwise; a search that stops where nothing decisive is
/// left to gain then stops elsewhere, by up to 3e-3 of a variance or of a share in the kept outputs.
const RELATIVE: f64 = 5e-3;

/// Absolute difference that counts as none: the rounding of a sum that is zero, in SI.
const ABSOLUTE: f64 = 1e-15;

/// A longer file is kept as its size, its hash and this many bytes from its start and its end.
const LONG_BYTES: usize = 24_000;
const END_BYTES: usize = 2_000;

/// Stands for what is left out of a longer file.
const CUT: &str = "[...]";

/// A line with this start belongs to the comparison of bytes only.
const HASH: &str = "sha256 ";

/// A case: commands that run one after the other in an empty folder.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Case {
    /// Arguments of the program, separated by blanks; `DATA` is the repository's `data`, `< FILE` gives a file as input.
    run: Vec<String>,
    /// Files of the repository that are copied into the folder first.
    #[serde(default)]
    with: Vec<String>,
    /// Files and folders that are not kept.
    #[serde(default)]
    without: Vec<String>,
    /// Lines that contain one of these are not kept: how long something took.
    #[serde(default)]
    without_lines: Vec<String>,
    /// Lines that contain one of these differ from machine to machine: what is compared is that they are there.
    #[serde(default)]
    of_machine: Vec<String>,
    /// Only what is printed is kept, no file.
    #[serde(default)]
    printed_only: bool,
    /// Emulated gauges and the clock at hand took part: times are masked.
    #[serde(default)]
    timed: bool,
    /// It takes long: run only where the mode states it.
    #[serde(default)]
    long: bool,
}

/// A program and the folder with what it is known to give.
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
    /// Runs every case and compares, or keeps the outputs where the mode states it.
    ///
    /// # Panics
    /// With all differences.
    pub fn check(&self) {
        let text = fs::read_to_string(self.folder().join("cases.toml")).unwrap();
        let cases: BTreeMap<String, Case> = toml::from_str(&text).unwrap();
        let mode = std::env::var(MODE).unwrap_or_default();
        let write = mode == "write";
        let chosen: Vec<_> = cases
            .iter()
            .filter(|(_, case)| !case.long || !mode.is_empty())
            .collect();
        let judge = |(name, case): &(&String, &Case)| {
            let outputs = self.outputs(case);
            if write {
                self.keep(name, &outputs);
                return Vec::new();
            }
            self.complaints(name, case, &outputs)
        };
        let complaints: Vec<String> = chosen.par_iter().flat_map_iter(judge).collect();
        assert!(
            complaints.is_empty(),
            "\n{}\nIf the change is meant: just goldens, and say why in the commit.",
            complaints.join("\n")
        );
    }

    fn folder(&self) -> PathBuf {
        repository().join(self.folder)
    }

    /// All outputs of a case by the name of the file that keeps them.
    fn outputs(&self, case: &Case) -> BTreeMap<String, String> {
        let folder = TempDir::new().unwrap();
        // A name without a link in it, as the program prints it.
        let desk = folder.path().canonicalize().unwrap();
        for file in &case.with {
            let source = repository().join(file);
            copy(&source, &desk.join(source.file_name().unwrap()));
        }
        let given = files(&desk);
        let mut printed = String::new();
        for line in &case.run {
            let (words, input) = words(line);
            let mut command = Command::new(self.program);
            let data = repository().join("data");
            let word = |word: &str| word.replace("DATA", data.to_str().unwrap());
            command
                .env_remove(MODE)
                .current_dir(&desk)
                .args(words.into_iter().map(word));
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
        let mask = Mask {
            desk: desk.to_str().unwrap(),
            commit: self.commit,
            case,
        };
        let mut outputs = BTreeMap::from([("printed.txt".to_owned(), mask.applied(&printed))]);
        if case.printed_only {
            return outputs;
        }
        for path in files(&desk)
            .into_iter()
            .filter(|path| !given.contains(path))
        {
            if case.without.iter().any(|without| path.contains(without)) {
                continue;
            }
            let bytes = fs::read(desk.join(&path)).unwrap();
            outputs.insert(format!("{path}.golden"), kept(&bytes, &mask));
        }
        outputs
    }

    /// Keeps the outputs of a case in place of those that were kept.
    fn keep(&self, name: &str, outputs: &BTreeMap<String, String>) {
        let folder = self.folder().join(name);
        if folder.exists() {
            fs::remove_dir_all(&folder).unwrap();
        }
        for (file, text) in outputs {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }

    /// Where the outputs of a case differ from those that are kept.
    fn complaints(
        &self,
        name: &str,
        case: &Case,
        outputs: &BTreeMap<String, String>,
    ) -> Vec<String> {
        let folder = self.folder().join(name);
        let mut kept = files(&folder);
        kept.retain(|file| !outputs.contains_key(file));
        let mut complaints: Vec<String> = kept
            .iter()
            .map(|file| format!("{name}/{file}: no longer written"))
            .collect();
        for (file, now) in outputs {
            match fs::read_to_string(folder.join(file)) {
                Err(_) => complaints.push(format!("{name}/{file}: nothing is kept")),
                Ok(golden) => complaints.extend(
                    difference(&golden, now, &case.of_machine)
                        .map(|difference| format!("{name}/{file}: {difference}")),
                ),
            }
        }
        complaints
    }
}

/// The words of a command line, and the file of the repository that is its input.
fn words(line: &str) -> (Vec<&str>, Option<&str>) {
    let (line, input) = match line.split_once(" < ") {
        Some((line, input)) => (line, Some(input.trim())),
        None => (line, None),
    };
    (line.split_whitespace().collect(), input)
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

/// All files below a folder, as paths from it.
fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let path = path.strip_prefix(folder).unwrap();
                found.push(path.to_str().unwrap().to_owned());
            }
        }
    }
    found
}

/// A file in the form that is kept.
fn kept(bytes: &[u8], mask: &Mask) -> String {
    let hash = |bytes: &[u8]| {
        let digest = Sha256::digest(bytes);
        digest.iter().fold(String::from(HASH), |mut text, byte| {
            write!(text, "{byte:02x}").unwrap();
            text
        })
    };
    if let Some(png) = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n") {
        let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        return format!("PNG {} x {}\n{}\n", side(8), side(12), hash(bytes));
    }
    let Ok(text) = std::str::from_utf8(bytes) else {
        return format!("{} bytes\n{}\n", bytes.len(), hash(bytes));
    };
    let text = mask.applied(text);
    if text.len() <= LONG_BYTES {
        return text;
    }
    let cut = |at: usize| {
        (0..=at)
            .rev()
            .find(|at| text.is_char_boundary(*at))
            .unwrap()
    };
    let (head, tail) = (cut(END_BYTES), cut(text.len() - END_BYTES));
    format!(
        "{} lines\n{}\n{}\n{CUT}\n{}",
        text.lines().count(),
        hash(text.as_bytes()),
        &text[..head],
        &text[tail..]
    )
}

/// What differs from run to run and from machine to machine: paths, version, and times where there is a clock.
struct Mask<'a> {
    desk: &'a str,
    commit: &'a str,
    case: &'a Case,
}

impl Mask<'_> {
    fn applied(&self, text: &str) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let commit = self.commit;
        let printed = if commit.is_empty() {
            "not recorded"
        } else {
            commit
        };
        let mut text = text
            .replace(&format!("{version} ({commit})"), version)
            .replace(&format!("commit {printed}"), "commit COMMIT")
            .replace(self.desk, "DESK")
            .replace(repository().to_str().unwrap(), "REPOSITORY")
            .replace(&format!("stiffbench {version}"), "stiffbench VERSION")
            .replace(
                &format!("stiffbench-validate {version}"),
                "stiffbench-validate VERSION",
            );
        for colon in [":", ": "] {
            for (key, value) in [("version", version), ("commit", commit)] {
                text = text.replace(
                    &format!("\"{key}\"{colon}\"{value}\""),
                    &format!("\"{key}\"{colon}\"{}\"", key.to_uppercase()),
                );
            }
        }
        if !self.case.without_lines.is_empty() {
            let out = |line: &&str| {
                self.case
                    .without_lines
                    .iter()
                    .any(|part| line.contains(part))
            };
            text = text
                .lines()
                .filter(|line| !out(line))
                .collect::<Vec<_>>()
                .join("\n");
        }
        if self.case.timed {
            text = without_time_columns(&without_hashes(&without_stamps(&text)));
        }
        text
    }
}

/// A text whose time stamps (`2026-11-22T04:31:26.9Z`, `20261122T043125Z`) are masked.
fn without_stamps(text: &str) -> String {
    let is_stamp = |word: &str| {
        word.len() >= 16
            && word.ends_with('Z')
            && word.contains('T')
            && word.starts_with("20")
            && word[..8]
                .bytes()
                .all(|byte| byte.is_ascii_digit() || byte == b'-')
    };
    let part = |c: char| c.is_ascii_digit() || matches!(c, 'T' | 'Z' | ':' | '.' | '-');
    let (mut masked, mut rest) = (String::new(), text);
    while let Some(start) = rest.find("20") {
        let length = rest[start..]
            .find(|c| !part(c))
            .unwrap_or(rest.len() - start);
        let word = &rest[start..start + length];
        masked += &rest[..start];
        masked += if is_stamp(word) { "TIME" } else { word };
        rest = &rest[start + length..];
    }
    masked + rest
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

/// A table of readings whose columns of elapsed times are masked; any other text as it is.
fn without_time_columns(text: &str) -> String {
    if !text.starts_with("session,seq,utc,t_s,") {
        return text.to_owned();
    }
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let mut masked = String::new();
    for (row, line) in text.lines().enumerate() {
        let values = line.split(',').zip(&names).map(|(value, name)| {
            let time = row > 0 && ["t_s", "hold_s"].contains(name);
            if time { "T" } else { value }
        });
        masked += &values.collect::<Vec<_>>().join(",");
        masked.push('\n');
    }
    masked
}

/// Where two texts differ in more than the last digits of their numbers; `None` if nowhere.
fn difference(golden: &str, now: &str, of_machine: &[String]) -> Option<String> {
    let ([old_start, old_end], [new_start, new_end]) = (ends(golden), ends(now));
    // Where a long file is cut depends on the lengths of its numbers.
    let starts = old_start.len().min(new_start.len());
    let both = old_end.len().min(new_end.len());
    let end_of = |lines: &[&str]| lines[lines.len() - both..].join("\n");
    if old_end.is_empty() || new_end.is_empty() {
        return first_difference(golden, now, of_machine);
    }
    let starts = [&old_start, &new_start].map(|lines| lines[..starts].join("\n"));
    let ends = [&old_end, &new_end].map(|lines| end_of(lines));
    first_difference(&starts[0], &starts[1], of_machine)
        .or_else(|| first_difference(&ends[0], &ends[1], of_machine))
}

/// The whole lines at the start and at the end of a long file, as [`kept`] has it; all lines of another, and no end.
fn ends(text: &str) -> [Vec<&str>; 2] {
    let lines: Vec<&str> = text.lines().collect();
    match lines.iter().position(|line| *line == CUT) {
        Some(cut) => [
            lines[..cut.saturating_sub(1)].to_vec(),
            lines[lines.len().min(cut + 2)..].to_vec(),
        ],
        None => [lines, Vec::new()],
    }
}

fn first_difference(golden: &str, now: &str, of_machine: &[String]) -> Option<String> {
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
    if old == new || (old.starts_with(HASH) && new.starts_with(HASH)) {
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
        let long = |start: &str, end: &str| format!("90 lines\n{start}\ncu\n{CUT}\nt\n{end}");
        assert_eq!(
            difference(&long("a\nb", "y\nz"), &long("a", "x\ny\nz"), &[]),
            None
        );
        assert!(difference(&long("a\nb", "y\nz"), &long("a\nb", "y\nw"), &[]).is_some());
        assert!(difference(&long("a\nb", "y"), &long("a\nc", "y"), &[]).is_some());
    }
}
