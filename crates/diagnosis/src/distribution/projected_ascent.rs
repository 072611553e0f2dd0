//! Uphill along the limits of a robot until none of them lets one go on.
//!
//! Rosen's gradient projection (Journal of the Society for Industrial and Applied Mathematics 8 (1960) 181): all limits are linear in the
//! angles. It finds the top of the hill on which it starts.

use nalgebra::{DMatrix, DVector};

use stiffbench_beams::robot::{Pose, Robot, RobotError};

/// A limit this near is touched, degrees: as for [`Robot::violated_limits`].
const TOUCHING_DEG: f64 = 1e-9;

/// Moves after which a ascent ends in any case. Corners take as many as there are limits, edges a few more.
const MOST_MOVES: usize = 2_000;

/// Share of a height that rounding can hide: stiff structures lose six of sixteen digits, and near the top two places differ by less.
const ROUNDING: f64 = 1e-9;

/// A limit a·x ≥ b in the free variables.
struct LinearLimit {
    a: DVector<f64>,
    b: f64,
    text: String,
}

/// Something that has a value in every pose.
pub(super) trait AscentObjective {
    /// Step of the differences that give slopes, degrees.
    const STEP_DEG: f64;
    /// A slope below this is flat, a degree.
    const FLAT_PER_DEG: f64;

    /// The value in a pose.
    ///
    /// # Errors
    /// [`RobotError`] of a pose that cannot be taken.
    fn height(&mut self, pose: &Pose) -> Result<f64, RobotError>;
}

/// Where an ascent ended.
pub(super) struct HillTop {
    pub(super) pose: Pose,
    /// The limits that hold it there, in words.
    pub(super) limits: Vec<String>,
    /// The steepest way that is left, a degree.
    pub(super) slope_per_deg: f64,
}

/// The way up a hill within the limits of a robot.
pub(super) struct ProjectedAscent<H> {
    objective: H,
    /// Indices of the free variables.
    free: Vec<usize>,
    limits: Vec<LinearLimit>,
    /// Where the ascent is.
    pose: Pose,
}

impl<H: AscentObjective> ProjectedAscent<H> {
    /// The top of the hill on which a pose stands, with the objective that found it.
    ///
    /// # Errors
    /// [`RobotError`] if a pose on the way cannot be taken.
    pub(super) fn ascend(
        robot: &Robot,
        free: Vec<usize>,
        objective: H,
        start: Pose,
    ) -> Result<(H, HillTop), RobotError> {
        let mut ascent = Self {
            objective,
            limits: linear_limits(robot, &free, &start),
            free,
            pose: start,
        };
        let slope_per_deg = ascent.leave_the_minimum()?;
        let touched = ascent.touched().into_iter();
        let top = HillTop {
            limits: touched
                .map(|limit| ascent.limits[limit].text.clone())
                .collect(),
            slope_per_deg,
            pose: ascent.pose,
        };
        Ok((ascent.objective, top))
    }

    /// Goes on until no limit lets it; returns the steepest way that is left, a degree: above [`AscentObjective::FLAT_PER_DEG`] only where it
    /// gave up.
    ///
    /// # Errors
    /// [`RobotError`] if a pose on the way cannot be taken.
    fn leave_the_minimum(&mut self) -> Result<f64, RobotError> {
        let mut slope = f64::INFINITY;
        for _ in 0..MOST_MOVES {
            let direction = self.way_on()?;
            slope = direction.norm();
            if slope < H::FLAT_PER_DEG {
                break;
            }
            self.follow(&(direction / slope))?;
        }
        Ok(slope)
    }

    fn x(&self) -> DVector<f64> {
        DVector::from_iterator(
            self.free.len(),
            self.free
                .iter()
                .map(|&variable| self.pose.angles_deg[variable]),
        )
    }

    /// The pose with the free variables at `x`.
    fn pose_at(&self, x: &DVector<f64>) -> Pose {
        let mut pose = self.pose.clone();
        for (&variable, value) in self.free.iter().zip(x.iter()) {
            pose.angles_deg[variable] = *value;
        }
        pose
    }

    fn value(&mut self, x: &DVector<f64>) -> Result<f64, RobotError> {
        let pose = self.pose_at(x);
        self.objective.height(&pose)
    }

    /// Slope at `x` along a unit direction, a degree, and the mean of the two heights that it is computed from.
    fn slope(
        &mut self,
        x: &DVector<f64>,
        direction: &DVector<f64>,
    ) -> Result<(f64, f64), RobotError> {
        let ahead = self.value(&(x + direction * H::STEP_DEG))?;
        let behind = self.value(&(x - direction * H::STEP_DEG))?;
        Ok((
            (ahead - behind) / (2.0 * H::STEP_DEG),
            0.5 * (ahead + behind),
        ))
    }

    /// Indices of the limits the pose touches.
    fn touched(&self) -> Vec<usize> {
        let x = self.x();
        (0..self.limits.len())
            .filter(|&limit| {
                let limit = &self.limits[limit];
                limit.a.dot(&x) - limit.b <= TOUCHING_DEG * limit.a.norm().max(1.0)
            })
            .collect()
    }

    /// The steepest direction that the touched limits allow, as long as its slope; zero at the extreme.
    fn way_on(&mut self) -> Result<DVector<f64>, RobotError> {
        let x = self.x();
        let n = self.free.len();
        let mut gradient = DVector::zeros(n);
        for i in 0..n {
            let axis = DVector::from_fn(n, |j, _| f64::from(u8::from(i == j)));
            (gradient[i], _) = self.slope(&x, &axis)?;
        }
        let mut kept = self.touched();
        loop {
            if kept.is_empty() {
                return Ok(gradient);
            }
            let normals = DMatrix::from_fn(n, kept.len(), |i, k| self.limits[kept[k]].a[i]);
            // Least squares by singular values: limits that meet in one corner may depend on one another.
            let Ok(push) = normals.clone().svd(true, true).solve(&gradient, 1e-12) else {
                return Ok(gradient);
            };
            let along = &gradient - &normals * &push;
            if along.norm() >= H::FLAT_PER_DEG {
                return Ok(along);
            }
            // Held on all sides. A limit that the way uphill leads away from need not hold.
            let (place, strongest) = push.argmax();
            if strongest < H::FLAT_PER_DEG {
                return Ok(along);
            }
            kept.remove(place);
        }
    }

    /// Goes along a unit direction to where it stops rising or a limit stops it, and never lower than it was: behind a valley the slope may
    /// rise again far below.
    fn follow(&mut self, direction: &DVector<f64>) -> Result<(), RobotError> {
        let x = self.x();
        let mut farthest = f64::INFINITY;
        for limit in &self.limits {
            let toward = -limit.a.dot(direction);
            let room = limit.a.dot(&x) - limit.b;
            if toward > 1e-12 * limit.a.norm() {
                farthest = farthest.min(room.max(0.0) / toward);
            }
        }
        // Every free variable has limits of its own, so that every direction meets one.
        let (mut rising, (_, mut height)) = (0.0, self.slope(&x, direction)?);
        let (mut falling, mut tried) = (farthest, farthest);
        // Bisection between a place that rises and one that falls or lies lower, far below what a step of the differences tells apart.
        loop {
            let there = &x + direction * tried;
            let (slope, reached) = self.slope(&there, direction)?;
            let lower = reached < height - ROUNDING * height.abs();
            if !lower && slope >= 0.0 {
                (rising, height) = (tried, reached);
            } else {
                falling = tried;
            }
            if rising >= farthest || falling - rising <= 1e-5 * H::STEP_DEG {
                break;
            }
            tried = 0.5 * (rising + falling);
        }
        self.pose = self.pose_at(&(&x + direction * rising));
        Ok(())
    }
}

/// All limits in the free variables; held ones stand at their value in `pose`.
fn linear_limits(robot: &Robot, free: &[usize], pose: &Pose) -> Vec<LinearLimit> {
    let n = free.len();
    let mut limits = Vec::new();
    for (place, &variable) in free.iter().enumerate() {
        let variable = &robot.variables[variable];
        let along = |sign: f64| DVector::from_fn(n, |i, _| if i == place { sign } else { 0.0 });
        limits.push(LinearLimit {
            a: along(1.0),
            b: variable.min_deg,
            text: format!("{} >= {}", variable.name, variable.min_deg),
        });
        limits.push(LinearLimit {
            a: along(-1.0),
            b: -variable.max_deg,
            text: format!("{} <= {}", variable.name, variable.max_deg),
        });
    }
    for limit in &robot.limits {
        let mut a = DVector::zeros(n);
        let mut b = limit.at_least_deg;
        for &(variable, coefficient) in &limit.terms {
            match free.iter().position(|&f| f == variable) {
                Some(place) => a[place] += coefficient,
                None => b -= coefficient * pose.angles_deg[variable],
            }
        }
        if a.norm() > 0.0 {
            limits.push(LinearLimit {
                a,
                b,
                text: limit.in_words(robot),
            });
        }
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robot;

    /// A height over one angle, degrees.
    struct AngleProfile(fn(f64) -> f64, usize);

    impl AscentObjective for AngleProfile {
        const STEP_DEG: f64 = 1e-3;
        const FLAT_PER_DEG: f64 = 1e-6;

        fn height(&mut self, pose: &Pose) -> Result<f64, RobotError> {
            Ok((self.0)(pose.angles_deg[self.1]))
        }
    }

    /// Where an ascent ends over the second axis of the shipped arm, which has limits at 10 and 110 degrees.
    fn top(profile: fn(f64) -> f64, start_deg: f64) -> f64 {
        let robot = robot("serial-arm");
        let axis = robot
            .variables
            .iter()
            .position(|variable| variable.name == "theta2")
            .unwrap();
        let mut pose = robot.poses[0].pose.clone();
        pose.angles_deg[axis] = start_deg;
        let mut ascend = ProjectedAscent {
            objective: AngleProfile(profile, axis),
            limits: linear_limits(&robot, &[axis], &pose),
            free: vec![axis],
            pose,
        };
        ascend.leave_the_minimum().unwrap();
        ascend.pose.angles_deg[axis]
    }

    #[test]
    fn a_valley_behind_the_top_is_not_crossed_to_lower_ground() {
        // A top at 40 degrees, a valley, and ground that rises again to a limit that lies lower.
        let two_hills = |x: f64| (-((x - 40.0) / 15.0).powi(2)).exp() + 0.004 * (x - 90.0).max(0.0);
        assert!((top(two_hills, 30.0) - 40.0).abs() < 1e-2);
        // Where the ground behind the valley is higher, either top will do, and none that lies lower than the start.
        let higher = |x: f64| (-((x - 40.0) / 15.0).powi(2)).exp() + 0.2 * (x - 90.0).max(0.0);
        assert!(higher(top(higher, 30.0)) >= higher(40.0) - 1e-9);
        // A slope without a top ends at the limit.
        assert!((top(|x| x, 30.0) - 110.0).abs() < 1e-9);
    }
}
