//! What may know of what: the table of imports, and who prints, reads the clock and opens files.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

use std::fs;
use std::path::{Path, PathBuf};

/// Each module of `src` and the modules it may import; its own paths are always open to it. `cli` may import everything.
#[rustfmt::skip]
const MAY_IMPORT: [(&str, &[&str]); 27] = [
    ("statistics", &[]),
    ("source_text", &[]),
    ("nearest", &[]),
    ("vector", &[]),
    ("clock", &[]),
    ("quantity", &["statistics"]),
    ("test_point", &["quantity"]),
    ("readings", &["quantity", "test_point", "nearest"]),
    ("specimen", &["quantity", "test_point", "nearest", "readings"]),
    ("procedure", &["source_text", "nearest", "test_point", "readings"]),
    ("instrument", &["clock", "source_text", "nearest", "quantity"]),
    ("stiffness", &["quantity", "statistics", "test_point", "readings"]),
    ("session", &["clock", "nearest", "quantity", "test_point", "readings", "procedure", "instrument", "stiffness"]),
    ("lanes", &[]),
    ("structure", &["lanes", "vector"]),
    ("reference", &["structure"]),
    ("robot", &["source_text", "nearest", "lanes", "vector", "test_point", "structure"]),
    ("physics", &["source_text", "nearest", "lanes", "vector", "test_point", "structure", "robot"]),
    ("bench", &["clock", "test_point", "readings", "procedure", "robot", "physics"]),
    ("least_squares", &["statistics", "lanes"]),
    ("fit", &["quantity", "statistics", "test_point", "readings", "stiffness", "structure", "robot", "physics", "least_squares"]),
    ("mismatch", &["statistics", "lanes", "vector", "test_point", "readings", "procedure", "specimen", "structure", "robot", "physics", "least_squares"]),
    ("prove", &["statistics", "source_text", "test_point", "readings", "specimen", "robot", "physics", "least_squares", "mismatch"]),
    ("distribution", &["statistics", "source_text", "vector", "test_point", "structure", "robot", "physics"]),
    ("plot", &["quantity", "vector", "test_point"]),
    (
        "report",
        &[
            "quantity", "test_point", "readings", "specimen", "stiffness", "structure", "reference", "robot", "physics", "least_squares", "fit", "mismatch",
            "prove", "distribution", "plot",
        ],
    ),
    ("cli", EVERYTHING),
];

#[rustfmt::skip]
const EVERYTHING: &[&str] = &[
    "quantity", "statistics", "source_text", "nearest", "lanes", "vector", "clock", "test_point", "readings", "specimen", "procedure", "instrument",
    "session", "stiffness",
    "structure", "reference", "robot", "physics", "bench", "least_squares", "fit", "mismatch", "prove", "distribution", "plot", "report",
];

/// Who outside `cli` may do some of that, and why it must.
#[rustfmt::skip]
const EXCEPTIONS: &[(&str, &[&str])] = &[
    // The one clock.
    ("clock.rs", &["Instant::now", "SystemTime"]),
    // The journal, its lock and the live table.
    ("session/folder.rs", &["std::fs", "File::", "OpenOptions"]),
    // What the system knows of its ports is in files (sysfs, /dev, /proc), and a port that settles or is busy is waited for.
    ("instrument/port/", &["std::fs", "thread::sleep"]),
    // A replay at the pace of a clock waits as the gauge did.
    ("instrument/trace/replay.rs", &["thread::sleep"]),
    // The far end of an emulated line is the outside world: it makes the link by which a port is found, and takes it away when the cable is pulled.
    ("instrument/emulator/served.rs", &["std::fs"]),
];

/// What only `cli` may do: print, read the clock, wait, open files.
#[rustfmt::skip]
const ONLY_CLI: [&str; 16] = [
    "print!", "println!", "eprint!", "eprintln!", "dbg!", "stdout()", "stderr()", "stdin()", "Instant::now", "SystemTime",
    "Timestamp::now", "Zoned::now", "thread::sleep", "std::fs", "File::", "OpenOptions",
];

/// Folders and files that documentation and checks rely on.
#[rustfmt::skip]
const TOP_LEVEL: [&str; 20] = [
    "Cargo.toml", "Cargo.lock", "README.md", "justfile", ".ci/run", "src/lib.rs", "src/main.rs", "tests", "fixtures", "fuzz", "benches",
    "data/robots", "data/paper", "data/sessions", "data/fonts", "data/recordings", "data/concealed",
    "protocols/procedures", "protocols/instruments", "fixtures/instruments",
];

/// Lines above which a file of `src` is to be split.
const LONGEST_FILE: usize = 500;

/// A source file with its module and its lines that are not comments.
struct Source {
    path: PathBuf,
    module: String,
    text: String,
}

impl Source {
    /// Whether this file is excepted from what only `cli` may do.
    fn may(&self, deed: &str) -> bool {
        let path = self.path.to_string_lossy();
        let mut exceptions = EXCEPTIONS.iter();
        exceptions
            .any(|(part, deeds)| path.contains(&format!("src/{part}")) && deeds.contains(&deed))
    }

    fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.text.lines().enumerate().map(|(i, line)| (i + 1, line));
        lines.filter(|(_, line)| !line.trim_start().starts_with("//"))
    }

    /// The lines before the unit tests, which stand at the end of a file or in a file of their own.
    fn code_without_tests(&self) -> impl Iterator<Item = (usize, &str)> {
        let of_tests = self.path.to_string_lossy().ends_with("tests.rs");
        self.code()
            .take_while(move |(_, line)| !of_tests && !line.starts_with("#[cfg(test)]"))
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All source files of modules; `lib.rs` and `main.rs` only tie them together.
fn sources() -> Vec<Source> {
    let src = root().join("src");
    let mut folders = vec![src.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let module = path.strip_prefix(&src).unwrap().with_extension("");
            let module = module.iter().next().unwrap().to_str().unwrap().to_owned();
            if !["lib", "main"].contains(&module.as_str()) {
                let text = fs::read_to_string(&path).unwrap();
                found.push(Source { path, module, text });
            }
        }
    }
    found
}

/// The words that follow `start` in a line, where it does not continue another word.
fn after<'a>(line: &'a str, start: &'a str) -> impl Iterator<Item = &'a str> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(start)
        .filter(move |(at, _)| !line[..*at].ends_with(is_word))
        .map(move |(at, _)| {
            let rest = &line[at + start.len()..];
            &rest[..rest.find(|c| !is_word(c)).unwrap_or(rest.len())]
        })
}

fn assert_none(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn modules_import_only_what_the_table_allows() {
    let mut complaints = Vec::new();
    for source in sources() {
        let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == source.module) else {
            complaints.push(format!("{} has no row in the table", source.path.display()));
            continue;
        };
        for (number, line) in source.code() {
            let place = format!("{}:{number}", source.path.display());
            for module in after(line, "crate::") {
                if module != source.module && !allowed.contains(&module) {
                    complaints.push(format!(
                        "{place}: {} must not know of `{module}`",
                        source.module
                    ));
                }
            }
            if line.contains("super::super") {
                complaints.push(format!("{place}: `super::super` walks around the table"));
            }
        }
    }
    assert_none(&complaints);
}

#[test]
fn every_row_of_the_table_is_a_module_and_below_those_that_import_it() {
    let modules: Vec<String> = sources().into_iter().map(|source| source.module).collect();
    for (place, (name, imports)) in MAY_IMPORT.iter().enumerate() {
        assert!(
            modules.iter().any(|module| module == name),
            "{name} is no module"
        );
        for import in *imports {
            let below = MAY_IMPORT[..place].iter().any(|(known, _)| known == import);
            assert!(
                below,
                "{name} imports {import}, which does not stand above it in the table"
            );
        }
    }
}

#[test]
fn only_cli_prints_reads_the_clock_and_opens_files() {
    let mut complaints = Vec::new();
    for source in sources().iter().filter(|source| source.module != "cli") {
        for (number, line) in source.code_without_tests() {
            for deed in ONLY_CLI
                .iter()
                .filter(|deed| after(line, deed).next().is_some() && !source.may(deed))
            {
                complaints.push(format!(
                    "{}:{number}: only cli may use `{deed}`",
                    source.path.display()
                ));
            }
        }
    }
    assert_none(&complaints);
}

#[test]
fn no_source_file_has_grown_too_long() {
    let long = sources().into_iter().filter_map(|source| {
        let lines = source.text.lines().count();
        (lines > LONGEST_FILE).then(|| format!("{}: {lines} lines", source.path.display()))
    });
    assert_none(&long.collect::<Vec<_>>());
}

#[test]
fn folders_and_files_that_others_rely_on_exist() {
    let missing = TOP_LEVEL.iter().filter(|name| !root().join(name).exists());
    assert_none(
        &missing
            .map(|name| format!("{name} is missing"))
            .collect::<Vec<_>>(),
    );
}
