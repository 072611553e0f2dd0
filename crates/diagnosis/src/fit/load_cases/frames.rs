//! Where the tracker stands and which point of the tool it sees: found beside the springs from absolute positions.
//!
//! With x the tool centre of the rigid robot in a pose, A its axes, u and θ its displacement and rotation under own weight and load, all in the
//! axes of the base, the tracker reads p = t + R (x + A b + u + θ × A b). Base frame (t, R) and tool point b are nine further parameters.
//!
//! # Source
//! Absolute calibration with base and tool frames: Mooring, Roth & Driels, Fundamentals of Manipulator Calibration (1991), chapter 3; elastic
//! calibration: Klimchik, Wu, Dumas, Caro, Furet & Pashkevich, ICRA 2013. The rotation of the start: Kabsch, Acta Cryst. A32 (1976) 922.

use nalgebra::{Matrix3, Vector3};

use stiffbench_beams::robot::{
    Mechanism, Robot, TRACKER_PARAMETERS, ToolPose, TrackedPoses, TrackerFrames,
};
use stiffbench_numeric::least_squares::Parameter;
use stiffbench_numeric::vector::{cross, dot6, norm};
use stiffbench_units_and_text::test_point::Direction;

use crate::fit::FitError;
use crate::search::{self, push_orthonormal};

use super::posed::PosedLoadCases;
use super::prediction::{SeenRows, ToolMotion};

/// Whole positions without which a start for the frames cannot be found.
const FEWEST_POSITIONS: usize = 4;

/// Most alternations between rotation and tool point; what is left is the search's.
const MOST_ALTERNATIONS: usize = 500;

/// Change of the tool point, m, below which alternations end: far below any tracker.
const STILL_M: f64 = 1e-10;

/// Singular values below this share of the largest carry no component of the tool point.
const UNSEEN: f64 = 1e-9;

/// The tools of load cases as a tracker sees them whose frames fit the rigid robot nearly best; `None` without positions.
///
/// # Errors
/// [`FitError::TooFewPositions`]; a pose that cannot be reached.
pub(in crate::fit) fn nearest_tracker(
    robot: &Robot,
    mechanism: &Mechanism,
    posed: &PosedLoadCases,
) -> Result<Option<TrackedPoses>, FitError> {
    if !posed.has_positions() {
        return Ok(None);
    }
    let start = TrackerFrames::IDENTITY;
    let mut tracker = TrackedPoses::new(robot, mechanism, &posed.poses, start)?;
    tracker.frames = first_frames(posed, &tracker.tools)?;
    Ok(Some(tracker))
}

/// The nine parameters of a tracker, beginning where it stands, which is zero.
pub(in crate::fit) fn frame_parameters() -> impl Iterator<Item = Parameter> {
    TRACKER_PARAMETERS
        .into_iter()
        .map(|name| Parameter::unbounded(name, 0.0))
}

/// A tracker at nine coordinates: shift, rotation vector, change of the tool point.
pub(in crate::fit) fn moved_tracker(tracker: &TrackedPoses, coordinates: &[f64]) -> TrackedPoses {
    let mut moved = tracker.clone();
    if let [x, y, z, rx, ry, rz, bx, by, bz] = *coordinates {
        let frames = tracker.frames.turned([rx, ry, rz]);
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
        moved.frames = TrackerFrames {
            base_m: sum(frames.base_m, [x, y, z]),
            tool_point_m: sum(frames.tool_point_m, [bx, by, bz]),
            ..frames
        };
    }
    moved
}

/// Derivatives of positions to the nine coordinates.
///
/// # Arguments
/// - `motions`: of the tool centre, one a load case.
pub(in crate::fit) fn frame_columns(
    posed: &PosedLoadCases,
    tracker: &TrackedPoses,
    coordinates: &[f64],
    motions: &[ToolMotion],
) -> Vec<Vec<f64>> {
    let there = moved_tracker(tracker, coordinates);
    let turn = coordinates
        .get(3..6)
        .map_or([0.0; 3], |turn| std::array::from_fn(|i| turn[i]));
    let turning = left_jacobian(turn);
    let rows = SeenRows::of(posed, Some(&there));
    let column = |place: usize| {
        let axis = place % 3;
        rows.each(motions, |row, motion| {
            let tool = there.tools[row.pose].moved(*motion);
            let shown = there.frames.read_unit(&tool, row.axis.axis());
            let motions = there.frames.motions(&tool);
            match place / 3 {
                1 => (0..3)
                    .map(|turn| turning[turn][axis] * dot6(shown, motions[3 + turn]))
                    .sum(),
                _ => dot6(shown, motions[place]),
            }
        })
    };
    (0..TRACKER_PARAMETERS.len()).map(column).collect()
}

/// J with exp(ω + dω) = exp(J dω) exp(ω), row by row.
///
/// # Source
/// Barfoot, State Estimation for Robotics (2017), eq. (7.77).
fn left_jacobian(vector: [f64; 3]) -> [[f64; 3]; 3] {
    let angle = norm(vector);
    let (first, second) = if angle < 1e-4 {
        (
            0.5 - angle * angle / 24.0,
            1.0 / 6.0 - angle * angle / 120.0,
        )
    } else {
        let squared = angle * angle;
        (
            (1.0 - angle.cos()) / squared,
            (angle - angle.sin()) / (squared * angle),
        )
    };
    let column = |axis: usize| {
        let unit = Direction::ALL[axis].unit_vector();
        let once = cross(vector, unit);
        let twice = cross(vector, once);
        [0, 1, 2].map(|i| unit[i] + first * once[i] + second * twice[i])
    };
    let columns = [0, 1, 2].map(column);
    [0, 1, 2].map(|row| columns.map(|column| column[row]))
}

/// A position with all components.
struct WholePosition<'a> {
    measured: Vector3<f64>,
    tool: &'a ToolPose,
}

impl WholePosition<'_> {
    fn centre(&self) -> Vector3<f64> {
        Vector3::from(self.tool.position_m)
    }

    /// Columns: axes of the tool in those of the base.
    fn axes(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&self.tool.axes.map(Vector3::from))
    }
}

/// Frames from rotation and tool point in turn: each is the least-squares solution for given values of the other.
fn first_frames(posed: &PosedLoadCases, tools: &[ToolPose]) -> Result<TrackerFrames, FitError> {
    let whole: Vec<WholePosition<'_>> = posed
        .cases
        .iter()
        .filter_map(|case| {
            let read = |axis: usize| {
                let mut components = case.components.iter();
                let found =
                    components.find(|read| read.is_position() && read.component % 3 == axis);
                found.map(|read| read.value)
            };
            Some(WholePosition {
                measured: Vector3::new(read(0)?, read(1)?, read(2)?),
                tool: &tools[case.pose],
            })
        })
        .collect();
    let mut poses: Vec<[u64; 3]> = whole
        .iter()
        .map(|one| one.tool.position_m.map(f64::to_bits))
        .collect();
    poses.sort_unstable();
    poses.dedup();
    if poses.len() < FEWEST_POSITIONS {
        return Err(FitError::TooFewPositions {
            whole: poses.len(),
            needed: FEWEST_POSITIONS,
        });
    }
    let count = whole.len() as f64;
    let mean_axes = whole.iter().map(WholePosition::axes).sum::<Matrix3<f64>>() / count;
    let mut normal = Matrix3::zeros();
    for one in &whole {
        let axes = one.axes() - mean_axes;
        normal += axes.transpose() * axes;
    }
    let inverse = pseudo_inverse(&normal);
    let mut point = Vector3::zeros();
    let (mut rotation, mut base) = (Matrix3::identity(), Vector3::zeros());
    for _ in 0..MOST_ALTERNATIONS {
        (rotation, base) = kabsch(&whole, &point);
        // Rᵀ p - x = A b + s with s = Rᵀ t: the mean takes s away.
        let left = |one: &WholePosition<'_>| rotation.transpose() * one.measured - one.centre();
        let mean = whole.iter().map(left).sum::<Vector3<f64>>() / count;
        let mut right = Vector3::zeros();
        for one in &whole {
            right += (one.axes() - mean_axes).transpose() * (left(one) - mean);
        }
        let next = inverse * right;
        let change = (next - point).norm();
        point = next;
        if change < STILL_M {
            break;
        }
    }
    Ok(TrackerFrames {
        rotation: [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[(row, column)])),
        base_m: base.into(),
        tool_point_m: point.into(),
    })
}

/// Rotation and shift that carry the points of the rigid robot onto the measured ones with the least sum of squares.
fn kabsch(whole: &[WholePosition<'_>], point: &Vector3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
    let count = whole.len() as f64;
    let rigid = |one: &WholePosition<'_>| one.centre() + one.axes() * point;
    let mean_rigid = whole.iter().map(rigid).sum::<Vector3<f64>>() / count;
    let mean = whole.iter().map(|one| one.measured).sum::<Vector3<f64>>() / count;
    let mut covariance = Matrix3::zeros();
    for one in whole {
        covariance += (one.measured - mean) * (rigid(one) - mean_rigid).transpose();
    }
    let decomposed = covariance.svd(true, true);
    let (Some(left), Some(right)) = (decomposed.u, decomposed.v_t) else {
        return (Matrix3::identity(), mean - mean_rigid);
    };
    // The weakest direction, whichever place it has, makes up for a reflection.
    let mut signs = Vector3::repeat(1.0);
    signs[decomposed.singular_values.imin()] = (left * right).determinant().signum();
    let rotation = left * Matrix3::from_diagonal(&signs) * right;
    (rotation, mean - rotation * mean_rigid)
}

fn pseudo_inverse(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let decomposed = matrix.svd(true, true);
    let largest = decomposed.singular_values.max();
    // Both sides were computed: the only error does not arise.
    decomposed
        .pseudo_inverse(UNSEEN * largest)
        .unwrap_or_else(|_| Matrix3::zeros())
}

/// Length of what some columns leave of each vector.
pub(in crate::fit) fn lengths_beside(columns: &[Vec<f64>], vectors: &[Vec<f64>]) -> Vec<f64> {
    let mut units = Vec::with_capacity(columns.len());
    for column in columns {
        push_orthonormal(&mut units, column.clone(), UNSEEN, 0.0);
    }
    let rest = |vector: &Vec<f64>| {
        let mut rest = vector.clone();
        for unit in &units {
            let share = search::dot(unit, &rest);
            search::subtract(&mut rest, share, unit);
        }
        search::norm(&rest)
    };
    vectors.iter().map(rest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_left_jacobian_is_the_derivative_of_the_rotation() {
        let step = 1e-6;
        for vector in [[1e-6, 0.0, 2e-6], [0.4, -0.2, 0.9]] {
            let jacobian = left_jacobian(vector);
            let arm = [0.3, -1.2, 0.7];
            let there = |vector| TrackerFrames::IDENTITY.turned(vector).to_tracker(arm);
            for axis in 0..3 {
                let ends = [step, -step].map(|by| {
                    let mut moved = vector;
                    moved[axis] += by;
                    there(moved)
                });
                let column = jacobian.map(|row| row[axis]);
                let expected = cross(column, there(vector));
                for i in 0..3 {
                    let found = (ends[0][i] - ends[1][i]) / (2.0 * step);
                    assert!((found - expected[i]).abs() < 1e-9, "{found} {expected:?}");
                }
            }
        }
    }
}
