//! Shipped descriptions by name, and what is decoded.

use stiffbench_gauges::{Decoded, InstrumentDescription, Sample};

/// A shipped description, which can be read.
pub(crate) fn shipped_instrument(name: &str) -> InstrumentDescription {
    let mut shipped = stiffbench_test_files::shipped_instruments().iter();
    let file = shipped
        .find(|file| file.name == name)
        .expect("it is shipped");
    let read = InstrumentDescription::parse(file.text, file.name);
    read.expect("a shipped description can be read").0
}

/// The values among what was decoded.
pub(crate) fn samples(decoded: &[Decoded]) -> Vec<&Sample> {
    let samples = decoded.iter().filter_map(|one| match one {
        Decoded::Sample(sample) => Some(sample),
        _ => None,
    });
    samples.collect()
}
