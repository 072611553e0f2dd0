//! Ranges of axes, and the way from a value to a place on the sheet.

use super::figure::{Axis, AxisScale, Figure, Marks, Panel, Sharing};

/// Room between the outermost data and the end of an axis, as a share of the data's span.
const MARGIN: f64 = 0.06;

/// One of the two axes of a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    X,
    Y,
}

impl Along {
    pub(super) fn axis(self, panel: &Panel) -> &Axis {
        match self {
            Self::X => &panel.x,
            Self::Y => &panel.y,
        }
    }

    fn pick(self, [x, y]: [f64; 2]) -> f64 {
        match self {
            Self::X => x,
            Self::Y => y,
        }
    }
}

/// Least and greatest of the finite values, if there are any.
pub(super) fn finite_ends(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let ends = finite.map(|value| [value, value]);
    ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// The different ones of some things, in the order in which they first come.
pub(super) fn distinct<T: PartialEq>(things: impl Iterator<Item = T>) -> Vec<T> {
    let mut all: Vec<T> = Vec::new();
    for thing in things {
        if !all.contains(&thing) {
            all.push(thing);
        }
    }
    all
}

/// Value on the axis as it is spread: its logarithm on a logarithmic axis; `None` if it has no place there.
pub(super) fn spread(scale: &AxisScale, value: f64) -> Option<f64> {
    let spread = match scale {
        AxisScale::Log10 if value > 0.0 => value.log10(),
        AxisScale::Log10 => return None,
        AxisScale::Linear | AxisScale::Categories(_) => value,
    };
    spread.is_finite().then_some(spread)
}

/// Inverse of [`spread`].
pub(super) fn unspread(scale: &AxisScale, place: f64) -> f64 {
    match scale {
        AxisScale::Log10 => 10f64.powf(place),
        AxisScale::Linear | AxisScale::Categories(_) => place,
    }
}

/// Range of every panel along one axis, in spread coordinates, with sharing.
pub(super) fn ranges(figure: &Figure, along: Along, sharing: Sharing) -> Vec<[f64; 2]> {
    let columns = figure.columns.max(1);
    let group = |panel: usize| match sharing {
        Sharing::Own => panel,
        Sharing::All => 0,
        Sharing::Column => panel % columns,
        Sharing::Row => panel / columns,
    };
    let spans: Vec<Option<[f64; 2]>> = figure
        .panels
        .iter()
        .map(|panel| data_span(panel, along))
        .collect();
    (0..figure.panels.len())
        .map(|index| {
            let axis = along.axis(&figure.panels[index]);
            if let Some(fixed) = fixed_range(axis) {
                return fixed;
            }
            let shared = (0..spans.len())
                .filter(|other| group(*other) == group(index))
                .filter_map(|other| spans[other])
                .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            padded(shared)
        })
        .collect()
}

/// The range that the axis itself prescribes.
fn fixed_range(axis: &Axis) -> Option<[f64; 2]> {
    if let Some([low, high]) = axis.range {
        let [low, high] = [spread(&axis.scale, low)?, spread(&axis.scale, high)?];
        return (low < high).then_some([low, high]);
    }
    match &axis.scale {
        AxisScale::Categories(names) => Some([-0.5, names.len().max(1) as f64 - 0.5]),
        AxisScale::Linear | AxisScale::Log10 => None,
    }
}

fn padded(span: Option<[f64; 2]>) -> [f64; 2] {
    let Some([low, high]) = span else {
        return [0.0, 1.0];
    };
    let room = if high > low {
        MARGIN * (high - low)
    } else if high == 0.0 {
        1.0
    } else {
        // A single value stands in the middle of a tenth of itself.
        0.05 * high.abs()
    };
    [low - room, high + room]
}

/// Smallest and largest spread value that the marks of a panel reach along one axis.
fn data_span(panel: &Panel, along: Along) -> Option<[f64; 2]> {
    let scale = &along.axis(panel).scale;
    let mut span: Option<[f64; 2]> = None;
    let mut reach = |value: f64| {
        if let Some(place) = spread(scale, value) {
            let [low, high] = span.unwrap_or([place, place]);
            span = Some([low.min(place), high.max(place)]);
        }
    };
    for series in &panel.series {
        match &series.marks {
            Marks::Points(points) => {
                for point in points {
                    reach(along.pick([point.x, point.y]));
                    let bar = match along {
                        Along::X => point.x_bar,
                        Along::Y => point.y_bar,
                    };
                    bar.into_iter().flatten().for_each(&mut reach);
                }
            }
            Marks::Line(points) | Marks::Steps(points) => {
                for point in points {
                    reach(along.pick(*point));
                }
            }
            Marks::Segments(pairs) | Marks::Arrows(pairs) => {
                pairs
                    .iter()
                    .flatten()
                    .for_each(|point| reach(along.pick(*point)));
            }
            Marks::Band(points) => {
                for [x, low, high] in points {
                    reach(along.pick([*x, *low]));
                    reach(along.pick([*x, *high]));
                }
            }
            Marks::Polygons(polygons) => polygons
                .iter()
                .flat_map(|polygon| &polygon.corners)
                .for_each(|corner| reach(along.pick(*corner))),
            Marks::LevelAt(value) if along == Along::Y => reach(*value),
            Marks::UprightAt(value) if along == Along::X => reach(*value),
            Marks::LevelAt(_) | Marks::UprightAt(_) => {}
        }
    }
    span
}

/// Widens one of two ranges so that a unit is equally long along both.
pub(super) fn with_equal_aspect(
    x: [f64; 2],
    y: [f64; 2],
    [width_px, height_px]: [f64; 2],
) -> [[f64; 2]; 2] {
    let per_px = ((x[1] - x[0]) / width_px).max((y[1] - y[0]) / height_px);
    let widened = |range: [f64; 2], length_px: f64| {
        let middle = 0.5 * (range[0] + range[1]);
        let half = 0.5 * per_px * length_px;
        [middle - half, middle + half]
    };
    [widened(x, width_px), widened(y, height_px)]
}

/// From values along one axis to places on the sheet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ruler {
    scale: AxisScale,
    /// Spread values at the two ends.
    range: [f64; 2],
    /// Places of the two ends, px.
    ends_px: [f64; 2],
}

impl Ruler {
    /// Ruler whose range runs from the first to the second place.
    pub(super) fn new(axis: &Axis, range: [f64; 2], ends_px: [f64; 2]) -> Self {
        let ends_px = if axis.reversed {
            [ends_px[1], ends_px[0]]
        } else {
            ends_px
        };
        Self {
            scale: axis.scale.clone(),
            range,
            ends_px,
        }
    }

    /// Place of a value, also beyond the ends; `None` if it has none.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let share = (spread(&self.scale, value)? - self.range[0]) / (self.range[1] - self.range[0]);
        Some(self.ends_px[0] + share * (self.ends_px[1] - self.ends_px[0]))
    }

    /// Place of a value whose ends beyond the axis stop at its end: what has no place on a logarithmic axis lies below it.
    pub(super) fn stopped(&self, value: f64) -> f64 {
        let [low, high] = [
            self.ends_px[0].min(self.ends_px[1]),
            self.ends_px[0].max(self.ends_px[1]),
        ];
        self.place(value).map_or_else(
            || {
                if value == f64::INFINITY {
                    self.ends_px[1]
                } else {
                    self.ends_px[0]
                }
            },
            |place| place.clamp(low, high),
        )
    }

    /// Whether a value lies on the axis; rounding at its ends is forgiven.
    pub(super) fn holds(&self, value: f64) -> bool {
        let slack = 1e-9 * (self.range[1] - self.range[0]);
        spread(&self.scale, value)
            .is_some_and(|v| v >= self.range[0] - slack && v <= self.range[1] + slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{FigurePoint, Series, Style};

    fn panel(points: &[[f64; 2]]) -> Panel {
        let mut panel = Panel::new("", Axis::linear("a", "m"), Axis::log10("b", "N"));
        panel.series.push(Series::new(
            Style::nth(0),
            Marks::Points(
                points
                    .iter()
                    .map(|[x, y]| FigurePoint::new(*x, *y))
                    .collect(),
            ),
        ));
        panel
    }

    fn figure(panels: Vec<Panel>, columns: usize) -> Figure {
        Figure {
            columns,
            panels,
            ..Figure::new("t", "c")
        }
    }

    #[test]
    fn sharing_joins_the_right_panels() {
        let figure = figure(
            vec![
                panel(&[[0.0, 1.0], [1.0, 10.0]]),
                panel(&[[5.0, 1.0], [6.0, 10.0]]),
                panel(&[[10.0, 1.0], [20.0, 10.0]]),
            ],
            2,
        );
        let low = |sharing| -> Vec<f64> {
            ranges(&figure, Along::X, sharing)
                .iter()
                .map(|range| range[0].round())
                .collect()
        };
        assert_eq!(low(Sharing::Own), [0.0, 5.0, 9.0]);
        assert_eq!(low(Sharing::All), [-1.0, -1.0, -1.0]);
        assert_eq!(low(Sharing::Column), [-1.0, 5.0, -1.0]);
        assert_eq!(low(Sharing::Row), [0.0, 0.0, 9.0]);
    }

    #[test]
    fn odd_data_still_give_a_range() {
        let figure = figure(
            vec![
                panel(&[]),
                panel(&[[3.0, 3.0]]),
                panel(&[[f64::NAN, -1.0], [0.0, 0.0]]),
            ],
            3,
        );
        for along in [Along::X, Along::Y] {
            for range in ranges(&figure, along, Sharing::Own) {
                assert!(range[0] < range[1] && range[0].is_finite() && range[1].is_finite());
            }
        }
    }

    #[test]
    fn a_logarithmic_ruler_puts_the_geometric_mean_in_the_middle() {
        let ruler = Ruler::new(&Axis::log10("K", "N/m"), [0.0, 4.0], [100.0, 0.0]);
        assert_eq!(ruler.place(100.0), Some(50.0));
        assert_eq!(ruler.place(-1.0), None);
        assert_eq!(ruler.stopped(-1.0), 100.0);
        assert_eq!(ruler.stopped(1e9), 0.0);
        assert!(ruler.holds(1e4) && !ruler.holds(1.1e4));
    }

    #[test]
    fn equal_aspect_never_cuts() {
        let [x, y] = with_equal_aspect([0.0, 2.0], [0.0, 1.0], [100.0, 100.0]);
        assert_eq!((x, y), ([0.0, 2.0], [-0.5, 1.5]));
    }
}
