//! A prism as quadratic hexahedra.
//!
//! Twenty-node elements: one through a thin side bends as it should, and with reduced integration (`C3D20R`) neither shear nor
//! volume locks. The grid is structured and every element a cuboid, so that area and second moments of the mesh are those of the prism.

use super::prism::Prism;

/// Nodes of a twenty-node element on the grid of half elements along local x, y, z, in CalculiX's order.
const TWENTY: [[usize; 3]; 20] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2],
    [1, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 1, 0],
    [1, 0, 2],
    [2, 1, 2],
    [1, 2, 2],
    [0, 1, 2],
    [0, 0, 1],
    [2, 0, 1],
    [2, 2, 1],
    [0, 2, 1],
];

/// Fewest elements along a solid side and along the member: with two the warping of twist has a middle and both bendings a symmetric mesh.
const FEWEST: usize = 2;

/// Nodes and elements of one member in its local axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mesh {
    /// Local coordinates, m; x from the first end.
    pub(super) nodes_m: Vec<[f64; 3]>,
    /// Indices of the nodes of each element.
    pub(super) elements: Vec<[usize; 20]>,
    /// Nodes of the first and of the last face.
    pub(super) faces: [Vec<usize>; 2],
}

/// Meshes a prism with elements no longer than `size_m` on any side.
pub(super) fn mesh(prism: &Prism, length_m: f64, size_m: f64) -> Mesh {
    let lines = [
        even(0.0, length_m, size_m, FEWEST),
        across(prism.side_y_m, prism.wall_m, size_m),
        across(prism.side_z_m, prism.wall_m, size_m),
    ];
    let counts = [0, 1, 2].map(|i| lines[i].len() - 1);
    let in_hole = |axis: usize, cell: usize| {
        prism.wall_m.is_some_and(|wall| {
            let inner = (lines[axis][0] + wall)..(lines[axis][counts[axis]] - wall);
            inner.contains(&(0.5 * (lines[axis][cell] + lines[axis][cell + 1])))
        })
    };
    let size = counts.map(|count| 2 * count + 1);
    let mut numbers = vec![usize::MAX; size.iter().product()];
    let mut mesh = Mesh {
        nodes_m: Vec::new(),
        elements: Vec::new(),
        faces: [Vec::new(), Vec::new()],
    };
    for x in 0..counts[0] {
        for y in 0..counts[1] {
            for z in (0..counts[2]).filter(|&z| !(in_hole(1, y) && in_hole(2, z))) {
                let cell = [x, y, z];
                let element = TWENTY.map(|offset| {
                    let at = [0, 1, 2].map(|i| 2 * cell[i] + offset[i]);
                    let number = &mut numbers[(at[0] * size[1] + at[1]) * size[2] + at[2]];
                    if *number == usize::MAX {
                        *number = mesh.nodes_m.len();
                        mesh.nodes_m.push([0, 1, 2].map(|i| half(&lines[i], at[i])));
                        if at[0] == 0 {
                            mesh.faces[0].push(*number);
                        } else if at[0] == 2 * counts[0] {
                            mesh.faces[1].push(*number);
                        }
                    }
                    *number
                });
                mesh.elements.push(element);
            }
        }
    }
    mesh
}

/// Coordinate of a place on the grid of half elements.
fn half(lines: &[f64], place: usize) -> f64 {
    0.5 * (lines[place / 2] + lines[place.div_ceil(2)])
}

/// Lines of the grid across a side, about its middle.
fn across(side: f64, wall: Option<f64>, size: f64) -> Vec<f64> {
    let edge = 0.5 * side;
    let Some(wall) = wall else {
        return even(-edge, edge, size, FEWEST);
    };
    let mut lines = even(-edge, wall - edge, size, 1);
    lines.pop();
    lines.extend(even(wall - edge, edge - wall, size, FEWEST));
    lines.pop();
    lines.extend(even(edge - wall, edge, size, 1));
    lines
}

/// So many even parts that none is longer than `size`, at least `fewest`.
fn even(from: f64, to: f64, size: f64, fewest: usize) -> Vec<f64> {
    // A hair less than a whole number of parts is that number: lengths come out of kinematics with rounding.
    let parts = (((to - from) / size - 1e-6).ceil() as usize).max(fewest);
    (0..=parts)
        .map(|part| from + (to - from) * part as f64 / parts as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume, and second moments of the first face's cells about y and z, from the corners of the elements alone.
    fn constants(mesh: &Mesh) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for element in &mesh.elements {
            let (low, high) = (mesh.nodes_m[element[0]], mesh.nodes_m[element[6]]);
            let side = [0, 1, 2].map(|i| high[i] - low[i]);
            assert!(side.iter().all(|side| *side > 0.0));
            sums[0] += side.iter().product::<f64>();
            if low[0] == 0.0 {
                let strip = |i: usize| (high[i].powi(3) - low[i].powi(3)) / 3.0;
                sums[1] += side[1] * strip(2);
                sums[2] += side[2] * strip(1);
            }
        }
        sums
    }

    fn holds(prism: &Prism, length_m: f64, size_m: f64) -> Mesh {
        let mesh = mesh(prism, length_m, size_m);
        let section = prism.section();
        let expected = [section.area_m2 * length_m, section.iy_m4, section.iz_m4];
        for (found, expected) in constants(&mesh).into_iter().zip(expected) {
            let expected = expected / prism.modulus_scale;
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        for (face, x) in mesh.faces.iter().zip([0.0, length_m]) {
            assert!(
                face.iter()
                    .all(|&node| (mesh.nodes_m[node][0] - x).abs() < 1e-15)
            );
        }
        mesh
    }

    #[test]
    fn a_solid_prism_has_its_volume_and_second_moments() {
        let prism = Prism {
            side_y_m: 0.02,
            side_z_m: 0.06,
            wall_m: None,
            modulus_scale: 1.7,
        };
        let mesh = holds(&prism, 0.2, 0.02);
        assert_eq!(mesh.elements.len(), 10 * 2 * 3);
        // Corners and edges of a grid of 10 × 2 × 3: 11·3·4 + 10·3·4 + 11·2·4 + 11·3·3.
        assert_eq!(mesh.nodes_m.len(), 132 + 120 + 88 + 99);
        // A face of 2 × 3 eight-node sides.
        assert_eq!(mesh.faces[0].len(), 12 + 2 * 4 + 3 * 3);
    }

    #[test]
    fn a_tube_leaves_its_inside_free() {
        let prism = Prism {
            side_y_m: 0.06,
            side_z_m: 0.04,
            wall_m: Some(0.004),
            modulus_scale: 1.0,
        };
        let mesh = holds(&prism, 0.1, 0.01);
        // Across: 1 + 6 + 1 lines of cells along y, 1 + 4 + 1 along z.
        assert_eq!(mesh.elements.len(), 10 * (8 * 6 - 6 * 4));
        let inside = |p: &[f64; 3]| p[1].abs() < 0.02599 && p[2].abs() < 0.01599;
        assert!(!mesh.nodes_m.iter().any(inside));
    }

    #[test]
    fn every_node_stands_once() {
        let prism = Prism {
            side_y_m: 0.03,
            side_z_m: 0.03,
            wall_m: Some(0.005),
            modulus_scale: 1.0,
        };
        let mesh = mesh(&prism, 0.06, 0.01);
        let mut places: Vec<[i64; 3]> = mesh
            .nodes_m
            .iter()
            .map(|p| p.map(|c| (c * 1e9).round() as i64))
            .collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), mesh.nodes_m.len());
    }
}
