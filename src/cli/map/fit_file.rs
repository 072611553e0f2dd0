//! Factors with their covariance, from what `stiffbench fit --json` printed.

use crate::analysis::{ArgumentError, read_text};
use std::path::Path;

use serde_json::Value;

use crate::cli::failure::Failure;
use crate::distribution::FittedCovariance;
use crate::export::ParameterRow;
use crate::robot::{FittingFactors, ModelParameter};

/// What a fit found.
#[derive(Default)]
pub(in crate::cli) struct FitFile {
    pub(in crate::cli) factors_name: String,
    pub(in crate::cli) factors: FittingFactors,
    pub(super) covariance: Option<FittedCovariance>,
    /// What the covariance leaves out.
    pub(super) notes: Vec<String>,
    /// What the fit warned of, each with the name of its file.
    pub(in crate::cli) warnings: Vec<String>,
    /// The robot that was fitted, if it names one: its name, and the SHA-256 of its file.
    pub(in crate::cli) robot: Option<(String, String)>,
    /// The mechanism that was fitted, if it names one.
    pub(in crate::cli) mechanism: Option<String>,
    /// Each parameter with its interval.
    pub(in crate::cli) parameters: Vec<ParameterRow>,
}

/// Reads a fit.
pub(in crate::cli) fn read_fit(path: &Path) -> Result<FitFile, Failure> {
    let refuse = |problem: String| {
        ArgumentError::new(
            format!("--fit {}", path.display()),
            problem,
            "stiffbench fit DATA --json > fit.json, then --fit fit.json",
        )
    };
    let whole = printed_fit(path, &refuse)?;
    let mut fitted = from_data(&whole["data"]).map_err(refuse)?;
    fitted.factors_name = format!("of {}", path.display());
    let robot = |key| whole["inputs"]["robot"][key].as_str().map(str::to_owned);
    let warnings = whole["warnings"].as_array().into_iter().flatten();
    let warnings = warnings.filter_map(Value::as_str);
    fitted.warnings = warnings
        .map(|warning| format!("{}: {warning}", path.display()))
        .collect();
    fitted.robot = robot("name").zip(robot("sha256"));
    Ok(fitted)
}

/// What `stiffbench fit --json` printed, whole.
pub(in crate::cli) fn printed_fit(
    path: &Path,
    refuse: &dyn Fn(String) -> ArgumentError,
) -> Result<Value, Failure> {
    let whole: Value = serde_json::from_str(&read_text(path)?)
        .map_err(|error| refuse(format!("it is no JSON: {error}")))?;
    if whole["kind"] != "fit" || whole["ok"] != true {
        return Err(refuse("it is not what stiffbench fit --json prints".to_owned()).into());
    }
    Ok(whole)
}

/// Values and covariance from the data of a fit.
///
/// # Errors
/// What is missing, in words.
fn from_data(data: &Value) -> Result<FitFile, String> {
    let names = data["correlation"]["names"].as_array();
    let (mut values, mut notes, mut rows) = (FittingFactors::UNIT, Vec::new(), Vec::new());
    let mut parameters = Vec::new();
    // Place, among the correlations, of the parameter whose covariance each one has.
    let mut sources = Vec::new();
    for (name, entry) in entries(data) {
        let parameter =
            ModelParameter::try_from(name.clone()).map_err(|error| error.to_string())?;
        let value = entry["value"].as_f64();
        let value = value.filter(|value| *value > 0.0 || (!parameter.is_factor() && *value == 0.0));
        // Of a spring that no load turned there is none.
        if parameter.is_factor() || !entry["value"].is_null() {
            let value = value.ok_or_else(|| format!("it has no value of {name}"))?;
            values.set(&parameter, value);
        }
        let own = entry["tied_to"].as_str().unwrap_or(&name);
        let source = names.and_then(|names| names.iter().position(|known| known == own));
        let status = entry["status"].as_str().unwrap_or_default();
        if ["at_bound", "not_identified"].contains(&status) {
            let taken = match source {
                Some(_) => "its second-order one",
                None => "it as exact",
            };
            notes.push(format!(
                "{name} is {}: the uncertainty of the map takes {taken}",
                status.replace('_', " ")
            ));
        }
        rows.push(parameter_row(&parameter, entry));
        parameters.push(parameter);
        sources.push(source);
    }
    let covariance = covariance(data, parameters, &sources);
    if covariance.is_none() {
        notes.push(
            "the fit has no covariance: the map has no uncertainty of the factors".to_owned(),
        );
    }
    Ok(FitFile {
        factors: values,
        covariance,
        notes,
        mechanism: data["mechanism"].as_str().map(str::to_owned),
        parameters: rows,
        ..FitFile::default()
    })
}

/// A parameter with its interval and what the fit did with it.
fn parameter_row(parameter: &ModelParameter, entry: &Value) -> ParameterRow {
    let end = |place: usize| entry["ci95"][place].as_f64();
    let ci95 = end(0).zip(end(1)).map(|(low, high)| [low, high]);
    let value = entry["value"].as_f64();
    ParameterRow {
        status: entry["status"].as_str().map(str::to_owned),
        ..ParameterRow::new(parameter.to_string(), value, parameter.unit(), ci95)
    }
}

/// Name and entry of each parameter of a fit; one printed before there was a list has its factors by class.
fn entries(data: &Value) -> Vec<(String, &Value)> {
    if let Some(list) = data["parameters"].as_array() {
        let name = |entry: &Value| entry["name"].as_str().unwrap_or_default().to_owned();
        return list.iter().map(|entry| (name(entry), entry)).collect();
    }
    let classes = ModelParameter::CLASSES
        .iter()
        .map(ModelParameter::to_string);
    classes
        .map(|name| {
            let (class, constant) = name.split_once('.').unwrap_or_default();
            let entry = &data["factors"][class][constant];
            (name, entry)
        })
        .collect()
}

/// The covariance of the parameters; `None` if the fit has none.
fn covariance(
    data: &Value,
    parameters: Vec<ModelParameter>,
    sources: &[Option<usize>],
) -> Option<FittedCovariance> {
    let correlation = data["correlation"].as_object()?;
    let u = correlation.get("u_ln")?.as_array()?;
    let coefficients = correlation.get("matrix")?.as_array()?;
    let entry = |a: usize, b: usize| {
        let coefficient = coefficients.get(a)?.get(b)?.as_f64()?;
        Some(coefficient * u.get(a)?.as_f64()? * u.get(b)?.as_f64()?)
    };
    let row = |one: &Option<usize>| -> Option<Vec<f64>> {
        let others = sources.iter();
        others
            .map(|other| match (one, other) {
                (Some(a), Some(b)) => entry(*a, *b),
                _ => Some(0.0),
            })
            .collect()
    };
    Some(FittedCovariance {
        parameters,
        matrix: sources.iter().map(row).collect::<Option<_>>()?,
        dof: correlation.get("dof").and_then(Value::as_f64),
    })
}
