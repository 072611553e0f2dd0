use std::fmt::Write;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::prove::recordings::Recordings;

/// Angles and regressors of 200 poses; the errors are rigid ones, noise of 0.05 mm, and what `by_joint_2` gives for the angle of joint 2 and its arm.
fn tables(by_joint_2: impl Fn(f64, f64) -> f64) -> (String, String) {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let mut derived =
        String::from("error_mm,rigid01,rigid02,joint2_compliance_mm,joint3_compliance_mm");
    let mut grid = String::from("step_order");
    for joint in 1..=JOINTS {
        write!(derived, ",joint{joint}_arm_mm_per_rad").unwrap();
        write!(grid, ",joint_{joint}").unwrap();
    }
    derived.push('\n');
    grid.push('\n');
    for pose in 0..200 {
        let angles: Vec<f64> = (0..JOINTS).map(|_| 60.0 * normal()).collect();
        write!(grid, "{pose}").unwrap();
        for angle in &angles {
            write!(grid, ",{angle}").unwrap();
        }
        grid.push('\n');
        for _ in 0..AXES {
            let [rigid_1, rigid_2, compliance_2, compliance_3] = std::array::from_fn(|_| normal());
            let arms: Vec<f64> = (0..JOINTS).map(|_| 300.0 * normal()).collect();
            let periodic = by_joint_2(angles[1].to_radians(), arms[1]);
            let error = 2.0 * rigid_1 - rigid_2 + periodic + 0.05 * normal();
            write!(
                derived,
                "{error},{rigid_1},{rigid_2},{compliance_2},{compliance_3}"
            )
            .unwrap();
            for arm in arms {
                write!(derived, ",{arm}").unwrap();
            }
            derived.push('\n');
        }
    }
    (derived, grid)
}

fn ur5() -> Recording {
    let list = stiffbench_test_files::text("data/recordings/recordings.toml");
    let list = Recordings::parse("recordings.toml", list).unwrap();
    let mut all = list.recording.into_iter();
    all.find(|recording| recording.name == "ur5-pose-errors")
        .unwrap()
}

#[test]
fn a_periodic_error_is_found_and_nothing_where_there_is_none() {
    let (derived, grid) = tables(|angle, arm| 4e-4 * arm * angle.sin());
    let score = score_pose_errors(&ur5(), &derived, &grid, 0).unwrap();
    assert_eq!(score.verdict, "explained");
    assert!(
        score
            .words
            .starts_with("explained; periodic in joint 2, order 1 ("),
        "{}",
        score.words
    );
    assert!(!score.words.contains(" and "), "{}", score.words);
    let (derived, grid) = tables(|_, _| 0.0);
    let score = score_pose_errors(&ur5(), &derived, &grid, 0).unwrap();
    assert_eq!(score.verdict, "nothing-missing", "{}", score.words);
}

#[test]
fn incomplete_tables_are_refused() {
    let (derived, grid) = tables(|_, _| 0.0);
    for (derived, grid) in [
        ("", grid.as_str()),
        (&derived, "step_order\n0\n"),
        ("pose,error_mm\n0,1\n", &grid),
    ] {
        let refused = score_pose_errors(&ur5(), derived, grid, 0);
        assert!(matches!(refused, Err(ProveError::Form { .. })));
    }
}

#[test]
fn a_line_is_fitted_with_its_standard_errors() {
    // y = 1 + 2x with residuals 1, -2, 1 over 3.
    let (one, x) = (vec![1.0; 3], vec![0.0, 1.0, 2.0]);
    let y = [1.0 + 1.0 / 3.0, 3.0 - 2.0 / 3.0, 5.0 + 1.0 / 3.0];
    let found = LinearFit::new(&[&one, &x], &y).unwrap();
    assert!((found.values[0] - 1.0).abs() < 1e-12 && (found.values[1] - 2.0).abs() < 1e-12);
    // Variance 6/9 over one degree of freedom; of the slope half of it, of the intercept 5/6 of it.
    assert!((found.standard_errors[1] - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((found.standard_errors[0] - (5.0_f64 / 9.0).sqrt()).abs() < 1e-12);
    assert!(LinearFit::new(&[&one, &one], &y).is_err());
}
