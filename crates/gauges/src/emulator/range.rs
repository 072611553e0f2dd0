//! What a described gauge is built for: units, steps, capacity, the sense of its plus.

use crate::Channel;
use crate::description::{InstrumentDescription, SignMeaning};

use super::meter::{Range, Unit};

/// Capacities of gauges whose description has none, N and m.
const USUAL_CAPACITY_SI: [f64; 2] = [500.0, 0.05];

/// Steps of the last digit of gauges whose description has none, N and m.
const USUAL_STEP_SI: [f64; 2] = [0.1, 1e-6];

/// Most decimals of a unit.
const MOST_DECIMALS: u8 = 6;

impl Range {
    /// The values of a description, and usual values where it has none.
    pub(super) fn described(description: &InstrumentDescription) -> Self {
        let mut units = description.units.all();
        let first = first_unit(description.channel);
        units.sort_by_key(|unit| unit != first);
        let place = usize::from(description.channel.is_displacement());
        let kind = description.channel.kind();
        let units = units.into_iter().filter_map(|name| {
            let si = kind.si_factor(&name)?;
            let decimals = decimals(description, &name, USUAL_STEP_SI[place] / si);
            Some(Unit { name, si, decimals })
        });
        let capacity_si = description.physical.capacity_si;
        Self {
            channel: description.channel,
            units: units.collect(),
            capacity_si: capacity_si.unwrap_or(USUAL_CAPACITY_SI[place]),
            plus_as_truth: match (description.channel, description.sign.compression) {
                // Most force gauges without a stated sign have compression plus.
                (Channel::Force, SignMeaning::Positive | SignMeaning::Ask) => false,
                (Channel::Force, SignMeaning::Negative) => true,
                (_, meaning) => meaning != SignMeaning::Negative,
            },
        }
    }
}

/// The unit after switching on, and after the command that sets it.
pub(super) fn first_unit(channel: Channel) -> &'static str {
    match channel {
        Channel::Force => "N",
        _ => "mm",
    }
}

/// Digits behind the point in a unit.
fn decimals(description: &InstrumentDescription, unit: &str, usual_step: f64) -> u8 {
    let physical = &description.physical;
    let mut decimals = physical.decimals.iter();
    if let Some((_, possible)) = decimals.find(|(name, _)| name == unit)
        && let Some(most) = possible.iter().max()
    {
        return *most;
    }
    let mut resolution = physical.resolution.iter();
    let stated = resolution.find(|(name, _)| name == unit);
    let step = stated.map_or(usual_step, |(_, step)| *step);
    let shows = |digits: &u8| {
        let steps = step * 10_f64.powi(i32::from(*digits));
        // A stated step is shown whole, a usual one as the next finer decimal one.
        let is_whole = (steps - steps.round()).abs() < 1e-6 * steps;
        steps >= 0.999 && (stated.is_none() || is_whole)
    };
    (0..MOST_DECIMALS).find(shows).unwrap_or(MOST_DECIMALS)
}
