//! Values of the parameters of a model.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use super::spring_axis::SpringAxis;
use crate::structure::Property;

use super::model_parameter::{ElementClass, ModelParameter, NotAParameter};

/// Values of the parameters of a model; a factor not listed is one, a spring not listed is that of the robot file, else rigid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "StoredFactors", try_from = "StoredFactors")]
pub struct FittingFactors {
    /// Of beams, order A, Iy, Iz, J.
    pub beam: [f64; 4],
    /// Of links.
    pub link: [f64; 4],
    /// Of single sections, by name, beside those of the class.
    pub sections: BTreeMap<String, [f64; 4]>,
    /// Of groups of members, by name, beside those of class and section.
    pub groups: BTreeMap<String, [f64; 4]>,
    /// Compliances of springs, rad/(N·m) or m/N.
    pub springs: BTreeMap<ModelParameter, f64>,
}

/// The form in files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FittingFactors")]
struct StoredFactors {
    /// Of beams, order A, Iy, Iz, J.
    beam: [f64; 4],
    /// Of links.
    link: [f64; 4],
    /// Of single sections, by name, beside those of the class.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    sections: BTreeMap<String, [f64; 4]>,
    /// Of groups of members, by name, beside those of class and section.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    groups: BTreeMap<String, [f64; 4]>,
    #[serde(flatten)]
    springs: StoredSprings,
}

/// The springs of a model as files have them: those of joints about their axis and of the base about x, y, z apart from the others.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct StoredSprings {
    /// Compliance of joints about their axis, by name, rad/(N·m).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints_rad_per_nm: BTreeMap<String, f64>,
    /// Compliance of the base about x, y, z through the first support, rad/(N·m).
    #[serde(default, skip_serializing_if = "is_rigid")]
    pub base_rad_per_nm: [f64; 3],
    /// Compliance of all other springs, by the name of the parameter, rad/(N·m) or m/N.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub springs: BTreeMap<String, f64>,
}

fn is_rigid(base_rad_per_nm: &[f64; 3]) -> bool {
    *base_rad_per_nm == [0.0; 3]
}

/// The base's springs about x, y, z.
const BASE_TURNS: [SpringAxis; 3] = [SpringAxis::Rx, SpringAxis::Ry, SpringAxis::Rz];

impl From<FittingFactors> for StoredFactors {
    fn from(factors: FittingFactors) -> Self {
        Self {
            springs: StoredSprings::from(&factors),
            beam: factors.beam,
            link: factors.link,
            sections: factors.sections,
            groups: factors.groups,
        }
    }
}

impl From<&FittingFactors> for StoredSprings {
    fn from(factors: &FittingFactors) -> Self {
        let mut stored = Self::default();
        for (spring, &compliance) in &factors.springs {
            match spring {
                ModelParameter::Joint(joint) => {
                    stored
                        .joints_rad_per_nm
                        .insert(joint.to_string(), compliance);
                }
                ModelParameter::Base(axis) if axis.turns() && compliance != 0.0 => {
                    stored.base_rad_per_nm[axis.index() - 3] = compliance;
                }
                other => {
                    stored.springs.insert(other.to_string(), compliance);
                }
            }
        }
        stored
    }
}

impl TryFrom<StoredFactors> for FittingFactors {
    type Error = NotAParameter;

    fn try_from(stored: StoredFactors) -> Result<Self, NotAParameter> {
        let mut springs = BTreeMap::new();
        for (joint, compliance) in stored.springs.joints_rad_per_nm {
            springs.insert(ModelParameter::Joint(joint.into()), compliance);
        }
        for (axis, compliance) in BASE_TURNS.into_iter().zip(stored.springs.base_rad_per_nm) {
            if compliance != 0.0 {
                springs.insert(ModelParameter::Base(axis), compliance);
            }
        }
        for (name, compliance) in stored.springs.springs {
            springs.insert(ModelParameter::spring_named(&name)?, compliance);
        }
        Ok(Self {
            beam: stored.beam,
            link: stored.link,
            sections: stored.sections,
            groups: stored.groups,
            springs,
        })
    }
}

impl JsonSchema for FittingFactors {
    fn schema_name() -> Cow<'static, str> {
        StoredFactors::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = StoredFactors::json_schema(generator);
        schema.insert(
            "description".to_owned(),
            "Values of the parameters of a model; a factor not listed is one, a spring not listed is that of the robot file, else rigid."
                .into(),
        );
        schema
    }
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
            groups: BTreeMap::new(),
            springs: BTreeMap::new(),
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

    /// The value of a parameter; of a spring not listed zero (see [`Robot::with_own_springs`](super::Robot::with_own_springs)).
    #[must_use]
    pub fn get(&self, parameter: &ModelParameter) -> f64 {
        let of = |table: &BTreeMap<String, [f64; 4]>, name: &str, property: Property| {
            table.get(name).map_or(1.0, |own| own[property.index()])
        };
        match parameter {
            ModelParameter::Class(class, property) => self.of(*class)[property.index()],
            ModelParameter::Section(section, property) => of(&self.sections, section, *property),
            ModelParameter::Group(group, property) => of(&self.groups, group, *property),
            spring => self.spring(spring).unwrap_or(0.0),
        }
    }

    /// The compliance of a spring, if it is listed.
    #[must_use]
    pub fn spring(&self, spring: &ModelParameter) -> Option<f64> {
        self.springs.get(spring).copied()
    }

    /// Compliance of a joint that turns about its axis, rad/(N·m).
    #[must_use]
    pub fn joint_rad_per_nm(&self, joint: &str) -> f64 {
        self.get(&ModelParameter::Joint(joint.into()))
    }

    /// Gives a parameter a value.
    pub fn set(&mut self, parameter: &ModelParameter, value: f64) {
        let set = |table: &mut BTreeMap<String, [f64; 4]>, name: &str, property: Property| {
            let own = table.entry(name.to_owned());
            own.or_insert([1.0; 4])[property.index()] = value;
        };
        match parameter {
            ModelParameter::Class(ElementClass::Beam, property) => {
                self.beam[property.index()] = value;
            }
            ModelParameter::Class(ElementClass::Link, property) => {
                self.link[property.index()] = value;
            }
            ModelParameter::Section(section, property) => {
                set(&mut self.sections, section, *property);
            }
            ModelParameter::Group(group, property) => set(&mut self.groups, group, *property),
            spring => {
                self.springs.insert(spring.clone(), value);
            }
        }
    }

    /// The same with rigid joints and a base that does not rock. Those of the structure stay: of joints across their axis and
    /// along it, of the base along an axis, of the tool.
    #[must_use]
    pub fn without_springs(&self) -> Self {
        let mut rest = self.clone();
        for (spring, compliance) in &mut rest.springs {
            if spring.is_beside_structure() {
                *compliance = 0.0;
            }
        }
        rest
    }

    /// All parameters beyond the classes that these values name.
    pub fn named(&self) -> impl Iterator<Item = ModelParameter> + '_ {
        type Named = fn(Arc<str>, Property) -> ModelParameter;
        let of = |name: &String, named: Named| {
            let name: Arc<str> = name.as_str().into();
            Property::ALL.map(|property| named(name.clone(), property))
        };
        let sections = self.sections.keys();
        let sections = sections.flat_map(move |name| of(name, ModelParameter::Section));
        let groups = self.groups.keys();
        let groups = groups.flat_map(move |name| of(name, ModelParameter::Group));
        sections.chain(groups).chain(self.springs())
    }

    /// The springs that these values name.
    pub fn springs(&self) -> impl Iterator<Item = ModelParameter> + '_ {
        self.springs.keys().cloned()
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
        let factors = |(name, values): (&String, &[f64; 4])| {
            let entries = Property::ALL.into_iter().zip(values);
            let entries =
                entries.map(|(property, factor)| (property.name().to_owned(), (*factor).into()));
            (name.clone(), toml::Value::Table(entries.collect()))
        };
        let compliances = |entries: BTreeMap<String, f64>| -> toml::Table {
            let entries = entries.into_iter();
            entries.map(|(name, c)| (name, c.into())).collect()
        };
        table("sections", self.sections.iter().map(factors).collect());
        table("groups", self.groups.iter().map(factors).collect());
        let stored = StoredSprings::from(self);
        table("joints_rad_per_Nm", compliances(stored.joints_rad_per_nm));
        let base = ["x", "y", "z"].into_iter().zip(stored.base_rad_per_nm);
        let base = base.filter(|(_, compliance)| *compliance != 0.0);
        table(
            "base_rad_per_Nm",
            base.map(|(axis, c)| (axis.to_owned(), c.into())).collect(),
        );
        table("springs", compliances(stored.springs));
        text
    }
}
