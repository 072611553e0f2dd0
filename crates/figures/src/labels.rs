//! Texts at points of a panel, placed so that they cover neither points nor each other.

use super::canvas::{Align, Canvas};
use super::figure::{FigureNote, Marks, NotePlacement, Panel};
use super::font;
use super::layout::Frame;
use super::marks::clipped;
use super::palette::Colour;

/// Between a point and a text toward a given side, px: clear of a large marker.
const GAP_PX: f64 = 11.0;
/// Gaps tried for a free text, px.
const FREE_GAPS_PX: [f64; 3] = [5.0, 9.0, 14.0];
/// What a line under a free text costs, against one for every pixel that it stands farther away.
const CROSSING_COST: f64 = 20.0;
/// Sides on which a free text may stand (right, down), the best first.
const SIDES: [[f64; 2]; 8] = [
    [0.7, -0.7],
    [-0.7, -0.7],
    [0.7, 0.7],
    [-0.7, 0.7],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, -1.0],
    [0.0, 1.0],
];
/// More points than this are a cloud, which labels may cover.
const FEW_POINTS: usize = 400;

/// A rectangle on the sheet: left, top, right, bottom.
type LabelBox = [f64; 4];

/// Draws the notes of a panel: first those whose place is given, then the free ones around them.
pub(super) fn draw(canvas: &mut Canvas<'_>, panel: &Panel, frame: &Frame) {
    let mut taken = points(panel, frame);
    let (free, fixed): (Vec<&FigureNote>, Vec<&FigureNote>) = panel
        .notes
        .iter()
        .partition(|note| note.placement == NotePlacement::Free);
    let lines = lines(panel, frame);
    let areas = |marks: &Marks| matches!(marks, Marks::Polygons(_));
    let has_areas = panel.series.iter().any(|series| areas(&series.marks));
    for note in fixed {
        let Some(at) = frame.place(note.at) else {
            continue;
        };
        let side = match note.placement {
            NotePlacement::Toward([right, up]) => [right, -up],
            NotePlacement::Centred | NotePlacement::Free => [0.0, 0.0],
        };
        let spot = beside(at, note, side, GAP_PX);
        let covers = || has_areas || crossings(ground(spot), &lines) > 0;
        if note.placement != NotePlacement::Centred && covers() {
            lay_ground(canvas, spot);
        }
        write(canvas, note, spot);
        taken.push(spot);
    }
    for note in free {
        let Some(at) = frame.place(note.at) else {
            continue;
        };
        if let Some(spot) = free_spot(at, note, frame, &taken, &lines) {
            lay_ground(canvas, spot);
            write(canvas, note, spot);
            taken.push(spot);
        }
    }
}

/// The place of a free note that covers no point and no text, and as few lines as can be.
fn free_spot(
    at: [f64; 2],
    note: &FigureNote,
    frame: &Frame,
    taken: &[LabelBox],
    lines: &[[[f64; 2]; 2]],
) -> Option<LabelBox> {
    let mut best: Option<(f64, LabelBox)> = None;
    for gap_px in FREE_GAPS_PX {
        for side in SIDES {
            let spot = beside(at, note, side, gap_px);
            if !within(frame, spot) || taken.iter().any(|other| overlap(spot, *other)) {
                continue;
            }
            let cost = CROSSING_COST * crossings(spot, lines) as f64 + gap_px;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, spot));
            }
        }
    }
    best.map(|(_, spot)| spot)
}

/// How many lines run under a text.
fn crossings([left, top, right, bottom]: LabelBox, lines: &[[[f64; 2]; 2]]) -> usize {
    let area = [left, top, right - left, bottom - top];
    lines
        .iter()
        .filter(|[from, to]| clipped(area, *from, *to).is_some())
        .count()
}

/// What is paled under a text: it and the strokes that touch it.
fn ground([left, top, right, bottom]: LabelBox) -> LabelBox {
    [left - 1.0, top - 2.0, right + 1.0, bottom + 2.0]
}

/// Pales what lies under a text, so that it can be read.
fn lay_ground(canvas: &mut Canvas<'_>, spot: LabelBox) {
    let [left, top, right, bottom] = ground(spot);
    canvas.rectangle(
        [left, top, right - left, bottom - top],
        Colour::WHITE.with_opacity(0.85),
    );
}

/// Straight pieces of all lines of a panel.
fn lines(panel: &Panel, frame: &Frame) -> Vec<[[f64; 2]; 2]> {
    let [left, top, width, height] = frame.area;
    let mut pieces = Vec::new();
    let mut push = |from: [f64; 2], to: [f64; 2]| {
        if let (Some(from), Some(to)) = (frame.place(from), frame.place(to)) {
            pieces.push([from, to]);
        }
    };
    let mut across = Vec::new();
    for series in &panel.series {
        match &series.marks {
            Marks::Line(points) => {
                for pair in points.windows(2) {
                    push(pair[0], pair[1]);
                }
            }
            Marks::Segments(pairs) | Marks::Arrows(pairs) => {
                for [from, to] in pairs {
                    push(*from, *to);
                }
            }
            Marks::LevelAt(value) => {
                let level = frame.y.place(*value);
                across.extend(level.map(|y| [[left, y], [left + width, y]]));
            }
            Marks::UprightAt(value) => {
                let upright = frame.x.place(*value);
                across.extend(upright.map(|x| [[x, top], [x, top + height]]));
            }
            _ => {}
        }
    }
    pieces.extend(across);
    pieces
}

/// Boxes around the points of a panel.
fn points(panel: &Panel, frame: &Frame) -> Vec<LabelBox> {
    panel
        .series
        .iter()
        .filter_map(|series| match &series.marks {
            Marks::Points(points) if points.len() <= FEW_POINTS => {
                Some((points, series.style.marker_px))
            }
            _ => None,
        })
        .flat_map(|(points, r)| {
            points.iter().filter_map(move |point| {
                let [x, y] = frame.place([point.x, point.y])?;
                Some([x - r, y - r, x + r, y + r])
            })
        })
        .collect()
}

/// Box of a note that stands on one side of a point.
fn beside([x, y]: [f64; 2], note: &FigureNote, side: [f64; 2], gap_px: f64) -> LabelBox {
    let half_width = 0.5 * font::width_px(&note.text, note.size_px);
    let half_height = 0.5 * font::CAPITAL_HEIGHT * note.size_px;
    let length = side[0].hypot(side[1]);
    let [across, down] = if length > 0.0 {
        side.map(|c| c / length)
    } else {
        [0.0, 0.0]
    };
    let gap = if length > 0.0 { gap_px } else { 0.0 };
    let centre = [
        x + across * (gap + half_width),
        y + down * (gap + half_height),
    ];
    [
        centre[0] - half_width,
        centre[1] - half_height,
        centre[0] + half_width,
        centre[1] + half_height,
    ]
}

fn overlap(a: LabelBox, b: LabelBox) -> bool {
    a[0] < b[2] + 1.0 && b[0] < a[2] + 1.0 && a[1] < b[3] + 1.0 && b[1] < a[3] + 1.0
}

fn within(frame: &Frame, spot: LabelBox) -> bool {
    let [left, top, width, height] = frame.area;
    spot[0] >= left && spot[1] >= top && spot[2] <= left + width && spot[3] <= top + height
}

fn write(canvas: &mut Canvas<'_>, note: &FigureNote, spot: LabelBox) {
    canvas.text(
        [0.5 * (spot[0] + spot[2]), spot[3]],
        &note.text,
        note.size_px,
        note.colour,
        Align::Middle,
    );
}
