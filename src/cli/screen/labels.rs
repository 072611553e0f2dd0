//! Numbers and times as the screen says them.

use crate::quantity::METRES_PER_MICROMETRE as UM;
use crate::session::{GaugeView, Purpose, StiffnessSoFar, Task};

/// Decimals that a resolution asks for: 0.1 needs one, 0.005 three, 1 none; at most four.
fn decimals(resolution: f64) -> usize {
    (0..4)
        .find(|&digits| {
            let scaled = resolution * 10_f64.powi(digits);
            scaled >= 0.999 && (scaled - scaled.round()).abs() < 1e-6
        })
        .unwrap_or(4) as usize
}

/// The live value of a gauge in N or µm with the decimals that it shows; dashes where there is none.
pub(super) fn value(gauge: &GaugeView, si_per_unit: f64) -> String {
    let resolution = gauge.resolution_si.map_or(0.1, |step| step / si_per_unit);
    match gauge.value_si {
        Some(value) => number(value / si_per_unit, decimals(resolution)),
        None => "---".to_owned(),
    }
}

/// A number with so many decimals; what rounds to zero has no sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let nothing = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if nothing {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

/// Displacement with a decimal, µm.
pub(super) fn displacement(displacement_m: f64) -> String {
    number(displacement_m / UM, 1)
}

/// The smallest and largest value since the task began, with the decimals of the gauge; empty before the first.
pub(in crate::cli) fn extremes(gauge: &GaugeView, si_per_unit: f64) -> String {
    let resolution = gauge.resolution_si.map_or(0.1, |step| step / si_per_unit);
    gauge.extremes_si.map_or_else(String::new, |ends| {
        let [low, high] = ends.map(|end| number(end / si_per_unit, decimals(resolution)));
        format!("min {low} max {high}")
    })
}

/// Age of a value.
pub(in crate::cli) fn age(age_s: Option<f64>) -> String {
    match age_s {
        None => "no value yet".to_owned(),
        Some(s) if s < 1.0 => format!("{:.0} ms ago", s * 1e3),
        Some(s) => format!("{s:.0} s ago"),
    }
}

/// A time in hours and minutes.
pub(super) fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).ceil().max(0.0) as u64;
    match (minutes / 60, minutes % 60) {
        (0, 0) => "less than a minute".to_owned(),
        (0, minutes) => format!("{minutes} min"),
        (hours, minutes) => format!("{hours} h {minutes:02} min"),
    }
}

/// What the operator is to do, as an order.
pub(super) fn task(task: &Task) -> String {
    match task {
        Task::CheckInstruments => "Querying the identity of the gauges".to_owned(),
        Task::Answer => "Answer the question below".to_owned(),
        Task::SetUp { pose, direction } => {
            format!("Set the robot to {pose}; jack and gauges along {direction}")
        }
        Task::PushByHand { let_go: true, .. } => {
            "Let go of robot and gauges: their rest is observed".to_owned()
        }
        Task::PushByHand {
            direction,
            force_n,
            gauge,
            ..
        } => {
            let word = direction.to_string();
            let way = match (word.strip_prefix('-'), *force_n < 0.0) {
                (Some(axis), true) => format!("+{axis}"),
                (Some(axis), false) => format!("-{axis}"),
                (None, true) => format!("-{word}"),
                (None, false) => format!("+{word}"),
            };
            if gauge.is_some() {
                format!("Push the end by hand along {way}, beside the force gauge")
            } else {
                format!("Push by hand along {way}, {:.0} N or more", force_n.abs())
            }
        }
        Task::Load { target_n, purpose } => load(*target_n, *purpose),
        Task::Hold { target_n, left_s } => {
            format!("Keep {target_n:.1} N on for {left_s:.0} s more")
        }
        Task::Wait => "Wait".to_owned(),
        Task::Paused => "Paused: p continues".to_owned(),
        Task::Done => "Done".to_owned(),
    }
}

fn load(target_n: f64, purpose: Purpose) -> String {
    match purpose {
        Purpose::Free => "Take the jack off: the gauge hangs free".to_owned(),
        Purpose::Preload => format!("Press on to the preload of {target_n:.1} N"),
        Purpose::Release => format!("Release to {target_n:.1} N"),
        Purpose::Again => format!("Once more to {target_n:.1} N, on the way to the open reading"),
        Purpose::Reading if target_n == 0.0 => {
            "Take the jack off: a reading without load".to_owned()
        }
        Purpose::Reading => format!("Turn the jack to {target_n:.1} N"),
        Purpose::ZeroCheck => format!("Back to {target_n:.1} N: does the zero still hold?"),
    }
}

/// How far the force is from the band, as an order.
pub(super) fn to_go(force_n: f64, target_n: f64, tolerance_n: f64) -> String {
    let short_n = target_n - force_n;
    if short_n.abs() <= tolerance_n {
        return "in the band".to_owned();
    }
    // More load means away from zero; what crosses zero counts as more.
    let more = short_n * target_n > 0.0;
    let word = if more { "more" } else { "less" };
    format!("{:.1} N {word}", short_n.abs())
}

/// Share of the stiffness below which an uncertainty is owed to the gauges' last digits and carries no information.
const NEGLIGIBLE: f64 = 1e-5;

/// Stiffness so far with what its uncertainty holds, and what one more repeat would buy.
pub(super) fn stiffness(so_far: &StiffnessSoFar) -> Vec<String> {
    let si = crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
    let k = so_far.stiffness_n_per_m / si;
    let mut lines = Vec::new();
    match (so_far.expanded_n_per_m, so_far.k) {
        (Some(u), Some(_)) if u < NEGLIGIBLE * so_far.stiffness_n_per_m.abs() => {
            lines.push(format!("K = {k:.4} N/um"));
            lines.push("all on one line to the last digit: U needs more readings".to_owned());
        }
        (Some(u), Some(coverage)) => {
            let digits = decimals_of_uncertainty(u / si);
            lines.push(format!(
                "K = {k:.digits$} N/um, U = {:.digits$} N/um",
                u / si
            ));
            lines.push(format!(
                "(k = {coverage:.2}, {:.1} dof, {} runs, scatter only)",
                so_far.dof, so_far.runs
            ));
            if let Some(next) = so_far.with_one_more_n_per_m {
                lines.push(format!("one more repeat: U = {:.digits$} N/um", next / si));
            }
        }
        _ => lines.push(format!("K = {k:.3} N/um, uncertainty needs a second run")),
    }
    lines
}

/// Decimals at which an uncertainty shows two significant digits.
fn decimals_of_uncertainty(u: f64) -> usize {
    if u.is_finite() && u > 0.0 {
        (1.0 - u.log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_follow_the_resolution_of_the_gauge() {
        for (resolution, digits) in [
            (1.0, 0),
            (0.5, 1),
            (0.1, 1),
            (0.02, 2),
            (0.005, 3),
            (10.0, 0),
            (1e-9, 4),
        ] {
            assert_eq!(decimals(resolution), digits, "{resolution}");
        }
    }

    #[test]
    fn more_and_less_are_meant_for_the_jack_whatever_the_sign() {
        assert_eq!(to_go(-28.0, -30.0, 0.5), "2.0 N more");
        assert_eq!(to_go(-32.0, -30.0, 0.5), "2.0 N less");
        assert_eq!(to_go(28.0, 30.0, 0.5), "2.0 N more");
        assert_eq!(to_go(-30.4, -30.0, 0.5), "in the band");
        assert_eq!(to_go(-3.0, 0.0, 0.5), "3.0 N less");
    }

    #[test]
    fn times_are_said_in_hours_and_minutes() {
        assert_eq!(duration(0.0), "less than a minute");
        assert_eq!(duration(59.0), "1 min");
        assert_eq!(duration(3660.0), "1 h 01 min");
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(number(-0.04, 1), "0.0");
        assert_eq!(number(-0.06, 1), "-0.1");
    }
}
