//! What a fit can change in a robot: the list of model parameters, and their values.
//!
//! Two kinds. A factor multiplies a nominal section constant, of a class of elements (the paper's eq. (16)) or of one section. A spring is
//! a rotational compliance where the model is otherwise rigid, in a joint or under the base (the virtual joint method).

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::test_point::Direction;

use crate::structure::Property;

use super::Robot;
use super::error::RobotError;
use super::file::ElementClass;
use super::mechanism::Mechanism;

/// One parameter of the model of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum ModelParameter {
    /// Multiplier of a section constant in all elements of a class.
    Class(ElementClass, Property),
    /// Multiplier of a constant of one section, by name, beside that of the class.
    Section(Arc<str>, Property),
    /// Compliance of a joint, by name, about its axis, rad/(N·m).
    Joint(Arc<str>),
    /// Compliance of the base about an axis through the first support, rad/(N·m).
    Base(Direction),
}

impl ModelParameter {
    /// The paper's eight factors: beams A, Iy, Iz, J, then links.
    pub const CLASSES: [Self; 8] = {
        use ElementClass::{Beam, Link};
        use Property::{A, Iy, Iz, J};
        [
            Self::Class(Beam, A),
            Self::Class(Beam, Iy),
            Self::Class(Beam, Iz),
            Self::Class(Beam, J),
            Self::Class(Link, A),
            Self::Class(Link, Iy),
            Self::Class(Link, Iz),
            Self::Class(Link, J),
        ]
    };

    /// The paper's four factors of beams: A, Iy, Iz, J.
    pub const BEAMS: [Self; 4] = {
        use Property::{A, Iy, Iz, J};
        const BEAM: ElementClass = ElementClass::Beam;
        [
            Self::Class(BEAM, A),
            Self::Class(BEAM, Iy),
            Self::Class(BEAM, Iz),
            Self::Class(BEAM, J),
        ]
    };

    /// Every parameter that a mechanism has: factors of classes and of its sections, springs in its joints and under the base.
    #[must_use]
    pub fn all(robot: &Robot, mechanism: &Mechanism) -> Vec<Self> {
        let sections = robot.sections.keys().enumerate().filter(|(section, _)| {
            let mut members = mechanism.members.iter();
            members.any(|&member| robot.members[member].section == *section)
        });
        let of_section = |(_, name): (usize, &String)| {
            let name: Arc<str> = name.as_str().into();
            Property::ALL.map(|property| Self::Section(name.clone(), property))
        };
        let joints = mechanism.joints(robot).into_iter();
        let joints = joints.map(|joint| Self::Joint(robot.joints[joint].name.as_str().into()));
        Self::CLASSES
            .into_iter()
            .chain(sections.flat_map(of_section))
            .chain(joints)
            .chain(Direction::ALL.map(Self::Base))
            .collect()
    }

    /// The parameter of a name such as `beam.Iy`, `section.rod.A`, `joint.J2`, `base.x`.
    ///
    /// # Errors
    /// [`RobotError::NotAParameter`]; [`RobotError::UnknownName`] for a joint or section that the mechanism has not.
    pub fn find(robot: &Robot, mechanism: &Mechanism, name: &str) -> Result<Self, RobotError> {
        let parameter = Self::try_from(name.to_owned())?;
        let all = Self::all(robot, mechanism);
        if all.contains(&parameter) {
            return Ok(parameter);
        }
        Err(match &parameter {
            Self::Joint(joint) => {
                let known = mechanism.joints(robot).into_iter();
                robot.unknown(
                    "joint",
                    joint,
                    known.map(|joint| robot.joints[joint].name.as_str()),
                )
            }
            Self::Section(section, _) => robot.unknown(
                "section",
                section,
                robot.sections.keys().map(String::as_str),
            ),
            Self::Class(..) | Self::Base(_) => NotAParameter {
                text: name.to_owned(),
            }
            .into(),
        })
    }

    /// Its unit, `1` for a factor.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        if self.is_factor() { "1" } else { "rad/(N*m)" }
    }

    /// Whether it multiplies a section constant; else it is the compliance of a spring.
    #[must_use]
    pub fn is_factor(&self) -> bool {
        matches!(self, Self::Class(..) | Self::Section(..))
    }
}

/// Its name in files, options and tables.
impl fmt::Display for ModelParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Class(ElementClass::Beam, property) => write!(f, "beam.{}", property.name()),
            Self::Class(ElementClass::Link, property) => write!(f, "link.{}", property.name()),
            Self::Section(section, property) => write!(f, "section.{section}.{}", property.name()),
            Self::Joint(joint) => write!(f, "joint.{joint}"),
            Self::Base(axis) => write!(f, "base.{axis}"),
        }
    }
}

impl From<ModelParameter> for String {
    fn from(parameter: ModelParameter) -> Self {
        parameter.to_string()
    }
}

/// A text that names no parameter.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a model parameter")]
#[diagnostic(
    code(stiffbench::robot::model_parameter),
    help("write for example beam.Iy, link.A, section.NAME.Iz, joint.NAME or base.x")
)]
pub struct NotAParameter {
    /// The text.
    pub text: String,
}

impl TryFrom<String> for ModelParameter {
    type Error = NotAParameter;

    fn try_from(text: String) -> Result<Self, NotAParameter> {
        let property = |name: &str| Property::ALL.into_iter().find(|p| p.name() == name);
        let parsed = match text.split_once('.') {
            Some(("beam", name)) => property(name).map(|p| Self::Class(ElementClass::Beam, p)),
            Some(("link", name)) => property(name).map(|p| Self::Class(ElementClass::Link, p)),
            Some(("section", rest)) => rest
                .rsplit_once('.')
                .and_then(|(section, name)| Some(Self::Section(section.into(), property(name)?))),
            Some(("joint", name)) => Some(Self::Joint(name.into())),
            Some(("base", axis)) => axis.parse().ok().map(Self::Base),
            _ => None,
        };
        parsed.ok_or(NotAParameter { text })
    }
}

/// Values of the parameters of a model; those not listed are one for factors and zero for springs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FittingFactors {
    /// Of beams, order A, Iy, Iz, J.
    pub beam: [f64; 4],
    /// Of links.
    pub link: [f64; 4],
    /// Of single sections, by name, beside those of the class.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sections: BTreeMap<String, [f64; 4]>,
    /// Compliance of joints about their axis, by name, rad/(N·m).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints_rad_per_nm: BTreeMap<String, f64>,
    /// Compliance of the base about x, y, z through the first support, rad/(N·m).
    #[serde(default, skip_serializing_if = "is_rigid")]
    pub base_rad_per_nm: [f64; 3],
}

fn is_rigid(base_rad_per_nm: &[f64; 3]) -> bool {
    *base_rad_per_nm == [0.0; 3]
}

impl Default for FittingFactors {
    fn default() -> Self {
        Self::UNIT
    }
}

impl FittingFactors {
    /// The model that was never fitted (eq. (11)).
    pub const UNIT: Self = Self::of_classes([1.0; 4], [1.0; 4]);

    /// Factors of beams and of links alone.
    #[must_use]
    pub const fn of_classes(beam: [f64; 4], link: [f64; 4]) -> Self {
        Self {
            beam,
            link,
            sections: BTreeMap::new(),
            joints_rad_per_nm: BTreeMap::new(),
            base_rad_per_nm: [0.0; 3],
        }
    }

    /// Factors of a class.
    #[must_use]
    pub fn of(&self, class: ElementClass) -> [f64; 4] {
        match class {
            ElementClass::Beam => self.beam,
            ElementClass::Link => self.link,
        }
    }

    /// Multipliers of the constants of an element: those of its class times those of its section.
    #[must_use]
    pub fn of_element(&self, class: ElementClass, section: &str) -> [f64; 4] {
        let mut multipliers = self.of(class);
        if let Some(factors) = self.sections.get(section) {
            for (multiplier, factor) in multipliers.iter_mut().zip(factors) {
                *multiplier *= factor;
            }
        }
        multipliers
    }

    /// The value of a parameter.
    #[must_use]
    pub fn get(&self, parameter: &ModelParameter) -> f64 {
        match parameter {
            ModelParameter::Class(class, property) => self.of(*class)[property.index()],
            ModelParameter::Section(section, property) => {
                let own = self.sections.get(&**section);
                own.map_or(1.0, |factors| factors[property.index()])
            }
            ModelParameter::Joint(joint) => self.joint_rad_per_nm(joint),
            ModelParameter::Base(axis) => self.base_rad_per_nm[axis.index()],
        }
    }

    /// Gives a parameter a value.
    pub fn set(&mut self, parameter: &ModelParameter, value: f64) {
        match parameter {
            ModelParameter::Class(ElementClass::Beam, property) => {
                self.beam[property.index()] = value;
            }
            ModelParameter::Class(ElementClass::Link, property) => {
                self.link[property.index()] = value;
            }
            ModelParameter::Section(section, property) => {
                let own = self.sections.entry(section.to_string());
                own.or_insert([1.0; 4])[property.index()] = value;
            }
            ModelParameter::Joint(joint) => {
                self.joints_rad_per_nm.insert(joint.to_string(), value);
            }
            ModelParameter::Base(axis) => self.base_rad_per_nm[axis.index()] = value,
        }
    }

    /// Compliance of a joint about its axis, rad/(N·m).
    #[must_use]
    pub fn joint_rad_per_nm(&self, joint: &str) -> f64 {
        self.joints_rad_per_nm.get(joint).copied().unwrap_or(0.0)
    }

    /// The same with rigid joints and a rigid base.
    #[must_use]
    pub fn without_springs(&self) -> Self {
        Self {
            sections: self.sections.clone(),
            ..Self::of_classes(self.beam, self.link)
        }
    }

    /// All parameters beyond the classes that these values name.
    pub fn named(&self) -> impl Iterator<Item = ModelParameter> + '_ {
        let of_section = |section: &String| {
            let section: Arc<str> = section.as_str().into();
            Property::ALL.map(|property| ModelParameter::Section(section.clone(), property))
        };
        self.sections
            .keys()
            .flat_map(of_section)
            .chain(self.springs())
    }

    /// The springs that these values name.
    pub fn springs(&self) -> impl Iterator<Item = ModelParameter> + '_ {
        let joints = self.joints_rad_per_nm.keys();
        let joints = joints.map(|joint| ModelParameter::Joint(joint.as_str().into()));
        let rocks = |axis: &Direction| self.base_rad_per_nm[axis.index()] != 0.0;
        let base = Direction::ALL.into_iter().filter(rocks);
        joints.chain(base.map(ModelParameter::Base))
    }

    /// Whether joints and base are rigid and no section has factors of its own: the paper's model.
    #[must_use]
    pub fn is_of_classes(&self) -> bool {
        self.sections.is_empty()
            && self.joints_rad_per_nm.values().all(|c| *c == 0.0)
            && is_rigid(&self.base_rad_per_nm)
    }

    /// The text of a file of factors, which `--factors` and the `factors` of a model file take.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let four = |[a, iy, iz, j]: [f64; 4]| {
            format!("{{ A = {a:?}, Iy = {iy:?}, Iz = {iz:?}, J = {j:?} }}")
        };
        let mut text = format!("beam = {}\nlink = {}\n", four(self.beam), four(self.link));
        // Names may need quotes.
        let mut table = |key: &str, entries: toml::Table| {
            if !entries.is_empty() {
                let _ = writeln!(text, "{key} = {}", toml::Value::Table(entries));
            }
        };
        let factors = |values: &[f64; 4]| {
            let entries = Property::ALL.into_iter().zip(values);
            let entries =
                entries.map(|(property, factor)| (property.name().to_owned(), (*factor).into()));
            toml::Value::Table(entries.collect())
        };
        let sections = self.sections.iter();
        table(
            "sections",
            sections
                .map(|(name, values)| (name.clone(), factors(values)))
                .collect(),
        );
        let joints = self.joints_rad_per_nm.iter();
        table(
            "joints_rad_per_Nm",
            joints
                .map(|(name, c)| (name.clone(), (*c).into()))
                .collect(),
        );
        let base = Direction::ALL.into_iter().zip(self.base_rad_per_nm);
        let base = base.filter(|(_, compliance)| *compliance != 0.0);
        table(
            "base_rad_per_Nm",
            base.map(|(axis, c)| (axis.to_string(), c.into())).collect(),
        );
        text
    }
}

/// Values of one and zero that name the springs among `parameters`: a structure made with them can be given others.
pub(super) fn springs_without_compliance(parameters: &[ModelParameter]) -> FittingFactors {
    let mut factors = FittingFactors::UNIT;
    for parameter in parameters {
        if let ModelParameter::Joint(_) = parameter {
            factors.set(parameter, 0.0);
        }
    }
    factors
}
