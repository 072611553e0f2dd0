//! Colours and markers that are distinguishable with colour blindness and in grey.

/// Luminance to which black and white have the same contrast: (1 + 0.05)/(L + 0.05) = (L + 0.05)/0.05.
const EQUAL_CONTRAST: f64 = 0.179;

/// A colour with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Red, green, blue.
    pub rgb: [u8; 3],
    /// 0 (nothing is seen) to 1.
    pub opacity: f64,
}

impl Colour {
    /// Black.
    pub const BLACK: Self = Self::new(0, 0, 0);
    /// White.
    pub const WHITE: Self = Self::new(255, 255, 255);
    /// Text and axes.
    pub const INK: Self = Self::new(34, 34, 34);
    /// Lines that carry no data.
    pub const GREY: Self = Self::new(136, 136, 136);
    /// Grid.
    pub const FAINT: Self = Self::new(224, 224, 224);

    /// An opaque colour.
    #[must_use]
    pub const fn new(red: u8, green: u8, blue: u8) -> Self {
        Self {
            rgb: [red, green, blue],
            opacity: 1.0,
        }
    }

    /// The same colour, of which only a share is seen.
    #[must_use]
    pub const fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// Lightness as a printer in grey shows it: 0 black, 1 white (weights of ITU-R BT.709).
    #[must_use]
    pub fn grey(self) -> f64 {
        let [red, green, blue] = self.rgb.map(|c| f64::from(c) / 255.0);
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    }

    /// Black or white, whichever has the greater contrast to this colour: at least 4.58, where text needs 4.5 (WCAG 2.2, 1.4.3).
    #[must_use]
    pub fn readable_ink(self) -> Self {
        if self.luminance() > EQUAL_CONTRAST {
            Self::BLACK
        } else {
            Self::WHITE
        }
    }

    /// Relative luminance of WCAG 2.2: 0 black, 1 white.
    fn luminance(self) -> f64 {
        let linear = |c: u8| (f64::from(c) / 255.0).powf(2.2);
        let [red, green, blue] = self.rgb.map(linear);
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    }
}

/// Colours for things that have no order.
///
/// # Source
/// M. Okabe and K. Ito, Color Universal Design (2008). Blue and orange come first because they also differ in grey; yellow is left
/// out because thin lines in it vanish on white.
pub const QUALITATIVE: [Colour; 7] = [
    Colour::new(0, 114, 178),
    Colour::new(230, 159, 0),
    Colour::new(0, 158, 115),
    Colour::new(204, 121, 167),
    Colour::new(213, 94, 0),
    Colour::new(86, 180, 233),
    Colour::new(0, 0, 0),
];

/// The n-th colour without order; after the last the first comes again.
#[must_use]
pub fn qualitative(n: usize) -> Colour {
    QUALITATIVE[n % QUALITATIVE.len()]
}

/// From nearly white (0) to dark blue (1), darkening all the way.
#[must_use]
pub fn sequential(share: f64) -> Colour {
    between(
        &[
            Colour::new(222, 235, 247),
            Colour::new(107, 174, 214),
            Colour::new(8, 48, 107),
        ],
        share,
    )
}

/// From dark violet (0) over green to yellow (1), lightening all the way: for areas whose values are read.
///
/// # Source
/// Viridis by S. van der Walt and N. Smith (2015, CC0), every eighth part of its 256 colours: made for even steps in lightness, also
/// for those who see no red or no green.
#[must_use]
pub fn lightening(share: f64) -> Colour {
    between(
        &[
            Colour::new(68, 1, 84),
            Colour::new(71, 45, 123),
            Colour::new(59, 82, 139),
            Colour::new(44, 114, 142),
            Colour::new(33, 145, 140),
            Colour::new(40, 174, 128),
            Colour::new(94, 201, 98),
            Colour::new(173, 220, 48),
            Colour::new(253, 231, 37),
        ],
        share,
    )
}

/// From dark blue (-1) over white (0) to orange-red (+1).
///
/// Both ends darken, but to different greys, so the sign survives a grey printer; numbers should stand beside it all the same.
#[must_use]
pub fn diverging(signed_share: f64) -> Colour {
    let white = Colour::new(255, 255, 255);
    if signed_share < 0.0 {
        between(&[white, Colour::new(0, 70, 130)], -signed_share)
    } else {
        between(&[white, Colour::new(213, 94, 0)], signed_share)
    }
}

/// Colour at a share of the way along equally spaced stops.
fn between(stops: &[Colour], share: f64) -> Colour {
    let share = if share.is_finite() {
        share.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let place = share * (stops.len() - 1) as f64;
    let first = (place as usize).min(stops.len() - 2);
    let t = place - first as f64;
    let [a, b] = [stops[first].rgb, stops[first + 1].rgb];
    let mixed: [u8; 3] =
        std::array::from_fn(|i| (f64::from(a[i]) * (1.0 - t) + f64::from(b[i]) * t).round() as u8);
    Colour {
        rgb: mixed,
        opacity: 1.0,
    }
}

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Disc.
    Circle,
    /// Square.
    Square,
    /// Triangle standing on its base.
    Triangle,
    /// Square standing on a corner.
    Diamond,
    /// Triangle standing on its tip.
    Nabla,
    /// Diagonal cross; has no inside, so hollow and filled look the same.
    Cross,
    /// Horizontal stroke, for a predicted value beside measured points.
    Dash,
    /// A held node: triangle on hatched ground.
    Ground,
    /// A small dot.
    Dot,
}

/// Shapes in the order in which series take them.
const SHAPES: [Marker; 5] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
    Marker::Nabla,
];

impl Marker {
    /// The n-th shape; after the last the first comes again.
    ///
    /// There are five shapes and seven colours: no two of the first 35 series agree in both.
    #[must_use]
    pub fn nth(n: usize) -> Self {
        SHAPES[n % SHAPES.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_series_differ_in_shape_and_colour() {
        for n in 0..4 {
            assert_ne!(Marker::nth(n), Marker::nth(n + 1));
            assert_ne!(qualitative(n), qualitative(n + 1));
        }
    }

    #[test]
    fn sequential_darkens_all_the_way() {
        let greys: Vec<f64> = (0..=20)
            .map(|i| sequential(f64::from(i) / 20.0).grey())
            .collect();
        assert!(greys.windows(2).all(|pair| pair[1] < pair[0]));
    }

    #[test]
    fn lightening_lightens_all_the_way_and_spans_most_greys() {
        let greys: Vec<f64> = (0..=40)
            .map(|i| lightening(f64::from(i) / 40.0).grey())
            .collect();
        assert!(greys.windows(2).all(|pair| pair[1] > pair[0]), "{greys:?}");
        assert!(greys[40] - greys[0] > 0.75);
    }

    #[test]
    fn diverging_keeps_its_sign_in_grey() {
        assert_eq!(diverging(0.0).rgb, [255, 255, 255]);
        assert!(diverging(1.0).grey() - diverging(-1.0).grey() > 0.2);
        assert_eq!(diverging(f64::NAN).rgb, [255, 255, 255]);
        assert_eq!(diverging(-7.0), diverging(-1.0));
    }

    /// Contrast of WCAG 2.2, whose sRGB has a straight part near black.
    fn contrast(a: Colour, b: Colour) -> f64 {
        let luminance = |colour: Colour| {
            let [red, green, blue] = colour.rgb.map(|c| match f64::from(c) / 255.0 {
                dark if dark <= 0.04045 => dark / 12.92,
                light => ((light + 0.055) / 1.055).powf(2.4),
            });
            0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05
        };
        let [a, b] = [a, b].map(luminance);
        a.max(b) / a.min(b)
    }

    #[test]
    fn text_is_readable_on_every_shade() {
        for i in -100..=100 {
            let share = f64::from(i) / 100.0;
            for ground in [
                diverging(share),
                lightening(share.abs()),
                sequential(share.abs()),
            ] {
                assert!(contrast(ground, ground.readable_ink()) >= 4.5, "{ground:?}");
            }
        }
    }
}
