//! What the tests of structures build with.

pub(crate) mod arms;
pub(crate) mod level_arm;
pub(crate) mod robots;
pub(crate) mod rows;

use stiffbench_beams::structure::{
    Attachment, Compliance6, Element, Hinge, Material, Node, Section, Solver, Structure, Support,
};

/// Steel, Pa.
pub(crate) const STEEL: Material = Material {
    youngs_modulus_pa: 210e9,
    shear_modulus_pa: 81e9,
};

/// A hollow section that is different about every axis.
pub(crate) const SECTION: Section = Section {
    area_m2: 1.9e-3,
    iy_m4: 3.1e-6,
    iz_m4: 1.2e-6,
    j_m4: 2.2e-6,
};

pub(crate) fn node(name: &str, position_m: [f64; 3]) -> Node {
    Node {
        name: name.into(),
        position_m,
    }
}

/// An Euler-Bernoulli beam of steel.
pub(crate) fn beam(nodes: [usize; 2], toward_y: [f64; 3], section: Section) -> Element {
    Element {
        ends: nodes.map(Attachment::from),
        toward_y,
        section,
        material: STEEL,
        shear: None,
    }
}

pub(crate) fn hinge(name: &str, axis: [f64; 3], stiffness_nm_per_rad: f64) -> Hinge {
    Hinge {
        slides: false,
        name: name.into(),
        axis,
        stiffness_nm_per_rad,
    }
}

/// A support that holds some freedoms of a node: displacements first.
pub(crate) fn held(node: usize, held: [bool; 6]) -> Support {
    Support { node, held }
}

/// The side of a node behind a hinge.
pub(crate) fn behind(node: usize, hinge: usize) -> Attachment {
    Attachment {
        node,
        hinges: vec![hinge],
    }
}

/// Beams of one section from node to node, clamped at the first, with the end at the last.
pub(crate) fn chain(positions_m: &[[f64; 3]], toward_y: [f64; 3]) -> Structure {
    let last = positions_m.len() - 1;
    let nodes = positions_m.iter().enumerate();
    Structure {
        nodes: nodes.map(|(i, at)| node(&format!("N{i}"), *at)).collect(),
        elements: (0..last)
            .map(|i| beam([i, i + 1], toward_y, SECTION))
            .collect(),
        supports: vec![Support::clamped(0)],
        end: last.into(),
        ..Structure::default()
    }
}

/// The solver of a structure, factorised.
pub(crate) fn solver(structure: &Structure) -> Solver {
    let mut solver = Solver::new(structure).expect("indices of the test are right");
    solver
        .update(structure)
        .expect("the structure of the test is sound");
    solver
}

pub(crate) fn compliance(structure: &Structure) -> Compliance6 {
    solver(structure).end_compliance()
}

/// A text in which « marks a place: without the mark, and line and column of the place.
pub(crate) fn marked(text: &str) -> (String, (usize, usize)) {
    let (before, behind) = text.split_once('«').expect("the text has a mark");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap().chars().count() + 1;
    (format!("{before}{behind}"), (line, column))
}

/// a · b for 3 × 3 matrices.
pub(crate) fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

pub(crate) fn transposed(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// The compliance in axes turned by `r`, which takes old components to new ones: each 3 × 3 block becomes R C Rᵀ.
pub(crate) fn turned(compliance: &Compliance6, r: [[f64; 3]; 3]) -> Compliance6 {
    let mut result = [[0.0; 6]; 6];
    for (bi, bj) in [(0, 0), (0, 3), (3, 0), (3, 3)] {
        let block = std::array::from_fn(|i| std::array::from_fn(|j| compliance.0[bi + i][bj + j]));
        let block = product(product(r, block), transposed(r));
        for i in 0..3 {
            for j in 0..3 {
                result[bi + i][bj + j] = block[i][j];
            }
        }
    }
    Compliance6(result)
}
