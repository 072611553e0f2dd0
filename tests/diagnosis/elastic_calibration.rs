//! Springs and frames from absolute positions under own weight: against SciPy, closed forms, and what positions do not determine.

use std::fmt::Write as _;

use serde_json::Value;
use stiffbench::robot::GRAVITY_M_PER_S2;
use stiffbench_test_files::text;

use super::robots::RobotFile;
use crate::support::Json;
use crate::support::tables::Table;

/// SciPy fits the same positions with kinematics of its own; its estimates in the deflected pose differ by a share of a standard error.
#[test]
fn springs_and_frames_are_those_of_scipy() {
    let arm = RobotFile::new(text("fixtures/elastic-calibration/arm.toml"));
    let expected = Table::parse(text("fixtures/elastic-calibration/estimates.csv"));
    for data in ["weight", "loads"] {
        let file = format!("fixtures/elastic-calibration/{data}.csv");
        let fit = arm.fit(&Table::parse(text(&file)), "");
        let frames = &fit["frames"];
        let mut seen = 0;
        for row in 0..expected.len() {
            if expected.word(row, "data") != data {
                continue;
            }
            let [name, model] = ["parameter", "model"].map(|column| expected.word(row, column));
            let standard_error: Option<f64> = expected.word(row, "standard_error").parse().ok();
            let axis = || "xyz".find(name.chars().last().unwrap()).unwrap();
            let (value, error) = match name.split_once('.') {
                Some(("joint", _)) => {
                    let one = fit["parameters"].named(name);
                    (one["value"].number(), one["se"].as_f64())
                }
                Some(("base_frame", rotation)) if rotation.starts_with('r') => {
                    let degrees = frames["rotation_vector_deg"][axis()].number();
                    (degrees.to_radians(), None)
                }
                Some((of, _)) => {
                    let own = if of == "base_frame" {
                        "base_mm"
                    } else {
                        "tool_point_mm"
                    };
                    let known = frames["parameters"].named(name);
                    assert_eq!(known["unit"], "um");
                    let se = known["se"].as_f64().map(|um| 1e-6 * um);
                    (1e-3 * frames[own][axis()].number(), se)
                }
                None if name == "scatter" => (1e-6 * fit["displacement_sd_um"].number(), None),
                None => (1e-6 * fit["rms"]["before_um"].number(), None),
            };
            let off = (value - expected.number(row, "value")).abs();
            let off = off / standard_error.unwrap_or(2e-6);
            // Deflected or not makes up to a sixth of a standard error here.
            let allowed = if model == "exact" { 0.2 } else { 1e-3 };
            assert!(off < allowed, "{data} {model} {name}: {value} off by {off}");
            if let (Some(found), Some(expected)) = (error, standard_error)
                && model == "linear"
            {
                let ratio = found / expected;
                assert!((ratio - 1.0).abs() < 1e-3, "{data} {name}: {ratio}");
                seen += 1;
            }
        }
        assert_eq!(seen, if data == "weight" { 11 } else { 12 });
        let first = fit["parameters"].named("joint.J1");
        let words = first["words"].as_str().unwrap_or_default();
        assert_eq!(
            first["status"] == "not_identified" && words.contains("100 N along"),
            data == "weight",
            "{first}"
        );
        let [fitted, unseen] = ["fitted_um", "unseen_um"].map(|state| fit["rms"][state].number());
        let rigid = frames["rigid_unseen_um"].number();
        assert!(
            fitted < 22.0 && unseen < 25.0 && rigid > 500.0,
            "{unseen} {rigid}"
        );
    }
}

/// Of two parallel level axes; the tool 0.5 m out, 0.3 m up.
const TWO_LEVEL: &str = r#"
schema = "stiffbench/robot/2"
name = "two level axes"
up = "z"
[joints]
J1 = { axis = "z", min_deg = -180, max_deg = 180 }
J2 = { axis = "y", min_deg = -80, max_deg = 80, spring = "free" }
drum = { on = "J2", axis = "y", min_deg = -180, max_deg = 180 }
[tool]
on = "J2"
at_mm = [500, 0, 300]
[masses]
arm = { mass_kg = 20, on = "J2", at_mm = [400, 0, 0] }
drum = { mass_kg = 10, on = "drum", at_mm = [250, 0, 0] }
[poses]
P1_deg = [0, 0, 0]
"#;

/// A tracker turned by 90 degrees about z sees the tool sink by c m g l cos θ times its lever; the mass on the drum turns with the drum's own joint.
#[test]
fn one_level_axis_droops_by_its_closed_form() {
    let arm = RobotFile::new(TWO_LEVEL);
    let c = 5e-6;
    let mut rows = String::from(
        "joint_J1_deg,joint_J2_deg,joint_drum_deg,position_x_mm,position_y_mm,position_z_mm\n",
    );
    for i in 0..24 {
        let degrees = [
            -150.0 + 40.0 * f64::from(i % 8),
            -60.0 + 11.0 * f64::from(i % 11),
            37.0 * f64::from(i) - 175.0,
        ];
        let [yaw, pitch, drum] = degrees.map(f64::to_radians);
        let moment =
            GRAVITY_M_PER_S2 * (20.0 * 0.4 * pitch.cos() + 10.0 * 0.25 * (pitch + drum).cos());
        let turn = c * moment;
        // In the plane of the arm, the tool point 0.02 m above the tool centre; a turn by pitch takes x to -z.
        let [x, z] = [0.5, 0.32];
        let [out, up] = [
            x * pitch.cos() + z * pitch.sin(),
            z * pitch.cos() - x * pitch.sin(),
        ];
        let [out, up] = [out + turn * up, up - turn * out];
        let [px, py] = [out * yaw.cos(), out * yaw.sin()];
        let [x, y, z] = [1.0 - py, 2.0 + px, 3.0 + up].map(|m| 1e3 * m);
        let [a, b, d] = degrees;
        writeln!(rows, "{a},{b},{d},{x:.9},{y:.9},{z:.9}").unwrap();
    }
    let json = arm.json(&Table::parse(&rows), "fit");
    let spring = |json: &Value| json["data"]["parameters"].named("joint.J2")["value"].number();
    let found = spring(&json);
    assert!((found / c - 1.0).abs() < 1e-6, "{found}");
    let frames = &json["data"]["frames"];
    for (key, expected) in [
        ("base_mm", [1000.0, 2000.0, 3000.0]),
        ("tool_point_mm", [0.0, 0.0, 20.0]),
    ] {
        for (found, expected) in frames[key].list().iter().zip(expected) {
            assert!((found.number() - expected).abs() < 1e-5, "{frames}");
        }
    }
    // The drum standing still would be another arm.
    let still = rows.replace("joint_drum_deg", "note");
    let json = arm.json(&Table::parse(&still), "fit");
    let mut warnings = json["warnings"].list().iter();
    assert!(warnings.any(|words| words.word().contains("drum")));
    let wrong = spring(&json);
    assert!((wrong / c - 1.0).abs() > 1e-3, "{wrong}");
}

#[test]
fn too_few_positions_are_refused() {
    let arm = RobotFile::new(TWO_LEVEL);
    let rows = "joint_J1_deg,joint_J2_deg,position_x_mm,position_y_mm,position_z_mm\n0,0,1,2,3\n10,20,2,3,4\n20,30,,1,2\n30,40,3,,4\n";
    let error = Table::parse(rows).refusal("fit", &arm.option());
    let error = error["error"]["message"].word();
    assert!(error.contains("2 poses") && error.contains('4'), "{error}");
}
