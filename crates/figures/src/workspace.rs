//! Projection of the workspace on the vertical plane of the arm (the paper's Fig. 3).

use std::collections::BTreeMap;

use super::caption::{if_any, joined};
use super::figure::{
    Axis, Figure, FigureNote, FigurePoint, LegendEntry, LegendMark, Marks, NotePlacement, Panel,
    Polygon, Series, Style,
};
use super::font;
use super::palette::{Colour, Marker, qualitative, sequential};

/// Up to this many points are drawn one by one; more become a density, which also keeps the file small.
const SINGLE_POINTS: usize = 3000;
/// Width of a density cell, px.
const CELL_PX: f64 = 6.0;
/// Size of the names of points, and room between a name and both its point and the border, px.
const NAME_PX: f64 = 12.0;
const NAME_GAP_PX: f64 = 16.0;
/// Least and largest side of the plot area, px.
const SIDE_PX: [f64; 2] = [260.0, 560.0];

/// What the figure shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorkspaceProjection {
    /// End points of random poses, (z, y), m.
    pub points_z_y_m: Vec<[f64; 2]>,
    /// Extreme points of these: highest, farthest, lowest, nearest.
    pub extremes: Vec<NamedPoint>,
    /// The same as a publication states them; empty for none.
    pub stated: Vec<NamedPoint>,
    /// Whose statement that is, for the legend.
    pub stated_by: String,
    /// Names of the two coordinates, for example `z, radial` and `y, vertical`.
    pub axes: [String; 2],
}

/// A named point of the projection.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPoint {
    /// Name.
    pub name: String,
    /// Coordinate across, m.
    pub across_m: f64,
    /// Coordinate upward, m.
    pub up_m: f64,
}

/// The figure: both axes to one scale.
#[must_use]
pub fn workspace(input: &WorkspaceProjection) -> Figure {
    let finite: Vec<[f64; 2]> = input
        .points_z_y_m
        .iter()
        .copied()
        .filter(|point| point.iter().all(|c| c.is_finite()))
        .collect();
    let [z, y] = [0, 1].map(|axis| span(input, &finite, axis));
    let larger = (z[1] - z[0]).max(y[1] - y[0]);
    let z = with_names(input, &finite, z, larger / SIDE_PX[1]);
    let [wide, high] = [z[1] - z[0], y[1] - y[0]];
    let per_px = wide.max(high) / SIDE_PX[1];
    let panel_px = [wide, high].map(|span| (span / per_px).max(SIDE_PX[0]));
    let mut panel = Panel::new(
        "",
        Axis {
            range: Some(z),
            ..Axis::linear(&input.axes[0], "m")
        },
        Axis {
            range: Some(y),
            ..Axis::linear(&input.axes[1], "m")
        },
    );
    panel.equal_aspect = true;
    let mut legend = Vec::new();
    if finite.len() <= SINGLE_POINTS {
        let points = finite
            .iter()
            .map(|[z, y]| FigurePoint::new(*z, *y))
            .collect();
        let style = Style::new(sequential(0.6), Marker::Dot).marker_size(2.4);
        panel.series.push(Series::labelled(
            "end point of a pose",
            style,
            Marks::Points(points),
        ));
    } else {
        let (polygons, classes) = density(&finite, CELL_PX * per_px);
        legend = classes;
        panel.series.push(Series::new(
            Style::new(sequential(0.6), Marker::Dot),
            Marks::Polygons(polygons),
        ));
    }
    push_named(&mut panel, input, &finite);
    let left_out = input.points_z_y_m.len() - finite.len();
    Figure {
        panel_px,
        panels: vec![panel],
        legend,
        ..Figure::new(
            "Workspace in the plane of the arm",
            caption(finite.len(), left_out),
        )
    }
}

fn caption(drawn: usize, left_out: usize) -> String {
    let shaded = drawn > SINGLE_POINTS;
    joined([
        Some(format!(
            "End points of n\u{a0}=\u{a0}{drawn} random poses within the limits."
        )),
        shaded.then(|| {
            "Shade: number of poses in a hexagon; every hexagon with at least one pose is drawn.".to_owned()
        }),
        if_any(
            left_out,
            format!("{left_out} points without a finite coordinate are not drawn."),
        ),
    ])
}

/// Range along one coordinate with room for labels.
fn span(input: &WorkspaceProjection, finite: &[[f64; 2]], axis: usize) -> [f64; 2] {
    let named = input
        .extremes
        .iter()
        .chain(&input.stated)
        .map(|point| [point.across_m, point.up_m]);
    let ends = finite
        .iter()
        .copied()
        .chain(named)
        .map(|point| point[axis])
        .filter(|value| value.is_finite())
        .fold(None, |ends: Option<[f64; 2]>, value| {
            let [low, high] = ends.unwrap_or([value, value]);
            Some([low.min(value), high.max(value)])
        });
    let [low, high] = ends.unwrap_or([0.0, 1.0]);
    let room = (0.08 * (high - low)).max(0.01);
    [low - room, high + room]
}

/// The range of z, wider where names beside the cloud would cross the border.
fn with_names(
    input: &WorkspaceProjection,
    finite: &[[f64; 2]],
    [mut low, mut high]: [f64; 2],
    per_px_m: f64,
) -> [f64; 2] {
    let centre = centre(finite);
    for point in named(input) {
        let [out, up] = [point.across_m - centre[0], point.up_m - centre[1]];
        // As far as the name stands beside its point rather than above or below it.
        let share = out.abs() / out.hypot(up).max(f64::MIN_POSITIVE);
        let width_px = 0.5 * (1.0 + share) * font::width_px(&point.name, NAME_PX);
        let reach_m = (width_px + NAME_GAP_PX) * per_px_m;
        if out < 0.0 {
            low = low.min(point.across_m - reach_m);
        } else {
            high = high.max(point.across_m + reach_m);
        }
    }
    [low, high]
}

fn centre(finite: &[[f64; 2]]) -> [f64; 2] {
    let count = finite.len().max(1) as f64;
    [0, 1].map(|axis| finite.iter().map(|p| p[axis]).sum::<f64>() / count)
}

/// The points whose names are written: a stated point without a name among the extremes too.
fn named(input: &WorkspaceProjection) -> impl Iterator<Item = &NamedPoint> {
    let others = input
        .stated
        .iter()
        .filter(|stated| input.extremes.iter().all(|own| own.name != stated.name));
    input.extremes.iter().chain(others)
}

fn push_named(panel: &mut Panel, input: &WorkspaceProjection, finite: &[[f64; 2]]) {
    let centre = centre(finite);
    let marked = |points: &[NamedPoint]| {
        Marks::Points(
            points
                .iter()
                .map(|p| FigurePoint::new(p.across_m, p.up_m))
                .collect(),
        )
    };
    panel.push(Series::labelled(
        input.stated_by.clone(),
        Style::new(qualitative(1), Marker::Square).marker_size(6.5),
        marked(&input.stated),
    ));
    panel.push(Series::labelled(
        "extreme point",
        Style::new(Colour::BLACK, Marker::Circle),
        marked(&input.extremes),
    ));
    // Names stand outside the cloud.
    for point in named(input) {
        panel.notes.push(FigureNote {
            at: [point.across_m, point.up_m],
            text: point.name.clone(),
            colour: Colour::INK,
            size_px: NAME_PX,
            placement: NotePlacement::Toward([point.across_m - centre[0], point.up_m - centre[1]]),
        });
    }
}

/// Hexagons shaded by the number of points in them, and the legend of the shades.
///
/// Each class ends at a quarter of the one above it: the evenly filled inside is one shade in spite of its random counts, thin
/// borders are another.
fn density(points: &[[f64; 2]], width_m: f64) -> (Vec<Polygon>, Vec<LegendEntry>) {
    let mut counts: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    for point in points {
        *counts.entry(hexagon_of(*point, width_m)).or_default() += 1;
    }
    let most = counts.values().copied().max().unwrap_or(1);
    // Largest count of each class, from the darkest down to one.
    let tops: Vec<usize> = std::iter::successors(Some(most), |top| Some(top / 4))
        .take_while(|top| *top > 0)
        .collect();
    let shade = |class: usize| sequential(0.85 - 0.8 * class as f64 / tops.len() as f64);
    let polygons = counts
        .iter()
        .map(|(place, count)| Polygon {
            corners: hexagon(*place, width_m),
            colour: shade(tops.iter().filter(|top| *top >= count).count() - 1),
        })
        .collect();
    let legend = tops
        .iter()
        .enumerate()
        .rev()
        .map(|(class, &high)| LegendEntry {
            label: poses_between(tops.get(class + 1).map_or(1, |below| below + 1), high),
            style: Style::new(shade(class), Marker::Square),
            sample: LegendMark::Area,
        })
        .collect();
    (polygons, legend)
}

fn poses_between(low: usize, high: usize) -> String {
    match (low, high) {
        (_, 1) => "1 pose".to_owned(),
        (low, high) if low == high => format!("{low} poses"),
        (low, high) => format!("{low} to {high} poses"),
    }
}

/// Row spacing of hexagons of unit width, standing on a corner.
const ROW: f64 = 0.866_025_403_784_438_6;

/// The hexagon whose centre is nearest; ties go to the even row.
fn hexagon_of([z, y]: [f64; 2], width_m: f64) -> (i64, i64) {
    let row_near = (y / (ROW * width_m)).floor() as i64;
    let candidates = [row_near, row_near + 1].map(|row| {
        let shift = 0.5 * row.rem_euclid(2) as f64;
        let column = (z / width_m - shift).round();
        let centre = [(column + shift) * width_m, row as f64 * ROW * width_m];
        ((row, column as i64), (z - centre[0]).hypot(y - centre[1]))
    });
    if candidates[1].1 < candidates[0].1 {
        candidates[1].0
    } else {
        candidates[0].0
    }
}

fn hexagon((row, column): (i64, i64), width_m: f64) -> Vec<[f64; 2]> {
    let shift = 0.5 * row.rem_euclid(2) as f64;
    let centre = [
        (column as f64 + shift) * width_m,
        row as f64 * ROW * width_m,
    ];
    // A little larger than the cell: neighbours overlap and no light seam is left between them.
    let radius = 1.04 * width_m / 3f64.sqrt();
    (0..6)
        .map(|corner| {
            let (sin, cos) = (f64::from(corner) * 60.0 + 30.0).to_radians().sin_cos();
            [centre[0] + radius * cos, centre[1] + radius * sin]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;

    fn grid(side: usize) -> Vec<[f64; 2]> {
        (0..side * side)
            .map(|i| {
                [
                    1.0 + 0.7 * (i % side) as f64 / side as f64,
                    0.4 + 0.8 * (i / side) as f64 / side as f64,
                ]
            })
            .collect()
    }

    #[test]
    fn every_point_is_counted_in_one_hexagon() {
        let points = grid(80);
        let mut counts = BTreeMap::new();
        for point in &points {
            let place = hexagon_of(*point, 0.03);
            *counts.entry(place).or_insert(0) += 1;
            let corners = hexagon(place, 0.03);
            let centre = [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / 6.0);
            let distance = (point[0] - centre[0]).hypot(point[1] - centre[1]);
            assert!(distance <= 0.03 / 3f64.sqrt() + 1e-12, "{distance}");
        }
        assert_eq!(counts.values().sum::<usize>(), points.len());
        assert_eq!(density(&points, 0.03).0.len(), counts.len());
    }

    #[test]
    fn classes_of_the_density_meet_without_gap_or_overlap() {
        // One cell with 73 points, one with one: classes end at 73, 18, 4 and 1.
        let mut points = vec![[0.0, 0.0]; 73];
        points.push([5.0, 0.0]);
        let (polygons, legend) = density(&points, 1.0);
        let labels: Vec<&str> = legend.iter().map(|entry| entry.label.as_str()).collect();
        assert_eq!(
            labels,
            ["1 pose", "2 to 4 poses", "5 to 18 poses", "19 to 73 poses"]
        );
        assert_eq!(polygons[0].colour, legend[3].style.colour);
        assert_eq!(polygons[1].colour, legend[0].style.colour);
    }

    #[test]
    fn thirty_thousand_points_stay_a_small_file() {
        let input = WorkspaceProjection {
            points_z_y_m: grid(174),
            ..WorkspaceProjection::default()
        };
        let svg = workspace(&input).to_svg();
        assert!(svg.len() < 1_500_000, "{} bytes", svg.len());
        assert!(svg.contains("30276"));
        parse(&svg).unwrap();
    }

    #[test]
    fn named_points_are_labelled_once() {
        let named = |name: &str, across_m, up_m| NamedPoint {
            name: name.to_owned(),
            across_m,
            up_m,
        };
        let figure = workspace(&WorkspaceProjection {
            points_z_y_m: vec![[1.0, 1.0], [1.2, f64::NAN]],
            extremes: vec![named("P1", 1.638, 1.229)],
            stated: vec![named("P1", 1.64, 1.23), named("P2", 1.7, 0.9)],
            stated_by: "as published".to_owned(),
            axes: ["z", "y"].map(str::to_owned),
        });
        let names: Vec<&str> = figure.panels[0]
            .notes
            .iter()
            .map(|note| note.text.as_str())
            .collect();
        assert_eq!(names, ["P1", "P2"]);
        assert!(
            figure
                .caption
                .contains("1 points without a finite coordinate")
        );
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn nothing_to_show_is_still_a_figure() {
        parse(&workspace(&WorkspaceProjection::default()).to_svg()).unwrap();
    }
}
