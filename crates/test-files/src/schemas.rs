//! The published schemas of results.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

/// How the goldens are kept too.
pub(crate) const MODE: &str = "STIFFBENCH_GOLDENS";

/// Whether what is kept is written instead of compared.
pub(crate) fn are_written() -> bool {
    std::env::var(MODE).is_ok_and(|mode| mode == "write")
}

/// The files of a folder of the repository are these schemas by kind, and no others. Under `STIFFBENCH_GOLDENS=write` they are written.
pub fn are_published(folder: &str, schemas: impl IntoIterator<Item = (&'static str, Value)>) {
    let folder = super::repository().join(folder);
    let write = are_written();
    let mut names = BTreeSet::new();
    for (kind, schema) in schemas {
        let file = folder.join(format!("{kind}.json"));
        let text = format!("{:#}\n", json!(schema));
        if write {
            fs::create_dir_all(&folder).unwrap();
            fs::write(&file, &text).unwrap();
        }
        let published = fs::read_to_string(&file).unwrap_or_default();
        assert!(published == text, "{}: just goldens", file.display());
        names.insert(file);
    }
    let files = fs::read_dir(&folder).unwrap();
    let files = files.map(|file| file.unwrap().path());
    let files: BTreeSet<PathBuf> = files.filter(|path| path.is_file()).collect();
    assert_eq!(files, names);
}
