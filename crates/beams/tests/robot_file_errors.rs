//! What is wrong with a robot file is said at the line and column where it stands, and nothing that a file can say makes the reader
//! panic, hang or compute with numbers that are none.

use crate::support::{level_arm, marked};
use miette::Diagnostic;
use proptest::prelude::*;
use stiffbench_beams::robot::{Predictor, Robot, RobotError, chain_mobility, mobility};
use stiffbench_test_files::{shipped_robot, shipped_robots};
use stiffbench_units_and_text::source_text::SourceText;

fn parse(text: &str) -> Result<Robot, RobotError> {
    Robot::parse(&SourceText::new("arm.toml", text))
}

/// Line, column, message and help of the error in a text.
fn error_in(text: &str) -> (usize, usize, String, String) {
    match parse(text) {
        Err(RobotError::File(error)) => {
            assert_eq!(error.file, "arm.toml");
            let help = error.help.unwrap_or_default();
            (error.line, error.column, error.problem.to_string(), help)
        }
        other => panic!("{other:?}"),
    }
}

/// Replaces `find` by `replacement`, in which « marks where the error must be found.
#[track_caller]
fn refused(find: &str, replacement: &str, message: &str, help: &str) {
    let (text, expected) = marked(&level_arm::with(find, replacement));
    let (line, column, said, helped) = error_in(&text);
    assert!(said.contains(message), "{said}");
    assert!(helped.contains(help), "help: {helped}");
    assert_eq!((line, column), expected, "{said}");
}

/// What is replaced, by what, and what the message and the help must contain.
type Case = (&'static str, &'static str, &'static str, &'static str);

fn all_refused(cases: &[Case]) {
    for (find, replacement, message, help) in cases {
        refused(find, replacement, message, help);
    }
}

#[test]
fn names_that_do_not_exist() {
    #[rustfmt::skip]
    all_refused(&[
        (r#"node = "O", bodies"#, r#"node = «"Q", bodies"#, "no node `Q`", "did you mean"),
        (r#"nodes = ["G", "O"]"#, r#"nodes = ["G", «"elbow"]"#, "no node `elbow`", "the file has: G, O, A, C, D, E"),
        (r#"["C", "arm"], ["A""#, r#"["C", "arm"], [«"AA""#, "no node `AA`", "did you mean `A`?"),
        (r#"dist = ["O", "C"]"#, r#"dist = ["O", «"c4"]"#, "no node `c4`", ""),
        (r#"fixed = ["G"]"#, r#"fixed = ["G", «"base"]"#, "no node `base`", ""),
        (r#"node = "E""#, r#"node = «"hand""#, "no node `hand`", ""),
        (r#"along = ["C", "D"]"#, r#"along = [«"X1", "D"]"#, "no node `X1`", ""),
        (r#"origin = "O""#, r#"origin = «"origin""#, "no node `origin`", ""),
        (r#"section = "post""#, r#"section = «"pots""#, "no section `pots`", "the file has: post, tube, rod"),
        (r#"body = "ground", plane"#, r#"body = «"grund", plane"#, "no body `grund`", "did you mean `ground`?"),
        (r#"bodies = ["ground", "arm"]"#, r#"bodies = ["ground", «"am"]"#, "no body `am`", "did you mean `arm`?"),
        (r#"parent = "ground""#, r#"parent = «"world""#, "no body `world`", "ground"),
        (r#"on = "arm""#, r#"on = «"forearm""#, "no body `forearm`", ""),
        ("body = \"ground\"\nnormal", "body = «\"earth\"\nnormal", "no body `earth`", ""),
        (r#"plane = "upright" }"#, r#"plane = «"uprigth" }"#, "no plane `uprigth`", "did you mean `upright`?"),
        (r#"axis = "upright" }"#, r#"axis = «"floor" }"#, "no plane `floor`", "upright"),
        ("plane = \"upright\"\n", "plane = «\"flat\"\n", "no plane `flat`", ""),
        (r#"plane = "upright", branch"#, r#"plane = «"side", branch"#, "no plane `side`", ""),
        (r#"material = "steel""#, r#"material = «"steal""#, "no material `steal`", "did you mean `steel`?"),
        ("terms = { lift = 1.0", "terms = { «lft = 1.0", "no variable `lft`", "did you mean `lift`?"),
        ("angle = { lift = 1.0", "angle = { «theta = 1.0", "no variable `theta`", "lift, trim"),
        ("lift = 45.0", "«left = 45.0", "no variable `left`", "did you mean `lift`?"),
        (r#"chains = ["host"]"#, r#"chains = ["host", «"C"]"#, "no chain `C`", "host"),
        (r#"M1 = "O" }"#, r#"M1 = «"J1" }"#, "no joint `J1`", "O, A, C, D"),
        (r#"locked = ["A"]"#, r#"locked = [«"Z"]"#, "no joint `Z`", ""),
        (r#"chains = ["host"]"#, "chains = [\"host\"]\nelements = [«\"OB\"]", "no element `OB`", "did you mean"),
        (r#"at = [0.0, "height", 0.0]"#, r#"at = [0.0, «"heigth", 0.0]"#, "`heigth` is not a parameter", "did you mean `height`?"),
        ("min = -30.0", "min = «\"lowest\"", "`lowest` is not a parameter", ""),
        ("reach = 0.200", "reach = «\"arm - hand\"", "`hand` is not a parameter", ""),
    ]);
}

#[test]
fn names_given_twice() {
    #[rustfmt::skip]
    all_refused(&[
        (r#"{ id = "A", node = "A""#, r#"{ id = «"O", node = "A""#, "joint `O` is defined twice", ""),
        (r#"{ id = "OA""#, r#"{ id = «"GO""#, "element `GO` is defined twice", ""),
        ("id = \"rod\"\n", "id = «\"arm\"\n", "body `arm` is defined twice", ""),
        (r#"fixed = ["G"]"#, r#"fixed = ["G", «"G"]"#, "support `G` is defined twice", ""),
        // Keys of tables are TOML's own business.
        ("O = { on = \"ground\"", "«G = { on = \"ground\"", "duplicate key", ""),
        ("[mechanisms.levelled]", "[mechanisms.«arm-only]", "duplicate key", ""),
    ]);
}

#[test]
fn a_definition_that_needs_itself_is_an_error() {
    #[rustfmt::skip]
    all_refused(&[
        (r#"A = { on = "arm""#, r#"A = «{ on = "hand""#, "node `A` depends on itself: A needs hand needs A", ""),
        (r#"D = { loop = [["C", "arm"]"#, r#"D = «{ loop = [["D", "arm"]"#, "D needs D", ""),
        ("id = \"arm\"\nchain = \"host\"\nparent = \"ground\"\norigin = \"O\"",
         "id = «\"arm\"\nchain = \"host\"\nparent = \"ground\"\norigin = \"A\"", "arm needs A needs arm", ""),
        ("id = \"arm\"\nchain = \"host\"\nparent = \"ground\"",
         "id = «\"arm\"\nchain = \"host\"\nparent = \"arm\"", "arm needs arm", ""),
        ("height = 0.500", "height = \"spare + 0.1\"\nspare = «\"height - 0.1\"",
         "parameter `spare` depends on itself: height needs spare needs height", ""),
        ("height = 0.500", "height = «\"height + 0.1\"", "height needs height", ""),
    ]);
}

#[test]
fn expressions_without_value() {
    for text in ["2 * arm", "", "0.1 +", "--arm", "3 arm", "sin(3)"] {
        refused("reach = 0.200", &format!("reach = «\"{text}\""), "", "");
    }
    #[rustfmt::skip]
    all_refused(&[
        ("reach = 0.200", "reach = «\"2 * arm\"", "is not a signed sum", ""),
        ("reach = 0.200", "reach = «\"1e999\"", "must lie between -1e9 and 1e9", ""),
    ]);
}

/// TOML has nan and inf; so has a file whose numbers came out of a script that failed.
#[test]
fn numbers_that_are_none() {
    #[rustfmt::skip]
    let places = [
        ("min = -30.0", "min = #"), ("max = 60.0", "max = #"), ("nominal = 0.0", "nominal = #"),
        ("terms = { lift = 1.0", "terms = { lift = #"), ("at_least = -20.0", "at_least = #"),
        ("height = 0.500", "height = #"),
        ("angle = { lift = 1.0 }", "angle = { lift = # }"),
        ("angle = { lift = 1.0 }", "angle = { lift = 1.0, offset_deg = # }"),
        ("along = [\"C\", \"D\"]", "along = [\"C\", \"D\"]\nturn_deg = #"),
        ("at = [0.0, \"height\", 0.0]", "at = [0.0, \"height\", #]"),
        ("[\"C\", \"arm\"]", "[\"C\", #]"),
        ("lift = 45.0", "lift = #"), ("lift = 45.0", "paper_z_y = [#, 0.0]"), ("lift = 45.0", "paper_z_y = [0.0, #]"),
    ];
    // A direction may be as long as it likes, a constant as large: only what is no number at all is refused there.
    #[rustfmt::skip]
    let endless_places = [
        ("axis = [-1.0, 0.0, 0.0]", "axis = «[0.0, @, 0.0]"),
        ("normal = [1.0, 0.0, 0.0]", "normal = «[@, 0.0, 0.0]"),
        ("[support]", "[frame]\nradial = «[@, 0.0, 0.0]\n[support]"),
        ("E = 210.0e9", "E = #"), ("G = 81.0e9", "G = #"),
        ("A = 3.0e-3", "A = #"), ("Iy = 4.0e-6", "Iy = #"), ("Iz = 4.0e-6", "Iz = #"), ("J = 8.0e-6", "J = #"),
        ("shear = [0.44, 0.53]", "shear = «[0.44, @]"),
        ("Iy = 0.8", "Iy = #"), ("link = { A = 0.7", "link = { A = #"),
    ];
    let check = |number: &str, (find, replacement): (&str, &str)| {
        let replacement = replacement.replace('#', "«@").replace('@', number);
        refused(find, &replacement, "", "");
    };
    for number in ["nan", "-nan", "inf", "-inf"] {
        for place in places.into_iter().chain(endless_places) {
            check(number, place);
        }
    }
    for place in places {
        check("1e300", place);
    }
}

#[test]
fn numbers_that_are_impossible() {
    for number in ["-3.0e-3", "0.0", "-0.0"] {
        #[rustfmt::skip]
        let places = [
            ("A = 3.0e-3", "A = «#", "A of section post is"),
            ("Iy = 4.0e-6", "Iy = «#", "above zero"),
            ("E = 210.0e9", "E = «#", "E of material steel is"),
            ("Iy = 0.8", "Iy = «#", "factor Iy of beam in fitted is"),
            ("[\"C\", \"arm\"]", "[\"C\", «#]", "the radius is"),
        ];
        for (find, replacement, message) in places {
            refused(find, &replacement.replace('#', number), message, "");
        }
    }
    #[rustfmt::skip]
    all_refused(&[
        // A material that no section uses is read all the same.
        ("[materials.steel]", "[materials.air]\nE = 1.0\nG = «-1.0\n[materials.steel]", "G of material air", ""),
        ("min = -30.0", "min = «70.0", "it must not be above the largest", ""),
        ("branch = -1", "branch = «2", "it must be 1 or -1", ""),
        ("branch = -1", "branch = «0", "it must be 1 or -1", ""),
        ("branch = -1", "branch = «-9223372036854775808", "it must be 1 or -1", ""),
        ("normal = [1.0, 0.0, 0.0]", "normal = «[0.0, 0.0, 0.0]", "a direction needs", ""),
    ]);
}

#[test]
fn formats_and_units_of_others() {
    let format = "format = \"planar-linkage-robot/1\"";
    #[rustfmt::skip]
    all_refused(&[
        (format, "format = «\"planar-linkage-robot/2\"", "this version reads `planar-linkage-robot/1`", ""),
        ("[support]", "[units]\nlength = «\"mm\"\n[support]", "a unit is `mm`, this version reads `m`", ""),
        ("[support]", "[units]\nangle = «\"rad\"\n[support]", "`deg`", ""),
        ("[support]", "[units]\narea = «\"mm2\"\n[support]", "`m2`", ""),
        ("[support]", "[units]\nsecond_moment = «\"cm4\"\n[support]", "`m4`", ""),
        ("[support]", "[units]\nmodulus = «\"GPa\"\n[support]", "`Pa`", ""),
    ]);
}

#[test]
fn keys_that_lack_or_exclude_one_another() {
    #[rustfmt::skip]
    all_refused(&[
        ("[[bodies]]                       # from C", "«[[bodies]]\nparent = \"arm\" #", "not both", ""),
        ("[[bodies]]                       # from C", "«[[bodies]]\naxis = [1.0, 0.0, 0.0] #", "this one has `along`", ""),
        ("[[bodies]]                       # turns", "«[[bodies]]\nturn_deg = 3.0 #", "this one has `parent`", ""),
        ("[[bodies]]                       # the reference", "«[[bodies]]\naxis = [1.0, 0.0, 0.0] #", "needs `parent`", ""),
        ("[[bodies]]                       # the reference", "«[[bodies]]\nplane = \"upright\" #", "needs `along`", ""),
        ("[[bodies]]                       # turns with `lift` about -x through O\nid = \"arm\"\nchain = \"host\"\nparent = \"ground\"\norigin = \"O\"", "«[[bodies]]\nid = \"arm\"\nparent = \"ground\"", "needs `origin` and `axis`", ""),
        ("lift = 45.0", "lift = «[1.0, 2.0]", "only `paper_z_y` may be a point", ""),
        (r#"nodes = ["G", "O"]"#, r#"nodes = «["G", "G"]"#, "two different nodes", ""),
        (r#"along = ["C", "D"]"#, r#"along = «["C", "C"]"#, "two different nodes", ""),
        (r#"[["C", "arm"], ["A", { dist"#, r#"«[["C", "arm"], ["C", { dist"#, "two different centres", ""),
    ]);
}

#[test]
fn shapes_that_are_not_the_formats() {
    #[rustfmt::skip]
    all_refused(&[
        (r#"class = "beam""#, r#"class = «"bean""#, "unknown word `bean`, expected `beam` or `link`", ""),
        (r#"node = "E""#, "node = «5", "expected a string", ""),
        ("A = 3.0e-3", "A = «\"thick\"", "expected a number", ""),
        ("reach = 0.200", "reach = «true", "expected a number or text", ""),
        ("elements = [", "elements = «3\nrest = [", "expected an array", ""),
        ("angle = { lift = 1.0 }", "angle = «3", "expected a table", ""),
        ("lift = 45.0", "lift = «[1.0]", "expected an angle in degrees", ""),
        ("[sections.rod]\nmaterial = \"steel\"", "«[sections.rod]", "missing key `material`", ""),
        // Arrays that are too long are not cut to size.
        (r#"nodes = ["G", "O"]"#, r#"nodes = «["G", "O", "A"]"#, "must have 2 entries, it has 3", ""),
        (r#"bodies = ["ground", "arm"]"#, r#"bodies = «["ground"]"#, "must have 2 entries, it has 1", ""),
        ("axis = [-1.0, 0.0, 0.0]", "axis = «[-1.0, 0.0]", "must have 3 entries, it has 2", ""),
        ("normal = [1.0, 0.0, 0.0]", "normal = «[1.0, 0.0, 0.0, 0.0]", "must have 3 entries, it has 4", ""),
        (r#"at = [0.0, "height", 0.0]"#, r#"at = «[0.0, "height"]"#, "must have 3 entries, it has 2", ""),
        (r#"[["C", "arm"], "#, r#"«[["C", "arm"], ["G", 1.0], "#, "must have 2 entries, it has 3", ""),
        (r#"["C", "arm"]"#, r#"«["C"]"#, "expected [node, radius]", ""),
        (r#"["C", "arm"]"#, r#"«["C", "arm", 2]"#, "expected [node, radius]", ""),
        (r#"dist = ["O", "C"]"#, r#"dist = «["O", "C", "A"]"#, "must have 2 entries", ""),
        ("shear = [0.44, 0.53]", "shear = «[0.44]", "must have 2 entries", ""),
        // Nodes have two shapes.
        (r#"E = { on = "hand", at = [0.0, "-reach", 0.0] }"#, r#"E = «{ on = "hand" }"#, "this node lacks a key", ""),
        (r#"E = { on = "hand""#, r#"E = «{ branch = 1, on = "hand""#, "mixes the keys of two kinds", ""),
        (r#"E = { on = "hand", at = [0.0, "-reach", 0.0] }"#, "E = «3", "expected { on = body", ""),
        ("branch = -1", "branch = «1.5", "expected a whole number", ""),
    ]);
}

#[test]
fn text_that_is_not_toml() {
    #[rustfmt::skip]
    all_refused(&[
        ("[poses.straight]", "[poses.straight«\n", "unclosed table", ""),
        ("reach = 0.200", "reach = 0.2«.00", "invalid float", ""),
    ]);
    for text in [
        "", "\u{0}", "a = [[[[", "format =", "\u{feff}", "=", "[", "\"", "µ = ½",
    ] {
        let (line, column, message, _) = error_in(text);
        assert!((line, column) >= (1, 1) && !message.is_empty(), "{text:?}");
    }
}

#[test]
fn endless_nesting_is_refused() {
    let many = 100_000;
    for text in [
        format!("a = {}{}", "[".repeat(many), "]".repeat(many)),
        format!("a = {}1{}", "{a=".repeat(many), "}".repeat(many)),
        format!("{} = 1", vec!["a"; many].join(".")),
        format!("[{}]\nb = 1", vec!["a"; many].join(".")),
    ] {
        let (_, _, message, _) = error_in(&text);
        assert!(message.contains("recurs"), "{message}");
    }
}

/// A chain of bodies and nodes longer than any stack is deep.
#[test]
fn long_dependencies_are_followed() {
    let count = 20_000;
    let (mut bodies, mut nodes) = (Vec::new(), Vec::new());
    let (mut body, mut node) = ("ground".to_owned(), "G".to_owned());
    for i in 0..count {
        bodies.push(format!(
            "[[bodies]]\nid = \"b{i}\"\nparent = \"{body}\"\norigin = \"{node}\"\naxis = [1, 0, 0]\n"
        ));
        nodes.push(format!("n{i} = {{ on = \"b{i}\", at = [0, 0, 0.001] }}\n"));
        (body, node) = (format!("b{i}"), format!("n{i}"));
    }
    let text = level_arm::with(
        "[nodes]\n",
        &format!("{}[nodes]\n{}", bodies.concat(), nodes.concat()),
    );
    let robot = parse(&text).unwrap();
    assert_eq!(robot.bodies.len(), count + 5);
}

#[test]
fn the_report_quotes_the_line() {
    let text = level_arm::with("section = \"post\"", "section = \"pots\"");
    let error = parse(&text).unwrap_err();
    assert!(error.to_string().starts_with("arm.toml:14:"), "{error}");
    assert_eq!(error.code().unwrap().to_string(), "stiffbench::robot::file");
    let mut report = String::new();
    miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none())
        .render_report(&mut report, &error)
        .unwrap();
    assert!(
        report.contains("section = \"pots\"") && report.contains("here"),
        "{report}"
    );
}

#[test]
fn unknown_keys_are_warned_about_where_they_stand() {
    #[rustfmt::skip]
    let cases = [
        ("name = \"level arm\"", "name = \"level arm\"\n«colour = \"red\"", "`colour`"),
        ("angle = { lift = 1.0 }", "angle = { lift = 1.0 }\n«mass = 3.0", "`bodies.1.mass`"),
        ("branch = -1 }", "branch = -1, «brnch = 1 }", "`nodes.D.brnch`"),
        ("{ dist = [\"O\", \"C\"] }", "{ dist = [\"O\", \"C\"], «scale = 2 }", "scale`"),
        ("E = 210.0e9", "E = 210.0e9\n«nu = 0.3", "`materials.steel.nu`"),
        ("link = { A = 0.7", "link = { «k = 1.0, A = 0.7", "`factors.fitted.link.k`"),
    ];
    for (find, replacement, name) in cases {
        let (text, (line, column)) = marked(&level_arm::with(find, replacement));
        let robot = parse(&text).unwrap();
        let [warning] = &robot.warnings[..] else {
            panic!("{:?}", robot.warnings)
        };
        let place = format!("arm.toml:{line}:{column}: key ");
        assert!(warning.starts_with(&place), "{warning} for {place}");
        assert!(warning.contains(name), "{warning}");
    }
}

#[test]
fn what_is_optional_may_be_absent() {
    let text = level_arm::text();
    let limits = "terms = { lift = 1.0, trim = 1.0 }\nat_least = -20.0\n";
    let start = text.find("[[limits]]").unwrap();
    let stop = text.find(limits).unwrap() + limits.len();
    let without_limits = format!("{}{}", &text[..start], &text[stop..]);
    assert!(parse(&without_limits).unwrap().limits.is_empty());

    let without_chains = text
        .replace("\nchain = \"host\"\n", "\n")
        .replace("\nchain = \"level\"\n", "\n");
    let robot = parse(&without_chains).unwrap();
    assert!(robot.bodies.iter().all(|body| body.chain.is_none()));

    // No published points and no S-FSD factors in the example.
    let robot = parse(text).unwrap();
    assert!(robot.poses.iter().all(|pose| pose.stated_zy_m.is_none()));
    assert!(robot.factor_set("s_fsd").is_err());
    assert!(robot.factor_set("unit").is_ok());

    for table in ["poses", "factors", "joints", "limits"] {
        let mut value = toml::from_str::<toml::Table>(text).unwrap();
        value.remove(table);
        if table == "joints" {
            // Joints that mechanisms name must be there.
            for (_, mechanism) in value["mechanisms"].as_table_mut().unwrap() {
                let mechanism = mechanism.as_table_mut().unwrap();
                mechanism.remove("drives");
                mechanism.remove("locked");
            }
        }
        let robot = parse(&toml::to_string(&value).unwrap()).unwrap();
        assert_eq!(robot.members.len(), 6, "without {table}");
    }
}

#[test]
fn whole_numbers_are_numbers() {
    let text = level_arm::text()
        .replace("60.0", "60")
        .replace("[0.0,", "[0,")
        .replace("[\"C\", \"arm\"]", "[\"C\", 1]");
    let robot = parse(&text).unwrap();
    assert_eq!(robot.variables[0].max_deg, 60.0);
}

/// What a reader may do with a text: refuse it, or make a robot all of whose poses give finite numbers or an error.
fn survives(text: &str) {
    let Ok(robot) = parse(text) else { return };
    let (_, factors) = robot.default_factors();
    for mechanism in robot.mechanisms.values() {
        let Ok(mut predictor) = Predictor::new(&robot, mechanism, &factors) else {
            continue;
        };
        for named in &robot.poses {
            let _ = mobility(&robot, mechanism, &named.pose);
            if predictor.place(&named.pose).is_ok() {
                let compliance = predictor.compliance();
                let finite = compliance.0.iter().flatten().all(|c| c.is_finite());
                assert!(finite, "{text}");
            }
        }
    }
    let _ = chain_mobility(&robot, &robot.nominal_pose());
}

/// One change of a text: a line removed, doubled, cut, or a number or a word in it replaced.
fn mutated(text: &str, line: usize, kind: usize, spice: usize) -> String {
    const SPICES: [&str; 12] = [
        "nan", "inf", "-1", "0", "1e308", "1e-308", "\"\"", "[]", "{}", "\"A\"", "\u{0}", "\"-\"",
    ];
    let spice = SPICES[spice % SPICES.len()];
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return spice.to_owned();
    }
    let place = line % lines.len();
    let old = lines[place].clone();
    match kind % 6 {
        0 => {
            lines.remove(place);
        }
        1 => lines.insert(place, old),
        2 => {
            let half = old.chars().count() / 2;
            lines[place] = old.chars().take(half).collect();
        }
        3 => lines[place] = old.replace('"', ""),
        4 => {
            if let Some((key, _)) = old.split_once('=') {
                lines[place] = format!("{key}= {spice}");
            }
        }
        _ => {
            let digits = |c: char| c.is_ascii_digit() || c == '.';
            if let Some(start) = old.find(digits) {
                let rest = &old[start..];
                let stop = rest.find(|c| !digits(c)).map_or(old.len(), |n| start + n);
                lines[place] = format!("{}{spice}{}", &old[..start], &old[stop..]);
            }
        }
    }
    lines.join("\n")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn changed_files_never_panic(changes in prop::collection::vec((0..400_usize, 0..6_usize, 0..12_usize), 1..4)) {
        let start = level_arm::text().to_owned();
        let text = changes.into_iter().fold(start, |text, (line, kind, spice)| mutated(&text, line, kind, spice));
        survives(&text);
    }

    #[test]
    fn changed_shipped_robots_never_panic(robot in 0..8_usize, line in 0..600_usize, kind in 0..6_usize, spice in 0..12_usize) {
        let name = shipped_robots().nth(robot).unwrap();
        survives(&mutated(&shipped_robot(name).unwrap().text, line, kind, spice));
    }

    #[test]
    fn arbitrary_text_never_panics(text in "\\PC{0,200}") {
        let _ = parse(&text);
    }
}
