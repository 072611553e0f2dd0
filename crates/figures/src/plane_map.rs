//! The distribution of a quantity over the workspace (the paper's Figs. 11 to 28): one map as surface and from above, several maps with
//! one scale, and the difference of two.

use std::collections::BTreeMap;

use super::caption::{if_any, joined};
use super::colour_scale::{BAR_PX, ColourScale};
use super::figure::Figure;
use super::plane_bins::{BinValue, PlaneBins};
use super::plane_panel::{PlaneMap, extent, plane_panel, point_legend, with_room};
use super::surface_panel::{SURFACE_PX, surface_panel};
use super::ticks::signed;
/// Height of the view from above, beside a surface and in a sheet of several, px.
const ALONE_PX: f64 = 400.0;
const IN_SHEET_PX: f64 = 330.0;
/// Widest view from above, px.
const WIDEST_PX: f64 = 620.0;
/// A workspace thinner than this share of its length is a line, not a surface.
const FLAT: f64 = 0.05;
/// Panels beside each other in a sheet, without the colour bar.
const SHEET_COLUMNS: usize = 3;
/// Values of one bin that differ by less than this share of the scale are not worth a sentence.
const SPREAD_WORTH_SAYING: f64 = 0.02;

/// One quantity over the workspace of one or several mechanisms.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneMapFigure {
    /// One line of what is shown.
    pub title: String,
    /// Quantity, for example `stiffness along y`.
    pub quantity: String,
    /// Its unit, for example `N/mm`.
    pub unit: String,
    /// What the values are of and how the poses were chosen, as sentences; the caption begins with them.
    pub about: String,
    /// The maps.
    pub maps: Vec<PlaneMap>,
    /// Least and greatest value of the colour scale; `None` takes those of the maps.
    pub range: Option<[f64; 2]>,
}

impl PlaneMapFigure {
    /// One scale for all maps: of the means of the bins, or of the given range.
    fn scale(&self) -> ColourScale {
        let given = self.range.into_iter().flatten();
        if self.range.is_some() {
            return ColourScale::of(&self.quantity, &self.unit, given);
        }
        let means = self.maps.iter().flat_map(PlaneMap::means);
        ColourScale::of(&self.quantity, &self.unit, means)
    }
}

/// Each map as a surface and from above, side by side with the colour bar; all share one scale.
#[must_use]
pub fn plane_map(input: &PlaneMapFigure) -> Figure {
    let scale = input.scale();
    let size = Size::of(input.maps.iter(), ALONE_PX);
    let [width_px, height_px] = size.panel_px;
    let extent = extent(input.maps.iter());
    // An end that keeps its height or its reach has no surface over the plane.
    let [reach, height] = extent.map(|[low, high]| high - low);
    let is_surface = reach.min(height) > FLAT * reach.max(height);
    let mut panels = Vec::new();
    for map in &input.maps {
        if is_surface {
            panels.push(surface_panel(map, &scale, extent, height_px));
        }
        panels.push(plane_panel(map, &scale, size.ranges, size.per_px_m));
        panels.push(scale.bar());
    }
    let mut column_widths_px = vec![width_px, BAR_PX];
    if is_surface {
        column_widths_px.insert(0, SURFACE_PX[0]);
    }
    Figure {
        columns: column_widths_px.len(),
        panel_px: size.panel_px,
        column_widths_px,
        panels,
        legend: point_legend(&input.maps),
        ..Figure::new(input.title.clone(), caption(input, &scale, is_surface))
    }
}

/// All maps from above, three in a row, with one scale.
#[must_use]
pub fn plane_map_sheet(input: &PlaneMapFigure) -> Figure {
    let scale = input.scale();
    let size = Size::of(input.maps.iter(), IN_SHEET_PX);
    let columns = input.maps.len().clamp(1, SHEET_COLUMNS);
    let mut panels = Vec::new();
    for row in input.maps.chunks(columns) {
        panels.extend(
            row.iter()
                .map(|map| plane_panel(map, &scale, size.ranges, size.per_px_m)),
        );
        if row.len() == columns {
            panels.push(scale.bar());
        }
    }
    let mut widths = vec![size.panel_px[0]; columns];
    widths.push(BAR_PX);
    Figure {
        columns: columns + 1,
        panel_px: size.panel_px,
        column_widths_px: widths,
        panels,
        legend: point_legend(&input.maps),
        ..Figure::new(input.title.clone(), caption(input, &scale, false))
    }
}

/// How large views from above are: edges of squares stand on whole pixels, because between areas that end within a pixel the ground
/// shines through.
struct Size {
    ranges: [[f64; 2]; 2],
    /// Metres a pixel spans.
    per_px_m: f64,
    panel_px: [f64; 2],
}

impl Size {
    /// As high as given, or as near to it as whole pixels allow.
    fn of<'a>(maps: impl Iterator<Item = &'a PlaneMap> + Clone, height_px: f64) -> Self {
        let side_m = maps
            .clone()
            .map(|map| map.bins.side_m())
            .fold(1e-9, f64::max);
        let ranges = with_room(extent(maps), side_m);
        let [wide, high] = ranges.map(|[low, high]| ((high - low) / side_m).round());
        let wanted = (height_px / high.max(1.0)).min(WIDEST_PX / wide.max(1.0));
        let side_px = wanted.round().max(1.0);
        Self {
            ranges,
            per_px_m: side_m / side_px,
            panel_px: [wide * side_px, high * side_px],
        }
    }
}

fn caption(input: &PlaneMapFigure, scale: &ColourScale, is_single: bool) -> String {
    let bins = || input.maps.iter().map(|map| &map.bins);
    let left_out: usize = bins().map(PlaneBins::left_out).sum();
    let side_mm = bins().map(PlaneBins::side_m).fold(0.0, f64::max) * 1e3;
    joined([
        (!input.about.is_empty()).then(|| input.about.clone()),
        Some(format!(
            "Colour: {} the poses whose end lies in a square of {}\u{a0}mm; lines: equal values, of the plane through a square and its neighbours{}.",
            value_words(bins().next()),
            signed(side_mm, 1),
            if scale.is_logarithmic() {
                "; the scale is logarithmic"
            } else {
                ""
            },
        )),
        is_single.then(|| extremes_sentence(input)).flatten(),
        within_bins(input, scale),
        if_any(
            left_out,
            format!("{left_out} poses without a finite value are not drawn."),
        ),
    ])
}

/// What the value of a square is of its poses.
fn value_words(bins: Option<&PlaneBins>) -> &'static str {
    match bins.map(PlaneBins::value).unwrap_or_default() {
        BinValue::Mean => "mean over",
        BinValue::Median => "median of",
        BinValue::Least => "least of",
        BinValue::Greatest => "greatest of",
    }
}

/// Least and greatest value, of the first map.
fn extremes_sentence(input: &PlaneMapFigure) -> Option<String> {
    let [map] = &input.maps[..] else {
        return None;
    };
    let number = |value: f64| {
        let digits = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0);
        signed(value, digits as usize)
    };
    let [least, greatest] = [map.least?, map.greatest?].map(|at| number(at.value));
    Some(format!(
        "Least {least}, greatest {greatest}\u{a0}{}, of single poses.",
        input.unit
    ))
}

/// How far poses with their end at one place differ, as a sentence if it can be seen.
fn within_bins(input: &PlaneMapFigure, scale: &ColourScale) -> Option<String> {
    let spreads = input
        .maps
        .iter()
        .flat_map(|map| map.bins.filled())
        .map(|bin| {
            let [low, high] = bin.range.map(|value| scale.share(value));
            high - low
        });
    let mut spreads: Vec<f64> = spreads.filter(|s| s.is_finite()).collect();
    spreads.sort_by(f64::total_cmp);
    let median = *spreads.get(spreads.len() / 2)?;
    (median > SPREAD_WORTH_SAYING).then(|| {
        format!(
            "Poses in one square differ: half of the squares span more than {}\u{a0}% of the scale.",
            signed(100.0 * median, 0)
        )
    })
}

/// Two maps of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneMapDifference {
    /// One line of what is shown.
    pub title: String,
    /// Quantity, for example `stiffness along y`.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// As in [`PlaneMapFigure::about`].
    pub about: String,
    /// The map that is compared with.
    pub before: PlaneMap,
    /// The map that is compared; its bins have the same side.
    pub after: PlaneMap,
}

/// After minus before, and after over before, where both have a value.
#[must_use]
pub fn plane_map_difference(input: &PlaneMapDifference) -> Figure {
    let pairs = pairs(&input.before.bins, &input.after.bins);
    let (quantity, unit) = (&input.quantity, &input.unit);
    let difference = input.of_pairs(&pairs, "minus", |before, after| after - before);
    let ratio = input.of_pairs(&pairs, "over", |before, after| after / before);
    let change = ColourScale::of_change(&format!("change of {quantity}"), unit, difference.means());
    let times = ColourScale::of_ratio(&format!("ratio of {quantity}"), ratio.means());
    let size = Size::of([&difference, &ratio].into_iter(), ALONE_PX);
    let [width_px, _] = size.panel_px;
    let panel =
        |map: &PlaneMap, scale: &ColourScale| plane_panel(map, scale, size.ranges, size.per_px_m);
    Figure {
        columns: 4,
        panel_px: size.panel_px,
        column_widths_px: vec![width_px, BAR_PX, width_px, BAR_PX],
        panels: vec![
            panel(&difference, &change),
            change.bar(),
            panel(&ratio, &times),
            times.bar(),
        ],
        legend: point_legend(std::slice::from_ref(&difference)),
        ..Figure::new(input.title.clone(), input.caption(pairs.len()))
    }
}

/// Place and both means of a square.
type Pair = ([f64; 2], f64, f64);

impl PlaneMapDifference {
    /// The map of what is made of both values.
    fn of_pairs(&self, pairs: &[Pair], word: &str, value: impl Fn(f64, f64) -> f64) -> PlaneMap {
        let points = pairs
            .iter()
            .map(|(at, before, after)| (*at, value(*before, *after)));
        PlaneMap {
            heading: format!("{} {word} {}", self.after.heading, self.before.heading),
            axes: self.after.axes.clone(),
            bins: PlaneBins::gather(
                points.collect::<Vec<_>>().into_iter(),
                self.after.bins.side_m(),
            ),
            extremes: self.after.extremes.clone(),
            least: None,
            greatest: None,
        }
    }

    fn caption(&self, pairs: usize) -> String {
        let filled = [&self.before, &self.after].map(|map| map.bins.filled().count());
        let alone = filled[0] + filled[1] - 2 * pairs;
        joined([
            (!self.about.is_empty()).then(|| self.about.clone()),
            Some(format!(
                "Blue: less, orange: more, white: the same. {} squares of {}\u{a0}mm; the scale of the ratio is logarithmic.",
                match self.after.bins.value() {
                    BinValue::Mean => "Means over",
                    BinValue::Median => "Medians of",
                    BinValue::Least => "The least of",
                    BinValue::Greatest => "The greatest of",
                },
                signed(1e3 * self.after.bins.side_m(), 1)
            )),
            if_any(
                alone,
                format!("{alone} squares have poses of one mechanism only and are not drawn."),
            ),
        ])
    }
}

/// Place and both means of the squares that have both.
fn pairs(before: &PlaneBins, after: &PlaneBins) -> Vec<Pair> {
    let side = after.side_m();
    let key = |centre: [f64; 2]| centre.map(|c| (c / side).floor() as i64);
    let known: BTreeMap<[i64; 2], f64> = before
        .filled()
        .map(|bin| (key(bin.centre_m), bin.value))
        .collect();
    let bins = after.filled();
    bins.filter_map(|bin| Some((bin.centre_m, *known.get(&key(bin.centre_m))?, bin.value)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ValueAt;
    use crate::png::parse;
    use crate::reading::assert_says;

    /// A slanted field over a square, of which a strip may be missing.
    fn map(heading: &str, factor: f64, from: f64) -> PlaneMap {
        let places = (0..2500).map(|i| [i % 50, i / 50].map(|k| 0.02 * f64::from(k) + 0.01));
        let points = places.filter(|at| at[0] > from);
        let points = points.map(|[z, y]| ([z, y], factor * (1.0 + z + y)));
        PlaneMap {
            heading: heading.to_owned(),
            axes: ["z", "y"].map(str::to_owned),
            bins: PlaneBins::gather(points.collect::<Vec<_>>().into_iter(), 0.1),
            extremes: Vec::new(),
            least: None,
            greatest: Some(ValueAt {
                at_m: [0.9, 0.9],
                value: 2.8 * factor,
            }),
        }
    }

    fn input(maps: Vec<PlaneMap>) -> PlaneMapFigure {
        PlaneMapFigure {
            title: "t".to_owned(),
            quantity: "stiffness".to_owned(),
            unit: "N/mm".to_owned(),
            about: String::new(),
            maps,
            range: None,
        }
    }

    #[test]
    fn maps_of_a_sheet_have_one_scale_and_stand_on_whole_pixels() {
        let sheet = input(vec![map("A", 1.0, 0.0), map("B", 2.0, 0.0)]);
        assert!((sheet.scale().range[0] - 1.1).abs() < 1e-12);
        assert!((sheet.scale().range[1] - 5.8).abs() < 1e-12);
        let size = Size::of(sheet.maps.iter(), IN_SHEET_PX);
        let side_px = 0.1 / size.per_px_m;
        assert!((side_px - side_px.round()).abs() < 1e-9, "{side_px}");
        for i in 0..2 {
            let edge = size.ranges[i][0] / 0.1;
            assert!((edge - edge.round()).abs() < 1e-9, "{edge}");
            assert_eq!(size.panel_px[i], size.panel_px[i].round());
        }
        let figure = plane_map_sheet(&sheet);
        assert_eq!(figure.panels.len(), 3);
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn a_difference_counts_what_only_one_has() {
        let figure = plane_map_difference(&PlaneMapDifference {
            title: "t".to_owned(),
            quantity: "stiffness".to_owned(),
            unit: "N/mm".to_owned(),
            about: String::new(),
            before: map("A", 1.0, 0.0),
            after: map("B", 3.0, 0.2),
        });
        assert_says(&figure, "20 squares have poses of one");
        assert_eq!(figure.panels[2].title, "B over A");
        // Three times as much everywhere, and the bar shows from one to three.
        let [low, high] = figure.panels[3].y.range.unwrap();
        assert!(
            (low, (high - 3.0).abs() < 1e-12) == (1.0, true),
            "{low} {high}"
        );
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn no_poses_make_an_empty_figure() {
        let none = PlaneMap {
            bins: PlaneBins::gather(std::iter::empty(), 0.1),
            greatest: None,
            ..map("A", 1.0, 0.0)
        };
        parse(&plane_map(&input(vec![none.clone()])).to_svg()).unwrap();
        parse(&plane_map_sheet(&input(Vec::new())).to_svg()).unwrap();
    }
}
