//! Dimensions of the parameters of laws: the SI unit in files, other spellings that are read, the unit printed for people.

/// Spellings of a unit: the word, and how many of them make one SI unit.
///
/// Division by such a count gives the number nearest to the quotient: 30 um is 3e-5 m, which 30 × 1e-6 is not.
type Spelling = (&'static str, f64);

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// What a parameter measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Rotation of a joint under load, rad.
    JointRotation,
    /// A direction or a phase, rad.
    Angle,
    /// A moment, N·m.
    Moment,
    /// Compliance in rotation, rad/(N·m).
    RotationalCompliance,
    /// Quadratic compliance in rotation, rad/(N·m)².
    QuadraticRotationalCompliance,
    /// Compliance in translation, m/N.
    Compliance,
    /// Quadratic compliance in translation, m/N².
    QuadraticCompliance,
    /// A length, m.
    Length,
    /// A force, N.
    Force,
    /// Change of a length with time, m/s.
    LengthPerTime,
    /// Change of a length with temperature, m/K.
    LengthPerTemperature,
    /// Share for each newton, 1/N.
    PerForce,
    /// Share for each decade of time.
    PerDecade,
    /// A time, s.
    Time,
    /// A share, 1.
    Share,
    /// A number of repeats.
    Repeats,
    /// What a part answers with, in the unit of its table.
    Answer,
    /// What is set at a part, in the unit of its table.
    Driver,
    /// Answer for each unit of what is set.
    AnswerPerDriver,
    /// The same for each cube.
    AnswerPerDriverCubed,
    /// Share for each unit of what is set.
    PerDriver,
    /// Share for each square of what is set.
    PerDriverSquared,
}

impl Dimension {
    /// Unit in files, in SI and ASCII.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.spellings()[0].0
    }

    /// All spellings, the unit in files first.
    fn spellings(self) -> &'static [Spelling] {
        match self {
            Self::JointRotation | Self::Angle => {
                &[("rad", 1.0), ("mrad", 1e3), ("urad", 1e6), ("deg", DEGREES)]
            }
            Self::Moment => &[("N*m", 1.0), ("N*mm", 1e3), ("mN*m", 1e3)],
            Self::RotationalCompliance => {
                &[("rad/(N*m)", 1.0), ("mrad/(N*m)", 1e3), ("urad/(N*m)", 1e6)]
            }
            Self::QuadraticRotationalCompliance => &[
                ("rad/(N*m)^2", 1.0),
                ("mrad/(N*m)^2", 1e3),
                ("urad/(N*m)^2", 1e6),
            ],
            Self::Compliance => &[("m/N", 1.0), ("mm/N", 1e3), ("um/N", 1e6), ("nm/N", 1e9)],
            Self::QuadraticCompliance => &[("m/N^2", 1.0), ("mm/N^2", 1e3), ("um/N^2", 1e6)],
            Self::Length => &[("m", 1.0), ("mm", 1e3), ("um", 1e6), ("nm", 1e9)],
            Self::Force => &[("N", 1.0), ("mN", 1e3), ("kN", 1e-3)],
            Self::LengthPerTime => &[
                ("m/s", 1.0),
                ("um/s", 1e6),
                ("nm/s", 1e9),
                ("um/min", 6e7),
                ("um/h", 3.6e9),
            ],
            Self::LengthPerTemperature => {
                &[("m/K", 1.0), ("mm/K", 1e3), ("um/K", 1e6), ("nm/K", 1e9)]
            }
            Self::PerForce => &[("1/N", 1.0), ("%/N", 1e2), ("1/kN", 1e3)],
            Self::PerDecade => &[("1/decade", 1.0), ("%/decade", 1e2)],
            Self::Time => &[("s", 1.0), ("ms", 1e3), ("min", 1.0 / 60.0)],
            Self::Share => &[("1", 1.0), ("", 1.0), ("%", 1e2)],
            Self::Repeats => &[("repeats", 1.0), ("repeat", 1.0), ("", 1.0)],
            Self::Answer => &[("answer", 1.0)],
            Self::Driver => &[("driver", 1.0)],
            Self::AnswerPerDriver => &[("answer/driver", 1.0)],
            Self::AnswerPerDriverCubed => &[("answer/driver^3", 1.0)],
            Self::PerDriver => &[("1/driver", 1.0)],
            Self::PerDriverSquared => &[("1/driver^2", 1.0)],
        }
    }

    /// A number in SI; `None` if `unit` is no spelling of this dimension.
    pub(super) fn in_si(self, number: f64, unit: &str) -> Option<f64> {
        let plain = unit.replace(['µ', 'μ'], "u").replace(['·', '⋅'], "*");
        let spellings = self.spellings();
        let (_, per_si) = spellings.iter().find(|(word, _)| *word == plain)?;
        Some(number / per_si)
    }

    /// The spellings in words, for messages.
    pub(super) fn accepted(self) -> String {
        let words: Vec<&str> = self
            .spellings()
            .iter()
            .map(|(word, _)| if word.is_empty() { "no unit" } else { word })
            .collect();
        words.join(", ")
    }

    /// Factor and unit in which a value of a size in SI is printed for people.
    #[must_use]
    pub fn printed(self, size: f64) -> (f64, &'static str) {
        match self {
            Self::Angle => (DEGREES, "degrees"),
            Self::JointRotation if size.abs() < 1e-3 => (1e6, "urad"),
            Self::JointRotation => (1e3, "mrad"),
            Self::RotationalCompliance if size.abs() < 1e-3 => (1e6, "urad per N m"),
            Self::RotationalCompliance => (1e3, "mrad per N m"),
            Self::QuadraticRotationalCompliance => (1e6, "urad per (N m)^2"),
            Self::Compliance => (1e6, "um/N"),
            Self::QuadraticCompliance => (1e6, "um/N^2"),
            Self::Length if size.abs() < 1e-3 => (1e6, "um"),
            Self::Length => (1e3, "mm"),
            Self::LengthPerTime => (6e7, "um/min"),
            Self::LengthPerTemperature => (1e6, "um/K"),
            Self::PerForce => (1e4, "% per 100 N"),
            Self::PerDecade => (100.0, "% per tenfold time"),
            Self::Share => (100.0, "%"),
            Self::Moment => (1.0, "N m"),
            Self::Force => (1.0, "N"),
            Self::Time => (1.0, "s"),
            Self::Answer
            | Self::Driver
            | Self::AnswerPerDriver
            | Self::AnswerPerDriverCubed
            | Self::PerDriver
            | Self::PerDriverSquared => (1.0, self.unit()),
            Self::Repeats => (1.0, "repeats"),
        }
    }

    /// The same of a joint that slides: what is a rotation or a moment in one that turns is a displacement or a force.
    #[must_use]
    pub(super) fn of_slide(self) -> Self {
        match self {
            Self::JointRotation => Self::Length,
            Self::Moment => Self::Force,
            Self::RotationalCompliance => Self::Compliance,
            Self::QuadraticRotationalCompliance => Self::QuadraticCompliance,
            other => other,
        }
    }

    /// Powers of load, answer and time in a parameter of a force-displacement table without a robot, where a joint with a lever of one
    /// length unit stands for the specimen; `None` where the dimension has none of them.
    ///
    /// # Returns
    /// `[answer, load, time]`.
    #[must_use]
    pub fn powers(self) -> Option<[i8; 3]> {
        match self {
            Self::JointRotation | Self::Length | Self::Answer => Some([1, 0, 0]),
            Self::Moment | Self::Force | Self::Driver => Some([0, 1, 0]),
            Self::RotationalCompliance | Self::Compliance | Self::AnswerPerDriver => {
                Some([1, -1, 0])
            }
            Self::QuadraticRotationalCompliance | Self::QuadraticCompliance => Some([1, -2, 0]),
            Self::AnswerPerDriverCubed => Some([1, -3, 0]),
            Self::PerForce | Self::PerDriver => Some([0, -1, 0]),
            Self::PerDriverSquared => Some([0, -2, 0]),
            Self::LengthPerTime => Some([1, 0, -1]),
            Self::LengthPerTemperature => Some([1, 0, 0]),
            Self::Angle | Self::PerDecade | Self::Time | Self::Share | Self::Repeats => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_divided_by_what_makes_one_si_unit() {
        for (number, unit, dimension, expected) in [
            (-30.0, "um", Dimension::Length, -3e-5),
            (-30.0, "µm", Dimension::Length, -3e-5),
            (120.0, "urad", Dimension::JointRotation, 1.2e-4),
            (3.6, "N·m", Dimension::Moment, 3.6),
            (4.0, "%/decade", Dimension::PerDecade, 0.04),
            (36.0, "um/h", Dimension::LengthPerTime, 1e-8),
            (2.0, "min", Dimension::Time, 120.0),
            (1.5, "", Dimension::Repeats, 1.5),
        ] {
            assert_eq!(
                dimension.in_si(number, unit),
                Some(expected),
                "{number} {unit}"
            );
        }
        let degrees = Dimension::Angle.in_si(180.0, "deg").unwrap();
        assert!((degrees - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(Dimension::Length.in_si(1.0, "N"), None);
        assert_eq!(Dimension::Length.in_si(1.0, ""), None);
        assert_eq!(Dimension::Repeats.accepted(), "repeats, repeat, no unit");
    }
}
