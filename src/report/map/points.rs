//! The points of a map as a table and as a mesh.

use std::fmt::Write;

use rayon::prelude::*;

use crate::distribution::{MapColumn, MechanismStudy, PoseSample, StiffnessMap};
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::robot::Robot;

use super::vtu::{MeshField, vtu};

/// Rows that are written as one piece.
const CHUNK: usize = 4096;

/// Heads of the columns: number, angles, end, stiffnesses, weakest direction.
pub(super) fn point_heads(robot: &Robot, poses: &PoseSample, columns: &[MapColumn]) -> Vec<String> {
    let angles = poses
        .free
        .iter()
        .map(|&variable| format!("{}_deg", robot.variables[variable].name));
    let stiffness = columns.iter().map(|column| {
        // Names of directions given as numbers hold commas.
        format!("stiffness_{}_N_per_um", column.name().replace(',', "_"))
    });
    let mut heads = vec!["id".to_owned()];
    heads.extend(angles);
    heads.extend(["x_m", "y_m", "z_m"].map(str::to_owned));
    heads.extend(stiffness);
    if columns.iter().any(MapColumn::is_principal) {
        heads.extend(["weakest_x", "weakest_y", "weakest_z"].map(str::to_owned));
    }
    heads
}

/// The numbers of a row beside its pose's number, in the order of the heads.
pub(super) fn point_values<'a>(
    poses: &'a PoseSample,
    map: &'a StiffnessMap,
    row: usize,
) -> impl Iterator<Item = f64> + 'a {
    let place = map.places[row] as usize;
    let stiffnesses = 3..3 + map.columns.len();
    let values = map.row(row).iter().enumerate();
    let angles = poses.free_angles_deg(place).iter().copied();
    angles.chain(values.map(move |(i, value)| {
        if stiffnesses.contains(&i) {
            value / N_PER_UM
        } else {
            *value
        }
    }))
}

/// The map as CSV: every digit that tells one number from its neighbours, the same bytes on every machine.
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
                    let _ = write!(text, ",{value}");
                }
                text.push('\n');
            }
            text
        })
        .collect();
    format!(
        "{}\n{}",
        point_heads(robot, poses, &map.columns).join(","),
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
    let heads = point_heads(robot, poses, &map.columns);
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
    vtu(&points, study.triangles.as_deref(), &fields)
}
