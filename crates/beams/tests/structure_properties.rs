//! What holds for every structure of beams, tried on random ones.

use crate::support::{beam, compliance, held, hinge, node, solver, turned};
use proptest::prelude::*;
use stiffbench_beams::structure::{
    Attachment, ComplianceGradient, Element, Property, Section, ShearCoefficients, Structure,
    Support,
};
use stiffbench_numeric::vector::{cross, norm, rotation, scale, subtract};

/// The properties hold to what rounding leaves of sixteen digits: the worst of 20 000 random structures a property, very slender members
/// beside very stout ones, kept between seven and eight.
const TOLERANCE: f64 = 1e-6;

/// Section constants spread over a factor of a hundred.
fn any_section() -> impl Strategy<Value = Section> {
    prop::array::uniform4(-1.0..1.0_f64).prop_map(|exponents| {
        let [a, y, z, j] = exponents.map(|e| 10_f64.powf(e));
        Section {
            area_m2: 1e-3 * a,
            iy_m4: 1e-6 * y,
            iz_m4: 1e-6 * z,
            j_m4: 1e-6 * j,
        }
    })
}

/// A direction in the yz plane: elements here always advance along x, so that it is never parallel to one.
fn any_hint() -> impl Strategy<Value = [f64; 3]> {
    (0.0..std::f64::consts::TAU).prop_map(|angle| [0.3, angle.cos(), angle.sin()])
}

fn any_shear() -> impl Strategy<Value = Option<ShearCoefficients>> {
    prop::option::of(
        (0.3..1.0_f64, 0.3..1.0_f64)
            .prop_map(|(along_y, along_z)| ShearCoefficients { along_y, along_z }),
    )
}

/// Everything about an element but its second node.
type Recipe = (
    prop::sample::Index,
    Section,
    [f64; 3],
    Option<ShearCoefficients>,
);

fn any_recipe() -> impl Strategy<Value = Recipe> {
    (
        any::<prop::sample::Index>(),
        any_section(),
        any_hint(),
        any_shear(),
    )
}

fn element(recipe: &Recipe, to: usize) -> Element {
    let (from, section, hint, shear) = recipe;
    Element {
        shear: *shear,
        ..beam([from.index(to), to], *hint, *section)
    }
}

/// Three to seven nodes, a tree of elements and up to three more that close loops, clamped at the first node, in half the cases
/// also held at the second; no hinges.
fn any_rigid_structure() -> impl Strategy<Value = Structure> {
    let place = prop::array::uniform3(-0.15..0.15_f64);
    (
        prop::collection::vec((place, any_recipe()), 2..7),
        prop::collection::vec((any::<prop::sample::Index>(), any_recipe()), 0..4),
        any::<bool>(),
    )
        .prop_map(|(tree, closing, second_support)| {
            let mut nodes = vec![node("root", [0.0; 3])];
            let mut elements = Vec::new();
            for (number, ([x, y, z], recipe)) in tree.iter().enumerate() {
                let advance = 0.4 * (number + 1) as f64;
                nodes.push(node("n", [advance + x, 2.0 * y, 2.0 * z]));
                elements.push(element(recipe, number + 1));
            }
            for (to, recipe) in &closing {
                elements.push(element(recipe, 1 + to.index(nodes.len() - 1)));
            }
            let mut supports = vec![Support::clamped(0)];
            if second_support {
                supports.push(held(1, [false, true, false, false, false, true]));
            }
            Structure {
                struts: Vec::new(),
                rigid_members: Vec::new(),
                end: (nodes.len() - 1).into(),
                nodes,
                elements,
                supports,
                hinges: Vec::new(),
            }
        })
}

/// The same with compliant joints at up to three element ends, one of them at the end if `behind` says so.
fn any_structure() -> impl Strategy<Value = Structure> {
    let joint = (
        any::<prop::sample::Index>(),
        any::<bool>(),
        prop::array::uniform3(0.1..1.0_f64),
        2.0..6.0_f64,
    );
    (
        any_rigid_structure(),
        prop::collection::vec(joint, 0..4),
        any::<bool>(),
    )
        .prop_map(|(mut structure, joints, behind)| {
            for (element, second, axis, exponent) in joints {
                let axis = scale(axis, 1.0 / norm(axis));
                let place = structure.hinges.len();
                structure
                    .hinges
                    .push(hinge("joint", axis, 10_f64.powf(exponent)));
                let element = element.index(structure.elements.len());
                let end = &mut structure.elements[element].ends[usize::from(second)];
                end.hinges.push(place);
                if behind && end.node == structure.end.node {
                    structure.end.hinges = end.hinges.clone();
                }
            }
            structure
        })
}

/// Whether a symmetric matrix, scaled to a unit diagonal, has a Cholesky factor.
fn is_positive_definite(c: &[[f64; 6]; 6]) -> bool {
    let mut l = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..=i {
            let scaled = c[i][j] / (c[i][i] * c[j][j]).sqrt();
            let rest = scaled - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j {
                if rest.is_nan() || rest <= 0.0 {
                    return false;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    true
}

fn constant(section: &mut Section, property: Property) -> &mut f64 {
    match property {
        Property::A => &mut section.area_m2,
        Property::Iy => &mut section.iy_m4,
        Property::Iz => &mut section.iz_m4,
        Property::J => &mut section.j_m4,
    }
}

fn gradients(structure: &Structure) -> ([f64; 6], Vec<Vec<ComplianceGradient>>) {
    let mut solver = solver(structure);
    let compliance = solver.end_compliance();
    let gradients = (0..6)
        .map(|i| {
            let mut gradient = vec![[0.0; 4]; structure.elements.len()];
            solver.compliance_gradient(i, &mut gradient);
            gradient
        })
        .collect();
    (std::array::from_fn(|i| compliance.direct(i)), gradients)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn compliance_is_symmetric_and_positive_definite(structure in any_structure()) {
        let c = compliance(&structure);
        let mirrored = stiffbench_beams::structure::Compliance6(std::array::from_fn(|i| std::array::from_fn(|j| c.0[j][i])));
        prop_assert!(c.relative_difference(&mirrored) < TOLERANCE);
        prop_assert!(is_positive_definite(&c.0), "{c:?}");
    }

    /// Maxwell and Betti: what a load at one node does at another is what the same load there does here.
    #[test]
    fn loads_and_displacements_change_places(structure in any_structure(), a in any::<prop::sample::Index>(), b in any::<prop::sample::Index>()) {
        let n = structure.nodes.len();
        let (a, b) = (1 + a.index(n - 1), 1 + b.index(n - 1));
        let mut solver = solver(&structure);
        let mut respond = |node: usize| {
            let unit = |component: usize| {
                let mut load = [0.0; 6];
                load[component] = 1.0;
                load
            };
            (0..6).map(|c| solver.respond(&structure, &[(Attachment::from(node), unit(c))]).nodes).collect::<Vec<_>>()
        };
        let (from_a, from_b) = (respond(a), respond(b));
        for i in 0..6 {
            for j in 0..6 {
                let scale = (from_a[i][a][i] * from_b[j][b][j]).sqrt();
                prop_assert!((from_a[i][b][j] - from_b[j][a][i]).abs() <= TOLERANCE * scale);
            }
        }
    }

    /// A branch that no load reaches moves as a rigid body and carries nothing.
    #[test]
    fn rigid_motions_carry_no_force(structure in any_structure(), recipe in any_recipe(), at in prop::array::uniform3(0.2..0.6_f64)) {
        let mut structure = structure;
        let base = structure.end.node;
        let tip = structure.nodes.len();
        let start = structure.nodes[base].position_m;
        structure.nodes.push(node("branch", std::array::from_fn(|i| start[i] + at[i])));
        let (_, section, hint, shear) = recipe;
        structure.elements.push(Element { shear, ..beam([base, tip], hint, section) });
        let load = [(Attachment::from(base), [3.0, -2.0, 5.0, 1.0, 0.5, -0.7])];
        let response = solver(&structure).respond(&structure, &load);
        let forces = response.elements.last().unwrap();
        // Against the largest force in the structure, which the unit loads and levers of a metre make of order ten.
        prop_assert!(forces.first.iter().chain(&forces.second).all(|f| f.abs() < 1e-6), "{forces:?}");
        let [from, to] = [base, tip].map(|n| response.nodes[n]);
        let turn = [from[3], from[4], from[5]];
        let carried = cross(turn, at);
        let size = norm([from[0], from[1], from[2]]) + norm(carried);
        for i in 0..3 {
            prop_assert!((to[i] - from[i] - carried[i]).abs() <= TOLERANCE * size);
            prop_assert!((to[3 + i] - turn[i]).abs() <= TOLERANCE * norm(turn).max(size));
        }
    }

    /// The same structure in another place of the world, turned: the compliance turns as a tensor.
    #[test]
    fn rotation_of_the_world_changes_nothing(structure in any_structure(), axis in prop::array::uniform3(0.1..1.0_f64), angle in -3.0..3.0_f64, shift in prop::array::uniform3(-5.0..5.0_f64)) {
        // A support that holds single freedoms holds them in the axes of the world; here only the clamped one turns with it.
        let mut here = structure;
        here.supports.truncate(1);
        let r = rotation(scale(axis, 1.0 / norm(axis)), angle);
        let apply = |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| (0..3).map(|j| r[i][j] * v[j]).sum()) };
        let mut there = here.clone();
        for node in &mut there.nodes {
            let turned = apply(node.position_m);
            node.position_m = std::array::from_fn(|i| turned[i] + shift[i]);
        }
        for element in &mut there.elements {
            element.toward_y = apply(element.toward_y);
        }
        for hinge in &mut there.hinges {
            hinge.axis = apply(hinge.axis);
        }
        let difference = compliance(&there).relative_difference(&turned(&compliance(&here), r));
        prop_assert!(difference < TOLERANCE, "{difference:e}");
    }

    /// A node in the middle of a member is no event.
    #[test]
    fn subdividing_a_member_changes_nothing(structure in any_structure(), which in any::<prop::sample::Index>(), share in 0.1..0.9_f64) {
        let mut finer = structure.clone();
        let which = which.index(finer.elements.len());
        let [first, second] = finer.elements[which].ends.clone();
        let (start, stop) = (finer.nodes[first.node].position_m, finer.nodes[second.node].position_m);
        let span = subtract(stop, start);
        let middle = finer.nodes.len();
        finer.nodes.push(node("middle", std::array::from_fn(|i| start[i] + share * span[i])));
        let whole = finer.elements[which].clone();
        finer.elements[which].ends = [first, middle.into()];
        finer.elements.push(Element { ends: [middle.into(), second], ..whole });
        let difference = compliance(&finer).relative_difference(&compliance(&structure));
        prop_assert!(difference < TOLERANCE, "{difference:e}");
    }

    /// More material anywhere never makes the end softer in the direction of its own load.
    #[test]
    fn stiffening_never_raises_a_diagonal_compliance(structure in any_structure(), which in any::<prop::sample::Index>(), property in 0..4_usize, factor in 1.0..100.0_f64) {
        let mut stiffer = structure.clone();
        let which = which.index(stiffer.elements.len());
        *constant(&mut stiffer.elements[which].section, Property::ALL[property]) *= factor;
        let (before, after) = (compliance(&structure), compliance(&stiffer));
        for i in 0..6 {
            prop_assert!(after.direct(i) <= before.direct(i) * (1.0 + TOLERANCE), "{i}: {:e}", after.direct(i) / before.direct(i) - 1.0);
        }
    }

    /// Derivatives to ln A, ln Iy, ln Iz, ln J against central differences.
    #[test]
    fn gradient_equals_central_differences(structure in any_structure(), which in any::<prop::sample::Index>()) {
        let which = which.index(structure.elements.len());
        let (direct, gradients) = gradients(&structure);
        // Truncation of a central difference is h²/6 of the third derivative, 1e-6 at most; rounding is that of the worst structures, 2e-8,
        // over h.
        let h = 1e-3;
        for property in Property::ALL {
            let moved = |step: f64| {
                let mut structure = structure.clone();
                *constant(&mut structure.elements[which].section, property) *= step.exp();
                compliance(&structure)
            };
            let (up, down) = (moved(h), moved(-h));
            for i in 0..6 {
                let difference = (up.direct(i) - down.direct(i)) / (2.0 * h);
                let gradient = gradients[i][which][property.index()];
                prop_assert!((gradient - difference).abs() <= 1e-4 * direct[i], "{property:?} {i}: {gradient:e} {difference:e}");
                prop_assert!(gradient <= 0.0);
            }
        }
    }

    /// Compliance is of degree minus one in all section constants together: the derivatives add up to minus the compliance.
    #[test]
    fn gradients_add_up_to_minus_the_compliance(structure in any_rigid_structure()) {
        let (direct, gradients) = gradients(&structure);
        for i in 0..6 {
            let sum: f64 = gradients[i].iter().flatten().sum();
            prop_assert!((sum + direct[i]).abs() <= TOLERANCE * direct[i], "{i}: {sum:e} {:e}", direct[i]);
        }
    }

    /// One solver moved from structure to structure gives what a new one gives.
    #[test]
    fn a_solver_can_be_moved(structure in any_structure(), scale in 0.5..2.0_f64) {
        let mut other = structure.clone();
        for node in &mut other.nodes {
            node.position_m[1] *= scale;
        }
        let mut moved = solver(&structure);
        moved.update(&other).unwrap();
        prop_assert_eq!(moved.end_compliance(), compliance(&other));
        moved.update(&structure).unwrap();
        let first = moved.end_compliance();
        prop_assert_eq!(first, compliance(&structure));
        // Half of the work, the same numbers.
        prop_assert_eq!(moved.end_translation_compliance(), first.translation());
    }
}
