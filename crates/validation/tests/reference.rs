//! The reference of solids: the files for CalculiX are whole and hold the members they stand for; solved, they agree with beams where beams
//! are right.
//!
//! What needs CalculiX states it and is passed over where it is not installed (`apt-get install calculix-ccx`).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use stiffbench_beams::robot::{FittingFactors, JointModel, MechanismModel, Robot, Theory};
use stiffbench_beams::structure::{Element, Material, Node, Section, Solver, Structure, Support};
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_validation::reference::{
    ReferenceError, SolidModel, beams_of_the_prisms, end_displacement_m,
};

/// Steel, Pa.
const STEEL: Material = Material {
    youngs_modulus_pa: 210e9,
    shear_modulus_pa: 81e9,
};

fn node(name: &str, position_m: [f64; 3]) -> Node {
    Node {
        name: name.into(),
        position_m,
    }
}

/// What stands in a CalculiX file, read by its rules and not by those of the writer.
#[derive(Debug, Default)]
struct Deck {
    nodes: BTreeMap<usize, [f64; 3]>,
    /// Elements by set.
    elements: BTreeMap<String, Vec<Vec<usize>>>,
    sets: BTreeMap<String, Vec<usize>>,
    /// Node set, moving and turning node of each rigid body.
    bodies: Vec<[String; 3]>,
    held: Vec<usize>,
    youngs_mpa: BTreeMap<String, f64>,
    materials: BTreeMap<String, String>,
}

impl Deck {
    fn read(text: &str) -> Self {
        let mut deck = Self::default();
        let mut keyword = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        for line in text.lines().filter(|line| !line.starts_with("**")) {
            assert!(line.is_ascii() && line.len() <= 132, "{line}");
            let words: Vec<&str> = line.split(',').map(str::trim).collect();
            if line.starts_with('*') {
                keyword = words.iter().map(|word| (*word).to_owned()).collect();
                if keyword[0] == "*RIGID BODY" {
                    deck.bodies.push(
                        ["NSET=", "REF NODE=", "ROT NODE="].map(|name| value(&keyword, name)),
                    );
                } else if keyword[0] == "*SOLID SECTION" {
                    deck.materials
                        .insert(value(&keyword, "ELSET="), value(&keyword, "MATERIAL="));
                }
                continue;
            }
            assert!(words.len() <= 16, "CalculiX reads sixteen entries: {line}");
            assert!(words.iter().all(|word| word.len() <= 20), "{line}");
            let number = |place: usize| words[place].parse::<usize>().unwrap();
            let real = |place: usize| words[place].parse::<f64>().unwrap();
            match keyword[0].as_str() {
                "*NODE" => {
                    let known = deck.nodes.insert(number(0), [real(1), real(2), real(3)]);
                    assert_eq!(known, None, "node {} stands twice", number(0));
                }
                "*ELEMENT" => {
                    let continued = words.last() == Some(&"");
                    let entries = words.iter().filter(|word| !word.is_empty());
                    open.extend(entries.map(|word| word.parse::<usize>().unwrap()));
                    if !continued {
                        let set = value(&keyword, "ELSET=");
                        let element = std::mem::take(&mut open);
                        deck.elements.entry(set).or_default().push(element);
                    }
                }
                "*NSET" => {
                    let set = deck.sets.entry(value(&keyword, "NSET=")).or_default();
                    set.extend(words.iter().map(|word| word.parse::<usize>().unwrap()));
                }
                "*BOUNDARY" => {
                    assert_eq!(words[1..], ["1", "3"]);
                    deck.held.push(number(0));
                }
                "*ELASTIC" => {
                    let material = format!("MAT{}", deck.youngs_mpa.len() + 1);
                    deck.youngs_mpa.insert(material, real(0));
                }
                other => panic!("{other}: {line}"),
            }
        }
        deck
    }

    /// Volume of a member, mm³, from the corners of its elements, which are boxes.
    fn volume(&self, set: &str) -> f64 {
        let of = |element: &Vec<usize>| {
            let corner = |place: usize| self.nodes[&element[place]];
            let edge = |place: usize| {
                let (a, b) = (corner(1), corner(place));
                [0, 1, 2].map(|i| b[i] - a[i])
            };
            let (x, y, z) = (edge(2), edge(4), edge(5));
            let normal = stiffbench_numeric::vector::cross(y, x);
            -stiffbench_numeric::vector::dot(normal, z)
        };
        self.elements[set].iter().map(of).sum()
    }
}

fn value(keyword: &[String], name: &str) -> String {
    let found = keyword.iter().find_map(|word| word.strip_prefix(name));
    found.unwrap().to_owned()
}

#[test]
fn the_files_of_the_robot_are_whole() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (rigid, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let factors = FittingFactors::UNIT;
    let mut beams = MechanismModel::new(&robot, mechanism, &rigid, theory, &factors).unwrap();
    beams
        .place(robot.pose(&PoseId::new("P1")).unwrap())
        .unwrap();
    let names: Vec<&str> = beams.members().map(|member| member.name.as_str()).collect();
    let structure = beams.structure();
    let solids = SolidModel::new(structure, &names, 0.05).unwrap();
    let deck = Deck::read(&solids.deck(&["a title".to_owned()]));

    // Nodes of the mesh, and two for each joint.
    assert_eq!(deck.nodes.len(), solids.nodes() + 2 * structure.nodes.len());
    assert_eq!(deck.elements.len(), 36);
    let count: usize = deck.elements.values().map(Vec::len).sum();
    assert_eq!(count, solids.elements());
    let mut numbers = BTreeSet::new();
    for element in deck.elements.values().flatten() {
        assert_eq!(element.len(), 21);
        assert!(
            numbers.insert(element[0]),
            "element {} stands twice",
            element[0]
        );
        let of_element: BTreeSet<&usize> = element[1..].iter().collect();
        assert_eq!(of_element.len(), 20);
        assert!(of_element.iter().all(|node| deck.nodes.contains_key(node)));
    }
    // Every face moves with one joint, and the joint stands where the robot's node is.
    let mut moved = BTreeSet::new();
    for (body, node) in deck.bodies.iter().zip(&structure.nodes) {
        assert!(
            deck.sets[&body[0]]
                .iter()
                .all(|number| moved.insert(*number))
        );
        let place = deck.nodes[&body[1].parse().unwrap()];
        for (mm, m) in place.into_iter().zip(node.position_m) {
            assert!((mm - 1e3 * m).abs() < 1e-6);
        }
    }
    assert_eq!(deck.bodies.len(), structure.nodes.len());
    // Both nodes of every support are held.
    assert_eq!(deck.held.len(), 2 * structure.supports.len());
    // E times volume is EA times length, whatever became of shape and modulus.
    for (place, element) in structure.elements.iter().enumerate() {
        let set = format!("M{}", place + 1);
        let [a, b] = [0, 1].map(|end| structure.nodes[element.ends[end].node].position_m);
        let length = stiffbench_numeric::vector::norm(stiffbench_numeric::vector::subtract(b, a));
        let found = deck.youngs_mpa[&deck.materials[&set]] * deck.volume(&set);
        let expected = 1e3 * element.material.youngs_modulus_pa * element.section.area_m2 * length;
        // Coordinates are printed to 1e-6 mm, the thinnest element is 2 mm.
        assert!(
            (found / expected - 1.0).abs() < 2e-6,
            "{set}: {found} {expected}"
        );
    }
}

#[test]
fn what_cannot_be_meshed_is_refused_with_its_reason() {
    let good = cantilever();
    let code = |structure: &Structure, size_m: f64| {
        use miette::Diagnostic;
        let error = SolidModel::new(structure, &["beam"], size_m).unwrap_err();
        assert!(error.help().is_some());
        error.code().unwrap().to_string()
    };
    assert_eq!(code(&good, 0.0), "stiffbench::reference::size");
    assert_eq!(code(&good, f64::NAN), "stiffbench::reference::size");
    assert_eq!(code(&good, 1e-5), "stiffbench::reference::size");
    let mut rubber = good.clone();
    rubber.elements[0].material.shear_modulus_pa = STEEL.youngs_modulus_pa / 3.0;
    assert_eq!(code(&rubber, 0.02), "stiffbench::reference::poisson");
    let mut short = good.clone();
    short.nodes[1].position_m = short.nodes[0].position_m;
    assert_eq!(code(&short, 0.02), "stiffbench::reference::no_length");
    let mut half = good.clone();
    half.supports[0].held[3] = false;
    assert_eq!(code(&half, 0.02), "stiffbench::reference::support");
}

#[test]
fn the_answer_of_calculix_is_read_or_refused() {
    // As ccx 2.20 printed it.
    let text = "\n displacements (vx,vy,vz) for set ENDNODE and time  0.1000000E+01\n\n      4451 -2.622000E+00  1.500000E-03 -1.000000E-06\n";
    let found = end_displacement_m("a.dat", text).unwrap();
    assert!((found[0] + 2.622e-3).abs() < 1e-15 && (found[2] + 1e-9).abs() < 1e-20);
    // Of several increments the last counts; sets of others do not.
    let twice = format!("{}{}", text.replace("-2.622", "-1.0"), text);
    assert!((end_displacement_m("a.dat", &twice).unwrap()[0] + 2.622e-3).abs() < 1e-15);
    let other = text.replace("ENDNODE", "OTHER");
    for empty in [
        "",
        "\n\n",
        other.as_str(),
        text.split("4451").next().unwrap(),
    ] {
        let error = end_displacement_m("a.dat", empty).unwrap_err();
        assert!(matches!(error, ReferenceError::NoAnswer { .. }), "{error}");
    }
    let stopped = format!("{text}{}", text.replace("0.1000000E+01", "0.2500000E+00"));
    let error = end_displacement_m("a.dat", &stopped)
        .unwrap_err()
        .to_string();
    assert_eq!(error, "a.dat ends at 25.0 % of the load");
    for bad in ["NaN", "********", ""] {
        let bad = text.replace("-2.622000E+00", bad);
        let error = end_displacement_m("a.dat", &bad).unwrap_err().to_string();
        assert!(
            error.starts_with("a.dat:4: expected a node and three displacements"),
            "{error}"
        );
    }
}

/// A rectangular section, 30 mm along y and 50 mm along z.
fn rectangle() -> Section {
    let (y, z) = (0.03_f64, 0.05_f64);
    Section {
        area_m2: y * z,
        iy_m4: y * z.powi(3) / 12.0,
        iz_m4: z * y.powi(3) / 12.0,
        j_m4: 1e-7,
    }
}

fn member(ends: [usize; 2], section: Section) -> Element {
    Element {
        ends: ends.map(Into::into),
        toward_y: [1.0, 0.0, 0.0],
        section,
        material: STEEL,
        shear: None,
    }
}

/// ```text
///   ▒├──────────● 0.6 m along z
/// ```
fn cantilever() -> Structure {
    Structure {
        nodes: vec![node("root", [0.0; 3]), node("tip", [0.0, 0.0, 0.6])],
        elements: vec![member([0, 1], rectangle())],
        supports: vec![Support::clamped(0)],
        end: 1.into(),
        ..Structure::default()
    }
}

/// Displacement of the end per newton along each axis by CalculiX, m/N; `None` where it is not installed.
#[expect(clippy::print_stderr, reason = "a test that is skipped says so")]
fn by_calculix(structure: &Structure, size_m: f64) -> Option<[f64; 3]> {
    if Command::new("ccx").arg("-v").output().is_err() {
        eprintln!("skipped: CalculiX is not installed (apt-get install calculix-ccx)");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..structure.elements.len())
        .map(|i| format!("m{i}"))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let solids = SolidModel::new(structure, &names, size_m).unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    write("model.inp", solids.deck(&[]));
    Some([0, 1, 2].map(|axis| {
        write("case.inp", solids.case("model.inp", axis, 1000.0, false));
        ccx(folder.path());
        let text = std::fs::read_to_string(folder.path().join("case.dat")).unwrap();
        end_displacement_m("case.dat", &text).unwrap()[axis] / 1000.0
    }))
}

fn ccx(folder: &Path) {
    let ran = Command::new("ccx")
        .arg("case")
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stdout)
    );
}

/// The same by beams with the constants of the prisms, shear included.
fn by_beams(structure: &Structure) -> [f64; 3] {
    let structure = beams_of_the_prisms(structure);
    let mut solver = Solver::new(&structure).unwrap();
    solver.update(&structure).unwrap();
    let compliance = solver.end_translation_compliance();
    [0, 1, 2].map(|i| compliance[i][i])
}

fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (found, expected) in found.into_iter().zip(expected) {
        let off = found / expected - 1.0;
        assert!(
            off.abs() < tolerance,
            "{found:e} for {expected:e}: off by {off:e}"
        );
    }
}

/// Closed form, Timoshenko (Young, Budynas and Sadegh, Roark's Formulas, 8th edition, table 8.1 case 1a, and section 8.10 for shear):
/// F L³/3EI + 6 F L/5GA, and F L/EA along the axis. A clamped face restrains contraction over about a depth of section, a twelfth of this
/// beam, by a few percent of what that part adds, hence 1 %.
#[test]
fn a_solid_cantilever_agrees_with_beam_theory() {
    let structure = cantilever();
    let Some(coarse) = by_calculix(&structure, 0.05) else {
        return;
    };
    let fine = by_calculix(&structure, 0.0125).unwrap();
    let (l, section) = (0.6_f64, rectangle());
    let shear = 1.2 * l / (STEEL.shear_modulus_pa * section.area_m2);
    let bending = |i: f64| l.powi(3) / (3.0 * STEEL.youngs_modulus_pa * i);
    let axial = l / (STEEL.youngs_modulus_pa * section.area_m2);
    let expected = [
        bending(section.iz_m4) + shear,
        bending(section.iy_m4) + shear,
        axial,
    ];
    assert_near(by_beams(&structure), expected, 1e-9);
    assert_near(fine, expected, 1e-2);
    // Quadratic elements as long as the section is deep are there already: four times finer changes 0.3 %.
    assert_near(coarse, fine, 5e-3);
}

/// ```text
///      ├──────────● 0.5 m along z, a tube
///      │ 0.4 m along y, solid
///      ▒
/// ```
/// Out of its plane the load twists the post: a rectangle's torsion constant counts too.
#[test]
fn a_frame_of_solids_agrees_with_beams() {
    let tube = Section {
        area_m2: 0.04 * 0.06 - 0.03 * 0.05,
        iy_m4: (0.04 * 0.06_f64.powi(3) - 0.03 * 0.05_f64.powi(3)) / 12.0,
        iz_m4: (0.06 * 0.04_f64.powi(3) - 0.05 * 0.03_f64.powi(3)) / 12.0,
        j_m4: 1e-7,
    };
    let structure = Structure {
        nodes: vec![
            node("foot", [0.0; 3]),
            node("knee", [0.0, 0.4, 0.0]),
            node("end", [0.0, 0.4, 0.5]),
        ],
        elements: vec![member([0, 1], rectangle()), member([1, 2], tube)],
        supports: vec![Support::clamped(0)],
        end: 2.into(),
        ..Structure::default()
    };
    let Some(coarse) = by_calculix(&structure, 0.02) else {
        return;
    };
    let fine = by_calculix(&structure, 0.01).unwrap();
    // Restrained warping and contraction at six faces: beams are softer by up to 2 %.
    assert_near(fine, by_beams(&structure), 2e-2);
    assert_near(coarse, fine, 3e-3);
}
