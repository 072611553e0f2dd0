//! Known properties of the gauges: resolution and calibration.

use miette::Diagnostic;
use thiserror::Error;

use crate::readings::{InstrumentRecord, Reading};

use super::display_step::{are_set, step_of};

/// Coverage factor taken when a certificate's expanded uncertainty comes without one; the usual one for 95 % (GUM 6.3.3).
const USUAL_COVERAGE_FACTOR: f64 = 2.0;

/// Whether a coverage factor is √3, as far as two decimals tell: that of limits of error, within which every value is as likely.
#[must_use]
pub fn is_factor_of_limits(k: f64) -> bool {
    (k - 3_f64.sqrt()).abs() < 0.005
}

/// Why an input to the stiffness stage was refused.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
pub enum StiffnessError {
    /// A resolution, expanded uncertainty or coverage factor that cannot be one.
    #[error("{term} of a gauge is {value}, which is not a finite number {bound}")]
    #[diagnostic(
        code(stiffbench::stiffness::gauge_term),
        help("give the number from the data sheet or certificate in SI units, or leave it out")
    )]
    GaugeTerm {
        /// Which number: `resolution`, `expanded uncertainty` or `coverage factor`.
        term: &'static str,
        /// What was given.
        value: f64,
        /// What it has to be.
        bound: &'static str,
    },
}

/// Resolution and calibration of one gauge, N for force and m for displacement; what is not stated is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaugeTerms {
    resolution: Option<f64>,
    resolution_is_read_off: bool,
    expanded_uncertainty: Option<f64>,
    coverage_factor: Option<f64>,
    reversibility: Option<f64>,
}

impl GaugeTerms {
    /// Terms in SI units of the gauge (N or m).
    ///
    /// # Arguments
    /// - `resolution`: smallest step of the display, at least zero.
    /// - `expanded_uncertainty`: U of the certificate, at least zero, common to all readings of this gauge.
    /// - `coverage_factor`: k of `expanded_uncertainty`, above zero; without one 2 is taken and the budget states it.
    ///
    /// # Errors
    /// `StiffnessError::GaugeTerm` for a number that is not finite or out of these bounds.
    pub fn new(
        resolution: Option<f64>,
        expanded_uncertainty: Option<f64>,
        coverage_factor: Option<f64>,
    ) -> Result<Self, StiffnessError> {
        for (term, value, may_be_zero) in [
            ("resolution", resolution, true),
            ("expanded uncertainty", expanded_uncertainty, true),
            ("coverage factor", coverage_factor, false),
        ] {
            let is_one = |value: f64| value > 0.0 || (may_be_zero && value == 0.0);
            if let Some(value) = value.filter(|value| !(value.is_finite() && is_one(*value))) {
                let bound = if may_be_zero {
                    "of at least zero"
                } else {
                    "above zero"
                };
                return Err(StiffnessError::GaugeTerm { term, value, bound });
            }
        }
        Ok(Self {
            resolution,
            resolution_is_read_off: false,
            expanded_uncertainty,
            coverage_factor,
            reversibility: None,
        })
    }

    /// The same with the largest difference between its readings of one value while that grows and while it falls.
    #[must_use]
    pub fn with_reversibility(self, reversibility: Option<f64>) -> Self {
        Self {
            reversibility,
            ..self
        }
    }

    /// Terms that the record of a gauge states, if there is one.
    ///
    /// # Errors
    /// As [`GaugeTerms::new`].
    pub fn of(record: Option<&InstrumentRecord>) -> Result<Self, StiffnessError> {
        record.map_or(Ok(Self::default()), |record| {
            let terms = Self::new(record.resolution, record.expanded_uncertainty, record.k)?;
            Ok(terms.with_reversibility(record.reversibility))
        })
    }

    /// Smallest step of the display, N or m.
    #[must_use]
    pub fn resolution(&self) -> Option<f64> {
        self.resolution
    }

    /// Whether the resolution was not stated, and is the step of the readings.
    #[must_use]
    pub fn resolution_is_read_off(&self) -> bool {
        self.resolution_is_read_off
    }

    /// The same with the step of its readings, where it states none.
    fn with_step_of(self, values: impl Iterator<Item = f64>) -> Self {
        match self.resolution.is_none().then(|| step_of(values)).flatten() {
            Some(step) => Self {
                resolution: Some(step),
                resolution_is_read_off: true,
                ..self
            },
            None => self,
        }
    }

    /// Largest difference between its readings of one value while that grows and while it falls, N or m.
    #[must_use]
    pub fn reversibility(&self) -> Option<f64> {
        self.reversibility
    }

    /// Expanded uncertainty U of the certificate, N or m.
    #[must_use]
    pub fn expanded_uncertainty(&self) -> Option<f64> {
        self.expanded_uncertainty
    }

    /// Standard uncertainty of the calibration U/k, N or m (GUM 4.3.3).
    #[must_use]
    pub fn calibration_standard_uncertainty(&self) -> Option<f64> {
        let k = self.coverage_factor.unwrap_or(USUAL_COVERAGE_FACTOR);
        self.expanded_uncertainty.map(|expanded| expanded / k)
    }

    /// Whether the expanded uncertainty is a pair of limits within which every value is as likely: the half width a of a rectangle with
    /// u = a/√3 (GUM 4.3.7), so that k is √3.
    #[must_use]
    pub fn states_limits(&self) -> bool {
        self.expanded_uncertainty.is_some() && self.coverage_factor.is_some_and(is_factor_of_limits)
    }

    /// Whether k = 2 had to be assumed for the stated expanded uncertainty.
    #[must_use]
    pub fn coverage_factor_is_assumed(&self) -> bool {
        self.expanded_uncertainty.is_some() && self.coverage_factor.is_none()
    }
}

/// That the step of a gauge was read off its readings.
#[must_use]
pub fn read_off_words(gauge: &str, step: f64, unit: &str) -> String {
    let step = (step * 1e6).round() / 1e6;
    format!(
        "the resolution of the {gauge} gauge is not stated: its readings are whole multiples of {step} {unit}, which is used"
    )
}

/// The two gauges of a bench.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaugePair {
    /// Force gauge, terms in N.
    pub force: GaugeTerms,
    /// Displacement gauge, terms in m.
    pub displacement: GaugeTerms,
}

impl GaugePair {
    /// The same gauges with the steps of their readings, where no resolution is stated. Forces that were set have none.
    #[must_use]
    pub fn with_steps_of(self, readings: &[Reading]) -> Self {
        let force = if are_set(readings) {
            self.force
        } else {
            let forces = readings.iter().map(|reading| reading.force_n);
            self.force.with_step_of(forces)
        };
        let displacements = readings.iter().map(|reading| reading.displacement_m);
        Self {
            force,
            displacement: self.displacement.with_step_of(displacements),
        }
    }

    /// What was read off the readings because it is not stated.
    pub fn read_off(&self) -> impl Iterator<Item = String> {
        let of = |terms: GaugeTerms, name: &'static str, scale: f64, unit: &'static str| {
            let step = terms.resolution.filter(|_| terms.resolution_is_read_off)?;
            Some(read_off_words(name, scale * step, unit))
        };
        [
            of(self.force, "force", 1.0, "N"),
            of(self.displacement, "displacement", 1e6, "µm"),
        ]
        .into_iter()
        .flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certificate_without_coverage_factor_gets_k_2_and_a_note() {
        let gauge = GaugeTerms::new(Some(0.1), Some(0.15), None).unwrap();
        assert_eq!(gauge.calibration_standard_uncertainty(), Some(0.075));
        assert!(gauge.coverage_factor_is_assumed());
        assert!(!GaugeTerms::default().coverage_factor_is_assumed());
    }

    #[test]
    fn impossible_terms_are_refused_with_their_value() {
        for (terms, name) in [
            ((Some(-0.1), None, None), "resolution"),
            ((Some(f64::NAN), None, None), "resolution"),
            ((None, Some(f64::INFINITY), None), "expanded uncertainty"),
            ((None, Some(0.1), Some(0.0)), "coverage factor"),
        ] {
            let (resolution, expanded, k) = terms;
            let error = GaugeTerms::new(resolution, expanded, k).unwrap_err();
            let StiffnessError::GaugeTerm { term, .. } = error;
            assert_eq!(term, name);
        }
    }
}
