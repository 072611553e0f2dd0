//! The poses of a set joined to triangles.
//!
//! Where two variables vary, poses are neighbours if they are neighbours in the angles. There the limits leave a convex piece, so a
//! Delaunay triangulation covers it and nothing else; carried to the place of the end it is the workspace, hollows of its edge included.

use delaunator::{Point, triangulate};

use super::StiffnessMap;
use crate::distribution::pose_set::PoseSet;

/// Triangles over the poses of a set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Surface {
    /// Places in the set of the corners.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Joins the poses; `None` unless two variables vary and there are three poses that do not lie in a line.
    #[must_use]
    pub fn over(poses: &PoseSet) -> Option<Self> {
        if poses.free.len() != 2 {
            return None;
        }
        let points: Vec<Point> = (0..poses.len())
            .map(|place| match *poses.free_angles_deg(place) {
                [x, y] => Point { x, y },
                _ => unreachable!("two variables vary"),
            })
            .collect();
        let found = triangulate(&points);
        let corners = found.triangles.chunks_exact(3);
        let triangles: Vec<[u32; 3]> = corners
            .map(|corners| [0, 1, 2].map(|i| corners[i] as u32))
            .collect();
        (!triangles.is_empty()).then_some(Self { triangles })
    }

    /// The triangles of which all corners have a row in a map, as rows.
    #[must_use]
    pub fn rows_of(&self, map: &StiffnessMap, poses: &PoseSet) -> Vec<[u32; 3]> {
        if map.failed.is_empty() && map.len() == poses.len() {
            return self.triangles.clone();
        }
        let mut row_of = vec![None; poses.len()];
        for (row, &place) in map.places.iter().enumerate() {
            row_of[place as usize] = Some(row as u32);
        }
        let rows = self.triangles.iter().filter_map(|corners| {
            let [a, b, c] = corners.map(|corner| row_of[corner as usize]);
            Some([a?, b?, c?])
        });
        rows.collect()
    }
}
