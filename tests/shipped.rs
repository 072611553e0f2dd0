//! What the program embeds is what lies in `data` and `protocols`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use stiffbench::shipped::{
    DEFAULT_PROCEDURE, shipped_instruments, shipped_procedure, shipped_procedures, shipped_robot,
    shipped_robots,
};

/// The TOML files of a folder: name and text.
fn folder(path: &str) -> BTreeMap<String, String> {
    let entries = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let toml = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    toml.map(|path| {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        (name, fs::read_to_string(path).unwrap())
    })
    .collect()
}

fn embedded<'a>(files: impl Iterator<Item = (&'a str, String)>) -> BTreeMap<String, String> {
    files.map(|(name, text)| (name.to_owned(), text)).collect()
}

#[test]
fn the_shipped_procedures_are_those_in_the_folder() {
    let text = |name: &str| shipped_procedure(name).unwrap().text;
    let shipped = embedded(shipped_procedures().map(|name| (name, text(name))));
    assert_eq!(shipped, folder("protocols/procedures"));
    assert!(shipped.contains_key(DEFAULT_PROCEDURE));
    assert!(shipped_procedure("nope").is_none());
}

#[test]
fn the_shipped_descriptions_are_those_in_the_folder() {
    let shipped = shipped_instruments().iter();
    let shipped = embedded(shipped.map(|shipped| (shipped.name, shipped.text.to_owned())));
    assert_eq!(shipped, folder("protocols/instruments"));
}

#[test]
fn the_shipped_robots_are_those_in_the_folder() {
    let text = |name: &str| shipped_robot(name).unwrap().text;
    let shipped = embedded(shipped_robots().map(|name| (name, text(name))));
    assert_eq!(shipped, folder("data/robots"));
    assert!(shipped_robot("nope").is_none());
}
