//! The paper's Tables VII to X beside maps of its mechanisms.

use std::borrow::Cow;

use indexmap::{IndexMap, IndexSet};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, Table};

use crate::distribution::{ColumnStatistics, MechanismStudy};
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::report::paper::{Printed, direction, printed_rows};
use crate::report::text::{digits, or_dash};

/// Tables of the stiffness distribution, with their titles and what stands beside one another in each.
const TITLES: [(&str, &str); 4] = [
    ("VII", "Stiffness distribution along x (lateral)"),
    ("VIII", "Stiffness distribution along y (vertical)"),
    ("IX", "Stiffness distribution along z (radial)"),
    ("X", "Mean stiffness, and its share of that along x"),
];

/// Cells whose ratio lies within this factor of one are called reproduced: the reconstruction's section constants were themselves found by a
/// compromise between all tables, with a scatter of 12 to 15 % and worst cells near 30 % (`data/robots/README.md`).
const REPRODUCED_WITHIN: f64 = 1.30;

/// A printed cell beside ours.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PaperCellSummary")]
pub struct PaperCell {
    /// Roman number of the table.
    pub table: Cow<'static, str>,
    /// Row: model or chain.
    pub row: String,
    /// Column.
    pub place: String,
    /// What it is, with its unit.
    pub quantity: String,
    /// What the paper prints.
    pub paper: f64,
    /// Ours; `null` if there is none.
    pub ours: Option<f64>,
    /// Ours over the paper's.
    pub ratio: Option<f64>,
    /// Whether it is reproduced.
    pub reproduced: bool,
    /// Why there is none of ours, or a remark.
    pub reason: Option<Cow<'static, str>>,
}

impl PaperCell {
    /// # Arguments
    /// - `ours`: worked out by this program, if it was studied.
    /// - `remark`: why ours differs beyond the reconstruction's scatter; asked where it does.
    fn new(row: &Printed, ours: Option<f64>, remark: impl FnOnce() -> &'static str) -> Self {
        let ratio = ours.map(|ours| ours / row.value);
        let within = 1.0 / REPRODUCED_WITHIN..=REPRODUCED_WITHIN;
        let reproduced = ratio.is_some_and(|ratio| within.contains(&ratio));
        let reason = match ours {
            None => Some("this mechanism or direction was not studied"),
            Some(_) => (!reproduced).then(remark),
        };
        Self {
            table: row.table.clone().into(),
            row: row.mechanism_or_model.clone(),
            place: row.physical_direction.clone(),
            quantity: format!("{}, {}", row.quantity, row.unit),
            paper: row.value,
            ours,
            ratio,
            reproduced,
            reason: reason.map(Into::into),
        }
    }
}

/// The printed cells of Tables VII to X with ours, for the mechanisms that were studied; extremes are those of the sample, as the
/// paper's are.
pub(super) fn cells(mechanisms: &[(Vec<String>, MechanismStudy)]) -> Vec<PaperCell> {
    let rows = printed_rows();
    rows.iter()
        .filter_map(|row| cell(row, mechanisms))
        .collect()
}

fn cell(row: &Printed, mechanisms: &[(Vec<String>, MechanismStudy)]) -> Option<PaperCell> {
    TITLES.into_iter().find(|(table, _)| *table == row.table)?;
    let axis = direction(&row.physical_direction)?.index();
    let names = row.mechanism_or_model.strip_prefix("mechanism ")?;
    let of = |name: &str, axis: usize, quantity: &str| -> Option<f64> {
        let mut studies = mechanisms.iter().map(|(_, study)| study);
        let study = studies.find(|study| study.map.mechanism == name)?;
        value(&study.axis(axis)?.statistics, quantity)
    };
    // "minimum stiffness", "minimum stiffness, ratio", "mean stiffness relative to x".
    let quantity = row.quantity.split(" stiffness").next()?;
    let quantity = if row.quantity.starts_with("stiffness difference") {
        "difference"
    } else {
        quantity
    };
    let ours = match names.split_once('/') {
        Some((name, base)) => of(name, axis, quantity)
            .zip(of(base, axis, quantity))
            .map(|(ours, base)| 100.0 * ours / base),
        None if row.quantity.ends_with("relative to x") => of(names, axis, quantity)
            .zip(of(names, 0, quantity))
            .map(|(ours, x)| 100.0 * ours / x),
        None => of(names, axis, quantity).map(|ours| ours / N_PER_UM),
    };
    let remark = || remark(names, axis, quantity);
    Some(PaperCell::new(row, ours, remark))
}

/// Why a cell of ours lies further from the print than the reconstruction's scatter (`data/robots/README.md`, what cannot be reproduced).
fn remark(names: &str, axis: usize, quantity: &str) -> &'static str {
    let of_a = names == "A" || names.ends_with("/A");
    match (quantity, axis) {
        ("maximum" | "difference" | "mean", 1) if of_a => {
            "mechanism A as printed, 60-fold vertically: a serial arm cannot change so much over this workspace"
        }
        ("maximum" | "difference", 2) if of_a => {
            "mechanism A as printed, 20-fold radially: a serial arm cannot change so much over this workspace"
        }
        (_, 1 | 2) if names.starts_with('E') => {
            "the gain of E over D as printed: chains E and G only drive the waist"
        }
        ("difference" | "minimum" | "maximum", 1 | 2) => {
            "the print has a narrower spread over the workspace than the reconstruction"
        }
        _ => {
            "sections of the robot are not published; the reconstruction is a compromise between all tables"
        }
    }
}

fn value(statistics: &ColumnStatistics, quantity: &str) -> Option<f64> {
    let (least, most) = (
        statistics.smallest.stiffness_n_per_m,
        statistics.largest.stiffness_n_per_m,
    );
    match quantity {
        "minimum" => Some(least),
        "maximum" => Some(most),
        "difference" => Some(most - least),
        "mean" => Some(statistics.mean.value),
        _ => None,
    }
}

/// Adds the tables with paper, ours and ratio side by side; none without cells of ours.
pub(super) fn add_tables(document: &mut Document, cells: &[PaperCell]) {
    for (table, title) in TITLES {
        let cells: Vec<&PaperCell> = cells
            .iter()
            .filter(|cell| cell.table == table && cell.ours.is_some())
            .collect();
        if cells.is_empty() {
            continue;
        }
        document.paragraph(format!(
            "Table {table}. {title}, N/µm and %: paper, ours, ours/paper"
        ));
        document.table(side_by_side(&cells));
        add_reasons(document, &cells);
    }
}

/// One line a row of the print, three columns a quantity.
fn side_by_side(cells: &[&PaperCell]) -> Table {
    // A ratio has a row of its own in the print, under the quantity it is a ratio of.
    let head_of = |cell: &PaperCell| -> String {
        let quantity = cell.quantity.split(',').next().unwrap_or_default();
        let axis = direction(&cell.place).map_or_else(String::new, |d| d.to_string());
        if quantity.contains("relative") {
            return format!("{axis}/x");
        }
        let quantity = quantity.replace(" stiffness", "").replace("stiffness ", "");
        if cell.table == "X" {
            format!("{quantity} {axis}")
        } else {
            quantity
        }
    };
    let heads: IndexSet<String> = cells.iter().map(|cell| head_of(cell)).collect();
    let names: IndexSet<&str> = cells.iter().map(|cell| cell.row.as_str()).collect();
    let mut table = Table::of(names).words("row", |name| *name);
    for head in &heads {
        table = table.numbers_each([head, "ours", "ratio"], |name| {
            let mut cells = cells.iter();
            let cell = cells.find(|cell| cell.row == *name && head_of(cell) == *head);
            let ratio = cell.and_then(|cell| cell.ratio);
            [
                or_dash(cell, |cell| cell.paper.to_string()),
                digits(cell.and_then(|cell| cell.ours), 4),
                or_dash(ratio, |ratio| format!("{ratio:.2}")),
            ]
        });
    }
    table.into()
}

/// Cells that cannot be had or differ, grouped by reason.
fn add_reasons(document: &mut Document, cells: &[&PaperCell]) {
    let mut groups: IndexMap<&str, IndexSet<String>> = IndexMap::new();
    for cell in cells {
        if let Some(reason) = &cell.reason {
            let name = format!("{} {}", cell.row, cell.place);
            let names = groups.entry(reason).or_default();
            names.insert(name.trim().to_owned());
        }
    }
    if !groups.is_empty() {
        document.paragraph("Not reproduced, and why:");
    }
    for (reason, names) in groups {
        let names: Vec<String> = names.into_iter().collect();
        document.item(format!("{reason}: {}", names.join("; ")));
    }
}
