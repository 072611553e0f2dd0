//! Effects and laws as results write them and as they are read back.

use std::borrow::Cow;

use indexmap::IndexMap;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::effect::Effect;
use super::effect_text::{EffectProblem, laws_named, with_parameters};
use super::law::Law;
use super::place::Place;

/// From its name; of several laws of one name the first.
impl<'de> Deserialize<'de> for Law {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let laws = laws_named(&name).map_err(|problem| {
            let help = problem.help().unwrap_or_default();
            D::Error::custom(format!("{problem}: {help}"))
        })?;
        Ok(laws[0])
    }
}

/// An effect as results write it.
#[derive(Serialize, Deserialize, JsonSchema)]
struct EffectObject {
    /// The law.
    physics: Law,
    /// Where it acts.
    place: Place,
    /// Its parameters by name.
    parameters: IndexMap<Cow<'static, str>, EffectParameter>,
}

/// A parameter of an effect as results write it.
#[derive(Serialize, Deserialize, JsonSchema)]
struct EffectParameter {
    /// Its value in `unit`.
    value: f64,
    /// ASCII unit.
    unit: Cow<'static, str>,
}

impl From<Effect> for EffectObject {
    fn from(effect: Effect) -> Self {
        let parameters = effect.parameters().map(|(parameter, value)| {
            let unit = parameter.unit().into();
            (parameter.name.into(), EffectParameter { value, unit })
        });
        Self {
            parameters: parameters.collect(),
            physics: effect.law,
            place: effect.place,
        }
    }
}

impl TryFrom<EffectObject> for Effect {
    type Error = EffectProblem;

    fn try_from(object: EffectObject) -> Result<Self, EffectProblem> {
        let laws: Vec<Law> = Law::named(object.physics.name).collect();
        let place = object.place.of(object.physics.place_kind);
        let given = object.parameters.iter();
        let given: Vec<_> = given
            .map(|(name, one)| (&**name, one.value, &*one.unit))
            .collect();
        with_parameters(&laws, place, &given)
    }
}

impl Serialize for Effect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        EffectObject::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Effect {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let object = EffectObject::deserialize(deserializer)?;
        Self::try_from(object).map_err(D::Error::custom)
    }
}

impl JsonSchema for Effect {
    fn schema_name() -> Cow<'static, str> {
        "Effect".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        EffectObject::json_schema(generator)
    }
}
