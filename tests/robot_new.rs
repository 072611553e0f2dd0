//! Robot files made from URDFs, Denavit-Hartenberg tables and templates: kinematics against Pinocchio, and clear errors.

use std::path::PathBuf;

use serde_json::Value;
use stiffbench::analysis::{
    DhSettings, StatedPosition, TEMPLATES, UrdfSettings, check_positions, check_robot,
    robot_from_dh, robot_from_urdf,
};
use stiffbench::robot::format2::file::DhConvention;
use stiffbench::robot::{Pose, Robot};
use stiffbench::shipped::{shipped_robot, shipped_robots};
use stiffbench::source_text::SourceText;

use crate::support::{Contains, Json};

/// The FANUC R-2000iC as CSV, rows of Craig's convention.
pub(crate) const TABLE: &str = "joint,alpha_deg,a_mm,theta_deg,d_mm,angle,min_deg,max_deg
J1,0,0,0,670,,-185,185
J2,-90,312,-90,0,,-60,76
J3,0,1075,0,0,J2=-1 J3=-1,-132,180
J4,-90,225,0,1280,J4=-1,-360,360
J5,90,0,0,0,J5=-1,-125,125
J6,-90,0,0,215,J6=-1,-360,360
";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn parsed(text: &str) -> Robot {
    Robot::parse(&SourceText::new("made.toml", text))
        .unwrap_or_else(|error| panic!("{error:?}\n{text}"))
}

/// `tests/urdf/check.py` made the positions; two of its robots lie there, the others in Python packages that
/// `STIFFBENCH_URDF_PACKAGES` names.
#[test]
fn imported_robots_stand_where_pinocchio_puts_them() {
    let fixture = std::fs::read_to_string(root().join("fixtures/urdf/kinematics.json")).unwrap();
    let fixture: Value = serde_json::from_str(&fixture).unwrap();
    let packages = std::env::var("STIFFBENCH_URDF_PACKAGES").ok();
    let mut compared = 0;
    for robot in fixture["robots"].list() {
        let path = PathBuf::from(robot["package_path"].word());
        let here = root().join("fixtures/urdf").join(path.file_name().unwrap());
        let path = match &packages {
            Some(folder) => PathBuf::from(folder).join(&path),
            None if here.exists() => here,
            None => continue,
        };
        let name = |key: &str| Some(robot[key].word().to_owned());
        let settings = UrdfSettings {
            base: name("base"),
            tip: name("tip"),
            sections: Vec::new(),
        };
        let source = SourceText::new(
            path.display().to_string(),
            std::fs::read_to_string(&path).unwrap(),
        );
        let made = robot_from_urdf(&source, &settings).unwrap_or_else(|error| panic!("{error}"));
        let arm = parsed(&made.text);
        for pose in robot["poses"].list() {
            let mut values = arm.nominal_pose().angles_deg;
            for (joint, value) in pose["values"].as_object().unwrap() {
                let variable = arm.variable(joint).unwrap();
                let slides =
                    arm.variables[variable].motion == stiffbench::robot::JointMotion::Slides;
                let value = value.number();
                values[variable] = if slides { value } else { value.to_degrees() };
            }
            let found = arm.tool_pose(&Pose { angles_deg: values }).unwrap();
            for i in 0..3 {
                let expected = pose["position_m"][i].number();
                let error = (found.position_m[i] - expected).abs();
                assert!(error < 1e-9, "{}: {error:e} m", path.display());
                for j in 0..3 {
                    let expected = pose["rotation"][i][j].number();
                    let error = (found.axes[j][i] - expected).abs();
                    assert!(error < 1e-9, "{}: {error:e}", path.display());
                }
            }
            compared += 1;
        }
    }
    let least = if packages.is_some() { 36 } else { 6 };
    assert!(compared >= least, "only {compared} poses were compared");
}

type Matrix = [[f64; 4]; 4];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A row of Craig's convention: Rot x(alpha) Trans x(a) Rot z(theta) Trans z(d), written out (Craig, 3rd edition, eq. 3.6).
fn craig([alpha, a, theta, d]: [f64; 4]) -> Matrix {
    let ((sa, ca), (st, ct)) = (alpha.sin_cos(), theta.sin_cos());
    [
        [ct, -st, 0.0, a],
        [st * ca, ct * ca, -sa, -sa * d],
        [st * sa, ct * sa, ca, ca * d],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

/// Tool centre of the FANUC R-2000iC by the rows that come with its data, angles of the pendant in degrees.
fn fanuc_tool_m(pendant_deg: [f64; 6]) -> [f64; 3] {
    use std::f64::consts::FRAC_PI_2;
    let [p1, p2, p3, p4, p5, p6] = pendant_deg.map(f64::to_radians);
    let rows = [
        [0.0, 0.0, p1, 0.670],
        [-FRAC_PI_2, 0.312, -FRAC_PI_2 + p2, 0.0],
        [0.0, 1.075, -(p2 + p3), 0.0],
        [-FRAC_PI_2, 0.225, -p4, 1.280],
        [FRAC_PI_2, 0.0, -p5, 0.0],
        [-FRAC_PI_2, 0.0, -p6, 0.215],
    ];
    let frame = rows
        .map(craig)
        .iter()
        .skip(1)
        .fold(craig(rows[0]), |frame, row| times(&frame, row));
    let tool = [0.0069, 0.2453, 0.3193, 1.0];
    std::array::from_fn(|i| (0..4).map(|k| frame[i][k] * tool[k]).sum())
}

#[test]
fn the_fanuc_stands_where_its_table_puts_it() {
    let shipped = parsed(&shipped_robot("fanuc-r2000ic").unwrap().text);
    let settings = DhSettings {
        convention: Some(DhConvention::Modified),
        controller: None,
    };
    let made = robot_from_dh(&SourceText::new("table.csv", TABLE), &settings).unwrap();
    assert_eq!(made.notes, Vec::<String>::new());
    let made = parsed(
        &made
            .text
            .replace("at_mm = [0, 0, 0]", "at_mm = [6.9, 245.3, 319.3]"),
    );
    let poses = [
        [0.0; 6],
        [-59.991, -16.693, -28.93, 3.788, -62.93, 144.919],
        [17.0, 40.0, 12.0, -33.0, 71.0, -140.0],
    ];
    for pose in poses {
        let expected = fanuc_tool_m(pose);
        for robot in [&shipped, &made] {
            let found = robot.tool_pose(&Pose {
                angles_deg: pose.to_vec(),
            });
            let found = found.unwrap().position_m;
            for i in 0..3 {
                assert!(
                    (found[i] - expected[i]).abs() < 1e-9,
                    "{found:?} is not {expected:?}"
                );
            }
        }
    }
}

#[test]
fn stated_positions_find_a_wrong_sign() {
    let robot = parsed(&shipped_robot("fanuc-r2000ic").unwrap().text);
    let stated = |values: [f64; 6]| StatedPosition {
        values: values.to_vec(),
        position_mm: fanuc_tool_m(values).map(|m| 1e3 * m),
    };
    let right = [
        stated([0.0; 6]),
        stated([10.0, 20.0, -15.0, 40.0, -60.0, 5.0]),
    ];
    assert_eq!(check_positions(&robot, &right).unwrap().len(), 2);
    let wrong = right.map(|mut position| {
        position.values[3] *= -1.0;
        position.values[5] *= -1.0;
        position
    });
    let error = check_positions(&robot, &wrong).unwrap_err();
    let help = error.help.unwrap();
    help.must_contain(&["it fits if J4, J6 count the other way"]);
    let short: StatedPosition = "1,2=3,4,5".parse().unwrap();
    assert!(check_positions(&robot, &[short]).is_err());
    for text in ["1,2", "1=2,3", "a=1,2,3", "1=1,2,nan"] {
        assert!(text.parse::<StatedPosition>().is_err(), "{text}");
    }
}

#[test]
fn templates_and_shipped_robots_can_be_checked_without_complaint() {
    let shipped = shipped_robots().map(|name| shipped_robot(name).unwrap());
    let templates = TEMPLATES
        .iter()
        .map(|(name, text)| SourceText::new(*name, *text));
    for source in shipped.chain(templates) {
        let robot =
            Robot::parse(&source).unwrap_or_else(|error| panic!("{}: {error:?}", source.name));
        let check = check_robot(&robot, &source)
            .unwrap_or_else(|error| panic!("{}: {error:?}", source.name));
        assert_eq!(check.findings, Vec::<String>::new(), "{}", source.name);
        assert!(check.checked.len() >= 4, "{}", source.name);
        for pose in &check.checked {
            assert!(
                pose.stiffness_n_per_um.iter().flatten().count() == 3,
                "{}: {pose:?}",
                source.name
            );
        }
    }
}

#[test]
fn what_is_odd_is_found() {
    let odd = |text: &str, find: &str, replacement: &str| {
        assert!(text.contains(find), "{find}");
        let source = SourceText::new("odd.toml", text.replace(find, replacement));
        let robot = Robot::parse(&source).unwrap();
        check_robot(&robot, &source).unwrap().findings.join("\n")
    };
    let template = |name: &str| {
        TEMPLATES
            .iter()
            .find(|(known, _)| *known == name)
            .unwrap()
            .1
    };
    let serial = template("serial");
    let found = odd(serial, "at_mm = [520, 0, 0]", "at_m = [52, 0, 0]");
    found.must_contain(&["are lengths in mm taken for m?"]);
    let found = odd(serial, "P1_deg = [0, 0,", "P1_deg = [0, 200,");
    found.must_contain(&["pose P1 lies 80.0 degrees beyond the limit J2 <= 120"]);
    let found = odd(
        serial,
        "stiffness_Nm_per_rad = 4e5",
        "stiffness_Nm_per_rad = 4",
    );
    found.must_contain(&["lies outside of 0.0001 to 1000 N/µm"]);
    let crossed = odd(template("parallelogram"), "side = 1", "side = -1");
    crossed.must_contain(&["the parallelogram that closes in `D` is crossed"]);
    let line = template("parallelogram")
        .lines()
        .position(|line| line.starts_with("D = "))
        .unwrap()
        + 1;
    crossed.must_contain(&[&format!("odd.toml:{line}: ")]);
    let found = odd(
        template("four-bar"),
        "radii_mm = [350, 250]",
        "radii_mm = [150, 250]",
    );
    found.must_contain(&["cannot be reached"]);
}

const URDF: &str = r#"<robot name="arm">
<link name="world"/><link name="a"><inertial><mass value="2"/></inertial></link><link name="b"/>
<joint name="j1" type="revolute"><parent link="world"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
<joint name="j2" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="0" upper="0.2"/></joint>
</robot>
"#;

fn urdf(find: &str, replacement: &str) -> Result<stiffbench::analysis::NewRobot, String> {
    assert!(URDF.contains(find), "{find}");
    let text = URDF.replacen(find, replacement, 1);
    let made = robot_from_urdf(&SourceText::new("arm.urdf", text), &UrdfSettings::default());
    made.map_err(|error| format!("{error} | {}", error.help.clone().unwrap_or_default()))
}

#[test]
fn right_angles_and_whole_turns_are_written_as_such() {
    let text = URDF
        .replace(
            "lower=\"-1\" upper=\"1\"",
            "lower=\"-6.2831853\" upper=\"6.28318530718\"",
        )
        .replace(
            "<child link=\"b\"/>",
            "<child link=\"b\"/><origin rpy=\"1.570796326795 0 0.25\"/>",
        );
    let source = SourceText::new("arm.urdf", text);
    let made = robot_from_urdf(&source, &UrdfSettings::default())
        .unwrap()
        .text;
    // Fewer digits than a right angle has are kept: kinematics follow the file.
    made.must_contain(&[
        "max_deg = 360,",
        "min_deg = -359.9999995",
        "turn_deg = [90, 0, 14.32394487827",
    ]);
}

#[test]
fn urdfs_that_cannot_be_used_name_the_element() {
    #[rustfmt::skip]
    let refused = [
        ("type=\"revolute\"", "type=\"floating\"", "arm.urdf:3:1: joint `j1` is floating: it has more than one freedom | choose --base"),
        ("type=\"revolute\"", "type=\"revolut\"", "arm.urdf:3:1: joint `j1`: there is no type `revolut`"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", "joint `j1`: its axis has no direction"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0\"/>", "joint `j1`: `xyz` is `0 0` | write three numbers"),
        ("<child link=\"a\"/>", "<child link=\"aa\"/>", "joint `j1`: there is no link `aa` | did you mean `a`?"),
        ("<link name=\"b\"/>", "<link name=\"b\"/><link name=\"a\"/>", "link `a` is there twice"),
        ("name=\"j2\"", "name=\"j1\"", "joint `j1` is there twice"),
        ("<link name=\"b\"/>", "<link name=\"b\"/><link name=\"c\"/>", "2 links hang on no joint: world, c | name the one that is held with --base"),
        ("</robot>", "<joint name=\"j3\" type=\"fixed\"><parent link=\"world\"/><child link=\"b\"/></joint></robot>", "hangs on joint `j2` already: the robot has a loop"),
        ("</robot>", "<link name=\"c\"/><joint name=\"j3\" type=\"fixed\"><parent link=\"world\"/><child link=\"c\"/></joint></robot>", "the robot has 2 ends: b, c | name the link that carries the tool with --tip, for example --tip b"),
        ("<parent link=\"world\"/>", "<parent link=\"b\"/>", "no joint moves between `world` and `world`"),
        ("<robot name=\"arm\">", "<sdf>", "no XML"),
        ("<mass value=\"2\"/>", "<mass value=\"-2\"/>", "link `a`: its mass is -2"),
        ("lower=\"-1\"", "lower=\"${-pi}\"", "this is a xacro expression; expand the file first"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"$(arg axis)\"/>", "joint `j1`: `xyz` is `$(arg axis)` | this is a xacro expression"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 nan\"/>", "joint `j1`: `xyz` is `nan` | write a finite number"),
        ("lower=\"-1\"", "lower=\"nan\"", "joint `j1`: `lower` is `nan` | write a finite number"),
        ("</joint>", "<mimic joint=\"j1\"/></joint>", "joint `j1` follows joint `j1`, and both follow each other"),
        ("type=\"revolute\"", "type=\"planar\"", "joint `j1` is planar: it has more than one freedom"),
        ("type=\"revolute\"", "type=\"spherical\"", "joint `j1` is spherical: it has more than one freedom"),
        ("<link name=\"world\"/>", "<link name=\"world\"/><xacro:macro xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/>", "this file is a xacro"),
    ];
    for (find, replacement, message) in refused {
        let error = urdf(find, replacement).expect_err(replacement);
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn urdfs_with_oddities_are_imported_with_a_note() {
    let whole = urdf("arm", "arm").unwrap();
    assert_eq!(whole.notes, ["no mass is stated for b"]);
    whole.text.must_contain(&["mass_kg = 2"]);
    #[rustfmt::skip]
    let noted = [
        ("<limit lower=\"-1\" upper=\"1\"/>", "", "arm.urdf:3: joint `j1` has no limits: -180 to 180 degrees were taken"),
        ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 2\"/>", "joint `j1` has an axis of length 2"),
        ("<limit lower=\"-1\" upper=\"1\"/>", "<limit lower=\"-1e16\" upper=\"1e16\"/>", "joint `j1` has no limits"),
        ("<limit lower=\"-1\" upper=\"1\"/>", "<limit effort=\"3\"/>", "joint `j1` has no limits"),
        ("<limit lower=\"-1\" upper=\"1\"/>", "<limit lower=\"2\" upper=\"1\"/>", "joint `j1` has a lower limit of 2 above its upper limit of 1: -180 to 180 degrees were taken"),
        ("</joint>", "<mimic joint=\"gone\"/></joint>", "joint `j1` follows joint `gone`, which is not a joint of this file: it has a variable of its own"),
        ("</joint>", "<mimic joint=\"j0\"/></joint><link name=\"c\"/><joint name=\"j0\" type=\"fixed\"><parent link=\"b\"/><child link=\"c\"/></joint>", "joint `j1` follows joint `j0`, which has no variable"),
        ("<link name=\"b\"/>", "<link name=\"b\"><visual><geometry><mesh filename=\"package://nowhere/b.stl\"/></geometry></visual></link>", "arm.urdf:2: link `b`: its mesh package://nowhere/b.stl is not there; meshes have no part in stiffness"),
    ];
    for (find, replacement, note) in noted {
        let made = urdf(find, replacement).unwrap();
        assert!(
            made.notes.iter().any(|said| said.contains(note)),
            "{:?}",
            made.notes
        );
        parsed(&made.text);
    }
    // Followers of followers, and of joints that come later: 0.1 + 2 (0.2 + 3 q).
    let text = URDF.replace(
        "<axis",
        "<mimic joint=\"j2\" multiplier=\"2\" offset=\"0.1\"/><axis",
    );
    let text = text.replacen(
        "joint=\"j2\" multiplier=\"2\" offset=\"0.1\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\"",
        "joint=\"j3\" multiplier=\"3\" offset=\"0.2\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\"",
        1,
    );
    let text = text.replace("</robot>", "<link name=\"c\"/><joint name=\"j3\" type=\"prismatic\"><parent link=\"b\"/><child link=\"c\"/><limit lower=\"0\" upper=\"1\"/></joint></robot>");
    let made = robot_from_urdf(&SourceText::new("arm.urdf", text), &UrdfSettings::default());
    let made = made.unwrap_or_else(|error| panic!("{error}")).text;
    made.must_contain(&[
        "angle = { j3 = 343.77467707849, offset_deg = 28.647889756541 }",
        "angle = { j3 = 3, offset_mm = 200 }",
    ]);
    parsed(&made);
    let sections = UrdfSettings {
        sections: vec![(Some("j1".to_owned()), "tube 60x4 aluminium".to_owned())],
        ..UrdfSettings::default()
    };
    let source = SourceText::new(
        "arm.urdf",
        URDF.replace(
            "<child link=\"b\"/>",
            "<child link=\"b\"/><origin xyz=\"0.3 0 0\"/>",
        ),
    );
    let robot = parsed(&robot_from_urdf(&source, &sections).unwrap().text);
    assert_eq!(robot.members.len(), 1);
}

#[test]
fn tables_of_spreadsheets_are_the_same_as_those_with_commas() {
    let settings = DhSettings {
        convention: Some(DhConvention::Modified),
        controller: None,
    };
    let text_of = |table: &str| {
        let robot = robot_from_dh(&SourceText::new("t.csv", table), &settings).unwrap();
        robot.text
    };
    let mut semicolons = TABLE.replace('.', "!").replace(',', ";").replace('!', ",");
    for (plain, bracketed) in [
        ("joint", "Joint"),
        ("alpha_deg", "α [°]"),
        ("a_mm", "a [mm]"),
        ("theta_deg", "Theta (deg)"),
        ("d_mm", "d (mm)"),
    ] {
        assert!(semicolons.contains(plain), "{plain}");
        semicolons = semicolons.replacen(plain, bracketed, 1);
    }
    assert_eq!(text_of(&semicolons), text_of(TABLE));
    let tabs = TABLE.replace(',', "\t").replace("312", "312,5");
    assert_eq!(text_of(&tabs), text_of(&TABLE.replace("312", "312.5")));
}

#[test]
fn units_that_a_table_leaves_open_are_said() {
    let settings = DhSettings {
        convention: Some(DhConvention::Standard),
        controller: None,
    };
    let notes = |name: &str, text: &str| {
        let made = robot_from_dh(&SourceText::new(name, text), &settings).unwrap();
        let notes = made
            .notes
            .into_iter()
            .filter(|note| !note.contains("limits"));
        notes.collect::<Vec<_>>()
    };
    let said = notes(
        "t.csv",
        "a,alpha,d,theta\n0,1.5708,0.1625,0\n-0.425,0,0,0\n",
    );
    assert_eq!(
        said,
        [
            "no unit is stated for `a` and `d`: taken as m; a name states another one, for example a_mm",
            "no unit is stated for `alpha` and `theta`: taken as degrees; a name states another one, for example alpha_rad",
            "`alpha` and `theta` look like radians (first 1.5708) and were taken as degrees: if they are radians, name them alpha_rad and theta_rad",
        ]
    );
    // Half a right angle, and in TOML.
    let said = notes(
        "t.toml",
        "rows = [{ a_mm = 100, alpha = -0.7854 }, { a_mm = 100 }]",
    );
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(
        said[1].contains("(first -0.7854)") && said[1].ends_with("alpha_rad"),
        "{said:?}"
    );
    // Degrees, odd angles, zeros, and angles with a unit are no radians.
    for angle in ["90", "1.5", "0", "6.3"] {
        let said = notes("t.csv", &format!("a_mm,alpha\n0,{angle}\n"));
        assert_eq!(said.len(), 1, "{said:?}");
    }
    let mixed = notes("t.csv", "a_mm,alpha,theta\n0,1.5708,90\n");
    assert_eq!(mixed.len(), 1, "{mixed:?}");
    assert_eq!(
        notes("t.csv", "a_mm,alpha_rad\n0,1.5708\n"),
        Vec::<String>::new()
    );
    // Limits, which turn and slide.
    let said = notes("t.csv", "a_mm,min,max\n0,-3.1416,3.1416\n");
    said[0].must_contain(&["`min` and `max`: taken as degrees"]);
    said[1].must_contain(&["min_rad and max_rad"]);
    let said = notes(
        "t.csv",
        "kind,a_mm,min,max\nsliding,0,0,1.5708\nrevolute,0,-90,90\n",
    );
    assert_eq!(said.len(), 1, "{said:?}");
    said[0].must_contain(&["taken as degrees, of sliding joints m"]);
}

#[test]
fn tables_that_cannot_be_used_name_the_line() {
    let refused_with = |name: &str, text: &str, convention| {
        let settings = DhSettings {
            convention,
            controller: None,
        };
        let error = robot_from_dh(&SourceText::new(name, text), &settings).unwrap_err();
        format!("{error} | {}", error.help.clone().unwrap_or_default())
    };
    let refused = |name: &str, text: &str| refused_with(name, text, Some(DhConvention::Modified));
    let with = |find: &str, replacement: &str| TABLE.replace(find, replacement);
    refused_with("t.csv", TABLE, None)
        .must_contain(&["the table does not state its convention | add --convention"]);
    let craig = "rows = [{ a = 1 }]\nconvention = \"craig\"".to_owned();
    let empty = "convention = \"standard\"\nrows = []".to_owned();
    #[rustfmt::skip]
    let tables: [(&str, String, &str, &[&str]); 6] = [
        ("t.csv", with("J4,-90,225", "J4,-90,much"), "t.csv:5:", &["not a finite number"]),
        ("t.csv", with("J4,-90,225,0", "J4,-90,225"), "t.csv:5:", &["does not fit"]),
        ("t.csv", with("alpha_deg", "alfa_deg"), "t.csv:1:", &["no column `alfa_deg`", "alpha_deg"]),
        ("t.csv", with("alpha_deg", "alpha_mm"), "", &["`mm` is not a unit of this key"]),
        ("t.toml", craig, "t.toml:2:", &["unknown word `craig`"]),
        ("t.toml", empty, "", &["no rows"]),
    ];
    for (name, text, place, words) in tables {
        let error = refused(name, &text);
        assert!(error.starts_with(place), "{error}");
        error.must_contain(words);
    }
}
