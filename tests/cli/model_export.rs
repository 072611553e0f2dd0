//! `stiffbench robot export`: files for other programs, held to closed forms, to other commands and to what MuJoCo made of them.

use std::collections::BTreeMap;

use roxmltree::{Document, Node};
use serde_json::Value;

use super::desk;
use crate::support::{Contains, Json};
use stiffbench_test_files::text;

/// Elements of a name with an attribute of this value.
fn named<'a>(document: &'a Document<'a>, element: &str, name: &str) -> Node<'a, 'a> {
    let mut all = document.descendants();
    all.find(|node| node.has_tag_name(element) && node.attribute("name") == Some(name))
        .unwrap_or_else(|| panic!("there is no {element} {name}"))
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split_whitespace();
    words.map(|word| word.parse().unwrap()).collect()
}

fn attribute(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// The text of an element below another.
fn child<'a>(node: Node<'a, 'a>, name: &str) -> &'a str {
    let mut below = node.descendants();
    let found = below.find(|node| node.has_tag_name(name));
    found.and_then(|node| node.text()).unwrap()
}

fn near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}");
}

const LAWS: &str = "--effect joint-friction@S2:c=20urad/(N*m),friction_moment=3N*m --effect joint-backlash@S3:play=0.1mrad,seat_moment=1N*m --effect base-compliance@x:c=0.5urad/(N*m)";

#[test]
fn mujoco_gets_the_springs_of_beams_joints_and_base_with_friction_and_play() {
    let arguments =
        format!("robot export serial-arm --format mjcf --factors unit --pose P1 {LAWS}");
    let printed = desk().run(&arguments).succeeds().stdout;
    let document = Document::parse(&printed).unwrap();
    let stiffness = |name: &str| attribute(named(&document, "joint", name), "stiffness");
    // The pedestal: E A/L, 12 E I/L³, G J/L, E I/L at 0.15 m.
    near(stiffness("member.E12.x"), 206e9 * 2.4e-3 / 0.15);
    near(
        stiffness("member.E12.y"),
        12.0 * 206e9 * 2.05e-6 / 0.15_f64.powi(3),
    );
    near(stiffness("member.E12.rx"), 79e9 * 4e-6 / 0.15);
    near(stiffness("member.E12.rz"), 206e9 * 2.05e-6 / 0.15);
    near(stiffness("base.rx.law"), 2e6);
    near(stiffness("joint.S2.law1"), 5e4);
    near(
        attribute(named(&document, "joint", "joint.S2.law1"), "frictionloss"),
        3.0,
    );
    let play = named(&document, "joint", "joint.S3.law1");
    assert_eq!(play.attribute("range"), Some("-0.0001 0.0001"));
    assert_eq!(play.attribute("stiffness"), None);
    printed.must_contain(&["0.0001 rad, no interval"]);
    assert!(!printed.contains("99999999"), "{printed}");
    // Seven beams with six springs each, two laws, one spring of the base.
    let joints = document
        .descendants()
        .filter(|node| node.has_tag_name("joint") && node.attribute("name").is_some());
    assert_eq!(joints.count(), 7 * 6 + 3);
}

#[test]
fn sdf_and_urdf_hold_joints_with_limits_springs_and_friction() {
    let desk = desk();
    let export = |form: &str| {
        let arguments = format!("robot export serial-arm --format {form} --pose P1 {LAWS}");
        desk.run(&arguments).succeeds().stdout
    };
    let poses = desk.data("robot show serial-arm");
    let theta1 = poses["poses"][0]["angles_deg"]["theta1"]
        .as_f64()
        .unwrap_or(0.0);
    let ends = [-90.0, 90.0].map(|end: f64| (end - theta1).to_radians());

    let urdf = export("urdf");
    let document = Document::parse(&urdf).unwrap();
    let joint = |name: &str| named(&document, "joint", name);
    let below = |node: Node<'_, '_>, name: &str, attribute: &str| {
        let mut below = node.children();
        let found = below.find(|node| node.has_tag_name(name)).unwrap();
        found.attribute(attribute).unwrap().to_owned()
    };
    let s1 = joint("S1");
    assert_eq!(s1.attribute("type"), Some("revolute"));
    for (name, end) in ["lower", "upper"].into_iter().zip(ends) {
        near(below(s1, "limit", name).parse().unwrap(), end);
    }
    assert_eq!(below(s1, "axis", "xyz"), "0 1 0");
    // It turns as the difference of two variables does: no limit of its own.
    assert_eq!(joint("S3").attribute("type"), Some("continuous"));
    assert_eq!(below(joint("S2"), "dynamics", "friction"), "3");
    let links = document
        .descendants()
        .filter(|node| node.has_tag_name("link"));
    let children = document
        .descendants()
        .filter(|node| node.has_tag_name("child"));
    assert_eq!(
        children.count() + 1,
        links.count(),
        "a tree: every link but the world is a child"
    );

    let sdf = export("sdf");
    let document = Document::parse(&sdf).unwrap();
    let s2 = named(&document, "joint", "S2");
    assert_eq!(child(s2, "spring_stiffness"), "50000");
    assert_eq!(child(s2, "friction"), "3");
    assert_eq!(
        numbers(child(named(&document, "joint", "S1"), "lower")).len(),
        1
    );
}

#[test]
fn loops_are_welded_kept_or_named() {
    let desk = desk();
    let export = |form: &str| {
        let run = desk.run(&format!(
            "robot export --format {form} --mechanism F --pose P1"
        ));
        run.succeeds().stdout
    };
    let (mjcf, sdf, urdf) = (export("mjcf"), export("sdf"), export("urdf"));
    let count = |text: &str, element: &str| {
        let document = Document::parse(text).unwrap();
        document
            .descendants()
            .filter(|node| node.has_tag_name(element))
            .count()
    };
    let show = desk.data("robot show --mobility");
    let rows = show["mechanisms"].list();
    let of_f = rows.iter().find(|row| row["mechanism"] == "F").unwrap();
    let loops = of_f["rank_check"]["loops"].as_u64().unwrap() as usize;
    assert_eq!(urdf.matches("URDF holds no loops").count(), loops);
    // One joint more, between world and ground.
    let joints = of_f["rank_check"]["joints"].as_u64().unwrap() as usize;
    assert_eq!(count(&sdf, "joint"), joints + 1);
    assert!(count(&mjcf, "weld") >= loops, "each loop is cut");
}

#[test]
fn the_table_holds_the_intervals_of_a_fit_and_the_compliance_of_the_robot() {
    let desk = desk();
    desk.run("simulate session --seed 4").succeeds();
    let fit = desk.run("fit session --json").succeeds().stdout;
    desk.write("fit.json", &fit);
    let fit: Value = serde_json::from_str(&fit).unwrap();
    let csv = desk
        .run("robot export --format csv --fit fit.json --pose P3")
        .succeeds()
        .stdout;
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    let row = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap();
    let fitted = &fit["data"]["parameters"];
    let iy = fitted.named("beam.Iy");
    let found = row("beam.Iy");
    assert_eq!(found["status"], "free");
    for (key, expected) in [
        ("value", &iy["value"]),
        ("ci95_low", &iy["ci95"][0]),
        ("ci95_high", &iy["ci95"][1]),
    ] {
        near(found[key].parse().unwrap(), expected.number());
    }
    desk.run("fit session --save-factors fitted.toml")
        .succeeds();
    let compliance = desk.data("robot compliance --pose P3 --factors fitted.toml");
    let entry = compliance["compliance"][1][3].number();
    let found = row("compliance.uy.Mx");
    assert_eq!(found["unit"], "m/(N*m)");
    assert_eq!(found["pose"], "P3");
    assert!((found["value"].parse::<f64>().unwrap() / entry - 1.0).abs() < 1e-9);
    let json = desk
        .run("robot export --format json --fit fit.json")
        .succeeds();
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["poses"].list().len(), 4);
    let of = |list: &Value| list.named("beam.Iy")["ci95"][1].number();
    near(of(&json["parameters"]), of(fitted));
}

/// Inertia tensor of each body of a file, kg·m², as it is written.
fn inertias(form: &str, document: &Document<'_>) -> Vec<[[f64; 3]; 3]> {
    let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
    let elements = document.descendants().filter_map(|node| {
        let moments: Vec<f64> = match (form, node.tag_name().name()) {
            ("mjcf", "inertial") => numbers(node.attribute("fullinertia")?),
            ("urdf", "inertia") => names.map(|name| attribute(node, name)).into(),
            ("sdf", "inertia") => names.map(|name| child(node, name).parse().unwrap()).into(),
            _ => return None,
        };
        let [xx, yy, zz, xy, xz, yz] = moments.try_into().unwrap();
        Some([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    });
    elements.collect()
}

/// All principal moments are positive and each is less than the sum of the others: then trace/2 - I is positive definite, by leading minors.
fn is_of_a_body(inertia: [[f64; 3]; 3]) -> bool {
    let half = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 2.0;
    let mut m = inertia.map(|row| row.map(|x| -x));
    (0..3).for_each(|i| m[i][i] += half);
    let minor = |i: usize, j: usize, k: usize, l: usize| m[i][j] * m[k][l] - m[i][l] * m[k][j];
    let whole =
        m[0][0] * minor(1, 1, 2, 2) - m[0][1] * minor(1, 0, 2, 2) + m[0][2] * minor(1, 0, 2, 1);
    m[0][0] > 0.0 && minor(0, 0, 1, 1) > 0.0 && whole > 0.0
}

/// Robots that `tests/robots/random_robots.py` made.
const RANDOM_ROBOTS: [&str; 6] = ["1", "2", "4", "10", "11", "13"];

#[test]
fn bodies_weigh_what_the_robot_file_says_and_placeholders_next_to_nothing() {
    let desk = desk();
    // Beams behind slides change their length: `robot check` states the largest mass of all poses.
    let mut robots: Vec<(String, &str)> = [
        ("franka-panda", "P1"),
        ("fanuc-r2000ic", "P1"),
        ("scara", "P4"),
        ("gantry", "P3"),
        ("four-bar", "P1"),
        ("hp-robot", "P1"),
        ("serial-arm", "P1"),
    ]
    .map(|(robot, pose)| (robot.to_owned(), pose))
    .into();
    robots.extend(RANDOM_ROBOTS.map(|number| {
        let file = format!("robot-{number}.toml");
        desk.write(&file, text(&format!("fixtures/cases/random-robots/{file}")));
        (file, "P1")
    }));
    for (robot, pose) in robots {
        let check = desk.data(&format!("robot check {robot}"));
        let kg = check["mass_kg"].as_f64().unwrap_or(0.0);
        for form in ["mjcf", "urdf", "sdf"] {
            let line = format!("robot export {robot} --format {form} --pose {pose}");
            let run = desk.run(&line).succeeds();
            let document = Document::parse(&run.stdout).unwrap();
            let masses = document.descendants().filter_map(|node| {
                let text = match (form, node.tag_name().name()) {
                    ("mjcf", "inertial") => node.attribute("mass"),
                    ("urdf", "mass") => node.attribute("value"),
                    ("sdf", "mass") => node.text(),
                    _ => None,
                };
                text.map(|text| text.parse::<f64>().unwrap())
            });
            let sum: f64 = masses.sum();
            assert!((sum - kg).abs() < 1e-6 * kg.max(1e-3), "{line}: {sum} {kg}");
            let inertias = inertias(form, &document);
            assert!(inertias.len() > 1, "{line}");
            let odd = inertias.iter().find(|inertia| !is_of_a_body(**inertia));
            assert_eq!(odd, None, "{line}");
            let shape = if form == "mjcf" { "geom" } else { "cylinder" };
            let mut shapes = document.descendants();
            assert!(shapes.any(|node| node.has_tag_name(shape)), "{line}");
            let marked = run.stdout.matches("placeholder: the robot file").count();
            assert_eq!(marked > 0, run.stderr.contains("placeholder"), "{line}");
            assert!(marked > 0 || robot != "hp-robot", "{line}");
        }
    }
}

/// What MuJoCo found, and for which files: `tests/mujoco/check.py --write`.
#[test]
fn mujoco_moves_as_the_compliance_says() {
    let kept: Value = serde_json::from_str(text("fixtures/mujoco/displacements.json")).unwrap();
    let force_n = kept["force_N"].number();
    let cases: BTreeMap<String, Vec<String>> =
        serde_json::from_str(text("fixtures/mujoco/cases.json")).unwrap();
    assert!(cases.len() >= 5);
    for (name, arguments) in cases {
        let desk = desk();
        desk.write("springs.json", text("fixtures/mujoco/springs.json"));
        let line = format!("robot export {}", arguments.join(" "));
        let now = desk.run(&format!("{line} --format mjcf")).succeeds().stdout;
        same_model(&now, text(&format!("fixtures/mujoco/{name}.xml")));
        for axis in 0..3 {
            let compliance = if arguments.iter().any(|word| word == "--fit") {
                let table = desk.run(&format!("{line} --format json")).succeeds().stdout;
                let table: Value = serde_json::from_str(&table).unwrap();
                table["poses"][0].clone()
            } else {
                let mut force = [0.0; 3];
                force[axis] = force_n;
                let [x, y, z] = force;
                let all = arguments.join(" ");
                desk.data(&format!("robot compliance {all} --load={x},{y},{z}"))
            };
            let (mut apart, mut length) = (0.0, 0.0);
            for i in 0..3 {
                let ours = force_n * compliance["compliance"][i][axis].number();
                let found = kept["displacement_m"][&name][axis][i].number();
                apart += (found - ours).powi(2);
                length += ours.powi(2);
            }
            let share = f64::sqrt(apart / length);
            assert!(share < 0.01, "{name}, force along {axis}: {share}");
        }
    }
}

/// Two files are the same but for rounding and the version in the first comment.
fn same_model(now: &str, kept: &str) {
    let elements = |text: &str| -> Vec<(String, Vec<(String, String)>)> {
        let document = Document::parse(text).unwrap();
        let all = document.descendants().filter(Node::is_element);
        let of = |node: Node<'_, '_>| {
            let attributes = node.attributes();
            let attributes = attributes.map(|a| (a.name().to_owned(), a.value().to_owned()));
            (node.tag_name().name().to_owned(), attributes.collect())
        };
        all.map(of).collect()
    };
    let (now, kept) = (elements(now), elements(kept));
    assert_eq!(now.len(), kept.len(), "tests/mujoco/check.py --write");
    for (now, kept) in now.iter().zip(&kept) {
        assert_eq!(now.0, kept.0);
        for ((name, now), (kept_name, kept)) in now.1.iter().zip(&kept.1) {
            assert_eq!(name, kept_name);
            let pairs = now.split(' ').zip(kept.split(' '));
            for (now, kept) in pairs {
                let same = match (now.parse::<f64>(), kept.parse::<f64>()) {
                    (Ok(now), Ok(kept)) => (now - kept).abs() <= 1e-9 * kept.abs().max(1e-6),
                    _ => now == kept,
                };
                assert!(
                    same,
                    "{name}: {now}, kept {kept}: tests/mujoco/check.py --write"
                );
            }
        }
    }
}
