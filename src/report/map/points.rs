//! The points of a map as a table and as a mesh.

use std::fmt::Write;

use rayon::prelude::*;

use crate::distribution::{MapColumn, MatrixKind, PoseSample, StiffnessMap};
use crate::robot::{JointMotion, Robot};
use crate::structure::Compliance6;

use super::unit_of;

/// Rows that are written as one piece.
const CHUNK: usize = 4096;

/// Heads of the columns: number, angles, end, stiffnesses, weakest direction and axis, matrix.
pub(super) fn point_heads(robot: &Robot, poses: &PoseSample, map: &StiffnessMap) -> Vec<String> {
    let columns = &map.columns;
    let angles = poses.free.iter().map(|&variable| {
        let variable = &robot.variables[variable];
        let unit = match variable.motion {
            JointMotion::Turns => "deg",
            JointMotion::Slides => "m",
        };
        format!("{}_{unit}", variable.name)
    });
    let stiffness = columns.iter().map(|column| {
        // Names of directions given as numbers hold commas.
        let name = column.name().replace([',', ' '], "_");
        let unit = if column.is_rotational() {
            "Nm_per_rad"
        } else {
            "N_per_um"
        };
        format!("stiffness_{name}_{unit}")
    });
    let mut heads = vec!["id".to_owned()];
    heads.extend(angles);
    heads.extend(["x_m", "y_m", "z_m"].map(str::to_owned));
    heads.extend(stiffness);
    for (rotational, word) in [(false, "weakest"), (true, "weakest_axis")] {
        let of_kind = |column: &MapColumn| column.is_rotational() == rotational;
        if columns.iter().any(|c| c.is_principal() && of_kind(c)) {
            heads.extend(["x", "y", "z"].map(|axis| format!("{word}_{axis}")));
        }
    }
    heads.extend(map.matrix.into_iter().flat_map(matrix_heads));
    heads
}

/// Heads of the 36 entries, row by row: `K_Fx_ux_N_per_m` is the force along x per displacement along x.
fn matrix_heads(kind: MatrixKind) -> Vec<String> {
    let (loads, displacements) = (Compliance6::LOADS, Compliance6::DISPLACEMENTS);
    let entries = (0..36).map(|entry| (entry / 6, entry % 6));
    let head = |(row, column): (usize, usize)| {
        let turns = (row >= 3, column >= 3);
        match kind {
            MatrixKind::Stiffness => {
                let unit = match turns {
                    (false, false) => "N_per_m",
                    (false, true) => "N_per_rad",
                    (true, false) => "Nm_per_m",
                    (true, true) => "Nm_per_rad",
                };
                format!("K_{}_{}_{unit}", loads[row], displacements[column])
            }
            MatrixKind::Compliance => {
                let unit = match turns {
                    (false, false) => "m_per_N",
                    (false, true) => "m_per_Nm",
                    (true, false) => "rad_per_N",
                    (true, true) => "rad_per_Nm",
                };
                format!("C_{}_{}_{unit}", displacements[row], loads[column])
            }
        }
    };
    entries.map(head).collect()
}

/// The numbers of a row beside its pose's number, in the order of the heads.
pub(super) fn point_values<'a>(
    poses: &'a PoseSample,
    map: &'a StiffnessMap,
    row: usize,
) -> impl Iterator<Item = f64> + 'a {
    let place = map.places[row] as usize;
    let values = map.row(row).iter().enumerate();
    let angles = poses.free_angles_deg(place).iter().copied();
    angles.chain(values.map(move |(i, value)| {
        let column = i.checked_sub(3).and_then(|i| map.columns.get(i));
        column.map_or(*value, |column| value / unit_of(column).1)
    }))
}

/// The map as CSV: every digit that tells one number from its neighbours, the same bytes on every machine; a cell is empty where nothing
/// yields.
#[must_use]
pub fn points_csv(robot: &Robot, poses: &PoseSample, map: &StiffnessMap) -> String {
    let rows: Vec<usize> = (0..map.len()).collect();
    let pieces: Vec<String> = rows
        .par_chunks(CHUNK)
        .map(|rows| {
            let mut text = String::with_capacity(rows.len() * 200);
            for &row in rows {
                let _ = write!(text, "{}", poses.ids[map.places[row] as usize]);
                for value in point_values(poses, map, row) {
                    text.push(',');
                    // Where nothing yields there is no number.
                    if value.is_finite() {
                        let _ = write!(text, "{value}");
                    }
                }
                text.push('\n');
            }
            text
        })
        .collect();
    format!(
        "{}\n{}",
        point_heads(robot, poses, map).join(","),
        pieces.concat()
    )
}
