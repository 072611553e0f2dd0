//! Effects as one writes them on the command line: `joint-backlash@A3:play=1.2e-4rad,seat_moment=3.6N*m`.
//!
//! ```text
//!   effect     = law [ "@" place ] [ ":" parameter { "," parameter } ]
//!   place      = joint | element | axis | direction | direction ">" axis | pose "." direction "." repeat "." step
//!              | "force" | "displacement" | "structure" | "clock"
//!   parameter  = name "=" number [ unit ]
//! ```
//!
//! A place may be left out where there is only one of its kind. Every parameter of the law is given once, with its unit; the unit of
//! a drift's rate distinguishes its two laws. A unit that begins with a digit stands behind a space: `q=7e-5 1/N`.
//! `docs/physics.md` lists laws, places and units.

use std::fmt::Write as _;
use std::str::FromStr;

use indexmap::IndexSet;
use stiffbench_units_and_text::nearest::nearest;

use super::effect::{Effect, EffectError};
use super::law::Law;
use super::parameter::ParameterSpec;
use super::place::Place;

/// What is wrong with an effect in writing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectProblem {
    /// A law that does not exist.
    #[error("there is no law `{name}`")]
    Law {
        /// The name.
        name: String,
    },
    /// No place, where there are many.
    #[error("{law} needs a place: {expected}")]
    NoPlace {
        /// The law.
        law: Law,
        /// What a place of its kind is.
        expected: &'static str,
    },
    /// A place that is none for the law.
    #[error("`{place}` is not a place for {law}: it must be {expected}")]
    Place {
        /// The law.
        law: Law,
        /// The place.
        place: String,
        /// What a place of its kind is.
        expected: &'static str,
    },
    /// A parameter without an equals sign.
    #[error("`{text}` is not a parameter: write NAME=VALUE")]
    NotAParameter {
        /// The text.
        text: String,
    },
    /// A parameter that the law does not have.
    #[error("{law} has no parameter `{name}`")]
    UnknownParameter {
        /// The law.
        law: Law,
        /// The name.
        name: String,
    },
    /// A parameter given twice.
    #[error("{name} is given twice")]
    Twice {
        /// The name.
        name: &'static str,
    },
    /// A parameter that is missing.
    #[error("{law} needs {name}, in {unit}")]
    Missing {
        /// The law.
        law: Law,
        /// The name.
        name: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// A value that does not begin with a number.
    #[error("{name} = `{text}` is not a number with a unit")]
    Number {
        /// The parameter.
        name: &'static str,
        /// The text.
        text: String,
    },
    /// A unit of another quantity, or none.
    #[error("{}", unit_sentence(name, unit))]
    Unit {
        /// The parameter.
        name: &'static str,
        /// The unit given.
        unit: String,
        /// Those that are possible.
        accepted: String,
    },
    /// A value that physics does not allow.
    #[error(transparent)]
    Impossible(#[from] EffectError),
}

impl EffectProblem {
    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Law { name } => nearest(name, Law::names())
                .map(|near| format!("did you mean {near}?"))
                .or_else(|| Some(format!("the laws are {}", Law::names().join(", ")))),
            Self::NoPlace { law, .. } | Self::Place { law, .. } => {
                let example = law.place_kind.example();
                Some(format!("for example {law}{example}"))
            }
            // Few and short: the whole list is more helpful than the nearest.
            Self::UnknownParameter { law, .. } => {
                let mut known: Vec<&str> = law.parameters.iter().map(|p| p.name).collect();
                // A second law of the name may have one parameter more.
                let richer = Law::named(law.name).filter(|other| other.contains(*law));
                let own = known.len();
                known.extend(
                    richer
                        .flat_map(|other| &other.parameters[own..])
                        .map(|p| p.name),
                );
                Some(if known.is_empty() {
                    format!("{law} has none")
                } else {
                    format!("it has {}", known.join(", "))
                })
            }
            Self::Unit { unit, accepted, .. } if unit.starts_with('/') => Some(format!(
                "write one of {accepted}; put a space before a unit that begins with a digit"
            )),
            Self::Unit { accepted, .. } => Some(format!("write one of {accepted}")),
            Self::NotAParameter { .. } | Self::Missing { .. } | Self::Number { .. } => {
                Some("for example joint-backlash@A3:play=1.2e-4rad,seat_moment=3.6N*m".to_owned())
            }
            Self::Twice { .. } => Some("give every parameter once".to_owned()),
            Self::Impossible(_) => None,
        }
    }
}

/// An effect in writing that cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not an effect: {problem}")]
#[diagnostic(code(stiffbench::usage::effect))]
pub struct NotAnEffect {
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub problem: EffectProblem,
    /// What to do about it.
    #[help]
    pub help: Option<String>,
}

impl FromStr for Effect {
    type Err = NotAnEffect;

    fn from_str(text: &str) -> Result<Self, NotAnEffect> {
        read(text.trim()).map_err(|problem| NotAnEffect {
            text: text.to_owned(),
            help: problem.help(),
            problem,
        })
    }
}

fn unit_sentence(name: &str, unit: &str) -> String {
    if unit.is_empty() {
        return format!("{name} needs a unit");
    }
    format!("{name} cannot have the unit `{unit}`")
}

fn read(text: &str) -> Result<Effect, EffectProblem> {
    let name_end = text.find(['@', ':']).unwrap_or(text.len());
    let (name, rest) = text.split_at(name_end);
    let laws = laws_named(name.trim())?;
    let (place, parameters) = match rest.strip_prefix('@') {
        // A law without parameters: names of elements may have any letters.
        Some(place) if laws[0].parameters.is_empty() => (Some(place), ""),
        Some(rest) => match rest.rsplit_once(':') {
            Some((place, parameters)) => (Some(place), parameters),
            None => (Some(rest), ""),
        },
        None => (None, rest.strip_prefix(':').unwrap_or(rest)),
    };
    let place = read_place(&laws, place.map(str::trim))?;
    let here = laws_at(&laws, &place);
    let mut given = Vec::new();
    for part in parameters.split(',').map(str::trim) {
        if part.is_empty() && parameters.trim().is_empty() {
            continue;
        }
        let (name, value) = part
            .split_once('=')
            .ok_or_else(|| EffectProblem::NotAParameter {
                text: part.to_owned(),
            })?;
        let spec = parameter_named(&here, name.trim())?;
        let (number, unit) = number_and_unit(spec.name, value.trim())?;
        given.push((spec.name, number, unit));
    }
    with_parameters(&laws, place, &given)
}

/// The laws of a name: one, or those distinguished by the unit of a parameter.
pub(super) fn laws_named(name: &str) -> Result<Vec<Law>, EffectProblem> {
    let laws: Vec<Law> = Law::named(name).collect();
    if laws.is_empty() {
        let name = name.to_owned();
        return Err(EffectProblem::Law { name });
    }
    Ok(laws)
}

/// A parameter by name of any of some laws.
pub(super) fn parameter_named(
    laws: &[Law],
    name: &str,
) -> Result<&'static ParameterSpec, EffectProblem> {
    let mut specs = laws.iter().flat_map(|law| law.parameters);
    let spec = specs.find(|spec| spec.name == name);
    spec.ok_or_else(|| EffectProblem::UnknownParameter {
        law: laws[0],
        name: name.to_owned(),
    })
}

/// Those of the laws of a name that act at a kind of place; all if none does.
pub(super) fn laws_at(laws: &[Law], place: &Place) -> Vec<Law> {
    let here = laws.iter().filter(|law| law.place_kind == place.kind());
    let here: Vec<Law> = here.copied().collect();
    if here.is_empty() { laws.to_vec() } else { here }
}

/// The place of the laws of a name, where there is but one.
pub(super) fn only_place(laws: &[Law]) -> Option<Place> {
    let law = laws[0];
    let is_one = laws.iter().all(|other| other.place_kind == law.place_kind);
    law.place_kind.only().filter(|_| is_one)
}

fn read_place(laws: &[Law], text: Option<&str>) -> Result<Place, EffectProblem> {
    let law = laws[0];
    let kinds = || laws.iter().map(|law| law.place_kind);
    let expected = law.place_kind.in_words();
    match text {
        None => only_place(laws).ok_or(EffectProblem::NoPlace { law, expected }),
        Some(text) => {
            let place = kinds().find_map(|kind| kind.read(text));
            place.ok_or_else(|| EffectProblem::Place {
                law,
                place: text.to_owned(),
                expected,
            })
        }
    }
}

/// A number and what follows it.
fn number_and_unit<'a>(name: &'static str, text: &'a str) -> Result<(f64, &'a str), EffectProblem> {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    let end = text.find(|c| !is_number(c)).unwrap_or(text.len());
    let number = text[..end].parse().map_err(|_| EffectProblem::Number {
        name,
        text: text.to_owned(),
    })?;
    Ok((number, text[end..].trim()))
}

/// An effect from a law's place and its parameters as they were given: name, number, unit.
///
/// # Arguments
/// - `laws`: all laws of one name; the first whose parameters and units fit is meant.
pub(super) fn with_parameters(
    laws: &[Law],
    place: Place,
    given: &[(&str, f64, &str)],
) -> Result<Effect, EffectProblem> {
    let mut first_problem = None;
    let laws = &laws_at(laws, &place);
    let meant: Vec<Place> = place.meant().collect();
    let of_place = |place| laws.iter().map(move |law| (place, *law));
    for (place, law) in meant.iter().flat_map(of_place) {
        match values(law, place, given) {
            Ok(values) => return Ok(Effect::new(law, place.clone(), values)?),
            // Of a law that has all these parameters it is the number or the unit that is wrong.
            Err(problem) => {
                let is_other_law = matches!(problem, EffectProblem::UnknownParameter { .. });
                let problem = with_units_of_all(problem, laws, &meant);
                first_problem = first_problem.filter(|(other, _)| is_other_law || !other);
                first_problem.get_or_insert((is_other_law, problem));
            }
        }
    }
    let nothing = || EffectProblem::Law {
        name: String::new(),
    };
    Err(first_problem.map_or_else(nothing, |(_, problem)| problem))
}

fn values(law: Law, place: &Place, given: &[(&str, f64, &str)]) -> Result<Vec<f64>, EffectProblem> {
    let mut values = Vec::new();
    for ParameterSpec {
        name, dimension, ..
    } in law.parameters_at(place)
    {
        let mut of_name = given.iter().filter(|(given, ..)| *given == name);
        let &(_, number, given_unit) = of_name.next().ok_or(EffectProblem::Missing {
            law,
            name,
            unit: dimension.unit(),
        })?;
        if of_name.next().is_some() {
            return Err(EffectProblem::Twice { name });
        }
        let value = dimension
            .in_si(number, given_unit)
            .ok_or_else(|| EffectProblem::Unit {
                name,
                unit: given_unit.to_owned(),
                accepted: dimension.accepted(),
            })?;
        values.push(value);
    }
    let is_known = |name: &str| law.parameters.iter().any(|spec| spec.name == name);
    match given.iter().find(|(name, ..)| !is_known(name)) {
        Some((name, ..)) => Err(EffectProblem::UnknownParameter {
            law,
            name: (*name).to_owned(),
        }),
        None => Ok(values),
    }
}

/// Adds the units of the other laws of the name to those that are possible.
fn with_units_of_all(problem: EffectProblem, laws: &[Law], meant: &[Place]) -> EffectProblem {
    let EffectProblem::Unit { name, unit, .. } = problem else {
        return problem;
    };
    let at = |place| laws.iter().flat_map(move |law| law.parameters_at(place));
    let specs = meant.iter().flat_map(at);
    let accepted = specs
        .filter(|spec| spec.name == name)
        .map(|spec| spec.dimension.accepted());
    // Two laws of a name may have a parameter in common, and so may a hinge and a slide.
    let units: IndexSet<String> = accepted.collect();
    let units: Vec<String> = units.into_iter().collect();
    let accepted = units.join(", ");
    EffectProblem::Unit {
        name,
        unit,
        accepted,
    }
}

impl Effect {
    /// The form that [`Effect::from_str`] reads, in SI units, every digit kept.
    #[must_use]
    pub fn compact(&self) -> String {
        let mut text = format!("{}@{}", self.law, self.place.compact());
        let mut separator = ':';
        for (parameter, value) in self.parameters() {
            let _ = write!(
                text,
                "{separator}{}={value:?} {}",
                parameter.name,
                parameter.unit()
            );
            separator = ',';
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::laws;
    use proptest::prelude::*;

    fn effect(text: &str) -> Effect {
        text.parse().unwrap()
    }

    #[test]
    fn every_kind_of_effect_is_read() {
        let backlash = effect("joint-backlash@A3:play=1.2e-4rad, seat_moment = 3600 N*mm");
        assert_eq!(backlash.law, laws::JOINT_BACKLASH);
        assert_eq!(backlash.place, Place::Joint("A3".into()));
        assert_eq!(backlash.values, [1.2e-4, 3.6]);
        let drift = |text: &str| effect(text).law;
        assert_eq!(
            drift("thermal-drift@clock:rate=1e-8m/s"),
            laws::DRIFT_PER_SECOND
        );
        assert_eq!(drift("thermal-drift:rate=-2um/K"), laws::DRIFT_PER_KELVIN);
        let late = effect("thermal-drift:rate=1000um/h,zeroed_before=0.25min");
        assert_eq!(late.law, laws::DRIFT_SINCE_ZEROING);
        assert_eq!(late.values[1], 15.0);
        assert_eq!(effect("slip@P3.z.2.5:jump=-30um").values, [-3e-5]);
        assert_eq!(effect("load-misalignment@y>z:angle=0.01rad").values, [0.01]);
        assert!(effect("loose-member@B1B2").values.is_empty());
        assert_eq!(effect("setting-in:k=3%,decay=1.5").values, [0.03, 1.5]);
        let odd = effect("loose-member@odd:name");
        assert_eq!(odd.place, Place::Element("odd:name".into()));
    }

    /// What is read, and what the message and the help must contain.
    #[rustfmt::skip]
    const MISTAKES: [(&str, &str, &str); 21] = [
        ("joint-play@A3", "there is no law `joint-play`", ""),
        ("joint-backlsh@A3", "there is no law", "joint-backlash"),
        ("gremlins", "there is no law", "gauge-periodic"),
        ("joint-compliance:c=1e-6rad/(N*m)", "joint-compliance needs a place", ""),
        ("loose-member:A3B1", "loose-member needs a place", ""),
        ("base-compliance@w:c=1", "`w` is not a place for base-compliance", "base-compliance@x"),
        ("joint-backlash@A3:play=3mm,seat_moment=1N*m", "play cannot have the unit `mm`", "mrad"),
        ("thermal-drift:rate=1K", "rate cannot have the unit", "um/h"),
        ("thermal-drift:rate=1K", "rate cannot have the unit", "um/K"),
        ("thermal-drift:rate=1um/h,zeroed=1s", "no parameter `zeroed`", "zeroed_before"),
        ("thermal-drift:rate=1um/h,zeroed_before=1K", "zeroed_before cannot have the unit `K`", ""),
        ("joint-backlash@A3:play=1mrad", "joint-backlash needs seat_moment", ""),
        ("creep:k=0.01/decade,t0=1s", "k cannot have the unit", ""),
        // Not one percent and not one per mille: 1/decade without a space before it.
        ("creep:k=0.0041/decade,t0=1s", "k cannot have the unit", "space"),
        ("creep:k=1%/decade,k=1%/decade,t0=1s", "k is given twice", ""),
        ("creep:k=x,t0=1s", "k = `x` is not a number", ""),
        ("creep:fast", "`fast` is not a parameter", ""),
        ("creep:k=1%/decade,t=1s", "no parameter `t`", "t0"),
        ("joint-backlash@A3:play=-1mrad,seat_moment=1N*m", "play = -0.001 rad is impossible", ""),
        ("creep:k=1%/decade,t0=0s", "t0 = 0 s is impossible", ""),
        ("slip@P1.x.1.1:jump=1e999m", "jump = inf m is impossible", ""),
    ];

    #[test]
    fn errors_list_the_allowed_values() {
        for (text, says, helps) in MISTAKES {
            let error = text.parse::<Effect>().unwrap_err();
            let problem = error.problem.to_string();
            assert!(problem.contains(says), "{text}: {problem}");
            let help = error.help.unwrap_or_default();
            assert!(help.contains(helps), "{text}: {help}");
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_it_panic(text in ".{0,60}", law in 0..Law::ALL.len()) {
            let _ = text.parse::<Effect>();
            let _ = format!("{}{text}", Law::ALL[law]).parse::<Effect>();
        }
    }
}
