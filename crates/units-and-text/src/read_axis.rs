//! What a gauge reads of the motion of the end of a robot.

use crate::test_point::Direction;

/// A displacement along an axis, or a rotation about one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadAxis {
    axis: Direction,
    rotates: bool,
    unit: [f64; 6],
}

impl ReadAxis {
    /// Along or about an axis of axes that may be turned.
    ///
    /// # Arguments
    /// - `unit`: what a displacement along x, y, z of the base and a rotation about x, y, z contribute, of length one.
    #[must_use]
    pub fn new(axis: Direction, rotates: bool, unit: [f64; 6]) -> Self {
        Self {
            axis,
            rotates,
            unit,
        }
    }

    /// Its axis among those that it is stated in.
    #[must_use]
    pub fn axis(&self) -> Direction {
        self.axis
    }

    /// Whether it is a rotation.
    #[must_use]
    pub fn is_rotation(&self) -> bool {
        self.rotates
    }

    /// Displacement along x, y, z and rotation about x, y, z of the base that it reads, of length one.
    #[must_use]
    pub fn unit(&self) -> [f64; 6] {
        self.unit
    }

    /// Its place among displacement x, y, z and rotation x, y, z along the axes that it is stated in.
    #[must_use]
    pub fn place(&self) -> usize {
        self.axis.index() + if self.rotates { 3 } else { 0 }
    }

    /// The base axis along which it reads displacements; `None` for anything else.
    #[must_use]
    pub fn base_axis(&self) -> Option<Direction> {
        (*self == Self::from(self.axis)).then_some(self.axis)
    }
}

impl From<Direction> for ReadAxis {
    fn from(axis: Direction) -> Self {
        let [x, y, z] = axis.unit_vector();
        Self::new(axis, false, [x, y, z, 0.0, 0.0, 0.0])
    }
}

impl PartialEq<Direction> for ReadAxis {
    fn eq(&self, axis: &Direction) -> bool {
        self.base_axis() == Some(*axis)
    }
}
