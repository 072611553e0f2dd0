//! Compliance along the base axes, for people and programs.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_document::{Document, Table};

use crate::analysis::VectorStiffness;
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::reported::Reported;
use crate::statistics::Estimate;
use crate::test_point::PoseId;

use super::text::value_and_u;

/// Metres per newton in a micrometre and in a millimetre per newton.
const UM_PER_N: f64 = 1e-6;
const MM_PER_N: f64 = 1e-3;

/// Name of the procedure whose table is that of ISO 9283.
const STATIC_COMPLIANCE: &str = "iso-9283-static-compliance";

/// Compliance of every pose under each load.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct VectorStiffnessReport {
    /// Poses and directions of load, in the order of measurement.
    pub cells: Vec<VectorStiffnessCell>,
    /// Static compliance after ISO 9283; only of sessions of that procedure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub static_compliance: Option<Vec<StaticComplianceRow>>,
}

/// Compliance of one pose under a load in one direction.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct VectorStiffnessCell {
    /// The pose.
    pub pose: PoseId,
    /// Name of the direction of the load.
    pub direction: String,
    /// The direction, a unit vector along the base axes.
    pub unit_vector: [f64; 3],
    /// Number of runs.
    pub runs: usize,
    /// Number of readings.
    pub readings: usize,
    /// Displacement along the base axes per force along the load, slope over the loads.
    pub compliance: AxisValues,
    /// Stiffness along the load, the inverse of the compliance along it.
    pub stiffness: Reported,
}

/// Values along the base axes.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AxisValues {
    /// Along x.
    pub x: Reported,
    /// Along y.
    pub y: Reported,
    /// Along z.
    pub z: Reported,
}

/// Static compliance in one pose and direction of force.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
        document.table(table_with_u(["pose", "load along", "runs"], &values, rows));
        document.paragraph(
            "Displacement along the base axes per force along the load: the slope over the loads by generalised least squares, which `fit` takes. \
             U is the expanded uncertainty for 95 % from the noise of all readings, without repeats from their scatter about the lines; \
             calibration is not included. A dash: no gauge along this axis.",
        );
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
    table_with_u(["pose", "force along", "force, N"], &values, rows)
}

/// A table of values, each with its expanded uncertainty.
fn table_with_u<'r>(
    names: [&str; 3],
    values: &[&str],
    rows: impl Iterator<Item = ([String; 3], Vec<&'r Reported>)>,
) -> Table {
    let heads = values.iter().flat_map(|value| [*value, "U"]);
    let heads: Vec<&str> = names.into_iter().chain(heads).collect();
    let mut table = Table::new(&heads);
    for (named, values) in rows {
        let values = values
            .into_iter()
            .flat_map(|value| value_and_u([value.value, value.expanded_uncertainty], 4, "-"));
        table.row(named.into_iter().chain(values));
    }
    table
}

fn axis_values(values: &[Option<Estimate>; 3], si_per_unit: f64, unit: &'static str) -> AxisValues {
    let [x, y, z] = values.map(|value| match value {
        Some(estimate) => Reported::from_estimate(&estimate, si_per_unit, unit),
        None => Reported::missing(unit, "not read along this axis"),
    });
    AxisValues { x, y, z }
}

impl From<&VectorStiffness> for VectorStiffnessCell {
    fn from(cell: &VectorStiffness) -> Self {
        let inverse = cell.along_m_per_n.filter(|along| along.value != 0.0);
        let inverse = inverse.map(|along| Estimate {
            value: 1.0 / along.value,
            standard_uncertainty: along.standard_uncertainty / along.value.powi(2),
            dof: along.dof,
        });
        Self {
            pose: cell.pose.clone(),
            direction: cell.direction.clone(),
            unit_vector: cell.unit,
            runs: cell.runs,
            readings: cell.readings,
            compliance: axis_values(&cell.compliance_m_per_n, UM_PER_N, "um/N"),
            stiffness: match &inverse {
                Some(inverse) => Reported::from_estimate(inverse, N_PER_UM, "N/um"),
                None => Reported::missing(
                    "N/um",
                    "the load has a component along an axis that was not read",
                ),
            },
        }
    }
}

impl From<&VectorStiffness> for StaticComplianceRow {
    fn from(cell: &VectorStiffness) -> Self {
        Self {
            pose: cell.pose.clone(),
            direction: cell.direction.clone(),
            force_n: cell.largest_n,
            compliance: axis_values(&cell.at_largest_m_per_n, MM_PER_N, "mm/N"),
        }
    }
}
