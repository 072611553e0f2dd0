//! Any bytes as a table of another program, and as a mapping: no panic, and what is imported can be written and read.
use stiffbench::import::{ImportDraft, ImportMapping};
use stiffbench::readings::{read_readings, write_readings};

/// Tries some bytes; the first chooses what is stated of the table.
pub(crate) fn run(bytes: &[u8]) {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let mut mapping = ImportMapping::default();
    if choice & 1 != 0 {
        mapping.direction = Some("-y".to_owned());
    }
    if choice & 2 != 0 {
        mapping.units.force = Some("kgf".to_owned());
        mapping.units.displacement = Some("mm".to_owned());
    }
    if choice & 4 != 0 {
        for (role, column) in [("force", "1"), ("displacement", "2")] {
            mapping.set(role, column).expect("both are roles");
        }
    }
    let log = (choice & 8 != 0).then_some(("log", bytes));
    if let Ok(text) = std::str::from_utf8(bytes) {
        // Either answer will do.
        let _ = ImportMapping::from_toml("fuzz.toml", text);
    }
    let Ok(draft) = ImportDraft::read(&[("fuzz.csv", bytes)], log, &mapping) else {
        return;
    };
    let _ = (draft.missing(), draft.columns());
    if let Ok(imported) = draft.finish("stiffbench import") {
        let mut written = Vec::new();
        write_readings(&imported.table, &mut written).expect("what was imported is finite");
        let again = read_readings("again.csv", &written[..]).expect("what was written can be read");
        assert_eq!(again.readings.len(), imported.table.readings.len());
        let text = imported.mapping.to_toml();
        let same = ImportMapping::from_toml("mapping.toml", &text).expect("a mapping is read back");
        assert_eq!(same.columns, imported.mapping.columns);
    }
}
