use super::*;
use crate::prove::recordings::Recordings;

fn list() -> &'static str {
    stiffbench_test_files::text("data/recordings/recordings.toml")
}

fn derived() -> &'static str {
    stiffbench_test_files::text(
        "data/recordings/robot-pose-errors-laser-tracker/derived_ur5_regressors.csv",
    )
}

fn grid() -> &'static str {
    stiffbench_test_files::text("data/recordings/robot-pose-errors-laser-tracker/ur5_grid_1000.csv")
}

fn ur5() -> Recording {
    let list = Recordings::parse("recordings.toml", list()).unwrap();
    let mut all = list.recording.into_iter();
    all.find(|recording| recording.name == "ur5-pose-errors")
        .unwrap()
}

#[test]
fn figures_of_the_ur5_are_those_that_are_known_and_compliance_is_rejected() {
    let score = score_pose_errors(&ur5(), derived(), grid(), 0).unwrap();
    for figure in &score.figures {
        let (known, ours) = (figure.known.unwrap(), figure.ours.unwrap());
        // Known with four digits, from another program; the BIC of almost nothing is a difference of thousands.
        let tolerance = 2e-3 * known.abs() + if known.abs() < 10.0 { 2e-2 } else { 0.0 };
        let tolerance = if figure.name.starts_with("mean") {
            2e-3 * known
        } else {
            tolerance
        };
        assert!(
            (ours - known).abs() <= tolerance,
            "{}: {ours} instead of {known}",
            figure.name
        );
    }
    assert!(score.is_right(), "{}", score.words);
    assert!(
        score
            .words
            .contains("joint-compliance at joint 3: impossible"),
        "{}",
        score.words
    );
}

#[test]
fn incomplete_tables_are_refused() {
    for (derived, grid) in [
        ("", grid()),
        (derived(), "step_order\n0\n"),
        ("pose,error_mm\n0,1\n", grid()),
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
    let found = fit(&[&one, &x], &y).unwrap();
    assert!((found.values[0] - 1.0).abs() < 1e-12 && (found.values[1] - 2.0).abs() < 1e-12);
    // Variance 6/9 over one degree of freedom; of the slope half of it, of the intercept 5/6 of it.
    assert!((found.standard_errors[1] - (1.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((found.standard_errors[0] - (5.0_f64 / 9.0).sqrt()).abs() < 1e-12);
    assert!(fit(&[&one, &one], &y).is_none());
}
