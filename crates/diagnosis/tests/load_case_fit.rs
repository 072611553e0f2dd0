//! Fits to load cases: a real robot against figures of another program, known springs found again, and what poses do not determine.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot};
use stiffbench_diagnosis::elastostatics::{
    LoadCaseFit, LoadCaseFitOptions, LoadCaseModel, PosedLoadCases, ScatterSource, fit_load_cases,
    usual_choice,
};
use stiffbench_diagnosis::fit::FactorStatus;
use stiffbench_diagnosis::parameters::{FitRole, ParameterChoice};
use stiffbench_measurement::load_cases::{LoadCaseTable, read_load_cases};
use stiffbench_measurement::readings::ReadOptions;
use stiffbench_test_files::text;
use stiffbench_units_and_text::source_text::SourceText;

/// Compliance and standard error of each joint, µrad/(N·m): ordinary least squares by NumPy on J (Jᵀ F), from the DH table.
const FANUC: [(f64, f64); 6] = [
    (1.162, 0.041),
    (0.368, 0.060),
    (0.510, 0.061),
    (3.69, 0.52),
    (2.36, 0.40),
    (4.9, 2.3),
];

fn table(name: &str, text: &str) -> LoadCaseTable {
    read_load_cases(name, text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn fanuc() -> (Robot, LoadCaseTable) {
    let path = "data/robots/fanuc-r2000ic.toml";
    let robot = Robot::parse(&SourceText::new(path, text(path))).unwrap();
    let path = "data/load-cases/fanuc-r2000ic/readings.csv";
    (robot, table(path, text(path)))
}

fn fit(robot: &Robot, table: &LoadCaseTable, options: Option<LoadCaseFitOptions>) -> LoadCaseFit {
    let mechanism = robot.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, table).unwrap();
    let mut start = FittingFactors::UNIT;
    for (spring, _) in robot.own_springs() {
        start.set(&spring, 0.0);
    }
    let options = options.unwrap_or_else(|| LoadCaseFitOptions {
        choice: usual_choice(robot, mechanism, &start, &posed).unwrap(),
        ..LoadCaseFitOptions::default()
    });
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: &start,
        posed: &posed,
    };
    fit_load_cases(&model, &options).unwrap()
}

#[test]
fn a_real_robot_gives_the_springs_that_numpy_gives() {
    let (robot, table) = fanuc();
    let fit = fit(&robot, &table, None);
    for (joint, (compliance, error)) in FANUC.into_iter().enumerate() {
        let name = format!("joint.J{}", joint + 1);
        let estimate = fit.estimate(&name).unwrap();
        let difference = (1e6 * estimate.value - compliance) / error;
        assert!(
            difference.abs() < 0.1,
            "{name}: {} off by {difference}",
            estimate.value
        );
        let ratio = 1e6 * estimate.standard_uncertainty.unwrap() / error;
        assert!(
            (0.97..1.03).contains(&ratio),
            "{name}: standard error {ratio}"
        );
        let [low, high] = estimate.interval_95.unwrap();
        // Student's t with 123 degrees of freedom.
        let half = 1.9794 * estimate.standard_uncertainty.unwrap();
        assert!((estimate.value - low - half).abs() < 2e-3 * half);
        assert!((high - estimate.value - half).abs() < 2e-3 * half);
        assert_eq!(estimate.status, FactorStatus::Free);
    }
    let [before, fitted, unseen] = fit.rms_m().map(|rms| 1e6 * rms.unwrap());
    assert!((before - 996.0).abs() < 1.0, "{before}");
    assert!((unseen - 234.0).abs() < 1.0, "{unseen}");
    assert!(fitted < unseen);
    let agreement = fit.agreement.unwrap();
    assert_eq!(agreement.source, ScatterSource::Residuals);
    assert_eq!((agreement.dof, agreement.rank, agreement.free), (123, 6, 6));
    assert!((agreement.condition - 3.49).abs() < 0.01);
}

/// The column J (Jᵀ F) of every joint in one pose, from the modified DH table alone.
fn columns(pendant: &[f64], force: [f64; 3]) -> Vec<[f64; 3]> {
    let rows = [
        (0.0, 0.0, 0.0, 0.670),
        (-FRAC_PI_2, 0.312, -FRAC_PI_2, 0.0),
        (0.0, 1.075, 0.0, 0.0),
        (-FRAC_PI_2, 0.225, 0.0, 1.280),
        (FRAC_PI_2, 0.0, 0.0, 0.0),
        (-FRAC_PI_2, 0.0, 0.0, 0.215),
    ];
    let p = pendant;
    let q = [p[0], p[1], -(p[1] + p[2]), -p[3], -p[4], -p[5]];
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut origin = [0.0; 3];
    let along = |axes: &[[f64; 3]; 3], local: [f64; 3]| -> [f64; 3] {
        [0, 1, 2].map(|i| (0..3).map(|k| local[k] * axes[k][i]).sum())
    };
    let mut joints = Vec::new();
    for ((alpha, a, theta0, d), q) in rows.into_iter().zip(q) {
        let (sa, ca) = f64::sin_cos(alpha);
        let (st, ct) = f64::sin_cos(theta0 + q);
        let shift = along(&axes, [a, -sa * d, ca * d]);
        origin = [0, 1, 2].map(|i| origin[i] + shift[i]);
        axes = [
            along(&axes, [ct, st * ca, st * sa]),
            along(&axes, [-st, ct * ca, ct * sa]),
            along(&axes, [0.0, -sa, ca]),
        ];
        joints.push((origin, axes[2]));
    }
    let tool = along(&axes, [0.0069, 0.2453, 0.3193]);
    let end = [0, 1, 2].map(|i| origin[i] + tool[i]);
    let column = |(at, [x, y, z]): ([f64; 3], [f64; 3])| {
        let [u, v, w] = [0, 1, 2].map(|i| end[i] - at[i]);
        let lever = [y * w - z * v, z * u - x * w, x * v - y * u];
        let moment: f64 = (0..3).map(|i| lever[i] * force[i]).sum();
        lever.map(|lever| lever * moment)
    };
    joints.into_iter().map(column).collect()
}

#[test]
fn predictions_are_those_of_the_jacobian() {
    let (robot, table) = fanuc();
    let fit = fit(&robot, &table, None);
    let compliances: Vec<f64> = (1..=6)
        .map(|joint| fit.estimate(&format!("joint.J{joint}")).unwrap().value)
        .collect();
    let mut components = fit.components.iter();
    for case in &table.cases {
        let columns = columns(&case.joints, case.force_n);
        for axis in 0..3 {
            let expected: f64 = columns
                .iter()
                .zip(&compliances)
                .map(|(j, c)| j[axis] * c)
                .sum();
            let found = components.next().unwrap().predicted;
            assert!(
                (found - expected).abs() < 2e-9,
                "{}: {found} {expected}",
                case.line
            );
        }
    }
}

/// The table of six-axis loads in some poses, with displacements of the given springs as a fit predicts them.
fn simulated(
    robot: &Robot,
    mechanism: &Mechanism,
    poses: &[[f64; 6]],
    truth: &FittingFactors,
    sd_um: f64,
    repeats: u32,
) -> LoadCaseTable {
    let mut text = String::from("pose,repeat");
    for joint in 1..=6 {
        write!(text, ",joint_J{joint}_deg").unwrap();
    }
    text +=
        ",force_x_N,force_y_N,force_z_N,displacement_x_um,displacement_y_um,displacement_z_um\n";
    for (pose, angles) in poses.iter().enumerate() {
        for force in ["200,0,0", "0,200,0", "0,0,200"] {
            for repeat in 1..=repeats {
                let angles: Vec<String> = angles.iter().map(f64::to_string).collect();
                writeln!(text, "P{pose},{repeat},{},{force},1,1,1", angles.join(",")).unwrap();
            }
        }
    }
    let mut made = table("simulated.csv", &text);
    let posed = PosedLoadCases::new(robot, mechanism, &made).unwrap();
    let mut choice = ParameterChoice::default();
    for joint in mechanism.joints(robot) {
        let name = robot.joints[joint].name.as_str();
        choice.set(&ModelParameter::Joint(name.into()), FitRole::Fixed);
    }
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: truth,
        posed: &posed,
    };
    let predicted = model.predicted().unwrap();
    let mut random = 12_345_u64;
    let mut noise = || {
        // Irwin-Hall of twelve: mean 0, variance 1.
        let sum: f64 = (0..12)
            .map(|_| {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (random >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum();
        sum - 6.0
    };
    for (case, predicted) in made.cases.iter_mut().zip(predicted.chunks(3)) {
        for (read, predicted) in case.displacement_m.iter_mut().zip(predicted) {
            *read = Some(predicted + 1e-6 * sd_um * noise());
        }
    }
    made
}

fn truth() -> FittingFactors {
    let mut truth = FittingFactors::UNIT;
    for (joint, c) in [1.2e-6, 0.4e-6, 0.6e-6, 3e-6, 2.4e-6, 5e-6]
        .into_iter()
        .enumerate()
    {
        let name = format!("J{}", joint + 1);
        truth.set(&ModelParameter::Joint(name.as_str().into()), c);
    }
    truth
}

const POSES: [[f64; 6]; 4] = [
    [0.0, -20.0, 10.0, 30.0, 60.0, -40.0],
    [40.0, 30.0, -30.0, -60.0, -70.0, 100.0],
    [-60.0, 10.0, 20.0, 90.0, 40.0, 10.0],
    [90.0, 50.0, -10.0, -120.0, 80.0, 170.0],
];

#[test]
fn known_springs_are_found_from_repeats_with_their_scatter() {
    let (robot, _) = fanuc();
    let mechanism = robot.mechanism(None).unwrap();
    let exact = simulated(&robot, mechanism, &POSES, &truth(), 0.0, 1);
    let found = fit(&robot, &exact, None);
    let noisy = simulated(&robot, mechanism, &POSES, &truth(), 8.0, 4);
    let noisy = fit(&robot, &noisy, None);
    for parameter in truth().springs() {
        let (name, expected) = (parameter.to_string(), truth().get(&parameter));
        let value = found.estimate(&name).unwrap().value;
        // Links a million times stiffer than the springs leave six digits.
        assert!((value / expected - 1.0).abs() < 1e-5, "{name}: {value}");
        let estimate = noisy.estimate(&name).unwrap();
        let off = (estimate.value - expected) / estimate.standard_uncertainty.unwrap();
        assert!(off.abs() < 4.0, "{name}: {off} standard errors off");
    }
    let agreement = noisy.agreement.unwrap();
    assert_eq!(agreement.source, ScatterSource::Repeats);
    // Four repeats of 36 components: 108 degrees of freedom.
    assert_eq!(agreement.scatter_dof, 108.0);
    let sd = 1e6 * agreement.displacement_sd_m.unwrap();
    assert!((sd / 8.0 - 1.0).abs() < 0.3, "{sd}");
    assert!(agreement.p.unwrap() > 1e-3);
}

#[test]
fn a_spring_that_a_pose_does_not_load_is_named() {
    let (robot, _) = fanuc();
    let mechanism = robot.mechanism(None).unwrap();
    let mut lifted = simulated(&robot, mechanism, &POSES[..1], &truth(), 0.0, 1);
    // A force along the axis of the first joint does not load it.
    for case in &mut lifted.cases {
        case.force_n = [0.0, 0.0, 200.0];
    }
    lifted.cases.truncate(1);
    let few = fit_few(&robot, mechanism, &lifted);
    let first = few.estimate("joint.J1").unwrap();
    assert!(
        matches!(&first.status, FactorStatus::NotIdentified { words } if words.contains("no load")),
        "{:?}",
        first.status
    );
}

/// Fits the springs of two joints alone.
fn fit_few(robot: &Robot, mechanism: &Mechanism, table: &LoadCaseTable) -> LoadCaseFit {
    let mut choice = ParameterChoice::default();
    for factor in ModelParameter::BEAMS {
        choice.set(&factor, FitRole::Fixed);
    }
    for name in ["joint.J1", "joint.J2"] {
        let parameter = ModelParameter::find(robot, mechanism, name).unwrap();
        choice.set(&parameter, FitRole::Free);
    }
    let options = LoadCaseFitOptions {
        choice,
        ..LoadCaseFitOptions::default()
    };
    fit(robot, table, Some(options))
}

#[test]
fn components_along_the_axes_of_the_tool_say_the_same() {
    let (robot, table) = fanuc();
    let mechanism = robot.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(&robot, mechanism, &table).unwrap();
    // The robot file turns the tool against its body.
    let (body, own) = (robot.tool.body.unwrap(), robot.tool.axes.unwrap());
    let mut turned = table.clone();
    for (case, given) in turned.cases.iter_mut().zip(&posed.cases) {
        let body = robot.body_axes(body, &posed.poses[given.pose]).unwrap();
        let axes =
            own.map(|local| [0, 1, 2].map(|i| (0..3).map(|k| local[k] * body[k][i]).sum::<f64>()));
        let along =
            |vector: [f64; 3]| axes.map(|axis| (0..3).map(|i| axis[i] * vector[i]).sum::<f64>());
        case.axes = stiffbench_measurement::load_cases::LoadAxes::Tool;
        case.force_n = along(case.force_n);
        case.displacement_m = along(case.displacement_m.map(Option::unwrap)).map(Some);
    }
    let (base, tool) = (fit(&robot, &table, None), fit(&robot, &turned, None));
    for (a, b) in base.estimates.iter().zip(&tool.estimates) {
        assert!(
            (a.value - b.value).abs() <= 1e-8 * a.value.abs(),
            "{}: {} and {}",
            a.name,
            a.value,
            b.value
        );
    }
}

#[test]
fn a_beam_and_a_spring_are_fitted_together() {
    let source = stiffbench_test_files::shipped_robot("serial-arm").unwrap();
    let robot = Robot::parse(&source).unwrap();
    let mechanism = robot.mechanism(None).unwrap();
    let mut text = String::from(
        "pose,force_x_N,force_y_N,force_z_N,displacement_x_um,displacement_y_um,displacement_z_um\n",
    );
    for pose in ["P1", "P2", "P3", "P4"] {
        for force in ["50,20,0", "0,50,30", "10,0,50"] {
            writeln!(text, "{pose},{force},1,1,1").unwrap();
        }
    }
    let mut made = table("beams.csv", &text);
    let posed = PosedLoadCases::new(&robot, mechanism, &made).unwrap();
    let mut truth = FittingFactors::of_classes([1.0, 0.6, 1.0, 1.0], [1.0; 4]);
    let spring = ModelParameter::find(&robot, mechanism, "joint.S3").unwrap();
    truth.set(&spring, 8e-6);
    let model = LoadCaseModel {
        robot: &robot,
        mechanism,
        start: &truth,
        posed: &posed,
    };
    let predicted = model.predicted().unwrap();
    for (case, predicted) in made.cases.iter_mut().zip(predicted.chunks(3)) {
        for (read, predicted) in case.displacement_m.iter_mut().zip(predicted) {
            *read = Some(*predicted);
        }
    }
    let mut choice = ParameterChoice::default();
    for name in ["beam.A", "beam.Iz", "beam.J"] {
        choice.set(
            &ModelParameter::find(&robot, mechanism, name).unwrap(),
            FitRole::Fixed,
        );
    }
    choice.set(&spring, FitRole::Free);
    let options = LoadCaseFitOptions {
        choice,
        ..LoadCaseFitOptions::default()
    };
    let found = fit(&robot, &made, Some(options));
    let value = |name: &str| found.estimate(name).unwrap().value;
    assert!(
        (value("beam.Iy") - 0.6).abs() < 1e-5,
        "{}",
        value("beam.Iy")
    );
    assert!(
        (value("joint.S3") / 8e-6 - 1.0).abs() < 1e-4,
        "{}",
        value("joint.S3")
    );
}
