//! What the tests of structures build with.

pub(crate) mod arms;
pub(crate) mod level_arm;

use stiffbench_beams::structure::{
    Attachment, Compliance6, Element, Hinge, Material, Node, Section, Solver, Structure,
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
