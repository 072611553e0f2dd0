//! Significance of the section constants, for people and for programs.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table};

use crate::fit::{Scope, SectionSignificance, SequenceStep};
use crate::robot::FittingFactors;
use crate::structure::Property;
use crate::test_point::PoseId;

use super::text::{digits, significant, with_unit};

/// Significance as the data of `stiffbench robot significance --json`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SignificanceReport {
    /// The pose.
    pub pose: PoseId,
    /// Elements in which the constants were changed.
    pub scope: Scope,
    /// The factors around which they were changed.
    pub factors: FittingFactors,
    /// Displacement per force, um/N.
    #[serde(rename = "compliance_um_per_N")]
    pub compliance_um_per_n: ByDirection<f64>,
    /// What remains of the displacement when a constant is multiplied by 100, by constant, 1.
    pub remaining_at_100: BTreeMap<Property, ByDirection<f64>>,
    /// Share of each constant in the compliance, 1.
    pub share: BTreeMap<Property, ByDirection<f64>>,
    /// Share of everything else, 1.
    pub share_of_others: ByDirection<f64>,
    /// The fitting sequence.
    pub sequence: Vec<SequenceStep>,
    /// Single sections and springs.
    pub further: Vec<FurtherSignificance>,
}

/// A value along each axis.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ByDirection<T> {
    /// Along x.
    pub x: T,
    /// Along y.
    pub y: T,
    /// Along z.
    pub z: T,
}

/// Significance of a single section constant or a spring.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FurtherSignificance {
    /// Its name.
    pub name: String,
    /// Its value in `unit`.
    pub value: f64,
    /// `1` of a factor, `rad/(N*m)` of a spring.
    pub unit: Cow<'static, str>,
    /// What remains of the displacement when it is a hundred times as stiff, 1.
    pub remaining_at_100: ByDirection<f64>,
    /// Its share in the compliance, 1.
    pub share: ByDirection<f64>,
    /// Compliance of a spring that adds 1 % to the displacement, rad/(N*m); `null` where no load acts on it, and for factors.
    pub adds_one_percent_at: ByDirection<Option<f64>>,
}

impl<T> From<[T; 3]> for ByDirection<T> {
    fn from([x, y, z]: [T; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<T: Copy> ByDirection<T> {
    /// x, y, z.
    fn each(&self) -> [T; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<&SectionSignificance> for SignificanceReport {
    fn from(significance: &SectionSignificance) -> Self {
        let by_property = |rows: &[[f64; 3]; 4]| {
            let rows = Property::ALL.into_iter().zip(rows);
            rows.map(|(property, row)| (property, (*row).into()))
                .collect()
        };
        let further = significance
            .further
            .iter()
            .map(|further| FurtherSignificance {
                name: further.parameter.to_string(),
                value: further.value,
                unit: further.parameter.unit().into(),
                remaining_at_100: further.remaining.into(),
                share: further.shares.into(),
                adds_one_percent_at: further.adds_a_hundredth.into(),
            });
        Self {
            pose: significance.pose.clone(),
            scope: significance.scope,
            factors: significance.factors.clone(),
            compliance_um_per_n: significance.compliance_m_per_n.map(|c| c * 1e6).into(),
            remaining_at_100: by_property(&significance.remaining),
            share: by_property(&significance.shares),
            share_of_others: significance.share_of_others.into(),
            sequence: significance.sequence(),
            further: further.collect(),
        }
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Heads of the columns with the shares of the directions.
fn share_heads() -> [String; 3] {
    AXES.map(|axis| format!("{axis}: share, %"))
}

impl SignificanceReport {
    /// Tables and sequence.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = self.of_constants();
        document.append(self.of_further());
        document.paragraph(format!(
            "Fitting sequence: {}.",
            sequence_text(&self.sequence)
        ));
        document
    }

    /// Both readings of significance beside each other: what a hundredfold leaves, and the exact share.
    pub(super) fn of_constants(&self) -> Document {
        let constants = Property::ALL.map(|property| {
            let left = &self.remaining_at_100[&property];
            (property.name(), Some(left), &self.share[&property])
        });
        let links = (self.scope == Scope::Beams).then_some(("links", None, &self.share_of_others));
        let percent = |part: f64| format!("{:.2}", 100.0 * part);
        let left = |left: Option<&ByDirection<f64>>| {
            left.map_or_else(Default::default, |left| left.each().map(percent))
        };
        let mut document = Document::new();
        document.table(
            Table::of(constants.into_iter().chain(links))
                .words("constant", |(name, ..)| *name)
                .numbers_each(AXES.map(|axis| format!("{axis}: % left")), |(_, of, _)| {
                    left(*of)
                })
                .numbers_each(share_heads(), |(.., share)| share.each().map(percent)),
        );
        let others = self.share_of_others.each();
        let total = [0, 1, 2].map(|i| {
            let shares = Property::ALL.map(|property| self.share[&property].each()[i]);
            shares.iter().sum::<f64>() + others[i]
        });
        let compliance = self.compliance_um_per_n.each().map(|c| significant(c, 4));
        document.paragraph(format!(
            "% left: displacement when the constant is multiplied by 100, in percent of before (the paper's Table III). Share: part of the \
             compliance stored through the constant; shares of a direction add up to {:.4}, {:.4}, {:.4}. Compliance before: {} µm/N (x, y, z).",
            total[0],
            total[1],
            total[2],
            compliance.join(", ")
        ));
        document
    }

    /// Single sections and springs; empty without any.
    fn of_further(&self) -> Document {
        let mut document = Document::new();
        if self.further.is_empty() {
            return document;
        }
        let percent = |part: f64| format!("{:.2}", 100.0 * part);
        document.table(
            Table::of(&self.further)
                .words("parameter", |one| with_unit(&one.name, &one.unit))
                .numbers("value", |one| significant(one.value, 4))
                .numbers_each(share_heads(), |one| one.share.each().map(percent))
                .numbers_each(AXES.map(|axis| format!("{axis}: 1 % at")), |one| {
                    one.adds_one_percent_at.each().map(|at| digits(at, 3))
                }),
        );
        document.paragraph(
            "Share: part of the compliance. 1 % at: compliance of a spring that adds 1 % to the displacement.",
        );
        document
    }
}

/// The fitting sequence in one line.
#[must_use]
pub(super) fn sequence_text(sequence: &[SequenceStep]) -> String {
    let step = |step: &SequenceStep| match step.direction {
        Some(direction) => format!("a_{} on {direction}", step.property.name()),
        None => format!("a_{} stays", step.property.name()),
    };
    sequence.iter().map(step).collect::<Vec<_>>().join(", ")
}
