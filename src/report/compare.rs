//! The comparison of two sessions, for people and for programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use stiffbench_document::{Document, Table};

use crate::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM,
};
use crate::reported::Reported;
use crate::stiffness::{
    CellChange, Comparison, DECISION_RULE, LoopChange, NotCompared, OverallTest, StiffnessAgreement,
};
use crate::test_point::{Direction, PoseId};

use super::text::{significant, value_and_u};
use crate::count::counted;

/// Unit of every stiffness.
const UNIT: &str = "N/um";

/// The comparison of two sessions, A and B.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ComparisonReport {
    /// The cells that both have.
    pub cells: Vec<CellDifference>,
    /// The others.
    pub not_compared: Vec<CellNotCompared>,
    /// Widths of the loops between loading and unloading of the cells that have one in both; no part of the verdict.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<LoopDifference>,
    /// All cells together; `null` without cells.
    pub overall: Option<OverallTest>,
    /// Whether the sessions agree.
    pub verdict: StiffnessAgreement,
    /// The verdict in a sentence, with the cells that differ.
    pub headline: String,
    /// The rule behind the verdict.
    pub rule: Cow<'static, str>,
    /// Whether the robot files of the sessions differ.
    pub two_robots: bool,
}

/// The stiffness of one cell in two sessions.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct CellDifference {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Stiffness in A.
    pub a: Reported,
    /// Stiffness in B.
    pub b: Reported,
    /// B minus A.
    pub difference: MeasuredDifference,
    /// The difference over its expanded uncertainty.
    pub en_ratio: f64,
    /// Whether the cell differs by itself: Holm's rule at 2.5 % over all cells, which is stricter than a ratio beyond 1.
    pub differs: bool,
}

/// The width of the loop of one cell in two sessions, at the load at which it is largest in A.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LoopDifference {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Target force.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// Width in A.
    pub a: Reported,
    /// Width in B.
    pub b: Reported,
    /// B minus A, with the uncertainty at this load.
    pub difference: Reported,
}

/// A difference with its uncertainty.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MeasuredDifference {
    /// The difference in `unit`.
    pub value: f64,
    /// Unit of all three.
    pub unit: Cow<'static, str>,
    /// Standard uncertainty.
    pub u: f64,
    /// Expanded uncertainty for 95 %.
    #[serde(rename = "U")]
    pub expanded: f64,
    /// Effective degrees of freedom; `null` where they have no limit.
    pub dof: Option<f64>,
}

/// A cell that cannot be compared.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct CellNotCompared {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Why.
    pub reason: Cow<'static, str>,
}

impl ComparisonReport {
    /// The comparison for a report.
    #[must_use]
    pub fn new(comparison: &Comparison, two_robots: bool) -> Self {
        let left_out = comparison.not_compared.iter();
        Self {
            cells: comparison.changes.iter().map(CellDifference::of).collect(),
            not_compared: left_out
                .map(|(cell, reason)| CellNotCompared {
                    pose: cell.pose.clone(),
                    direction: cell.direction,
                    reason: reason_words(*reason).into(),
                })
                .collect(),
            loops: comparison.loops.iter().map(Into::into).collect(),
            overall: comparison.overall,
            verdict: comparison.agreement,
            headline: verdict_sentence(comparison),
            rule: DECISION_RULE.into(),
            two_robots,
        }
    }

    /// Differences cell by cell, and the verdict with its rule.
    ///
    /// # Arguments
    /// - `a`, `b`: what the sessions are called.
    #[must_use]
    pub fn document(&self, a: &str, b: &str) -> Document {
        let stiffness = |reported: &Reported| significant(reported.value.unwrap_or(f64::NAN), 5);
        let difference = |cell: &&CellDifference| {
            let MeasuredDifference {
                value, expanded, ..
            } = cell.difference;
            value_and_u([Some(value), Some(expanded)], 3, "-")
        };
        let dof =
            |dof: Option<f64>| dof.map_or_else(|| "inf".to_owned(), |dof| significant(dof, 2));
        let differs = |differs: bool| if differs { "yes" } else { "" }.to_owned();
        let mut document = Document::new();
        document.paragraph(&self.headline);
        document.item(format!("A is {a}"));
        document.item(format!("B is {b}"));
        document.table(
            Table::of(&self.cells)
                .words("pose", |cell| &cell.pose)
                .words("direction", |cell| &cell.direction)
                .numbers("K of A, N/µm", |cell| stiffness(&cell.a))
                .numbers("K of B, N/µm", |cell| stiffness(&cell.b))
                .numbers_each(["B - A, N/µm", "U"], difference)
                .numbers("B/A - 1, %", |cell| {
                    let share = cell.difference.value / cell.a.value.unwrap_or(f64::NAN);
                    format!("{:+.1}", 100.0 * share)
                })
                .numbers("dof", |cell| dof(cell.difference.dof))
                .numbers("(B - A)/U", |cell| format!("{:.2}", cell.en_ratio))
                .words("differs", |cell| differs(cell.differs)),
        );
        document.paragraph(
            "U is the expanded uncertainty of the difference for 95 %: without any change, |B - A|/U exceeds 1 in one of twenty cells. \
             A cell differs if its difference is too large for chance, given the number of cells.",
        );
        document.section("Hysteresis", self.loops_document());
        for left_out in &self.not_compared {
            let CellNotCompared {
                pose,
                direction,
                reason,
            } = left_out;
            document.item(format!("not compared: {pose} {direction}: {reason}"));
        }
        if let Some(overall) = &self.overall {
            document.paragraph(format!(
                "All cells together: chi-squared {:.2} with {}, {}.",
                overall.chi_squared,
                counted(overall.dof, "degree of freedom"),
                probability(overall.p)
            ));
        }
        document.paragraph(format!("Rule: {}", self.rule));
        document
    }

    /// How the widths of the loops differ; nothing without any.
    fn loops_document(&self) -> Document {
        let mut document = Document::new();
        if self.loops.is_empty() {
            return document;
        }
        let with_u = |value: &Reported, one: &LoopDifference| {
            value_and_u([value.value, one.difference.expanded_uncertainty], 3, "-")
        };
        document.table(
            Table::of(&self.loops)
                .words("pose", |one| &one.pose)
                .words("direction", |one| &one.direction)
                .numbers("at, N", |one| one.target_n)
                .numbers("width of A, µm", |one| with_u(&one.a, one)[0].clone())
                .numbers("width of B, µm", |one| with_u(&one.b, one)[0].clone())
                .numbers_each(["B - A, µm", "U"], |one| with_u(&one.difference, one)),
        );
        document.paragraph(
            "Width of the loop between loading and unloading, at the load at which it is largest in A. U holds for one cell; \
             the widths are no part of the verdict.",
        );
        document
    }

    /// The verdict in a sentence, with the cells that differ.
    #[must_use]
    pub fn sentence(&self) -> &str {
        &self.headline
    }
}

/// The verdict, and what it rests on.
fn verdict_sentence(comparison: &Comparison) -> String {
    match comparison.agreement {
        StiffnessAgreement::Agrees => return "The sessions agree.".to_owned(),
        StiffnessAgreement::NothingToCompare => return "No cell can be compared.".to_owned(),
        StiffnessAgreement::Differs => {}
    }
    let differing = comparison.changes.iter().filter(|change| change.differs);
    let cells: Vec<String> = differing.map(|change| change.cell.to_string()).collect();
    let cells = cells.join(", ");
    match &comparison.overall {
        Some(test) if !test.differs => {
            format!("The sessions differ in {cells}; all cells together do not show it.")
        }
        _ if cells.is_empty() => {
            "The sessions differ in all cells together; no single cell can be named.".to_owned()
        }
        Some(_) => format!("The sessions differ in {cells}, and in all cells together."),
        None => format!("The sessions differ in {cells}."),
    }
}

impl CellDifference {
    fn of(change: &CellChange) -> Self {
        Self {
            pose: change.cell.pose.clone(),
            direction: change.cell.direction,
            a: Reported::exact(change.a_n_per_m / N_PER_UM, UNIT),
            b: Reported::exact(change.b_n_per_m / N_PER_UM, UNIT),
            difference: MeasuredDifference {
                value: change.change_n_per_m / N_PER_UM,
                unit: UNIT.into(),
                u: change.standard_uncertainty_n_per_m / N_PER_UM,
                expanded: change.expanded_n_per_m / N_PER_UM,
                dof: change.dof.is_finite().then_some(change.dof),
            },
            en_ratio: change.en_ratio,
            differs: change.differs,
        }
    }
}

impl From<&LoopChange> for LoopDifference {
    fn from(change: &LoopChange) -> Self {
        let exact = |m: f64| Reported::exact(m / METRES_PER_MICROMETRE, "um");
        Self {
            pose: change.cell.pose.clone(),
            direction: change.cell.direction,
            target_n: change.target_n,
            a: exact(change.a_m),
            b: exact(change.b_m),
            difference: Reported::from_estimate(&change.change_m, METRES_PER_MICROMETRE, "um"),
        }
    }
}

/// A probability in words; one that would print as zero is said to be small.
fn probability(p: f64) -> String {
    if p < 0.001 {
        "p < 0.001".to_owned()
    } else {
        format!("p = {p:.3}")
    }
}

fn reason_words(reason: NotCompared) -> &'static str {
    match reason {
        NotCompared::OnlyInA => "only in A",
        NotCompared::OnlyInB => "only in B",
        NotCompared::NoUncertainty => "without an uncertainty in one of the sessions",
    }
}
