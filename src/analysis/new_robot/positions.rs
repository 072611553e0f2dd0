//! Positions that a controller shows, compared with those of a new robot file.

use crate::robot::{Pose, Robot};
use crate::vector::{norm, subtract};

use crate::analysis::ArgumentError;

/// Distance, m, above which a stated position is not that of the file: controllers state thousandths of a millimetre, tables whole ones.
const TOLERANCE_M: f64 = 1e-3;

/// Most variables whose signs are tried.
const MOST_SIGNS: usize = 8;

/// A position of the tool centre that a controller shows.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedPosition {
    /// Values of the variables in the order of the file, degrees; of sliding joints mm.
    pub values: Vec<f64>,
    /// The position, mm.
    pub position_mm: [f64; 3],
}

impl std::str::FromStr for StatedPosition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = |part: &str| -> Option<Vec<f64>> {
            let parsed = part
                .split(',')
                .map(|number| number.trim().parse::<f64>().ok());
            parsed
                .map(|number| number.filter(|number| number.is_finite()))
                .collect()
        };
        let form = || {
            "write the joint values, an equals sign and x,y,z in mm: 0,0,0,0,-90,0=1500,0,1850"
                .to_owned()
        };
        let (values, position) = text.split_once('=').ok_or_else(form)?;
        let values = numbers(values).ok_or_else(form)?;
        let position_mm = numbers(position).and_then(|position| position.try_into().ok());
        Ok(Self {
            values,
            position_mm: position_mm.ok_or_else(form)?,
        })
    }
}

/// Holds stated positions against those of a robot file; one line for each that fits.
///
/// # Errors
/// [`ArgumentError`] with the distance where one does not fit, and with the signs of the variables with which all would.
pub fn check_positions(
    robot: &Robot,
    stated: &[StatedPosition],
) -> Result<Vec<String>, ArgumentError> {
    let count = robot.variables.len();
    let mut lines = Vec::new();
    for position in stated {
        let argument = format!("--check-position {}", in_words(position));
        if position.values.len() != count {
            let names: Vec<&str> = robot.variables.iter().map(|v| v.name.as_str()).collect();
            return Err(ArgumentError::new(
                argument,
                format!(
                    "it has {} values, the robot has {count} variables",
                    position.values.len()
                ),
                format!("state them in the order {}", names.join(",")),
            ));
        }
        let signs = vec![1.0; count];
        let Some((distance_m, found_mm)) = distance(robot, position, &signs) else {
            return Err(ArgumentError::new(
                argument,
                "this pose cannot be reached",
                "check the values",
            ));
        };
        if distance_m > TOLERANCE_M {
            let [x, y, z] = found_mm;
            return Err(ArgumentError::new(
                argument,
                format!(
                    "the table puts the tool centre at {x:.1}, {y:.1}, {z:.1} mm, {:.1} mm away",
                    1e3 * distance_m
                ),
                remedy(robot, stated),
            ));
        }
        lines.push(format!(
            "{}: fits to {:.3} mm",
            in_words(position),
            1e3 * distance_m
        ));
    }
    Ok(lines)
}

fn in_words(position: &StatedPosition) -> String {
    let list = |numbers: &[f64]| {
        numbers
            .iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(",")
    };
    format!("{}={}", list(&position.values), list(&position.position_mm))
}

/// Distance, m, of a stated position from that of the robot, and the latter, mm.
fn distance(robot: &Robot, stated: &StatedPosition, signs: &[f64]) -> Option<(f64, [f64; 3])> {
    use crate::robot::JointMotion;
    let values = robot.variables.iter().zip(&stated.values).zip(signs);
    let values = values.map(|((variable, value), sign)| match variable.motion {
        JointMotion::Turns => sign * value,
        JointMotion::Slides => sign * 1e-3 * value,
    });
    let pose = Pose {
        angles_deg: values.collect(),
    };
    let found = robot.tool_pose(&pose).ok()?.position_m;
    let stated_m = stated.position_mm.map(|mm| 1e-3 * mm);
    Some((norm(subtract(found, stated_m)), found.map(|m| 1e3 * m)))
}

/// What could be wrong: signs of variables with which every stated position fits.
fn remedy(robot: &Robot, stated: &[StatedPosition]) -> String {
    let count = robot.variables.len();
    let general = "check units, convention, tool centre, and how the controller counts its angles (`angle` of the rows)";
    if count > MOST_SIGNS || stated.iter().any(|position| position.values.len() != count) {
        return general.to_owned();
    }
    let fits = |signs: &[f64]| {
        let mut all = stated.iter();
        all.all(|position| distance(robot, position, signs).is_some_and(|(d, _)| d <= TOLERANCE_M))
    };
    let choices = (1..1_usize << count).map(|bits| {
        let sign = |place: usize| if bits >> place & 1 == 1 { -1.0 } else { 1.0 };
        (0..count).map(sign).collect::<Vec<f64>>()
    });
    let mut fitting: Vec<Vec<f64>> = choices.filter(|signs| fits(signs)).collect();
    fitting.sort_by_key(|signs| signs.iter().filter(|sign| **sign < 0.0).count());
    let Some(signs) = fitting.first() else {
        return general.to_owned();
    };
    let turned = robot
        .variables
        .iter()
        .zip(signs)
        .filter(|(_, sign)| **sign < 0.0);
    let names: Vec<&str> = turned.map(|(variable, _)| variable.name.as_str()).collect();
    format!(
        "it fits if {} count the other way: turn the signs in `angle` of the rows",
        names.join(", ")
    )
}
