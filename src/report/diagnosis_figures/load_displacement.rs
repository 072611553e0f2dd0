//! The readings that were searched, with those of data findings marked beside them.

use std::collections::BTreeMap;

use crate::analysis::DiagnosisReport;
use crate::mismatch::{Observations, ObservedCell};
use crate::plot::{
    Bar, DisplacementPoint, LoadCurvePoints, LoadDisplacement, MarkedPoints, SessionCurves,
};
use crate::test_point::{Direction, PoseId};

/// Load against displacement; `None` where no reading is part of a data finding.
pub(super) fn load_displacement(report: &DiagnosisReport) -> Option<LoadDisplacement> {
    let marked: Vec<(PoseId, Direction, [f64; 2])> = report
        .marked_readings
        .iter()
        .map(|one| {
            let at = [one.force_n, one.displacement_m];
            (one.pose.clone(), one.direction, at)
        })
        .collect();
    if marked.is_empty() {
        return None;
    }
    let (observations, done) = (&report.observations, report.outliers_kept);
    let cells = observations.cells.iter();
    Some(LoadDisplacement {
        bar: Bar::StandardDeviation,
        sessions: vec![SessionCurves {
            name: "mean of the others".to_owned(),
            curves: cells
                .map(|cell| curve(observations, cell, &marked))
                .collect(),
        }],
        marked: Some(MarkedPoints {
            name: format!("data findings, {}", if done { "kept" } else { "left out" }),
            points: marked,
        }),
    })
}

/// Means of the repeats of each load step of a cell, without marked readings.
fn curve(
    observations: &Observations,
    cell: &ObservedCell,
    marked: &[(PoseId, Direction, [f64; 2])],
) -> LoadCurvePoints {
    let (pose, direction) = (&observations.poses[cell.pose], cell.axis());
    let mut steps: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for reading in cell.readings.clone() {
        let (load, detail) = (
            &observations.loads[reading],
            &observations.readings[reading],
        );
        let at = [load.force_n, observations.displacement_m[reading]];
        let is_marked = |(of_pose, of, value): &(PoseId, Direction, [f64; 2])| {
            (of_pose, *of, *value) == (pose, direction, at)
        };
        if !marked.iter().any(is_marked) {
            let step = steps.entry((load.step, detail.hold_number)).or_default();
            step.push(reading);
        }
    }
    let point = |readings: &Vec<usize>| {
        let n = readings.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| readings.iter().map(|one| of(*one)).sum::<f64>() / n;
        let displacement_m = mean(&|one| observations.displacement_m[one]);
        let square = mean(&|one| (observations.displacement_m[one] - displacement_m).powi(2));
        DisplacementPoint {
            force_n: mean(&|one| observations.loads[one].force_n),
            displacement_m,
            bar_m: (readings.len() > 1).then(|| (square * n / (n - 1.0)).sqrt()),
            n: readings.len(),
            branch: observations.readings[readings[0]].branch,
            flagged: false,
        }
    };
    LoadCurvePoints {
        pose: pose.clone(),
        direction,
        points: steps.values().map(point).collect(),
        line: None,
    }
}
