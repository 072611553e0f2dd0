//! Laws, places, sizes and odds in words for a reader who knows no statistics.

use crate::analysis::Subject;
use crate::mismatch::{Location, Stratum};
use crate::physics::{Effect, Law, Place};

/// What is missing, as the object of "the model leaves out …".
pub(in crate::report) fn phrase(law: Law, place: &Place, values: &[f64]) -> String {
    (law.words.phrase)(&place_words(place), values) + &of_gauge(place)
}

/// Which of several gauges it is, where the law's own words do not say.
fn of_gauge(place: &Place) -> String {
    match place {
        Place::Clock(Some(axis)) | Place::DisplacementGauge(Some(axis)) => {
            format!(", gauge along {axis}")
        }
        _ => String::new(),
    }
}

/// The same, short enough for the heading of a figure.
pub(in crate::report) fn short_phrase(effect: &Effect) -> String {
    (effect.law.words.heading)(&effect.place) + &of_gauge(&effect.place)
}

/// Where, in words that go on a phrase.
fn place_words(place: &Place) -> String {
    match place {
        Place::Axis(axis) => format!("the {axis} axis"),
        Place::Toward { direction, toward } => {
            format!("along {direction} that leans toward {toward}")
        }
        Place::Run {
            pose,
            direction,
            repeat,
            step,
            gauge,
        } => {
            let of_gauge = gauge.map_or_else(String::new, |axis| format!(", gauge along {axis}"));
            format!(
                "in pose {pose}, direction {direction}{of_gauge}, repeat {repeat}, at load step {step}"
            )
        }
        other => other.to_string(),
    }
}

/// Why a law was refused that needs an impossible value.
pub(super) fn impossible(law: Law) -> String {
    let name = law.parameters.first().map_or("size", |size| size.word);
    format!("it would need a negative {name}")
}

/// How much likelier, from the logarithm of a Bayes factor.
pub(super) fn likelier(log_bayes: f64) -> String {
    /// Beyond this the noise model itself is less certain than the number.
    const MOST: f64 = 1e6;
    let ratio = log_bayes.exp();
    if ratio >= MOST {
        "more than a million times likelier".to_owned()
    } else if ratio >= 10.0 {
        format!("about {} times likelier", rounded(ratio))
    } else if ratio >= 1.1 {
        format!("{ratio:.1} times likelier")
    } else {
        "no likelier".to_owned()
    }
}

/// One chance in how many sessions.
///
/// # Arguments
/// - `least`: the smallest chance that the draws of noise can show; as small a one is only known to be no larger.
pub(super) fn one_in(p: f64, least: f64) -> String {
    if p >= 0.2 {
        return format!("in {:.0} of 100 such sessions", 100.0 * p);
    }
    if least > 0.0 && p <= 1.001 * least {
        return format!(
            "in fewer than 1 in {} such sessions (the limit of the simulation)",
            rounded(1.0 / least)
        );
    }
    if p < 1e-6 {
        return "in fewer than 1 in a million such sessions".to_owned();
    }
    format!("in about 1 in {} such sessions", rounded(1.0 / p))
}

/// Two digits that matter, without an exponent.
fn rounded(value: f64) -> String {
    let magnitude = 10f64.powf(value.log10().floor() - 1.0).max(1.0);
    format!("{:.0}", (value / magnitude).round() * magnitude)
}

/// How strong an evidence is, in a word.
pub(super) fn strength(log_bayes: f64) -> &'static str {
    match log_bayes {
        l if l < 1.0 => "no appreciable evidence",
        l if l < 3.0 => "a hint",
        l if l < 6.0 => "clear",
        l if l < 12.0 => "strong",
        _ => "very strong",
    }
}

/// Where something sits, in words: a stratum, with its pose and direction.
pub(super) fn location(subject: &Subject, location: &Location) -> String {
    let size = subject.reading(location.size_m);
    if let Some(period_s) = location.period_s {
        let period = if period_s < 120.0 {
            format!("{period_s:.0} s")
        } else {
            format!("{:.0} min", period_s / 60.0)
        };
        return format!("in an oscillation over time, period about {period} (up to {size})");
    }
    let what = match location.stratum {
        Stratum::CellSlope => "in the stiffness, which one set of factors does not give everywhere",
        Stratum::LoadStep => "in the shape of the load-displacement curves",
        Stratum::Branch => "in the difference between loading and unloading",
        Stratum::RepeatTime => "in a trend over repeats or time",
        Stratum::Sign => "in the difference between pushing and pulling",
        Stratum::Rest => "in the size of the scatter, or in a pattern over the gauge's travel",
    };
    let place = match (subject, &location.pose, location.direction) {
        (Subject::Part { .. }, Some(configuration), _) => {
            format!("configuration {configuration}, ")
        }
        (Subject::Part { .. }, None, _) => String::new(),
        (_, Some(pose), Some(direction)) => format!("pose {pose}, direction {direction}, "),
        (_, Some(pose), None) => format!("pose {pose}, all directions, "),
        (_, None, Some(direction)) => format!("direction {direction}, all poses, "),
        (_, None, None) => "all poses and directions, ".to_owned(),
    };
    format!("{what} ({place}up to {size})")
}

/// Several things in one sentence.
pub(in crate::report) fn listed(things: &[String], last: &str) -> String {
    match things {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., end] => format!("{} {last} {end}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::laws;

    #[test]
    fn odds_are_printed_without_exponents() {
        assert_eq!(likelier(41.0), "more than a million times likelier");
        assert_eq!(likelier(8.0), "about 3000 times likelier");
        assert_eq!(likelier(3.0), "about 20 times likelier");
        assert_eq!(likelier(1.0), "2.7 times likelier");
        assert_eq!(likelier(-2.0), "no likelier");
        assert_eq!(one_in(0.0003, 1e-4), "in about 1 in 3300 such sessions");
        assert_eq!(
            one_in(1e-4, 1e-4),
            "in fewer than 1 in 10000 such sessions (the limit of the simulation)"
        );
        assert_eq!(one_in(0.41, 1e-4), "in 41 of 100 such sessions");
        assert_eq!(
            one_in(0.0, 0.0),
            "in fewer than 1 in a million such sessions"
        );
    }

    #[test]
    fn a_law_is_named_with_its_place() {
        let place = Place::Joint("A3".to_owned());
        assert_eq!(
            phrase(laws::JOINT_BACKLASH, &place, &[]),
            "play in joint A3"
        );
        assert_eq!(
            phrase(laws::JOINT_NONLINEARITY, &place, &[1e-5, -1e-7]),
            "a joint A3 that grows stiffer under load"
        );
    }
}
