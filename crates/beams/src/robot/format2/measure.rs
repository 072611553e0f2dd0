//! Numbers with the unit that their key ends in: `at_mm`, `E_GPa`, `stiffness_Nm_per_rad`. Without a unit they are SI, angles in degrees.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde_json::Value;

use stiffbench_units_and_text::toml_text::split_unit;

use crate::robot::expression::Expression;

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredKind {
    /// m.
    Length,
    /// Degrees.
    Angle,
    /// kg.
    Mass,
    /// N.
    Force,
    /// N·m/rad.
    TurningStiffness,
    /// N/m.
    Stiffness,
    /// rad/(N·m).
    TurningCompliance,
    /// m/N.
    Compliance,
    /// Pa.
    Modulus,
    /// kg/m³.
    Density,
    /// kg/m.
    MassPerLength,
    /// m².
    Area,
    /// m⁴.
    SecondMoment,
}

/// From a unit to SI; by division where the factor has no exact value.
#[derive(Debug, Clone, Copy)]
enum UnitConversion {
    Times(f64),
    Over(f64),
}

use MeasuredKind::{
    Angle, Area, Compliance, Density, Force, Length, Mass, MassPerLength, Modulus, SecondMoment,
    Stiffness, TurningCompliance, TurningStiffness,
};
use UnitConversion::{Over, Times};

/// Units that a key may end in, the one without prefix of each kind first.
#[rustfmt::skip]
const UNITS: [(&str, MeasuredKind, UnitConversion); 34] = [
    ("m", Length, Times(1.0)), ("mm", Length, Over(1e3)), ("cm", Length, Over(1e2)), ("um", Length, Over(1e6)),
    ("deg", Angle, Times(1.0)), ("rad", Angle, Times(180.0 / std::f64::consts::PI)),
    ("kg", Mass, Times(1.0)), ("g", Mass, Over(1e3)),
    ("N", Force, Times(1.0)), ("kN", Force, Times(1e3)),
    ("Nm_per_rad", TurningStiffness, Times(1.0)), ("kNm_per_rad", TurningStiffness, Times(1e3)),
    ("MNm_per_rad", TurningStiffness, Times(1e6)), ("Nm_per_deg", TurningStiffness, Times(180.0 / std::f64::consts::PI)),
    ("N_per_m", Stiffness, Times(1.0)), ("N_per_mm", Stiffness, Times(1e3)), ("N_per_um", Stiffness, Times(1e6)),
    ("kN_per_mm", Stiffness, Times(1e6)),
    ("rad_per_Nm", TurningCompliance, Times(1.0)), ("urad_per_Nm", TurningCompliance, Over(1e6)),
    ("m_per_N", Compliance, Times(1.0)), ("um_per_N", Compliance, Over(1e6)), ("mm_per_N", Compliance, Over(1e3)),
    ("Pa", Modulus, Times(1.0)), ("MPa", Modulus, Times(1e6)), ("GPa", Modulus, Times(1e9)),
    ("kg_per_m3", Density, Times(1.0)),
    ("kg_per_m", MassPerLength, Times(1.0)),
    ("m2", Area, Times(1.0)), ("mm2", Area, Over(1e6)), ("cm2", Area, Over(1e4)),
    ("m4", SecondMoment, Times(1.0)), ("mm4", SecondMoment, Over(1e12)), ("cm4", SecondMoment, Over(1e8)),
];

/// Names of all units.
#[must_use]
pub fn units() -> Vec<&'static str> {
    UNITS.iter().map(|(name, ..)| *name).collect()
}

/// What a unit measures, and its size in SI; `None` for one that is not known.
#[must_use]
pub fn unit_in_si(unit: &str) -> Option<(MeasuredKind, f64)> {
    let known = UNITS.iter().find(|(name, ..)| *name == unit);
    known.map(|(_, kind, conversion)| match conversion {
        Times(factor) => (*kind, *factor),
        Over(divisor) => (*kind, divisor.recip()),
    })
}

/// Units of some kinds.
fn units_of(kinds: &[MeasuredKind]) -> Vec<&'static str> {
    let units = UNITS.iter().filter(|(_, kind, _)| kinds.contains(kind));
    units.map(|(name, ..)| *name).collect()
}

/// What the numbers of a key may measure.
pub trait Measurable {
    /// Name of the schema.
    const NAME: &'static str;
    /// The kinds; several where another key decides between them.
    const KINDS: &'static [MeasuredKind];
    /// Whether it may be a sum of parameters.
    const IS_EXPRESSION: bool = false;
}

macro_rules! measurable {
    ($($(#[$doc:meta])* $marker:ident: [$($kind:ident),+] $(, $expression:ident)?;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $marker;

        impl Measurable for $marker {
            const NAME: &'static str = stringify!($marker);
            const KINDS: &'static [MeasuredKind] = &[$(MeasuredKind::$kind),+];
            $(const IS_EXPRESSION: bool = measurable!(@$expression);)?
        }
    )+};
    (@expression) => { true };
}

measurable! {
    /// A length, m.
    LengthOf: [Length], expression;
    /// An angle, degrees.
    AngleOf: [Angle], expression;
    /// A length or an angle: a travel of a sliding joint, m, an angle of another, degrees.
    TravelOf: [Length, Angle], expression;
    /// A mass, kg.
    MassOf: [Mass];
    /// A force, N.
    ForceOf: [Force];
    /// A stiffness, N·m/rad or N/m.
    StiffnessOf: [TurningStiffness, Stiffness];
    /// A compliance, rad/(N·m) or m/N.
    ComplianceOf: [TurningCompliance, Compliance];
    /// An elastic modulus, Pa.
    ModulusOf: [Modulus];
    /// A density, kg/m³.
    DensityOf: [Density];
    /// A mass per length, kg/m.
    MassPerLengthOf: [MassPerLength];
    /// An area, m².
    AreaOf: [Area];
    /// A second moment of area, m⁴.
    SecondMomentOf: [SecondMoment];
}

/// A number, or a signed sum of numbers and parameters, in SI (angles in degrees).
#[derive(Debug, Clone, PartialEq)]
pub struct InUnit<K> {
    /// The value.
    pub value: Expression,
    /// What its unit measures; `None` if its key has no unit.
    pub kind: Option<MeasuredKind>,
    of: PhantomData<K>,
}

impl<K> InUnit<K> {
    /// The number; NaN of a sum of parameters.
    #[must_use]
    pub fn number(&self) -> f64 {
        match self.value {
            Expression::Number(number) => number,
            Expression::Text(_) => f64::NAN,
        }
    }
}

impl<'de, K: Measurable> Deserialize<'de> for InUnit<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(MeasuredVisitor(PhantomData))
    }
}

struct MeasuredVisitor<K>(PhantomData<K>);

impl<K: Measurable> Visitor<'_> for MeasuredVisitor<K> {
    type Value = InUnit<K>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")?;
        if K::IS_EXPRESSION {
            f.write_str(" or text such as \"a + b\"")?;
        }
        Ok(())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<InUnit<K>, E> {
        Ok(InUnit {
            value: Expression::Number(value),
            kind: None,
            of: PhantomData,
        })
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<InUnit<K>, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<InUnit<K>, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<InUnit<K>, E> {
        let (text, unit) = split_unit(text);
        let value = match text.parse() {
            // What TOML takes for a number came here with its unit; a text in quotes is none.
            Ok(number) if unit.is_some() => Expression::Number(number),
            _ if K::IS_EXPRESSION => Expression::Text(text.to_owned()),
            _ => return Err(E::invalid_type(serde::de::Unexpected::Str(text), &self)),
        };
        let Some(unit) = unit else {
            return Ok(InUnit {
                value,
                kind: None,
                of: PhantomData,
            });
        };
        let found = UNITS.iter().find(|(name, ..)| *name == unit);
        let Some((_, kind, conversion)) = found.filter(|(_, kind, _)| K::KINDS.contains(kind))
        else {
            let known = units_of(K::KINDS).join(", ");
            return Err(E::custom(format_args!(
                "`{unit}` is not a unit of this key: it may end in {known}"
            )));
        };
        let convert = |number: f64| match conversion {
            Times(factor) => number * factor,
            Over(divisor) => number / divisor,
        };
        Ok(InUnit {
            value: value.with_numbers(&convert),
            kind: Some(*kind),
            of: PhantomData,
        })
    }
}

/// Key of a schema under which the units stand until the keys with units are written out.
const UNITS_OF_KEY: &str = "x-units";

impl<K: Measurable> JsonSchema for InUnit<K> {
    fn schema_name() -> Cow<'static, str> {
        K::NAME.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let units = units_of(K::KINDS);
        if K::IS_EXPRESSION {
            json_schema!({ "type": ["number", "string"], UNITS_OF_KEY: units })
        } else {
            json_schema!({ "type": "number", UNITS_OF_KEY: units })
        }
    }
}

/// Gives every key of a measured value in a schema its forms with units beside it.
pub(super) fn write_units(schema: &mut Value) {
    let definitions = schema["$defs"].clone();
    write_units_of(schema, &definitions);
    if let Some(definitions) = schema["$defs"].as_object_mut() {
        for definition in definitions.values_mut() {
            if let Some(object) = definition.as_object_mut() {
                object.shift_remove(UNITS_OF_KEY);
            }
        }
    }
}

fn write_units_of(schema: &mut Value, definitions: &Value) {
    match schema {
        Value::Array(entries) => {
            for entry in entries {
                write_units_of(entry, definitions);
            }
        }
        Value::Object(object) => {
            for value in object.values_mut() {
                write_units_of(value, definitions);
            }
            let Some(Value::Object(properties)) = object.get("properties").cloned() else {
                return;
            };
            let mut written = serde_json::Map::new();
            let mut choices = Vec::new();
            for (key, value) in properties {
                let keys: Vec<String> = units_in(&value, definitions)
                    .iter()
                    .map(|unit| format!("{key}_{unit}"))
                    .collect();
                for key in &keys {
                    written.insert(key.clone(), value.clone());
                }
                if let Some(Value::Array(required)) = object.get_mut("required")
                    && !keys.is_empty()
                    && let Some(place) = required.iter().position(|name| *name == *key)
                {
                    required.remove(place);
                    let keys = std::iter::once(&key).chain(&keys);
                    let one: Vec<Value> = keys
                        .map(|key| serde_json::json!({ "required": [key] }))
                        .collect();
                    choices.push(serde_json::json!({ "oneOf": one }));
                }
                written.insert(key, value);
            }
            object.insert("properties".to_owned(), Value::Object(written));
            if !choices.is_empty() {
                object.insert("allOf".to_owned(), Value::Array(choices));
            }
        }
        _ => {}
    }
}

/// Units of the numbers that a schema describes: its own, or those of its entries.
fn units_in(schema: &Value, definitions: &Value) -> Vec<String> {
    let reference = schema.get("$ref").and_then(Value::as_str);
    if let Some(name) = reference.and_then(|text| text.strip_prefix("#/$defs/")) {
        let units = definitions[name][UNITS_OF_KEY].as_array();
        let units = units.into_iter().flatten().filter_map(Value::as_str);
        return units.map(str::to_owned).collect();
    }
    let parts = schema.get("anyOf").and_then(Value::as_array);
    let parts = parts.into_iter().flatten().chain(schema.get("items"));
    parts
        .map(|part| units_in(part, definitions))
        .find(|units| !units.is_empty())
        .unwrap_or_default()
}
