//! Directions of loads: a base axis, or any unit vector.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::nearest::nearest;
use crate::test_point::{Direction, DirectionName};

/// How far the length of a vector may be from 1: digits that were left out.
const LENGTH_SLACK: f64 = 0.02;

/// How far a unit vector may be from 1 and stay as it is, so that reading what was written changes nothing.
const IS_UNIT: f64 = 1e-12;

/// Components below which a vector lies along the remaining axis.
const ON_AXIS: f64 = 1e-9;

/// The direction of a load in the base frame: along a positive axis, or oblique.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "DirectionEntry", try_from = "DirectionEntry")]
#[schemars(with = "DirectionEntry")]
pub enum LoadDirection {
    /// Along the positive x, y or z.
    Axis(Direction),
    /// Along another unit vector.
    Oblique(ObliqueLoad),
}

/// A unit vector in the base frame, with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct ObliqueLoad {
    /// As the user called it; `None` for a vector without a name.
    name: Option<Arc<str>>,
    /// Zero of a moment without a force.
    unit: [f64; 3],
    /// Moment beside it, N·m for 1 N; of a moment without a force a unit vector.
    moment_m: [f64; 3],
}

// No component is ever NaN.
impl Eq for LoadDirection {}
impl Eq for ObliqueLoad {}

/// A direction as files have it: a word for an axis, else the vector, with its name if it has one.
#[derive(Debug, Clone, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "LoadDirection")]
enum DirectionEntry {
    /// Along a positive base axis.
    Axis(Direction),
    /// A unit vector in the base frame.
    Vector([f64; 3]),
    /// A unit vector with a name.
    Named {
        /// The name.
        name: String,
        /// The unit vector in the base frame.
        vector: [f64; 3],
    },
}

/// Why something is no direction.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotALoadDirection {
    /// The vector is no unit vector.
    #[error("the vector ({}) of length {length:.4}", numbers(.vector))]
    Length {
        /// Its components.
        vector: [f64; 3],
        /// Its length.
        length: f64,
    },
    /// Not a name and not a vector.
    #[error(
        "`{0}` is not a direction: {hint}x, y, z, -x, -y, -z, or a unit vector such as 0,0.7071,0.7071",
        hint = meant_direction(.0).map_or_else(String::new, |meant| format!("did you mean `{meant}`? It is "))
    )]
    Word(String),
}

/// The direction that a mistyped word means: by its letter, or by what the axes are called.
#[must_use]
pub fn meant_direction(word: &str) -> Option<&'static str> {
    const AXES: [(&str, &str); 3] = [("x", "-x"), ("y", "-y"), ("z", "-z")];
    const WORDS: [&str; 3] = ["lateral", "vertical", "radial"];
    let lower = word.trim().to_lowercase();
    let letter = lower.trim_matches(|c: char| !c.is_alphabetic());
    let against = lower.contains('-');
    let of_word = || {
        let meant = nearest(letter, WORDS).filter(|_| letter.len() > 2)?;
        WORDS.iter().position(|word| *word == meant)
    };
    let of_letter = || {
        let doubled = |axis: &str| !letter.is_empty() && letter.replace(axis, "").is_empty();
        AXES.iter().position(|(axis, _)| doubled(axis))
    };
    let (along, opposite) = AXES[of_letter().or_else(of_word)?];
    Some(if against { opposite } else { along })
}

impl LoadDirection {
    /// Along an axis.
    #[must_use]
    pub fn of_axis(axis: Direction) -> &'static Self {
        const AXES: [LoadDirection; 3] = [
            LoadDirection::Axis(Direction::X),
            LoadDirection::Axis(Direction::Y),
            LoadDirection::Axis(Direction::Z),
        ];
        static ALL: [LoadDirection; 3] = AXES;
        &ALL[axis.index()]
    }

    /// The three base axes, in order.
    #[must_use]
    pub fn axes() -> Vec<Self> {
        Direction::ALL.map(Self::Axis).to_vec()
    }

    /// A direction from a vector whose length is 1 within 2 %; it is normalised. A positive axis becomes that axis.
    ///
    /// # Errors
    /// [`NotALoadDirection::Length`] with the length, also for a vector that is not finite.
    pub fn from_vector(vector: [f64; 3]) -> Result<Self, NotALoadDirection> {
        let length = vector[0].hypot(vector[1]).hypot(vector[2]);
        // A length that is not a number is not near 1 either.
        let is_near = (length - 1.0).abs() <= LENGTH_SLACK;
        if !is_near {
            return Err(NotALoadDirection::Length { vector, length });
        }
        let unit = if (length - 1.0).abs() <= IS_UNIT {
            vector
        } else {
            vector.map(|part| part / length)
        };
        // Without a minus in front of zero.
        let unit = unit.map(|part| part + 0.0);
        let axis = Direction::ALL.into_iter().find(|axis| {
            let others = Direction::ALL.into_iter().filter(|other| other != axis);
            unit[axis.index()] > 0.0
                && others
                    .into_iter()
                    .all(|at| unit[at.index()].abs() < ON_AXIS)
        });
        let oblique = ObliqueLoad {
            name: None,
            unit,
            moment_m: [0.0; 3],
        };
        Ok(axis.map_or(Self::Oblique(oblique), Self::Axis))
    }

    /// The direction of a force and a moment, and their amount along it: N, of a moment without a force N·m; `None` of neither. Along a base axis the
    /// amount has a sign.
    #[must_use]
    pub fn of_wrench([fx, fy, fz, mx, my, mz]: [f64; 6]) -> Option<(Self, f64)> {
        let size = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
        let (force_n, moment_nm) = ([fx, fy, fz], [mx, my, mz]);
        let size_n = size(force_n);
        if size_n == 0.0 {
            let amount_nm = size(moment_nm);
            let moment_m = moment_nm.map(|part| part / amount_nm);
            let alone = ObliqueLoad {
                name: None,
                unit: [0.0; 3],
                moment_m,
            };
            return (amount_nm > 0.0).then_some((Self::Oblique(alone), amount_nm));
        }
        let against = Self::from_vector(force_n.map(|part| -part / size_n)).ok()?;
        if against.axis().is_some() && moment_nm == [0.0; 3] {
            return Some((against, -size_n));
        }
        let along = Self::from_vector(force_n.map(|part| part / size_n)).ok()?;
        if moment_nm == [0.0; 3] {
            return Some((along, size_n));
        }
        let both = ObliqueLoad {
            name: None,
            unit: along.unit_vector(),
            moment_m: moment_nm.map(|part| part / size_n),
        };
        Some((Self::Oblique(both), size_n))
    }

    /// The same direction under a name.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self::Oblique(ObliqueLoad {
            name: Some(Arc::from(name)),
            unit: self.unit_vector(),
            moment_m: self.moment_m(),
        })
    }

    /// The unit vector in the base frame.
    #[must_use]
    pub fn unit_vector(&self) -> [f64; 3] {
        match self {
            Self::Axis(axis) => axis.unit_vector(),
            Self::Oblique(oblique) => oblique.unit,
        }
    }

    /// Force and moment for an amount of 1, N and N·m.
    #[must_use]
    pub fn wrench(&self) -> [f64; 6] {
        let ([x, y, z], [mx, my, mz]) = (self.unit_vector(), self.moment_m());
        [x, y, z, mx, my, mz]
    }

    fn moment_m(&self) -> [f64; 3] {
        match self {
            Self::Axis(_) => [0.0; 3],
            Self::Oblique(oblique) => oblique.moment_m,
        }
    }

    /// What it is called.
    #[must_use]
    pub fn called(&self) -> DirectionName {
        match self {
            Self::Axis(axis) => (*axis).into(),
            Self::Oblique(_) => DirectionName::new(&self.to_string()),
        }
    }

    /// Whether it is called so.
    #[must_use]
    pub fn is_called(&self, name: &DirectionName) -> bool {
        match self {
            Self::Axis(axis) => ["x", "y", "z"][axis.index()] == name.as_str(),
            Self::Oblique(_) => self.called() == *name,
        }
    }

    /// The component along a base axis.
    #[must_use]
    pub fn along(&self, axis: Direction) -> f64 {
        self.unit_vector()[axis.index()]
    }

    /// The positive base axis that it is; `None` for any other direction.
    #[must_use]
    pub fn axis(&self) -> Option<Direction> {
        match self {
            Self::Axis(axis) => Some(*axis),
            Self::Oblique(_) => None,
        }
    }

    /// The name that the user gave it, for a table of names.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Axis(_) => None,
            Self::Oblique(oblique) => oblique.name.as_deref(),
        }
    }

    /// The components of a direction that is no axis, for example `(0, 0.6, 0.8)`.
    #[must_use]
    pub fn components_text(&self) -> Option<String> {
        match self {
            Self::Axis(_) => None,
            Self::Oblique(oblique) => Some(format!("({})", numbers(&oblique.unit))),
        }
    }

    /// Directions from a list with commas: words, and three numbers for each vector, as in `x,-z,0,0.7071,0.7071`.
    ///
    /// # Errors
    /// [`NotALoadDirection`].
    pub fn parse_list(text: &str) -> Result<Vec<Self>, NotALoadDirection> {
        let mut found = Vec::new();
        let mut vector = Vec::new();
        for word in text.split(',') {
            match word.trim().parse::<f64>() {
                Ok(part) => vector.push(part),
                Err(_) if vector.is_empty() => found.push(word.parse()?),
                Err(_) => return Err(NotALoadDirection::Word(text.to_owned())),
            }
            if let [x, y, z] = vector[..] {
                found.push(Self::from_vector([x, y, z])?);
                vector.clear();
            }
        }
        if vector.is_empty() {
            Ok(found)
        } else {
            Err(NotALoadDirection::Word(text.to_owned()))
        }
    }
}

/// Components with at most four decimals.
fn numbers(vector: &[f64; 3]) -> String {
    let four = |part: &f64| {
        let text = format!("{part:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" {
            "0".to_owned()
        } else {
            text.to_owned()
        }
    };
    vector.iter().map(four).collect::<Vec<_>>().join(",")
}

impl fmt::Display for LoadDirection {
    /// `x`, the user's name, `-x`, or the components in brackets.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axis(axis) => axis.fmt(f),
            Self::Oblique(ObliqueLoad {
                name: Some(name), ..
            }) => f.pad(name),
            Self::Oblique(ObliqueLoad { unit, moment_m, .. }) => {
                let against = Direction::ALL
                    .into_iter()
                    .find(|axis| unit[axis.index()] == -1.0);
                match against {
                    _ if *unit == [0.0; 3] => f.pad(&format!("moment ({})", numbers(moment_m))),
                    _ if *moment_m != [0.0; 3] => f.pad(&format!(
                        "({}) with moment ({}) m",
                        numbers(unit),
                        numbers(moment_m)
                    )),
                    Some(axis) => f.pad(&format!("-{axis}")),
                    None => f.pad(&format!("({})", numbers(unit))),
                }
            }
        }
    }
}

impl FromStr for LoadDirection {
    type Err = NotALoadDirection;

    /// One of `x`, `y`, `z`, `-x`, `-y`, `-z`, or three numbers with commas between.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        let not = || NotALoadDirection::Word(text.to_owned());
        if let Ok(axis) = text.parse::<Direction>() {
            return Ok(Self::Axis(axis));
        }
        if let Some(Ok(axis)) = text.strip_prefix('-').map(str::parse::<Direction>) {
            return Self::from_vector(axis.unit_vector().map(|part| -part));
        }
        let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        let parts = parts.map_err(|_| not())?;
        let vector: [f64; 3] = parts.try_into().map_err(|_| not())?;
        Self::from_vector(vector)
    }
}

impl From<Direction> for LoadDirection {
    fn from(axis: Direction) -> Self {
        Self::Axis(axis)
    }
}

impl PartialEq<Direction> for LoadDirection {
    fn eq(&self, axis: &Direction) -> bool {
        self.axis() == Some(*axis)
    }
}

impl From<LoadDirection> for DirectionEntry {
    fn from(direction: LoadDirection) -> Self {
        let vector = direction.unit_vector();
        match (direction.axis(), direction.name()) {
            (Some(axis), _) => Self::Axis(axis),
            (None, Some(name)) => Self::Named {
                name: name.to_owned(),
                vector,
            },
            (None, None) => Self::Vector(vector),
        }
    }
}

impl TryFrom<DirectionEntry> for LoadDirection {
    type Error = NotALoadDirection;

    fn try_from(entry: DirectionEntry) -> Result<Self, Self::Error> {
        Ok(match entry {
            DirectionEntry::Axis(axis) => Self::Axis(axis),
            DirectionEntry::Vector(vector) => Self::from_vector(vector)?,
            DirectionEntry::Named { name, vector } => Self::from_vector(vector)?.named(&name),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_vectors_are_directions_and_their_text_is_read_again() {
        let x: LoadDirection = "x".parse().unwrap();
        assert_eq!(x, Direction::X);
        assert_eq!(LoadDirection::from_vector([1.0, 0.0, 0.0]), Ok(x));
        let back: LoadDirection = "-y".parse().unwrap();
        assert_eq!(back.unit_vector(), [0.0, -1.0, 0.0]);
        assert_eq!(back.to_string(), "-y");
        let oblique: LoadDirection = "0,0.7,0.7".parse().unwrap();
        // 0.7 / (0.7 √2) = 1/√2.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let [none, y, z] = oblique.unit_vector();
        assert!(none == 0.0 && (y - half).abs() < 1e-15 && (z - half).abs() < 1e-15);
        assert_eq!(oblique.to_string(), "(0,0.7071,0.7071)");
        let list = LoadDirection::parse_list("x,0,0.7,0.7,-z").unwrap();
        let words: Vec<String> = list.iter().map(ToString::to_string).collect();
        assert_eq!(words, ["x", "(0,0.7071,0.7071)", "-z"]);
    }

    #[test]
    fn what_is_written_is_read_again_to_the_last_bit() {
        let oblique = LoadDirection::from_vector([0.36, -0.48, 0.800_000_1]).unwrap();
        for direction in [
            LoadDirection::Axis(Direction::Z),
            "-x".parse().unwrap(),
            oblique.clone(),
            oblique.named("diagonal"),
        ] {
            let json = serde_json::to_string(&direction).unwrap();
            assert_eq!(
                serde_json::from_str::<LoadDirection>(&json).unwrap(),
                direction
            );
        }
        assert_eq!(
            serde_json::to_string(&LoadDirection::Axis(Direction::Y)).unwrap(),
            "\"y\""
        );
    }

    #[test]
    fn a_vector_of_another_length_is_refused_with_its_length() {
        let error = "0,3,4".parse::<LoadDirection>().unwrap_err();
        assert_eq!(error.to_string(), "the vector (0,3,4) of length 5.0000");
        for text in ["w", "", "1,0", "0,0,0", "nan,0,0", "inf,0,0", "1,0,0,0"] {
            assert!(text.parse::<LoadDirection>().is_err(), "{text}");
        }
        assert!(LoadDirection::parse_list("0.7,x,0.7").is_err());
        assert!(LoadDirection::parse_list("x,0.7").is_err());
    }

    #[test]
    fn a_mistyped_direction_has_the_one_that_was_meant() {
        for (typed, meant) in [
            ("+x", Some("x")),
            ("y-", Some("-y")),
            ("vertical", Some("y")),
            ("-radal", Some("-z")),
            ("Latteral", Some("x")),
            ("w", None),
            ("", None),
            ("north", None),
        ] {
            assert_eq!(meant_direction(typed), meant, "{typed}");
        }
        let error = "+x".parse::<LoadDirection>().unwrap_err().to_string();
        assert!(error.contains("did you mean `x`?"), "{error}");
        assert_eq!(meant_direction("-zz"), Some("-z"));
        assert_eq!(meant_direction("xy"), None);
    }
}
