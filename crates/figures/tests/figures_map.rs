//! Figures of the stiffness distribution (the paper's Figs. 11 to 28): each comes out, and shows what the paper describes.
//!
//! Poses are drawn with the waist and the fourth axis held, as the paper's plane of (z, y) has it. The figures are written to
//! `target/figures-check/`, to be checked.

use stiffbench_beams::robot::{Keep, Pose, PoseSweep, Robot};
use stiffbench_diagnosis::distribution::{PosePlan, PoseSample, Sampling, Shard};
use stiffbench_figures::{
    NamedPoint, PlaneBins, PlaneMap, PlaneMapDifference, PlaneMapFigure, ValueAt, plane_map,
    plane_map_difference, plane_map_sheet,
};
use stiffbench_test_files::shipped_robot;

use crate::support::check;

const DIRECTIONS: [&str; 3] = ["x", "y", "z"];

/// Maps of the stiffness of one mechanism along x, y, z, N/mm.
fn maps(robot: &Robot, mechanism: &str, poses: usize) -> [PlaneMap; 3] {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let plan = PosePlan {
        sampling: Sampling::MonteCarlo,
        poses,
        seed: 0,
        held: ["theta1", "theta4"].map(str::to_owned).into(),
    };
    let sample = PoseSample::draw(robot, &plan, Shard::WHOLE).unwrap();
    let poses: Vec<Pose> = (0..sample.len())
        .map(|number| sample.pose(number))
        .collect();
    let sweep = PoseSweep::new(robot, mechanism, &robot.factor_set("m_fsd").unwrap()).unwrap();
    let swept = sweep.run(&poses, Keep::Diagonal);
    let named: Vec<Pose> = robot.poses.iter().map(|pose| pose.pose.clone()).collect();
    let ends = sweep.run(&named, Keep::Diagonal);
    let extremes: Vec<NamedPoint> = robot
        .poses
        .iter()
        .zip(&ends.poses)
        .map(|(pose, end)| NamedPoint {
            name: pose.id.to_string(),
            across_m: end.unwrap().end_m[2],
            up_m: end.unwrap().end_m[1],
        })
        .collect();
    [0, 1, 2].map(|axis| {
        let points = || {
            swept.poses.iter().map(|pose| {
                let pose = pose.unwrap();
                let stiffness = 1e-3 / pose.direct_m_per_n[axis];
                ([pose.end_m[2], pose.end_m[1]], stiffness)
            })
        };
        let value_at = |(at_m, value)| ValueAt { at_m, value };
        PlaneMap {
            heading: format!("mechanism {}", mechanism.name),
            axes: ["z, radial", "y, vertical"].map(str::to_owned),
            bins: PlaneBins::gather(points(), 0.0075),
            extremes: extremes.clone(),
            least: points().min_by(|a, b| a.1.total_cmp(&b.1)).map(value_at),
            greatest: points().max_by(|a, b| a.1.total_cmp(&b.1)).map(value_at),
        }
    })
}

fn figure(title: &str, axis: usize, maps: Vec<PlaneMap>) -> PlaneMapFigure {
    PlaneMapFigure {
        title: title.to_owned(),
        quantity: format!("stiffness along {}", DIRECTIONS[axis]),
        unit: "N/mm".to_owned(),
        about: "Factors m_fsd; 20000 random poses.".to_owned(),
        maps,
        range: None,
    }
}

#[test]
fn distributions_of_the_paper() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let names = ["A", "B", "C", "D", "E", "F"];
    let all = names.map(|name| maps(&robot, name, 20_000));
    for axis in 0..3 {
        let direction = DIRECTIONS[axis];
        for (name, maps) in names.iter().zip(&all) {
            let title = format!("Stiffness along {direction}, mechanism {name}");
            let one = figure(&title, axis, vec![maps[axis].clone()]);
            check(&format!("map-{direction}-{name}"), &plane_map(&one));
        }
        let title = format!("Stiffness along {direction} of the six mechanisms");
        let sheet = figure(&title, axis, all.iter().map(|m| m[axis].clone()).collect());
        check(&format!("map-{direction}-sheet"), &plane_map_sheet(&sheet));
        let difference = PlaneMapDifference {
            title: format!("Stiffness along {direction}: what chains B to F add"),
            quantity: format!("stiffness along {direction}"),
            unit: "N/mm".to_owned(),
            about: String::new(),
            before: all[0][axis].clone(),
            after: all[5][axis].clone(),
        };
        check(
            &format!("map-{direction}-difference"),
            &plane_map_difference(&difference),
        );
    }
}
