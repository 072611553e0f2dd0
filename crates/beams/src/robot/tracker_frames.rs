//! Where a tracker sees a point of the tool.

use stiffbench_numeric::vector::{cross, dot, norm, rotation, scale};
use stiffbench_units_and_text::test_point::Direction;

use super::tool_pose::ToolPose;

/// Where a tracker stands against the robot's base, and which point of the tool it measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerFrames {
    /// Rotation from the axes of the robot's base to those of the tracker, row by row.
    pub rotation: [[f64; 3]; 3],
    /// Origin of the robot's base in the axes of the tracker, m.
    pub base_m: [f64; 3],
    /// The measured point from the tool centre, in the axes of the tool, m.
    pub tool_point_m: [f64; 3],
}

/// Names of what is free of a tracker: position of the base (m) and its rotation (rad) along and about the axes of the tracker, the point of the
/// tool (m).
pub const TRACKER_PARAMETERS: [&str; 9] = [
    "base_frame.x",
    "base_frame.y",
    "base_frame.z",
    "base_frame.rx",
    "base_frame.ry",
    "base_frame.rz",
    "tool_point.x",
    "tool_point.y",
    "tool_point.z",
];

impl TrackerFrames {
    /// A tracker in the robot's base that measures the tool centre.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        base_m: [0.0; 3],
        tool_point_m: [0.0; 3],
    };

    /// A vector of the base in the axes of the tracker.
    #[must_use]
    pub fn to_tracker(&self, vector: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| dot(row, vector))
    }

    /// The measured point from the tool centre, in the axes of the base, m.
    fn lever_m(&self, tool: &ToolPose) -> [f64; 3] {
        in_base(tool, self.tool_point_m)
    }

    /// Position of the measured point in the axes of the tracker, m.
    ///
    /// # Arguments
    /// - `tool`: the tool of the rigid robot.
    /// - `motion`: small displacement, m, and rotation, rad, of the tool centre in the axes of the base.
    #[must_use]
    pub fn position_m(&self, tool: &ToolPose, motion: &[f64; 6]) -> [f64; 3] {
        let moved = tool.moved(*motion);
        let from_base_m = add(moved.position_m, self.lever_m(&moved));
        add(self.base_m, self.to_tracker(from_base_m))
    }

    /// What a motion of the tool centre along x, y, z and about x, y, z of the base contributes to the position along an axis of the tracker.
    #[must_use]
    pub fn read_unit(&self, tool: &ToolPose, axis: Direction) -> [f64; 6] {
        let along = self.rotation[axis.index()];
        joined(along, cross(self.lever_m(tool), along))
    }

    /// Small motions of the tool centre that show as much as one unit more of each of [`TRACKER_PARAMETERS`].
    #[must_use]
    pub fn motions(&self, tool: &ToolPose) -> [[f64; 6]; TRACKER_PARAMETERS.len()] {
        std::array::from_fn(|place| {
            let axis = place % 3;
            let along = self.rotation[axis];
            match place / 3 {
                0 => joined(along, [0.0; 3]),
                1 => joined(cross(along, tool.position_m), along),
                _ => joined(tool.axes[axis], [0.0; 3]),
            }
        })
    }

    /// The same frames with the base turned about the axes of the tracker through the base's origin.
    ///
    /// # Arguments
    /// - `vector_rad`: rotation vector.
    #[must_use]
    pub fn turned(&self, vector_rad: [f64; 3]) -> Self {
        let turn = rotation_of(vector_rad);
        let product = |row: [f64; 3]| -> [f64; 3] {
            [0, 1, 2].map(|column| (0..3).map(|k| row[k] * self.rotation[k][column]).sum())
        };
        Self {
            rotation: turn.map(product),
            ..*self
        }
    }

    /// Rotation vector of the base against the tracker, rad; its length is at most π.
    #[must_use]
    pub fn rotation_vector_rad(&self) -> [f64; 3] {
        let r = &self.rotation;
        let sine = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]].map(|x| 0.5 * x);
        let cosine = 0.5 * (r[0][0] + r[1][1] + r[2][2] - 1.0);
        let angle = norm(sine).atan2(cosine);
        if norm(sine) > 1e-6 {
            return scale(sine, angle / norm(sine));
        }
        if cosine > 0.0 {
            return sine;
        }
        // Half a turn: the axis is the longest column of R + 1 (Shuster, J. Astronaut. Sci. 41, 1993, section on the Euler axis).
        let columns =
            [0, 1, 2].map(|i| [0, 1, 2].map(|k| 0.5 * (r[k][i] + if i == k { 1.0 } else { 0.0 })));
        let longest =
            columns.into_iter().fold(
                [0.0; 3],
                |best, one| if norm(one) > norm(best) { one } else { best },
            );
        scale(longest, angle / norm(longest))
    }
}

fn joined(a: [f64; 3], b: [f64; 3]) -> [f64; 6] {
    let ([x, y, z], [rx, ry, rz]) = (a, b);
    [x, y, z, rx, ry, rz]
}

/// A vector of the tool in the axes of the base.
fn in_base(tool: &ToolPose, local: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|k| local[k] * tool.axes[k][i]).sum())
}

/// Rotation matrix of a rotation vector, row by row.
fn rotation_of(vector_rad: [f64; 3]) -> [[f64; 3]; 3] {
    let angle = norm(vector_rad);
    if angle == 0.0 {
        return TrackerFrames::IDENTITY.rotation;
    }
    rotation(scale(vector_rad, 1.0 / angle), angle)
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_numeric::vector::dot6;

    #[test]
    fn a_rotation_vector_comes_back_from_its_matrix() {
        let pi = std::f64::consts::PI;
        for vector in [
            [0.0; 3],
            [1e-9, 0.0, -2e-9],
            [0.3, -1.2, 2.0],
            [0.0, 3.1, 0.0],
            [pi / 2.0_f64.sqrt(), 0.0, pi / 2.0_f64.sqrt()],
        ] {
            let found = TrackerFrames::IDENTITY.turned(vector).rotation_vector_rad();
            let error = norm([0, 1, 2].map(|i| found[i] - vector[i]));
            assert!(error < 1e-9, "{vector:?} {found:?}");
        }
    }

    /// What a reading takes of a motion, and what each parameter shows, against positions.
    #[test]
    fn motions_show_as_positions_do() {
        let frames = TrackerFrames {
            base_m: [1.0, -2.0, 0.5],
            tool_point_m: [0.1, 0.03, -0.05],
            ..TrackerFrames::IDENTITY
        }
        .turned([0.4, -0.7, 1.1]);
        let tool = ToolPose {
            position_m: [0.9, -0.4, 1.2],
            axes: TrackerFrames::IDENTITY.turned([0.2, 0.5, -0.3]).rotation,
        };
        let still = frames.position_m(&tool, &[0.0; 6]);
        let motion = [1e-3, -2e-3, 5e-4, 3e-4, -1e-4, 7e-4];
        let moved = frames.position_m(&tool, &motion);
        for axis in Direction::ALL {
            let shown = dot6(frames.read_unit(&tool, axis), motion);
            let expected = moved[axis.index()] - still[axis.index()];
            assert!(
                (shown - expected).abs() < 1e-15,
                "{axis}: {shown} {expected}"
            );
        }
        let step = 1e-6;
        for (place, motion) in frames.motions(&tool).iter().enumerate() {
            let mut other = frames;
            let mut unit = [0.0; 3];
            unit[place % 3] = step;
            match place / 3 {
                0 => other.base_m = add(frames.base_m, unit),
                1 => other = frames.turned(unit),
                _ => other.tool_point_m = add(frames.tool_point_m, unit),
            }
            let there = other.position_m(&tool, &[0.0; 6]);
            for axis in Direction::ALL {
                let shown = step * dot6(frames.read_unit(&tool, axis), *motion);
                let expected = there[axis.index()] - still[axis.index()];
                let name = TRACKER_PARAMETERS[place];
                assert!(
                    (shown - expected).abs() < 1e-11,
                    "{name} {axis}: {shown} {expected}"
                );
            }
        }
    }

    /// Small turns and shifts of a tool come back.
    #[test]
    fn a_tool_has_moved_from_another() {
        let tool = ToolPose {
            position_m: [0.9, -0.4, 1.2],
            axes: TrackerFrames::IDENTITY.turned([0.2, 0.5, -0.3]).rotation,
        };
        let turn = [3e-5, -1e-5, 2e-5];
        let turned = TrackerFrames::IDENTITY.turned(turn);
        let moved = ToolPose {
            position_m: add(tool.position_m, [1e-3, 2e-3, -1e-3]),
            axes: tool.axes.map(|axis| turned.to_tracker(axis)),
        };
        let found = moved.moved_from(&tool);
        for (found, expected) in found
            .iter()
            .zip([1e-3, 2e-3, -1e-3].into_iter().chain(turn))
        {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    /// Tool 1 m out on x, its x along the base's y; point 0.1 m on its x; tracker turned by 90 degrees about z and shifted.
    #[test]
    fn a_point_of_the_tool_in_the_axes_of_a_tracker() {
        let tool = ToolPose {
            position_m: [1.0, 0.0, 0.0],
            axes: [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let frames = TrackerFrames {
            base_m: [5.0, 6.0, 7.0],
            tool_point_m: [0.1, 0.0, 0.02],
            ..TrackerFrames::IDENTITY
        }
        .turned([0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        // In the base (1, 0.1, 0.02), and by the motion 1 mm down and 2 mrad about x: (0, -40 um, 200 um).
        let motion = [0.0, 0.0, -1e-3, 2e-3, 0.0, 0.0];
        let found = frames.position_m(&tool, &motion);
        let expected = [5.0 - 0.1 + 40e-6, 6.0 + 1.0, 7.0 + 0.02 - 1e-3 + 200e-6];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-15 * 10.0,
                "{found} {expected}"
            );
        }
    }
}
