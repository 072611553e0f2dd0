//! The points of a map as a table and as a mesh.

use std::fmt::Write;

use rayon::prelude::*;

use crate::distribution::{MapColumn, MatrixKind, MechanismStudy, PoseSample, StiffnessMap};
use crate::robot::{JointMotion, Robot};
use crate::structure::Compliance6;

use super::unit_of;
use super::vtu::{MeshField, vtu};

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

/// The map as a mesh: points where the end is, triangles where poses make a surface, and on them angles, stiffnesses and the weakest
/// direction.
#[must_use]
pub fn mesh_of(robot: &Robot, poses: &PoseSample, study: &MechanismStudy) -> String {
    let map = &study.map;
    let points: Vec<[f64; 3]> = (0..map.len()).map(|row| map.end_m(row)).collect();
    let mut fields: Vec<MeshField> = Vec::new();
    let heads = point_heads(robot, poses, map);
    let scalars = poses.free.len() + 3 + map.columns.len();
    for (column, name) in heads[1..=scalars].iter().enumerate() {
        let is_end = (poses.free.len()..poses.free.len() + 3).contains(&column);
        if is_end {
            continue;
        }
        fields.push(MeshField {
            name: name.clone(),
            components: 1,
            values: (0..map.len())
                .filter_map(|row| point_values(poses, map, row).nth(column))
                .collect(),
        });
    }
    let weakest: Vec<f64> = (0..map.len())
        .filter_map(|row| map.weakest_direction(row))
        .flatten()
        .collect();
    if !weakest.is_empty() {
        fields.push(MeshField {
            name: "weakest_direction".to_owned(),
            components: 3,
            values: weakest,
        });
    }
    if let Some(kind) = map.matrix {
        fields.push(MeshField {
            name: match kind {
                MatrixKind::Stiffness => "stiffness_matrix_SI",
                MatrixKind::Compliance => "compliance_matrix_SI",
            }
            .to_owned(),
            components: 36,
            values: (0..map.len())
                .filter_map(|row| map.matrix(row))
                .flatten()
                .copied()
                .collect(),
        });
    }
    vtu(&points, study.triangles.as_deref(), &fields)
}
