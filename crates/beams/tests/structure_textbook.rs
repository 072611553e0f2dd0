//! Closed forms and book examples, each with its source and a sketch.
//!
//! Closed forms without a source named are those of elementary beam theory as in Young, Budynas and Sadegh, Roark's Formulas for
//! Stress and Strain, 8th edition, table 8.1.

use crate::support::{
    SECTION, STEEL, beam, behind, chain, compliance, held, hinge, node, solver, transposed, turned,
};
use stiffbench_beams::structure::{
    Attachment, Compliance6, Element, Material, Section, ShearCoefficients, Structure, Support,
};
use stiffbench_numeric::vector::{cross, norm, rotation, scale};

const E: f64 = STEEL.youngs_modulus_pa;
const G: f64 = STEEL.shear_modulus_pa;

/// One solve loses some digits to the condition of the matrix; the structures of this file keep 1e-9 with room to spare.
const TOLERANCE: f64 = 1e-9;

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(
        error < tolerance,
        "{found:e} for {expected:e}: off by {error:e}"
    );
}

/// A section so strong along its axis that only bending is left.
///
/// The share of the axial deformation is then below 1e-8 in the structures here; `INEXTENSIBLE` is the bound that leaves.
fn inextensible(section: Section) -> Section {
    Section {
        area_m2: 1e5 * section.area_m2,
        ..section
    }
}

const INEXTENSIBLE: f64 = 1e-6;

/// A clamped beam of length `l` from the origin along `along`, local y toward `toward_y`.
fn cantilever(l: f64, along: [f64; 3], toward_y: [f64; 3]) -> Structure {
    chain(&[[0.0; 3], scale(along, l / norm(along))], toward_y)
}

/// ```text
///   ▒├────────────────● F, M in all six freedoms
/// ```
/// In local axes: u = F L/EA, v = F L³/3EIz, w = F L³/3EIy, θx = M L/GJ, θy = M L/EIy, θz = M L/EIz, and the couplings of a tip
/// force and a tip rotation, L²/2EI, whose signs follow from θz = v', θy = -w'.
fn cantilever_in_local_axes(l: f64) -> Compliance6 {
    let Section {
        area_m2,
        iy_m4,
        iz_m4,
        j_m4,
    } = SECTION;
    let mut c = [[0.0; 6]; 6];
    c[0][0] = l / (E * area_m2);
    c[1][1] = l.powi(3) / (3.0 * E * iz_m4);
    c[2][2] = l.powi(3) / (3.0 * E * iy_m4);
    c[3][3] = l / (G * j_m4);
    c[4][4] = l / (E * iy_m4);
    c[5][5] = l / (E * iz_m4);
    let (vz, wy) = (l * l / (2.0 * E * iz_m4), -l * l / (2.0 * E * iy_m4));
    (c[1][5], c[5][1]) = (vz, vz);
    (c[2][4], c[4][2]) = (wy, wy);
    Compliance6(c)
}

#[test]
fn cantilever_in_any_orientation() {
    let l = 0.83;
    let local = cantilever_in_local_axes(l);
    let turns = [
        ([1.0, 0.0, 0.0], 0.0),
        ([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2), // along -z
        ([0.0, 1.0, 0.0], -std::f64::consts::FRAC_PI_2), // along +z
        ([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2), // along +y
        ([0.0, 0.0, 1.0], std::f64::consts::PI),        // along -x
        ([1.0, 0.0, 0.0], 1.1),                         // rolled about itself
        ([2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0], 2.3),
        ([-6.0 / 7.0, 2.0 / 7.0, 3.0 / 7.0], 0.7),
    ];
    for (axis, angle) in turns {
        // Columns of the rotation are the local axes in global components.
        let r = rotation(axis, angle);
        let [x, y, _] = transposed(r);
        let found = compliance(&cantilever(l, x, y));
        let difference = found.relative_difference(&turned(&local, r));
        assert!(difference < TOLERANCE, "{axis:?} {angle}: {difference:e}");
    }
}

#[test]
fn only_the_part_of_the_hint_across_the_element_counts() {
    let (x, y) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let straight = compliance(&cantilever(0.5, x, y));
    let oblique = compliance(&cantilever(0.5, x, [2.0, 0.0, -5.0]));
    assert!(oblique.relative_difference(&straight) < TOLERANCE);
}

/// ```text
///             P
///   ▒├────────▼────────┤
///       L/2       L/2  △ held along the load only
/// ```
/// Roark table 8.1 case 1c: δ = 7 P L³/768 EI under the load, prop 5P/16, clamping moment 3PL/16.
#[test]
fn propped_cantilever() {
    let (l, p) = (1.6, 1000.0);
    let structure = Structure {
        supports: vec![
            Support::clamped(0),
            held(2, [false, true, false, false, false, false]),
        ],
        end: 1.into(),
        ..chain(
            &[[0.0; 3], [0.5 * l, 0.0, 0.0], [l, 0.0, 0.0]],
            [0.0, 1.0, 0.0],
        )
    };
    let load = [(Attachment::from(1), [0.0, -p, 0.0, 0.0, 0.0, 0.0])];
    let response = solver(&structure).respond(&structure, &load);
    let deflection = 7.0 * p * l.powi(3) / (768.0 * E * SECTION.iz_m4);
    assert_close(-response.nodes[1][1], deflection, TOLERANCE);
    assert_close(response.reactions[1][1], 5.0 * p / 16.0, TOLERANCE);
    assert_close(response.reactions[0][1], 11.0 * p / 16.0, TOLERANCE);
    assert_close(response.reactions[0][5], 3.0 * p * l / 16.0, TOLERANCE);
    // What is not held has no reaction, and exactly none.
    assert_eq!(response.reactions[1][5], 0.0);
}

/// ```text
///          P
///   ├──────▼──────┤
///   △     L/2     ○
/// ```
/// Roark table 8.1 case 1e: δ = P L³/48 EI, end rotation P L²/16 EI; supports hold parts of their nodes only, twist at one end.
#[test]
fn simply_supported_beam() {
    let (l, p) = (2.4, 500.0);
    let structure = Structure {
        supports: vec![
            held(0, [true, true, true, false, false, true]),
            held(2, [true, true, false, false, false, false]),
        ],
        end: 1.into(),
        ..chain(
            &[[0.0; 3], [0.0, 0.0, 0.5 * l], [0.0, 0.0, l]],
            [1.0, 0.0, 0.0],
        )
    };
    // Along z with local y = x: local z = z × x = y, so a force along y bends about local y, against Iy.
    let load = [(Attachment::from(1), [0.0, p, 0.0, 0.0, 0.0, 0.0])];
    let response = solver(&structure).respond(&structure, &load);
    let ei = E * SECTION.iy_m4;
    assert_close(response.nodes[1][1], p * l.powi(3) / (48.0 * ei), TOLERANCE);
    assert_close(response.nodes[0][3], -p * l * l / (16.0 * ei), TOLERANCE);
    assert_close(response.nodes[2][3], p * l * l / (16.0 * ei), TOLERANCE);
    assert_close(response.reactions[0][1], -0.5 * p, TOLERANCE);
    let x = compliance(&structure).direct(0);
    assert_close(x, l.powi(3) / (48.0 * E * SECTION.iz_m4), TOLERANCE);
}

/// Roark table 8.1 case 1d, both ends clamped, load in the middle: δ = P L³/192 EI.
#[test]
fn beam_clamped_at_both_ends() {
    let l = 1.1;
    let structure = Structure {
        supports: vec![Support::clamped(0), Support::clamped(2)],
        end: 1.into(),
        ..chain(
            &[[0.0; 3], [0.5 * l, 0.0, 0.0], [l, 0.0, 0.0]],
            [0.0, 1.0, 0.0],
        )
    };
    let c = compliance(&structure);
    assert_close(c.direct(0), l / (4.0 * E * SECTION.area_m2), TOLERANCE);
    assert_close(
        c.direct(1),
        l.powi(3) / (192.0 * E * SECTION.iz_m4),
        TOLERANCE,
    );
    assert_close(
        c.direct(2),
        l.powi(3) / (192.0 * E * SECTION.iy_m4),
        TOLERANCE,
    );
}

/// ```text
///        P across the page at the tip
///   a    ●
///   ┌────┘ b
///   │
///   ▒
/// ```
/// Castigliano for the bent cantilever: δ = P a³/3EI + P b³/3EI + P b² a/GJ, a the clamped arm, which the tip twists by P b.
#[test]
fn bent_cantilever_bends_and_twists() {
    let (a, b) = (0.7, 0.45);
    let structure = chain(&[[0.0; 3], [0.0, 0.0, a], [b, 0.0, a]], [0.0, 1.0, 0.0]);
    // Local y is the direction of the load in both arms: bending against Iz.
    let ei = E * SECTION.iz_m4;
    let expected = a.powi(3) / (3.0 * ei) + b.powi(3) / (3.0 * ei) + b * b * a / (G * SECTION.j_m4);
    assert_close(compliance(&structure).direct(1), expected, TOLERANCE);
    // In the plane, along the first arm: the second arm bends, the first takes the moment b, and shortens.
    let ei = E * SECTION.iy_m4;
    let expected = b.powi(3) / (3.0 * ei) + b * b * a / ei + a / (E * SECTION.area_m2);
    assert_close(compliance(&structure).direct(2), expected, TOLERANCE);
}

/// Timoshenko's cantilever, δ = P L³/3EI + P L/k G A in each plane, in one piece and in three.
#[test]
fn timoshenko_cantilever() {
    let l = 0.2;
    let shear = ShearCoefficients {
        along_y: 0.44,
        along_z: 5.0 / 6.0,
    };
    let in_pieces = |places: &[f64]| {
        let places: Vec<[f64; 3]> = places.iter().map(|s| [s * l, 0.0, 0.0]).collect();
        let mut structure = chain(&places, [0.0, 1.0, 0.0]);
        for element in &mut structure.elements {
            element.shear = Some(shear);
        }
        structure
    };
    let ga = G * SECTION.area_m2;
    for structure in [in_pieces(&[0.0, 1.0]), in_pieces(&[0.0, 0.3, 0.55, 1.0])] {
        let c = compliance(&structure);
        let y = l.powi(3) / (3.0 * E * SECTION.iz_m4) + l / (0.44 * ga);
        let z = l.powi(3) / (3.0 * E * SECTION.iy_m4) + l / (5.0 / 6.0 * ga);
        assert_close(c.direct(1), y, TOLERANCE);
        assert_close(c.direct(2), z, TOLERANCE);
        // Shear adds nothing to the rotation a tip force gives.
        assert_close(c.0[5][1], l * l / (2.0 * E * SECTION.iz_m4), TOLERANCE);
    }
}

/// A portal of two columns of height `h` and a beam of span `l`, in the xy plane, feet attached as given.
fn portal(h: f64, l: f64, column: Section, girder: Section, feet: [Attachment; 2]) -> Structure {
    let [left, right] = feet;
    let out_of_plane = [0.0, 0.0, 1.0];
    let upright = |foot: Attachment, top: usize| Element {
        ends: [foot, top.into()],
        ..beam([0, 0], out_of_plane, inextensible(column))
    };
    Structure {
        nodes: vec![
            node("A", [0.0; 3]),
            node("B", [0.0, h, 0.0]),
            node("C", [l, h, 0.0]),
            node("D", [l, 0.0, 0.0]),
        ],
        elements: vec![
            upright(left, 1),
            beam([1, 2], out_of_plane, inextensible(girder)),
            upright(right, 2),
        ],
        supports: vec![Support::clamped(0), Support::clamped(3)],
        end: 1.into(),
        ..Structure::default()
    }
}

/// ```text
///   P ─▶B───────────C
///       │           │   h, span l, k = (I_BC/l)/(I_AB/h)
///       ▒A          ▒D
/// ```
/// Slope-deflection of the sway portal without axial deformation (Kleinlogel, Rigid Frame Formulas, frame with fixed feet):
/// base moments P h/2 · (3k + 1)/(6k + 1), sway P h³/12EI · (3k + 2)/(6k + 1).
#[test]
fn portal_with_fixed_feet() {
    let (h, l, p) = (3.0, 4.0, 8000.0);
    let girder = Section {
        iy_m4: 2.0 * SECTION.iy_m4,
        ..SECTION
    };
    let structure = portal(h, l, SECTION, girder, [0.into(), 3.into()]);
    let load = [(Attachment::from(1), [p, 0.0, 0.0, 0.0, 0.0, 0.0])];
    let response = solver(&structure).respond(&structure, &load);
    let k = 2.0 * h / l;
    let ei = E * SECTION.iy_m4;
    let sway = p * h.powi(3) / (12.0 * ei) * (3.0 * k + 2.0) / (6.0 * k + 1.0);
    assert_close(response.nodes[1][0], sway, INEXTENSIBLE);
    let base = 0.5 * p * h * (3.0 * k + 1.0) / (6.0 * k + 1.0);
    for reaction in &response.reactions {
        assert_close(reaction[0], -0.5 * p, INEXTENSIBLE);
        assert_close(reaction[5], base, INEXTENSIBLE);
    }
    // Columns pull and push with the couple that is left: P h - 2 M over the span.
    assert_close(
        response.reactions[1][1],
        (p * h - 2.0 * base) / l,
        INEXTENSIBLE,
    );
}

/// The same portal on pinned feet: sway P h³/12EI · (1 + 2k)/k, horizontal reactions P/2, no base moment.
#[test]
fn portal_with_pinned_feet() {
    let (h, l, p) = (3.0, 4.0, 8000.0);
    let mut structure = portal(h, l, SECTION, SECTION, [behind(0, 0), behind(3, 1)]);
    structure.hinges = vec![
        hinge("A", [0.0, 0.0, 1.0], 0.0),
        hinge("D", [0.0, 0.0, 1.0], 0.0),
    ];
    let load = [(Attachment::from(1), [p, 0.0, 0.0, 0.0, 0.0, 0.0])];
    let response = solver(&structure).respond(&structure, &load);
    let k = h / l;
    let sway = p * h.powi(3) / (12.0 * E * SECTION.iy_m4) * (1.0 + 2.0 * k) / k;
    assert_close(response.nodes[1][0], sway, INEXTENSIBLE);
    for reaction in &response.reactions {
        assert_close(reaction[0], -0.5 * p, INEXTENSIBLE);
        assert!(reaction[5].abs() < 1e-6 * p * h, "{reaction:?}");
    }
    // Each column turns about its foot by sway/h plus what bends: both feet alike.
    assert_close(response.hinges_rad[0], response.hinges_rad[1], INEXTENSIBLE);
}

/// ```text
///               P
///   ▒├──────────o──────────┤▒      o a pin: two cantilevers share the load
/// ```
/// δ = P a³/6EI with arms of length a; out of the plane of the pin the beam stays whole, P (2a)³/192EI.
#[test]
fn beam_with_a_pin_under_the_load() {
    let a = 0.9;
    let mut structure = Structure {
        hinges: vec![hinge("pin", [0.0, 0.0, 1.0], 0.0)],
        supports: vec![Support::clamped(0), Support::clamped(2)],
        end: 1.into(),
        ..chain(
            &[[0.0; 3], [a, 0.0, 0.0], [2.0 * a, 0.0, 0.0]],
            [0.0, 0.0, 1.0],
        )
    };
    structure.elements[1].ends[0].hinges = vec![0];
    let c = compliance(&structure);
    assert_close(
        c.direct(1),
        a.powi(3) / (6.0 * E * SECTION.iy_m4),
        TOLERANCE,
    );
    let whole = (2.0 * a).powi(3) / (192.0 * E * SECTION.iz_m4);
    assert_close(c.direct(2), whole, TOLERANCE);
}

/// ```text
///        P
///        ▼
///        o          two pinned bars at the angle α
///      /   \
///     o     o
/// ```
/// δ = P L/(2 E A sin²α), bars without bending.
#[test]
fn two_bar_truss() {
    let (l, alpha) = (1.3, 0.6_f64);
    let (sin, cos) = alpha.sin_cos();
    let z = [0.0, 0.0, 1.0];
    let places = [
        [-l * cos, 0.0, 0.0],
        [0.0, l * sin, 0.0],
        [l * cos, 0.0, 0.0],
    ];
    let mut structure = Structure {
        hinges: ["left", "apex", "right"]
            .map(|name| hinge(name, z, 0.0))
            .to_vec(),
        supports: vec![Support::clamped(0), Support::clamped(2)],
        end: 1.into(),
        ..chain(&places, z)
    };
    structure.elements[0].ends[0] = behind(0, 0);
    structure.elements[1].ends = [behind(1, 1), behind(2, 2)];
    let load = [(Attachment::from(1), [0.0, -1.0, 0.0, 0.0, 0.0, 0.0])];
    let response = solver(&structure).respond(&structure, &load);
    let expected = l / (2.0 * E * SECTION.area_m2 * sin * sin);
    assert_close(-response.nodes[1][1], expected, TOLERANCE);
    // Bars push with P/(2 sin α) and carry no moment in the plane.
    assert_close(response.elements[0].first[0], 0.5 / sin, TOLERANCE);
    assert!(response.elements[0].second[4].abs() < 1e-9 * l);
}

/// ```text
///   ▒∿────────────────● P      spring 1/c about z at the root
/// ```
/// A compliant joint at the root adds L² c to the tip in its plane, c to its rotation, L c to what couples them, and nothing else.
#[test]
fn compliant_joint_at_the_root() {
    let (l, c) = (0.75, 3.3e-5);
    let rigid = cantilever(l, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let mut compliant = rigid.clone();
    compliant.hinges = vec![hinge("root", [0.0, 0.0, 1.0], 1.0 / c)];
    compliant.elements[0].ends[0].hinges = vec![0];
    let (before, after) = (compliance(&rigid), compliance(&compliant));
    let mut expected = before;
    expected.0[1][1] += l * l * c;
    expected.0[5][5] += c;
    expected.0[1][5] += l * c;
    expected.0[5][1] += l * c;
    assert!(after.relative_difference(&expected) < TOLERANCE);
    // A joint whose stiffness is that of rock is rigid.
    compliant.hinges[0].stiffness_nm_per_rad = 1e15;
    assert!(compliance(&compliant).relative_difference(&before) < 1e-6);
}

/// A load behind a compliant joint at the end turns by c on its own.
#[test]
fn compliant_joint_at_the_end() {
    let (l, c) = (0.75, 3.3e-5);
    let mut structure = cantilever(l, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let before = compliance(&structure);
    structure.hinges = vec![hinge("hand", [0.0, 1.0, 0.0], 1.0 / c)];
    structure.end.hinges = vec![0];
    let mut expected = before;
    expected.0[4][4] += c;
    assert!(compliance(&structure).relative_difference(&expected) < TOLERANCE);
}

/// ```text
///           ●1──x      three members of 100 in meet at node 1, their other ends (2, 3, 4) are fixed:
///          /│          2 at -x, 3 at -z, 4 at -y of node 1
/// ```
/// Logan, A First Course in the Finite Element Method, space frame of three members (example 5.8 of the 4th and 5th editions):
/// E = 30 000 ksi, G = 10 000 ksi, A = 10 in², Iy = Iz = 100 in⁴, J = 50 in⁴; -50 kip along y and -1000 kip·in about x at node 1.
/// The solver is free of units as long as they agree: inch and kip here.
#[test]
fn logan_space_frame() {
    let section = Section {
        area_m2: 10.0,
        iy_m4: 100.0,
        iz_m4: 100.0,
        j_m4: 50.0,
    };
    let material = Material {
        youngs_modulus_pa: 30_000.0,
        shear_modulus_pa: 10_000.0,
    };
    let member = |ends, toward_y| Element {
        material,
        ..beam(ends, toward_y, section)
    };
    let structure = Structure {
        nodes: vec![
            node("1", [0.0; 3]),
            node("2", [-100.0, 0.0, 0.0]),
            node("3", [0.0, 0.0, -100.0]),
            node("4", [0.0, -100.0, 0.0]),
        ],
        elements: vec![
            member([1, 0], [0.0, 1.0, 0.0]),
            member([2, 0], [0.0, 1.0, 0.0]),
            member([3, 0], [1.0, 0.0, 0.0]),
        ],
        supports: vec![
            Support::clamped(1),
            Support::clamped(2),
            Support::clamped(3),
        ],
        end: 0.into(),
        ..Structure::default()
    };
    let load = [(Attachment::from(0), [0.0, -50.0, 0.0, -1000.0, 0.0, 0.0])];
    let found = solver(&structure).respond(&structure, &load).nodes[0];
    let printed = [7.098e-5, -0.014, -2.352e-3, -3.996e-3, 1.78e-5, -1.033e-4];
    let last_digit = [1e-8, 1e-3, 1e-6, 1e-6, 1e-7, 1e-7];
    for ((found, printed), digit) in found.into_iter().zip(printed).zip(last_digit) {
        assert!(
            (found - printed).abs() <= 0.5 * digit,
            "{found:e} for {printed:e}"
        );
    }
}

/// Global equilibrium of a space structure with three loads: reactions balance forces and moments about the origin.
#[test]
fn reactions_balance_the_loads() {
    let structure = Structure {
        supports: vec![
            Support::clamped(0),
            held(3, [true, true, true, false, false, false]),
        ],
        end: 1.into(),
        ..chain(
            &[[0.0; 3], [0.5, 0.8, 0.1], [1.2, 0.7, -0.3], [1.5, 0.1, 0.2]],
            [0.2, 0.3, 0.9],
        )
    };
    let loads: Vec<(Attachment, [f64; 6])> = vec![
        (1.into(), [10.0, -20.0, 5.0, 1.0, 2.0, -3.0]),
        (2.into(), [-4.0, 8.0, 15.0, -2.0, 0.5, 1.0]),
        (3.into(), [1.0, 2.0, 3.0, 0.3, -0.2, 0.1]),
    ];
    let response = solver(&structure).respond(&structure, &loads);
    let mut sum = [0.0; 6];
    let mut add = |node: usize, load: [f64; 6]| {
        let moment = cross(
            structure.nodes[node].position_m,
            [load[0], load[1], load[2]],
        );
        for i in 0..3 {
            sum[i] += load[i];
            sum[3 + i] += load[3 + i] + moment[i];
        }
    };
    for (at, load) in &loads {
        add(at.node, *load);
    }
    for (support, reaction) in structure.supports.iter().zip(&response.reactions) {
        add(support.node, *reaction);
    }
    assert!(sum.iter().all(|s| s.abs() < 1e-8), "{sum:?}");
}
