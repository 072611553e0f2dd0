use std::sync::Arc;

use pulp::Simd;

use super::schedule::{Op, ReductionForm, Schedule, SchedulePiece};
use super::*;
use crate::structure::{
    Attachment, Compliance6, Element, Hinge, Material, Node, Section, ShearCoefficients, Solver,
    Structure, Support,
};
use stiffbench_numeric::simd::{InstructionSet, Lane};

const SHEAR: ShearCoefficients = ShearCoefficients {
    along_y: 0.5,
    along_z: 0.9,
};

/// Normals of the two planes: that of the drawing, and one that contains it.
const NORMALS: [[f64; 3]; 2] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];

/// A braced square on two supports, a chain of two elements on it to the end, and a dangling element.
///
/// ```text
///       6
///       |
///   2 = 3 - 4 - 5 (end)       2 = 3: two elements, side by side; another goes from 2 to 4
///   | X |
///   0   1
/// ```
fn square(lean: f64, shear: Option<ShearCoefficients>) -> Structure {
    let at = [
        [0.0, 0.0, 0.0],
        [1.0, 0.1, 0.0],
        [lean, 1.0, 0.0],
        [1.1 + lean, 0.9, 0.0],
        [1.6, 1.2, 0.0],
        [2.0, 0.7 + lean, 0.0],
        [1.1, 1.5, 0.0],
    ];
    let nodes = at.iter().enumerate().map(|(place, &position_m)| Node {
        name: Arc::from(place.to_string()),
        position_m,
    });
    let mut area_m2 = 1e-3;
    let mut element = |first: usize, second: usize| {
        area_m2 *= 1.3;
        Element {
            ends: [first.into(), second.into()],
            toward_y: NORMALS[0],
            section: Section {
                area_m2,
                iy_m4: 3e-6,
                iz_m4: 5e-7,
                j_m4: 7e-7,
            },
            material: Material {
                youngs_modulus_pa: 210e9,
                shear_modulus_pa: 81e9,
            },
            shear,
        }
    };
    let pairs = [
        (0, 2),
        (0, 3),
        (1, 2),
        (1, 3),
        (2, 3),
        (3, 2),
        (3, 4),
        (5, 4),
        (3, 6),
        (2, 4),
    ];
    Structure {
        struts: Vec::new(),
        rigid_members: Vec::new(),
        nodes: nodes.collect(),
        elements: pairs.into_iter().map(|(a, b)| element(a, b)).collect(),
        hinges: Vec::new(),
        supports: vec![Support::clamped(0), Support::clamped(1)],
        end: Attachment::from(5),
    }
}

/// The square with its last element, and so its end, out of the plane.
fn with_an_arm_across(lean: f64) -> (Structure, Vec<usize>) {
    let mut structure = square(lean, None);
    structure.nodes[5].position_m = [1.7, 1.3, 0.5 + lean];
    structure.elements[7].toward_y = NORMALS[1];
    let mut planes = vec![0; structure.elements.len()];
    planes[7] = 1;
    (structure, planes)
}

/// A hinge about the normal of a plane, behind which the given ends of elements lie.
fn add_hinge(structure: &mut Structure, plane: usize, nm_per_rad: f64, behind: &[(usize, usize)]) {
    let hinge = structure.hinges.len();
    structure.hinges.push(Hinge {
        slides: false,
        name: Arc::from(hinge.to_string()),
        axis: NORMALS[plane],
        stiffness_nm_per_rad: nm_per_rad,
    });
    for &(element, end) in behind {
        structure.elements[element].ends[end].hinges.push(hinge);
    }
}

/// The square with joints that yield: on a support, between a brace and its node, at the foot of the chain, and at the end.
fn with_yielding_joints(lean: f64) -> Structure {
    let mut structure = square(lean, None);
    add_hinge(&mut structure, 0, 3e3, &[(0, 0)]);
    add_hinge(&mut structure, 0, 2e4, &[(3, 1)]);
    add_hinge(&mut structure, 0, 1e4, &[(6, 1), (9, 1)]);
    add_hinge(&mut structure, 0, 5e3, &[(7, 0)]);
    structure
}

/// Solves structures side by side; `None` where there is no solution.
struct Together<'a> {
    structures: &'a [Structure],
    planes: &'a [usize],
    hinge_planes: &'a [usize],
    path: SolutionPath,
}

impl Together<'_> {
    fn solve<S: Simd>(&self, simd: S) -> Vec<Option<Compliance6>> {
        let model = &self.structures[0];
        let reduced = Reduction::of(model, self.planes, self.hinge_planes, self.path);
        let mut reduction = reduced.unwrap();
        assert!(reduction.rate(model));
        let mut reducer = Reducer::new(simd, &reduction, true);
        let groups: Vec<usize> = (0..model.elements.len()).map(|e| e % 2).collect();
        let (zero, one) = (Lane::zero(simd), Lane::one(simd));
        let units = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        let mut gradient = [[[zero; 4]; 3]; 2];
        let mut results = Vec::new();
        for bundle in self.structures.chunks(Lane::<S>::COUNT) {
            let mut placed = Placed::new(simd, model.nodes.len(), NORMALS.len());
            placed.faults = Lane::zero(simd);
            for lane in 0..Lane::<S>::COUNT {
                let structure = &bundle[lane.min(bundle.len() - 1)];
                for i in 0..3 {
                    for (target, node) in placed.nodes_m.iter_mut().zip(&structure.nodes) {
                        target.0[i].set(lane, node.position_m[i]);
                    }
                    for (target, normal) in placed.normals.iter_mut().zip(&NORMALS) {
                        target.0[i].set(lane, normal[i]);
                    }
                }
            }
            reducer.solve(&reduction, &placed);
            reducer.differentiate(&reduction, &placed, &groups, &units, &mut gradient);
            for lane in 0..bundle.len() {
                let found = reducer
                    .results
                    .compliance
                    .map(|row| row.map(|c| c.get(lane)));
                let sound = reducer.results.faults.get(lane) == 0.0;
                if sound {
                    let entries = gradient.map(|of| of.map(|axis| axis.map(|g| g.get(lane))));
                    assert_derivatives(&bundle[lane], &entries);
                }
                results.push(sound.then_some(Compliance6(found)));
            }
        }
        results
    }

    fn on(&self, instructions: InstructionSet) -> Vec<Option<Compliance6>> {
        match instructions {
            InstructionSet::Plain(set) => self.solve(set),
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon(set) => self.solve(set),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2(set) => self.solve(set),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512(set) => self.solve(set),
        }
    }
}

fn solver(structure: &Structure) -> Solver {
    let mut solver = Solver::new(structure).unwrap();
    solver.update(structure).unwrap();
    solver
}

/// Asserts that derivatives of the elements with even and with odd numbers are those of the general solver.
fn assert_derivatives(structure: &Structure, found: &[[[f64; 4]; 3]; 2]) {
    let mut solver = solver(structure);
    let compliance = solver.end_compliance();
    let mut of_elements = vec![[0.0; 4]; structure.elements.len()];
    for axis in 0..3 {
        solver.compliance_gradient(axis, &mut of_elements);
        for (group, found) in found.iter().enumerate() {
            for (property, found) in found[axis].iter().enumerate() {
                let of_group = of_elements.iter().skip(group).step_by(2);
                let expected: f64 = of_group.map(|element| element[property]).sum();
                let difference = (found - expected).abs() / compliance.direct(axis);
                assert!(
                    difference < 1e-10,
                    "axis {axis}, group {group}, property {property}: {difference:e}"
                );
            }
        }
    }
}

fn assert_agree(found: &[Option<Compliance6>], structures: &[Structure]) {
    // A joint a thousand times softer than the elements around it costs the general solver digits.
    let bound = if structures[0].hinges.is_empty() {
        1e-11
    } else {
        1e-10
    };
    assert_eq!(found.len(), structures.len());
    for (found, structure) in found.iter().zip(structures) {
        let difference = found
            .unwrap()
            .relative_difference(&solver(structure).end_compliance());
        assert!(difference < bound, "{difference:e}");
    }
}

const PATHS: [SolutionPath; 2] = [SolutionPath::Fastest, SolutionPath::Spatial];

/// Structures as they lean more and more; eleven of them fill no register evenly.
fn leaning(count: usize, structure: impl Fn(f64) -> Structure) -> Vec<Structure> {
    (0..count).map(|i| structure(0.03 * i as f64)).collect()
}

/// On every instruction set, both ways.
fn assert_all_agree(structures: &[Structure], planes: &[usize], hinge_planes: &[usize]) {
    for instructions in InstructionSet::all() {
        for path in PATHS {
            let together = Together {
                structures,
                planes,
                hinge_planes,
                path,
            };
            assert_agree(&together.on(instructions), structures);
        }
    }
}

#[test]
fn every_instruction_set_and_both_ways_agree_with_the_general_solver() {
    for shear in [None, Some(SHEAR)] {
        assert_all_agree(&leaning(11, |lean| square(lean, shear)), &[0; 10], &[]);
    }
    let across = leaning(5, |lean| with_an_arm_across(lean).0);
    assert_all_agree(&across, &with_an_arm_across(0.0).1, &[]);
}

#[test]
fn joints_that_yield_agree_with_the_general_solver() {
    assert_all_agree(&leaning(11, with_yielding_joints), &[0; 10], &[0; 4]);
    // One whose axis lies in the plane of its neighbours: that part is solved in space.
    let (_, planes) = with_an_arm_across(0.0);
    let across = leaning(11, |lean| {
        let (mut structure, _) = with_an_arm_across(lean);
        add_hinge(&mut structure, 1, 1e4, &[(6, 0)]);
        structure
    });
    assert_all_agree(&across, &planes, &[1]);
}

/// The square with joints between several elements on either side: at a corner, two in series at another, on the way to the end.
fn with_joints_between_many(lean: f64, across: bool) -> Structure {
    let mut structure = square(lean, None);
    let ends = |structure: &Structure, node: usize| -> Vec<(usize, usize)> {
        let all = (0..structure.elements.len()).flat_map(|element| [(element, 0), (element, 1)]);
        all.filter(|&(element, end)| structure.elements[element].ends[end].node == node)
            .collect()
    };
    let mut hinged = 0;
    for node in 0..structure.nodes.len() {
        let there = ends(&structure, node);
        if there.len() >= 4 {
            let behind = &there[..there.len() / 2];
            add_hinge(&mut structure, 0, 4e3 * (1.0 + node as f64), behind);
            hinged += 1;
            if hinged == 2 {
                add_hinge(&mut structure, usize::from(across), 9e3, behind);
            }
        }
    }
    assert!(hinged > 1, "{hinged} joints");
    structure
}

#[test]
fn joints_between_several_elements_agree_with_the_general_solver() {
    for across in [false, true] {
        let structures = leaning(11, |lean| with_joints_between_many(lean, across));
        let hinges = structures[0].hinges.iter();
        let hinge_planes: Vec<usize> = hinges
            .map(|hinge| usize::from(hinge.axis != NORMALS[0]))
            .collect();
        assert_all_agree(&structures, &[0; 10], &hinge_planes);
    }
}

#[test]
fn a_pose_out_of_its_plane_is_solved_beside_others_that_are_in_theirs() {
    let flat = square(0.1, None);
    let mut bent = flat.clone();
    bent.nodes[4].position_m[2] = 0.2;
    let structures = [flat.clone(), bent.clone(), flat.clone()];
    let planes = vec![0; flat.elements.len()];
    for instructions in InstructionSet::all() {
        let solve = |structures: &[Structure]| {
            let together = Together {
                structures,
                planes: &planes,
                hinge_planes: &[],
                path: SolutionPath::Fastest,
            };
            together.on(instructions)
        };
        let mixed = solve(&structures);
        assert_agree(&mixed, &structures);
        for (mixed, structure) in mixed.iter().zip(structures.clone()) {
            assert_eq!(*mixed, solve(&[structure])[0]);
        }
    }
}

#[test]
fn unsolvable_poses_are_reported_one_by_one() {
    let sound = square(0.0, None);
    let mut short = sound.clone();
    short.nodes[5].position_m = short.nodes[4].position_m;
    let mut idle_and_short = sound.clone();
    idle_and_short.nodes[6].position_m = idle_and_short.nodes[3].position_m;
    let mut lost = sound.clone();
    lost.nodes[2].position_m[0] = f64::NAN;
    let structures = [sound.clone(), short, idle_and_short, lost, sound];
    let planes = vec![0; structures[0].elements.len()];
    for instructions in InstructionSet::all() {
        for path in PATHS {
            let together = Together {
                structures: &structures,
                planes: &planes,
                hinge_planes: &[],
                path,
            };
            let solved: Vec<bool> = together
                .on(instructions)
                .iter()
                .map(Option::is_some)
                .collect();
            assert_eq!(solved, [true, false, false, false, true]);
        }
    }
}

#[test]
fn parts_are_cut_where_the_plane_changes() {
    let (structure, planes) = with_an_arm_across(0.1);
    let said = |path| -> Vec<String> {
        let reduction = Reduction::of(&structure, &planes, &[], path).unwrap();
        reduction
            .methods()
            .iter()
            .map(ToString::to_string)
            .collect()
    };
    // The two elements between 2 and 3 are one; 2 and 3 then have three neighbours each.
    assert_eq!(
        said(SolutionPath::Fastest),
        [
            "supports to 4: 8 elements, 2 nodes eliminated, in its plane and across it apart",
            "4 to 5: 1 elements, 0 nodes eliminated, in its plane and across it apart"
        ]
    );
}

#[test]
fn structures_for_the_general_solver_are_passed_on() {
    let planes = vec![0; 10];
    let refused = |change: &dyn Fn(&mut Structure)| {
        let mut structure = square(0.0, None);
        change(&mut structure);
        let hinge_planes = vec![0; structure.hinges.len()];
        Reduction::of(&structure, &planes, &hinge_planes, SolutionPath::Fastest).is_none()
    };
    assert!(!refused(&|_| {}));
    assert!(refused(&|s| s.supports[0].held[3] = false));
    assert!(refused(&|s| s.end = Attachment::from(0)));
    assert!(refused(&|s| s.elements[8].ends[0] = 6.into()));
    // A hinge with something behind it, in series with an element: but for a pin, none of these is refused.
    assert!(!refused(&|s| add_hinge(s, 0, 1e4, &[(0, 1)])));
    assert!(refused(&|s| add_hinge(s, 0, 0.0, &[(0, 1)])));
    assert!(refused(&|s| add_hinge(s, 0, f64::INFINITY, &[(0, 1)])));
    assert!(refused(&|s| add_hinge(s, 0, 1e4, &[])));
    // Two braces behind it; a brace and the foot of the chain, with two more before it.
    assert!(!refused(&|s| add_hinge(s, 0, 1e4, &[(1, 1), (3, 1)])));
    assert!(!refused(&|s| add_hinge(s, 0, 1e4, &[(1, 1), (6, 0)])));
    // Behind one hinge and then another; but not with an element behind the second alone.
    assert!(!refused(&|s| {
        add_hinge(s, 0, 1e4, &[(0, 1)]);
        add_hinge(s, 0, 1e4, &[(0, 1)]);
    }));
    assert!(refused(&|s| {
        add_hinge(s, 0, 1e4, &[(0, 1)]);
        add_hinge(s, 0, 1e4, &[(0, 1), (2, 1)]);
    }));
    // What hangs on nothing moves, even if it does not touch the way to the end.
    assert!(refused(&|s| {
        let lone = Node {
            name: Arc::from("lone"),
            position_m: [5.0; 3],
        };
        s.nodes.push(lone);
        s.elements[8].ends[0] = 7.into();
    }));
    let structure = square(0.0, None);
    let mut reduction = Reduction::of(&structure, &planes, &[], SolutionPath::Fastest).unwrap();
    assert!(reduction.rate(&structure));
    for impossible in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
        let mut wrong = structure.clone();
        wrong.elements[0].section.iy_m4 *= impossible;
        assert!(!reduction.rate(&wrong));
    }
}

#[test]
fn operations_are_counted() {
    let mut schedule = Schedule::default();
    schedule.ops.push(Op::Piece {
        piece: SchedulePiece::Element(0),
        form: ReductionForm::Compliance,
        into: 1,
        fresh: true,
    });
    schedule.ops.push(Op::Invert {
        from: 1,
        into: 0,
        fresh: false,
    });
    // One freedom: 7 for the element; 1/d and its ratio, the entry itself counted as one product, and one sum.
    assert_eq!(schedule.operations(1, 1, [7, 5]), 7 + 2 + 1 + 1);
    // Two halves of two freedoms: twice 4 + 1 + 2 to factorise, 1 + 1 + 1 + 3 for the inverse, 3 sums.
    assert_eq!(schedule.operations(2, 2, [7, 5]), 7 + 2 * (7 + 6 + 3));
    // A hinge is added as it is worked out: 5 in all.
    schedule.ops.push(Op::Piece {
        piece: SchedulePiece::Hinge(0),
        form: ReductionForm::Compliance,
        into: 1,
        fresh: false,
    });
    assert_eq!(schedule.operations(1, 1, [7, 5]), 7 + 2 + 1 + 1 + 5);
}
