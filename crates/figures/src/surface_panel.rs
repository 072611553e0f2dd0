//! A quantity over the plane of the arm as a surface in space.
//!
//! Decision. The view is a parallel projection, and the surface has one value over each place of the plane. Its facets then hide one
//! another in the order of their places alone: drawn from the farthest row to the nearest, what is hidden is covered, exactly. A facet
//! is drawn twice, first whole in the colour of the mesh, then a little smaller in the colour of its value: so the mesh is hidden with
//! its facet, and no seams are left.

use super::colour_scale::ColourScale;
use super::contour::Grid;
use super::figure::{Axis, FigureNote, FigurePoint, Marks, NotePlacement, Panel, Polygon, Style};
use super::font;
use super::palette::{Colour, Marker};
use super::plane_bins::PlaneBins;
use super::plane_panel::{POINT_STYLES, PlaneMap, smooth_grid};
use super::range::spread;
use super::ticks::{Tick, ticks};

/// Plot area, px.
pub(super) const SURFACE_PX: [f64; 2] = [430.0, 400.0];
/// Turn of the view about the upright, and how far it looks down.
const TURN_DEG: f64 = 36.0;
const DOWN_DEG: f64 = 27.0;
/// Length of the floor along z and along y, and height, px before projection.
const BOX_PX: [f64; 3] = [235.0, 270.0, 185.0];
/// Part of a facet that is not mesh.
const FACET: f64 = 0.9;
/// Most facets along a side.
const MOST_FACETS: usize = 60;
/// Sizes of texts, px.
const TICK_PX: f64 = 10.0;
const NAME_PX: f64 = 11.0;
/// What a name may take of the margin to the left of the panel, px.
const MARGIN_PX: f64 = 12.0;

/// The view: from shares of the three ranges to places in the panel, px.
#[derive(Debug, Clone, Copy)]
struct SurfaceView {
    z: [f64; 2],
    y: [f64; 2],
    values: [f64; 2],
}

impl SurfaceView {
    /// Place of a point given by shares of the ranges.
    fn project([z, y, value]: [f64; 3]) -> [f64; 2] {
        let (sin, cos) = TURN_DEG.to_radians().sin_cos();
        let (sin_down, cos_down) = DOWN_DEG.to_radians().sin_cos();
        let [across, deep] = [(z - 0.5) * BOX_PX[0], (y - 0.5) * BOX_PX[1]];
        let depth = cos * deep - sin * across;
        [
            0.51 * SURFACE_PX[0] + cos * across + sin * deep,
            0.5 * SURFACE_PX[1] + sin_down * depth + cos_down * (value - 0.5) * BOX_PX[2],
        ]
    }

    fn shares(&self, [z, y]: [f64; 2]) -> [f64; 2] {
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        [share(z, self.z), share(y, self.y)]
    }
}

/// The panel.
pub(super) fn surface_panel(
    map: &PlaneMap,
    scale: &ColourScale,
    [z, y]: [[f64; 2]; 2],
    height_px: f64,
) -> Panel {
    let view = SurfaceView {
        z,
        y,
        values: scale.range,
    };
    let px = |middle: f64, length: f64| {
        Axis::categories("", Vec::new()).within([middle - 0.5 * length, middle + 0.5 * length])
    };
    let [width, height] = SURFACE_PX;
    let mut panel = Panel::new("", px(0.5 * width, width), px(0.5 * height, height_px));
    panel.bordered = false;
    push_walls(&mut panel, map, &view, scale);
    panel.draw(
        Style::new(Colour::INK, Marker::Square),
        Marks::Polygons(facets(&map.bins, &view, scale)),
    );
    push_points(&mut panel, map, &view, scale);
    panel
}

/// Facets between the centres of bins, the farthest first.
fn facets(bins: &PlaneBins, view: &SurfaceView, scale: &ColourScale) -> Vec<Polygon> {
    let grid = smooth_grid(bins);
    let [columns, rows] = grid.size;
    let [across, deep] = grid.size.map(|n| n.div_ceil(MOST_FACETS).max(1));
    let mut drawn = Vec::new();
    // Farthest are the greatest y, and among them the least z.
    for row in (0..rows).step_by(deep).rev() {
        for column in (0..columns).step_by(across) {
            let place = |[dz, dy]: [usize; 2]| [column + across * dz, row + deep * dy];
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(place);
            push_facet(&mut drawn, bins, &grid, view, scale, corners);
        }
    }
    drawn
}

fn push_facet(
    drawn: &mut Vec<Polygon>,
    bins: &PlaneBins,
    grid: &Grid,
    view: &SurfaceView,
    scale: &ColourScale,
    corners: [[usize; 2]; 4],
) {
    let known: Vec<([f64; 2], f64)> = corners
        .into_iter()
        .filter(|at| at[0] < grid.size[0] && at[1] < grid.size[1])
        .filter_map(|at| {
            Some((
                bins.centre_m(at),
                grid.values[at[1] * grid.size[0] + at[0]]?,
            ))
        })
        .collect();
    if known.len() < 3 {
        return;
    }
    let mean = known.iter().map(|(_, value)| value).sum::<f64>() / known.len() as f64;
    let corners: Vec<[f64; 2]> = known
        .iter()
        .map(|(at, value)| {
            let [z, y] = view.shares(*at);
            SurfaceView::project([z, y, scale.share(*value).clamp(0.0, 1.0)])
        })
        .collect();
    let colour = scale.colour(mean);
    let count = corners.len() as f64;
    let middle = [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / count);
    let inner = corners
        .iter()
        .map(|c| [0, 1].map(|i| middle[i] + FACET * (c[i] - middle[i])))
        .collect();
    drawn.push(Polygon {
        corners,
        colour: mesh(colour),
    });
    drawn.push(Polygon {
        corners: inner,
        colour,
    });
}

/// The same colour, darker.
fn mesh(colour: Colour) -> Colour {
    Colour {
        rgb: colour.rgb.map(|c| (0.6 * f64::from(c)) as u8),
        ..colour
    }
}

/// Floor and the two walls behind the surface with their grids, and the three axes with ticks and names.
fn push_walls(panel: &mut Panel, map: &PlaneMap, view: &SurfaceView, scale: &ColourScale) {
    let thin = Style::line(Colour::FAINT, 0.8);
    let axis = Style::line(Colour::GREY, 1.0);
    let even = |range| ticks(&super::figure::AxisScale::Linear, range, 5);
    let share = |tick: &Tick, [low, high]: [f64; 2]| (tick.value - low) / (high - low);
    let mut grid: Vec<[[f64; 3]; 2]> = Vec::new();
    for tick in even(view.z) {
        let z = share(&tick, view.z);
        grid.extend([
            [[z, 0.0, 0.0], [z, 1.0, 0.0]],
            [[z, 1.0, 0.0], [z, 1.0, 1.0]],
        ]);
        push_tick(panel, &tick, [z, 0.0, 0.0], [-0.2, -1.0]);
    }
    for tick in even(view.y) {
        let y = share(&tick, view.y);
        grid.extend([
            [[0.0, y, 0.0], [1.0, y, 0.0]],
            [[0.0, y, 0.0], [0.0, y, 1.0]],
        ]);
        push_tick(panel, &tick, [1.0, y, 0.0], [1.0, -0.4]);
    }
    for tick in ticks(&scale.axis.scale, view.values, 6) {
        if spread(&scale.axis.scale, tick.value).is_none() || tick.text.is_empty() {
            continue;
        }
        let value = scale.share(tick.value);
        grid.extend([
            [[0.0, 0.0, value], [0.0, 1.0, value]],
            [[0.0, 1.0, value], [1.0, 1.0, value]],
        ]);
        push_tick(panel, &tick, [0.0, 0.0, value], [-1.0, 0.0]);
    }
    grid.extend([
        [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        [[0.0, 1.0, 1.0], [1.0, 1.0, 1.0]],
    ]);
    let flat = |lines: &[[[f64; 3]; 2]]| {
        Marks::Segments(
            lines
                .iter()
                .map(|line| line.map(SurfaceView::project))
                .collect(),
        )
    };
    panel.draw(thin, flat(&grid));
    let edges = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    ];
    panel.draw(axis, flat(&edges));
    let [across, deep] = map.axes.each_ref().map(|name| format!("{name} (m)"));
    push_name(panel, &across, [0.5, 0.0, 0.0], [-30.0, -32.0]);
    push_name(panel, &deep, [1.0, 0.5, 0.0], [44.0, -30.0]);
    push_value_name(panel, &scale.axis.label);
}

/// The name of the upright axis above it; in two lines, the unit below, where one would leave the panel.
fn push_value_name(panel: &mut Panel, label: &str) {
    let [x, _] = SurfaceView::project([0.0, 0.0, 1.0]);
    let [dx, dy] = [14.0, 22.0];
    let room = |dx: f64| x + dx + MARGIN_PX;
    let fits = 0.5 * font::width_px(label, NAME_PX) <= room(dx);
    let lines: Vec<&str> = match label.rfind(" (") {
        Some(at) if !fits => vec![&label[at + 1..], &label[..at]],
        _ => vec![label],
    };
    for (index, line) in lines.into_iter().enumerate() {
        // Still wider ones move to the right until they fit.
        let dx = dx.max(0.5 * font::width_px(line, NAME_PX) - room(0.0));
        let dy = dy + 1.3 * NAME_PX * index as f64;
        push_name(panel, line, [0.0, 0.0, 1.0], [dx, dy]);
    }
}

fn push_tick(panel: &mut Panel, tick: &Tick, at: [f64; 3], toward: [f64; 2]) {
    panel.notes.push(FigureNote::new(
        SurfaceView::project(at),
        tick.text.clone(),
        TICK_PX,
        NotePlacement::Toward(toward),
    ));
}

fn push_name(panel: &mut Panel, text: &str, at: [f64; 3], by_px: [f64; 2]) {
    let [x, y] = SurfaceView::project(at);
    panel.notes.push(FigureNote::new(
        [x + by_px[0], y + by_px[1]],
        text.to_owned(),
        NAME_PX,
        NotePlacement::Centred,
    ));
}

/// The outermost points on the surface with their names, each with a line down to the floor.
fn push_points(panel: &mut Panel, map: &PlaneMap, view: &SurfaceView, scale: &ColourScale) {
    let mut drops = Vec::new();
    let mut points = Vec::new();
    for point in &map.extremes {
        let Some(value) = nearest_value(&map.bins, [point.across_m, point.up_m]) else {
            continue;
        };
        let [z, y] = view.shares([point.across_m, point.up_m]);
        let top = SurfaceView::project([z, y, scale.share(value)]);
        drops.push([SurfaceView::project([z, y, 0.0]), top]);
        points.push(FigurePoint::new(top[0], top[1]).hollow(true));
        panel.notes.push(FigureNote::new(
            top,
            point.name.clone(),
            NAME_PX,
            NotePlacement::Free,
        ));
    }
    let drop = Style {
        dash_px: Some([2.0, 2.0]),
        ..Style::line(Colour::INK, 0.8)
    };
    panel.draw(drop, Marks::Segments(drops));
    panel.draw(POINT_STYLES[0], Marks::Points(points));
}

/// Smooth estimate in the bin nearest to a place.
fn nearest_value(bins: &PlaneBins, [z, y]: [f64; 2]) -> Option<f64> {
    let away = |centre: [f64; 2]| (centre[0] - z).hypot(centre[1] - y);
    let nearest = bins
        .filled()
        .min_by(|a, b| away(a.centre_m).total_cmp(&away(b.centre_m)))?;
    bins.smooth(nearest.place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::notes_of;

    /// A ridge along z in the middle of y.
    fn ridge() -> PlaneBins {
        let places =
            (0..50).flat_map(|i| (0..50).map(move |j| [i, j].map(|k| 0.02 * f64::from(k) + 0.01)));
        PlaneBins::gather(
            places
                .map(|[z, y]| ([z, y], 2.0 - (2.0 * y - 1.0).abs()))
                .collect::<Vec<_>>()
                .into_iter(),
            0.02,
        )
    }

    #[test]
    fn a_facet_is_drawn_after_all_that_it_can_hide() {
        let bins = ridge();
        let scale = ColourScale::of("K", "N/mm", bins.filled().map(|bin| bin.value));
        let view = SurfaceView {
            z: [0.0, 1.0],
            y: [0.0, 1.0],
            values: scale.range,
        };
        let drawn = facets(&bins, &view, &scale);
        assert!(drawn.len() > 1000);
        // Whoever stands at the place of the last facet drawn there sees the one nearest to the viewer. Its distance grows with y and
        // falls with z, and so do the places of facets with equal value along the sheet: on the near side of the ridge, which slopes
        // down toward the viewer, nothing is hidden, and the topmost facet at the middle of each must be that facet itself.
        let whole: Vec<&Polygon> = drawn.iter().step_by(2).collect();
        let middle = |polygon: &Polygon| {
            let n = polygon.corners.len() as f64;
            [0, 1].map(|i| polygon.corners.iter().map(|c| c[i]).sum::<f64>() / n)
        };
        let near_side = whole.len() / 2 + 60..whole.len();
        for index in near_side {
            let at = middle(whole[index]);
            let top = whole.iter().rposition(|polygon| holds(polygon, at));
            assert_eq!(top, Some(index));
        }
        // The far side slopes away, steeper than the view looks down: all of it is hidden by the ridge.
        let hidden = (0..whole.len() / 2 - 60).filter(|&index| {
            let at = middle(whole[index]);
            whole.iter().rposition(|polygon| holds(polygon, at)) != Some(index)
        });
        assert!(hidden.count() > whole.len() / 5);
    }

    /// Whether a convex polygon holds a point.
    fn holds(polygon: &Polygon, at: [f64; 2]) -> bool {
        let n = polygon.corners.len();
        let sides = (0..n).map(|i| {
            let [a, b] = [polygon.corners[i], polygon.corners[(i + 1) % n]];
            (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])
        });
        let sides: Vec<f64> = sides.collect();
        sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
    }

    #[test]
    fn a_long_name_of_the_upright_axis_stays_in_the_panel() {
        let mut panel = Panel::new("", Axis::linear("", ""), Axis::linear("", ""));
        let long = "displacement of the end under a load that has a long name (um)";
        for label in [
            "stiffness along x (N/mm)",
            "weakest principal stiffness (N/mm)",
            long,
        ] {
            push_value_name(&mut panel, label);
        }
        let texts = notes_of(&panel);
        assert_eq!(texts[0], "stiffness along x (N/mm)");
        assert_eq!(texts[1..3], ["(N/mm)", "weakest principal stiffness"]);
        for note in &panel.notes {
            let left = note.at[0] - 0.5 * font::width_px(&note.text, note.size_px);
            assert!(left >= -MARGIN_PX - 1e-9, "{}: {left}", note.text);
        }
    }

    #[test]
    fn the_whole_box_fits_the_panel() {
        for corner in 0..8 {
            let at = [0, 1, 2].map(|i| f64::from(corner >> i & 1));
            let [x, y] = SurfaceView::project(at);
            assert!((40.0..SURFACE_PX[0] - 30.0).contains(&x), "{at:?}: {x}");
            assert!((30.0..SURFACE_PX[1] - 20.0).contains(&y), "{at:?}: {y}");
        }
    }
}
