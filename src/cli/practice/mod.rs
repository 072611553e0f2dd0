//! Sessions on an emulated bench: the hand that does what is asked for, and what faults do to a session.

mod faults;
mod hand;
mod rehearsal;

use crate::instrument::description::UnitSource;
use crate::instrument::{Channel, InstrumentDescription};

pub(super) use faults::{FaultsArgs, run as run_faults};
pub(super) use hand::HelpingHand;

/// The unit that an emulated gauge is in where its packets do not say; `None` where they do.
pub(super) fn unit_in_use(description: &InstrumentDescription) -> Option<String> {
    let usual = match description.channel {
        Channel::Force => "N",
        Channel::Displacement => "mm",
    };
    let choices = description.unit_choices();
    let unit = match choices.first() {
        Some(first) if !choices.contains(&usual) => first,
        _ => usual,
    };
    (description.unit_source() != UnitSource::Packet).then(|| unit.to_owned())
}
