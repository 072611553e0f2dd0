//! Fits to load cases: a real robot against figures of another program, known springs found again, and what poses do not determine.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;

use stiffbench_test_files::text;

use super::load_cases::{DISPLACEMENTS, FORCES, SPRINGS, interval};
use super::robots::RobotFile;
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// Compliance and standard error of each joint, µrad/(N·m): ordinary least squares by NumPy on J (Jᵀ F), from the DH table.
const FANUC: [(f64, f64); 6] = [
    (1.162, 0.041),
    (0.368, 0.060),
    (0.510, 0.061),
    (3.69, 0.52),
    (2.36, 0.40),
    (4.9, 2.3),
];

/// Load cases of the real robot.
fn measured() -> Table {
    Table::parse(text("data/load-cases/fanuc-r2000ic/readings.csv"))
}

fn joint(place: usize) -> String {
    format!("joint.J{}", place + 1)
}

#[test]
fn a_real_robot_gives_the_springs_that_numpy_gives() {
    let fit = RobotFile::fanuc().fit(&measured(), "");
    for (place, (compliance, error)) in FANUC.into_iter().enumerate() {
        let name = joint(place);
        let estimate = fit["parameters"].named(&name);
        let [value, se] = ["value", "se"].map(|key| estimate[key].number());
        let difference = (1e6 * value - compliance) / error;
        assert!(
            difference.abs() < 0.1,
            "{name}: {value} off by {difference}"
        );
        let ratio = 1e6 * se / error;
        assert!(
            (0.97..1.03).contains(&ratio),
            "{name}: standard error {ratio}"
        );
        let [low, high] = interval(&estimate["ci95"]).unwrap();
        // Student's t with 123 degrees of freedom, those of the scatter.
        let half = 1.9794 * se;
        assert!((value - low - half).abs() < 2e-3 * half);
        assert!((high - value - half).abs() < 2e-3 * half);
        assert_eq!(estimate["status"], "free");
    }
    let [before, fitted, unseen] =
        ["before_um", "fitted_um", "unseen_um"].map(|state| fit["rms"][state].number());
    assert!((before - 996.0).abs() < 1.0, "{before}");
    assert!((unseen - 234.0).abs() < 1.0, "{unseen}");
    assert!(fitted < unseen);
    assert_eq!(fit["weights"]["basis"], "from-residuals");
    for (key, expected) in [("dof", 123), ("rank", 6), ("free", 6)] {
        assert_eq!(fit[key], expected, "{key}");
    }
    assert!((fit["condition"].number() - 3.49).abs() < 0.01);
}

/// Joints of the arm in one pose, from the modified DH table alone: a point and the direction of each axis; the axes of the flange, row by
/// row; the tool centre.
struct Arm {
    joints: Vec<([f64; 3], [f64; 3])>,
    axes: [[f64; 3]; 3],
    end: [f64; 3],
}

impl Arm {
    /// # Arguments
    /// - `pendant`: angles as the pendant shows them, rad.
    fn posed(pendant: [f64; 6]) -> Self {
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
        Self { joints, axes, end }
    }

    /// The pose of a row of a table.
    fn of_row(table: &Table, row: usize) -> Self {
        let angle = |joint: usize| {
            let degrees = table.number(row, &format!("joint_J{joint}_deg"));
            degrees.to_radians()
        };
        Self::posed([1, 2, 3, 4, 5, 6].map(angle))
    }

    /// How far the tool centre moves under a force on springs about the axes, m: the sum of c J (Jᵀ F).
    fn motion(&self, force: [f64; 3], compliances: &[f64]) -> [f64; 3] {
        let mut motion = [0.0; 3];
        for ((at, [x, y, z]), c) in self.joints.iter().zip(compliances) {
            let [u, v, w] = [0, 1, 2].map(|i| self.end[i] - at[i]);
            let lever = [y * w - z * v, z * u - x * w, x * v - y * u];
            let moment: f64 = (0..3).map(|i| lever[i] * force[i]).sum();
            for (motion, lever) in motion.iter_mut().zip(lever) {
                *motion += c * lever * moment;
            }
        }
        motion
    }
}

#[test]
fn predictions_are_those_of_the_jacobian() {
    let table = measured();
    let fit = RobotFile::fanuc().fit(&table, "");
    let compliances: Vec<f64> = (0..6)
        .map(|place| fit["parameters"].named(&joint(place))["value"].number())
        .collect();
    let mut components = fit["components"].list().iter();
    for row in 0..table.len() {
        let force = FORCES.map(|column| table.number(row, column));
        for expected in Arm::of_row(&table, row).motion(force, &compliances) {
            let found = 1e-6 * components.next().unwrap()["predicted"].number();
            assert!(
                (found - expected).abs() < 2e-9,
                "row {row}: {found} {expected}"
            );
        }
    }
    assert_eq!(components.next(), None);
}

/// A table of loads along the base axes in some poses, with displacements of [`SPRINGS`].
fn simulated(poses: &[[f64; 6]], sd_um: f64, repeats: u32) -> Table {
    let mut text = String::from("pose,repeat");
    for joint in 1..=6 {
        write!(text, ",joint_J{joint}_deg").unwrap();
    }
    writeln!(text, ",{},{}", FORCES.join(","), DISPLACEMENTS.join(",")).unwrap();
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
    for (pose, degrees) in poses.iter().enumerate() {
        let arm = Arm::posed(degrees.map(f64::to_radians));
        for force in [[200.0, 0.0, 0.0], [0.0, 200.0, 0.0], [0.0, 0.0, 200.0]] {
            let exact = arm.motion(force, &SPRINGS);
            for repeat in 1..=repeats {
                let read = exact.map(|exact| 1e6 * exact + sd_um * noise());
                let numbers = degrees.iter().chain(&force).chain(&read);
                let numbers: Vec<String> = numbers.map(f64::to_string).collect();
                writeln!(text, "P{pose},{repeat},{}", numbers.join(",")).unwrap();
            }
        }
    }
    Table::parse(&text)
}

const POSES: [[f64; 6]; 4] = [
    [0.0, -20.0, 10.0, 30.0, 60.0, -40.0],
    [40.0, 30.0, -30.0, -60.0, -70.0, 100.0],
    [-60.0, 10.0, 20.0, 90.0, 40.0, 10.0],
    [90.0, 50.0, -10.0, -120.0, 80.0, 170.0],
];

#[test]
fn known_springs_are_found_from_repeats_with_their_scatter() {
    let robot = RobotFile::fanuc();
    let found = robot.fit(&simulated(&POSES, 0.0, 1), "");
    let noisy = robot.fit(&simulated(&POSES, 8.0, 4), "");
    for (place, expected) in SPRINGS.into_iter().enumerate() {
        let name = joint(place);
        let value = found["parameters"].named(&name)["value"].number();
        // Links a million times stiffer than the springs leave six digits.
        assert!((value / expected - 1.0).abs() < 1e-5, "{name}: {value}");
        let estimate = noisy["parameters"].named(&name);
        let off = (estimate["value"].number() - expected) / estimate["se"].number();
        assert!(off.abs() < 4.0, "{name}: {off} standard errors off");
    }
    assert_eq!(noisy["weights"]["basis"], "pooled");
    // Four repeats of 36 components have 108 degrees of freedom, less what tells the scatter of the load from that of readings.
    let dof = noisy["weights"]["dof"].number();
    assert!((70.0..109.0).contains(&dof), "{dof}");
    let sd = noisy["displacement_sd_um"].number();
    assert!((sd / 8.0 - 1.0).abs() < 0.3, "{sd}");
    assert!(noisy["p"].number() > 1e-3);
}

#[test]
fn a_spring_that_a_pose_does_not_load_is_named() {
    let mut lifted = simulated(&POSES[..1], 0.0, 1).filtered(|_, row| row == 0);
    // A force along the axis of the first joint does not load it.
    for (column, force) in FORCES.into_iter().zip([0, 0, 200]) {
        lifted.set(0, column, &force);
    }
    let two = "--parameter beam.A,beam.Iy,beam.Iz,beam.J=fixed --parameter joint.J1,joint.J2=free";
    let fit = RobotFile::fanuc().fit(&lifted, two);
    let first = fit["parameters"].named("joint.J1");
    assert_eq!(first["status"], "not_identified");
    let words = first["words"].word();
    words.must_contain(&["no load"]);
}

#[test]
fn components_along_the_axes_of_the_tool_say_the_same() {
    let robot = RobotFile::fanuc();
    let table = measured();
    let mut turned = table.clone();
    for row in 0..table.len() {
        let axes = Arm::of_row(&table, row).axes;
        turned.set(row, "axes", &"tool");
        for columns in [FORCES, DISPLACEMENTS] {
            let vector = columns.map(|column| table.number(row, column));
            for (column, axis) in columns.into_iter().zip(axes) {
                let along: f64 = (0..3).map(|i| axis[i] * vector[i]).sum();
                turned.set(row, column, &along);
            }
        }
    }
    let [base, tool] = [&table, &turned].map(|table| robot.fit(table, ""));
    for (a, b) in base["parameters"]
        .list()
        .iter()
        .zip(tool["parameters"].list())
    {
        assert_eq!(a["name"], b["name"]);
        let [own, other] = [a, b].map(|one| one["value"].number());
        assert!(
            (own - other).abs() <= 1e-8 * own.abs(),
            "{}: {own} and {other}",
            a["name"]
        );
    }
}

#[test]
fn a_beam_and_a_spring_are_fitted_together() {
    let model = "--robot serial-arm --factors unit";
    let cases = "--load-cases 12 --poses P1,P2,P3,P4 --loads-n 60 --repeats 1 --noise-free";
    let options = format!("{model} {cases} --true-factor beam.Iy=0.6,joint.S3=8e-6");
    let table = Table::simulated(&options, &[]);
    let free = "--parameter beam.A,beam.Iz,beam.J=fixed --parameter joint.S3=free";
    let fit = table.data("fit", &format!("{model} {free}"));
    let [iy, spring] =
        ["beam.Iy", "joint.S3"].map(|name| fit["parameters"].named(name)["value"].number());
    assert!((iy - 0.6).abs() < 1e-5, "{iy}");
    assert!((spring / 8e-6 - 1.0).abs() < 1e-4, "{spring}");
}
