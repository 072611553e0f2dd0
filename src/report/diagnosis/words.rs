//! Laws, places, sizes and odds in words for a reader who knows no statistics.

use crate::mismatch::{Location, Stratum};
use crate::physics::{Effect, Law, Place};
use crate::report::significant;

/// Width of the verdict page.
const WIDTH: usize = 100;

/// What is missing, as the object of "the model leaves out …".
pub(in crate::report) fn phrase(law: Law, place: &Place, values: &[f64]) -> String {
    let at = place_words(place);
    match law {
        Law::JointCompliance => format!("a springy {at}"),
        Law::JointBacklash => format!("play in {at}"),
        Law::JointFriction => format!("friction in {at}"),
        Law::JointNonlinearity => match values.get(1) {
            Some(q) if *q < 0.0 => format!("a {at} that grows stiffer under load"),
            Some(q) if *q > 0.0 => format!("a {at} that grows softer under load"),
            _ => format!("a {at} whose stiffness changes with the load"),
        },
        Law::BaseCompliance => format!("a base that rocks about {at}"),
        Law::GaugeStandCompliance => {
            format!("a stand of the displacement gauge that gives way in {at}")
        }
        Law::LoadMisalignment => format!("a force {at}"),
        Law::LooseMember => format!("a loose {at}"),
        Law::ForceGaugeNonlinearity => "a force gauge that does not read evenly".to_owned(),
        Law::Creep => "creep under a constant load".to_owned(),
        Law::DriftPerSecond => "a drift of the displacement gauge with time".to_owned(),
        Law::DriftPerKelvin => "a drift of the displacement gauge with temperature".to_owned(),
        Law::SettingIn => match values.first() {
            Some(k) if *k < 0.0 => "setting in (the first repeats give way less)".to_owned(),
            _ => "setting in (the first repeats give way more)".to_owned(),
        },
        Law::Slip => format!("a slip {at}"),
        Law::GaugePeriodic => "a periodic error of the displacement gauge".to_owned(),
    }
}

/// The same, short enough for the heading of a figure.
pub(in crate::report) fn short_phrase(effect: &Effect) -> String {
    match (effect.law, &effect.place) {
        (Law::JointNonlinearity, place) => format!("nonlinearity of {place}"),
        (Law::GaugeStandCompliance, place) => format!("a yielding gauge stand, {place}"),
        (Law::LoadMisalignment, place) => format!("a turned force, {place}"),
        (Law::LooseMember, place) => format!("{place} loose"),
        (Law::ForceGaugeNonlinearity, _) => "the error of the force gauge".to_owned(),
        (Law::Creep, _) => "creep".to_owned(),
        (Law::DriftPerSecond, _) => "drift with time".to_owned(),
        (Law::DriftPerKelvin, _) => "drift with temperature".to_owned(),
        (Law::SettingIn, _) => "setting in".to_owned(),
        (Law::GaugePeriodic, _) => "the period of the gauge".to_owned(),
        (
            Law::Slip,
            Place::Run {
                pose,
                direction,
                repeat,
                ..
            },
        ) => format!("a slip in {pose} {direction}, repeat {repeat}"),
        (law, place) => phrase(law, place, &effect.values),
    }
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
        } => {
            format!("in pose {pose}, direction {direction}, repeat {repeat}, at load step {step}")
        }
        other => other.to_string(),
    }
}

/// What a law does, in one sentence.
pub(super) fn explanation(law: Law) -> &'static str {
    match law {
        Law::JointCompliance => {
            "The joint turns in proportion to the moment on it, like a spring, where the model holds it rigid."
        }
        Law::JointBacklash => {
            "Once the moment on the joint overcomes its seat, the joint turns freely through its play; from then on it carries."
        }
        Law::JointFriction => {
            "The joint sticks until the moment on it exceeds the friction moment, then turns like a spring; when the load is taken off \
             it sticks again, so that loading and unloading differ."
        }
        Law::JointNonlinearity => {
            "The joint turns with the moment on it, but not in proportion: it has a linear and a quadratic part."
        }
        Law::BaseCompliance => {
            "All supports of the robot rock together, like a plate on a soft floor."
        }
        Law::GaugeStandCompliance => {
            "The gauge reads more than the robot moves, in proportion to the force, in every pose alike."
        }
        Law::LoadMisalignment => {
            "A part of the force acts across the direction in which it is meant to act."
        }
        Law::LooseMember => "The robot behaves as if this member were not there.",
        Law::ForceGaugeNonlinearity => {
            "The true force departs from the reading of the force gauge by an amount that grows with the square of the force."
        }
        Law::Creep => "The displacement grows with the logarithm of the time under load.",
        Law::DriftPerSecond => "The displacement reading moves with the clock, loaded or not.",
        Law::DriftPerKelvin => {
            "The displacement reading moves with the temperature, loaded or not."
        }
        Law::SettingIn => {
            "The first load sequences differ from the later ones by a share that dies away."
        }
        Law::Slip => "From that reading on, all readings of that one run are shifted.",
        Law::GaugePeriodic => "The gauge's error repeats itself over its travel.",
    }
}

/// Why a law was refused that needs an impossible value.
pub(super) fn impossible(law: Law) -> String {
    let parameter = law.parameters().first();
    let name = parameter.map_or("size", |parameter| parameter_word(law, parameter.name));
    format!("it would improve the fit only with a {name} below zero")
}

/// What a parameter is called in sentences.
pub(super) fn parameter_word(law: Law, name: &'static str) -> &'static str {
    match (law, name) {
        (Law::JointNonlinearity, "c") => "linear part",
        (_, "c") => "compliance",
        (Law::ForceGaugeNonlinearity, "q") => "error",
        (_, "q") => "quadratic part",
        (Law::Creep, "k") => "growth",
        (Law::SettingIn, "k") => "share",
        (_, "seat_moment") => "seat moment",
        (_, "friction_moment") => "friction moment",
        (_, other) => other,
    }
}

/// Factor and unit by which a quantity in a file's unit is printed.
pub(super) fn printed_unit(name: &str, unit: &'static str, size: f64) -> (f64, &'static str) {
    match unit {
        "rad" if name == "angle" || name == "phase" => (1f64.to_degrees(), "degrees"),
        "rad" if size.abs() < 1e-3 => (1e6, "urad"),
        "rad" => (1e3, "mrad"),
        "rad/(N*m)" if size.abs() < 1e-3 => (1e6, "urad per N m"),
        "rad/(N*m)" => (1e3, "mrad per N m"),
        "rad/(N*m)^2" => (1e6, "urad per (N m)^2"),
        "m/N" => (1e6, "um/N"),
        "m" => (1e6, "um"),
        "m/s" => (6e7, "um/min"),
        "m/K" => (1e6, "um/K"),
        "1/N" => (1e4, "% per 100 N"),
        "1/decade" => (100.0, "% per tenfold time"),
        "1" => (100.0, "%"),
        "N*m" => (1.0, "N m"),
        other => (1.0, other),
    }
}

/// A size with its unit, for people.
pub(super) fn printed(name: &str, unit: &'static str, value: f64) -> String {
    let (factor, word) = printed_unit(name, unit, value);
    format!("{} {word}", significant(factor * value, 3))
}

/// A length in µm with as many digits as help.
pub(super) fn um(value_m: f64) -> String {
    let value = value_m * 1e6;
    if value.abs() >= 99.95 {
        format!("{value:.0} um")
    } else {
        format!("{value:.1} um")
    }
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

/// One chance in how many.
///
/// # Arguments
/// - `least`: the smallest chance that the draws of noise can show; as small a one is only known to be no larger.
pub(super) fn one_in(p: f64, least: f64) -> String {
    if p >= 0.2 {
        return format!("in {:.0} of 100", 100.0 * p);
    }
    if p < 1e-6 {
        return "in fewer than 1 of a million".to_owned();
    }
    let word = if p <= 1.001 * least {
        "fewer than 1"
    } else {
        "about 1"
    };
    format!("in {word} of {}", rounded(1.0 / p))
}

/// Two digits that matter, without an exponent.
fn rounded(value: f64) -> String {
    let magnitude = 10f64.powf(value.log10().floor() - 1.0).max(1.0);
    format!("{:.0}", (value / magnitude).round() * magnitude)
}

/// How strong an evidence is, in a word.
pub(super) fn strength(log_bayes: f64) -> &'static str {
    match log_bayes {
        l if l < 1.0 => "no evidence to speak of",
        l if l < 3.0 => "a hint",
        l if l < 6.0 => "clear",
        l if l < 12.0 => "strong",
        _ => "beyond doubt",
    }
}

/// Where something sits, in words: a stratum, with its pose and direction.
pub(super) fn location(location: &Location) -> String {
    let what = match location.stratum {
        Stratum::CellSlope => "in the stiffness, which one set of factors does not give everywhere",
        Stratum::LoadStep => "in the shape of the load-displacement curves",
        Stratum::Branch => "in the difference between loading and unloading",
        Stratum::RepeatTime => "in a trend over repeats or time",
        Stratum::Sign => "in the difference between pushing and pulling",
        Stratum::Rest => "in the size of the scatter, or in a pattern over the gauge's travel",
    };
    let place = match (&location.pose, location.direction) {
        (Some(pose), Some(direction)) => format!("pose {pose}, direction {direction}"),
        (Some(pose), None) => format!("pose {pose}, all directions"),
        (None, Some(direction)) => format!("direction {direction}, all poses"),
        (None, None) => "all poses and directions".to_owned(),
    };
    format!("{what} ({place}, up to {})", um(location.size_m))
}

/// Name of a law in a row; the two drifts share one.
#[must_use]
pub fn law_row(law: Law) -> String {
    match law {
        Law::DriftPerSecond => format!("{law} (time)"),
        Law::DriftPerKelvin => format!("{law} (temperature)"),
        _ => law.to_string(),
    }
}

/// Several things in one sentence.
pub(in crate::report) fn listed(things: &[String], last: &str) -> String {
    match things {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., end] => format!("{} {last} {end}", rest.join(", ")),
    }
}

/// A paragraph broken into lines of the page's width, each after `indent`; the first after `first`.
pub(super) fn paragraph(text: &str, first: &str, indent: &str) -> String {
    let mut out = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            out.push_str(line.trim_end());
            out.push('\n');
            indent.clone_into(&mut line);
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    out.push_str(line.trim_end());
    out.push('\n');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odds_are_told_without_exponents() {
        assert_eq!(likelier(41.0), "more than a million times likelier");
        assert_eq!(likelier(8.0), "about 3000 times likelier");
        assert_eq!(likelier(3.0), "about 20 times likelier");
        assert_eq!(likelier(1.0), "2.7 times likelier");
        assert_eq!(likelier(-2.0), "no likelier");
        assert_eq!(one_in(0.0003, 1e-4), "in about 1 of 3300");
        assert_eq!(one_in(1e-4, 1e-4), "in fewer than 1 of 10000");
        assert_eq!(one_in(0.41, 1e-4), "in 41 of 100");
        assert_eq!(one_in(0.0, 0.0), "in fewer than 1 of a million");
    }

    #[test]
    fn sizes_are_printed_in_units_of_the_workshop() {
        assert_eq!(printed("play", "rad", 1.2e-4), "120 urad");
        assert_eq!(printed("angle", "rad", 0.02), "1.15 degrees");
        assert_eq!(printed("rate", "m/s", 5e-9), "0.300 um/min");
        assert_eq!(printed("k", "1/decade", 0.004), "0.400 % per tenfold time");
        assert_eq!(printed("q", "1/N", -2e-5), "-0.200 % per 100 N");
    }

    #[test]
    fn long_sentences_are_broken_and_indented() {
        let text = "word ".repeat(30);
        let broken = paragraph(&text, "- ", "  ");
        let lines: Vec<&str> = broken.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("- word") && lines[1].starts_with("  word"));
        assert!(lines.iter().all(|line| line.len() <= WIDTH));
    }

    #[test]
    fn every_law_has_its_phrase() {
        let place = Place::Joint("A3".to_owned());
        assert_eq!(phrase(Law::JointBacklash, &place, &[]), "play in joint A3");
        assert_eq!(
            phrase(Law::JointNonlinearity, &place, &[1e-5, -1e-7]),
            "a joint A3 that grows stiffer under load"
        );
        for law in Law::ALL {
            assert!(!phrase(law, &Place::Structure, &[]).is_empty());
            assert!(explanation(law).ends_with('.'));
        }
    }
}
