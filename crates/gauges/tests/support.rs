//! Shipped descriptions by name.

use stiffbench_gauges::InstrumentDescription;

/// A shipped description, which can be read.
pub(crate) fn shipped_instrument(name: &str) -> InstrumentDescription {
    let mut shipped = stiffbench_test_files::shipped_instruments().iter();
    let file = shipped
        .find(|file| file.name == name)
        .expect("it is shipped");
    let read = InstrumentDescription::parse(file.text, file.name);
    read.expect("a shipped description can be read").0
}
