//! Every way in which a structure can be impossible, and what is said about it.

use crate::support::{SECTION, beam, behind, chain, compliance, held, hinge, node};
use stiffbench_beams::structure::{
    Element, Freedom, ShearCoefficients, Solver, Structure, StructureError, Support,
};

fn outcome(structure: &Structure) -> Result<(), StructureError> {
    Solver::new(structure)?.update(structure)
}

/// Two elements in a row along z, clamped at the first node.
fn arm() -> Structure {
    let mut arm = chain(
        &[[0.0; 3], [0.0, 0.0, 0.5], [0.0, 0.3, 0.9]],
        [1.0, 0.0, 0.0],
    );
    for (node, name) in arm.nodes.iter_mut().zip(["base", "elbow", "hand"]) {
        node.name = name.into();
    }
    arm
}

fn moving_freedom(structure: &Structure) -> Freedom {
    match outcome(structure) {
        Err(StructureError::Mechanism { freedom }) => freedom,
        other => panic!("{other:?}"),
    }
}

fn of_node(node: &str, component: usize) -> Freedom {
    Freedom::OfNode {
        node: node.into(),
        component,
    }
}

#[test]
fn without_supports_something_moves() {
    let mut structure = arm();
    structure.supports.clear();
    let error = outcome(&structure).unwrap_err();
    assert!(
        matches!(error, StructureError::Mechanism { .. }),
        "{error:?}"
    );
    assert!(error.to_string().contains("of node"), "{error}");
}

#[test]
fn a_missing_hold_is_named() {
    // A straight shaft along y that nothing keeps from turning about itself: its nodes do not even move sideways.
    let shaft = |held: [bool; 6]| Structure {
        nodes: vec![node("low", [0.0; 3]), node("high", [0.0, 1.0, 0.0])],
        elements: vec![beam([0, 1], [1.0, 0.0, 0.0], SECTION)],
        supports: vec![Support { node: 0, held }],
        end: 1.into(),
        ..Structure::default()
    };
    let loose_twist = shaft([true, true, true, true, false, true]);
    let freedom = moving_freedom(&loose_twist);
    assert!(
        [of_node("low", 4), of_node("high", 4)].contains(&freedom),
        "{freedom}"
    );
    let message = outcome(&loose_twist).unwrap_err().to_string();
    assert!(message.contains("rotation about y of node"), "{message}");

    let loose_lift = shaft([true, false, true, true, true, true]);
    let freedom = moving_freedom(&loose_lift);
    assert!(
        [of_node("low", 1), of_node("high", 1)].contains(&freedom),
        "{freedom}"
    );
    assert!(
        freedom
            .to_string()
            .starts_with("displacement along y of node")
    );
}

#[test]
fn a_pinned_chain_is_a_mechanism() {
    // Clamped, but a pin at the elbow lets the forearm swing about x.
    let mut structure = arm();
    structure.hinges = vec![hinge("elbow pin", [1.0, 0.0, 0.0], 0.0)];
    structure.elements[1].ends[0].hinges = vec![0];
    let freedom = moving_freedom(&structure);
    let swings = [
        Freedom::OfHinge {
            hinge: "elbow pin".into(),
        },
        of_node("hand", 1),
        of_node("hand", 2),
        of_node("hand", 3),
    ];
    assert!(swings.contains(&freedom), "{freedom}");
    // A spring, however soft, is enough.
    structure.hinges[0].stiffness_nm_per_rad = 1.0;
    assert_eq!(outcome(&structure), Ok(()));
}

#[test]
fn a_four_bar_without_drive_is_a_mechanism() {
    let x = [1.0, 0.0, 0.0];
    let places = [[0.0; 3], [0.0, 0.5, 0.1], [0.0, 0.6, 0.9], [0.0, 0.0, 1.0]];
    let mut structure = Structure {
        hinges: ["a", "b", "c", "d"]
            .map(|name| hinge(name, x, 0.0))
            .to_vec(),
        supports: vec![Support::clamped(0), Support::clamped(3)],
        end: 2.into(),
        ..chain(&places, x)
    };
    structure.elements[0].ends[0] = behind(0, 0);
    structure.elements[1].ends[0] = behind(1, 1);
    structure.elements[2].ends = [behind(2, 2), behind(3, 3)];
    let error = outcome(&structure).unwrap_err();
    assert!(
        matches!(error, StructureError::Mechanism { .. }),
        "{error:?}"
    );
    // A drive that locks the crank makes it a structure.
    structure.elements[0].ends[0].hinges.clear();
    structure.hinges[0].stiffness_nm_per_rad = 1.0;
    assert_eq!(outcome(&structure), Ok(()));
}

#[test]
fn a_hinge_that_nothing_hangs_on_is_named() {
    let mut structure = arm();
    structure.hinges = vec![hinge("spare", [0.0, 1.0, 0.0], 0.0)];
    let freedom = moving_freedom(&structure);
    assert_eq!(freedom.to_string(), "twist of joint spare");
}

#[test]
fn an_element_without_length_or_plane_is_refused() {
    let mut flat = arm();
    flat.nodes[1].position_m = [0.0; 3];
    let expected = StructureError::DegenerateElement {
        element: 0,
        first: "base".into(),
        second: "elbow".into(),
    };
    assert_eq!(outcome(&flat), Err(expected.clone()));
    assert!(
        expected.to_string().contains("base and elbow"),
        "{expected}"
    );

    let mut parallel = arm();
    parallel.elements[0].toward_y = [0.0, 0.0, -3.0];
    assert_eq!(outcome(&parallel), Err(expected.clone()));

    let mut nowhere = arm();
    nowhere.nodes[1].position_m[2] = f64::NAN;
    assert_eq!(outcome(&nowhere), Err(expected.clone()));
    nowhere.nodes[1].position_m[2] = f64::INFINITY;
    assert_eq!(outcome(&nowhere), Err(expected));
}

#[test]
fn indices_that_point_nowhere_are_refused() {
    type Change = fn(&mut Structure);
    #[rustfmt::skip]
    let cases: [(Change, _, _, _, _); 6] = [
        (|s| s.elements[1].ends[1].node = 7, "an element", "node", 7, 3),
        (|s| s.elements[0].ends[0].hinges = vec![2], "an element", "hinge", 2, 0),
        (|s| s.supports[0].node = 3, "a support", "node", 3, 3),
        (|s| s.end.node = 4, "the end", "node", 4, 3),
        (|s| s.end.hinges = vec![0], "the end", "hinge", 0, 0),
        (|s| *s = Structure::default(), "the end", "node", 0, 0),
    ];
    for (change, what, kind, index, count) in cases {
        let mut structure = arm();
        change(&mut structure);
        let expected = StructureError::UnknownIndex {
            what,
            kind,
            index,
            count,
        };
        assert_eq!(outcome(&structure), Err(expected));
    }
}

#[test]
fn negative_and_endless_constants_are_refused() {
    type Change = fn(&mut Element, f64);
    let changes: [(&str, Change); 8] = [
        ("the area", |e, v| e.section.area_m2 = v),
        ("the second moment Iy", |e, v| e.section.iy_m4 = v),
        ("the second moment Iz", |e, v| e.section.iz_m4 = v),
        ("the torsion constant", |e, v| e.section.j_m4 = v),
        ("Young's modulus", |e, v| e.material.youngs_modulus_pa = v),
        ("the shear modulus", |e, v| e.material.shear_modulus_pa = v),
        ("the shear coefficient along y", |e, v| {
            e.shear = Some(ShearCoefficients {
                along_y: v,
                along_z: 0.8,
            });
        }),
        ("the shear coefficient along z", |e, v| {
            e.shear = Some(ShearCoefficients {
                along_y: 0.8,
                along_z: v,
            });
        }),
    ];
    for (name, change) in changes {
        for wrong in [-1e-6, f64::NAN, f64::INFINITY] {
            let mut structure = arm();
            change(&mut structure.elements[1], wrong);
            match outcome(&structure) {
                Err(StructureError::ImpossibleConstant { what, of, value }) => {
                    assert_eq!((what, of.as_str()), (name, "element 1"));
                    assert!(value == wrong || wrong.is_nan());
                }
                other => panic!("{name} {wrong}: {other:?}"),
            }
        }
    }
    // Two wrongs whose product looks right.
    let mut structure = arm();
    let section = &mut structure.elements[0].section;
    (section.area_m2, section.iy_m4, section.iz_m4) = (-1e-3, -1e-6, -1e-6);
    structure.elements[0].material.youngs_modulus_pa = -2e11;
    assert!(matches!(
        outcome(&structure),
        Err(StructureError::ImpossibleConstant { .. })
    ));
    // Possible constants of a length that makes their stiffness overflow.
    let mut structure = arm();
    structure.nodes[1].position_m[2] = 1e-300;
    assert!(outcome(&structure).is_err());
}

#[test]
fn a_hinge_needs_a_possible_stiffness_and_axis() {
    let hinged = |axis, stiffness| {
        let mut structure = arm();
        structure.hinges = vec![hinge("j", axis, stiffness)];
        structure.elements[1].ends[0].hinges = vec![0];
        outcome(&structure)
    };
    for stiffness in [-1.0, f64::NAN, f64::INFINITY] {
        let error = hinged([1.0, 0.0, 0.0], stiffness).unwrap_err();
        assert!(
            error.to_string().starts_with("the stiffness of joint j is"),
            "{error}"
        );
    }
    for axis in [[0.0; 3], [2.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0]] {
        let error = hinged(axis, 1.0).unwrap_err();
        assert!(
            matches!(error, StructureError::ImpossibleAxis { .. }),
            "{error:?}"
        );
    }
    assert_eq!(hinged([0.0, 0.6, 0.8], 1.0), Ok(()));
}

#[test]
fn an_element_that_carries_nothing_is_allowed_where_it_is_not_needed() {
    let mut structure = arm();
    let mut loose = beam([0, 2], [1.0, 0.0, 0.0], SECTION.scaled([0.0; 4]));
    loose.shear = Some(ShearCoefficients {
        along_y: 0.8,
        along_z: 0.8,
    });
    let before = compliance(&structure);
    structure.elements.push(loose);
    assert!(compliance(&structure).relative_difference(&before) < 1e-12);
    // Where it is needed the structure falls apart.
    structure.elements.remove(1);
    assert!(matches!(
        outcome(&structure),
        Err(StructureError::Mechanism { .. })
    ));
}

#[test]
fn a_structure_that_cannot_move_has_no_compliance() {
    let structure = Structure {
        supports: vec![
            Support::clamped(0),
            Support::clamped(1),
            Support::clamped(2),
        ],
        ..arm()
    };
    assert_eq!(compliance(&structure).0, [[0.0; 6]; 6]);
}

#[test]
fn one_support_that_holds_part_after_part() {
    // Two entries for one node hold what either holds.
    let mut structure = arm();
    let whole = compliance(&structure);
    structure.supports = vec![
        held(0, [true, true, true, false, false, false]),
        held(0, [false, false, false, true, true, true]),
    ];
    assert_eq!(compliance(&structure), whole);
}
