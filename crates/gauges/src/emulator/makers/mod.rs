//! The gauges that are emulated, a maker's protocol a file.
//!
//! Everything here is written by hand from what the makers print in their manuals, and never through the framing and decoding of this crate:
//! a mistake there must not find its like here. Where the makers do not say what is sent, the choice is stated.

mod aikoh;
mod cdi;
mod generic;
mod heidenhain;
mod imada_ds2;
mod imada_zts;
mod lutron;
mod magnescale;
mod mahr;
mod mark10;
mod mitutoyo;
mod modbus;
mod sauter;
mod shimpo;
mod sylvac;
#[cfg(test)]
mod test_bench;
mod unasked;

use super::gauge::Maker;
use super::meter::{Range, Unit};

/// A gauge that can be emulated.
pub(super) struct Make {
    /// The name of its description.
    pub(super) name: &'static str,
    pub(super) range: fn() -> Range,
    /// Its protocol as it is after switching on.
    pub(super) maker: fn() -> Box<dyn Maker>,
}

/// All of them.
pub(super) const EMULATED: [Make; 17] = [
    mark10::MAKE,
    sauter::MAKE,
    imada_ds2::MAKE,
    imada_zts::MAKE,
    aikoh::MAKE,
    shimpo::MAKE,
    lutron::MAKE,
    modbus::HP,
    mitutoyo::MAKE,
    sylvac::MAKE,
    mahr::MAKE,
    cdi::MAKE,
    heidenhain::MAKE,
    magnescale::MAKE,
    modbus::SHAHE,
    generic::FORCE,
    generic::DISPLACEMENT,
];

/// A unit as a table line.
fn unit(name: &str, si: f64, decimals: usize) -> Unit {
    Unit {
        name: name.to_owned(),
        si,
        decimals,
    }
}

/// Metres in a millimetre and an inch.
const MILLIMETRE_M: f64 = 1e-3;
const INCH_M: f64 = 0.0254;
