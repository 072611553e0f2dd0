//! Spread forces and own weight against closed forms and against OpenSees.

use crate::support::rows::{number, numbers, pose_of, rows};
use crate::support::{SECTION, STEEL, chain, held, solver};
use stiffbench_beams::robot::{
    FittingFactors, GRAVITY_M_PER_S2, JointModel, Masses, MechanismModel, Predictor, Robot, Theory,
};
use stiffbench_beams::structure::{ShearCoefficients, Structure, Support};
use stiffbench_numeric::vector::norm;
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::source_text::SourceText;

/// ```text
///   ▒├────────────────●   w along the whole length
/// ```
fn cantilever(length_m: f64, pieces: usize) -> Structure {
    let place = |i: usize| [length_m * i as f64 / pieces as f64, 0.0, 0.0];
    chain(
        &(0..=pieces).map(place).collect::<Vec<_>>(),
        [0.0, 1.0, 0.0],
    )
}

/// Displacement of the end under a force spread over all elements.
fn spread(structure: &Structure, w: [f64; 3]) -> [f64; 6] {
    let loads: Vec<_> = (0..structure.elements.len())
        .flat_map(|element| structure.spread_force(element, w))
        .collect();
    solver(structure).respond(structure, &loads).nodes[structure.end.node]
}

/// Roark, 8th edition, table 8.1, case 2a with a = 0: v = w L⁴/8EI, θ = w L³/6EI at the tip; along the axis u = w L²/2EA. One element
/// has it to rounding, and so have three.
#[test]
fn a_cantilever_under_its_own_weight() {
    let (l, w) = (1.7, 120.0);
    let e = STEEL.youngs_modulus_pa;
    for pieces in [1, 3] {
        let across = spread(&cantilever(l, pieces), [0.0, -w, 0.0]);
        let (v, turn) = (
            w * l.powi(4) / (8.0 * e * SECTION.iz_m4),
            w * l.powi(3) / (6.0 * e * SECTION.iz_m4),
        );
        assert!((across[1] / -v - 1.0).abs() < 1e-9, "{across:?} {v}");
        assert!((across[5] / -turn - 1.0).abs() < 1e-9, "{across:?} {turn}");
        let hanging = spread(&cantilever(l, pieces), [w, 0.0, 0.0]);
        let u = w * l * l / (2.0 * e * SECTION.area_m2);
        assert!((hanging[0] / u - 1.0).abs() < 1e-9, "{hanging:?} {u}");
    }
}

/// With shear deformation w L²/2κGA comes on top: w L/κGA for the resultant, half of it for a spread force.
#[test]
fn shear_deformation_under_a_spread_force() {
    let (l, w) = (0.4, 120.0);
    let mut structure = cantilever(l, 1);
    structure.elements[0].shear = Some(ShearCoefficients {
        along_y: 0.5,
        along_z: 0.9,
    });
    let bending = w * l.powi(4) / (8.0 * STEEL.youngs_modulus_pa * SECTION.iz_m4);
    let shear = w * l * l / (2.0 * 0.5 * STEEL.shear_modulus_pa * SECTION.area_m2);
    assert!(shear > 0.05 * bending, "it is to be seen");
    let found = spread(&structure, [0.0, w, 0.0])[1];
    assert!((found / (bending + shear) - 1.0).abs() < 1e-9, "{found}");
}

/// ```text
///   ▒├────────●────────┤▒   v = w L⁴/384EI in the middle        (Roark table 8.1, 2d)
///   ▒├─────────────────△   R = 3 w L/8 where it rests           (2c)
/// ```
#[test]
fn beams_held_at_both_ends() {
    let (l, w) = (1.6, 90.0);
    let mut structure = cantilever(l, 2);
    structure.supports.push(Support::clamped(2));
    structure.end = 1.into();
    let middle = w * l.powi(4) / (384.0 * STEEL.youngs_modulus_pa * SECTION.iz_m4);
    let found = spread(&structure, [0.0, -w, 0.0])[1];
    assert!((found / -middle - 1.0).abs() < 1e-9, "{found} {middle}");
    let mut rests = cantilever(l, 1);
    rests
        .supports
        .push(held(1, [false, true, false, false, false, false]));
    let loads = rests.spread_force(0, [0.0, -w, 0.0]).to_vec();
    let reaction = solver(&rests).respond(&rests, &loads).reactions[1][1];
    assert!(
        (reaction / (0.375 * w * l) - 1.0).abs() < 1e-9,
        "{reaction}"
    );
}

/// The reaction of the support is the whole weight, and its moment the weight at half the length.
#[test]
fn reactions_carry_the_weight() {
    let structure = cantilever(2.0, 1);
    let loads = structure.spread_force(0, [0.0, -50.0, 7.0]).to_vec();
    let reaction = solver(&structure).respond(&structure, &loads).reactions[0];
    let expected = [0.0, 100.0, -14.0, 0.0, 14.0, 100.0];
    for (found, expected) in reaction.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{reaction:?}");
    }
}

const ARM: &str = r#"
format = "planar-linkage-robot/1"
name = "level arm"
elements = [{ id = "OT", nodes = ["O", "T"], chain = "a", class = "beam", section = "tube", body = "arm", plane = "upright" }]
bodies = [{ id = "ground" }, { id = "arm", parent = "ground", origin = "O", axis = [-1.0, 0.0, 0.0], angle = { lift = 1.0 } }]
[variables.lift]
min = -90.0
max = 90.0
nominal = 0.0
[planes.upright]
body = "ground"
normal = [1.0, 0.0, 0.0]
[nodes]
O = { on = "ground", at = [0.0, 0.0, 0.0] }
T = { on = "arm", at = [0.0, 0.0, 1.5] }
[support]
fixed = ["O"]
[end]
node = "T"
[materials.steel]
E = 210.0e9
G = 81.0e9
[sections.tube]
material = "steel"
A = 1.0e-3
Iy = 5.0e-7
Iz = 5.0e-7
J = 1.0e-6
[mechanisms.A]
chains = ["a"]
[poses.lifted]
lift = 30.0
"#;

fn robot(text: &str) -> Robot {
    Robot::parse(&SourceText::new("arm.toml", text.to_owned())).unwrap()
}

/// Sag of the end in a pose, m.
fn sag(robot: &Robot, pose: usize) -> [f64; 3] {
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor = Predictor::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
    predictor.place(&robot.poses[pose].pose).unwrap();
    let (solver, model) = predictor.parts();
    let [x, y, z, ..] =
        solver.respond(model.structure(), &model.weight()).nodes[model.structure().end.node];
    [x, y, z]
}

/// Across the arm its weight bends by w L⁴ cos α/8EI and a tool by m g L³ cos α/3EI; both push along it.
#[test]
fn density_mass_per_length_and_tool_give_the_stated_weight() {
    let (l, ei, ea): (f64, f64, f64) = (1.5, 210e9 * 5e-7, 210e9 * 1e-3);
    let alpha = 30_f64.to_radians();
    let g = GRAVITY_M_PER_S2;
    let expected = |w: f64, tool: f64| {
        let across = alpha.cos() * (w * l.powi(4) / (8.0 * ei) + tool * l.powi(3) / (3.0 * ei));
        let along = alpha.sin() * (w * l * l / (2.0 * ea) + tool * l / ea);
        // Down and forward across the arm, back along it.
        [
            0.0,
            -across * alpha.cos() - along * alpha.sin(),
            across * alpha.sin() - along * alpha.cos(),
        ]
    };
    let dense = ARM.replace("G = 81.0e9", "G = 81.0e9\ndensity = 7850.0");
    let stated = dense.replace("J = 1.0e-6", "J = 1.0e-6\nmass_per_m = 10.0");
    let with_tool = stated.replace("[mechanisms.A]", "[masses]\nT = 4.0\n[mechanisms.A]");
    for (text, w, tool) in [
        (&dense, 7.85 * g, 0.0),
        (&stated, 10.0 * g, 0.0),
        (&with_tool, 10.0 * g, 4.0 * g),
    ] {
        let found = sag(&robot(text), 0);
        let expected = expected(w, tool);
        let error = norm([0, 1, 2].map(|i| found[i] - expected[i])) / norm(expected);
        assert!(error < 1e-9, "{found:?} {expected:?}");
    }
    let robot = robot(&with_tool);
    let mechanism = robot.mechanism(None).unwrap();
    let masses = Masses::of(&robot, mechanism);
    assert_eq!(masses.weighed, ["tube"]);
    assert_eq!(masses.at_nodes, [("T".to_owned(), 4.0)]);
    let mut model = MechanismModel::new(
        &robot,
        mechanism,
        &JointModel::Rigid,
        Theory::EulerBernoulli,
        &FittingFactors::UNIT,
    )
    .unwrap();
    model.place(&robot.poses[0].pose).unwrap();
    assert!((model.mass_kg() - 19.0).abs() < 1e-12);
}

/// All that `fixtures/opensees/generate_weight.py` gives the robot: 7850 kg/m3 and masses at A4, F6 and F8.
fn heavy_robot() -> Robot {
    let text = shipped_robot("hp-robot").unwrap().text;
    assert_eq!(text.matches("\nG = ").count(), 1, "one material");
    let dense = text.replace("\nG = ", "\ndensity = 7850.0\nG = ");
    robot(&format!(
        "{dense}\n[masses]\nA4 = 18.5\nF6 = 3.25\nF8 = 12.0\n"
    ))
}

/// OpenSees spreads the weight over its elements itself, from another reader's kinematics. It keeps 2.3e-10 of the compliance here
/// (agreement.csv), and displacements are sums of products with it: 1e-8, as for the compliance itself.
#[test]
fn the_sag_of_all_mechanisms_against_opensees() {
    let robot = heavy_robot();
    let rows = rows("opensees/weight.csv");
    assert_eq!(rows.len(), 63);
    let mut largest = 0.0_f64;
    for row in &rows {
        let mechanism = robot.mechanism(Some(&row["mechanism"])).unwrap();
        let factors = robot.factor_set(&row["factors"]).unwrap();
        let mut predictor = Predictor::new(&robot, mechanism, &factors).unwrap();
        predictor.place(&pose_of(row, &robot)).unwrap();
        let (solver, model) = predictor.parts();
        let found = solver.respond(model.structure(), &model.weight());
        let end = found.nodes[model.structure().end.node];
        for keys in [["ux", "uy", "uz"], ["rx", "ry", "rz"]] {
            let expected = numbers(row, keys);
            let first = usize::from(keys[0] == "rx") * 3;
            let error = norm([0, 1, 2].map(|i| end[first + i] - expected[i])) / norm(expected);
            largest = largest.max(error);
            assert!(error < 1e-8, "{row:?}: {error:e}");
        }
        assert!((model.mass_kg() / number(row, "mass_kg") - 1.0).abs() < 1e-13);
        let carried: f64 = found.reactions.iter().map(|reaction| reaction[1]).sum();
        assert!((carried / number(row, "reaction_N") - 1.0).abs() < 1e-8);
    }
    println!("largest difference {largest:e}");
}

/// Weight acts against the vertical of the file, whatever its length.
#[test]
fn weight_acts_against_the_vertical() {
    let text = ARM.replace("G = 81.0e9", "G = 81.0e9\ndensity = 7850.0");
    let upright = sag(&robot(&text), 0);
    let turned = text.replace(
        "[planes.upright]",
        "[frame]\nvertical = [2.0, 0.0, 0.0]\n[planes.upright]",
    );
    let turned = sag(&robot(&turned), 0);
    assert!(upright[1] < 0.0 && upright[0].abs() < 1e-15);
    assert!(turned[0] < 0.0 && turned[1].abs() < 1e-15 && turned[2].abs() < 1e-15);
}

#[test]
fn a_robot_without_masses_lists_the_massless_elements() {
    let robot = robot(ARM);
    let masses = Masses::of(&robot, robot.mechanism(None).unwrap());
    assert!(masses.is_empty());
    assert_eq!(masses.unweighed, ["tube"]);
    assert_eq!(sag(&robot, 0), [0.0; 3]);
}

/// Impossible masses are refused where they stand.
#[test]
fn masses_below_zero_and_at_unknown_nodes_are_refused() {
    #[rustfmt::skip]
    let cases = [
        ("J = 1.0e-6", "J = 1.0e-6\nmass_per_m = -1.0", "mass_per_m of section tube"),
        ("G = 81.0e9", "G = 81.0e9\ndensity = 0.0", "density of material steel"),
        ("[mechanisms.A]", "[masses]\nT = -4.0\n[mechanisms.A]", "the mass at T"),
        ("[mechanisms.A]", "[masses]\nX = 4.0\n[mechanisms.A]", "X"),
    ];
    for (find, replacement, complaint) in cases {
        let text = ARM.replace(find, replacement);
        let error = Robot::parse(&SourceText::new("arm.toml", text)).unwrap_err();
        assert!(error.to_string().contains(complaint), "{error}");
    }
}
