//! Fits of several models to the same cells, side by side.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use stiffbench_document::{Document, table_of};

use crate::statistics::f_upper_tail;

use super::text::{digits, or_dash, significant};

/// Values that differ by a smaller share are the same: JSON keeps all digits, other machines round the last ones otherwise.
const SAME: f64 = 1e-9;

/// Below this probability the richer model is needed.
const NEEDED: f64 = 0.05;

/// Several models of the same cells.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ModelComparison {
    /// The models, this fit first.
    pub models: Vec<ComparedModel>,
    /// Each pair of which one model contains the other.
    pub nested: Vec<NestedTest>,
}

/// One of the models.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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

/// A fit as it is compared, from what `fit --json` prints.
#[derive(Debug)]
pub struct ComparedFit<'a> {
    name: String,
    data: &'a Value,
    inputs: &'a Value,
    /// Parameters that the fit moves.
    free: usize,
    /// Cells of the fit.
    cells: usize,
    squares: f64,
}

impl<'a> ComparedFit<'a> {
    /// # Arguments
    /// - `data`, `inputs`: those of the JSON object of a fit.
    ///
    /// # Errors
    /// What it lacks, in words.
    pub fn new(name: &str, data: &'a Value, inputs: &'a Value) -> Result<Self, &'static str> {
        let cells = data["cells"]
            .as_array()
            .ok_or("it is not a fit of stiffness values")?;
        let squares = data["reduced_chi2"].as_f64().zip(data["dof"].as_f64());
        let (reduced, dof) = squares
            .ok_or("it has no degrees of freedom left, or was made by the paper's procedure")?;
        Ok(Self {
            name: name.to_owned(),
            data,
            inputs,
            free: parameters(data).filter(|one| moves(one)).count(),
            cells: cells
                .iter()
                .filter(|cell| cell["held_out"] == false)
                .count(),
            squares: reduced * dof,
        })
    }

    /// Why it cannot be ranked with another one, in words; `None` if both were fitted to the same.
    #[must_use]
    pub fn differs_from(&self, other: &Self) -> Option<&'static str> {
        let hashes = |fit: &Self| -> Vec<Value> {
            let data = fit.inputs["data"].as_array().into_iter().flatten();
            data.map(|one| one["sha256"].clone()).collect()
        };
        if hashes(self) != hashes(other) {
            return Some("it was fitted to other data");
        }
        let [own, others] = [self, other].map(|fit| fit.data["cells"].as_array());
        let (own, others) = own.zip(others)?;
        let same_of = |key: &'static str| {
            own.len() == others.len() && own.iter().zip(others).all(|(a, b)| same(&a[key], &b[key]))
        };
        if !["pose", "direction", "session", "measured"]
            .map(same_of)
            .iter()
            .all(|same| *same)
        {
            return Some("its cells or their measured stiffness differ");
        }
        if !same_of("held_out") {
            return Some("it was fitted to other poses");
        }
        if self.data["sigma"] != other.data["sigma"] || !same_of("ln_uncertainty") {
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
        let (deviance, more) = if self.data["sigma"] == "known" {
            (self.squares, 0.0)
        } else {
            (n * (self.squares / n).ln(), 1.0)
        };
        let k = self.free as f64 + more;
        let left = n - k - 1.0;
        (left > 0.0).then(|| deviance + 2.0 * k + 2.0 * k * (k + 1.0) / left)
    }

    fn unseen_rms_percent(&self) -> Option<f64> {
        let cells = self.data["cells"].as_array()?.iter();
        let error = |cell: &Value| {
            let unseen = if cell["held_out"] == true {
                &cell["predicted"]
            } else {
                &cell["predicted_without_its_pose"]
            };
            Some(100.0 * (unseen["value"].as_f64()? / cell["measured"]["value"].as_f64()? - 1.0))
        };
        let errors: Vec<f64> = cells.filter_map(error).collect();
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
    }

    /// Whether each model of this fit is one of the other's, which has more free parameters.
    fn is_within(&self, richer: &Self) -> bool {
        let of_richer =
            |own: &Value| parameters(richer.data).find(|one| one["name"] == own["name"]);
        let is_kept = |own: &Value| {
            let Some(other) = of_richer(own) else {
                return false;
            };
            match (moves(own), moves(other)) {
                (_, true) => true,
                (true, false) => false,
                (false, false) => {
                    let both = [own, other];
                    let [tie, others] = both.map(|one| &one["tied_to"]);
                    let key = if tie.is_null() { "value" } else { "start" };
                    tie == others && same(&own[key], &other[key])
                }
            }
        };
        let kept = ["mechanism", "physics"].iter();
        self.free < richer.free
            && kept.clone().all(|key| self.data[*key] == richer.data[*key])
            && parameters(richer.data).all(|one| {
                moves(one) || parameters(self.data).any(|own| own["name"] == one["name"])
            })
            && parameters(self.data).all(is_kept)
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

fn parameters(data: &Value) -> impl Iterator<Item = &Value> {
    data["parameters"].as_array().into_iter().flatten()
}

/// Whether a fit moves a parameter by itself.
fn moves(parameter: &Value) -> bool {
    let status = parameter["status"].as_str().unwrap_or_default();
    !["fixed", "tied"].contains(&status)
}

fn same(a: &Value, b: &Value) -> bool {
    match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME * a.abs().max(b.abs()),
        _ if a.is_object() && b.is_object() => same(&a["value"], &b["value"]),
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
            mechanism: fit.data["mechanism"]
                .as_str()
                .unwrap_or_default()
                .to_owned(),
            effects: fit.data["physics"].as_array().map_or(0, Vec::len),
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
        let table = table_of(
            &self.models,
            &[
                ("model", &|one| one.name.clone()),
                ("mechanism", &|one| one.mechanism.clone()),
                ("effects", &|one| one.effects.to_string()),
                ("free", &|one| one.free.to_string()),
                ("weighted squares", &|one| significant(one.squares, 4)),
                ("AICc", &|one| digits(one.aicc, 4)),
                ("above the best", &|one| {
                    or_dash(one.delta_aicc, |more| format!("{more:.1}"))
                }),
                ("root mean square error in unseen poses, %", &|one| {
                    digits(one.unseen_rms_percent, 3)
                }),
            ],
        );
        let mut document = Document::new();
        document.paragraph("Models of the same cells; the smallest AICc is best:");
        document.table(table);
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
    fn fit(free: usize, squares: f64, sigma: &str) -> [Value; 2] {
        let parameter = |place: usize| {
            let status = if place < free { "free" } else { "fixed" };
            json!({"name": format!("p{place}"), "status": status, "value": 0.0, "start": 0.0, "tied_to": null})
        };
        let cell = |place: usize| {
            json!({"pose": format!("P{place}"), "direction": "x", "measured": {"value": 2.0}, "ln_uncertainty": 0.01,
                "held_out": false, "predicted_without_its_pose": {"value": 2.0 + 0.02 * free as f64}})
        };
        let dof = 10 - free;
        let data = json!({
            "mechanism": "F", "physics": [], "sigma": sigma, "dof": dof, "reduced_chi2": squares / dof as f64,
            "parameters": (0..3).map(parameter).collect::<Vec<_>>(), "cells": (0..10).map(cell).collect::<Vec<_>>(),
        });
        [data, json!({"data": [{"sha256": "a"}]})]
    }

    #[test]
    fn numbers_are_those_of_the_textbook() {
        let [line, inputs] = fit(2, 4.0, "estimated");
        let [parabola, _] = fit(3, 2.5, "estimated");
        let fits = [("line", &line), ("parabola", &parabola)]
            .map(|(name, data)| ComparedFit::new(name, data, &inputs).unwrap());
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
        let [known, _] = fit(2, 4.0, "known");
        let known = ComparedFit::new("known", &known, &inputs).unwrap();
        assert!((known.aicc().unwrap() - (4.0 + 4.0 + 12.0 / 7.0)).abs() < 1e-12);
        assert_eq!(
            known.differs_from(&fits[0]),
            Some("it weights the cells differently")
        );
    }

    #[test]
    fn models_of_other_data_are_not_ranked() {
        let [own, inputs] = fit(2, 4.0, "known");
        let first = ComparedFit::new("a", &own, &inputs).unwrap();
        let differs = |data: &Value, inputs: &Value| {
            ComparedFit::new("b", data, inputs)
                .unwrap()
                .differs_from(&first)
        };
        assert_eq!(differs(&own, &inputs), None);
        let other = json!({"data": [{"sha256": "b"}]});
        assert_eq!(differs(&own, &other), Some("it was fitted to other data"));
        let mut fewer = own.clone();
        fewer["cells"].as_array_mut().unwrap().pop();
        assert!(differs(&fewer, &inputs).is_some());
        let mut held = own.clone();
        held["cells"][0]["held_out"] = true.into();
        assert_eq!(
            differs(&held, &inputs),
            Some("it was fitted to other poses")
        );
        assert!(ComparedFit::new("c", &json!({}), &inputs).is_err());
    }
}
