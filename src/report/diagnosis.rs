//! A diagnosis for programs, and what its document and its figures are made from.

mod answer;
mod appendix;
mod data_findings;
mod detection_limits;
mod known_effects;
mod loops;
mod noise;
mod open_questions;
mod page;
mod phrases;
mod sessions;
mod summary;
mod tables;
mod units;

use crate::analysis::{DiagnosisReport, Subject};
use crate::mismatch::{
    EstimatedValue, FactorChange, Impossible, LawCriticalValues, Quality, ReadingTrace,
};
use crate::physics::{Effect, FileLine, Law};
use crate::search::{LAW_LEVEL, NULL_SAMPLES};
use crate::test_point::Direction;

pub(super) use answer::DiagnosisAnswer;
pub(super) use data_findings::DataFindingKind;
pub use detection_limits::{DetectionLimitReport, LawLevel, SearchLevels, SeenLimit, UnseenReason};
pub use known_effects::{KnownEffectReport, KnownParameter};
pub use noise::{EarlierReport, NoiseDeviation, NoiseDeviations, NoiseReport};
pub(super) use open_questions::next_plans;
pub(super) use page::headline_words;
pub use page::{DiagnosisDetail, diagnosis_document};
pub(super) use phrases::{listed, short_phrase};
pub use summary::{
    ComponentShares, Determination, DiagnosisSummary, FactorChangeReport, FindingReport,
    FittedParameter, IntervalEnd, QualityReport, RejectedLaw, RivalReport, SiValue, SlopeReport,
    Strata, TableValue, UnexplainedReport, UntestedContrast,
};

/// Which model the residuals are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum DiagnosedModel {
    /// Those of the model without effects.
    Before,
    /// Those of the final model.
    After,
}

impl DiagnosedModel {
    /// Residuals about the gauge zero, and what is left of them within their run.
    pub(in crate::report) fn residuals_m(self, reading: &ReadingTrace) -> [f64; 2] {
        match self {
            Self::Before => [reading.before_m, reading.before_within_run_m],
            Self::After => [reading.after_m, reading.after_within_run_m],
        }
    }
}

impl DiagnosisReport {
    /// The line of the robot file that a finding accuses.
    #[must_use]
    pub fn file_line(&self, effect: &Effect) -> Option<&FileLine> {
        let mut lines = self.file_lines.iter();
        lines
            .find(|(known, _)| known == effect)
            .map(|(_, line)| line)
    }

    /// The factors with what became of them.
    pub(super) fn factor_changes(&self) -> impl Iterator<Item = FactorChangeReport> {
        let parameters = &self.parameters;
        self.diagnosis.factors.iter().map(move |factor| {
            let at_bound = parameters
                .iter()
                .find(|parameter| parameter.name == factor.name)
                .is_some_and(|parameter| parameter.is_near_bound(factor.after.value));
            let status = match (at_bound, factor.identified) {
                (true, _) => Determination::AtBound,
                (false, true) => Determination::Free,
                (false, false) => Determination::NotIdentified,
            };
            FactorChangeReport::new(&self.subject, factor, status)
        })
    }

    /// Laws refused for an impossible value; a law that was found there with a possible one is none of them.
    pub(super) fn impossible(&self) -> impl Iterator<Item = &Impossible> {
        let findings = &self.diagnosis.findings;
        self.diagnosis.impossible.iter().filter(move |one| {
            findings
                .iter()
                .all(|found| (found.effect.law, &found.effect.place) != (one.law, &one.place))
        })
    }

    /// Directions of the readings.
    fn directions(&self) -> impl Iterator<Item = Direction> {
        let cells = &self.observations.cells;
        Direction::ALL
            .into_iter()
            .filter(|direction| cells.iter().any(|cell| cell.axis() == *direction))
    }

    /// How well a model fits.
    fn quality(&self, model: DiagnosedModel) -> &Quality {
        match model {
            DiagnosedModel::Before => &self.diagnosis.before,
            DiagnosedModel::After => &self.diagnosis.after,
        }
    }

    /// Root mean squares of two residuals over all readings, or over those of a direction, m.
    fn rms_m(&self, model: DiagnosedModel, direction: Option<Direction>) -> [f64; 2] {
        let (mut squares, mut n) = ([0.0; 2], 0.0);
        let readings = self.trace.readings.iter();
        for reading in readings.filter(|r| direction.is_none_or(|d| d == r.cell.direction)) {
            for (square, residual) in squares.iter_mut().zip(model.residuals_m(reading)) {
                *square += residual * residual;
            }
            n += 1.0;
        }
        squares.map(|square| (square / f64::max(n, 1.0)).sqrt())
    }

    /// Root mean square that noise alone would leave, m.
    pub(super) fn noise_floor_m(&self) -> f64 {
        let slope_sd = self.diagnosis.noise.run_slope_sd;
        let readings = &self.trace.readings;
        let squares = readings
            .iter()
            .map(|r| r.reading_sd_m.powi(2) + (slope_sd * r.slope_m).powi(2));
        (squares.sum::<f64>() / readings.len().max(1) as f64).sqrt()
    }
}

/// What to do by hand about an effect, as a clause.
fn check(effect: &Effect) -> Option<String> {
    let check = effect.law.check?;
    Some((check.text)(&effect.place))
}

/// Value of a parameter from its fitted one, with its interval: of a slope in the unit of the table.
fn factor_value(
    subject: &Subject,
    factor: &FactorChange,
    fitted: &EstimatedValue,
) -> (f64, Option<[f64; 2]>) {
    let value = |fitted: f64| match (subject, factor.spring_rad_per_nm) {
        (Subject::Part { units, .. }, _) => units.of_slope().in_table(fitted),
        (_, None) => fitted.exp(),
        (_, Some(scale)) => scale * fitted,
    };
    let interval = fitted.interval_95().map(|ends| ends.map(value));
    (value(fitted.value), interval)
}

/// The smallest chance that the draws of noise can show of a pattern.
fn least_unexplained_p() -> f64 {
    1.0 / (NULL_SAMPLES as f64 + 1.0)
}

/// The smallest chance that the draws of noise can show of a law, its share of the level taken into account.
fn least_law_p(critical: &LawCriticalValues, law: Law) -> f64 {
    let level = critical.laws.levels.get(&(law, false)).copied();
    least_unexplained_p() * LAW_LEVEL / level.unwrap_or(LAW_LEVEL)
}

/// Whether so many degrees of freedom stand for a standard deviation that was given.
fn is_known(dof: f64) -> bool {
    dof >= 1e6
}
