//! Compliance along the base axes, for people and programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table};

use crate::analysis::{AxisValues, VectorStiffnessCell};
use crate::test_point::PoseId;

use super::hysteresis::hysteresis_document;
use super::text::with_u;

/// Name of the procedure whose table is that of ISO 9283.
const STATIC_COMPLIANCE: &str = "iso-9283-static-compliance";

/// Compliance of every pose under each load.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct VectorStiffnessReport {
    /// Poses and directions of load, in the order of measurement.
    pub cells: Vec<VectorStiffnessCell>,
    /// Static compliance after ISO 9283; only of sessions of that procedure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_compliance: Option<Vec<StaticComplianceRow>>,
}

/// Static compliance in one pose and direction of force.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct StaticComplianceRow {
    /// The pose.
    pub pose: PoseId,
    /// Name of the direction of the force.
    pub direction: String,
    /// The largest force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Displacement along the base axes at the largest force per that force, averaged over the repeats.
    pub compliance: AxisValues,
}

impl VectorStiffnessReport {
    /// The report on a session of a procedure.
    #[must_use]
    pub fn new(cells: Vec<VectorStiffnessCell>, procedure: Option<&str>) -> Self {
        let row = |cell: &VectorStiffnessCell| {
            Some(StaticComplianceRow {
                pose: cell.pose.clone(),
                direction: cell.direction.clone(),
                force_n: cell.largest_n,
                compliance: cell.at_largest.clone()?,
            })
        };
        let rows = || cells.iter().filter_map(row).collect();
        Self {
            static_compliance: (procedure == Some(STATIC_COMPLIANCE)).then(rows),
            cells,
        }
    }

    /// The tables, and what their values are.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        document.table(
            Table::of(&self.cells)
                .words("pose", |cell| &cell.pose)
                .words("load along", |cell| &cell.direction)
                .numbers("runs", |cell| cell.runs)
                .numbers_each(axes_with_u("µm/N"), |cell| of_axes(&cell.compliance))
                .numbers_each(["K along the load, N/µm", "U"], |cell| {
                    with_u(&cell.stiffness, 4)
                }),
        );
        document.paragraph(
            "Displacement along the base axes per force along the load: the slope over the loads by generalised least squares, which `fit` takes. \
             U is the expanded uncertainty for 95 % from the noise of all readings, without repeats from their scatter about the lines; \
             calibration is not included. A dash: no gauge along this axis.",
        );
        let loops = self.cells.iter().filter_map(|cell| {
            let found = cell.hysteresis.clone()?;
            Some((cell.pose.to_string(), cell.direction.clone(), found))
        });
        let loops: Vec<_> = loops.collect();
        document.section("Hysteresis", hysteresis_document(&loops));
        if let Some(rows) = &self.static_compliance {
            document.paragraph("Static compliance (ISO 9283), mm/N in the base frame");
            document.table(
                Table::of(rows)
                    .words("pose", |row| &row.pose)
                    .words("force along", |row| &row.direction)
                    .numbers("force, N", |row| format!("{:.1}", row.force_n))
                    .numbers_each(axes_with_u("mm/N"), |row| of_axes(&row.compliance)),
            );
            document.paragraph(
                "Displacement at the largest force per that force, averaged over the repeats.",
            );
        }
        document
    }
}

/// Heads of the columns of values along the base axes, each with its expanded uncertainty.
fn axes_with_u(unit: &str) -> impl Iterator<Item = String> {
    let axes = ["x", "y", "z"].into_iter();
    axes.flat_map(move |axis| [format!("{axis}, {unit}"), "U".to_owned()])
}

/// Values along the base axes, each with its expanded uncertainty.
fn of_axes(AxisValues { x, y, z }: &AxisValues) -> Vec<String> {
    let values = [x, y, z].into_iter();
    values.flat_map(|value| with_u(value, 4)).collect()
}
