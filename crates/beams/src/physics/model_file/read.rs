//! From the text of a model file to the model.

use std::ops::Range;

use toml::de::DeValue;

use crate::physics::EffectError;
use crate::physics::dimension::Dimension;
use crate::physics::effect_text::{
    EffectProblem, laws_at, laws_named, only_place, parameter_named, with_parameters,
};
use crate::physics::law::Law;
use crate::physics::place::{Place, PlaceKind};
use crate::robot::{FittingFactors, ModelParameter, SpringAxis};
use crate::structure::Property;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::{Direction, DirectionName, PoseId};
use stiffbench_units_and_text::toml_text::{TomlDocument, TomlTable, TomlValue};

use super::error::ModelFileError;
use super::{FoundEffect, MODEL_SCHEMA, ModelFile, ParameterUncertainty, Provenance};

type ModelRead<T> = Result<T, ModelFileError>;

/// A value of a parameter as it stands in the file.
struct Written<'a> {
    name: &'static str,
    number: f64,
    unit: &'a str,
    table: TomlTable<'a>,
}

pub(super) fn model(source: &SourceText) -> ModelRead<ModelFile> {
    let document = TomlDocument::parse(source)?;
    let root = document.root();
    // The schema first: of a newer version the other keys may be anything.
    root.check_schema(MODEL_SCHEMA, true)?;
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
    let effects = |key| -> ModelRead<Vec<FoundEffect>> {
        let tables = root.read_all(key, TomlValue::table)?;
        tables.iter().map(effect).collect()
    };
    Ok(ModelFile {
        robot: text(&root, "robot")?,
        robot_sha256: text(&root, "robot_sha256")?,
        mechanism: text(&root, "mechanism")?,
        provenance: provenance(&root)?,
        factors: root
            .get("factors")
            .as_ref()
            .map(factor_tables)
            .transpose()?,
        effects: effects("effects")?,
        alternatives: effects("alternatives")?,
    })
}

fn text(table: &TomlTable<'_>, key: &str) -> ModelRead<Option<String>> {
    Ok(table.read(key, TomlValue::text)?.map(str::to_owned))
}

fn error(table: &TomlTable<'_>, span: Range<usize>, problem: EffectProblem) -> ModelFileError {
    ModelFileError::new(table.source(), span, problem.into())
}

fn provenance(root: &TomlTable<'_>) -> ModelRead<Provenance> {
    let Some(table) = root.read("provenance", TomlValue::table)? else {
        return Ok(Provenance::default());
    };
    table.only(&["session", "software", "verdict"])?;
    Ok(Provenance {
        session: text(&table, "session")?,
        software: text(&table, "software")?,
        verdict: text(&table, "verdict")?,
    })
}

fn factor_tables(value: &TomlValue<'_>) -> ModelRead<FittingFactors> {
    let table = value.table()?;
    table.only(&[
        "beam",
        "link",
        "sections",
        "groups",
        "joints_rad_per_Nm",
        "base_rad_per_Nm",
        "springs",
    ])?;
    let four = |value: &TomlValue<'_>| -> ModelRead<[f64; 4]> {
        let keys = Property::ALL.map(Property::name);
        let class = value.table()?;
        class.only(&keys)?;
        let mut factors = [0.0; 4];
        for (factor, key) in factors.iter_mut().zip(keys) {
            let value = class.require(key)?;
            *factor = value.number()?;
            if *factor <= 0.0 {
                return Err(value.wrong("above zero").into());
            }
        }
        Ok(factors)
    };
    let mut factors = FittingFactors::of_classes(
        four(&table.require("beam")?)?,
        four(&table.require("link")?)?,
    );
    if let Some(sections) = table.read("sections", TomlValue::table)? {
        for (name, _, value) in sections.entries() {
            factors.sections.insert(name.to_owned(), four(&value)?);
        }
    }
    if let Some(groups) = table.read("groups", TomlValue::table)? {
        for (name, _, value) in groups.entries() {
            factors.groups.insert(name.to_owned(), four(&value)?);
        }
    }
    let compliance = |value: &TomlValue<'_>| -> ModelRead<f64> {
        let compliance = value.number()?;
        if compliance < 0.0 {
            return Err(value.wrong("zero or above").into());
        }
        Ok(compliance)
    };
    if let Some(joints) = table.read("joints_rad_per_Nm", TomlValue::table)? {
        for (name, _, value) in joints.entries() {
            let joint = ModelParameter::Joint(name.into());
            factors.springs.insert(joint, compliance(&value)?);
        }
    }
    if let Some(base) = table.read("base_rad_per_Nm", TomlValue::table)? {
        base.only(&["x", "y", "z"])?;
        for axis in Direction::ALL {
            if let Some(value) = base.get(&axis.to_string()) {
                let spring = ModelParameter::Base(SpringAxis::about(axis));
                factors.springs.insert(spring, compliance(&value)?);
            }
        }
    }
    if let Some(springs) = table.read("springs", TomlValue::table)? {
        for (name, _, value) in springs.entries() {
            let spring = ModelParameter::spring_named(name).map_err(|_| {
                value.wrong("that of a spring, such as joint.J2.y, base.x or tool.rz")
            })?;
            factors.springs.insert(spring, compliance(&value)?);
        }
    }
    Ok(factors)
}

fn effect(table: &TomlTable<'_>) -> ModelRead<FoundEffect> {
    table.only(&["physics", "place", "parameters", "alternative_group"])?;
    let name_value = table.require("physics")?;
    let problem = |span, problem| error(table, span, problem);
    let laws = laws_named(name_value.text()?).map_err(|wrong| problem(name_value.span(), wrong))?;
    let place = match (table.get("place"), only_place(&laws)) {
        (None, Some(only)) => only,
        (None, None) => {
            let (law, expected) = (laws[0], laws[0].place_kind.in_words());
            return Err(problem(
                table.span(),
                EffectProblem::NoPlace { law, expected },
            ));
        }
        (Some(value), _) => {
            let mut places = laws.iter().map(|law| place(*law, &value));
            let first = places.next().expect("a name has a law");
            first.or_else(|error| places.find_map(Result::ok).ok_or(error))?
        }
    };
    let written = parameters(table, &laws_at(&laws, &place))?;
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
        .parameters_at(&effect.place)
        .map(|spec| {
            let value = written.iter().find(|value| value.name == spec.name);
            value.map_or(Ok(ParameterUncertainty::default()), |value| {
                uncertainty(value, spec.dimension)
            })
        })
        .collect::<ModelRead<_>>()?;
    Ok(FoundEffect {
        effect,
        uncertainties,
        alternative_group: table.read("alternative_group", TomlValue::count)?,
    })
}

/// The values of an effect, each `{ value, unit }` and what is known of it.
fn parameters<'a>(table: &TomlTable<'a>, laws: &[Law]) -> ModelRead<Vec<Written<'a>>> {
    let Some(parameters) = table.read("parameters", TomlValue::table)? else {
        return Ok(Vec::new());
    };
    let mut written = Vec::new();
    for (key, span, value) in parameters.entries() {
        let spec = parameter_named(laws, key).map_err(|wrong| error(table, span, wrong))?;
        let entry = value.table()?;
        entry.only(&["value", "unit", "u", "dof", "ci95"])?;
        let unit = entry.require("unit")?.text()?;
        written.push(Written {
            name: spec.name,
            number: entry.require("value")?.number()?,
            unit,
            table: entry,
        });
    }
    Ok(written)
}

/// Known properties of a value, in SI.
fn uncertainty(value: &Written<'_>, dimension: Dimension) -> ModelRead<ParameterUncertainty> {
    let table = &value.table;
    let number = |key: &str| -> ModelRead<Option<f64>> {
        Ok(table.read(key, |value| {
            let number = value.number()?;
            if number < 0.0 {
                return Err(value.wrong("not below zero"));
            }
            Ok(number)
        })?)
    };
    let scaled = |number: f64| dimension.in_si(number, value.unit).unwrap_or(number);
    let ci95 = table.read("ci95", |interval| {
        let wrong = || interval.wrong("an array of two numbers, the smaller first");
        let ends = interval.items().map_err(|_| wrong())?;
        let [low, high] = &ends[..] else {
            return Err(wrong());
        };
        let (low, high) = (low.number()?, high.number()?);
        if low > high {
            return Err(wrong());
        }
        Ok([scaled(low), scaled(high)])
    });
    Ok(ParameterUncertainty {
        u: number("u")?.map(scaled),
        dof: number("dof")?,
        ci95: ci95?,
    })
}

/// The place of a law, in the form that JSON has too.
fn place(law: Law, value: &TomlValue<'_>) -> ModelRead<Place> {
    let table = value.table()?;
    let direction = |key: &str| direction(&table, key);
    let name = |key: &str| name(&table, key).map(str::to_owned);
    // A place with one possible value: the file must agree with it.
    let fixed = |key: &'static str, expected: &'static str, there: Place| -> ModelRead<Place> {
        let value = table.require(key)?;
        let agrees = match value.parsed() {
            DeValue::Boolean(yes) => *yes && expected == "true",
            DeValue::String(word) => format!("\"{word}\"") == expected,
            _ => false,
        };
        let there = agrees.then_some(there);
        there.ok_or_else(|| value.wrong(expected).into())
    };
    match law.place_kind {
        PlaceKind::Joint => {
            table.only(&["joint"])?;
            name("joint").map(Place::Joint)
        }
        PlaceKind::AcrossJoint => {
            table.only(&["joint", "axis"])?;
            let (joint, axis) = (name("joint")?, direction("axis")?);
            Ok(Place::AcrossJoint { joint, axis })
        }
        PlaceKind::ToolAbout | PlaceKind::ToolAlong => tool(&table, law.place_kind),
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
                return Err(value.wrong("another axis than the direction").into());
            }
            Ok(Place::Toward {
                direction: along,
                toward,
            })
        }
        PlaceKind::ForceGauge => {
            table.only(&["gauge"])?;
            fixed("gauge", "\"force\"", Place::ForceGauge)
        }
        PlaceKind::DisplacementGauge => {
            let there = Place::DisplacementGauge(one_of_gauges(&table, ["gauge", "direction"])?);
            fixed("gauge", "\"displacement\"", there)
        }
        PlaceKind::Structure => {
            table.only(&["structure"])?;
            fixed("structure", "true", Place::Structure)
        }
        PlaceKind::Clock => {
            let there = Place::Clock(one_of_gauges(&table, ["clock", "direction"])?);
            fixed("clock", "true", there)
        }
        PlaceKind::Run => run(&table),
        PlaceKind::Length => {
            table.only(&["body", "entry"])?;
            let (body, entry) = (name("body")?, name("entry")?);
            Ok(Place::Length { body, entry })
        }
        PlaceKind::JointAngle => {
            table.only(&["joint", "pose"])?;
            let pose = table.get("pose").map(|_| name("pose")).transpose()?;
            Ok(Place::JointAngle {
                joint: name("joint")?,
                pose: pose.as_deref().map(PoseId::new),
            })
        }
        PlaceKind::Group => {
            table.only(&["group", "property"])?;
            let known = |value: &TomlValue<'_>| {
                let text = value.text()?;
                let named = Property::ALL
                    .into_iter()
                    .find(|property| property.name() == text);
                named.ok_or_else(|| value.wrong("A, Iy, Iz or J"))
            };
            Ok(Place::Group {
                group: name("group")?,
                property: table.read("property", known)?,
            })
        }
        PlaceKind::Mechanism => {
            table.only(&["mechanism"])?;
            name("mechanism").map(Place::Mechanism)
        }
    }
}

fn tool(place: &TomlTable<'_>, kind: PlaceKind) -> ModelRead<Place> {
    place.only(&["tool"])?;
    let axis = place.require("tool")?;
    let there = kind.read(axis.text()?);
    there.ok_or_else(|| axis.wrong(kind.in_words()).into())
}

fn direction(table: &TomlTable<'_>, key: &str) -> ModelRead<Direction> {
    let value = table.require(key)?;
    let text = value.parsed().as_str().and_then(|text| text.parse().ok());
    text.ok_or_else(|| value.wrong("\"x\", \"y\" or \"z\"").into())
}

fn name<'a>(table: &TomlTable<'a>, key: &str) -> ModelRead<&'a str> {
    let value = table.require(key)?;
    let text = value.parsed().as_str().filter(|name| !name.is_empty());
    text.ok_or_else(|| value.wrong("a name in quotes").into())
}

/// The axis of one of several gauges, if there is one; the other key of the place is for the caller.
fn one_of_gauges(place: &TomlTable<'_>, keys: [&'static str; 2]) -> ModelRead<Option<Direction>> {
    place.only(&keys)?;
    let axis = place
        .get("direction")
        .map(|_| direction(place, "direction"));
    axis.transpose()
}

fn run(place: &TomlTable<'_>) -> ModelRead<Place> {
    place.only(&["run", "step", "direction"])?;
    let run = place.require("run")?.table()?;
    run.only(&["pose", "direction", "repeat"])?;
    Ok(Place::Run {
        pose: PoseId::new(name(&run, "pose")?),
        direction: DirectionName::new(name(&run, "direction")?),
        repeat: run.require("repeat")?.count()?,
        step: place.require("step")?.count()?,
        gauge: place
            .get("direction")
            .map(|_| direction(place, "direction"))
            .transpose()?,
    })
}
