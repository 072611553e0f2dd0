//! From the text of a model file to the model.

use toml::de::{DeTable, DeValue};

use crate::physics::EffectError;
use crate::physics::dimension::Dimension;
use crate::physics::effect_text::{EffectProblem, laws_named, parameter_named, with_parameters};
use crate::physics::law::Law;
use crate::physics::place::{Place, PlaceKind};
use crate::robot::FittingFactors;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::error::{ModelFileError, ModelProblem};
use super::table::{Table, Value};
use super::{FoundEffect, MODEL_SCHEMA, ModelFile, ParameterUncertainty, Provenance};

type Read<T> = Result<T, ModelFileError>;

/// A value of a parameter as it stands in the file.
struct Written<'a> {
    name: &'static str,
    number: f64,
    unit: &'a str,
    table: Table<'a>,
}

pub(super) fn model(source: &SourceText) -> Read<ModelFile> {
    let parsed = DeTable::parse(&source.text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        ModelFileError::at(
            source,
            span,
            ModelProblem::Syntax(error.message().to_owned()),
        )
    })?;
    let root = Table::root(source, parsed.get_ref());
    // The schema first: of a newer version the other keys may be anything.
    schema(&root)?;
    root.only(&[
        "schema",
        "robot",
        "robot_sha256",
        "mechanism",
        "provenance",
        "factors",
        "effects",
        "alternatives",
    ])?;
    let text = |key| Ok(root.text(key)?.map(str::to_owned));
    let factors = root.get("factors");
    let effects =
        |key| -> Read<Vec<FoundEffect>> { root.tables(key)?.iter().map(effect).collect() };
    Ok(ModelFile {
        robot: text("robot")?,
        robot_sha256: text("robot_sha256")?,
        mechanism: text("mechanism")?,
        provenance: provenance(&root)?,
        factors: factors
            .map(|value| factor_tables(&root, value))
            .transpose()?,
        effects: effects("effects")?,
        alternatives: effects("alternatives")?,
    })
}

fn schema(root: &Table<'_>) -> Read<()> {
    let value = root.require("schema")?;
    if value.get_ref().as_str() == Some(MODEL_SCHEMA) {
        return Ok(());
    }
    let found = root.text("schema")?.unwrap_or_default().to_owned();
    let expected = MODEL_SCHEMA;
    Err(root.error(value.span(), ModelProblem::Schema { found, expected }))
}

fn provenance(root: &Table<'_>) -> Read<Provenance> {
    let Some(value) = root.get("provenance") else {
        return Ok(Provenance::default());
    };
    let table = root.table("provenance", value)?;
    table.only(&["session", "software", "verdict"])?;
    let text = |key| Ok(table.text(key)?.map(str::to_owned));
    Ok(Provenance {
        session: text("session")?,
        software: text("software")?,
        verdict: text("verdict")?,
    })
}

fn factor_tables(root: &Table<'_>, value: &Value<'_>) -> Read<FittingFactors> {
    let table = root.table("factors", value)?;
    table.only(&["beam", "link"])?;
    let class = |name: &'static str| -> Read<[f64; 4]> {
        const KEYS: [&str; 4] = ["A", "Iy", "Iz", "J"];
        let class = table.table(name, table.require(name)?)?;
        class.only(&KEYS)?;
        let mut factors = [0.0; 4];
        for (factor, key) in factors.iter_mut().zip(KEYS) {
            let value = class.require(key)?;
            *factor = class.number(key, value)?;
            if *factor <= 0.0 {
                return Err(class.wrong(key, value, "above zero"));
            }
        }
        Ok(factors)
    };
    Ok(FittingFactors {
        beam: class("beam")?,
        link: class("link")?,
    })
}

fn effect(table: &Table<'_>) -> Read<FoundEffect> {
    table.only(&["physics", "place", "parameters", "alternative_group"])?;
    let name_value = table.require("physics")?;
    let name = table.text("physics")?.unwrap_or_default();
    let problem = |span, problem| table.error(span, ModelProblem::Effect(problem));
    let laws = laws_named(name).map_err(|wrong| problem(name_value.span(), wrong))?;
    let place = match (table.get("place"), laws[0].place_kind.only()) {
        (None, Some(only)) => only,
        (None, None) => {
            let (law, expected) = (laws[0], laws[0].place_kind.in_words());
            return Err(problem(
                table.span(),
                EffectProblem::NoPlace { law, expected },
            ));
        }
        (Some(value), _) => place(table, laws[0], value)?,
    };
    let written = parameters(table, laws[0])?;
    let given: Vec<(&str, f64, &str)> = written
        .iter()
        .map(|value| (value.name, value.number, value.unit))
        .collect();
    let effect = with_parameters(&laws, place, &given).map_err(|wrong| {
        // Where a value is at fault, its own place; else that of all of them.
        let name = match &wrong {
            EffectProblem::Unit { name, .. } => Some(*name),
            EffectProblem::Impossible(EffectError::Impossible { parameter, .. }) => {
                Some(*parameter)
            }
            _ => None,
        };
        let value = written.iter().find(|value| Some(value.name) == name);
        let span = value.map_or_else(|| table.span(), |value| value.table.span());
        problem(span, wrong)
    })?;
    let uncertainties = effect
        .law
        .parameters
        .iter()
        .map(|spec| {
            let value = written.iter().find(|value| value.name == spec.name);
            value.map_or(Ok(ParameterUncertainty::default()), |value| {
                uncertainty(value, spec.dimension)
            })
        })
        .collect::<Read<_>>()?;
    let group = table.get("alternative_group");
    let group = group.map(|value| table.count("alternative_group", value));
    Ok(FoundEffect {
        effect,
        uncertainties,
        alternative_group: group.transpose()?,
    })
}

/// The values of an effect, each `{ value, unit }` and what is known of it.
fn parameters<'a>(table: &Table<'a>, law: Law) -> Read<Vec<Written<'a>>> {
    let Some(value) = table.get("parameters") else {
        return Ok(Vec::new());
    };
    let parameters = table.table("parameters", value)?;
    let mut written = Vec::new();
    for (key, span, value) in parameters.entries() {
        let spec = parameter_named(law, key)
            .map_err(|wrong| table.error(span, ModelProblem::Effect(wrong)))?;
        let entry = parameters.table(key, value)?;
        entry.only(&["value", "unit", "u", "dof", "ci95"])?;
        entry.require("unit")?;
        written.push(Written {
            name: spec.name,
            number: entry.number("value", entry.require("value")?)?,
            unit: entry.text("unit")?.unwrap_or_default(),
            table: entry,
        });
    }
    Ok(written)
}

/// What is known of a value, in SI.
fn uncertainty(value: &Written<'_>, dimension: Dimension) -> Read<ParameterUncertainty> {
    let table = &value.table;
    let number = |key: &str| -> Read<Option<f64>> {
        let number = table.get(key).map(|value| {
            let number = table.number(key, value)?;
            if number < 0.0 {
                return Err(table.wrong(key, value, "not below zero"));
            }
            Ok(number)
        });
        number.transpose()
    };
    let scaled = |number: f64| dimension.in_si(number, value.unit).unwrap_or(number);
    let ci95 = table.get("ci95").map(|interval| {
        let expected = "an array of two numbers, the smaller first";
        let DeValue::Array(ends) = interval.get_ref() else {
            return Err(table.wrong("ci95", interval, expected));
        };
        let (Some(low), Some(high), 2) = (ends.first(), ends.get(1), ends.len()) else {
            return Err(table.wrong("ci95", interval, expected));
        };
        let (low, high) = (table.number("ci95", low)?, table.number("ci95", high)?);
        if low > high {
            return Err(table.wrong("ci95", interval, expected));
        }
        Ok([scaled(low), scaled(high)])
    });
    Ok(ParameterUncertainty {
        u: number("u")?.map(scaled),
        dof: number("dof")?,
        ci95: ci95.transpose()?,
    })
}

/// The place of a law, in the form that JSON has too.
fn place(effect: &Table<'_>, law: Law, value: &Value<'_>) -> Read<Place> {
    let table = effect.table("place", value)?;
    let direction = |key: &'static str| -> Read<Direction> {
        let value = table.require(key)?;
        let text = value.get_ref().as_str().and_then(|text| text.parse().ok());
        text.ok_or_else(|| table.wrong(key, value, "\"x\", \"y\" or \"z\""))
    };
    let name = |key: &'static str| -> Read<String> {
        let value = table.require(key)?;
        let text = value.get_ref().as_str().filter(|name| !name.is_empty());
        text.map(str::to_owned)
            .ok_or_else(|| table.wrong(key, value, "a name in quotes"))
    };
    // A place that can only be this: what the file says of it must agree.
    let fixed = |key: &'static str, expected: &'static str, there: Place| -> Read<Place> {
        table.only(&[key])?;
        let value = table.require(key)?;
        let agrees = match value.get_ref() {
            DeValue::Boolean(yes) => *yes && expected == "true",
            DeValue::String(word) => format!("\"{word}\"") == expected,
            _ => false,
        };
        let there = agrees.then_some(there);
        there.ok_or_else(|| table.wrong(key, value, expected))
    };
    match law.place_kind {
        PlaceKind::Joint => {
            table.only(&["joint"])?;
            name("joint").map(Place::Joint)
        }
        PlaceKind::Element => {
            table.only(&["element"])?;
            name("element").map(Place::Element)
        }
        PlaceKind::Axis => {
            table.only(&["axis"])?;
            direction("axis").map(Place::Axis)
        }
        PlaceKind::Direction => {
            table.only(&["direction"])?;
            direction("direction").map(Place::Direction)
        }
        PlaceKind::Toward => {
            table.only(&["direction", "toward"])?;
            let (along, toward) = (direction("direction")?, direction("toward")?);
            if along == toward {
                let value = table.require("toward")?;
                return Err(table.wrong("toward", value, "another axis than the direction"));
            }
            Ok(Place::Toward {
                direction: along,
                toward,
            })
        }
        PlaceKind::ForceGauge => fixed("gauge", "\"force\"", Place::ForceGauge),
        PlaceKind::DisplacementGauge => {
            fixed("gauge", "\"displacement\"", Place::DisplacementGauge)
        }
        PlaceKind::Structure => fixed("structure", "true", Place::Structure),
        PlaceKind::Clock => fixed("clock", "true", Place::Clock),
        PlaceKind::Run => run(&table),
    }
}

fn run(place: &Table<'_>) -> Read<Place> {
    place.only(&["run", "step"])?;
    let run = place.table("run", place.require("run")?)?;
    run.only(&["pose", "direction", "repeat"])?;
    let direction = run.require("direction")?;
    let axis = direction
        .get_ref()
        .as_str()
        .and_then(|text| text.parse().ok());
    let pose = run.require("pose")?;
    let name = pose.get_ref().as_str().filter(|name| !name.is_empty());
    Ok(Place::Run {
        pose: PoseId::new(name.ok_or_else(|| run.wrong("pose", pose, "a name in quotes"))?),
        direction: axis
            .ok_or_else(|| run.wrong("direction", direction, "\"x\", \"y\" or \"z\""))?,
        repeat: run.count("repeat", run.require("repeat")?)?,
        step: place.count("step", place.require("step")?)?,
    })
}
