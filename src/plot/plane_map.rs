//! The distribution of a quantity over the workspace (the paper's Figs. 11 to 28): one map as surface and from above, several maps with
//! one scale, and the difference of two.

use super::caption::{if_any, joined};
use super::colour_scale::{BAR_PX, ColourScale};
use super::figure::{Figure, LegendEntry, Panel};
use super::plane_bins::PlaneBins;
use super::plane_panel::{PlaneMap, plane_panel, plane_ranges, point_legend};
use super::surface_panel::{SURFACE_PX, surface_panel};
use super::ticks::signed;
/// Height of the view from above, beside a surface and in a sheet of several, px.
const ALONE_PX: f64 = 400.0;
const IN_SHEET_PX: f64 = 330.0;
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
    let ranges = plane_ranges(input.maps.iter());
    let (per_px_m, width_px) = size(ranges, ALONE_PX);
    let mut panels = Vec::new();
    for map in &input.maps {
        panels.push(surface_panel(map, &scale, ranges));
        panels.push(plane_panel(map, &scale, ranges, per_px_m));
        panels.push(scale.bar());
    }
    Figure {
        columns: 3,
        panel_px: [width_px, ALONE_PX],
        column_widths_px: vec![SURFACE_PX[0], width_px, BAR_PX],
        panels,
        legend: point_legend(input.maps.iter()),
        ..Figure::new(input.title.clone(), caption(input, &scale, true))
    }
}

/// All maps from above, three in a row, with one scale.
#[must_use]
pub fn plane_map_sheet(input: &PlaneMapFigure) -> Figure {
    let scale = input.scale();
    let ranges = plane_ranges(input.maps.iter());
    let (per_px_m, width_px) = size(ranges, IN_SHEET_PX);
    let columns = input.maps.len().clamp(1, SHEET_COLUMNS);
    let mut panels = Vec::new();
    for row in input.maps.chunks(columns) {
        panels.extend(
            row.iter()
                .map(|map| plane_panel(map, &scale, ranges, per_px_m)),
        );
        if row.len() == columns {
            panels.push(scale.bar());
        }
    }
    let mut widths = vec![width_px; columns];
    widths.push(BAR_PX);
    Figure {
        columns: columns + 1,
        panel_px: [width_px, IN_SHEET_PX],
        column_widths_px: widths,
        panels,
        legend: point_legend(input.maps.iter()),
        ..Figure::new(input.title.clone(), caption(input, &scale, false))
    }
}

/// Metres a pixel spans so that the map is as high as given, and how wide it then is, px.
fn size([z, y]: [[f64; 2]; 2], height_px: f64) -> (f64, f64) {
    let per_px_m = (y[1] - y[0]) / height_px;
    let width_px = ((z[1] - z[0]) / per_px_m).clamp(150.0, 560.0);
    (per_px_m.max((z[1] - z[0]) / width_px), width_px)
}

fn caption(input: &PlaneMapFigure, scale: &ColourScale, is_single: bool) -> String {
    let bins = || input.maps.iter().map(|map| &map.bins);
    let left_out: usize = bins().map(PlaneBins::left_out).sum();
    let side_mm = bins().map(PlaneBins::side_m).fold(0.0, f64::max) * 1e3;
    joined([
        (!input.about.is_empty()).then(|| input.about.clone()),
        Some(format!(
            "Colour: mean over the poses whose end lies in a square of {}\u{a0}mm; lines: equal values, of the plane through a square and its neighbours{}.",
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
    let pairs: Vec<([f64; 2], f64, f64)> = pairs(&input.before.bins, &input.after.bins);
    let side_m = input.after.bins.side_m();
    let map = |value: &dyn Fn(f64, f64) -> f64, heading: &str| PlaneMap {
        heading: heading.to_owned(),
        bins: PlaneBins::gather(
            pairs
                .iter()
                .map(|(at, before, after)| (*at, value(*before, *after))),
            side_m,
        ),
        extremes: input.after.extremes.clone(),
        least: None,
        greatest: None,
    };
    let [a, b] = [&input.before.heading, &input.after.heading];
    let difference = map(&|before, after| after - before, &format!("{b} minus {a}"));
    let ratio = map(&|before, after| after / before, &format!("{b} over {a}"));
    let change = ColourScale::of_change(
        &format!("change of {}", input.quantity),
        &input.unit,
        difference.means(),
    );
    let times = ColourScale::of_ratio(&format!("ratio of {}", input.quantity), ratio.means());
    let ranges = plane_ranges([&difference, &ratio].into_iter());
    let (per_px_m, width_px) = size(ranges, ALONE_PX);
    let panels: Vec<Panel> = vec![
        plane_panel(&difference, &change, ranges, per_px_m),
        change.bar(),
        plane_panel(&ratio, &times, ranges, per_px_m),
        times.bar(),
    ];
    let legend: Vec<LegendEntry> = point_legend([&difference].into_iter());
    let alone = [&input.before, &input.after].map(|map| map.bins.filled().count() - pairs.len());
    Figure {
        columns: 4,
        panel_px: [width_px, ALONE_PX],
        column_widths_px: vec![width_px, BAR_PX, width_px, BAR_PX],
        panels,
        legend,
        ..Figure::new(
            input.title.clone(),
            joined([
                (!input.about.is_empty()).then(|| input.about.clone()),
                Some(format!(
                    "Blue: less, orange: more, white: the same. Means over squares of {}\u{a0}mm; the scale of the ratio is logarithmic.",
                    signed(1e3 * side_m, 1)
                )),
                if_any(
                    alone[0] + alone[1],
                    format!(
                        "{} squares have poses of one mechanism only and are not drawn.",
                        alone[0] + alone[1]
                    ),
                ),
            ]),
        )
    }
}

/// Place and both means of the squares that have both.
fn pairs(before: &PlaneBins, after: &PlaneBins) -> Vec<([f64; 2], f64, f64)> {
    let side = after.side_m();
    let key = |centre: [f64; 2]| centre.map(|c| (c / side).floor() as i64);
    let known: std::collections::BTreeMap<[i64; 2], f64> = before
        .filled()
        .map(|bin| (key(bin.centre_m), bin.mean))
        .collect();
    let bins = after.filled();
    bins.filter_map(|bin| Some((bin.centre_m, *known.get(&key(bin.centre_m))?, bin.mean)))
        .collect()
}
