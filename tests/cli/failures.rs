//! What the program refuses: the code of the error, the exit code, and what it tells the user to do.

use super::{Ran, assert_output_contains, desk, desk_with_session, five_columns};

#[test]
fn data_that_are_not_there() {
    let desk = desk();
    desk.write("folder/notes.txt", "no session");
    desk.write("empty.csv", "");
    let error = desk.refusal("stiffness nowhere", 11, "stiffbench::input::not_found");
    assert_output_contains(&error, &["nowhere", "session folder"]);
    let error = desk.refusal("fit paper-experimint", 11, "stiffbench::input::not_found");
    assert_output_contains(&error, &["did you mean paper-experiment"]);
    let error = desk.refusal("stiffness folder", 11, "stiffbench::input::no_session");
    assert_output_contains(&error, &["folder holds no readings.csv"]);
    for subcommand in ["stiffness", "fit", "plot residuals", "compare empty.csv"] {
        desk.refusal(
            &format!("{subcommand} empty.csv"),
            11,
            "stiffbench::readings::empty",
        );
    }
}

#[test]
fn wrong_readings_are_named_by_file_line_and_column() {
    let desk = desk();
    desk.write(
        "word.csv",
        "pose,direction,repeat,force_N,displacement_um\nP1,x,1,-10,-5\nP1,x,1,-20,abc\n",
    );
    let error = desk.refusal("stiffness word.csv", 11, "stiffbench::readings::bad_value");
    assert_output_contains(
        &error,
        &["word.csv", "line 3", "displacement_um", "abc", "number"],
    );
    // The line as it stands, with a mark under the value.
    let printed = desk.run("stiffness word.csv").stderr;
    assert!(
        printed.contains("  3 | P1,x,1,-20,abc\n    |            ^^^\n"),
        "{printed}"
    );
    desk.write(
        "column.csv",
        "pose,direction,force_N,displacement_um\nP1,x,-10,-5\n",
    );
    let error = desk.refusal(
        "stiffness column.csv",
        11,
        "stiffbench::readings::missing_column",
    );
    assert_output_contains(&error, &["column.csv", "line 1", "repeat"]);
    desk.write(
        "direction.csv",
        "pose,direction,repeat,force_N,displacement_um\nP1,w,1,-10,-5\n",
    );
    let error = desk.refusal(
        "stiffness direction.csv",
        11,
        "stiffbench::readings::bad_value",
    );
    assert_output_contains(&error, &["line 2", "direction", "`w`"]);
}

#[test]
fn a_pose_that_the_robot_does_not_have_is_refused_with_the_nearest_name() {
    let desk = desk();
    desk.write("typo.csv", &five_columns(&["P1", "P2a"], 2));
    let error = desk.refusal(
        "fit typo.csv --robot hp-robot",
        11,
        "stiffbench::readings::unknown_pose",
    );
    assert_output_contains(&error, &["typo.csv", "line 26", "`P2a`", "`P2` meant"]);
    desk.write(
        "list.csv",
        "pose,direction,stiffness_N_per_um\nP1,x,0.01\nP7,x,0.01\n",
    );
    let error = desk.refusal(
        "fit list.csv --robot hp-robot",
        10,
        "stiffbench::robot::unknown_name",
    );
    assert_output_contains(&error, &["`P7`", "P1, P2, P3, P4"]);
    // Stiffness needs no robot: any name will do.
    desk.run("stiffness typo.csv").succeeds();
}

#[test]
fn stiffness_values_where_readings_are_needed() {
    let desk = desk();
    desk.write("list.csv", "pose,direction,stiffness_N_per_um\nP1,x,0.01\n");
    for arguments in [
        "stiffness list.csv",
        "stiffness paper-experiment",
        "compare list.csv paper-experiment",
        "plot load-displacement list.csv",
        "plot residuals paper-experiment",
        "fit paper-experiment --bootstrap 10",
    ] {
        let error = desk.refusal(arguments, 2, "stiffbench::usage::needs_readings");
        assert_output_contains(
            &error,
            &["holds stiffness values, not readings", "session folder"],
        );
    }
    desk.write(
        "twice.csv",
        "pose,direction,stiffness_N_per_um\nP1,x,0.01\nP1,x,0.02\n",
    );
    desk.refusal(
        "fit twice.csv",
        11,
        "stiffbench::fit::stiffness_list_duplicate",
    );
    desk.write("word.csv", "pose,direction,stiffness_N_per_um\nP1,x,soft\n");
    let error = desk.refusal("fit word.csv", 11, "stiffbench::readings::bad_value");
    assert_output_contains(&error, &["word.csv", "soft"]);
}

#[test]
fn names_that_do_not_exist() {
    let desk = desk();
    let unknown = "stiffbench::robot::unknown_name";
    assert_output_contains(
        &desk.refusal("robot compliance --pose P9", 10, unknown),
        &["`P9`", "P1, P2, P3, P4"],
    );
    assert_output_contains(
        &desk.refusal("robot compliance --mechanism Z", 10, unknown),
        &["`Z`", "A, B, C, D, E, F"],
    );
    assert_output_contains(
        &desk.refusal("robot compliance --set theta9=3", 10, unknown),
        &["did you mean `theta"],
    );
    assert_output_contains(
        &desk.refusal("robot workspace --vary thetaa", 10, unknown),
        &["theta1"],
    );
    assert_output_contains(
        &desk.refusal("fit paper-experiment --factors nope", 10, unknown),
        &["m_fsd"],
    );
    assert_output_contains(
        &desk.refusal("significance --pose P0", 10, unknown),
        &["P1"],
    );
    assert_output_contains(&desk.refusal("simulate s --poses P9", 10, unknown), &["P1"]);
    assert_output_contains(
        &desk.refusal(
            "fit paper-experiment --factors nope.toml",
            11,
            "stiffbench::input::read",
        ),
        &["nope.toml"],
    );
    let argument = "stiffbench::usage::argument";
    assert_output_contains(
        &desk.refusal("robot show nope", 2, argument),
        &["hp-robot, hp-robot-host-dominant, serial-arm"],
    );
    assert_output_contains(
        &desk.refusal(
            "fit paper-experiment --fix beam.Q",
            2,
            "stiffbench::robot::model_parameter",
        ),
        &["beam.Iy"],
    );
    assert!(
        !desk.path("s").exists(),
        "a simulation that cannot be leaves no folder"
    );
}

#[test]
fn arguments_without_meaning() {
    let desk = desk();
    let argument = "stiffbench::usage::argument";
    for (arguments, words) in [
        (
            "fit paper-experiment --bounds 2 3",
            ["both sides of 1", "--bounds 0.1..10"],
        ),
        (
            "fit paper-experiment --bounds -1 10",
            ["--bounds -1..10", "both sides of 1"],
        ),
        (
            "fit paper-experiment --bounds 0.1 inf",
            ["inf", "two numbers"],
        ),
        (
            "fit paper-experiment --bounds 0.1",
            ["two numbers", "--bounds 0.1..10"],
        ),
        (
            "session run s --no-input --effect gauge-stand-compliance@y:c=1um/N",
            ["emulated bench only", "--emulated"],
        ),
        (
            "fit paper-experiment --tie link.A",
            ["equals sign", "--tie link.A=beam.A"],
        ),
        (
            "fit paper-experiment --train P1,P9",
            ["P9", "P1, P2, P3, P4"],
        ),
        ("fit paper-experiment --train P1,P1", ["P1", "twice"]),
        (
            "fit paper-experiment --sigma known",
            ["no uncertainty", "u_N_per_um"],
        ),
        (
            "fit paper-experiment --weights 1,2",
            ["--weights", "--method paper"],
        ),
        (
            "fit paper-experiment --method paper --fix beam.J",
            ["--fix", "--method least-squares"],
        ),
        (
            "fit paper-experiment --method paper --weights 1",
            ["1 weights for 4", "--train"],
        ),
        (
            "robot compliance --set theta2",
            ["equals sign", "--set theta2=397.3"],
        ),
        (
            "robot compliance --set theta2=wide",
            ["theta2=wide", "degrees"],
        ),
        ("plot residuals", ["DATA", "measured data"]),
        ("plot robot --out robot.pdf", ["SVG and PNG", "pdf"]),
        (
            "simulate s --true-factor beam.Iy",
            ["equals sign", "beam.Iy=0.006"],
        ),
        (
            "simulate s --true-factor beam.Iy=-1",
            ["above zero", "beam.Iy=0.006"],
        ),
    ] {
        assert_output_contains(&desk.refusal(arguments, 2, argument), &words);
    }
    desk.refusal(
        "fit paper-experiment --tie link.A=beam.Q",
        2,
        "stiffbench::robot::model_parameter",
    );
    desk.refusal(
        "fit paper-experiment --tie link.A=link.Iy,link.Iy=link.A",
        2,
        "stiffbench::least_squares::tie_cycle",
    );
    desk.refusal(
        "fit paper-experiment --method paper --weights=-1,1,1,1",
        2,
        "stiffbench::fit::weights",
    );
    desk.refusal(
        "simulate s --reading-sd-um -1",
        10,
        "stiffbench::bench::noise",
    );
}

#[test]
fn procedures_that_cannot_be_followed() {
    let desk = desk();
    for (arguments, code) in [
        ("--repeats 0", "no_repeat"),
        ("--loads-n 0,nan", "not_finite"),
        ("--loads-N 0", "only_zero"),
        ("--poses P1,P1", "twice"),
        ("--force-tolerance-n -1", "negative"),
    ] {
        let code = format!("stiffbench::procedure::{code}");
        desk.refusal(&format!("simulate s {arguments}"), 10, &code);
    }
    assert_output_contains(
        &desk.refusal(
            "simulate s --procedure sweps",
            2,
            "stiffbench::usage::argument",
        ),
        &["did you mean sweeps?", "load-hold-unload"],
    );
    desk.write(
        "wrong.toml",
        "schema = \"stiffbench/procedure/1\"\nrepeats = many\n",
    );
    assert_output_contains(
        &desk.refusal(
            "simulate s --procedure wrong.toml",
            10,
            "stiffbench::procedure::file",
        ),
        &["wrong.toml:2:"],
    );
    assert!(!desk.path("s").exists());
}

#[test]
fn arguments_that_do_not_parse() {
    let desk = desk();
    for (arguments, word) in [
        ("nonsense", "nonsense"),
        ("stiffness", "<DATA>"),
        ("robot", "subcommand"),
        ("stiffness a b", "'b'"),
        ("simulate s --directions w", "is not a direction: x, y, z"),
        ("plot robot --load 1,2", "three numbers"),
        ("plot robot --load nan,0,0", "three numbers"),
        ("robot workspace --samples 0", "0"),
        ("plot cake", "load-displacement"),
    ] {
        if arguments == "robot" {
            // clap prints the whole help here.
            desk.run(arguments).exits_with(2);
            continue;
        }
        assert_output_contains(&desk.refusal(arguments, 2, "stiffbench::usage"), &[word]);
    }
}

#[test]
fn fits_that_cannot_be() {
    let desk = desk();
    desk.write("one.csv", &five_columns(&["P1"], 2));
    let error = desk.refusal(
        "fit one.csv --robot hp-robot",
        40,
        "stiffbench::fit::too_few_cells",
    );
    assert_output_contains(&error, &["4 free factors", "3 cells", "--fix"]);
    let fixed = "fit paper-experiment --fix beam.A,beam.Iy,beam.Iz,beam.J";
    desk.refusal(fixed, 40, "stiffbench::least_squares::no_free_parameter");
    desk.write(
        "two-directions.csv",
        "pose,direction,stiffness_N_per_um\nP1,x,0.01\nP1,y,0.03\n",
    );
    let error = desk.refusal(
        "fit two-directions.csv --robot hp-robot --method paper",
        40,
        "stiffbench::fit::missing_direction",
    );
    assert_output_contains(&error, &["P1", "z"]);
}

#[test]
fn parameters_that_cannot_be_fitted() {
    let desk = desk_with_session();
    let cases = [
        (
            "fit session --free joint.Z9",
            "stiffbench::robot::unknown_name",
            "Z9",
        ),
        (
            "fit session --bounds 10..0.1",
            "stiffbench::usage::argument",
            "lower one first",
        ),
        (
            "fit session --bounds beam.Iz=2..3",
            "stiffbench::usage::argument",
            "lies outside",
        ),
        (
            "fit session --bounds joint.A3=-1..3",
            "stiffbench::usage::argument",
            "below zero",
        ),
        (
            "fit session --tie joint.A3=beam.A",
            "stiffbench::fit::tie",
            "spring to a spring",
        ),
        (
            "diagnose session --tie link.A=beam.A",
            "stiffbench::mismatch::parameter",
            "ties none",
        ),
        (
            "fit session --factors wrong.toml",
            "stiffbench::robot::factor_file",
            "Z9",
        ),
        (
            "fit session --factors low.toml",
            "stiffbench::robot::factor_file",
            "joint.A3",
        ),
    ];
    let good = "beam = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }\nlink = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }\n";
    desk.write(
        "wrong.toml",
        &format!("{good}joints_rad_per_Nm = {{ Z9 = 1e-6 }}\n"),
    );
    desk.write(
        "low.toml",
        &format!("{good}joints_rad_per_Nm = {{ A3 = -1e-6 }}\n"),
    );
    for (command, code, word) in cases {
        let ran = desk.run(&format!("{command} --json"));
        assert_ne!(ran.code, 0, "{command}");
        let error = ran.json()["error"].take();
        assert_eq!(error["code"], code, "{command}: {error}");
        assert_output_contains(&error, &[word]);
    }
}

#[test]
fn files_of_robots_factors_and_sessions_that_are_wrong() {
    let desk = desk();
    let robot = include_str!("../../data/robots/serial-arm.toml");
    desk.write(
        "robot.toml",
        &robot.replacen("[poses.P1]", "[poses.P1]\ntheta22 = 3", 1),
    );
    let error = desk.refusal("robot show robot.toml", 10, "stiffbench::robot::file");
    assert_output_contains(
        &error,
        &["robot.toml:", "theta22", "did you mean `theta2`?"],
    );
    desk.write("syntax.toml", "format = ");
    assert_output_contains(
        &desk.refusal("robot check syntax.toml", 10, "stiffbench::robot::file"),
        &["syntax.toml:1:"],
    );
    let good = "beam = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }\nlink = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }\n";
    desk.write("good.toml", good);
    desk.run("robot compliance --factors good.toml").succeeds();
    for wrong in [
        good.replacen("A = 1.0", "A = -1.0", 1),
        good.replacen("A = 1.0, ", "", 1),
        "x".to_owned(),
    ] {
        desk.write("factors.toml", &wrong);
        let error = desk.refusal(
            "robot compliance --factors factors.toml",
            10,
            "stiffbench::robot::factor_file",
        );
        assert_output_contains(&error, &["factors.toml", "fit --save-factors"]);
    }
    desk.write("session/readings.csv", &five_columns(&["P1", "P2"], 2));
    desk.write(
        "session/session.toml",
        "schema = \"stiffbench/session/9\"\n",
    );
    desk.refusal(
        "stiffness session",
        10,
        "stiffbench::session_file::newer_schema",
    );
    desk.write(
        "session/session.toml",
        "schema = \"stiffbench/session/1\"\nrobot = \"gone.toml\"\n",
    );
    desk.run("stiffness session").succeeds();
    let error = desk.refusal("fit session", 10, "stiffbench::session_file::robot");
    assert_output_contains(&error, &["gone.toml", "session.toml", "--robot"]);
}

#[test]
fn a_session_is_never_written_over() {
    let desk = desk_with_session();
    let before = desk.read("session/readings.csv");
    let error = desk.refusal(
        "simulate session --seed 9",
        13,
        "stiffbench::output::exists",
    );
    assert_output_contains(&error, &["session exists already", "another name"]);
    assert_eq!(desk.read("session/readings.csv"), before);
    desk.write("file", "");
    desk.refusal("demo --out file/demo", 14, "stiffbench::output::write");
    desk.refusal(
        "plot robot --out file/robot.svg",
        14,
        "stiffbench::output::write",
    );
}

/// A reader that has seen enough (`| head`) is no failure; a full disk is one.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_no_more() {
    use std::io::Read;
    use std::process::{Command, Stdio};

    let program = env!("CARGO_BIN_EXE_stiffbench");
    // More text than a pipe holds, so that the program writes into a pipe that nobody reads any more.
    let mut child = Command::new(program)
        .args(["completions", "bash"])
        // Of the tests: no setting of the program.
        .env_remove("STIFFBENCH_GOLDENS")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 10];
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut first).unwrap();
    drop(stdout);
    let output = child.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.status.success());

    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let output = Command::new(program)
        .args(["robot", "show"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(14));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output"));
}

#[test]
fn a_robot_file_in_another_folder_is_found_from_anywhere() {
    let desk = desk();
    let robot = include_str!("../../data/robots/serial-arm.toml");
    desk.write(
        "robots/mine.toml",
        &robot.replacen("plain three-link serial arm", "my own arm", 1),
    );
    let robot = desk.path("robots/mine.toml");
    let robot = robot.display();
    let ran = desk.run(&format!("robot show {robot}")).succeeds();
    assert!(
        ran.stdout.starts_with("Robot: my own arm ("),
        "{}",
        ran.stdout
    );
    desk.run(&format!("simulate deep/er/session --robot {robot}"))
        .succeeds();
    // The session keeps its own copy, and is read with it from any other folder.
    let mut elsewhere = desk.command("fit ../session --json");
    std::fs::create_dir(desk.path("deep/er/elsewhere")).unwrap();
    let fit = Ran::of(elsewhere.current_dir(desk.path("deep/er/elsewhere")))
        .succeeds()
        .json();
    assert_eq!(fit["data"]["mechanism"], "A");
    assert_eq!(fit["data"]["cells"].as_array().unwrap().len(), 12);
    // A robot that was changed after the session is used only if it is named, and that is said.
    let changed = desk.read("deep/er/session/robot.toml") + "\n# changed\n";
    desk.write("deep/er/session/robot.toml", &changed);
    desk.refusal("fit deep/er/session", 10, "stiffbench::robot::other_file");
    let named = "fit deep/er/session --robot deep/er/session/robot.toml";
    let ran = desk.run(named).succeeds();
    assert!(ran.stderr.contains("SHA-256 differs"), "{}", ran.stderr);
}

#[test]
fn data_without_a_robot_get_no_model() {
    let desk = desk();
    desk.write("bare.csv", &five_columns(&["P1", "P2"], 3));
    desk.write(
        "list.csv",
        "pose,direction,stiffness_N_per_um\nP1,x,0.01\nP2,x,0.01\nP3,x,0.01\n",
    );
    for command in [
        "fit bare.csv",
        "fit list.csv",
        "diagnose bare.csv",
        "plot residuals bare.csv",
    ] {
        let error = desk.refusal(command, 2, "stiffbench::usage::no_robot");
        assert_output_contains(&error, &["--robot", "hp-robot", "serial-arm"]);
    }
}
