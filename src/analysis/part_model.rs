//! The model of a part as a file: schema `stiffbench/part-model/2`. `part diagnose` writes it, `part predict` reads it.
//!
//! Numbers stand in the units of the table that the model was fitted to. A key that is not known is an error.

use indexmap::IndexMap;
use miette::Diagnostic;
use serde::{Deserialize, Serialize};

use crate::mismatch::{PartBand, PartConfiguration, PartModel, PartUnits, test_object};
use crate::nearest::listed_names;
use crate::physics::{Effect, Law, Place};
use crate::specimen::{ColumnUnit, ResponseVariable, SpecimenOptions, SpecimenTable};

/// The only schema known to this version.
const PART_MODEL_SCHEMA: &str = "stiffbench/part-model/2";

/// A file that holds no model of a part, or one that cannot be.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum PartModelError {
    /// It is no TOML with these keys.
    #[error("{file}: {problem}")]
    #[diagnostic(
        code(stiffbench::part_model::unreadable),
        help(
            "stiffbench part diagnose TABLE --map … --out FOLDER writes a model of a part; that of a robot is for --model of other commands"
        )
    )]
    Unreadable {
        /// The file.
        file: String,
        /// What is wrong, with line and column where they are known.
        problem: String,
    },
    /// A value that means nothing.
    #[error("{file}: {key} is {value}, expected {expected}")]
    #[diagnostic(
        code(stiffbench::part_model::bad_value),
        help("write the model again: stiffbench part diagnose TABLE --map … --out FOLDER")
    )]
    BadValue {
        /// The file.
        file: String,
        /// The key.
        key: String,
        /// Its value.
        value: String,
        /// What it may be.
        expected: String,
    },
    /// A table measures something else than the model.
    #[error("{file}: column of the {quantity} is in {unit}, and the model in {expected}")]
    #[diagnostic(
        code(stiffbench::part_model::other_unit),
        help("name the unit behind the column's name, for example force_kN")
    )]
    OtherUnit {
        /// The table.
        file: String,
        /// Force or displacement.
        quantity: &'static str,
        /// Unit of the table.
        unit: String,
        /// Unit of the model.
        expected: String,
    },
    /// A configuration that the model does not have.
    #[error("{file}: the model has no configuration `{configuration}`; it has {known}")]
    #[diagnostic(
        code(stiffbench::part_model::unknown_configuration),
        help(
            "a line is known for the configurations of the fit only: leave these rows out, or diagnose a table that holds them"
        )
    )]
    UnknownConfiguration {
        /// The table.
        file: String,
        /// Its name.
        configuration: String,
        /// Those of the model, in backquotes.
        known: String,
    },
}

/// A model of a part, with how a table for it is read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartModelFile {
    schema: String,
    /// Program and version that wrote it.
    software: String,
    /// Verdict of the diagnosis.
    pub verdict: String,
    /// The table that was diagnosed, and its SHA-256.
    pub table: String,
    /// In hexadecimal.
    pub table_sha256: String,
    force_unit: String,
    displacement_unit: String,
    /// Whether the order of the readings stands for time.
    order_is_clock: bool,
    /// Smallest and largest value that was set.
    range: [f64; 2],
    /// Columns and units of a table, as `part diagnose` takes them.
    pub columns: SpecimenOptions,
    band: FileBand,
    configurations: Vec<FileConfiguration>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    effects: Vec<FileEffect>,
}

/// 95 % of the readings that were left out of the fit lie within `half_width`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileBand {
    half_width: f64,
    readings: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileConfiguration {
    name: String,
    slope: f64,
    zero: f64,
    size_factor: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileEffect {
    physics: String,
    place: String,
    parameters: IndexMap<String, FileValue>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileValue {
    value: f64,
    unit: String,
}

impl PartModelFile {
    /// The file of a model.
    ///
    /// # Arguments
    /// - `columns`: how its table was read.
    /// - `table`: name and SHA-256 of that table.
    #[must_use]
    pub fn new(
        model: &PartModel,
        columns: &SpecimenOptions,
        (table, sha256): (&str, &str),
        verdict: String,
    ) -> Self {
        let units = &model.units;
        let (load, answer) = (units.of_load(), units.of_answer());
        let (force, displacement) = match units.response {
            ResponseVariable::Displacement => (&units.load, &units.answer),
            ResponseVariable::Force => (&units.answer, &units.load),
        };
        let configuration = |one: &PartConfiguration| FileConfiguration {
            name: one.name.clone(),
            slope: units.of_slope().in_table(one.slope),
            zero: answer.in_table(one.zero),
            size_factor: one.size_factor,
        };
        Self {
            schema: PART_MODEL_SCHEMA.to_owned(),
            software: format!("stiffbench {}", env!("CARGO_PKG_VERSION")),
            verdict,
            table: table.to_owned(),
            table_sha256: sha256.to_owned(),
            force_unit: force.name.clone(),
            displacement_unit: displacement.name.clone(),
            order_is_clock: units.order_is_clock,
            range: model.range.map(|end| load.in_table(end)),
            columns: SpecimenOptions {
                response: Some(units.response),
                ..columns.clone()
            },
            band: FileBand {
                half_width: answer.in_table(model.band.half_width),
                readings: model.band.readings,
            },
            configurations: model.configurations.iter().map(configuration).collect(),
            effects: model.effects.iter().map(|one| effect(units, one)).collect(),
        }
    }

    fn response(&self) -> ResponseVariable {
        self.columns.response.unwrap_or_default()
    }

    /// Its text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // Strings, numbers and tables of them can be written.
        let text = toml::to_string(self).unwrap_or_default();
        format!("# A part's line and the laws beside it, in the units of its table.\n{text}")
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`PartModelError`].
    pub fn parse(file: &str, text: &str) -> Result<Self, PartModelError> {
        let read: Self = toml::from_str(text).map_err(|error| PartModelError::Unreadable {
            file: file.to_owned(),
            problem: problem(text, &error),
        })?;
        if read.schema == PART_MODEL_SCHEMA {
            Ok(read)
        } else {
            Err(bad(file, "schema", &read.schema, PART_MODEL_SCHEMA))
        }
    }

    /// The model.
    ///
    /// # Errors
    /// [`PartModelError::BadValue`] for units, laws, places, parameters and numbers that cannot be.
    pub fn model(&self, file: &str) -> Result<PartModel, PartModelError> {
        let unit = |key: &str, name: &str| {
            ColumnUnit::named(name).ok_or_else(|| bad(file, key, name, "a unit, or 1"))
        };
        let force = unit("force_unit", &self.force_unit)?;
        let displacement = unit("displacement_unit", &self.displacement_unit)?;
        let (load, answer) = match self.response() {
            ResponseVariable::Displacement => (force, displacement),
            ResponseVariable::Force => (displacement, force),
        };
        let half_width = self.band.half_width;
        if !(half_width > 0.0 && half_width.is_finite()) {
            let key = "band.half_width";
            return Err(bad(
                file,
                key,
                &half_width.to_string(),
                "a number above zero",
            ));
        }
        let units = PartUnits {
            response: self.response(),
            order_is_clock: self.order_is_clock,
            load,
            answer,
        };
        let (of_load, of_answer) = (units.of_load(), units.of_answer());
        let configuration = |one: &FileConfiguration| PartConfiguration {
            name: one.name.clone(),
            slope: units.of_slope().in_si(one.slope),
            zero: of_answer.in_si(one.zero),
            size_factor: one.size_factor,
        };
        let effects = self.effects.iter();
        Ok(PartModel {
            configurations: self.configurations.iter().map(configuration).collect(),
            effects: effects
                .map(|one| self.effect(file, &units, one))
                .collect::<Result<_, _>>()?,
            range: self.range.map(|end| of_load.in_si(end)),
            band: PartBand {
                half_width: of_answer.in_si(self.band.half_width),
                readings: self.band.readings,
            },
            units,
        })
    }

    fn effect(
        &self,
        file: &str,
        units: &PartUnits,
        written: &FileEffect,
    ) -> Result<Effect, PartModelError> {
        let key = |name: &str| format!("effects.{}.{name}", written.physics);
        let has_parameters = |law: &Law| {
            let mut names = law.parameters.iter().map(|spec| spec.name);
            names.len() == written.parameters.len()
                && names.all(|name| written.parameters.contains_key(name))
        };
        let mut laws = Law::searched_on(test_object(self.response()));
        let law = laws
            .find(|law| law.to_string() == written.physics && has_parameters(law))
            .ok_or_else(|| {
                let names: Vec<&String> = written.parameters.keys().collect();
                let value = format!("`{}` with {names:?}", written.physics);
                bad(
                    file,
                    "effects.physics",
                    &value,
                    "a law of parts (docs/parts.md) with its parameters",
                )
            })?;
        let is_of_a_part = |place: &Place| place.joint().is_none_or(|name| name == Place::PART);
        let place = law.place_kind.read(&written.place).filter(is_of_a_part);
        let expected = law.place_kind.in_words();
        let place = place.ok_or_else(|| bad(file, &key("place"), &written.place, expected))?;
        let mut values = Vec::new();
        for spec in law.parameters {
            let (unit, value) = (units.of(spec), &written.parameters[spec.name]);
            if value.unit != unit.name {
                return Err(bad(
                    file,
                    &key(spec.name),
                    &value.unit,
                    &format!("the unit {}", unit.name),
                ));
            }
            values.push(unit.in_si(value.value));
        }
        Effect::new(law, place, values).map_err(|error| {
            bad(
                file,
                &key("parameters"),
                &error.to_string(),
                "values that can be",
            )
        })
    }
}

/// Whether a model can predict a table.
///
/// # Errors
/// [`PartModelError::OtherUnit`], [`PartModelError::UnknownConfiguration`].
pub fn check_predictable(
    model: &PartModel,
    table: &SpecimenTable,
    file: &str,
) -> Result<(), PartModelError> {
    let (load, answer) = (&model.units.load, &model.units.answer);
    let own = PartUnits::new(table);
    let names = model.units.names();
    let answers = table
        .has_response
        .then_some((names[1], &own.answer, answer));
    for (quantity, unit, expected) in [Some((names[0], &own.load, load)), answers]
        .into_iter()
        .flatten()
    {
        if unit.si != expected.si {
            return Err(PartModelError::OtherUnit {
                file: file.to_owned(),
                quantity,
                unit: unit.name.clone(),
                expected: expected.name.clone(),
            });
        }
    }
    let known = |name: &&String| model.configurations.iter().any(|one| one.name == **name);
    if let Some(configuration) = table.configurations.iter().find(|name| !known(name)) {
        let known = model.configurations.iter().map(|one| one.name.as_str());
        return Err(PartModelError::UnknownConfiguration {
            file: file.to_owned(),
            configuration: configuration.clone(),
            known: listed_names(known),
        });
    }
    Ok(())
}

/// What is wrong with a text, and in which line.
fn problem(text: &str, error: &toml::de::Error) -> String {
    let message = error.message().replace('\n', " ");
    match error.span() {
        Some(span) => {
            let before = text.get(..span.start).unwrap_or_default();
            format!("line {}: {message}", before.matches('\n').count() + 1)
        }
        None => message,
    }
}

fn bad(file: &str, key: &str, value: &str, expected: &str) -> PartModelError {
    PartModelError::BadValue {
        file: file.to_owned(),
        key: key.to_owned(),
        value: value.to_owned(),
        expected: expected.to_owned(),
    }
}

fn effect(units: &PartUnits, effect: &Effect) -> FileEffect {
    let values = effect.law.parameters.iter().zip(&effect.values);
    let parameters = values.map(|(spec, value)| {
        let unit = units.of(spec);
        let value = FileValue {
            value: unit.in_table(*value),
            unit: unit.name,
        };
        (spec.name.to_owned(), value)
    });
    FileEffect {
        physics: effect.law.to_string(),
        place: effect.place.compact(),
        parameters: parameters.collect(),
    }
}
