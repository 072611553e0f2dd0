//! Results as the inputs of figures.

use crate::analysis::{Failure, FitData};
use crate::fit::{FactorCorrelations, FactorStatus, FitOutcome, WeightBasis};
use crate::plot::{
    Bar, ComparedCell, Correlation, DisplacementPoint, DrawnFactor, FactorFate, FactorIntervals,
    Figure, FittedLine, LoadCurvePoints, LoadDisplacement, Quantities, ResidualMeasure,
    ResidualPoint, Residuals, SessionCurves, StiffnessComparison, correlation, factor_intervals,
    load_displacement, residuals, stiffness_comparison,
};
use crate::readings::Reading;
use crate::statistics::NORMAL_95;
use crate::stiffness::{CellStiffness, Flag, StiffnessTable};

/// A point of a plane nearer than this to an outermost one is the same place, and gives it its name, m.
pub(super) const SAME_PLACE_M: f64 = 0.05;

/// Load against displacement with repeat scatter, per pose and direction (the paper's Fig. 9).
#[must_use]
pub fn load_displacement_figure(sessions: &[(&str, &StiffnessTable)]) -> Figure {
    load_displacement(&LoadDisplacement {
        bar: Bar::StandardDeviation,
        sessions: sessions
            .iter()
            .map(|(name, table)| SessionCurves {
                name: (*name).to_owned(),
                curves: table.cells.iter().map(curve).collect(),
            })
            .collect(),
        marked: None,
    })
}

fn curve(cell: &CellStiffness) -> LoadCurvePoints {
    LoadCurvePoints {
        pose: cell.cell.pose.clone(),
        direction: cell.cell.direction,
        points: cell
            .loads
            .iter()
            .map(|load| DisplacementPoint {
                force_n: load.force_n.mean,
                displacement_m: load.displacement_m.mean,
                bar_m: load.displacement_m.sd,
                n: load.n,
                branch: load.branch,
                flagged: false,
            })
            .collect(),
        line: cell.line.as_ref().ok().map(|line| FittedLine {
            compliance_m_per_n: line.slope_m_per_n,
            intercept_m: line.zero_offset_m.value,
        }),
    }
}

/// Measured against predicted stiffness, factors with intervals and bounds, and correlations if the fit has any, each with the name of its file.
pub(super) fn fit_figures(
    outcome: &FitOutcome,
    table: Option<&StiffnessTable>,
    range: [f64; 2],
) -> Vec<(&'static str, Figure)> {
    let cells = outcome.cells.iter().map(|cell| {
        let row = table.and_then(|table| table.cell(&cell.cell));
        let interval = cell.ln_uncertainty.map(|u| {
            // Student's t of the pooled weights is close to normal; the interval of ln K is symmetric.
            [-NORMAL_95, NORMAL_95].map(|k: f64| cell.measured_n_per_m * (k * u).exp())
        });
        ComparedCell {
            cell: cell.cell.clone(),
            measured_n_per_m: cell.measured_n_per_m,
            measured_ci95_n_per_m: interval,
            n_runs: row.map_or(0, |row| row.n_runs),
            flagged: row.is_some_and(|row| !row.flags.is_empty()),
            predicted_n_per_m: cell.judged_n_per_m(),
            held_out: cell.held_out || cell.predicted_without_its_pose_n_per_m.is_some(),
        }
    });
    // Springs have another unit, and their axis another scale.
    let factors = outcome.estimates.iter();
    let factors = factors.filter(|estimate| estimate.parameter.is_factor());
    let drawn = factors.map(|estimate| DrawnFactor {
        name: estimate.name.clone(),
        value: estimate.value,
        ci95: estimate.parts_95(),
        bounds: (!matches!(
            estimate.status,
            FactorStatus::Fixed | FactorStatus::Tied { .. }
        ))
        .then(|| range.map(|share| share * estimate.start)),
        fate: match estimate.status {
            FactorStatus::Free => FactorFate::Free,
            FactorStatus::Fixed => FactorFate::Fixed,
            FactorStatus::Tied { .. } => FactorFate::Tied,
            FactorStatus::AtBound { .. } => FactorFate::AtBound,
            FactorStatus::NotIdentified { .. } => FactorFate::NotIdentified,
        },
    });
    let comparison = stiffness_comparison(&StiffnessComparison {
        prediction: format!("fitted model of mechanism {}", outcome.mechanism),
        pooled: outcome
            .agreement
            .as_ref()
            .is_some_and(|agreement| matches!(agreement.basis, WeightBasis::Pooled { .. })),
        cells: cells.collect(),
    });
    let factors = factor_intervals(&FactorIntervals {
        factors: drawn.collect(),
    });
    [("stiffness", comparison), ("factors", factors)]
        .into_iter()
        .chain(correlation_figure(outcome.correlation.as_ref()))
        .collect()
}

/// Correlations of the parameters of any fit, if it has two or more, with the name of their file.
pub(super) fn correlation_figure(
    found: Option<&FactorCorrelations>,
) -> Option<(&'static str, Figure)> {
    let found = found.filter(|correlation| correlation.names.len() > 1)?;
    let figure = correlation(&Correlation {
        names: found.names.clone(),
        matrix: found.matrix.clone(),
    });
    Some(("correlation", figure))
}

/// Residuals of the readings from the fitted model, each gauge zero by itself.
///
/// # Errors
/// As [`FitData::residuals`].
pub(super) fn residuals_figure(
    data: &FitData,
    outcome: &FitOutcome,
    table: &StiffnessTable,
) -> Result<Figure, Failure> {
    let flagged = |reading: &Reading| {
        table.cell(&reading.cell()).is_some_and(|row| {
            row.flags
                .iter()
                .any(|flag| flags_reading(flag, reading.seq))
        })
    };
    Ok(residuals(&Residuals {
        quantities: Quantities::default(),
        prediction: format!(
            "fitted model of mechanism {}, mean of each gauge zero taken off",
            outcome.mechanism
        ),
        measure: ResidualMeasure::Micrometres,
        points: data
            .residuals(outcome)?
            .iter()
            .map(|one| ResidualPoint {
                cell: one.reading.cell(),
                force_n: one.reading.force_n,
                residual_m: one.residual_m,
                standard_uncertainty_m: None,
                sequence: one.sequence + 1,
                time_s: one.reading.time_s,
                flagged: flagged(one.reading),
            })
            .collect(),
    }))
}

/// Whether a flag is about one reading, and this one.
fn flags_reading(flag: &Flag, seq: u32) -> bool {
    flag.reading.is_some_and(|reading| reading.seq == seq)
}
