//! The poses of a set joined to triangles.
//!
//! Where two variables vary, poses are neighbours if they are neighbours in the angles. There the limits leave a convex piece, so a
//! Delaunay triangulation covers it and nothing else; carried to the place of the end it is the workspace, hollows of its edge included.

use delaunator::{Point, triangulate};

use super::stiffness_map::StiffnessMap;
use crate::distribution::pose_set::PoseSample;

/// Longest edge of a triangle, in mean distances between poses. Longer are slivers along the limits only: straight in the angles, they
/// would cut across the bends of the edge of the workspace.
const LONGEST: f64 = 5.0;

/// Triangles over the poses of a set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Surface {
    /// Places in the set of the corners.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Joins the poses; `None` unless two variables vary and there are three poses that do not lie in a line.
    #[must_use]
    pub fn over(poses: &PoseSample) -> Option<Self> {
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
        let (corners, _) = found.triangles.as_chunks::<3>();
        let seen = |corners: &[usize; 3]| corners.map(|corner| &points[corner]);
        let twice: f64 = corners.iter().map(|c| twice_area(seen(c)).abs()).sum();
        let longest = LONGEST * LONGEST * 0.5 * twice / points.len() as f64;
        let triangles: Vec<[u32; 3]> = corners
            .iter()
            .filter(|corners| longest_edge_squared(seen(corners)) <= longest)
            .map(|corners| corners.map(|corner| corner as u32))
            .collect();
        (!triangles.is_empty()).then_some(Self { triangles })
    }

    /// The triangles of which all corners have a row in a map, as rows.
    #[must_use]
    pub fn rows_of(&self, map: &StiffnessMap, poses: &PoseSample) -> Vec<[u32; 3]> {
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

/// Twice the signed area of a triangle.
fn twice_area([a, b, c]: [&Point; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)
}

fn longest_edge_squared([a, b, c]: [&Point; 3]) -> f64 {
    let squared = |p: &Point, q: &Point| (p.x - q.x).powi(2) + (p.y - q.y).powi(2);
    squared(a, b).max(squared(b, c)).max(squared(c, a))
}
