//! What a law is: all properties of one physical effect, in one value.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Deref;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

use super::action::{HistoryLaw, LawAction, MOST_PARAMETERS, SimulatedRotation, Values, values_of};
use super::parameter::ParameterSpec;
use super::place::{Place, PlaceKind};
use super::run_loads::LoadPoint;
use super::search::{PlaceScale, SearchSpec};

/// A number made of the values of an effect, which readings determine where they do not tell the values apart.
#[derive(Debug, Clone, Copy)]
pub struct Combination {
    /// How it is named and measured.
    pub spec: ParameterSpec,
    /// The number, SI; in proportion to the first value.
    ///
    /// # Arguments
    /// - The values of the law's parameters.
    /// - The scales of the place.
    pub of: fn(&Values, &PlaceScale) -> f64,
}

/// All properties of a law; each has a file of its own in `laws`.
#[derive(Debug)]
pub struct LawDefinition {
    /// Name in files. Two laws may share one, if the place, or the names or units of their parameters distinguish them.
    pub name: &'static str,
    /// Name in tables, of this law alone.
    pub row: &'static str,
    /// What it accuses, and how large a mistake is.
    pub kind: LawKind,
    /// The equation, in ASCII.
    pub equation: &'static str,
    /// The kind of place where it acts.
    pub place_kind: PlaceKind,
    /// Its parameters; the first is its size, the others its shape.
    pub parameters: &'static [ParameterSpec],
    /// Simpler laws at the same place that it contains, by their names in tables.
    pub contains: &'static [&'static str],
    /// What readings determine where they do not tell the values of its parameters apart.
    pub combination: Option<Combination>,
    /// What it does to a run.
    pub action: LawAction,
    /// How it is searched for.
    pub search: SearchSpec,
    /// How a figure shows it.
    pub figure: LawFigure,
    /// How a page names it.
    pub words: LawWording,
    /// What decides about it by itself, besides loading the robot.
    pub check: Option<Check>,
}

/// What a law accuses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawKind {
    /// The robot, its gauges or their surroundings.
    Physics,
    /// The robot file, or how gauges and loads were set up.
    Setup(MistakePrior),
}

/// Prior of the size of a mistake about none: mistakes that are made and overlooked.
///
/// A Cauchy density, which is a normal one whose standard deviation is itself known by its order of magnitude only: a scale by judgement
/// must not exclude what the readings do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MistakePrior {
    /// With this scale, in the unit of the size.
    Size(f64),
    /// Of ln(1 + size), with this scale: a factor.
    Factor(f64),
    /// It has no size.
    Sizeless,
}

impl MistakePrior {
    /// Logarithm of the prior density at a size, relative to no mistake.
    #[must_use]
    pub fn log_density(self, size: f64) -> f64 {
        let ratio = match self {
            Self::Size(scale) => size / scale,
            Self::Factor(scale) => size.max(-1.0 + f64::EPSILON).ln_1p() / scale,
            Self::Sizeless => 0.0,
        };
        -(ratio * ratio).ln_1p()
    }
}

/// How a law is named in sentences.
#[derive(Debug, Clone, Copy)]
pub struct LawWording {
    /// What is missing, as the object of "the model leaves out …".
    ///
    /// # Arguments
    /// - The place in words, and the values; none if the law is named without an effect.
    pub phrase: fn(&str, &[f64]) -> String,
    /// The same, short enough for the heading of a figure.
    pub heading: fn(&Place) -> String,
    /// What the law does, in one sentence.
    pub explanation: &'static str,
}

/// A check by hand.
#[derive(Debug, Clone, Copy)]
pub struct Check {
    /// How directly it decides: 0 is the most direct.
    pub rank: u8,
    /// What to do at a place, as a clause.
    pub text: fn(&Place) -> String,
    /// How long it takes.
    pub minutes: f64,
}

/// How a figure shows a law.
#[derive(Debug, Clone, Copy)]
pub struct LawFigure {
    /// What drives the law, and is drawn across.
    pub driving: Driving,
    /// Heading of one panel for all cells, for a law that acts alike in all; `None` for a panel a cell.
    pub pooled: Option<&'static str>,
    /// Whether only the largest loads are drawn, where a law that grows with the displacement shows best.
    pub large_loads_only: bool,
    /// The curve of the law.
    pub curve: Curve,
}

impl LawFigure {
    /// Over the force, a panel a cell.
    pub(super) const OVER_FORCE: Self = Self {
        driving: Driving::Force,
        pooled: None,
        large_loads_only: false,
        curve: Curve::Lines,
    };
}

/// What drives a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driving {
    /// The force.
    Force,
    /// The displacement, folded to one period if the law has one.
    Displacement,
    /// The time since the gauge zero.
    Clock,
    /// The time under load.
    Hold,
    /// The repeat.
    Repeat,
}

/// The curve of a law over what drives it.
#[derive(Debug, Clone, Copy)]
pub enum Curve {
    /// Lines between what the law does to the readings.
    Lines,
    /// Steps between what the law does to the readings.
    Steps,
    /// A function over one period, m, of the values and the share of the period.
    Period {
        /// The parameter that is the period.
        parameter: usize,
        /// The function.
        value_m: fn(&[f64], f64) -> f64,
    },
    /// A function of what drives the law, of a size that fits the readings.
    Shape(fn(&[f64], f64) -> f64),
}

/// A law of the library.
#[derive(Clone, Copy)]
pub struct Law(pub(super) &'static LawDefinition);

impl Law {
    /// Whether it is a mistake of the robot file or the set-up.
    #[must_use]
    pub fn is_setup(self) -> bool {
        matches!(self.kind, LawKind::Setup(_))
    }

    /// Logarithm of the prior density of its values, relative to none: of mistakes; physics within its bounds is as likely everywhere.
    #[must_use]
    pub fn log_prior(self, values: &[f64]) -> f64 {
        match self.kind {
            LawKind::Physics => 0.0,
            LawKind::Setup(prior) => values.first().map_or(0.0, |size| prior.log_density(*size)),
        }
    }

    /// Whether absolute positions of a tracker cannot show it: a tracker has no displacement gauge, stand or zero, and its positions belong to no run.
    #[must_use]
    pub fn is_hidden_from_trackers(self) -> bool {
        matches!(
            self.place_kind,
            PlaceKind::Direction
                | PlaceKind::Toward
                | PlaceKind::Structure
                | PlaceKind::Clock
                | PlaceKind::Run
                | PlaceKind::DisplacementGauge
        )
    }

    /// Its parameters as they are at a place.
    pub fn parameters_at(self, place: &Place) -> impl Iterator<Item = ParameterSpec> {
        self.parameters.iter().map(move |spec| spec.at(place))
    }

    /// Whether the law sits in one joint.
    #[must_use]
    pub fn is_of_a_joint(self) -> bool {
        self.place_kind == PlaceKind::Joint
    }

    /// Whether it is a law of a joint whose twist is not proportional to the moment.
    #[must_use]
    pub fn is_nonlinear_joint(self) -> bool {
        matches!(self.action, LawAction::Joint(law) if !law.is_linear())
    }

    /// Whether it changes what a load does by the same share however large the load is, so that a stiffness without its load shows it.
    #[must_use]
    pub fn is_in_proportion_to_load(self) -> bool {
        let ones = values_of(&[1.0; MOST_PARAMETERS]);
        let [one, two] = [1.0, 2.0].map(|force_n| LoadPoint {
            force_n,
            ..LoadPoint::default()
        });
        match self.action {
            LawAction::Joint(law) => law.is_linear(),
            LawAction::Force(of) | LawAction::Added(of) => {
                of(&ones, &one) != 0.0 && of(&ones, &two) == 2.0 * of(&ones, &one)
            }
            LawAction::Growth(of) => of(&ones, &one, 1) != 0.0,
            LawAction::Gauge(_) | LawAction::History(_) => false,
            LawAction::Base
            | LawAction::Missing
            | LawAction::Mechanism
            | LawAction::Structure
            | LawAction::Turn
            | LawAction::Lean => true,
        }
    }

    /// What it is in a simulator of rigid bodies; `None` if it is no law of a joint.
    ///
    /// # Arguments
    /// - `values`: of its parameters, SI.
    #[must_use]
    pub fn in_simulators(self, values: &[f64]) -> Option<SimulatedRotation> {
        match self.action {
            LawAction::Joint(law) => Some(law.in_simulators(&values_of(values))),
            _ => None,
        }
    }

    /// Whether it is an element that is missing: a change of the mechanism, with no size.
    #[must_use]
    pub fn is_missing_element(self) -> bool {
        matches!(self.action, LawAction::Missing)
    }

    /// Whether it makes another structure, which is solved anew: nothing that acts on the readings of this one.
    #[must_use]
    pub fn changes_structure(self) -> bool {
        let action = self.action;
        matches!(
            action,
            LawAction::Missing | LawAction::Mechanism | LawAction::Structure
        )
    }

    /// Whether it depends on where the gauge stands.
    #[must_use]
    pub fn is_gauge_error(self) -> bool {
        matches!(self.action, LawAction::Gauge(_))
    }

    /// What a part answers to its path under it; `None` of a law without such a memory.
    #[must_use]
    pub fn history(self) -> Option<&'static dyn HistoryLaw> {
        match self.action {
            LawAction::History(law) => Some(law),
            _ => None,
        }
    }

    /// Whether it happens in one run and not again.
    #[must_use]
    pub fn is_of_one_run(self) -> bool {
        self.place_kind == PlaceKind::Run
    }

    /// Whether this law contains `simpler` at the same place, as friction and nonlinearity contain compliance.
    #[must_use]
    pub fn contains(self, simpler: Self) -> bool {
        self.contains.contains(&simpler.row)
    }
}

impl Deref for Law {
    type Target = LawDefinition;

    fn deref(&self) -> &LawDefinition {
        self.0
    }
}

impl PartialEq for Law {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Law {}

impl PartialOrd for Law {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Law {
    fn cmp(&self, other: &Self) -> Ordering {
        self.number().cmp(&other.number())
    }
}

impl Hash for Law {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.row.hash(state);
    }
}

impl fmt::Debug for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row)
    }
}

/// Its name.
impl Serialize for Law {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

impl JsonSchema for Law {
    fn schema_name() -> Cow<'static, str> {
        "Law".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "description": "Name of a law.", "type": "string", "enum": Self::names() })
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name)
    }
}
