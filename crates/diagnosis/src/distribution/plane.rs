//! The plane over which a map is shown: two coordinates of the end.

use std::str::FromStr;

use stiffbench_beams::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, Pose, Robot, RobotError, Theory,
    Variable,
};
use stiffbench_numeric::vector::{dot, norm, scale, subtract};

use super::extreme::Extreme;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// A variable that moves the end by less than this moves it by rounding, m.
const MOVES_M: f64 = 1e-9;

/// Share of the range by which one variable stands further than the next, so that no two stand alike.
const GOLDEN_SHARE: f64 = 0.618_033_988_75;

/// A coordinate of the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneAxis {
    /// Along a global axis: 0 is x.
    Along(u8),
    /// Distance from the vertical axis through the origin.
    Reach,
    /// Along the vertical.
    Height,
}

/// Two coordinates of the end that span a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPlane {
    axes: [PlaneAxis; 2],
    vertical: [f64; 3],
}

impl MapPlane {
    /// Reach and height over a vertical, a unit vector.
    #[must_use]
    pub fn upright(vertical: [f64; 3]) -> Self {
        Self {
            axes: [PlaneAxis::Reach, PlaneAxis::Height],
            vertical,
        }
    }

    /// Two coordinates; the axis along which the vertical points is the height.
    #[must_use]
    pub fn new(axes: [PlaneAxis; 2], vertical: [f64; 3]) -> Self {
        let axes = axes.map(|axis| match axis {
            PlaneAxis::Along(i) if Some(usize::from(i)) == axis_along(vertical) => {
                PlaneAxis::Height
            }
            other => other,
        });
        Self { axes, vertical }
    }

    /// The coordinates.
    #[must_use]
    pub fn axes(&self) -> [PlaneAxis; 2] {
        self.axes
    }

    /// Whether it is spanned by reach and height.
    #[must_use]
    pub fn is_upright(&self) -> bool {
        self.axes == [PlaneAxis::Reach, PlaneAxis::Height]
    }

    /// Whether it is that of the paper: reach, and height along y.
    #[must_use]
    pub fn is_of_the_paper(&self) -> bool {
        self.is_upright() && axis_along(self.vertical) == Some(1)
    }

    /// Where an end is in the plane, m.
    #[must_use]
    pub fn place(&self, end_m: [f64; 3]) -> [f64; 2] {
        let height = dot(end_m, self.vertical);
        let reach = norm(subtract(end_m, scale(self.vertical, height)));
        self.axes.map(|axis| match axis {
            PlaneAxis::Along(i) => end_m[usize::from(i)],
            PlaneAxis::Reach => reach,
            PlaneAxis::Height => height,
        })
    }

    /// Letters of the two coordinates: `x`, `y`, `z`, `r` for the reach, `h` for a height along no axis.
    #[must_use]
    pub fn letters(&self) -> [&'static str; 2] {
        self.axes.map(|axis| match axis {
            PlaneAxis::Along(i) => AXES[usize::from(i)],
            PlaneAxis::Reach => "r",
            PlaneAxis::Height => axis_along(self.vertical).map_or("h", |i| AXES[i]),
        })
    }

    /// What an outermost point is called.
    #[must_use]
    pub fn word(&self, extreme: Extreme) -> String {
        let (axis, size) = match extreme {
            Extreme::Furthest => (0, "max"),
            Extreme::Nearest => (0, "min"),
            Extreme::Highest => (1, "max"),
            Extreme::Lowest => (1, "min"),
        };
        let largest = size == "max";
        match self.axes[axis] {
            PlaneAxis::Along(i) => format!("{size} {}", AXES[usize::from(i)]),
            PlaneAxis::Reach if largest => Extreme::Furthest.word().to_owned(),
            PlaneAxis::Reach => Extreme::Nearest.word().to_owned(),
            PlaneAxis::Height if largest => Extreme::Highest.word().to_owned(),
            PlaneAxis::Height => Extreme::Lowest.word().to_owned(),
        }
    }
}

/// The global axis along which a unit vector points, if it does.
fn axis_along(unit: [f64; 3]) -> Option<usize> {
    (0..3).find(|&axis| (0..3).all(|i| unit[i] == f64::from(u8::from(i == axis))))
}

/// A text that is no coordinate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("x, y, z or r is needed")]
pub struct NoPlaneAxis;

impl FromStr for PlaneAxis {
    type Err = NoPlaneAxis;

    fn from_str(text: &str) -> Result<Self, NoPlaneAxis> {
        match text {
            "x" => Ok(Self::Along(0)),
            "y" => Ok(Self::Along(1)),
            "z" => Ok(Self::Along(2)),
            "r" => Ok(Self::Reach),
            _ => Err(NoPlaneAxis),
        }
    }
}

/// Names of the variables that move the end in neither coordinate of a plane. In that of reach and height these are a waist, which only
/// turns the arm, and what moves only side chains. Each variable is tried at the nominal values of the others and at three more.
///
/// # Errors
/// [`RobotError`] if the mechanism cannot be built, or stands in no pose that was tried.
pub fn variables_beside_the_plane(
    robot: &Robot,
    mechanism: &Mechanism,
    plane: &MapPlane,
) -> Result<Vec<String>, RobotError> {
    let (joints, beams) = (JointModel::Rigid, FittingFactors::UNIT);
    let mut model = MechanismModel::new(robot, mechanism, &joints, Theory::EulerBernoulli, &beams)?;
    let nominal = robot.nominal_pose();
    let mut at = |pose: Pose| {
        model.place(&pose)?;
        let structure = model.structure();
        Ok(plane.place(structure.nodes[structure.end.node].position_m))
    };
    let mut starts = vec![(nominal.clone(), at(nominal.clone())?)];
    // A wrist that turns about an axis through the end moves it as soon as another joint bends it.
    for start in 1..=3 {
        let mut pose = nominal.clone();
        for (index, variable) in robot.variables.iter().enumerate() {
            let share = (GOLDEN_SHARE * (start * (index + 1)) as f64).fract();
            pose.angles_deg[index] = between(variable, 0.25 + 0.5 * share);
        }
        // A pose out of reach carries no information.
        if let Ok(from) = at(pose.clone()) {
            starts.push((pose, from));
        }
    }
    let mut beside = Vec::new();
    for (index, variable) in robot.variables.iter().enumerate() {
        let moves = starts.iter().any(|(start, from)| {
            [0.0, 0.3, 0.7, 1.0].into_iter().any(|share| {
                let mut pose = start.clone();
                pose.angles_deg[index] = between(variable, share);
                let to: Result<[f64; 2], RobotError> = at(pose);
                to.is_ok_and(|to| (0..2).any(|i| (to[i] - from[i]).abs() > MOVES_M))
            })
        });
        if !moves {
            beside.push(variable.name.clone());
        }
    }
    Ok(beside)
}

/// A value of a variable by its share of the range.
fn between(variable: &Variable, share: f64) -> f64 {
    variable.min_deg + share * (variable.max_deg - variable.min_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_follow_the_vertical() {
        let end = [3.0, 0.5, 4.0];
        let y_up = MapPlane::upright([0.0, 1.0, 0.0]);
        assert_eq!(y_up.place(end), [5.0, 0.5]);
        assert!(y_up.is_of_the_paper());
        let z_up = MapPlane::upright([0.0, 0.0, 1.0]);
        assert_eq!(z_up.place([3.0, 4.0, 0.5]), [5.0, 0.5]);
        assert_eq!(z_up.letters(), ["r", "z"]);
        assert!(!z_up.is_of_the_paper());
        let axes = ["x", "z"].map(|text| text.parse().unwrap());
        let plane = MapPlane::new(axes, [0.0, 1.0, 0.0]);
        assert_eq!(plane.place(end), [3.0, 4.0]);
        assert_eq!(plane.word(Extreme::Lowest), "min z");
        assert_eq!(plane.word(Extreme::Furthest), "max x");
    }

    #[test]
    fn the_vertical_axis_is_the_height() {
        let axes = ["r", "z"].map(|text| text.parse().unwrap());
        let plane = MapPlane::new(axes, [0.0, 0.0, 1.0]);
        assert_eq!(plane, MapPlane::upright([0.0, 0.0, 1.0]));
        assert_eq!(plane.word(Extreme::Highest), "highest");
        let axes = ["z", "r"].map(|text| text.parse().unwrap());
        let turned = MapPlane::new(axes, [0.0, 0.0, 1.0]);
        assert_eq!(turned.word(Extreme::Highest), "furthest");
        assert_eq!(turned.word(Extreme::Nearest), "lowest");
        assert!("h".parse::<PlaneAxis>().is_err());
    }
}
