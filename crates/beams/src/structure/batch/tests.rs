use std::sync::Arc;

use super::*;
use crate::structure::{
    Attachment, Element, Hinge, Material, Node, Section, ShearCoefficients, Solver, Support,
};

/// A portal of two columns and a beam in the plane z = 0, with an arm out of the plane to the end.
///
/// ```text
///   1 ----- 2 ==== 3 (end, towards +z)
///   |       |
///   0       4
/// ```
fn portal(lean: f64, shear: Option<ShearCoefficients>) -> Structure {
    let at = [
        [0.0, 0.0, 0.0],
        [lean, 1.0, 0.0],
        [0.8 + lean, 1.1, 0.0],
        [0.9, 1.2, 0.5],
        [0.8, 0.0, 0.0],
    ];
    let nodes = at.iter().enumerate().map(|(place, &position_m)| Node {
        name: Arc::from(place.to_string()),
        position_m,
    });
    let element = |first: usize, second: usize, toward_y| Element {
        ends: [first.into(), second.into()],
        toward_y,
        section: Section {
            area_m2: 2e-3,
            iy_m4: 3e-6,
            iz_m4: 5e-7,
            j_m4: 7e-7,
        },
        material: Material {
            youngs_modulus_pa: 210e9,
            shear_modulus_pa: 81e9,
        },
        shear,
    };
    Structure {
        nodes: nodes.collect(),
        elements: vec![
            element(0, 1, [0.0, 0.0, 1.0]),
            element(1, 2, [0.0, 0.0, 1.0]),
            element(2, 4, [0.0, 0.0, 1.0]),
            element(2, 3, [0.3, 1.0, 0.0]),
        ],
        hinges: Vec::new(),
        supports: vec![Support::clamped(0), Support::clamped(4)],
        end: Attachment::from(3),
    }
}

/// Columns are group 0, the beam and the arm group 1; the arm is in a plane of its own.
const ROLES: [ElementRole; 4] = [
    ElementRole { group: 0, plane: 0 },
    ElementRole { group: 1, plane: 0 },
    ElementRole { group: 0, plane: 0 },
    ElementRole { group: 1, plane: 1 },
];

const MULTIPLIERS: [[f64; 4]; 2] = [[1.0, 0.5, 3.0, 0.1], [0.2, 2.0, 1.0, 4.0]];

const SHEAR: ShearCoefficients = ShearCoefficients {
    along_y: 0.5,
    along_z: 0.9,
};

fn batch(structure: &Structure, poses: usize, instructions: InstructionSet) -> BatchSolver {
    BatchSolver::with(structure, &ROLES, poses, instructions)
        .unwrap()
        .unwrap()
}

/// Asserts that a pose of a batch agrees with the general solver.
fn assert_agrees(batch: &BatchSolver, pose: usize, structure: &Structure) {
    let mut rated = structure.clone();
    for (element, role) in rated.elements.iter_mut().zip(ROLES) {
        element.section = element.section.scaled(MULTIPLIERS[role.group]);
    }
    let mut solver = Solver::new(&rated).unwrap();
    solver.update(&rated).unwrap();
    let expected = solver.end_compliance(&rated);
    assert!(batch.is_solved(pose));
    let difference = batch.end_compliance(pose).relative_difference(&expected);
    assert!(difference < 1e-12, "pose {pose}: {difference:e}");
    let mut gradient = [[0.0; 4]; 4];
    for axis in 0..3 {
        solver.compliance_gradient(&rated, axis, &mut gradient);
        for group in 0..2 {
            let found = batch.derivatives(pose, axis, group);
            for property in 0..4 {
                let of_group = gradient.iter().zip(ROLES).filter(|(_, r)| r.group == group);
                let sum: f64 = of_group.map(|(g, _)| g[property]).sum();
                let difference = (found[property] - sum).abs() / expected.direct(axis);
                assert!(
                    difference < 1e-12,
                    "{axis} {group} {property}: {difference:e}"
                );
            }
        }
    }
}

#[test]
fn every_instruction_set_agrees_with_the_general_solver() {
    for instructions in InstructionSet::all() {
        for shear in [None, Some(SHEAR)] {
            // Eleven poses fill no register evenly.
            let poses: Vec<Structure> = (0..11)
                .map(|i| portal(0.05 * f64::from(i), shear))
                .collect();
            let mut batch = batch(&poses[0], poses.len(), instructions);
            for (place, pose) in poses.iter().enumerate() {
                batch.place(place, pose);
            }
            batch.solve(&MULTIPLIERS, true);
            for (place, pose) in poses.iter().enumerate() {
                assert_agrees(&batch, place, pose);
            }
        }
    }
}

#[test]
fn a_pose_out_of_its_plane_is_solved_beside_others_that_are_in_theirs() {
    let flat = portal(0.1, None);
    let mut bent = flat.clone();
    bent.nodes[1].position_m[2] = 0.2;
    for instructions in InstructionSet::all() {
        let mut mixed = batch(&flat, 3, instructions);
        mixed.place(0, &flat);
        mixed.place(1, &bent);
        mixed.place(2, &flat);
        mixed.solve(&MULTIPLIERS, true);
        for (place, structure) in [&flat, &bent, &flat].into_iter().enumerate() {
            assert_agrees(&mixed, place, structure);
            let mut alone = batch(&flat, 3, instructions);
            alone.place(place, structure);
            alone.solve(&MULTIPLIERS, true);
            assert_eq!(mixed.end_compliance(place), alone.end_compliance(place));
            assert_eq!(
                mixed.derivatives(place, 1, 0),
                alone.derivatives(place, 1, 0)
            );
        }
    }
}

#[test]
fn what_cannot_be_solved_is_told_pose_by_pose() {
    let sound = portal(0.0, None);
    for instructions in InstructionSet::all() {
        let mut batch = batch(&sound, 5, instructions);
        let mut short = sound.clone();
        short.nodes[3].position_m = short.nodes[2].position_m;
        let mut unturned = sound.clone();
        unturned.elements[3].toward_y = [0.1, 0.1, 0.5];
        let mut lost = sound.clone();
        lost.nodes[2].position_m[0] = f64::NAN;
        for (place, pose) in [&sound, &short, &unturned, &lost].into_iter().enumerate() {
            batch.place(place, pose);
        }
        batch.solve(&MULTIPLIERS, false);
        let solved: Vec<bool> = (0..5).map(|pose| batch.is_solved(pose)).collect();
        assert_eq!(solved, [true, false, false, false, false]);
        // Placed anew, it recovers.
        batch.place(3, &sound);
        batch.solve(&MULTIPLIERS, true);
        assert_agrees(&batch, 3, &sound);
        batch.place(3, &short);
        assert!(!batch.is_solved(3));

        // The arm turns about its own axis without resistance.
        batch.solve(&[[1.0; 4], [1.0, 1.0, 1.0, 0.0]], false);
        assert!(!batch.is_solved(0));
        for impossible in [-1.0, f64::NAN, f64::INFINITY] {
            batch.solve(&[[1.0; 4], [1.0, impossible, 1.0, 1.0]], false);
            assert!(!batch.is_solved(0));
        }
    }
}

#[test]
fn structures_for_the_general_solver_are_passed_on() {
    let refused = |change: &dyn Fn(&mut Structure)| {
        let mut structure = portal(0.0, None);
        change(&mut structure);
        BatchSolver::new(&structure, &ROLES, 1).unwrap().is_none()
    };
    assert!(!refused(&|_| {}));
    assert!(refused(&|s| s.supports[0].held[3] = false));
    assert!(refused(&|s| s.end = Attachment::from(0)));
    let mut empty = portal(0.0, None);
    empty.elements.clear();
    assert!(BatchSolver::new(&empty, &[], 1).unwrap().is_none());
    assert!(refused(&|s| s.hinges.push(Hinge {
        name: Arc::from("pin"),
        axis: [0.0, 0.0, 1.0],
        stiffness_nm_per_rad: 0.0,
    })));
    let mut structure = portal(0.0, None);
    structure.end = Attachment::from(9);
    assert!(matches!(
        BatchSolver::new(&structure, &ROLES, 1),
        Err(StructureError::UnknownIndex { index: 9, .. })
    ));
}

#[test]
fn derivatives_are_zero_where_nobody_asked() {
    let structure = portal(0.0, None);
    let mut solver = BatchSolver::new(&structure, &ROLES, 1).unwrap().unwrap();
    solver.place(0, &structure);
    solver.solve(&MULTIPLIERS, true);
    assert!(solver.derivatives(0, 0, 0)[1] < 0.0);
    assert_eq!(solver.derivatives(0, 0, 7), [0.0; 4]);
    solver.solve(&MULTIPLIERS, false);
    assert_eq!(solver.derivatives(0, 0, 0), [0.0; 4]);
}

#[test]
fn avx2_and_avx512_round_alike() {
    let structure = portal(0.3, Some(SHEAR));
    let sets = InstructionSet::all();
    let results: Vec<_> = sets
        .iter()
        .skip(1)
        .map(|&instructions| {
            let mut batch = batch(&structure, 1, instructions);
            batch.place(0, &structure);
            batch.solve(&MULTIPLIERS, true);
            (batch.end_compliance(0), batch.derivatives(0, 2, 1))
        })
        .collect();
    assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
}
