//! Decodes the bytes that a Mark-10 force gauge sends, with its shipped description.
//!
//! A packet that does not match the description completely is rejected with a reason; a number is never searched for inside a line.

use std::error::Error;
use std::fmt::Write;

use stiffbench::instrument::{Decoded, Decoder};
use stiffbench::shipped::shipped_instrument;

/// Two values, one in another unit, and a line that was damaged on the way.
const BYTES: &[u8] = b"4.285 N\r\n-12.5 lbF\r\n4.2#5 N\r\n";

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", report()?);
    Ok(())
}

/// What the example prints.
pub(crate) fn report() -> Result<String, Box<dyn Error>> {
    let description = shipped_instrument("mark10-series5")?;
    let mut decoder = Decoder::new(&description, None)?;
    let mut decoded = Vec::new();
    decoder.push(BYTES, 0.0, &mut decoded);
    let mut text = String::new();
    for one in &decoded {
        match one {
            Decoded::Sample(sample) => {
                writeln!(
                    text,
                    "{} {} = {:.6} N",
                    sample.value, sample.unit, sample.value_si
                )?;
            }
            Decoded::Rejected(rejected) => writeln!(text, "rejected: {}", rejected.raw)?,
            Decoded::Reply(reply) => writeln!(text, "not a value: {}", reply.raw)?,
        }
    }
    Ok(text)
}
