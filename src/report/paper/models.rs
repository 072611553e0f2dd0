//! The rules by which each printed cell is computed again: which factors, which load, which quantity.

use crate::fit::{CellModel, FitError, Scope, significance};
use crate::robot::{ChainMobility, Mechanism, Robot, chain_mobility};
use crate::structure::Property;
use crate::test_point::{Cell, Direction, PoseId};

use super::{PaperCell, Printed, direction};

/// Load at which the paper's displacements are given where a table has one load, N.
const LOAD_N: f64 = 50.0;

/// Everything of ours that the tables ask for.
pub(super) struct PaperModels {
    chains: Vec<ChainMobility>,
    /// Displacement per newton at P1 with unit factors, and with one constant a hundredfold: by constant, by direction, m/N.
    unit_m_per_n: [f64; 3],
    remaining: [[f64; 3]; 4],
    /// Stiffness by direction at P1 with the single-pose factors, N/m.
    single_pose_n_per_m: [f64; 3],
    /// Stiffness by pose and direction with the combined single-source and multi-source factors, N/m.
    single_source: Vec<(Cell, f64)>,
    multi_source: Vec<(Cell, f64)>,
}

impl PaperModels {
    pub(super) fn new(robot: &Robot, mechanism: &Mechanism) -> Result<Self, FitError> {
        let p1 = PoseId::new("P1");
        let unit = significance(
            robot,
            mechanism,
            &p1,
            &robot.factor_set("unit")?,
            Scope::All,
            None,
            &[],
        )?;
        let cells = |poses: &[&str]| -> Vec<Cell> {
            let of_pose = |pose: &&str| {
                Direction::ALL.map(|direction| Cell::new(PoseId::new(pose), direction))
            };
            poses.iter().flat_map(of_pose).collect()
        };
        let stiffness = |poses: &[&str], set: &str| -> Result<Vec<(Cell, f64)>, FitError> {
            let cells = cells(poses);
            let values = CellModel::new(robot, mechanism, &[], &cells)?
                .stiffness(&robot.factor_set(set)?)?;
            Ok(cells.into_iter().zip(values).collect())
        };
        let single_pose = stiffness(&["P1"], "s_fsd_p1")?;
        let poses = ["P1", "P2", "P3", "P4"];
        Ok(Self {
            chains: chain_mobility(robot, robot.pose(&p1)?)?,
            unit_m_per_n: unit.compliance_m_per_n,
            remaining: unit.remaining,
            single_pose_n_per_m: [0, 1, 2].map(|i| single_pose[i].1),
            single_source: stiffness(&poses, "s_fsd")?,
            multi_source: stiffness(&poses, "m_fsd")?,
        })
    }

    /// The cell of a printed row of Tables I and III to VI.
    pub(super) fn cell(&self, row: &Printed, all: &[Printed]) -> Option<PaperCell> {
        let table = ["I", "III", "IV", "V", "VI"]
            .into_iter()
            .find(|table| *table == row.table)?;
        let ours = match table {
            "I" => self.mobility(row),
            "III" => self.significance(row),
            "IV" => self.single_pose(row, all),
            "V" => of_model(
                row,
                all,
                "S-FSD",
                &self.single_source,
                "the finite-element model behind this row is not published",
            ),
            _ => of_model(
                row,
                all,
                "M-FSD",
                &self.multi_source,
                "a measurement; it is an input here",
            ),
        };
        let place = [row.physical_direction.as_str(), row.pose.as_str()]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        let differs = |reproduced: bool| !reproduced || is_impossible(row);
        Some(PaperCell::new((table, place), row, ours, |reproduced| {
            differs(reproduced).then(|| remark(row))
        }))
    }

    fn mobility(&self, row: &Printed) -> Result<f64, &'static str> {
        let name = row.mechanism_or_model.trim_start_matches("chain ");
        let chain = self
            .chains
            .iter()
            .find(|chain| chain.chain == name)
            .ok_or("the robot file has no such chain")?;
        let count = match row.quantity.as_str() {
            "n_components" => chain.components as i64,
            "g_joints" => chain.joints as i64,
            "mu_overconstraints" => chain.overconstraints,
            "nu_redundant_constraints" => chain.redundant_constraints as i64,
            "lambda_general_constraints" => chain.general_constraints as i64,
            "F_dof" => chain.freedoms,
            _ => return Err("not a quantity of Table I"),
        };
        Ok(count as f64)
    }

    /// Rows are `a=[aA,aIy,aIz,aJ]=[…]` with displacements, and `only a_X=100` with percentages.
    fn significance(&self, row: &Printed) -> Result<f64, &'static str> {
        let i = direction(&row.physical_direction)
            .ok_or("no direction")?
            .index();
        let changed = if let Some(name) = row.mechanism_or_model.strip_prefix("only a_") {
            let name = name.split('=').next().unwrap_or(name);
            Property::ALL
                .into_iter()
                .find(|property| property.name() == name)
        } else {
            let values = row
                .mechanism_or_model
                .rsplit('[')
                .next()
                .unwrap_or("")
                .trim_end_matches(']');
            values
                .split(',')
                .position(|value| value.trim() == "100")
                .map(|place| Property::ALL[place])
        };
        let left = changed.map_or(1.0, |property| self.remaining[property.index()][i]);
        Ok(match row.unit.as_str() {
            "%" => 100.0 * left,
            _ => -LOAD_N * 1e6 * self.unit_m_per_n[i] * left,
        })
    }

    fn single_pose(&self, row: &Printed, all: &[Printed]) -> Result<f64, &'static str> {
        if row.quantity.contains("time") {
            return Err("a time on the authors' computer");
        }
        let i = direction(&row.physical_direction)
            .ok_or("no direction")?
            .index();
        let load = row
            .quantity
            .split(" at ")
            .nth(1)
            .and_then(|text| text.split(' ').next())
            .and_then(|text| text.parse::<f64>().ok());
        let ours_um = load.ok_or("no load")? * 1e6 / self.single_pose_n_per_m[i];
        match row.mechanism_or_model.as_str() {
            "S-FSD (single pose)" => Ok(ours_um),
            "S-FSD/non-FSD" => {
                let reference = all.iter().find(|other| {
                    other.table == "IV"
                        && other.mechanism_or_model == "non-FSD"
                        && other.physical_direction == row.physical_direction
                        && row.quantity.starts_with(&other.quantity)
                });
                reference
                    .map(|other| 100.0 * ours_um / other.value)
                    .ok_or("no printed reference")
            }
            _ => Err("the finite-element model behind this row is not published"),
        }
    }
}

/// Tables V and VI: the fitted model's row, its ratio to the printed reference row, and the reference row itself.
fn of_model(
    row: &Printed,
    all: &[Printed],
    model: &str,
    ours: &[(Cell, f64)],
    reason: &'static str,
) -> Result<f64, &'static str> {
    let direction = direction(&row.physical_direction).ok_or("no direction")?;
    let cell = Cell::new(PoseId::new(&row.pose), direction);
    let stiffness = ours
        .iter()
        .find(|(known, _)| *known == cell)
        .map(|(_, k)| *k)
        .ok_or("no such pose")?;
    let quantity = |row: &Printed| {
        if row.quantity.starts_with("stiffness") {
            stiffness * 1e-6
        } else {
            -LOAD_N * 1e6 / stiffness
        }
    };
    if row.mechanism_or_model == model {
        return Ok(quantity(row));
    }
    let Some(reference_name) = row
        .mechanism_or_model
        .strip_prefix(model)
        .and_then(|rest| rest.strip_prefix('/'))
    else {
        return Err(reason);
    };
    let reference = all.iter().find(|other| {
        other.table == row.table
            && other.mechanism_or_model == reference_name
            && other.pose == row.pose
            && other.physical_direction == row.physical_direction
            && row.quantity.starts_with(&other.quantity)
    });
    reference
        .map(|other| 100.0 * quantity(other) / other.value)
        .ok_or("no printed reference")
}

/// Whether a printed percentage of Table III states that stiffening a part raises the displacement under the load.
fn is_impossible(row: &Printed) -> bool {
    row.table == "III" && row.unit == "%" && row.value > 100.0
}

/// Why a cell of ours lies further from the print than the reconstruction's scatter.
fn remark(row: &Printed) -> &'static str {
    match (row.table.as_str(), row.physical_direction.as_str()) {
        ("III", _) if is_impossible(row) => {
            "impossible as printed: stiffening a part cannot raise the displacement under the load"
        }
        ("III", "radial") => {
            "the print gives 88 % of the radial displacement to the area; in the reconstruction it is mostly bending"
        }
        ("III", "lateral") => {
            "the print gives torsion 3 % and bending in the plane none of the lateral displacement; sections unknown"
        }
        ("III", _) => {
            "sections of the robot are not published; Tables III and IV also exclude each other"
        }
        ("VI", _) => {
            "the experiment lies beyond what factors common to all poses can follow in this reconstruction"
        }
        _ => {
            "sections of the robot are not published; the reconstruction is a compromise between all tables"
        }
    }
}
