//! Springs and frames from absolute positions under own weight: against SciPy, closed forms, and what positions do not determine.

use std::fmt::Write as _;

use stiffbench_beams::robot::{FittingFactors, GRAVITY_M_PER_S2, Robot};
use stiffbench_diagnosis::elastostatics::{
    LoadCaseFit, LoadCaseFitError, LoadCaseFitOptions, LoadCaseModel, PosedLoadCases,
    fit_load_cases, usual_choice,
};
use stiffbench_diagnosis::fit::FactorStatus;
use stiffbench_measurement::load_cases::{LoadCaseTable, read_load_cases};
use stiffbench_measurement::readings::ReadOptions;
use stiffbench_test_files::text;
use stiffbench_units_and_text::source_text::SourceText;

fn robot(name: &str, text: &str) -> Robot {
    Robot::parse(&SourceText::new(name, text.to_owned())).unwrap()
}

fn table(text: &str) -> LoadCaseTable {
    read_load_cases("positions.csv", text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn try_fit(robot: &Robot, table: &LoadCaseTable) -> Result<LoadCaseFit, LoadCaseFitError> {
    let mechanism = robot.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, table).unwrap();
    let start = robot.with_own_springs(&FittingFactors::UNIT);
    let options = LoadCaseFitOptions {
        choice: usual_choice(robot, mechanism, &start, &posed)?,
        ..LoadCaseFitOptions::default()
    };
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: &start,
        posed: &posed,
    };
    fit_load_cases(&model, &options)
}

/// One row of `fixtures/elastic-calibration/estimates.csv`.
#[derive(serde::Deserialize)]
struct Estimate {
    data: String,
    model: String,
    parameter: String,
    value: f64,
    standard_error: Option<f64>,
}

fn estimates() -> Vec<Estimate> {
    let text = text("fixtures/elastic-calibration/estimates.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

/// SciPy fits the same positions with kinematics of its own; its estimates in the deflected pose differ by a share of a standard error.
#[test]
fn springs_and_frames_are_those_of_scipy() {
    let arm = robot("arm.toml", text("fixtures/elastic-calibration/arm.toml"));
    let expected = estimates();
    for (data, file) in [
        ("weight", text("fixtures/elastic-calibration/weight.csv")),
        ("loads", text("fixtures/elastic-calibration/loads.csv")),
    ] {
        let fit = try_fit(&arm, &table(file)).unwrap();
        let frames = fit.frames.as_ref().unwrap();
        let turn = frames.frames.rotation_vector_rad();
        let [before, ..] = fit.rms_m();
        let mut seen = 0;
        for row in expected.iter().filter(|row| row.data == data) {
            let axis = |name: &str| "xyz".find(name.chars().last().unwrap()).unwrap();
            let (value, error) = match row.parameter.split_once('.') {
                Some(("joint", _)) => {
                    let one = fit.estimate(&row.parameter).unwrap();
                    (one.value, one.standard_uncertainty)
                }
                Some(("base_frame", name)) if name.starts_with('r') => (turn[axis(name)], None),
                Some((of, name)) => {
                    let own = if of == "base_frame" {
                        frames.frames.base_m
                    } else {
                        frames.frames.tool_point_m
                    };
                    let mut known = frames.parameters.iter();
                    (
                        own[axis(name)],
                        known
                            .find(|one| one.name == row.parameter)
                            .unwrap()
                            .standard_error,
                    )
                }
                None if row.parameter == "scatter" => (
                    fit.agreement.as_ref().unwrap().displacement_sd_m.unwrap(),
                    None,
                ),
                None => (before.unwrap(), None),
            };
            let ratio = row.standard_error.unwrap_or(2e-6);
            let off = (value - row.value).abs() / ratio;
            // Deflected or not makes up to a sixth of a standard error here.
            let allowed = if row.model == "exact" { 0.2 } else { 1e-3 };
            assert!(
                off < allowed,
                "{data} {} {}: {value} off by {off}",
                row.model,
                row.parameter
            );
            if let (Some(found), Some(expected)) = (error, row.standard_error)
                && row.model == "linear"
            {
                let ratio = found / expected;
                assert!(
                    (ratio - 1.0).abs() < 1e-3,
                    "{data} {}: {ratio}",
                    row.parameter
                );
                seen += 1;
            }
        }
        assert_eq!(seen, if data == "weight" { 11 } else { 12 });
        let first = &fit.estimate("joint.J1").unwrap().status;
        assert_eq!(
            matches!(first, FactorStatus::NotIdentified { words } if words.contains("100 N along")),
            data == "weight",
            "{first:?}"
        );
        let [_, fitted, unseen] = fit.rms_m().map(Option::unwrap);
        let rigid = frames.rigid_unseen_m.unwrap();
        assert!(
            fitted < 22e-6 && unseen < 25e-6 && rigid > 500e-6,
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
    let arm = robot("level.toml", TWO_LEVEL);
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
    let fit = try_fit(&arm, &table(&rows)).unwrap();
    let found = fit.estimate("joint.J2").unwrap().value;
    assert!((found / c - 1.0).abs() < 1e-6, "{found}");
    let frames = fit.frames.unwrap().frames;
    for (found, expected) in frames.base_m.iter().zip([1.0, 2.0, 3.0]) {
        assert!((found - expected).abs() < 1e-8, "{frames:?}");
    }
    for (found, expected) in frames.tool_point_m.iter().zip([0.0, 0.0, 0.02]) {
        assert!((found - expected).abs() < 1e-8, "{frames:?}");
    }
    // The drum standing still would be another arm.
    let still = rows.replace("joint_drum_deg", "note");
    let mechanism = arm.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(&arm, mechanism, &table(&still)).unwrap();
    assert!(posed.warnings.iter().any(|words| words.contains("drum")));
    let wrong = try_fit(&arm, &table(&still)).unwrap();
    let wrong = wrong.estimate("joint.J2").unwrap().value;
    assert!((wrong / c - 1.0).abs() > 1e-3, "{wrong}");
}

#[test]
fn too_few_positions_are_refused() {
    let arm = robot("level.toml", TWO_LEVEL);
    let rows = "joint_J1_deg,joint_J2_deg,position_x_mm,position_y_mm,position_z_mm\n0,0,1,2,3\n10,20,2,3,4\n20,30,,1,2\n30,40,3,,4\n";
    let error = try_fit(&arm, &table(rows)).unwrap_err().to_string();
    assert!(error.contains("2 poses") && error.contains('4'), "{error}");
}
