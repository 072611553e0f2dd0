//! Derivatives of positions and displacements against differences of predictions.

use stiffbench_measurement::load_cases::{LoadCaseTable, read_load_cases};
use stiffbench_numeric::least_squares::minimise;
use stiffbench_test_files::text;
use stiffbench_units_and_text::source_text::SourceText;

use super::*;
use crate::fit::spring_choice;

/// Shifts, m, rotation, rad, and change of the tool point, m: not small, so that products of them count.
const FRAMES: [f64; 9] = [0.01, -0.02, 0.03, 0.3, -0.2, 0.25, 0.04, -0.03, 0.02];

fn arm(link: &str) -> Robot {
    let text = text("fixtures/elastic-calibration/arm.toml");
    let elbow = "axis = \"y\", min_deg = -60";
    assert!(text.contains(elbow));
    let text = text.replace(elbow, &format!("{link}{elbow}"));
    Robot::parse(&SourceText::new("arm.toml", text)).unwrap()
}

/// A few positions under weight and forces.
fn positions() -> LoadCaseTable {
    let text = text("fixtures/elastic-calibration/loads.csv");
    let rows: Vec<&str> = text.lines().take(13).collect();
    let text = rows.join("\n");
    read_load_cases("positions.csv", text.as_bytes()).unwrap()
}

fn model<'a>(
    robot: &'a Robot,
    start: &'a FittingFactors,
    posed: &'a PosedLoadCases,
) -> LoadCaseModel<'a> {
    LoadCaseModel {
        robot,
        mechanism: robot.mechanism(None).unwrap(),
        start,
        posed,
        steps: GaugeSteps::default(),
        physics: None,
    }
}

/// The largest difference of a column from central differences, as a share of the column's largest entry; and how many columns there were.
fn worst(robot: &Robot, table: &LoadCaseTable, choice: &ParameterChoice) -> (f64, usize) {
    let mechanism = robot.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, table).unwrap();
    let start = robot.with_own_springs(&FittingFactors::UNIT);
    let model = model(robot, &start, &posed);
    let tracker = model.tracker().unwrap();
    let (parameters, _) = model.parameters(choice, tracker.as_ref()).unwrap();
    let scatter = RowScatter::plain(&posed, model.steps, [1.0; 2]);
    let mut problem = LoadCaseProblem::new(model, &parameters, scatter, tracker.as_ref()).unwrap();
    let list = parameters.parameters().iter().enumerate();
    let mut point: Vec<f64> = list
        .map(
            |(place, one)| match (parameters.moves(place), one.is_factor()) {
                (false, _) => parameters.coordinates_of_start()[place],
                (true, true) => 0.2 + 0.1 * place as f64,
                (true, false) => 0.3 + 0.05 * place as f64,
            },
        )
        .collect();
    if tracker.is_some() {
        point.extend(FRAMES);
    }
    let motions = problem.motions(&point, true).unwrap();
    let columns = problem.columns(&point, &motions);
    assert_eq!(columns.len(), point.len());
    let (mut worst, mut moved) = (0.0_f64, 0);
    for (place, column) in columns.iter().enumerate() {
        let is_frame = place >= parameters.parameters().len();
        if !is_frame && !parameters.moves(place) {
            continue;
        }
        let step = 1e-4;
        let [up, down] = [step, -step].map(|by| {
            let mut there = point.clone();
            there[place] += by;
            problem.predictions(&there).unwrap()
        });
        let size = column.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        assert!(size > 0.0, "column {place}");
        for ((up, down), derivative) in up.iter().zip(&down).zip(column) {
            let difference = (up - down) / (2.0 * step);
            worst = worst.max((difference - derivative).abs() / size);
        }
        moved += 1;
    }
    (worst, moved)
}

#[test]
fn derivatives_of_positions_are_their_differences() {
    let robot = arm("");
    let mut choice = spring_choice(&robot, robot.mechanism(None).unwrap());
    let (off, moved) = worst(&robot, &positions(), &choice);
    assert_eq!(moved, 15);
    assert!(off < 1e-7, "{off}");
    // A forearm that bends: no longer linear, and sections move beside springs and frames.
    let robot = arm("link = \"tube 60x3 aluminium\", ");
    for factor in [1, 2, 3] {
        choice.set(&ModelParameter::BEAMS[factor], FitRole::Free);
    }
    let (off, moved) = worst(&robot, &positions(), &choice);
    assert_eq!(moved, 18);
    assert!(off < 1e-6, "{off}");
}

#[test]
fn derivatives_of_displacements_are_their_differences() {
    let robot = arm("link = \"tube 60x3 aluminium\", ");
    let mut choice = spring_choice(&robot, robot.mechanism(None).unwrap());
    choice.set(&ModelParameter::BEAMS[1], FitRole::Free);
    let mut table = positions();
    table.cases.retain(|case| case.force_n != [0.0; 3]);
    for case in &mut table.cases {
        case.position_m = [None; 3];
        case.displacement_m = [Some(1e-4); 3];
        case.rotation_rad = [Some(1e-4), None, Some(2e-4)];
    }
    let (off, moved) = worst(&robot, &table, &choice);
    assert_eq!(moved, 7);
    assert!(off < 1e-6, "{off}");
}

#[test]
fn a_component_without_a_value_is_named_by_pose_force_and_repeat() {
    let robot = arm("");
    let mechanism = robot.mechanism(None).unwrap();
    let mut table = positions();
    table.cases.retain(|case| case.force_n != [0.0; 3]);
    table.cases.truncate(2);
    for (case, force) in table
        .cases
        .iter_mut()
        .zip([[0.0, 0.0, -40.0], [3.0, 0.0, 4.0]])
    {
        case.force_n = force;
        case.position_m = [None; 3];
        case.displacement_m = [Some(1e-4); 3];
        case.repeat = 2;
    }
    let start = robot.with_own_springs(&FittingFactors::UNIT);
    let choice = spring_choice(&robot, mechanism);
    for (row, expected) in [(1, "F = -40 N along z"), (5, "F = (3, 0, 4) N")] {
        let posed = PosedLoadCases::new(&robot, mechanism, &table).unwrap();
        let mut without_value = posed.clone();
        without_value.cases[row / 3].components[row % 3].value = f64::NAN;
        let model = model(&robot, &start, &posed);
        let (parameters, _) = model.parameters(&choice, None).unwrap();
        let scatter = RowScatter::plain(&posed, model.steps, [1.0; 2]);
        let model = LoadCaseModel {
            posed: &without_value,
            ..model
        };
        let mut problem = LoadCaseProblem::new(model, &parameters, scatter, None).unwrap();
        let set = parameters.set().unwrap();
        let error = minimise(&mut problem, &set, &LeastSquaresSettings::default()).unwrap_err();
        let LeastSquaresError::StartHasNoValue { source } = error else {
            panic!("{error}");
        };
        let (pose, axis) = (&table.cases[row / 3].pose, ["x", "y", "z"][row % 3]);
        assert_eq!(
            source.to_string(),
            format!(
                "the model returned NaN at pose {pose}, {expected}, repeat 2, displacement {axis}"
            )
        );
    }
}
