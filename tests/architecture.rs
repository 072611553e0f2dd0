//! What may know of what inside a crate, what a crate may need, and who prints, reads the clock and opens files.
//!
//! Which crate may know of which is held by their `Cargo.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Modules of crates with several, and which of their siblings they may import.
#[rustfmt::skip]
const MAY_IMPORT: &[(&str, &str, &[&str])] = &[
    ("src", "shipped", &["EVERY CRATE"]),
    ("src", "analysis", &["EVERY CRATE", "shipped"]),
    ("src", "export", &["EVERY CRATE", "analysis"]),
    ("src", "report", &["EVERY CRATE", "shipped", "analysis", "export"]),
    ("src", "cli", &["EVERY CRATE", "report", "shipped", "analysis", "export"]),
    ("crates/numeric/src", "vector", &[]),
    ("crates/numeric/src", "simd", &[]),
    ("crates/numeric/src", "statistics", &[]),
    ("crates/numeric/src", "reported", &["statistics"]),
    ("crates/numeric/src", "least_squares", &["statistics", "simd"]),
    ("crates/units-and-text/src", "clock", &[]),
    ("crates/units-and-text/src", "count", &[]),
    ("crates/units-and-text/src", "digits", &[]),
    ("crates/units-and-text/src", "nearest", &[]),
    ("crates/units-and-text/src", "source_text", &[]),
    ("crates/units-and-text/src", "quantity", &[]),
    ("crates/units-and-text/src", "test_point", &["quantity"]),
    ("crates/units-and-text/src", "read_axis", &["test_point"]),
    ("crates/units-and-text/src", "load_direction", &["test_point", "nearest"]),
    ("crates/units-and-text/src", "toml_text", &["source_text", "nearest", "quantity"]),
    ("crates/beams/src", "structure", &[]),
    ("crates/beams/src", "robot", &["structure"]),
    ("crates/beams/src", "physics", &["structure", "robot"]),
    ("crates/measurement/src", "readings", &[]),
    ("crates/measurement/src", "table_files", &["readings"]),
    ("crates/measurement/src", "load_cases", &["readings", "table_files"]),
    ("crates/measurement/src", "specimen", &["readings", "table_files"]),
    ("crates/measurement/src", "import", &["readings", "table_files", "load_cases", "specimen"]),
    ("crates/measurement/src", "calibration", &["readings", "table_files"]),
    ("crates/measurement/src", "procedure", &["readings"]),
    ("crates/measurement/src", "run_check", &["procedure"]),
    ("crates/measurement/src", "stiffness", &["readings"]),
    ("crates/measurement/src", "stiffness_list", &["readings"]),
    ("crates/diagnosis/src", "search", &[]),
    ("crates/diagnosis/src", "parameters", &["search"]),
    ("crates/diagnosis/src", "mismatch", &["search", "parameters"]),
    ("crates/diagnosis/src", "fit", &["search", "parameters", "mismatch"]),
    ("crates/diagnosis/src", "distribution", &[]),
    ("crates/validation/src", "prove", &[]),
    ("crates/validation/src", "reference", &[]),
    ("crates/validation/src", "report", &["prove", "reference"]),
    ("crates/validation/src", "cli", &["prove", "reference", "report"]),
];

/// What stands for the modules that the root package takes from its crates.
const EVERY_CRATE: &str = "EVERY CRATE";

/// The module of what the unit tests of a crate share.
const SHARED_BY_TESTS: &str = "tests";

/// Crates that others may want alone, with what they must do without.
#[rustfmt::skip]
const ALONE: &[(&str, &[&str])] = &[
    ("stiffbench-beams", &["ratatui", "crossterm", "clap", "plotters", "resvg", "tokio", "serialport", "owo-colors"]),
    ("stiffbench-gauges", &["ratatui", "crossterm", "clap", "plotters", "resvg", "tokio", "serialport", "owo-colors", "nalgebra", "faer"]),
];

/// Who outside `cli` may do some of that, and why it must.
#[rustfmt::skip]
const EXCEPTIONS: &[(&str, &[&str])] = &[
    // The one clock.
    ("crates/units-and-text/src/clock.rs", &["Instant::now", "SystemTime"]),
    // The files that a user names.
    ("src/analysis/files.rs", &["std::fs", "stdin()", "File::"]),
    // The journal, its lock and the live table.
    ("crates/session/src/folder.rs", &["std::fs", "File::", "OpenOptions"]),
    ("crates/session/src/lock.rs", &["std::fs", "File::", "OpenOptions"]),
    // Every file of a session folder is opened by it, so that no link is followed.
    ("crates/session/src/inside.rs", &["std::fs", "OpenOptions"]),
    ("crates/session/src/whole_file.rs", &["std::fs", "File::"]),
    // What the system knows of its ports is in files (sysfs, /dev, /proc), and a port that settles or is busy is waited for.
    ("crates/gauges/src/port/", &["std::fs", "thread::sleep"]),
    // A replay at the pace of a clock waits as the gauge did.
    ("crates/gauges/src/trace/replay.rs", &["thread::sleep"]),
    // The far end of an emulated line is the outside world: it makes the link by which a port is found, and takes it away when the cable is pulled.
    ("crates/gauges/src/emulator/served.rs", &["std::fs"]),
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
    "data/robots", "data/paper", "data/sessions", "crates", "data/recordings", "data/concealed",
    "protocols/procedures", "protocols/instruments", "fixtures/instruments",
];

/// A source file with its crate, its module and its lines.
pub(super) struct Source {
    pub(super) path: PathBuf,
    /// Folder of the sources of its crate, from the root.
    pub(super) folder: String,
    module: String,
    pub(super) text: String,
}

impl Source {
    /// Whether this file is excepted from what only `cli` may do.
    fn may(&self, action: &str) -> bool {
        let path = self.path.to_string_lossy();
        let mut exceptions = EXCEPTIONS.iter();
        exceptions.any(|(part, actions)| path.contains(part) && actions.contains(&action))
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

/// The source folders: of the program, and of each crate.
fn source_folders() -> Vec<String> {
    let crates = fs::read_dir(root().join("crates")).unwrap();
    let names = crates.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut folders: Vec<String> = names.map(|name| format!("crates/{name}/src")).collect();
    folders.sort();
    folders.insert(0, "src".to_owned());
    folders
}

/// All source files; the module of a file that ties others together (`lib.rs`) is its own name.
pub(super) fn sources() -> Vec<Source> {
    let mut found = Vec::new();
    for folder in source_folders() {
        let src = root().join(&folder);
        let mut open = vec![src.clone()];
        while let Some(next) = open.pop() {
            for entry in fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    open.push(path);
                    continue;
                }
                let module = path.strip_prefix(&src).unwrap().with_extension("");
                let module = module.iter().next().unwrap().to_str().unwrap().to_owned();
                let text = fs::read_to_string(&path).unwrap();
                found.push(Source {
                    path,
                    folder: folder.clone(),
                    module,
                    text,
                });
            }
        }
    }
    assert!(found.len() > 500, "only {} source files", found.len());
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
    let row = |folder: &str, module: &str| {
        let mut rows = MAY_IMPORT.iter();
        rows.find(|(of, name, _)| (*of, *name) == (folder, module))
    };
    for source in sources() {
        let place = |number| format!("{}:{number}", source.path.display());
        for (number, line) in source.code() {
            if line.contains("super::super") {
                let place = place(number);
                complaints.push(format!("{place}: `super::super` walks around the table"));
            }
        }
        // The table names the crates that have several modules side by side.
        if ["lib", "main", SHARED_BY_TESTS].contains(&source.module.as_str())
            || !MAY_IMPORT.iter().any(|(of, ..)| *of == source.folder)
        {
            continue;
        }
        let Some((_, _, allowed)) = row(&source.folder, &source.module) else {
            complaints.push(format!("{} has no row in the table", source.path.display()));
            continue;
        };
        for (number, line) in source.code() {
            for module in after(line, "crate::") {
                let from_crate = row(&source.folder, module).is_none();
                let allowed = allowed.contains(&module)
                    || (from_crate && allowed.contains(&EVERY_CRATE))
                    || [source.module.as_str(), SHARED_BY_TESTS].contains(&module);
                if !allowed {
                    let place = place(number);
                    let name = &source.module;
                    complaints.push(format!("{place}: {name} must not know of `{module}`"));
                }
            }
        }
    }
    assert_none(&complaints);
}

/// Crates whose files import each other in one direction, but for a few that belong together.
const IN_ONE_DIRECTION: [&str; 3] = [
    "crates/beams/src",
    "crates/diagnosis/src",
    "crates/measurement/src",
];

/// Most files that may import each other in a circle.
const LARGEST_CIRCLE: usize = 3;

/// A path of names, or of modules from `src`.
type ItemPath = Vec<String>;

/// What a file imports.
#[derive(Default)]
struct Imports {
    file: String,
    /// Where each imported name comes from.
    names: BTreeMap<String, ItemPath>,
    /// What it takes for itself: imports that are no re-exports, and paths in its code.
    taken: Vec<ItemPath>,
}

/// The files of a crate without tests, by their modules.
fn files_of(folder: &str) -> BTreeMap<ItemPath, Imports> {
    let mut found = BTreeMap::new();
    for source in sources().iter().filter(|source| source.folder == folder) {
        let file = source.path.strip_prefix(root().join(folder)).unwrap();
        let module = file.with_extension("");
        let parts = module.iter().map(|part| part.to_str().unwrap());
        let parts = parts.filter(|part| !["lib", "mod"].contains(part));
        let module: ItemPath = parts.map(str::to_owned).collect();
        if module.iter().any(|part| part.ends_with("tests")) {
            continue;
        }
        let mut imports = Imports {
            file: file.display().to_string(),
            ..Imports::default()
        };
        let mut lines = source.text.lines();
        while let Some(line) = lines.next() {
            // What follows is one declaration, or the unit tests at the end.
            if line.starts_with("#[cfg(test)]") {
                match lines.next() {
                    Some(declared) if declared.ends_with(';') => continue,
                    _ => break,
                }
            }
            let mut line = line.split("//").next().unwrap_or_default().to_owned();
            let at = line
                .find("use ")
                .filter(|at| *at == 0 || line.starts_with("pub"));
            let Some(at) = at else {
                let is_path = |sign: char| sign.is_alphanumeric() || "_:".contains(sign);
                let words = line.split(|sign| !is_path(sign));
                let paths = words.filter(|word| word.contains("::"));
                let paths = paths.map(|word| word.split("::").map(str::to_owned).collect());
                imports.taken.extend(paths);
                continue;
            };
            while !line.ends_with(';') {
                line.push_str(lines.next().unwrap_or(";"));
            }
            let mut paths = Vec::new();
            expand(&line[at + 4..line.len() - 1], &[], &mut paths);
            let named = paths
                .iter()
                .filter_map(|path| Some((path.last()?.clone(), path.clone())));
            imports.names.extend(named);
            imports.taken.extend(paths.into_iter().filter(|_| at == 0));
        }
        found.insert(module, imports);
    }
    found
}

/// The paths that a `use` lists.
fn expand(tree: &str, before: &[String], out: &mut Vec<ItemPath>) {
    let mut depth = 0;
    let parts = tree.split(|sign: char| {
        depth += i32::from(sign == '{') - i32::from(sign == '}');
        sign == ',' && depth == 0
    });
    for part in parts.filter(|part| !part.trim().is_empty()) {
        let (head, inner) = part.split_once('{').unwrap_or((part, ""));
        let head = head.split(" as ").next().unwrap_or_default().trim();
        let own = head.split("::").filter(|own| !["", "self"].contains(own));
        let path: ItemPath = before
            .iter()
            .cloned()
            .chain(own.map(str::to_owned))
            .collect();
        match inner.rsplit_once('}') {
            Some((inner, _)) => expand(inner, &path, out),
            None => out.push(path),
        }
    }
}

/// The module that defines what a path of another names, through all re-exports; `None` outside the crate, and of a folder.
fn defining(
    files: &BTreeMap<ItemPath, Imports>,
    from: &[String],
    path: &[String],
) -> Option<ItemPath> {
    let supers = path.iter().take_while(|part| *part == "super").count();
    let mut at = from[..from.len().checked_sub(supers)?].to_vec();
    let mut rest = &path[supers..];
    if path.first()? == "crate" {
        (at, rest) = (Vec::new(), &path[1..]);
    } else if supers == 0 && !files.contains_key(&[from, &path[..1]].concat()) {
        return None;
    }
    while let Some((part, others)) = rest.split_first() {
        let below = [&at[..], std::slice::from_ref(part)].concat();
        if files.contains_key(&below) {
            (at, rest) = (below, others);
            continue;
        }
        return match files[&at].names.get(part) {
            Some(known) => defining(files, &at, &[known, others].concat()),
            None => Some(at),
        };
    }
    (!files.get(&at)?.file.ends_with("mod.rs")).then_some(at)
}

/// The names that each file takes from each other.
fn ties(files: &BTreeMap<ItemPath, Imports>) -> BTreeMap<(&str, &str), BTreeSet<&str>> {
    let mut ties: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
    for (module, imports) in files {
        for path in &imports.taken {
            if let Some(of) = defining(files, module, path).filter(|of| of != module) {
                let pair = (imports.file.as_str(), files[&of].file.as_str());
                ties.entry(pair)
                    .or_default()
                    .extend(path.last().map(String::as_str));
            }
        }
    }
    ties
}

#[test]
fn files_import_each_other_in_one_direction() {
    let mut complaints = Vec::new();
    for folder in IN_ONE_DIRECTION {
        let files = files_of(folder);
        let ties = ties(&files);
        let mut reached: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for imports in files.values() {
            let file = imports.file.as_str();
            let (beyond, mut open) = (reached.entry(file).or_default(), vec![file]);
            while let Some(next) = open.pop() {
                let taken = ties.keys().filter(|(of, _)| *of == next);
                open.extend(taken.map(|(_, to)| *to).filter(|to| beyond.insert(*to)));
            }
        }
        let circle_of = |file: &&str| -> Vec<&str> {
            let back = reached[file]
                .iter()
                .filter(|other| reached[*other].contains(file));
            back.copied().collect()
        };
        let circles: BTreeSet<Vec<&str>> = reached.keys().map(circle_of).collect();
        for circle in circles
            .iter()
            .filter(|circle| circle.len() > LARGEST_CIRCLE)
        {
            let (count, list) = (circle.len(), circle.join(", "));
            complaints.push(format!("{folder}: {count} files import each other: {list}"));
            // The thinnest tie first: it is most likely the one too many.
            let is_inside = |(of, to): &(&str, &str)| circle.contains(of) && circle.contains(to);
            let mut inside: Vec<_> = ties.iter().filter(|(pair, _)| is_inside(pair)).collect();
            inside.sort_by_key(|(_, names)| names.len());
            for ((of, to), names) in inside {
                let names: Vec<&str> = names.iter().copied().collect();
                complaints.push(format!("    {of} takes {} from {to}", names.join(", ")));
            }
        }
    }
    assert_none(&complaints);
}

/// The rooms of `mismatch`: each may import those before it.
const ROOMS: [&str; 10] = [
    "observed",
    "baselines",
    "noise",
    "problem",
    "screen",
    "hold_out",
    "unexplained",
    "candidates",
    "verdict",
    "design",
];

#[test]
fn rooms_import_only_those_before_them() {
    let files = files_of("crates/diagnosis/src");
    let place = |file: &str| {
        let room = file.strip_prefix("mismatch/")?.split_once('/')?.0;
        let place = ROOMS.iter().position(|known| *known == room);
        Some(place.unwrap_or_else(|| panic!("{room} is no room of the table")))
    };
    let ties = ties(&files);
    let upward = ties
        .iter()
        .filter(|((of, to), _)| place(to).is_some() && place(of) < place(to));
    let upward = upward.filter(|((of, _), _)| place(of).is_some());
    let complaints = upward.map(|((of, to), names)| {
        let names: Vec<&str> = names.iter().copied().collect();
        format!("{of} must not take {} from {to}", names.join(", "))
    });
    assert_none(&complaints.collect::<Vec<_>>());
}

/// Words of the problems that the search core serves: it knows rows and columns only.
#[rustfmt::skip]
const NOT_IN_SEARCH: [&str; 9] = [
    "reading", "run", "repeat", "gauge", "pose", "cell", "law", "robot", "session",
];

#[test]
fn the_search_core_knows_no_measurement() {
    let mut complaints = Vec::new();
    for source in sources() {
        // The one file of numbers holds those of its users too.
        let is_core = source.folder == "crates/diagnosis/src" && source.module == "search";
        if !is_core || source.path.ends_with("constants.rs") {
            continue;
        }
        for (number, line) in source.code() {
            let is_border = |c: char| !c.is_alphanumeric();
            let words = line.split(is_border).map(|word| word.trim_end_matches('s'));
            for word in words.filter(|word| NOT_IN_SEARCH.contains(word)) {
                complaints.push(format!("{}:{number}: {word}", source.path.display()));
            }
        }
    }
    assert_none(&complaints);
}

#[test]
fn every_row_of_the_table_is_a_module_and_below_those_that_import_it() {
    let sources = sources();
    for (place, (folder, name, imports)) in MAY_IMPORT.iter().enumerate() {
        let mut of_folder = sources.iter().filter(|source| source.folder == *folder);
        assert!(
            of_folder.any(|source| source.module == *name),
            "{name} is no module of {folder}"
        );
        for import in imports.iter().filter(|import| **import != EVERY_CRATE) {
            let below = MAY_IMPORT[..place]
                .iter()
                .any(|(of, known, _)| of == folder && known == import);
            assert!(
                below,
                "{name} imports {import}, which does not stand above it in the table"
            );
        }
    }
}

/// The two programs embed files and hand them in.
#[test]
fn no_crate_embeds_a_file_outside_its_folder() {
    let mut complaints = Vec::new();
    for source in sources()
        .iter()
        .filter(|source| !["src", "crates/validation/src"].contains(&source.folder.as_str()))
    {
        let src = root().join(&source.folder);
        let depth = source.path.strip_prefix(&src).unwrap().iter().count();
        for (number, line) in source.code() {
            // The folder of a crate lies one above its sources.
            let up = line.matches("../").count();
            if (line.contains("include_str!") || line.contains("include_bytes!")) && up > depth {
                complaints.push(format!(
                    "{}:{number}: {}",
                    source.path.display(),
                    line.trim()
                ));
            }
        }
    }
    assert_none(&complaints);
}

#[test]
fn beams_and_gauges_can_be_had_alone() {
    for (name, without) in ALONE {
        let arguments = ["tree", "--locked", "--offline", "--no-default-features"];
        let output = Command::new(env!("CARGO"))
            .current_dir(root())
            .args(arguments)
            .args(["--edges", "normal", "--prefix", "none", "--package", name])
            .output()
            .unwrap();
        let tree = String::from_utf8(output.stdout).unwrap();
        assert!(
            tree.starts_with(name),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        for line in tree.lines() {
            let dependency = line.split(' ').next().unwrap();
            assert!(!without.contains(&dependency), "{name} needs {dependency}");
        }
    }
}

fn prints_nothing(source: &Source) -> bool {
    let cli = source.module == "cli"
        && ["src", "crates/validation/src"].contains(&source.folder.as_str());
    !cli && source.folder != "crates/test-files/src"
}

#[test]
fn only_cli_prints_reads_the_clock_and_opens_files() {
    let mut complaints = Vec::new();
    for source in sources().iter().filter(|source| prints_nothing(source)) {
        for (number, line) in source.code_without_tests() {
            for action in ONLY_CLI
                .iter()
                .filter(|action| after(line, action).next().is_some() && !source.may(action))
            {
                complaints.push(format!(
                    "{}:{number}: only cli may use `{action}`",
                    source.path.display()
                ));
            }
        }
    }
    assert_none(&complaints);
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
