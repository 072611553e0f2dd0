//! Fits of several models to the same cells, side by side.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table};

use crate::least_squares::SigmaMode;
use crate::statistics::{f_upper_tail, root_mean_square};

use super::fit_report::{FitReport, FittedCellReport, ParameterReport};
use super::text::{digits, or_dash, significant};

/// Values that differ by a smaller share are the same: JSON keeps all digits, other machines round the last ones otherwise.
const SAME: f64 = 1e-9;

/// Below this probability the richer model is needed.
const NEEDED: f64 = 0.05;

/// Several models of the same cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelComparison {
    /// The models, this fit first.
    pub models: Vec<ComparedModel>,
    /// Each pair of which one model contains the other.
    pub nested: Vec<NestedTest>,
}

/// One of the models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ComparedModel {
    /// `this fit`, or the file.
    pub name: String,
    /// Its mechanism.
    pub mechanism: String,
    /// Effects beside the beams, which are held fixed and not counted.
    pub effects: usize,
    /// Parameters that the fit moves.
    pub free: usize,
    /// Sum of the weighted squared residuals.
    pub squares: f64,
    /// Akaike's criterion with the correction for few data; `null` if there are too few cells for it.
    pub aicc: Option<f64>,
    /// That of the model over the smallest one.
    pub delta_aicc: Option<f64>,
    /// Root mean square error in poses that the fit did not know, %; `null` without any.
    pub unseen_rms_percent: Option<f64>,
}

/// Whether the richer of two models is needed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NestedTest {
    /// The model that is contained in the other.
    pub simpler: String,
    /// The other.
    pub richer: String,
    /// Fall of the squares a further parameter, over the squares that are left a degree of freedom.
    pub f: f64,
    /// Further parameters, and degrees of freedom that are left.
    pub dof: [usize; 2],
    /// Probability of a fall at least as large if the simpler model is right.
    pub p: f64,
}

/// A fit as it is compared.
#[derive(Debug)]
pub struct ComparedFit<'a> {
    name: String,
    fit: &'a FitReport,
    /// SHA-256 of each of its data.
    data: Vec<&'a str>,
    /// Parameters that the fit moves.
    free: usize,
    /// Cells of the fit.
    cells: usize,
    squares: f64,
}

impl<'a> ComparedFit<'a> {
    /// # Arguments
    /// - `data`: SHA-256 of each of its data.
    ///
    /// # Errors
    /// What it lacks, in words.
    pub fn new(name: &str, fit: &'a FitReport, data: Vec<&'a str>) -> Result<Self, &'static str> {
        if fit.cells.is_empty() {
            return Err("it is not a fit of stiffness values");
        }
        let (reduced, dof) = fit
            .reduced_chi2
            .zip(fit.dof)
            .ok_or("it has no degrees of freedom left, or was made by the paper's procedure")?;
        Ok(Self {
            name: name.to_owned(),
            fit,
            data,
            free: fit
                .parameters
                .iter()
                .filter(|one| one.status.moves())
                .count(),
            cells: fit.cells.iter().filter(|cell| !cell.held_out).count(),
            squares: reduced * dof as f64,
        })
    }

    /// Why it cannot be ranked with another one, in words; `None` if both were fitted to the same.
    #[must_use]
    pub fn differs_from(&self, other: &Self) -> Option<&'static str> {
        if self.data != other.data {
            return Some("it was fitted to other data");
        }
        let (own, others) = (&self.fit.cells, &other.fit.cells);
        let same_of = |is_same: &dyn Fn(&FittedCellReport, &FittedCellReport) -> bool| {
            own.len() == others.len() && own.iter().zip(others).all(|(a, b)| is_same(a, b))
        };
        if !same_of(&|a, b| {
            (&a.pose, a.direction, &a.session) == (&b.pose, b.direction, &b.session)
                && same(a.measured.value, b.measured.value)
        }) {
            return Some("its cells or their measured stiffness differ");
        }
        if !same_of(&|a, b| a.held_out == b.held_out) {
            return Some("it was fitted to other poses");
        }
        if self.fit.sigma != other.fit.sigma
            || !same_of(&|a, b| same(a.ln_uncertainty, b.ln_uncertainty))
        {
            return Some("it weights the cells differently");
        }
        None
    }

    /// Akaike's criterion, corrected for few data.
    ///
    /// # Source
    /// Burnham and Anderson, Model Selection and Multimodel Inference (2002), sections 2.2 and 2.4: χ² with known standard deviations,
    /// n ln(S/n) with one more parameter if they are estimated.
    fn aicc(&self) -> Option<f64> {
        let n = self.cells as f64;
        let (deviance, more) = if self.fit.sigma == Some(SigmaMode::Known) {
            (self.squares, 0.0)
        } else {
            (n * (self.squares / n).ln(), 1.0)
        };
        let k = self.free as f64 + more;
        let left = n - k - 1.0;
        (left > 0.0).then(|| deviance + 2.0 * k + 2.0 * k * (k + 1.0) / left)
    }

    fn unseen_rms_percent(&self) -> Option<f64> {
        let error = |cell: &FittedCellReport| {
            let unseen = if cell.held_out {
                Some(&cell.predicted)
            } else {
                cell.predicted_without_its_pose.as_ref()
            };
            Some(100.0 * (unseen?.value? / cell.measured.value? - 1.0))
        };
        root_mean_square(self.fit.cells.iter().filter_map(error))
    }

    /// Whether each model of this fit is one of the other's, which has more free parameters.
    fn is_within(&self, richer: &Self) -> bool {
        let [own, others] = [self, richer].map(|one| &one.fit.parameters);
        let is_kept = |own: &ParameterReport| {
            let Some(other) = others.iter().find(|one| one.name == own.name) else {
                return false;
            };
            match (own.status.moves(), other.status.moves()) {
                (_, true) => true,
                (true, false) => false,
                (false, false) => {
                    own.tied_to == other.tied_to
                        && match own.tied_to {
                            None => same(own.value, other.value),
                            Some(_) => same(Some(own.start), Some(other.start)),
                        }
                }
            }
        };
        self.free < richer.free
            && (&self.fit.mechanism, &self.fit.physics)
                == (&richer.fit.mechanism, &richer.fit.physics)
            && others
                .iter()
                .all(|one| one.status.moves() || own.iter().any(|own| own.name == one.name))
            && own.iter().all(is_kept)
    }

    fn nested_test(&self, richer: &Self) -> Option<NestedTest> {
        let dof = [
            richer.free - self.free,
            richer.cells.checked_sub(richer.free)?,
        ];
        let [more, left] = dof.map(|count| count as f64);
        let f = (self.squares - richer.squares).max(0.0) / more / (richer.squares / left);
        Some(NestedTest {
            simpler: self.name.clone(),
            richer: richer.name.clone(),
            f,
            dof,
            p: f_upper_tail(f, more, left)?,
        })
    }
}

/// Whether two values are the same but for the last digits.
fn same(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME * a.abs().max(b.abs()),
        _ => a == b,
    }
}

impl ModelComparison {
    /// Compares fits to the same cells, this one first.
    #[must_use]
    pub fn of(fits: &[ComparedFit<'_>]) -> Self {
        let least = fits
            .iter()
            .filter_map(ComparedFit::aicc)
            .min_by(f64::total_cmp);
        let models = fits.iter().map(|fit| ComparedModel {
            name: fit.name.clone(),
            mechanism: fit.fit.mechanism.clone(),
            effects: fit.fit.physics.len(),
            free: fit.free,
            squares: fit.squares,
            aicc: fit.aicc(),
            delta_aicc: fit.aicc().zip(least).map(|(own, least)| own - least),
            unseen_rms_percent: fit.unseen_rms_percent(),
        });
        let pairs = fits.iter().flat_map(|a| fits.iter().map(move |b| (a, b)));
        let nested = pairs.filter(|(a, b)| a.is_within(b));
        Self {
            models: models.collect(),
            nested: nested.filter_map(|(a, b)| a.nested_test(b)).collect(),
        }
    }

    /// The comparison for people.
    pub(super) fn document(&self) -> Document {
        let mut document = Document::of("Models of the same cells; the smallest AICc is best:");
        document.table(
            Table::of(&self.models)
                .words("model", |one| &one.name)
                .words("mechanism", |one| &one.mechanism)
                .numbers("effects", |one| one.effects)
                .numbers("free", |one| one.free)
                .numbers("weighted squares", |one| significant(one.squares, 4))
                .numbers("AICc", |one| digits(one.aicc, 4))
                .numbers("above the best", |one| {
                    or_dash(one.delta_aicc, |more| format!("{more:.1}"))
                })
                .numbers("root mean square error in unseen poses, %", |one| {
                    digits(one.unseen_rms_percent, 3)
                }),
        );
        if self.models.iter().any(|model| model.effects > 0) {
            document.paragraph("Effects are held fixed: their parameters are not counted.");
        }
        for test in &self.nested {
            let [more, left] = test.dof;
            let verdict = if test.p < NEEDED {
                "the data need the richer model"
            } else {
                "the data do not need the richer model"
            };
            document.item(format!(
                "{} is contained in {}: F({more}, {left}) = {}, p = {}: {verdict}.",
                test.simpler,
                test.richer,
                significant(test.f, 3),
                significant(test.p, 2)
            ));
        }
        document
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A straight line or a parabola through ten points as if they were cells.
    fn fit(free: usize, squares: f64, sigma: &str) -> FitReport {
        let parameter = |place: usize| {
            let status = if place < free { "free" } else { "fixed" };
            json!({"name": format!("p{place}"), "status": status, "value": 0.0, "unit": "1", "se": null, "ci95": null,
                "islands": [], "bounds": null, "start": 0.0, "moved": null})
        };
        let cell = |place: usize| {
            let k = |value: f64| json!({"value": value, "unit": "N/um"});
            json!({"pose": format!("P{place}"), "direction": "x", "measured": k(2.0), "predicted": k(2.0), "ratio_percent": 100.0,
                "ln_uncertainty": 0.01, "held_out": false, "predicted_without_its_pose": k(2.0 + 0.02 * free as f64)})
        };
        let dof = 10 - free;
        serde_json::from_value(json!({
            "method": "least-squares", "mechanism": "F", "physics": [], "factors": {"beam": {}, "link": {}}, "not_determined": [], "marked": [],
            "runs_tests": [], "termination": "", "next": [], "sigma": sigma, "dof": dof, "reduced_chi2": squares / dof as f64,
            "parameters": (0..3).map(parameter).collect::<Vec<_>>(), "cells": (0..10).map(cell).collect::<Vec<_>>(),
        }))
        .unwrap()
    }

    #[test]
    fn numbers_are_those_of_the_textbook() {
        let (line, parabola) = (fit(2, 4.0, "estimated"), fit(3, 2.5, "estimated"));
        let fits = [("line", &line), ("parabola", &parabola)]
            .map(|(name, fit)| ComparedFit::new(name, fit, vec!["a"]).unwrap());
        let found = ModelComparison::of(&fits);
        // n ln(S/n) + 2 K + 2 K (K + 1)/(n - K - 1) with K = 3 and 4, by hand.
        for (model, expected) in found.models.iter().zip([0.837_093, 2.137_056]) {
            assert!((model.aicc.unwrap() - expected).abs() < 1e-5, "{model:?}");
        }
        assert_eq!(found.models[0].delta_aicc, Some(0.0));
        assert!((found.models[1].unseen_rms_percent.unwrap() - 3.0).abs() < 1e-9);
        // scipy.stats.f.sf(4.2, 1, 7) = 0.0796
        let [test] = &found.nested[..] else {
            panic!("{found:?}")
        };
        assert_eq!((test.simpler.as_str(), test.dof), ("line", [1, 7]));
        assert!(
            (test.f - 4.2).abs() < 1e-12 && (test.p - 0.0796).abs() < 1e-4,
            "{test:?}"
        );
        assert!(
            found
                .document()
                .text()
                .contains("line is contained in parabola: F(1, 7) = 4.20")
        );
        // With known standard deviations the squares themselves count, and no scatter is estimated.
        let known = fit(2, 4.0, "known");
        let known = ComparedFit::new("known", &known, vec!["a"]).unwrap();
        assert!((known.aicc().unwrap() - (4.0 + 4.0 + 12.0 / 7.0)).abs() < 1e-12);
        assert_eq!(
            known.differs_from(&fits[0]),
            Some("it weights the cells differently")
        );
    }

    #[test]
    fn models_of_other_data_are_not_ranked() {
        let own = fit(2, 4.0, "known");
        let first = ComparedFit::new("a", &own, vec!["a"]).unwrap();
        let differs = |fit: &FitReport, data: &'static str| {
            let other = ComparedFit::new("b", fit, vec![data]).unwrap();
            other.differs_from(&first)
        };
        assert_eq!(differs(&own, "a"), None);
        assert_eq!(differs(&own, "b"), Some("it was fitted to other data"));
        let mut fewer = own.clone();
        fewer.cells.pop();
        assert!(differs(&fewer, "a").is_some());
        let mut held = own.clone();
        held.cells[0].held_out = true;
        assert_eq!(differs(&held, "a"), Some("it was fitted to other poses"));
        let mut none = own.clone();
        none.cells.clear();
        assert!(ComparedFit::new("c", &none, vec!["a"]).is_err());
    }
}
