//! A quantity over the plane of the arm from straight above: coloured squares, lines of equal value, named points.

use super::colour_scale::ColourScale;
use super::contour::Grid;
use super::figure::{
    Axis, FigureNote, FigurePoint, LegendEntry, LegendMark, Marks, NotePlacement, Panel, Polygon,
    Style,
};
use super::font;
use super::palette::{Colour, Marker};
use super::plane_bins::PlaneBins;
use super::ticks::Tick;

/// Size of the numbers on lines, px.
const LEVEL_PX: f64 = 10.0;
/// Size of the names of points, px.
const NAME_PX: f64 = 11.0;
/// Room beside and above the map, as shares of its larger extent: names stand there.
const ROOM: [f64; 2] = [0.115, 0.075];
/// Levels that are wanted.
const LEVELS: usize = 10;
/// A line shorter than this many times its number stays without it.
const SHORTEST: f64 = 1.6;
/// A line shorter than this many squares is a speck that the steps of the border left.
const SPECK: f64 = 2.0;

/// A named point of a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPoint {
    /// Name.
    pub name: String,
    /// Coordinate across, m.
    pub across_m: f64,
    /// Coordinate upward, m.
    pub up_m: f64,
}

/// A quantity over two coordinates of the end.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneMap {
    /// For example `mechanism F`.
    pub heading: String,
    /// Names of the two coordinates, for example `z, radial` and `y, vertical`.
    pub axes: [String; 2],
    /// Values in the unit that is printed, over the plane.
    pub bins: PlaneBins,
    /// Outermost points of the workspace: highest, furthest, lowest, nearest.
    pub extremes: Vec<NamedPoint>,
    /// Where a single pose has the least and the greatest value; `None` where there is no pose.
    pub least: Option<ValueAt>,
    /// See `least`.
    pub greatest: Option<ValueAt>,
}

/// A value at a place of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueAt {
    /// Place in the plane, m.
    pub at_m: [f64; 2],
    /// The value in the unit that is printed.
    pub value: f64,
}

impl PlaneMap {
    /// Means of all bins.
    pub(super) fn means(&self) -> impl Iterator<Item = f64> + '_ {
        self.bins.filled().map(|bin| bin.value)
    }
}

/// Ranges of z and y that hold all maps and their points.
pub(super) fn extent<'a>(maps: impl Iterator<Item = &'a PlaneMap>) -> [[f64; 2]; 2] {
    let mut ranges: Option<[[f64; 2]; 2]> = None;
    for map in maps {
        let half = 0.5 * map.bins.side_m();
        let bins = map.bins.filled();
        let corners = bins.flat_map(|bin| [-half, half].map(|d| bin.centre_m.map(|c| c + d)));
        let named = map
            .extremes
            .iter()
            .map(|point| [point.across_m, point.up_m]);
        let all = corners.chain(named);
        for [z, y] in all.filter(|at| at.iter().all(|c| c.is_finite())) {
            let known = ranges.unwrap_or([[z, z], [y, y]]);
            ranges = Some([
                [known[0][0].min(z), known[0][1].max(z)],
                [known[1][0].min(y), known[1][1].max(y)],
            ]);
        }
    }
    ranges.unwrap_or([[0.0, 1.0]; 2])
}

/// Ranges of z and y with room for names, from edge to edge of squares.
pub(super) fn with_room(extent: [[f64; 2]; 2], side_m: f64) -> [[f64; 2]; 2] {
    let larger = extent
        .map(|[low, high]| high - low)
        .into_iter()
        .fold(0.0, f64::max);
    let edge_below = |value: f64| (value / side_m).floor() * side_m;
    [0, 1].map(|i| {
        let room = ROOM[i] * larger;
        [
            edge_below(extent[i][0] - room),
            -edge_below(-extent[i][1] - room),
        ]
    })
}

/// The panel; `per_px_m` is how many metres a pixel of it spans.
pub(super) fn plane_panel(
    map: &PlaneMap,
    scale: &ColourScale,
    [z, y]: [[f64; 2]; 2],
    per_px_m: f64,
) -> Panel {
    let axis = |quantity, range| Axis {
        range: Some(range),
        grid: false,
        ..Axis::linear(quantity, "m")
    };
    let mut panel = Panel::new(
        map.heading.clone(),
        axis(&map.axes[0], z),
        axis(&map.axes[1], y),
    );
    panel.equal_aspect = true;
    panel.draw(
        Style::new(Colour::INK, Marker::Square),
        Marks::Polygons(runs_of_squares(&map.bins, scale)),
    );
    push_contours(&mut panel, map, scale, per_px_m);
    push_points(&mut panel, map);
    panel
}

/// Squares, gaps filled; neighbours in a row whose colour is the same are one area, which keeps files small.
///
/// Their edges stand on whole pixels (see [`super::plane_map`]), so that no light seams are left between them.
fn runs_of_squares(bins: &PlaneBins, scale: &ColourScale) -> Vec<Polygon> {
    let half = 0.5 * bins.side_m();
    let mut runs: Vec<([usize; 2], Polygon)> = Vec::new();
    for (place, value) in bins.drawn() {
        let centre_m = bins.centre_m(place);
        let colour = scale.colour(value);
        if let Some((last, polygon)) = runs.last_mut()
            && *last == [place[0].wrapping_sub(1), place[1]]
            && polygon.colour == colour
        {
            *last = place;
            for corner in &mut polygon.corners[1..3] {
                corner[0] = centre_m[0] + half;
            }
            continue;
        }
        runs.push((place, Polygon::square(centre_m, half, colour)));
    }
    runs.into_iter().map(|(_, polygon)| polygon).collect()
}

/// The smooth estimates at the centres of the bins.
pub(super) fn smooth_grid(bins: &PlaneBins) -> Grid {
    let [columns, rows] = bins.size();
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    Grid {
        size: bins.size(),
        values: places.map(|place| bins.smooth(place)).collect(),
    }
}

fn push_contours(panel: &mut Panel, map: &PlaneMap, scale: &ColourScale, per_px_m: f64) {
    // Numbers keep clear of one another, of the points, and of other lines.
    let mut taken: Vec<[f64; 2]> = map.extremes.iter().map(|p| [p.across_m, p.up_m]).collect();
    taken.extend(
        [map.least, map.greatest]
            .into_iter()
            .flatten()
            .map(|at| at.at_m),
    );
    let lines = contour_lines(map, scale);
    for (index, (level, line)) in lines.iter().enumerate() {
        let ink = scale.colour(level.value).readable_ink();
        let style = Style::line(ink, 0.9);
        let half_px = [
            0.5 * font::width_px(&level.text, LEVEL_PX) + 3.0,
            0.5 * LEVEL_PX + 2.0,
        ];
        let half_m = half_px.map(|px| px * per_px_m);
        let others = lines
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index);
        let is_clear = |at: [f64; 2]| {
            let in_box = |point: &[f64; 2]| is_in_box(point, at, half_m);
            is_free(map, &taken, at, half_m)
                && !others.clone().any(|(_, (_, line))| line.iter().any(in_box))
        };
        let spot = (length(line) > 2.0 * SHORTEST * half_m[0])
            .then(|| label_spot(line, half_m, is_clear))
            .flatten();
        let Some(spot) = spot else {
            let marks = Marks::Line(line.clone());
            panel.draw(style, marks);
            continue;
        };
        taken.push(spot);
        for piece in without_box(line, spot, half_m) {
            panel.draw(style, Marks::Line(piece));
        }
        panel.notes.push(number_on_line(level, spot, ink));
    }
}

/// Lines of equal value with their levels, m, without specks.
fn contour_lines(map: &PlaneMap, scale: &ColourScale) -> Vec<(Tick, Vec<[f64; 2]>)> {
    let grid = smooth_grid(&map.bins);
    let side = map.bins.side_m();
    let origin = map.bins.centre_m([0, 0]);
    let place = |at: [f64; 2]| [0, 1].map(|i| origin[i] + side * at[i]);
    let mut lines = Vec::new();
    for level in scale.levels(LEVELS) {
        for line in grid.contours(level.value) {
            let line: Vec<[f64; 2]> = line.into_iter().map(place).collect();
            if length(&line) >= SPECK * side {
                lines.push((level.clone(), line));
            }
        }
    }
    lines
}

fn number_on_line(level: &Tick, at: [f64; 2], colour: Colour) -> FigureNote {
    FigureNote {
        colour,
        ..FigureNote::new(at, level.text.clone(), LEVEL_PX, NotePlacement::Centred)
    }
}

fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|p| distance(p[0], p[1])).sum()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The corner of a line nearest to its middle where its number may stand; `None` if there is none.
fn label_spot(
    line: &[[f64; 2]],
    half_m: [f64; 2],
    is_free: impl Fn([f64; 2]) -> bool,
) -> Option<[f64; 2]> {
    let half = 0.5 * length(line);
    let mut gone = 0.0;
    let mut best: Option<(f64, [f64; 2])> = None;
    for (index, &at) in line.iter().enumerate() {
        if index > 0 {
            gone += distance(line[index - 1], at);
        }
        let off = (gone - half).abs();
        // Numbers at the ends of a line would leave nothing of it.
        let is_inside = half - off > 0.8 * half_m[0];
        if is_inside && best.is_none_or(|(least, _)| off < least) && is_free(at) {
            best = Some((off, at));
        }
    }
    best.map(|(_, at)| at)
}

/// Whether a number at a place stands on the map with all corners, and clear of others.
fn is_free(map: &PlaneMap, taken: &[[f64; 2]], at: [f64; 2], half_m: [f64; 2]) -> bool {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let on_map = |side: [f64; 2]| map.bins.holds([0, 1].map(|i| at[i] + side[i] * half_m[i]));
    corners.into_iter().all(on_map)
        && taken
            .iter()
            .all(|other| distance(*other, at) > 2.2 * half_m[0])
}

fn is_in_box(at: &[f64; 2], centre: [f64; 2], half_m: [f64; 2]) -> bool {
    (0..2).all(|i| (at[i] - centre[i]).abs() < half_m[i])
}

/// What of a line lies outside a rectangle, as pieces.
fn without_box(line: &[[f64; 2]], centre: [f64; 2], half_m: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    line.split(|at| is_in_box(at, centre, half_m))
        .filter(|piece| piece.len() > 1)
        .map(<[_]>::to_vec)
        .collect()
}

/// Looks of the outermost points, of the least and of the greatest value: outlines, which are seen on every colour.
pub(super) const POINT_STYLES: [Style; 3] = [
    outline(Marker::Circle, 3.4),
    outline(Marker::Nabla, 5.0),
    outline(Marker::Triangle, 5.0),
];

const fn outline(marker: Marker, marker_px: f64) -> Style {
    Style {
        colour: Colour::BLACK,
        marker,
        marker_px,
        stroke_px: 1.4,
        dash_px: None,
    }
}

/// The legend of the points.
pub(super) fn point_legend(maps: &[PlaneMap]) -> Vec<LegendEntry> {
    let entry = |place: usize, label: &str| {
        LegendEntry::new(label, POINT_STYLES[place], LegendMark::HollowPoint)
    };
    let mut legend = Vec::new();
    if maps.iter().any(|map| !map.extremes.is_empty()) {
        legend.push(entry(0, "outermost point"));
    }
    if maps.iter().any(|map| map.least.is_some()) {
        legend.push(entry(1, "least of all poses"));
    }
    if maps.iter().any(|map| map.greatest.is_some()) {
        legend.push(entry(2, "greatest of all poses"));
    }
    legend
}

fn push_points(panel: &mut Panel, map: &PlaneMap) {
    let hollow = |[z, y]: [f64; 2]| FigurePoint::new(z, y).hollow(true);
    let at = |value: Option<ValueAt>| value.map(|at| hollow(at.at_m)).into_iter().collect();
    let outermost = map
        .extremes
        .iter()
        .map(|point| hollow([point.across_m, point.up_m]));
    // The smaller circle last, so that both are seen where they coincide.
    let points: [(usize, Vec<FigurePoint>); 3] = [
        (1, at(map.least)),
        (2, at(map.greatest)),
        (0, outermost.collect()),
    ];
    for (look, points) in points {
        panel.draw(POINT_STYLES[look], Marks::Points(points));
    }
    let count = map.extremes.len().max(1) as f64;
    let [z, y] = [
        map.extremes.iter().map(|p| p.across_m).sum::<f64>() / count,
        map.extremes.iter().map(|p| p.up_m).sum::<f64>() / count,
    ];
    for point in &map.extremes {
        panel.notes.push(FigureNote::new(
            [point.across_m, point.up_m],
            point.name.clone(),
            NAME_PX,
            NotePlacement::Toward(outward(point.across_m - z, point.up_m - y)),
        ));
    }
}

/// The side on which a name stands: that of the four along which its point lies farther out.
fn outward(right: f64, up: f64) -> [f64; 2] {
    if right.abs() > up.abs() {
        [right.signum(), 0.0]
    } else {
        [0.0, up.signum()]
    }
}
