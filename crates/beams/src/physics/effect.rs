//! A law at a place with values: what is found, simulated and stored.

use std::fmt;

use stiffbench_units_and_text::digits::significant;

use crate::robot::{FittingFactors, JointMotion, ModelParameter, SpringAxis};

use super::law::Law;
use super::laws;
use super::parameter::ParameterSpec;
use super::place::Place;

/// A law, where it acts, and its values in SI units, in the order of [`super::LawDefinition::parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// The law.
    pub law: Law,
    /// Where it acts.
    pub place: Place,
    /// Values of its parameters, SI.
    pub values: Vec<f64>,
}

/// Why an effect is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum EffectError {
    /// A place of another kind than the law's.
    #[error("{law} cannot act at {place}")]
    #[diagnostic(
        code(stiffbench::physics::place),
        help(
            "joint laws act at a joint, base compliance about an axis, a loose member at an element; docs/physics.md lists the places"
        )
    )]
    Place {
        /// The law.
        law: Law,
        /// The place.
        place: Place,
    },
    /// Too few or too many values.
    #[error("{law} has {expected} parameters, {given} were given")]
    #[diagnostic(code(stiffbench::physics::values))]
    Count {
        /// The law.
        law: Law,
        /// Parameters it has.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A value that physics does not allow.
    #[error(
        "{law}: {parameter} = {value} {unit} is impossible: it must be a finite number {allowed}"
    )]
    #[diagnostic(code(stiffbench::physics::impossible))]
    Impossible {
        /// The law.
        law: Law,
        /// The parameter.
        parameter: &'static str,
        /// Its unit.
        unit: &'static str,
        /// The value given.
        value: f64,
        /// Which numbers it may be, in words.
        allowed: &'static str,
    },
    /// A joint or element that the mechanism does not have.
    #[error("{place}: mechanism {mechanism} has no such {kind}")]
    #[diagnostic(
        code(stiffbench::physics::unknown_place),
        help("it has: {}", known.join(", "))
    )]
    Unknown {
        /// The place.
        place: Place,
        /// The mechanism.
        mechanism: String,
        /// Joint or element.
        kind: &'static str,
        /// Those that it has.
        known: Vec<String>,
    },
    /// Values of a joint that turns at one that slides, or the other way round.
    #[error("{law} at {place}: the joint {motion}, and the units given are of one that does not")]
    #[diagnostic(code(stiffbench::physics::motion), help("write {units}"))]
    Motion {
        /// The law.
        law: Law,
        /// The place, as the units tell it.
        place: Place,
        /// How the joint moves.
        motion: JointMotion,
        /// The parameters with the units that they have there.
        units: String,
    },
    /// A mistake of the robot file where the file itself is to be right.
    #[error("{law} at {place} is a mistake in the robot file, not an additional effect")]
    #[diagnostic(
        code(stiffbench::physics::of_the_file),
        help("correct the robot file, or name the right mechanism, and leave this effect out")
    )]
    OfTheFile {
        /// The law.
        law: Law,
        /// The place.
        place: Place,
    },
    /// A mechanism that cannot carry a load without the element.
    #[error("without {element} mechanism {mechanism} carries no load")]
    #[diagnostic(
        code(stiffbench::physics::falls_apart),
        help("choose an element of a closed loop")
    )]
    FallsApart {
        /// The element.
        element: String,
        /// The mechanism.
        mechanism: String,
    },
}

impl Effect {
    /// How many of its values a fit moves.
    #[must_use]
    pub fn fitted_values(&self) -> usize {
        let parameters = self.law.parameters.iter().take(self.values.len());
        parameters.filter(|one| !one.is_reference()).count()
    }

    /// The springs that the values of a model name, as effects beside it; those stay in the structure that turn or move no hinge of it.
    #[must_use]
    pub fn of_springs(values: &FittingFactors) -> Vec<Self> {
        let springs = values.springs().filter(ModelParameter::is_beside_structure);
        let effects = springs.filter_map(|spring| Self::of_spring(&spring, values.get(&spring)));
        effects.filter(|effect| effect.values[0] > 0.0).collect()
    }

    /// A spring of a model as an effect; `None` of one that no law describes.
    #[must_use]
    pub fn of_spring(spring: &ModelParameter, compliance: f64) -> Option<Self> {
        let (law, place) = match spring {
            ModelParameter::Joint(name) => (laws::JOINT_COMPLIANCE, Place::Joint(name.to_string())),
            ModelParameter::JointAlong(name) => {
                (laws::JOINT_COMPLIANCE, Place::Slide(name.to_string()))
            }
            ModelParameter::JointAbout(name, axis) => {
                let (joint, axis) = (name.to_string(), *axis);
                let place = Place::AcrossJoint { joint, axis };
                (laws::JOINT_TILT_COMPLIANCE, place)
            }
            ModelParameter::Base(axis) => (laws::BASE_COMPLIANCE, Place::Axis(axis.turn()?)),
            ModelParameter::Tool(axis) if axis.turns() => {
                (laws::TOOL_COMPLIANCE_ABOUT, Place::Tool(*axis))
            }
            ModelParameter::Tool(axis) => (laws::TOOL_COMPLIANCE_ALONG, Place::Tool(*axis)),
            _ => return None,
        };
        let values = vec![compliance];
        Some(Self { law, place, values })
    }

    /// The parameter of a model that it is, with its compliance, as [`Effect::of_spring`] has it.
    #[must_use]
    pub fn as_spring(&self) -> Option<(ModelParameter, f64)> {
        let spring = match &self.place {
            Place::Joint(name) if self.law == laws::JOINT_COMPLIANCE => {
                ModelParameter::Joint(name.as_str().into())
            }
            Place::Slide(name) if self.law == laws::JOINT_COMPLIANCE => {
                ModelParameter::JointAlong(name.as_str().into())
            }
            Place::Axis(axis) if self.law == laws::BASE_COMPLIANCE => {
                ModelParameter::Base(SpringAxis::about(*axis))
            }
            _ => return self.spring_of_structure(),
        };
        Some((spring, *self.values.first()?))
    }

    /// The spring of a structure that it is, with its compliance; `None` of what acts beside the structure, or is no spring.
    #[must_use]
    pub fn spring_of_structure(&self) -> Option<(ModelParameter, f64)> {
        Some((self.place.spring()?, *self.values.first()?))
    }

    /// The same as the simplest law that does it: of nested laws that without the last values, where these are zero.
    #[must_use]
    pub fn simplest(&self) -> Self {
        let nested = Law::ALL.iter().find(|law| {
            let mut names = law.parameters.iter().zip(self.law.parameters);
            let rest = self.values.get(law.parameters.len()..);
            self.law.contains(**law)
                && names.all(|(one, own)| one.name == own.name)
                && rest.is_some_and(|rest| !rest.is_empty() && rest.iter().all(|v| *v == 0.0))
        });
        let law = *nested.unwrap_or(&self.law);
        Self {
            law,
            place: self.place.clone(),
            values: self.values[..law.parameters.len()].to_vec(),
        }
    }

    /// An effect, checked for what needs no robot: kind of place, count and sign of values.
    ///
    /// # Errors
    /// [`EffectError::Place`], [`EffectError::Count`], [`EffectError::Impossible`].
    pub fn new(law: Law, place: Place, values: Vec<f64>) -> Result<Self, EffectError> {
        if !fits(law, &place) {
            return Err(EffectError::Place { law, place });
        }
        let parameters = law.parameters;
        if parameters.len() != values.len() {
            return Err(EffectError::Count {
                law,
                expected: parameters.len(),
                given: values.len(),
            });
        }
        for (parameter, &value) in law.parameters_at(&place).zip(&values) {
            if !parameter.sign.allows(value) {
                return Err(EffectError::Impossible {
                    law,
                    parameter: parameter.name,
                    unit: parameter.unit(),
                    value,
                    allowed: parameter.sign.in_words(),
                });
            }
        }
        Ok(Self { law, place, values })
    }

    /// Its parameters as they are at its place, each with its value, SI.
    pub fn parameters(&self) -> impl Iterator<Item = (ParameterSpec, f64)> {
        let values = self.values.iter().copied();
        self.law.parameters_at(&self.place).zip(values)
    }

    /// The law and its place in words: "joint-backlash at joint A3".
    #[must_use]
    pub fn title(&self) -> String {
        title(self.law, &self.place)
    }
}

/// A law and a place in words.
#[must_use]
pub fn title(law: Law, place: &Place) -> String {
    format!("{law} at {place}")
}

/// Whether a law can act at a place.
fn fits(law: Law, place: &Place) -> bool {
    let turned = !matches!(place, Place::Toward { direction, toward } if direction == toward);
    law.place_kind == place.kind() && turned
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title())?;
        let mut separator = ": ";
        for (parameter, value) in self.parameters() {
            let (factor, unit) = parameter.dimension.printed(value);
            let value = significant(factor * value, 4);
            write!(f, "{separator}{} = {value} {unit}", parameter.name)?;
            separator = ", ";
        }
        Ok(())
    }
}
