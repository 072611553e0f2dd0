//! Sessions on an emulated bench: the hand that does what is asked for, and what faults do to a session.

mod simulated_operator;

use crate::instrument::description::UnitSource;
use crate::instrument::{Channel, InstrumentDescription};

pub use simulated_operator::{PHASES, SimulatedOperator};

/// The unit that an emulated gauge is in where its packets do not say; `None` where they do.
#[must_use]
pub fn unit_in_use(description: &InstrumentDescription) -> Option<String> {
    let usual = match description.channel {
        Channel::Force => "N",
        _ => "mm",
    };
    let choices = description.unit_choices();
    let unit = match choices.first() {
        Some(first) if !choices.contains(&usual) => first,
        _ => usual,
    };
    (description.unit_source() != UnitSource::Packet).then(|| unit.to_owned())
}
