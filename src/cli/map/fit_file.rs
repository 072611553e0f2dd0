//! Factors with their covariance, from what `stiffbench fit --json` printed.

use crate::analysis::{ArgumentError, StoredResult, read_text};
use std::path::Path;

use crate::cli::failure::Failure;
use crate::distribution::FittedCovariance;
use crate::export::ParameterRow;
use crate::fit::{FactorCorrelations, StatusWord};
use crate::report::FitReport;
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
    let stored = StoredResult::<FitReport>::read("fit", &read_text(path)?).map_err(refuse)?;
    let mut fitted = of_model(&stored.data).map_err(refuse)?;
    fitted.factors_name = format!("of {}", path.display());
    let warnings = stored.warnings.iter();
    fitted.warnings = warnings
        .map(|warning| format!("{}: {warning}", path.display()))
        .collect();
    let robot = stored.inputs.robot();
    fitted.robot = robot.map(|(name, sha256)| (name.to_owned(), sha256.to_owned()));
    Ok(fitted)
}

/// Values and covariance of a fitted model.
///
/// # Errors
/// What is missing, in words.
fn of_model(fit: &FitReport) -> Result<FitFile, String> {
    let names = fit.correlation.as_ref().map(|found| &found.names);
    let (mut values, mut notes, mut rows) = (FittingFactors::UNIT, Vec::new(), Vec::new());
    let mut parameters = Vec::new();
    // Place, among the correlations, of the parameter whose covariance each one has.
    let mut sources = Vec::new();
    for one in &fit.parameters {
        let name = &one.name;
        let parameter =
            ModelParameter::try_from(name.clone()).map_err(|error| error.to_string())?;
        let is_possible = |value: &f64| *value > 0.0 || (!parameter.is_factor() && *value == 0.0);
        // Of a spring that no load turned there is none.
        if parameter.is_factor() || one.value.is_some() {
            let value = one.value.filter(is_possible);
            let value = value.ok_or_else(|| format!("it has no value of {name}"))?;
            values.set(&parameter, value);
        }
        let own = one.tied_to.as_ref().unwrap_or(name);
        let source = names.and_then(|names| names.iter().position(|known| known == own));
        if [StatusWord::AtBound, StatusWord::NotIdentified].contains(&one.status) {
            let taken = match source {
                Some(_) => "its second-order one",
                None => "it as exact",
            };
            notes.push(format!(
                "{name} is {}: the uncertainty of the map takes {taken}",
                one.status
            ));
        }
        rows.push(ParameterRow {
            status: Some(one.status),
            ..ParameterRow::new(name.clone(), one.value, parameter.unit(), one.ci95)
        });
        parameters.push(parameter);
        sources.push(source);
    }
    let covariance =
        (fit.correlation.as_ref()).and_then(|found| covariance(found, parameters, &sources));
    if covariance.is_none() {
        notes.push(
            "the fit has no covariance: the map has no uncertainty of the factors".to_owned(),
        );
    }
    Ok(FitFile {
        factors: values,
        covariance,
        notes,
        mechanism: Some(fit.mechanism.clone()),
        parameters: rows,
        ..FitFile::default()
    })
}

/// The covariance of the parameters; `None` of correlations that lack a row.
fn covariance(
    found: &FactorCorrelations,
    parameters: Vec<ModelParameter>,
    sources: &[Option<usize>],
) -> Option<FittedCovariance> {
    let entry = |a: usize, b: usize| {
        let coefficient = found.matrix.get(a)?.get(b)?;
        Some(coefficient * found.u_ln.get(a)? * found.u_ln.get(b)?)
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
        dof: found.dof,
    })
}
