//! What loads do to the end over the workspace: pose accuracy under a working load, and the sag under the robot's own weight.
//!
//! The displacement of the end is its whole compliance times the load, exact for linear structures. The weight acts all along the
//! members and is solved with the structure, pose by pose.

use rayon::prelude::*;

use stiffbench_beams::robot::{Pose, Predictor, RobotError, Theory};
use stiffbench_beams::structure::Compliance6;
use stiffbench_numeric::vector::{cross, norm, subtract};

use super::map::{MapModel, NoMap};
use super::pose_set::PoseSample;

/// Poses that a thread takes at a time.
const CHUNK: usize = 256;

/// How the end moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndShift {
    /// Displacement, m.
    pub displacement_m: [f64; 3],
    /// Rotation, rad.
    pub rotation_rad: [f64; 3],
}

impl EndShift {
    /// Under a force and a moment at the end, N and N·m.
    #[must_use]
    pub fn under(compliance: &Compliance6, load: [f64; 6]) -> Self {
        Self::from(compliance.times(load))
    }

    /// How far it moves, m.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        norm(self.displacement_m)
    }

    /// How far it turns, rad.
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        norm(self.rotation_rad)
    }
}

impl From<[f64; 6]> for EndShift {
    fn from([ux, uy, uz, rx, ry, rz]: [f64; 6]) -> Self {
        Self {
            displacement_m: [ux, uy, uz],
            rotation_rad: [rx, ry, rz],
        }
    }
}

/// The end over the poses of a set.
#[derive(Debug, Clone, PartialEq)]
pub struct ShiftMap {
    /// The mechanism.
    pub mechanism: String,
    /// Place in the set of each pose that has a shift.
    pub places: Vec<u32>,
    /// Where the end is, m.
    pub ends_m: Vec<[f64; 3]>,
    /// How it moves.
    pub shifts: Vec<EndShift>,
    /// Poses that have none: their place in the set and why.
    pub failed: Vec<(u32, String)>,
}

impl ShiftMap {
    /// Under a load at the end, N and N·m.
    ///
    /// # Errors
    /// [`NoMap`], also for laws that are not linear: their displacement is not the compliance times the load.
    pub fn under_load(
        model: &MapModel<'_>,
        poses: &PoseSample,
        load: [f64; 6],
    ) -> Result<Self, NoMap> {
        let values: Vec<f64> = (0..poses.len())
            .flat_map(|place| poses.pose(place).angles_deg)
            .collect();
        let solved = model.batch(&values, None, None, |end_m, compliance| {
            let compliance = model.on_its_base(compliance, end_m);
            Some((end_m, EndShift::under(&compliance, load)))
        })?;
        let mut failed = solved.failed.into_iter();
        let mut reason = || failed.next().map_or_else(String::new, |(_, reason)| reason);
        let found = solved.results.into_iter();
        Ok(Self::of(
            model,
            found.map(|found| found.ok_or_else(&mut reason)),
        ))
    }

    /// Under the robot's own weight: from the shape it would have without gravity.
    ///
    /// # Errors
    /// [`NoMap`], also for laws that are not linear.
    pub fn under_weight(model: &MapModel<'_>, poses: &PoseSample) -> Result<Self, NoMap> {
        model.sweep()?;
        let poses: Vec<Pose> = (0..poses.len()).map(|place| poses.pose(place)).collect();
        let chunks = poses.par_chunks(CHUNK).map(|poses| sags(model, poses));
        let chunks: Vec<Vec<_>> = chunks.collect::<Result<_, RobotError>>()?;
        Ok(Self::of(model, chunks.into_iter().flatten()))
    }

    fn of(model: &MapModel<'_>, found: impl Iterator<Item = EndMotion>) -> Self {
        let mut map = Self {
            mechanism: model.mechanism().name.clone(),
            places: Vec::new(),
            ends_m: Vec::new(),
            shifts: Vec::new(),
            failed: Vec::new(),
        };
        for (place, found) in (0..).zip(found) {
            match found {
                Ok((end_m, shift)) => {
                    map.places.push(place);
                    map.ends_m.push(end_m);
                    map.shifts.push(shift);
                }
                Err(reason) => map.failed.push((place, reason)),
            }
        }
        map
    }
}

/// Where the end is and how it moves, or why there is no answer.
type EndMotion = Result<([f64; 3], EndShift), String>;

/// The sag in poses, one after the other.
fn sags(model: &MapModel<'_>, poses: &[Pose]) -> Result<Vec<EndMotion>, RobotError> {
    let Some(joints) = model.joints() else {
        return Ok(Vec::new());
    };
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let theory = Theory::EulerBernoulli;
    let mut predictor = Predictor::with(robot, mechanism, joints, theory, model.factors())?;
    let mut sag = |pose: &Pose| -> Result<([f64; 3], EndShift), RobotError> {
        predictor.place(pose)?;
        let (solver, placed) = predictor.parts();
        let structure = placed.structure();
        let loads = placed.weight();
        let shift = EndShift::from(solver.end_displacement(&loads));
        let end_m = structure.nodes[structure.end.node].position_m;
        let about = |at_m: [f64; 3]| {
            loads.iter().fold([0.0; 3], |sum, (at, load)| {
                let [fx, fy, fz, moment @ ..] = *load;
                let arm = subtract(structure.nodes[at.node].position_m, at_m);
                let turned = cross(arm, [fx, fy, fz]);
                [0, 1, 2].map(|i| sum[i] + turned[i] + moment[i])
            })
        };
        let rocking = model.rocking_under(about, end_m);
        Ok((end_m, rocking.map_or(shift, |more| shift.plus(&more))))
    };
    Ok(poses
        .iter()
        .map(|pose| sag(pose).map_err(|error| error.to_string()))
        .collect())
}

impl EndShift {
    /// This and another.
    #[must_use]
    fn plus(&self, other: &Self) -> Self {
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
        Self {
            displacement_m: sum(self.displacement_m, other.displacement_m),
            rotation_rad: sum(self.rotation_rad, other.rotation_rad),
        }
    }

    /// Of a body that turns by `rotation_rad` about `at_m`, at `end_m`.
    pub(super) fn turned(rotation_rad: [f64; 3], at_m: [f64; 3], end_m: [f64; 3]) -> Self {
        Self {
            displacement_m: cross(rotation_rad, subtract(end_m, at_m)),
            rotation_rad,
        }
    }
}

/// The largest force along that of a load, N, or moment if it has no force, N·m, that moves the end by no more than `limit_m`.
///
/// `None` where the load does not move it.
#[must_use]
pub fn largest_load(shift: &EndShift, load: [f64; 6], limit_m: f64) -> Option<f64> {
    let [fx, fy, fz, moment @ ..] = load;
    let force = norm([fx, fy, fz]);
    let size = if force > 0.0 { force } else { norm(moment) };
    let distance = shift.distance_m();
    (distance > 0.0).then(|| size * limit_m / distance)
}

/// Where a value lies among those of all poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseSpread {
    /// Least, and its row.
    pub least: (f64, usize),
    /// Greatest, and its row.
    pub greatest: (f64, usize),
    /// Mean.
    pub mean: f64,
    /// Below it lie 5 %, 50 % and 95 %.
    pub quantiles: [f64; 3],
}

impl PoseSpread {
    /// Of finite values; `None` for none.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut order: Vec<usize> = (0..values.len())
            .filter(|&i| values[i].is_finite())
            .collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let (&first, &last) = (order.first()?, order.last()?);
        let at = |share: f64| values[order[(share * (order.len() - 1) as f64).round() as usize]];
        Some(Self {
            least: (values[first], first),
            greatest: (values[last], last),
            mean: order.iter().map(|&i| values[i]).sum::<f64>() / order.len() as f64,
            quantiles: [0.05, 0.5, 0.95].map(at),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_load_moves_the_end_by_the_limit() {
        let mut compliance = Compliance6([[0.0; 6]; 6]);
        for (i, c) in [4e-6, 2e-6, 1e-6, 1e-5, 1e-5, 2e-5].into_iter().enumerate() {
            compliance.0[i][i] = c;
        }
        compliance.0[0][5] = 3e-6;
        compliance.0[5][0] = 3e-6;
        let load = [30.0, 0.0, -40.0, 0.0, 0.0, 2.0];
        let shift = EndShift::under(&compliance, load);
        let found = [shift.displacement_m, shift.rotation_rad].concat();
        for (found, expected) in found.iter().zip([1.26e-4, 0.0, -4e-5, 0.0, 0.0, 1.3e-4]) {
            // Sums of six products.
            assert!((found - expected).abs() < 1e-18, "{found} {expected}");
        }
        let force = largest_load(&shift, load, 5e-4).unwrap();
        // Of 50 N and 2 N·m together the same multiple is taken.
        let scaled = EndShift::under(&compliance, load.map(|f| f * force / 50.0));
        assert!((scaled.distance_m() / 5e-4 - 1.0).abs() < 1e-12);
        assert_eq!(largest_load(&EndShift::from([0.0; 6]), load, 1e-3), None);
    }

    #[test]
    fn a_spread_names_its_ends() {
        let values: Vec<f64> = (0..101).rev().map(f64::from).chain([f64::NAN]).collect();
        let spread = PoseSpread::of(&values).unwrap();
        assert_eq!((spread.least, spread.greatest), ((0.0, 100), (100.0, 0)));
        assert_eq!((spread.mean, spread.quantiles), (50.0, [5.0, 50.0, 95.0]));
        assert_eq!(PoseSpread::of(&[f64::NAN]), None);
    }
}
