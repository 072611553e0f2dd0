//! The model of a part that a diagnosis leaves, and what it predicts for other readings.

use stiffbench_beams::physics::Effect;
use stiffbench_measurement::specimen::SpecimenTable;

use super::diagnosis::Diagnosis;
use crate::mismatch::baselines::{Line, PartUnits, part_observations};
use crate::mismatch::error::MismatchError;
use crate::mismatch::hold_out::{HoldOut, unseen_parts};
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, Model};

/// Share of readings within the band.
const WITHIN: f64 = 0.95;

/// A part's line and the laws beside it, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct PartModel {
    /// Units of the table that it was fitted to.
    pub units: PartUnits,
    /// Its configurations.
    pub configurations: Vec<PartConfiguration>,
    /// The effects that act.
    pub effects: Vec<Effect>,
    /// Smallest and largest value that was set.
    pub range: [f64; 2],
    /// How far it was off where it was not fitted.
    pub band: PartBand,
}

/// A configuration of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct PartConfiguration {
    /// Its name.
    pub name: String,
    /// Slope of its line.
    pub slope: f64,
    /// Mean zero of its runs.
    pub zero: f64,
    /// Factor on the sizes of effects.
    pub size_factor: f64,
}

/// How far a model was off in readings that it was not fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartBand {
    /// 95 % of those readings were not further off.
    pub half_width: f64,
    /// How many they were.
    pub readings: usize,
}

impl PartModel {
    /// The model of a diagnosis; `None` where the readings could not decide.
    ///
    /// # Arguments
    /// - `table`, `line`, `observations`: what was diagnosed, with the sizes that were found.
    ///
    /// # Errors
    /// [`MismatchError`].
    pub fn new(
        table: &SpecimenTable,
        (line, observations): (&Line, &Observations),
        diagnosis: &Diagnosis,
    ) -> Result<Option<Self>, MismatchError> {
        if !diagnosis.lacking.is_empty() {
            return Ok(None);
        }
        let problem = DiagnosisProblem::new(line, observations);
        let model = Model {
            parameters: diagnosis.parameters.clone(),
            effects: diagnosis.effects.clone(),
        };
        let residuals = problem.raw_residuals(&model)?;
        let mut configurations = Vec::new();
        for cell in &observations.cells {
            let own = &residuals[cell.readings.clone()];
            configurations.push(PartConfiguration {
                name: table.configurations[cell.pose].clone(),
                slope: model.parameters[cell.pose],
                zero: line.zero + own.iter().sum::<f64>() / own.len() as f64,
                size_factor: observations.size_factor(cell.pose),
            });
        }
        let band = band(&problem, &model)?;
        let drivers = observations.loads.iter().map(|load| load.force_n);
        let range = drivers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], load| {
            [low.min(load), high.max(load)]
        });
        Ok(Some(Self {
            units: PartUnits::new(table),
            configurations,
            effects: model.effects,
            range,
            band,
        }))
    }

    /// What the model predicts for each reading of a table, in the order of the table, in SI; its configurations must be of the model.
    ///
    /// Memory is carried over the readings of each run, and over runs of which one continues the other.
    ///
    /// # Errors
    /// [`MismatchError`].
    pub fn predict(&self, table: &SpecimenTable) -> Result<Vec<f64>, MismatchError> {
        let known = |name: &String| self.configurations.iter().find(|one| one.name == *name);
        let own: Option<Vec<&PartConfiguration>> = table.configurations.iter().map(known).collect();
        let own = own.ok_or(MismatchError::Empty)?;
        let (observations, places) = part_observations(table, 0.0);
        let factors: Vec<f64> = own.iter().map(|one| one.size_factor).collect();
        let observations = observations.with_size_factors(&factors);
        let slopes: Vec<f64> = own.iter().map(|one| one.slope).collect();
        let baseline = Line::with_slopes(&table.configurations, &slopes);
        let problem = DiagnosisProblem::new(&baseline, &observations);
        let model = Model {
            parameters: slopes,
            effects: self.effects.clone(),
        };
        let predicted = problem.predicted(&model)?;
        let mut out = vec![0.0; predicted.len()];
        for (reading, value) in predicted.iter().enumerate() {
            let cell = observations.cell_of(reading);
            let zero = own[observations.cells[cell].pose].zero;
            out[places[reading]] = value + zero;
        }
        Ok(out)
    }
}

/// How far a model is off in parts of a recording that are left out of its fit in turn.
fn band(problem: &DiagnosisProblem<'_>, model: &Model) -> Result<PartBand, MismatchError> {
    let state = &problem.state_of(model.clone(), KnownNoise::Nothing)?;
    let hold_out = HoldOut::new(problem, state);
    let mut off: Vec<f64> = Vec::new();
    for held in unseen_parts(problem.observations) {
        let left = hold_out.residuals_left_out(model, &held)?;
        off.extend(left.iter().map(|residual| residual.abs()));
    }
    off.sort_by(f64::total_cmp);
    let place = (WITHIN * off.len() as f64).ceil() as usize;
    Ok(PartBand {
        half_width: off
            .get(place.saturating_sub(1))
            .copied()
            .unwrap_or(f64::NAN),
        readings: off.len(),
    })
}
