//! The shipped descriptions, for unit tests.

use crate::{DescriptionError, InstrumentDescription};

/// A shipped description by its name.
pub(crate) fn shipped_instrument(name: &str) -> Result<InstrumentDescription, DescriptionError> {
    let mut shipped = stiffbench_test_files::shipped_instruments().iter();
    let file = shipped
        .find(|file| file.name == name)
        .expect("it is shipped");
    Ok(InstrumentDescription::parse(file.text, file.name)?.0)
}
