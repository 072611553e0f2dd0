//! Factors with their covariance, from what `stiffbench fit --json` printed.

use crate::analysis::read_text;
use std::path::Path;

use serde_json::Value;

use crate::cli::failure::Failure;
use crate::distribution::FactorCovariance;
use crate::fit::{FACTOR_NAMES, FACTORS, factors_from_vector};
use crate::robot::FittingFactors;

use super::job::wrong;

/// What a fit found.
pub(super) struct Fitted {
    pub(super) factors_name: String,
    pub(super) factors: FittingFactors,
    pub(super) covariance: Option<FactorCovariance>,
    /// What the covariance leaves out.
    pub(super) notes: Vec<String>,
}

/// Reads a fit.
pub(super) fn read_fit(path: &Path) -> Result<Fitted, Failure> {
    let text = read_text(path)?;
    let refuse = |problem: String| {
        wrong(
            &format!("--fit {}", path.display()),
            problem,
            "stiffbench fit DATA --json > fit.json, then --fit fit.json",
        )
    };
    let whole: Value =
        serde_json::from_str(&text).map_err(|error| refuse(format!("it is no JSON: {error}")))?;
    if whole["kind"] != "fit" || whole["ok"] != true {
        return Err(refuse("it is not what stiffbench fit --json prints".to_owned()).into());
    }
    let mut fitted = from_data(&whole["data"]).map_err(refuse)?;
    fitted.factors_name = format!("of {}", path.display());
    Ok(fitted)
}

/// Factors and covariance from the data of a fit.
///
/// # Errors
/// What is missing, in words.
fn from_data(data: &Value) -> Result<Fitted, String> {
    let mut vector = [0.0; FACTORS];
    // Place, among the correlations, of the factor whose covariance each factor has.
    let mut source: [Option<usize>; FACTORS] = [None; FACTORS];
    let names = data["correlation"]["names"].as_array();
    let mut notes = Vec::new();
    for (place, name) in FACTOR_NAMES.iter().enumerate() {
        let (class, constant) = name.split_once('.').unwrap_or_default();
        let entry = &data["factors"][class][constant];
        let value = entry["value"].as_f64().filter(|value| *value > 0.0);
        vector[place] = value.ok_or_else(|| format!("it has no value of {name}"))?;
        let own = entry["tied_to"].as_str().unwrap_or(name);
        source[place] = names.and_then(|names| names.iter().position(|known| known == own));
        let status = entry["status"].as_str().unwrap_or_default();
        if ["at_bound", "not_identified"].contains(&status) {
            let taken = match source[place] {
                Some(_) => "its second-order one",
                None => "it as exact",
            };
            notes.push(format!(
                "{name} is {}: the uncertainty of the map takes {taken}",
                status.replace('_', " ")
            ));
        }
    }
    let covariance = covariance(data, &source);
    if covariance.is_none() {
        notes.push(
            "the fit has no covariance: the map has no uncertainty of the factors".to_owned(),
        );
    }
    Ok(Fitted {
        factors_name: String::new(),
        factors: factors_from_vector(&vector),
        covariance,
        notes,
    })
}

/// The covariance of the logarithms; `None` if the fit has none.
fn covariance(data: &Value, source: &[Option<usize>; FACTORS]) -> Option<FactorCovariance> {
    let correlation = data["correlation"].as_object()?;
    let u = correlation.get("u_ln")?.as_array()?;
    let coefficients = correlation.get("matrix")?.as_array()?;
    let mut matrix = [[0.0; FACTORS]; FACTORS];
    for (i, row) in matrix.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            if let (Some(a), Some(b)) = (source[i], source[j]) {
                let coefficient = coefficients.get(a)?.get(b)?.as_f64()?;
                *entry = coefficient * u.get(a)?.as_f64()? * u.get(b)?.as_f64()?;
            }
        }
    }
    Some(FactorCovariance {
        matrix,
        dof: correlation.get("dof").and_then(Value::as_f64),
    })
}
