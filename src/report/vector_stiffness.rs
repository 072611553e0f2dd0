//! Compliance along the base axes, for people and programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table, TableColumn, numbers, words};

use crate::analysis::{AxisValues, VectorStiffness, VectorStiffnessCell};
use crate::reported::Reported;
use crate::test_point::PoseId;

use super::hysteresis::hysteresis_document;
use super::text::value_and_u;

/// Metres per newton in a millimetre per newton.
const MM_PER_N: f64 = 1e-3;

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
    pub fn new(cells: &[VectorStiffness], procedure: Option<&str>) -> Self {
        let rows = || cells.iter().map(StaticComplianceRow::from).collect();
        Self {
            cells: cells.iter().map(Into::into).collect(),
            static_compliance: (procedure == Some(STATIC_COMPLIANCE)).then(rows),
        }
    }

    /// The tables, and what their values are.
    #[must_use]
    pub fn document(&self) -> Document {
        let rows = self.cells.iter().map(|cell| {
            let AxisValues { x, y, z } = &cell.compliance;
            let named = [
                cell.pose.to_string(),
                cell.direction.clone(),
                cell.runs.to_string(),
            ];
            (named, vec![x, y, z, &cell.stiffness])
        });
        let values = ["x, µm/N", "y, µm/N", "z, µm/N", "K along the load, N/µm"];
        let mut document = Document::new();
        document.table(table_with_u(
            [words("pose"), words("load along"), numbers("runs")],
            &values,
            rows,
        ));
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
            document.table(static_compliance(rows));
            document.paragraph(
                "Displacement at the largest force per that force, averaged over the repeats.",
            );
        }
        document
    }
}

/// The table of ISO 9283.
fn static_compliance(rows: &[StaticComplianceRow]) -> Table {
    let rows = rows.iter().map(|row| {
        let AxisValues { x, y, z } = &row.compliance;
        let force = format!("{:.1}", row.force_n);
        let named = [row.pose.to_string(), row.direction.clone(), force];
        (named, vec![x, y, z])
    });
    let values = ["x, mm/N", "y, mm/N", "z, mm/N"];
    table_with_u(
        [words("pose"), words("force along"), numbers("force, N")],
        &values,
        rows,
    )
}

/// A table of values, each with its expanded uncertainty.
fn table_with_u<'r>(
    names: [TableColumn; 3],
    values: &[&str],
    rows: impl Iterator<Item = ([String; 3], Vec<&'r Reported>)>,
) -> Table {
    let columns = values.iter().flat_map(|value| [*value, "U"].map(numbers));
    let mut table = Table::new(names.into_iter().chain(columns));
    for (named, values) in rows {
        let values = values
            .into_iter()
            .flat_map(|value| value_and_u([value.value, value.expanded_uncertainty], 4, "-"));
        table.row(named.into_iter().chain(values));
    }
    table
}

impl From<&VectorStiffness> for StaticComplianceRow {
    fn from(cell: &VectorStiffness) -> Self {
        Self {
            pose: cell.pose.clone(),
            direction: cell.direction.clone(),
            force_n: cell.largest_n,
            compliance: AxisValues::new(&cell.at_largest_m_per_n, MM_PER_N, "mm/N"),
        }
    }
}
