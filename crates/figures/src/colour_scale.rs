//! From values to the colours of areas, and the levels of contour lines between them.

use super::figure::{Axis, AxisScale, Panel};
use super::palette::{Colour, diverging, lightening};
use super::range::{finite_ends, spread};
use super::ticks::{Tick, ticks};
use super::value_table::colour_bar;

/// Values that span more than this many times the least are spread by their logarithm: evenly, most of a map would be one shade.
const EVEN_UP_TO: f64 = 8.0;
/// Width of the colour bar, px.
pub(super) const BAR_PX: f64 = 15.0;

/// What colour a value has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColourScale {
    pub(super) axis: Axis,
    /// Least and greatest value that are distinguished.
    pub(super) range: [f64; 2],
    /// Part of it that the bar beside the panels shows.
    shown: [f64; 2],
    /// White in the middle, for changes; otherwise from dark to light.
    is_diverging: bool,
}

impl ColourScale {
    /// Scale of a quantity over the span of its values; without any value it runs from 0 to 1.
    pub(super) fn of(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = apart(finite_ends(values).unwrap_or([0.0, 1.0]));
        let axis = if low > 0.0 && high / low > EVEN_UP_TO {
            Axis::log10(quantity, unit)
        } else {
            Axis::linear(quantity, unit)
        };
        Self {
            axis,
            range: [low, high],
            shown: [low, high],
            is_diverging: false,
        }
    }

    /// Scale of a change: equal colours mean equally far up and down; what no value reaches is not shown.
    pub(super) fn of_change(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = finite_ends(values.chain([0.0])).unwrap_or([0.0; 2]);
        let most = if high > low { high.max(-low) } else { 1.0 };
        let range = [-most, most];
        Self::diverging(Axis::linear(quantity, unit), range, [low, high])
    }

    /// Scale of a ratio: equal colours mean equally many times as much and as little.
    pub(super) fn of_ratio(quantity: &str, values: impl Iterator<Item = f64>) -> Self {
        let ratios = values.filter(|ratio| *ratio > 0.0).chain([1.0]);
        let [low, high] = finite_ends(ratios).unwrap_or([1.0; 2]);
        let most = if high > low { high.max(1.0 / low) } else { 2.0 };
        let range = [1.0 / most, most];
        Self::diverging(Axis::log10(quantity, ""), range, [low, high])
    }

    /// A scale with white in the middle of its range, of which so much is found; all of it is shown where nothing changes.
    fn diverging(axis: Axis, range: [f64; 2], [low, high]: [f64; 2]) -> Self {
        Self {
            axis,
            range,
            shown: if high > low { [low, high] } else { range },
            is_diverging: true,
        }
    }

    /// Place of a value on the scale, 0 to 1 within its range.
    pub(super) fn share(&self, value: f64) -> f64 {
        let place = |v| spread(&self.axis.scale, v);
        match (place(value), place(self.range[0]), place(self.range[1])) {
            (Some(value), Some(low), Some(high)) => (value - low) / (high - low),
            _ => 0.0,
        }
    }

    pub(super) fn colour(&self, value: f64) -> Colour {
        if self.is_diverging {
            diverging(2.0 * self.share(value) - 1.0)
        } else {
            lightening(self.share(value))
        }
    }

    /// Levels of contour lines, about as many as wanted, with their texts.
    pub(super) fn levels(&self, wanted: usize) -> Vec<Tick> {
        let all = ticks(&self.axis.scale, self.shown, wanted);
        let inside = |tick: &Tick| {
            let share = self.share(tick.value);
            !tick.text.is_empty() && share > 0.0 && share < 1.0
        };
        all.into_iter().filter(inside).collect()
    }

    /// The scale beside the panels.
    pub(super) fn bar(&self) -> Panel {
        colour_bar(self.axis.clone(), self.shown, |value| self.colour(value))
    }

    /// Whether values are spread by their logarithm.
    pub(super) fn is_logarithmic(&self) -> bool {
        self.axis.scale == AxisScale::Log10
    }
}

/// A span that is not a single value.
fn apart([low, high]: [f64; 2]) -> [f64; 2] {
    if high > low {
        return [low, high];
    }
    let room = if low == 0.0 { 1.0 } else { 0.05 * low.abs() };
    [low - room, high + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_spans_are_spread_by_their_logarithm() {
        let scale = ColourScale::of("K", "N/mm", [0.5, 32.0, f64::NAN].into_iter());
        assert!(scale.is_logarithmic());
        // 4 is the geometric mean of 0.5 and 32.
        assert!((scale.share(4.0) - 0.5).abs() < 1e-12);
        assert_eq!(scale.colour(32.0), lightening(1.0));
        assert!(!ColourScale::of("K", "N/mm", [5.0, 32.0].into_iter()).is_logarithmic());
    }

    #[test]
    fn levels_lie_between_the_ends() {
        let scale = ColourScale::of("K", "N/mm", [9.0, 17.3].into_iter());
        let texts: Vec<String> = scale.levels(5).into_iter().map(|t| t.text).collect();
        assert_eq!(texts, ["10", "12", "14", "16"]);
    }

    #[test]
    fn no_change_is_white_on_every_scale_of_changes() {
        let change = ColourScale::of_change("change", "N/mm", [-1.0, 30.0].into_iter());
        let ratio = ColourScale::of_ratio("ratio", [0.5, 30.0].into_iter());
        assert_eq!(change.colour(0.0), Colour::WHITE);
        assert_eq!(ratio.colour(1.0), Colour::WHITE);
        assert_eq!(change.range, [-30.0, 30.0]);
        assert!((ratio.range[0] * 30.0 - 1.0).abs() < 1e-12);
        // The bar shows what is there, with no change in it.
        assert_eq!((change.shown, ratio.shown), ([-1.0, 30.0], [0.5, 30.0]));
        let up = ColourScale::of_change("change", "N/mm", [3.0, 30.0].into_iter());
        assert_eq!(up.shown, [0.0, 30.0]);
    }

    #[test]
    fn odd_values_still_make_a_scale() {
        for scale in [
            ColourScale::of("K", "", std::iter::empty()),
            ColourScale::of("K", "", [3.0, 3.0].into_iter()),
            ColourScale::of_change("K", "", std::iter::empty()),
            ColourScale::of_ratio("K", [1.0, -2.0].into_iter()),
        ] {
            assert!(scale.range[0] < scale.range[1], "{scale:?}");
        }
    }
}
