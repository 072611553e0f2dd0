//! Files of the format `stiffbench/robot/2`: what they mean, and that what is wrong is said where it stands.

use std::fmt::Write as _;

use stiffbench_beams::robot::{JointMotion, Predictor, Robot, RobotError, RoleInFit, Yielding};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::Direction;

use crate::support::marked;
use crate::support::robots::{at_values, predictor, shipped};

const ARM: &str = r#"schema = "stiffbench/robot/2"
name = "arm"
up = "z"
[parameters]
h_mm = 400
[joints]
J1 = { at_mm = [0, 0, "h"], axis = "z", min_deg = -90, max_deg = 90, spring = "free", stiffness_kNm_per_rad = 200 }
J2 = { at_mm = [100, 0, 0], axis = "-y", min_deg = -90, max_deg = 90, stiffness_Nm_per_rad = 1e5, link = "tube 60x5 aluminium", groups = ["arm"] }
J3 = { kind = "sliding", at_mm = [500, 0, 0], axis = "x", min_mm = 0, max_mm = 200, nominal_mm = 50, spring = "free" }
[tool]
at_mm = [100, 0, -20]
[masses]
hand = { mass_kg = 2, on = "J3", at_mm = [40, 0, 0] }
[poses]
P1 = { J2_deg = 30, J3_mm = 100 }
P2 = [10, 0.5235987755982988, 0.1]
"#;

fn parse(text: &str) -> Result<Robot, RobotError> {
    Robot::parse(&SourceText::new("arm.toml", text))
}

fn tool(robot: &Robot, values: &[f64]) -> [f64; 3] {
    robot.tool_pose(&at_values(values)).unwrap().position_m
}

#[test]
fn a_base_may_rock_about_all_axes_but_a_vertical_y() {
    let axes = |text: &str| parse(text).unwrap().rocking_axes().collect::<Vec<_>>();
    assert_eq!(axes(ARM), Direction::ALL);
    let y_up = ARM.replace("up = \"z\"", "up = \"y\"");
    assert_eq!(axes(&y_up), [Direction::X, Direction::Z]);
    assert!(
        shipped("hp-robot")
            .rocking_axes()
            .eq([Direction::X, Direction::Z])
    );
}

#[track_caller]
fn near(found: [f64; 3], expected: [f64; 3]) {
    for i in 0..3 {
        assert!(
            (found[i] - expected[i]).abs() < 1e-12,
            "{found:?} is not {expected:?}"
        );
    }
}

#[test]
fn a_serial_arm_in_twenty_lines() {
    let robot = parse(ARM).unwrap();
    assert_eq!(robot.warnings, Vec::<String>::new());
    assert_eq!(robot.vertical, [0.0, 0.0, 1.0]);
    assert_eq!(robot.poses[0].pose.angles_deg, [0.0, 30.0, 0.1]);
    assert_eq!(robot.variables[2].motion, JointMotion::Slides);
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let reach = 0.5 + 0.1 + 0.1;
    near(
        tool(&robot, &[0.0, 30.0, 0.1]),
        [
            0.1 + reach * cos + 0.02 * sin,
            0.0,
            0.4 + reach * sin - 0.02 * cos,
        ],
    );
    near(tool(&robot, &[90.0, 0.0, 0.0]), [0.0, 0.7, 0.38]);
    let springs: Vec<_> = robot
        .own_springs()
        .map(|(p, s)| (p.to_string(), s.clone()))
        .collect();
    let names: Vec<&str> = springs.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["joint.J1", "joint.J2", "joint.J3.along"]);
    assert_eq!(springs[0].1.yielding, Yielding::Compliance(5e-6));
    assert_eq!(springs[0].1.in_fit, RoleInFit::Free);
    assert_eq!(springs[1].1.in_fit, RoleInFit::Fixed);
    assert_eq!(springs[2].1.yielding, Yielding::Compliance(0.0));
}

/// Two springs and rigid links: δ = J K⁻¹ Jᵀ F with the levers of the joints.
#[test]
fn springs_give_the_compliance_of_the_virtual_joint_method() {
    let text = ARM.replace(", link = \"tube 60x5 aluminium\", groups = [\"arm\"]", "");
    let robot = parse(&text).unwrap();
    let c = predictor(&robot, &robot.poses[0].pose).translation_compliance();
    let end = tool(&robot, &robot.poses[0].pose.angles_deg);
    // About z through the origin the tool moves along y; about -y through the second joint along z × … in the plane.
    let first = [0.0, end[0], 0.0];
    let arm = [end[0] - 0.1, end[2] - 0.4];
    let second = [-arm[1], 0.0, arm[0]];
    for i in 0..3 {
        for j in 0..3 {
            let expected = 5e-6 * first[i] * first[j] + 1e-5 * second[i] * second[j];
            assert!(
                (c[i][j] - expected).abs() < 1e-14,
                "{i} {j}: {} is not {expected}",
                c[i][j]
            );
        }
    }
}

/// The frames of both conventions as products of their four elementary motions (Denavit and Hartenberg 1955; Craig, 3rd edition, 3.4).
#[test]
fn tables_of_both_conventions() {
    let rows = [
        [-90.0, 0.312, -90.0, 0.1],
        [30.0, 1.075, 10.0, 0.0],
        [77.0, 0.225, 0.0, 1.28],
        [-90.0, 0.05, 25.0, 0.215],
    ];
    let values = [12.0, -40.0, 65.0, 0.3];
    for convention in ["standard", "modified"] {
        let mut text = format!(
            "schema = \"stiffbench/robot/2\"\nname = \"a\"\nup = \"z\"\ndh = \"{convention}\"\n[joints]\n"
        );
        let mut frame = IDENTITY;
        for (place, [alpha, a, theta, d]) in rows.into_iter().enumerate() {
            let slides = place == 3;
            let kind = if slides { "kind = \"sliding\", " } else { "" };
            let _ = writeln!(
                text,
                "J{place} = {{ {kind}alpha_deg = {alpha}, a_mm = {}, theta = {theta}, d = {d}, min = -90, max = 90 }}",
                1e3 * a
            );
            let q = values[place];
            let (theta, d) = if slides {
                (theta, d + q)
            } else {
                (theta + q, d)
            };
            let x = motion(0, alpha, a);
            let z = motion(2, theta, d);
            frame = match convention {
                "standard" => times(&times(&frame, &z), &x),
                _ => times(&times(&frame, &x), &z),
            };
        }
        text += "[tool]\nat_mm = [10, 20, 30]\nturn_deg = [90, 0, 0]\n";
        let robot = parse(&text).unwrap();
        let found = robot.tool_pose(&at_values(&values)).unwrap();
        let at = [0.01, 0.02, 0.03];
        let expected: [f64; 3] =
            std::array::from_fn(|i| frame[i][3] + (0..3).map(|k| frame[i][k] * at[k]).sum::<f64>());
        near(found.position_m, expected);
        // Turned about x by 90 degrees, the tool's y is the frame's z.
        near(found.axes[0], std::array::from_fn(|i| frame[i][0]));
        near(found.axes[1], std::array::from_fn(|i| frame[i][2]));
    }
}

type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// A turn about and a step along one axis.
fn motion(axis: usize, angle_deg: f64, step: f64) -> Matrix {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = IDENTITY;
    m[b][b] = cos;
    m[b][c] = -sin;
    m[c][b] = sin;
    m[c][c] = cos;
    m[axis][3] = step;
    m
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Replaces `find` by `replacement`, in which « marks where the error must be found.
#[track_caller]
fn refused(find: &str, replacement: &str, message: &str) {
    assert!(ARM.contains(find), "{find}");
    let (text, place) = marked(&ARM.replacen(find, replacement, 1));
    match parse(&text) {
        Err(RobotError::File(error)) => {
            let said = format!(
                "{} {}",
                error.problem,
                error.help.clone().unwrap_or_default()
            );
            assert!(said.contains(message), "{said}");
            assert_eq!((error.line, error.column), place, "{said}");
        }
        other => panic!("{replacement}: {other:?}"),
    }
}

#[test]
fn what_is_wrong_is_said_where_it_stands() {
    #[rustfmt::skip]
    let cases = [
        ("at_mm = [0, 0, \"h\"]", "«at_inch = [0, 0, \"h\"]", "unknown key `at_inch`"),
        ("stiffness_kNm_per_rad", "«stifness_kNm_per_rad", "is `stiffness` meant"),
        ("at_mm = [0, 0, \"h\"]", "at_deg = [«0, 0, \"h\"]", "`deg` is not a unit of this key: it may end in m, mm"),
        ("stiffness_kNm_per_rad = 200", "stiffness_N_per_um = «200", "this spring turns"),
        ("stiffness_kNm_per_rad = 200", "stiffness_kNm_per_rad = «-2", "above zero"),
        ("stiffness_kNm_per_rad = 200", "stiffness_kNm_per_rad = «\"stiff\"", "a number"),
        ("min_deg = -90, max_deg = 90, spring", "min_mm = «-90, max_deg = 90, spring", "a length where a joint turns"),
        ("at_mm = [0, 0, \"h\"]", "at_mm = [0, 0, «\"g\"]", "`g` is not a parameter"),
        ("\"h\"], axis = \"z\"", "\"h\"], axis = «\"w\"", "an axis is `x`"),
        ("axis = \"-y\"", "axis = «[0, 0, 0]", "a direction needs"),
        ("J2 = { at_mm", "J2 = { on = «\"J4\", at_mm", "no body `J4`"),
        ("J2 = { at_mm", "J2 = «{ alpha_deg = 3, at_mm", "not by both"),
        ("\"tube 60x5", "«\"tub 60x5", "`tub` is not a profile"),
        ("\"tube 60x5 aluminium\"", "«\"tube 60x5 alu\"", "no material `alu` did you mean `aluminium`?"),
        ("\"tube 60x5 aluminium\"", "«\"tube 60x50 steel\"", "thicker"),
        ("\"tube 60x5 aluminium\"", "«\"IPE 210 steel\"", "the table has 80, 100"),
        ("P1 = { J2_deg = 30", "P1 = { «J5_deg = 30", "no variable `J5` did you mean"),
        ("P1 = { J2_deg = 30", "P1 = { J2_mm = «30", "a length where a joint turns"),
        ("P2 = [10, 0.5235987755982988, 0.1]", "P2 = «[10, 20]", "a pose has 3 values"),
        ("on = \"J3\"", "on = «\"J7\"", "no body `J7`"),
        ("mass_kg = 2", "mass_kg = «0", "above zero"),
        ("up = \"z\"", "up = «\"w\"", "unknown word `w`"),
        ("\"stiffbench/robot/2\"", "«\"stiffbench/robot/3\"", "supports up to"),
        ("spring = \"free\" }", "spring = «\"losse\" }", "unknown word"),
        ("spring = \"free\" }", "spring = \"tied\", tied_to = «\"J9\" }", "not a model parameter"),
        ("h_mm = 400", "h_mm = 400\n«h = 2", "given twice"),
    ];
    for (find, replacement, message) in cases {
        refused(find, replacement, message);
    }
    // What is missing stands nowhere.
    let error = parse(&ARM.replace("up = \"z\"\n", "")).unwrap_err();
    assert!(
        matches!(&error, RobotError::File(file) if file.problem.to_string().contains("missing key `up`")),
        "{error}"
    );
}

#[test]
fn a_tied_spring_has_the_value_of_the_other() {
    let text = ARM.replace(
        "stiffness_Nm_per_rad = 1e5",
        "spring = \"tied\", tied_to = \"joint.J1\"",
    );
    let robot = parse(&text).unwrap();
    let spring = robot.own_springs().nth(1).unwrap().1.clone();
    assert_eq!(spring.yielding, Yielding::Compliance(5e-6));
    assert!(matches!(spring.in_fit, RoleInFit::Tied(other) if other.to_string() == "joint.J1"));
}

#[test]
fn a_section_without_plane_and_missing_limits_are_noted_with_their_line() {
    let text = ARM.replace("axis = \"z\", min_deg = -90, max_deg = 90", "axis = \"z\"");
    let robot = parse(&text).unwrap();
    assert!(
        robot.warnings[0].contains("line 7: `J1` has no limits, -180 to 180 degrees"),
        "{:?}",
        robot.warnings
    );
    let text = ARM.replace(
        "[tool]",
        "[links]\npost = { between = [\"base\", \"J1\"], section = \"box 100x60x4\" }\n[tool]",
    );
    let robot = parse(&text).unwrap();
    assert!(
        robot.warnings[0].contains("line 11: link `post` has no plane"),
        "{:?}",
        robot.warnings
    );
    let text = text.replace("100x60x4\"", "100x60x4\", width = \"y\"");
    assert_eq!(parse(&text).unwrap().warnings, Vec::<String>::new());
}

#[test]
fn the_example_of_the_page_loads_and_solves() {
    let robot = parse(stiffbench_test_files::example("docs/robot-file.md", "toml")).unwrap();
    assert_eq!(robot.warnings, Vec::<String>::new());
    let mechanism = robot.mechanism(None).unwrap();
    let factors = robot.default_factors().1;
    let mut predictor = Predictor::new(&robot, mechanism, &factors).unwrap();
    for named in &robot.poses {
        predictor.place(&named.pose).unwrap();
        let c = predictor.translation_compliance();
        assert!((0..3).all(|i| c[i][i] > 1e-10), "{c:?}");
    }
}
