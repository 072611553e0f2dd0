//! What the paper's twelve stiffness values can show.

use std::fmt::Write;

use crate::prove::{FittedLaw, FurtherCell, TwelveValues};
use stiffbench::report::{AlignedTable, significant};

/// Laws that are printed.
const PRINTED: usize = 16;

/// Tables and what follows from them.
#[must_use]
pub fn twelve_values_text(found: &TwelveValues) -> String {
    let mut text = String::from(
        "The paper's bench (Table VI) against its finite elements (Table V): stiffness of the elements over that of the bench\n\n",
    );
    let mut gap = AlignedTable::new(&["pose", "direction", "elements over bench"]);
    for cell in &found.gap {
        gap.row([
            cell.pose.to_string(),
            cell.direction.to_string(),
            format!("{:.2}", cell.ratio),
        ]);
    }
    text.push_str(&gap.text());
    text.push_str(
        "\nWhat one linear law closes of that gap alone (share of the squares of ln K), the elements left as they are\n\n",
    );
    let mut alone: Vec<&FittedLaw> = found.candidates.iter().collect();
    alone.sort_by(|a, b| b.closes.total_cmp(&a.closes));
    let mut rows = AlignedTable::new(&["law", "value", "closes, %"]);
    for candidate in alone.iter().take(PRINTED) {
        rows.row([
            candidate.title.clone(),
            format!(
                "{} {}",
                significant(candidate.value_alone, 3),
                candidate.unit
            ),
            format!("{:.0}", 100.0 * candidate.closes),
        ]);
    }
    text.push_str(&rows.text());
    let _ = writeln!(
        text,
        "\nWhat one linear law adds once the beam factors are fitted to the bench; F needs {:.1} to pass the search of {} laws\n",
        found.f_limit,
        found.candidates.len()
    );
    text.push_str(&fitted_table(found));
    text.push_str(&conclusions(found));
    text
}

fn fitted_table(found: &TwelveValues) -> String {
    let mut rows = AlignedTable::new(&[
        "law",
        "value",
        "rms of 12, %",
        "F",
        "p of the search",
        "worst, pose left out, %",
        "worst, P2 and P4, %",
        "behind the best",
    ]);
    let listed = std::iter::once(&found.baseline).chain(found.candidates.iter().take(PRINTED));
    for candidate in listed {
        rows.row([
            candidate.title.clone(),
            format!("{} {}", significant(candidate.value, 3), candidate.unit),
            format!("{:.1}", candidate.rms_percent),
            format!("{:.2}", candidate.f),
            format!("{:.3}", candidate.p_family),
            format!("{:.1}", candidate.worst_left_out_percent),
            format!("{:.1}", candidate.worst_held_out_percent),
            format!("{:.2}", candidate.behind),
        ]);
    }
    rows.text()
}

fn conclusions(found: &TwelveValues) -> String {
    let mut text = String::new();
    let best = found.candidates.first();
    let least = found.candidates.iter().min_by(|a, b| {
        a.worst_held_out_percent
            .total_cmp(&b.worst_held_out_percent)
    });
    let _ = writeln!(
        text,
        "\nLaw that the search names: {}. Best fit: {}. Laws that twelve values do not distinguish from the best, itself counted: {}.",
        found.named.as_deref().unwrap_or("none"),
        best.map_or("none", |candidate| candidate.title.as_str()),
        found.not_distinguishable
    );
    if let Some(least) = least {
        let _ = writeln!(
            text,
            "Worst error on P2 and P4 with P1 and P3 fitted: {:.1} % with beam factors alone, at best {:.1} % with one law ({}); the paper prints {:.1} % for its own model.",
            found.baseline.worst_held_out_percent,
            least.worst_held_out_percent,
            least.title,
            found.paper_worst_percent
        );
    }
    text.push_str(
        "All these laws are linear in the load: readings at higher loads do not distinguish them, other poses and other gauges do. A second gauge at the base, at the\nstand and across a joint decides between base, stand and joint at once. With the end's gauge alone, one more cell decides most for each pair:\n\n",
    );
    let mut rows = AlignedTable::new(&[
        "best against",
        "pose",
        "direction",
        "predictions differ, %",
        "what the fit leaves, %",
        "decides",
    ]);
    for cell in &found.further {
        rows.row([
            cell.rival.clone(),
            pose_words(cell),
            cell.direction.to_string(),
            format!("{:.0}", cell.difference_percent),
            format!("{:.1}", cell.rms_percent),
            if cell.difference_percent > 2.0 * cell.rms_percent {
                "yes"
            } else {
                "no: only a gauge at the place itself"
            }
            .to_owned(),
        ]);
    }
    text.push_str(&rows.text());
    text.push('\n');
    text
}

fn pose_words(cell: &FurtherCell) -> String {
    let angles = cell
        .pose_deg
        .iter()
        .map(|(name, angle)| format!("{name}={angle:.1}"));
    angles.collect::<Vec<_>>().join(" ")
}
