//! Any bytes as a table of readings: no panic, errors with a line, and what is read survives being written.
use stiffbench::readings::{read_readings, write_readings};

/// Tries some bytes.
pub(crate) fn run(bytes: &[u8]) {
    match read_readings("fuzz.csv", bytes) {
        Ok(table) => {
            let mut written = Vec::new();
            write_readings(&table, &mut written).expect("what was read is finite");
            let again =
                read_readings("again.csv", &written[..]).expect("what was written can be read");
            assert_eq!(again.readings.len(), table.readings.len());
            assert_eq!(again.runs, table.runs);
            assert_eq!(again.zeros, table.zeros);
        }
        Err(error) if error.code == "stiffbench::readings::empty" => {}
        Err(error) => assert!(error.to_string().starts_with("fuzz.csv, line ")),
    }
}
