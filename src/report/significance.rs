//! Significance of the section constants, for people and for programs.

use serde_json::{Value, json};

use crate::fit::{Scope, SectionSignificance, SequenceStep};
use crate::structure::Property;
use crate::test_point::Direction;

use super::text::{AlignedTable, significant};

/// Both readings of significance beside each other: what a hundredfold leaves, and the exact share.
#[must_use]
pub(super) fn significance_text(significance: &SectionSignificance) -> String {
    let mut rows = AlignedTable::new(&[
        "constant",
        "x: % left",
        "y: % left",
        "z: % left",
        "x: share, %",
        "y: share, %",
        "z: share, %",
    ]);
    for property in Property::ALL {
        let (left, share) = (
            significance.remaining[property.index()],
            significance.shares[property.index()],
        );
        let cells = left
            .iter()
            .chain(&share)
            .map(|part| format!("{:.2}", 100.0 * part));
        rows.row(std::iter::once(property.name().to_owned()).chain(cells));
    }
    if significance.scope == Scope::Beams {
        let none = ["", "", ""].map(str::to_owned);
        let others = significance
            .share_of_others
            .map(|part| format!("{:.2}", 100.0 * part));
        rows.row(
            std::iter::once("links".to_owned())
                .chain(none)
                .chain(others),
        );
    }
    let total = [0, 1, 2].map(|i| {
        significance.shares.iter().map(|row| row[i]).sum::<f64>() + significance.share_of_others[i]
    });
    let compliance = significance
        .compliance_m_per_n
        .map(|c| significant(c * 1e6, 4));
    format!(
        "{}\n% left: displacement when the constant is multiplied by 100, in percent of before (the paper's Table III). Share: part of the\n\
         compliance stored through the constant; shares of a direction add up to {:.4}, {:.4}, {:.4}. Compliance before: {} um/N (x, y, z).\n",
        rows.text(),
        total[0],
        total[1],
        total[2],
        compliance.join(", ")
    )
}

/// Single sections and springs; empty without any.
fn further_text(significance: &SectionSignificance) -> String {
    if significance.further.is_empty() {
        return String::new();
    }
    let mut rows = AlignedTable::new(&[
        "parameter",
        "value",
        "x: share, %",
        "y: share, %",
        "z: share, %",
        "x: 1 % at",
        "y: 1 % at",
        "z: 1 % at",
    ]);
    for further in &significance.further {
        let share = further.shares.map(|part| format!("{:.2}", 100.0 * part));
        let adds = further.adds_a_hundredth;
        let adds = adds.map(|at| at.map_or_else(|| "-".to_owned(), |at| significant(at, 3)));
        let unit = further.parameter.unit();
        let name = match unit {
            "1" => further.parameter.to_string(),
            unit => format!("{}, {unit}", further.parameter),
        };
        let value = significant(further.value, 4);
        rows.row([name, value].into_iter().chain(share).chain(adds));
    }
    format!(
        "\n{}\nShare: part of the compliance. 1 % at: compliance of a spring that adds 1 % to the displacement.\n",
        rows.text()
    )
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

/// The same for programs.
#[must_use]
pub fn significance_json(significance: &SectionSignificance) -> Value {
    let by_direction = |values: [f64; 3]| -> Value {
        Value::Object(
            Direction::ALL
                .into_iter()
                .map(|d| (d.to_string(), json!(values[d.index()])))
                .collect(),
        )
    };
    let by_property = |rows: [[f64; 3]; 4]| -> Value {
        Value::Object(
            Property::ALL
                .into_iter()
                .map(|p| (p.name().to_owned(), by_direction(rows[p.index()])))
                .collect(),
        )
    };
    json!({
        "pose": significance.pose,
        "scope": significance.scope,
        "factors": significance.factors,
        "compliance_um_per_N": by_direction(significance.compliance_m_per_n.map(|c| c * 1e6)),
        "remaining_at_100": by_property(significance.remaining),
        "share": by_property(significance.shares),
        "share_of_others": by_direction(significance.share_of_others),
        "sequence": significance.sequence(),
        "further": significance.further.iter().map(|further| json!({
            "name": further.parameter.to_string(),
            "value": further.value,
            "unit": further.parameter.unit(),
            "remaining_at_100": by_direction(further.remaining),
            "share": by_direction(further.shares),
            "adds_one_percent_at": Direction::ALL
                .into_iter()
                .map(|d| (d.to_string(), json!(further.adds_a_hundredth[d.index()])))
                .collect::<serde_json::Map<_, _>>(),
        })).collect::<Vec<_>>(),
    })
}

/// Table and sequence together.
#[must_use]
pub fn significance_with_sequence(significance: &SectionSignificance) -> String {
    format!(
        "{}{}\nFitting sequence: {}.\n",
        significance_text(significance),
        further_text(significance),
        sequence_text(&significance.sequence())
    )
}
