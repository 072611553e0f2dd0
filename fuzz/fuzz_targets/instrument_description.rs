//! Any text as an instrument description: no panic, errors with a line, and what is read decodes any bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use stiffbench::instrument::{Decoder, InstrumentDescription};

fuzz_target!(|text: &str| {
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
});
