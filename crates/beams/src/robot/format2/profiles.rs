//! Cross-sections by profile: `tube 40x3`, `box 60x40x3`, `bar 60x10`, `round 12`, `IPE 200`, `HEA 160`, `HEB 100`, `UPN 80`.

use std::f64::consts::PI;

use crate::structure::{Section, ShearCoefficients};

use super::rolled::{self, Rolled};

/// Constants of a profile. Local z is its height, local y its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SectionProfile {
    /// Area, second moments, torsion constant.
    pub(crate) section: Section,
    /// Shear area over area.
    pub(crate) shear: ShearCoefficients,
    /// Whether it bends alike about both axes, so that its plane does not matter.
    pub(crate) is_round: bool,
}

/// Why a text is no profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum ProfileError {
    /// A word that names no shape.
    #[error("`{word}` is not a profile")]
    UnknownShape {
        /// The word.
        word: String,
    },
    /// Not as many dimensions as the shape has.
    #[error("a `{shape}` has the dimensions {form}, in mm, not `{found}`")]
    Dimensions {
        /// The shape.
        shape: &'static str,
        /// How they are written.
        form: &'static str,
        /// What was written.
        found: String,
    },
    /// A wall that fills more than the section, or a size that is not above zero.
    #[error("the wall of `{text}` is thicker than half of its outside")]
    Wall {
        /// The text.
        text: String,
    },
    /// A size that the table does not have.
    #[error("there is no {series} {size}; the table has {known}")]
    UnknownSize {
        /// Name of the series.
        series: &'static str,
        /// The size.
        size: String,
        /// The sizes there are.
        known: String,
    },
}

/// Names and dimensions of the shapes that are made to measure.
const SHAPES: [(&str, &str, usize); 4] = [
    ("tube", "DIAMETERxWALL, for example 40x3", 2),
    ("box", "HEIGHTxWIDTHxWALL, for example 60x40x3", 3),
    ("bar", "HEIGHTxWIDTH, for example 60x10", 2),
    ("round", "DIAMETER, for example 12", 1),
];

/// The first words of profiles.
pub(crate) fn shapes() -> impl Iterator<Item = &'static str> {
    let made = SHAPES.iter().map(|(name, ..)| *name);
    made.chain(rolled::SERIES.iter().map(|series| series.name))
}

impl SectionProfile {
    /// The constants of a profile given as text; dimensions in mm.
    ///
    /// # Errors
    /// [`ProfileError`] for an unknown shape or size, or dimensions that leave no section.
    pub(crate) fn parse(text: &str) -> Result<Self, ProfileError> {
        let text = text.trim();
        let split = text.find(|c: char| c.is_whitespace() || c.is_ascii_digit());
        let (word, rest) = text.split_at(split.unwrap_or(text.len()));
        let rest = rest.trim();
        if let Some(series) = rolled::SERIES
            .iter()
            .find(|series| series.name.eq_ignore_ascii_case(word))
        {
            return Ok(Self::rolled(series.find(rest)?));
        }
        let shape = SHAPES
            .iter()
            .find(|(name, ..)| name.eq_ignore_ascii_case(word));
        let Some(&(shape, form, count)) = shape else {
            let word = word.to_owned();
            return Err(ProfileError::UnknownShape { word });
        };
        let sizes: Option<Vec<f64>> = rest.split(['x', 'X', '×']).map(size_m).collect();
        let Some(sizes) = sizes.filter(|sizes| sizes.len() == count) else {
            let found = rest.to_owned();
            return Err(ProfileError::Dimensions { shape, form, found });
        };
        let made = match (shape, &sizes[..]) {
            ("tube", &[diameter, wall]) => Self::tube(diameter, wall),
            ("box", &[height, width, wall]) => Self::hollow(height, width, wall),
            ("bar", &[height, width]) => Some(Self::bar(height, width)),
            (_, &[diameter, ..]) => Some(Self::round(diameter)),
            _ => None,
        };
        made.ok_or_else(|| ProfileError::Wall {
            text: text.to_owned(),
        })
    }

    fn round(diameter_m: f64) -> Self {
        Self {
            section: Section::solid_circle(diameter_m),
            shear: both(0.9),
            is_round: true,
        }
    }

    /// Roark, 8th edition, table A.1 case 16 and table 10.7 case 10.
    fn tube(diameter_m: f64, wall_m: f64) -> Option<Self> {
        let inner = diameter_m - 2.0 * wall_m;
        let i = PI / 64.0 * (diameter_m.powi(4) - inner.powi(4));
        let section = Section {
            area_m2: PI * wall_m * (diameter_m - wall_m),
            iy_m4: i,
            iz_m4: i,
            j_m4: 2.0 * i,
        };
        (inner >= 0.0).then_some(Self {
            section,
            shear: both(0.5),
            is_round: true,
        })
    }

    /// Torsion of the thin closed wall along its middle line (Bredt): Roark, 8th edition, table 10.7 case 16.
    fn hollow(height_m: f64, width_m: f64, wall_m: f64) -> Option<Self> {
        let (h, b, t) = (height_m, width_m, wall_m);
        let (inner_h, inner_b) = (h - 2.0 * t, b - 2.0 * t);
        let area = h * b - inner_h * inner_b;
        let section = Section {
            area_m2: area,
            iy_m4: (b * h.powi(3) - inner_b * inner_h.powi(3)) / 12.0,
            iz_m4: (h * b.powi(3) - inner_h * inner_b.powi(3)) / 12.0,
            j_m4: 2.0 * t * ((h - t) * (b - t)).powi(2) / (h + b - 2.0 * t),
        };
        (inner_h > 0.0 && inner_b > 0.0).then_some(Self {
            section,
            shear: ShearCoefficients {
                along_y: 2.0 * t * b / area,
                along_z: 2.0 * t * h / area,
            },
            is_round: h == b,
        })
    }

    /// Roark, 8th edition, table 10.7 case 4 for torsion.
    fn bar(height_m: f64, width_m: f64) -> Self {
        let (h, b) = (height_m, width_m);
        let (long, short) = (0.5 * h.max(b), 0.5 * h.min(b));
        let slender = short / long;
        let torsion = 16.0 / 3.0 - 3.36 * slender * (1.0 - slender.powi(4) / 12.0);
        Self {
            section: Section {
                area_m2: h * b,
                iy_m4: b * h.powi(3) / 12.0,
                iz_m4: h * b.powi(3) / 12.0,
                j_m4: long * short.powi(3) * torsion,
            },
            shear: both(5.0 / 6.0),
            is_round: h == b,
        }
    }

    fn rolled(rolled: Rolled) -> Self {
        Self {
            section: rolled.section,
            shear: rolled.shear,
            is_round: false,
        }
    }
}

/// A dimension in mm as text, m; above zero and below 10 m.
fn size_m(text: &str) -> Option<f64> {
    let size: f64 = text.trim().parse().ok()?;
    (size > 0.0 && size < 1e4).then_some(1e-3 * size)
}

fn both(share: f64) -> ShearCoefficients {
    ShearCoefficients {
        along_y: share,
        along_z: share,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A in cm², Iy, Iz, J in cm⁴.
    fn cm(text: &str) -> [f64; 4] {
        let [a, iy, iz, j] = SectionProfile::parse(text).unwrap().section.constants();
        [1e4 * a, 1e8 * iy, 1e8 * iz, 1e8 * j]
    }

    fn agrees(text: &str, expected: [f64; 4], relative: f64) {
        let found = cm(text);
        for (found, expected) in found.into_iter().zip(expected) {
            let error = (found / expected - 1.0).abs();
            assert!(error < relative, "{text}: {found} is not {expected}");
        }
    }

    /// Closed forms, and EN 10219-2, table B.2, for the box (its corners are rounded).
    #[test]
    fn sections_made_to_measure() {
        agrees("tube 40x3", [3.487, 6.007, 6.007, 12.01], 1e-3);
        agrees("tube 40 x 20", [12.566, 12.566, 12.566, 25.13], 1e-3);
        agrees("round 12", [1.131, 0.10179, 0.10179, 0.20358], 1e-4);
        agrees("box 60x40x3", [5.64, 27.385, 14.313, 28.391], 1e-4);
        agrees("box 60x40x3", [5.41, 25.4, 13.4, 29.3], 0.08);
        agrees("bar 20x10", [2.0, 0.666_67, 0.166_67, 0.4577], 1e-3);
        agrees("BAR 10X10", [1.0, 0.083_333, 0.083_333, 0.1406], 2e-3);
    }

    /// A, Iy, Iz and It as printed in the tables of EN 10365.
    #[test]
    fn rolled_sections_as_printed() {
        agrees("IPE 100", [10.32, 171.0, 15.92, 1.20], 6e-3);
        agrees("IPE200", [28.48, 1943.0, 142.4, 6.98], 6e-3);
        agrees("IPE 300", [53.81, 8356.0, 603.8, 20.12], 6e-3);
        agrees("HEA 200", [53.83, 3692.0, 1336.0, 20.98], 6e-3);
        agrees("HEB 200", [78.08, 5696.0, 2003.0, 59.28], 6e-3);
        agrees("hea 100", [21.24, 349.2, 133.8, 5.24], 6e-3);
        agrees("UPN 80", [11.0, 106.0, 19.4, 2.16], 1e-9);
    }

    #[test]
    fn what_is_no_profile_is_refused() {
        for text in [
            "",
            "tub 40x3",
            "tube",
            "tube 40",
            "tube 40x3x2",
            "tube 40x-3",
            "tube 40x21",
            "box 10x10x5",
            "round 0",
            "round inf",
            "IPE 205",
            "IPE",
            "UPN x",
            "40x3",
            "tube 1e9x1",
        ] {
            assert!(SectionProfile::parse(text).is_err(), "{text}");
        }
        let error = SectionProfile::parse("IPE 205").unwrap_err().to_string();
        assert!(error.contains("80, 100"), "{error}");
    }
}
