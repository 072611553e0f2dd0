//! What to measure when no law of the library explains what is left: whether it comes again, and how it goes on there.

use super::next_measurement::NextMeasurement;
use crate::mismatch::observed::Observations;
use crate::mismatch::unexplained::{Location, Stratum};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::bench::DesignBench;
use super::plans::{loadings, proposed};

/// Name of the way of loading that shows most of a stratum, and what it shows.
fn loading_for(stratum: Stratum) -> (&'static str, &'static str) {
    match stratum {
        Stratum::CellSlope => (
            "load-unload",
            "whether the stiffness of further poses disagrees in the same way",
        ),
        Stratum::LoadStep => ("half-steps", "the shape of the curve between the loads"),
        Stratum::Branch => (
            "load-hold-unload",
            "whether the loop opens with the load or with time",
        ),
        Stratum::RepeatTime => (
            "more-repeats",
            "whether the trend goes on, dies out or turns back; write down the temperature with each reading",
        ),
        Stratum::Sign => ("both-signs", "how pushing and pulling differ"),
        Stratum::Rest => (
            "half-steps",
            "whether the pattern belongs to the load or to the travel of the gauge; move the zero of the gauge by 0.3 mm before",
        ),
    }
}

/// The measurement that shows more of what a diagnosis left unexplained, in the poses and directions where it sits.
///
/// # Arguments
/// - `done`: the readings already made, in the order of the poses at hand.
/// - `left`: where they fail.
/// - `base`: the procedure by which they were made, or one like it.
pub(super) fn refine_scores(
    bench: &DesignBench<'_>,
    done: &Observations,
    left: &Location,
    base: &Procedure,
) -> Option<NextMeasurement> {
    let separates = ["a cause that no law describes", "chance in these readings"];
    let separates = separates.map(str::to_owned);
    if let Some(period_s) = left.period_s {
        let (plan, minutes) = unloaded(period_s);
        return Some(NextMeasurement::check(plan, minutes, separates));
    }
    let (name, shows) = loading_for(left.stratum);
    let mut loadings = loadings(base).into_iter();
    let loading = loadings.find(|loading| loading.name == name)?;
    let poses = poses(bench, done, left);
    if poses.is_empty() {
        return None;
    }
    let (directions, along) = match left.direction {
        _ if bench.is_of_part() => (bench.directions().to_vec(), String::new()),
        None => (Direction::ALL.to_vec(), String::new()),
        Some(direction) => (vec![direction], format!(" in {direction}")),
    };
    let names: Vec<&str> = poses.iter().map(PoseId::as_str).collect();
    let of = if bench.is_of_part() {
        "configuration"
    } else {
        "pose"
    };
    let words = format!(
        "{of} {}{along}, {}: it shows {shows}",
        names.join(", "),
        loading.text.as_deref().unwrap_or_default()
    );
    let there = (poses, &directions[..]);
    Some(proposed(bench, &loading, words, there, separates))
}

/// What shows a swing of the clock, in words, and the minutes that it takes: the gauges alone.
fn unloaded(period_s: f64) -> (String, f64) {
    /// Periods, and readings in each, from which a swing is seen by eye.
    const PERIODS: f64 = 4.0;
    const READINGS: f64 = 12.0;
    let minutes = (PERIODS * period_s / 60.0).ceil();
    let words = format!(
        "leave the gauges on the unloaded robot for {minutes:.0} minutes and write down displacement and temperature every {:.0} s: it shows whether the swing occurs without load and follows the room temperature",
        (period_s / READINGS).ceil()
    );
    (words, minutes)
}

/// The pose where it sits, or all that were measured; for a stiffness that disagrees those that were not, if there are any.
fn poses(bench: &DesignBench<'_>, done: &Observations, left: &Location) -> Vec<PoseId> {
    let [measured, further] = bench.measured_and_further(done);
    match &left.pose {
        _ if left.stratum == Stratum::CellSlope && !further.is_empty() => bench.named(&further),
        Some(pose) if bench.may_be_measured.contains(pose) => vec![pose.clone()],
        _ => bench.named(&measured),
    }
}
