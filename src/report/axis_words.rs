//! What the axes of a robot are called in tables and figures.

use crate::distribution::{MapPlane, PlaneAxis};
use crate::robot::Robot;

/// Name of an axis with the word that the robot has for it, for example `y, vertical`.
#[must_use]
pub(super) fn axis_name(robot: &Robot, axis: usize) -> String {
    let letter = ["x", "y", "z"][axis];
    match robot.axis_word(axis) {
        Some(word) => format!("{letter}, {word}"),
        None => letter.to_owned(),
    }
}

/// Names of the two coordinates of a plane for the axes of a figure, for example `z, radial` and `y, vertical`.
#[must_use]
pub(super) fn plane_axis_names(plane: &MapPlane, robot: &Robot) -> [String; 2] {
    if plane.is_of_the_paper() {
        return ["z, radial", "y, vertical"].map(str::to_owned);
    }
    let letters = plane.letters();
    [0, 1].map(|i| match plane.axes()[i] {
        PlaneAxis::Along(axis) => axis_name(robot, axis.into()),
        PlaneAxis::Reach => format!("{}, radial", letters[i]),
        PlaneAxis::Height => format!("{}, vertical", letters[i]),
    })
}

/// Heads of the columns with the two coordinates, without the unit, for example `reach z` and `height y`.
#[must_use]
pub fn plane_column_heads(plane: &MapPlane) -> [String; 2] {
    if plane.is_of_the_paper() {
        return ["reach z", "height y"].map(str::to_owned);
    }
    let letters = plane.letters();
    [0, 1].map(|i| match plane.axes()[i] {
        PlaneAxis::Along(_) => letters[i].to_owned(),
        PlaneAxis::Reach => format!("reach {}", letters[i]),
        PlaneAxis::Height => format!("height {}", letters[i]),
    })
}

/// Letters of the two coordinates; the reach of the paper's plane is its z.
#[must_use]
pub(super) fn plane_letters(plane: &MapPlane) -> [&'static str; 2] {
    if plane.is_of_the_paper() {
        return ["z", "y"];
    }
    plane.letters()
}
