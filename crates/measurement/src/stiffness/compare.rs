//! Two tables of the same cells: did the stiffness change?

use std::collections::{HashMap, HashSet};
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::estimate::Method;
use super::table::{CellStiffness, StiffnessTable};
use stiffbench_numeric::statistics::{
    Estimate, chi_squared_upper_tail, normal_quantile, student_t_quantile, welch_satterthwaite,
};
use stiffbench_units_and_text::test_point::Cell;

/// Probability of a false "differs" of all cells together, and again of the single cells: half of 5 % for each, so that the
/// comparison as a whole holds 5 %.
const LEVEL_OF_EACH: f64 = 0.025;

/// Which gauges were the same in both tables, by serial number; their calibration error is then the same too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SameGauges {
    /// The force gauge.
    pub force: bool,
    /// The displacement gauge.
    pub displacement: bool,
}

impl From<bool> for SameGauges {
    /// Both the same, or neither.
    fn from(same: bool) -> Self {
        Self {
            force: same,
            displacement: same,
        }
    }
}

/// Change of the stiffness of one cell from table a to table b.
#[derive(Debug, Clone, PartialEq)]
pub struct CellChange {
    /// Pose and direction.
    pub cell: Cell,
    /// Stiffness in a, N/m.
    pub a_n_per_m: f64,
    /// Stiffness in b, N/m.
    pub b_n_per_m: f64,
    /// b minus a, N/m.
    pub change_n_per_m: f64,
    /// Standard uncertainty of the change, N/m; what both share is cancelled.
    pub standard_uncertainty_n_per_m: f64,
    /// Its effective degrees of freedom.
    pub dof: f64,
    /// Expanded uncertainty of the change for 95 %, N/m.
    pub expanded_n_per_m: f64,
    /// Change over its expanded uncertainty: beyond 1 in size for one cell in twenty that has not changed.
    pub en_ratio: f64,
    /// Whether this cell differs by itself, the number of cells allowed for (Holm at 2.5 %).
    pub differs: bool,
}

/// Change of the width of a cell's loop from table a to table b, at the load at which it is largest in a.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopChange {
    /// Pose and direction.
    pub cell: Cell,
    /// The load, N.
    pub target_n: f64,
    /// Width in a, m.
    pub a_m: f64,
    /// Width in b, m.
    pub b_m: f64,
    /// b minus a, m.
    pub change_m: Estimate,
}

impl LoopChange {
    /// `None` without a loop in one of the two, or where b was not read at the load.
    fn new(a: &CellStiffness, b: &CellStiffness) -> Option<Self> {
        let [loop_a, loop_b] = [a.hysteresis.as_ref()?, b.hysteresis.as_ref()?];
        let target_n = loop_a.largest.target_n;
        let [a_m, b_m] = [loop_a, loop_b].map(|found| {
            let mut widths = found.widths.iter();
            let width = widths.find(|width| width.target_n == target_n)?;
            Some(width.width_m)
        });
        let (a_m, b_m) = a_m.zip(b_m)?;
        let parts = [a_m, b_m].map(|width| (width.standard_uncertainty, width.dof));
        Some(Self {
            cell: a.cell.clone(),
            target_n,
            a_m: a_m.value,
            b_m: b_m.value,
            change_m: Estimate {
                value: b_m.value - a_m.value,
                standard_uncertainty: a_m.standard_uncertainty.hypot(b_m.standard_uncertainty),
                dof: welch_satterthwaite(&parts),
            },
        })
    }
}

/// Why a cell was not compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotCompared {
    /// Only in table a.
    OnlyInA,
    /// Only in table b.
    OnlyInB,
    /// No stiffness or no uncertainty in one of the tables.
    NoUncertainty,
}

impl fmt::Display for NotCompared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::OnlyInA => "only in the first",
            Self::OnlyInB => "only in the second",
            Self::NoUncertainty => "no stiffness with an uncertainty in one of the two",
        })
    }
}

/// The test of all cells together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "OverallDifference")]
pub struct OverallTest {
    /// Chi-squared: dᵀ V⁻¹ d of the changes.
    #[serde(rename = "chi2")]
    pub chi_squared: f64,
    /// Its degrees of freedom: the number of cells compared.
    pub dof: usize,
    /// Chance of as much or more if nothing differs.
    pub p: f64,
    /// Whether that is below the level of `DECISION_RULE`.
    #[serde(skip)]
    pub differs: bool,
}

/// Whether two sessions agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "ComparisonVerdict")]
pub enum StiffnessAgreement {
    /// No cell differs by itself, the number of cells allowed for, nor do all together.
    Agrees,
    /// A cell differs by itself, or all together do.
    Differs,
    /// They have no cell in common.
    NothingToCompare,
}

/// Comparison of two tables by the regression stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Cells in both, in the order of a.
    pub changes: Vec<CellChange>,
    /// The others, with the reason.
    pub not_compared: Vec<(Cell, NotCompared)>,
    /// Widths of the loops of cells that have one in both.
    pub loops: Vec<LoopChange>,
    /// The test over all cells; `None` without cells, or if a change has an uncertainty of zero.
    pub overall: Option<OverallTest>,
    /// The answer by `DECISION_RULE`.
    pub agreement: StiffnessAgreement,
}

/// The rule behind `Comparison::agreement`.
pub const DECISION_RULE: &str = "the tables differ if a single cell differs (Holm's rule at 2.5 % over all cells), or if all cells together differ (chi-squared with the correlations of shared calibration, at 2.5 %); for chi-squared, standard uncertainties are enlarged to U95/1.96 to allow for few degrees of freedom; without any change, tables are found to differ in at most 5 % of cases";

/// A change with its own uncertainty and the effects of calibration: one entry per independent calibration error.
struct Change {
    cell: Cell,
    a: f64,
    b: f64,
    independent: [(f64, f64); 2],
    /// Force in a, force in b, displacement in a, displacement in b; with the same gauge the difference of both stands in a's place.
    shared: [f64; 4],
}

/// Compares the regression stiffness of the cells of `a` and `b`.
///
/// An error of calibration common to both moves both stiffnesses by the same share, so of it only the difference
/// u(ln K) · (K_b - K_a) and the difference of the loads used remain; with different gauges both errors count, and still move all
/// cells of a table together.
#[must_use]
pub fn compare(
    a: &StiffnessTable,
    b: &StiffnessTable,
    same_gauges: impl Into<SameGauges>,
) -> Comparison {
    let same = same_gauges.into();
    let rows_of_b: HashMap<&Cell, &CellStiffness> =
        b.cells.iter().map(|row| (&row.cell, row)).collect();
    let cells_of_a: HashSet<&Cell> = a.cells.iter().map(|row| &row.cell).collect();
    let mut changes = Vec::new();
    let mut loops = Vec::new();
    let mut not_compared = Vec::new();
    for row in &a.cells {
        let Some(other) = rows_of_b.get(&row.cell) else {
            not_compared.push((row.cell.clone(), NotCompared::OnlyInA));
            continue;
        };
        loops.extend(LoopChange::new(row, other));
        match change(row, other, same) {
            Some(change) => changes.push(change),
            None => not_compared.push((row.cell.clone(), NotCompared::NoUncertainty)),
        }
    }
    for row in b.cells.iter().filter(|row| !cells_of_a.contains(&row.cell)) {
        not_compared.push((row.cell.clone(), NotCompared::OnlyInB));
    }
    let overall = overall_test(&changes);
    let mut changes: Vec<CellChange> = changes.iter().filter_map(cell_change).collect();
    mark_by_holm(&mut changes);
    let agreement = agreement_of(&changes, overall.as_ref());
    Comparison {
        changes,
        not_compared,
        loops,
        overall,
        agreement,
    }
}

fn agreement_of(changes: &[CellChange], overall: Option<&OverallTest>) -> StiffnessAgreement {
    let together = overall.is_some_and(|test| test.differs);
    if changes.is_empty() {
        StiffnessAgreement::NothingToCompare
    } else if together || changes.iter().any(|change| change.differs) {
        StiffnessAgreement::Differs
    } else {
        StiffnessAgreement::Agrees
    }
}

/// `None` if one of the two has no stiffness or no uncertainty.
fn change(a: &CellStiffness, b: &CellStiffness, same: SameGauges) -> Option<Change> {
    let of = |row: &CellStiffness| {
        let estimate = row.by(Method::Regression).ok()?;
        estimate.estimate.expanded_95()?;
        let (value, parts) = (estimate.estimate.value, estimate.ln_parts);
        // Standard uncertainties, N/m.
        let [own, force, displacement] = [
            parts.independent?,
            parts.force_calibration,
            parts.displacement_calibration,
        ]
        .map(|part| value.abs() * part);
        Some((value, (own, parts.independent_dof), force, displacement))
    };
    let (a_n_per_m, own_a, force_a, displacement_a) = of(a)?;
    let (b_n_per_m, own_b, force_b, displacement_b) = of(b)?;
    let pair = |same: bool, a: f64, b: f64| if same { [b - a, 0.0] } else { [a, b] };
    let force = pair(same.force, force_a, force_b);
    let displacement = pair(same.displacement, displacement_a, displacement_b);
    Some(Change {
        cell: a.cell.clone(),
        a: a_n_per_m,
        b: b_n_per_m,
        independent: [own_a, own_b],
        shared: [force[0], force[1], displacement[0], displacement[1]],
    })
}

impl Change {
    fn components(&self) -> Vec<(f64, f64)> {
        let shared = self.shared.iter().map(|u| (*u, f64::INFINITY));
        self.independent.iter().copied().chain(shared).collect()
    }

    /// Own variance with its standard uncertainty enlarged to U95/1.96; `None` without one.
    fn own_variance(&self) -> Option<f64> {
        let variance: f64 = self.independent.iter().map(|(u, _)| u * u).sum();
        let dof = welch_satterthwaite(&self.independent);
        let enlarged = student_t_quantile(0.975, dof)? / normal_quantile(0.975);
        let variance = variance * enlarged * enlarged;
        (variance > 0.0).then_some(variance)
    }
}

fn cell_change(change: &Change) -> Option<CellChange> {
    let components = change.components();
    let standard: f64 = components.iter().map(|(u, _)| u * u).sum::<f64>().sqrt();
    let dof = welch_satterthwaite(&components);
    let expanded = student_t_quantile(0.975, dof)? * standard;
    let difference = change.b - change.a;
    Some(CellChange {
        cell: change.cell.clone(),
        a_n_per_m: change.a,
        b_n_per_m: change.b,
        change_n_per_m: difference,
        standard_uncertainty_n_per_m: standard,
        dof,
        expanded_n_per_m: expanded,
        // Two equal numbers without any uncertainty agree.
        en_ratio: if difference == 0.0 {
            0.0
        } else {
            difference / expanded
        },
        differs: false,
    })
}

/// Holm's step-down rule: the farthest cell against 2.5 %/n, the next against 2.5 %/(n - 1), until one passes.
fn mark_by_holm(changes: &mut [CellChange]) {
    let n = changes.len();
    let mut order: Vec<usize> = (0..n).collect();
    let excess = |change: &CellChange, left: usize| {
        let p = 1.0 - LEVEL_OF_EACH / (2.0 * left as f64);
        let statistic = change.change_n_per_m.abs() / change.standard_uncertainty_n_per_m;
        student_t_quantile(p, change.dof).is_some_and(|limit| statistic > limit)
    };
    order.sort_by(|&i, &j| {
        changes[j]
            .en_ratio
            .abs()
            .total_cmp(&changes[i].en_ratio.abs())
    });
    for (passed, index) in order.into_iter().enumerate() {
        if !excess(&changes[index], n - passed) {
            break;
        }
        changes[index].differs = true;
    }
}

/// χ² = dᵀ V⁻¹ d, V = diag(own variances) + Σ s sᵀ over the calibration errors s.
///
/// The inverse is applied term by term (Sherman and Morrison): V_j⁻¹ x = V_{j-1}⁻¹ x - w (w·x)/(1 + s·w), w = V_{j-1}⁻¹ s.
fn overall_test(changes: &[Change]) -> Option<OverallTest> {
    if changes.is_empty() {
        return None;
    }
    let own: Option<Vec<f64>> = changes.iter().map(Change::own_variance).collect();
    let own = own?;
    let mut updates: Vec<(Vec<f64>, f64)> = Vec::new();
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let apply = |updates: &[(Vec<f64>, f64)], x: &[f64]| {
        let mut result: Vec<f64> = x.iter().zip(&own).map(|(x, v)| x / v).collect();
        for (w, denominator) in updates {
            let factor = dot(w, x) / denominator;
            for (entry, w) in result.iter_mut().zip(w) {
                *entry -= factor * w;
            }
        }
        result
    };
    for error in 0..4 {
        let s: Vec<f64> = changes.iter().map(|change| change.shared[error]).collect();
        let w = apply(&updates, &s);
        let denominator = 1.0 + dot(&s, &w);
        updates.push((w, denominator));
    }
    let differences: Vec<f64> = changes.iter().map(|change| change.b - change.a).collect();
    let chi_squared = dot(&differences, &apply(&updates, &differences)).max(0.0);
    let p = chi_squared_upper_tail(chi_squared, changes.len() as f64)?;
    Some(OverallTest {
        chi_squared,
        dof: changes.len(),
        p,
        differs: p < LEVEL_OF_EACH,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stiffness::sample::SimulatedBench;
    use crate::stiffness::{GaugePair, GaugeTerms, StiffnessOptions, stiffness_table};
    use stiffbench_units_and_text::test_point::Direction::{X, Y};

    /// Tables of two runs of one bench with a calibration of 1 % at the largest load, b stiffer by `factor`.
    fn pair(factor: f64) -> [StiffnessTable; 2] {
        let gauges = GaugePair {
            force: GaugeTerms::new(None, Some(1.4), Some(2.0)).unwrap(),
            ..GaugePair::default()
        };
        [(30, 1.0), (31, factor)].map(|(seed, factor)| {
            let mut readings = SimulatedBench::paper(6, seed).readings();
            for reading in &mut readings {
                reading.displacement_m /= factor;
            }
            stiffness_table(&readings, &gauges, StiffnessOptions::default())
        })
    }

    #[test]
    fn a_calibration_common_to_both_cancels_and_one_of_two_gauges_does_not() {
        let [a, b] = pair(1.0);
        let same = compare(&a, &b, true);
        let apart = compare(&a, &b, false);
        for (same, apart) in same.changes.iter().zip(&apart.changes) {
            let own = |table: &StiffnessTable| {
                let estimate = table
                    .cell(&same.cell)
                    .unwrap()
                    .by(Method::Regression)
                    .unwrap();
                estimate.type_a.unwrap().standard_uncertainty
            };
            let expected = (own(&a).powi(2) + own(&b).powi(2)).sqrt();
            assert!((same.standard_uncertainty_n_per_m / expected - 1.0).abs() < 1e-3);
            // Two independent errors of 1 % of 50 N/mm besides.
            let expected = (expected.powi(2) + 2.0 * 500.0_f64.powi(2)).sqrt();
            assert!((apart.standard_uncertainty_n_per_m / expected - 1.0).abs() < 0.02);
            assert!(apart.en_ratio.abs() < same.en_ratio.abs());
        }
    }

    #[test]
    fn a_change_that_all_cells_share_may_be_the_other_gauge_but_not_the_same_one() {
        // 1.5 % in all cells: one standard error of two gauges of 1 % each, many of the scatter alone.
        let [a, b] = pair(1.015);
        assert_eq!(compare(&a, &b, true).agreement, StiffnessAgreement::Differs);
        assert_eq!(compare(&a, &b, false).agreement, StiffnessAgreement::Agrees);
    }

    #[test]
    fn chi_squared_is_that_of_the_whole_matrix() {
        // Two cells, own variance 1 and 4 (infinite dof), one common error of effect 2 and 1: V = [[5, 2], [2, 5]].
        let change = |direction, difference, own, effect| Change {
            cell: Cell::new("P1".into(), direction),
            a: 0.0,
            b: difference,
            independent: [(own, f64::INFINITY), (0.0, f64::INFINITY)],
            shared: [effect, 0.0, 0.0, 0.0],
        };
        let changes = [change(X, 3.0, 1.0, 2.0), change(Y, -1.0, 2.0, 1.0)];
        let test = overall_test(&changes).unwrap();
        // V⁻¹ = [[5, -2], [-2, 5]]/21, d = (3, -1): (45 + 12 + 5)/21.
        assert!((test.chi_squared - 62.0 / 21.0).abs() < 1e-12);
        assert_eq!(test.dof, 2);
        assert!((test.p - (-31.0_f64 / 21.0).exp()).abs() < 1e-9);
    }

    #[test]
    fn the_answer_is_that_of_the_cells_and_of_all_together() {
        // Sixty cells of unit uncertainty and endless degrees of freedom. One alone off by 4: chi-squared 16 of 60, and Holm's first
        // limit is the normal quantile of 1 - 0.025/120, 3.53; by 3 its En is 1.53, and it is not named. All off by 1.4: 118 of 60.
        let of = |differences: &dyn Fn(usize) -> f64| {
            let changes: Vec<Change> = (0..60)
                .map(|index| Change {
                    cell: Cell::new(format!("P{index}").as_str().into(), X),
                    a: 0.0,
                    b: differences(index),
                    independent: [(1.0, f64::INFINITY), (0.0, f64::INFINITY)],
                    shared: [0.0; 4],
                })
                .collect();
            let overall = overall_test(&changes).unwrap();
            let mut changes: Vec<CellChange> = changes.iter().filter_map(cell_change).collect();
            mark_by_holm(&mut changes);
            let named = changes.iter().filter(|change| change.differs).count();
            (
                named,
                overall.differs,
                agreement_of(&changes, Some(&overall)),
            )
        };
        let one = |size: f64| move |index: usize| if index == 7 { size } else { 0.0 };
        assert_eq!(of(&one(4.0)), (1, false, StiffnessAgreement::Differs));
        assert_eq!(of(&one(3.0)), (0, false, StiffnessAgreement::Agrees));
        assert_eq!(of(&|_| 1.4), (0, true, StiffnessAgreement::Differs));
    }

    #[test]
    fn cells_of_one_table_only_are_listed() {
        let gauges = GaugePair::default();
        let [small, large] = [2, 3].map(|n| {
            let readings = SimulatedBench::paper(n, 1).readings();
            stiffness_table(&readings, &gauges, StiffnessOptions::default())
        });
        let reasons = |comparison: &Comparison| -> Vec<NotCompared> {
            comparison
                .not_compared
                .iter()
                .map(|(_, why)| *why)
                .collect()
        };
        assert_eq!(
            reasons(&compare(&small, &large, true)),
            [NotCompared::OnlyInB]
        );
        assert_eq!(
            reasons(&compare(&large, &small, true)),
            [NotCompared::OnlyInA]
        );
        // A single reading per cell has no uncertainty.
        let mut readings = SimulatedBench::paper(2, 1).readings();
        readings.retain(|r| r.repeat == 1 && r.step < 2);
        let bare = stiffness_table(&readings, &gauges, StiffnessOptions::default());
        let comparison = compare(&small, &bare, true);
        assert_eq!(reasons(&comparison), [NotCompared::NoUncertainty; 2]);
        assert_eq!(comparison.agreement, StiffnessAgreement::NothingToCompare);
        assert!(
            NotCompared::NoUncertainty
                .to_string()
                .contains("uncertainty")
        );
    }
}
