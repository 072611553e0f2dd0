//! A fit that `stiffbench fit --json` printed, read back: what a map, an export and a comparison of models go on from.

use serde::Deserialize;
use serde_json::{Value, json};

use crate::fit::FactorCorrelations;
use crate::least_squares::SigmaMode;

use super::fit_report::{FitReport, FittedCellReport, ParameterReport};

/// The object of `fit --json`.
#[derive(Debug, Clone, Deserialize)]
pub struct StoredFit {
    /// What it was made of.
    pub inputs: StoredInputs,
    /// The fit.
    pub data: StoredModel,
    /// What it warned of.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// What a fit was made of.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct StoredInputs {
    /// The data.
    pub data: Vec<StoredInput>,
    /// The robot file.
    pub robot: Option<StoredInput>,
}

/// An input by its name and the SHA-256 of its text.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct StoredInput {
    /// Its name.
    pub name: String,
    /// The hash, in hexadecimal.
    pub sha256: String,
}

/// The model of a fit, and the cells that it was fitted to, as [`FitReport`] has them.
#[derive(Debug, Clone, Deserialize)]
pub struct StoredModel {
    /// The mechanism; `None` of what any may have.
    pub mechanism: Option<String>,
    /// What acts beside the beams, held fixed.
    pub physics: Vec<Value>,
    /// Every parameter.
    pub parameters: Vec<ParameterReport>,
    /// Their correlations, if they have intervals.
    pub correlation: Option<FactorCorrelations>,
    /// Where the standard deviation of the residuals comes from.
    pub sigma: Option<SigmaMode>,
    /// Residuals less determined parameters.
    pub dof: Option<usize>,
    /// Sum of squared residuals over `dof`.
    pub reduced_chi2: Option<f64>,
    /// The cells; none of load cases.
    pub cells: Vec<FittedCellReport>,
}

impl StoredFit {
    /// Reads what `fit --json` printed.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn read(text: &str) -> Result<Self, String> {
        let whole: Value =
            serde_json::from_str(text).map_err(|error| format!("it is no JSON: {error}"))?;
        if whole["kind"] != "fit" || whole["ok"] != true {
            return Err("it is not what stiffbench fit --json prints".to_owned());
        }
        serde_json::from_value(whole)
            .map_err(|error| format!("it is not what this version of fit --json prints: {error}"))
    }
}

impl From<&FitReport> for StoredModel {
    fn from(fit: &FitReport) -> Self {
        Self {
            mechanism: Some(fit.mechanism.clone()),
            physics: fit.physics.iter().map(|effect| json!(effect)).collect(),
            parameters: fit.parameters.clone(),
            correlation: fit.correlation.clone(),
            sigma: fit.sigma,
            dof: fit.dof,
            reduced_chi2: fit.reduced_chi2,
            cells: fit.cells.clone(),
        }
    }
}
