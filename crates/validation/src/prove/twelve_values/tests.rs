use super::*;
use stiffbench_test_files::shipped_robot;

fn bench() -> &'static str {
    stiffbench_test_files::text("data/paper/experiment-table-vi.csv")
}

fn reference() -> &'static str {
    stiffbench_test_files::text("data/paper/reference.csv")
}

#[test]
fn the_smallest_value_of_a_parabola_is_found_on_both_kinds_of_range() {
    for (middle, range) in [(0.02, [0.0, 50.0]), (-0.1, [-0.3, 0.3]), (0.0, [0.0, 50.0])] {
        let found = smallest(&|x| (x - middle) * (x - middle), range);
        assert!((found - middle).abs() < 1e-6, "{found} for {middle}");
    }
}

#[test]
fn a_compliant_joint_is_found_in_stiffness_values_that_hold_one() {
    let robot = Robot::parse(&shipped_robot("serial-arm").unwrap()).unwrap();
    let mechanism = robot.mechanism(None).unwrap();
    let poses: Vec<Pose> = robot.poses.iter().map(|named| named.pose.clone()).collect();
    let start = robot.factor_set("m_fsd").unwrap();
    let mut problem = StiffnessProblem {
        robot: &robot,
        mechanism,
        start: start.clone(),
        cells: (0..poses.len())
            .flat_map(|pose| {
                Direction::ALL.map(|direction| ListedStiffness {
                    pose,
                    direction,
                    ln_stiffness: 0.0,
                })
            })
            .collect(),
        poses,
    };
    let mechanics = problem.mechanics().unwrap();
    let laws = LinearLaw::all(&mechanics, &problem.cells);
    let law = laws
        .iter()
        .find(|law| title(law.law, &law.place) == "joint-compliance at joint S2")
        .unwrap();
    let truth = LinearFit {
        ln_factors: start.beam.map(|factor| (1.2 * factor).ln()),
        size: 0.4,
        squares: 0.0,
    };
    let mut mechanics = problem.mechanics().unwrap();
    let exact = problem.predict(&mut mechanics, Some(law), &truth).unwrap();
    drop(mechanics);
    for (cell, ln) in problem.cells.iter_mut().zip(exact) {
        cell.ln_stiffness = ln;
    }
    let mut mechanics = problem.mechanics().unwrap();
    let without = problem.fit(&mut mechanics, None, &|_| true).unwrap();
    let with = problem.fit(&mut mechanics, Some(law), &|_| true).unwrap();
    assert!(with.squares < 1e-8, "{with:?}");
    assert!(without.squares > 1e3 * with.squares, "{without:?}");
    assert!((with.size - 0.4).abs() < 1e-3, "{with:?}");
    // The search names it among all laws, and nothing where the stiffness is that of the factors.
    let named = |problem: &StiffnessProblem<'_>| {
        let mut mechanics = problem.mechanics().unwrap();
        let start = problem.fit(&mut mechanics, None, &|_| true).unwrap();
        let mut fit = |law| problem.fit(&mut mechanics, Some(law), &|_| true).unwrap();
        let fits: Vec<LinearFit> = laws.iter().map(&mut fit).collect();
        let fits: Vec<&LinearFit> = fits.iter().collect();
        let search =
            StiffnessSearch::new(problem, &mut mechanics, &laws, (&start, &fits), 0).unwrap();
        selected(&search).0.map(|place| &laws[place])
    };
    assert_eq!(named(&problem), Some(law));
    let without = problem.predict(&mut mechanics, None, &truth).unwrap();
    drop(mechanics);
    for (number, (cell, ln)) in problem.cells.iter_mut().zip(without).enumerate() {
        cell.ln_stiffness = ln + 0.05 * (1.7 * number as f64).sin();
    }
    assert_eq!(named(&problem), None);
}

/// What the study says of the laws that follow from every choice of them.
fn decides_little(found: &TwelveValues) {
    assert!((found.paper_worst_percent - 23.66).abs() < 0.02);
    assert!(found.gap.iter().all(|cell| cell.ratio > 0.5));
    assert!((1..=found.candidates.len()).contains(&found.not_distinguishable));
    assert!(found.baseline.worst_held_out_percent > found.baseline.rms_percent);
    let in_order = |pair: &[FittedLaw]| pair[0].behind <= pair[1].behind;
    assert!(found.candidates.windows(2).all(in_order));
}

#[test]
fn twelve_values_cannot_separate_many_laws() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let few = [
        "joint-compliance at joint A3",
        "joint-compliance at joint A4",
        "base-compliance at the base, about x",
        "gauge-stand-compliance at direction y",
    ];
    let is_one = |law: &LinearLaw| few.contains(&title(law.law, &law.place).as_str());
    let found = values_under(&robot, bench(), reference(), 0, &is_one).unwrap();
    assert_eq!(found.candidates.len(), few.len());
    decides_little(&found);
}

#[test]
#[ignore = "about a minute; `prove --only paper` runs the same study"]
fn twelve_values_decide_little() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let found = twelve_values(&robot, bench(), reference(), 0).unwrap();
    decides_little(&found);
    assert!(found.not_distinguishable > 1);
}

#[test]
fn tables_of_another_form_are_refused() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let refused = twelve_values(&robot, "pose,direction\nP1,x\n", reference(), 0);
    assert!(matches!(refused, Err(ProveError::Form { .. })));
}
