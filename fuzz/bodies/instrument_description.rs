//! Any text as an instrument description: no panic, errors with a line, and what is read decodes any bytes.
use stiffbench::instrument::{Decoder, InstrumentDescription};

/// Tries some bytes; those that are no text are left out.
pub(crate) fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match InstrumentDescription::parse(text, "fuzz.toml") {
        Ok((description, _)) => {
            let unit = description.unit_choices().first().map(ToString::to_string);
            if let Ok(mut decoder) = Decoder::new(&description, unit.as_deref()) {
                let mut out = Vec::new();
                decoder.push(text.as_bytes(), 0.0, &mut out);
                decoder.idle(0.0, &mut out);
            }
        }
        Err(error) => assert!(error.line > 0 && error.column > 0),
    }
}
