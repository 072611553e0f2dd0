//! Where on the sheet everything stands.

use super::figure::{AxisScale, Figure, LegendEntry, LegendMark, Marks, Panel, Sharing};
use super::font;
use super::range::{Along, Ruler, ranges, unspread, with_equal_aspect};
use super::ticks::{Tick, step_of, ticks};

pub(super) const TITLE_PX: f64 = 15.0;
pub(super) const HEADING_PX: f64 = 12.0;
pub(super) const LABEL_PX: f64 = 12.0;
pub(super) const TICK_PX: f64 = 11.0;
pub(super) const LEGEND_PX: f64 = 11.5;
pub(super) const CAPTION_PX: f64 = 11.5;
/// Line spacing as a multiple of the size.
pub(super) const LINE: f64 = 1.35;
/// Length of a tick.
pub(super) const TICK_LENGTH_PX: f64 = 4.0;
/// Width of the sample in a legend entry.
pub(super) const SAMPLE_PX: f64 = 26.0;

/// Free border of the sheet.
const BORDER_PX: f64 = 14.0;
/// Narrowest sheet: captions need some width to be read.
const NARROWEST_PX: f64 = 460.0;
/// Between two columns or rows of panels.
const BETWEEN_PX: f64 = 12.0;

/// The whole sheet.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) size_px: [f64; 2],
    pub(super) title: Vec<TextLine>,
    pub(super) legend: Vec<([f64; 2], LegendEntry)>,
    pub(super) frames: Vec<Frame>,
    pub(super) caption: Vec<TextLine>,
}

/// A line of text and where its baseline starts.
#[derive(Debug)]
pub(super) struct TextLine {
    pub(super) at: [f64; 2],
    pub(super) text: String,
}

/// One panel on the sheet.
#[derive(Debug)]
pub(super) struct Frame {
    /// Plot area: left, top, width, height.
    pub(super) area: [f64; 4],
    pub(super) x: Ruler,
    pub(super) y: Ruler,
    pub(super) x_side: Side,
    pub(super) y_side: Side,
}

/// What is written beside one axis.
#[derive(Debug, Clone)]
pub(super) struct Side {
    pub(super) ticks: Vec<Tick>,
    /// Whether ticks have their text here, or only at the panel they are shared with.
    pub(super) texts: bool,
    /// Whether the axis is named here.
    pub(super) named: bool,
    /// Whether the texts read upward.
    pub(super) upward: bool,
    /// Room for the texts at right angles to the axis.
    pub(super) depth_px: f64,
}

impl Side {
    fn room_px(&self) -> f64 {
        let texts = if self.texts {
            TICK_LENGTH_PX + 3.0 + self.depth_px
        } else {
            TICK_LENGTH_PX
        };
        let name = if self.named {
            LABEL_PX * LINE + 2.0
        } else {
            0.0
        };
        texts + name
    }
}

/// Places everything.
pub(super) fn layout(figure: &Figure, caption: &str) -> Layout {
    let columns = figure.columns.max(1);
    let rows = figure.panels.len().div_ceil(columns);
    let ranges = all_ranges(figure);
    let sides = aligned_sides(figure, &ranges);
    let largest = |panels: &mut dyn Iterator<Item = usize>, room: &dyn Fn(usize) -> f64| {
        panels.map(room).fold(0.0, f64::max)
    };
    let in_column =
        |column: usize| (0..figure.panels.len()).filter(move |index| index % columns == column);
    let in_row = |row: usize| (0..figure.panels.len()).filter(move |index| index / columns == row);
    let left: Vec<f64> = (0..columns)
        .map(|c| largest(&mut in_column(c), &|i| sides[i][1].room_px()))
        .collect();
    let right: Vec<f64> = (0..columns)
        .map(|c| largest(&mut in_column(c), &|i| overhang_px(&sides[i][0])))
        .collect();
    let bottom: Vec<f64> = (0..rows)
        .map(|r| largest(&mut in_row(r), &|i| sides[i][0].room_px()))
        .collect();
    let top: Vec<f64> = (0..rows)
        .map(|r| largest(&mut in_row(r), &|i| heading_px(&figure.panels[i])))
        .collect();

    let widths: Vec<f64> = (0..columns).map(|c| figure.column_width_px(c)).collect();
    let between = |count: usize| BETWEEN_PX * count.saturating_sub(1) as f64;
    let all_widths = left.iter().chain(&right).chain(&widths);
    let grid_width = all_widths.sum::<f64>() + between(columns);
    let width = (grid_width + 2.0 * BORDER_PX).max(NARROWEST_PX);
    let text_width = width - 2.0 * BORDER_PX;

    let mut y = BORDER_PX;
    let title = lines(&figure.title, TITLE_PX, text_width, &mut y);
    let legend = place_legend(legend_entries(figure), text_width, &mut y);
    let grid_left = 0.5 * (width - grid_width);
    let mut frames = Vec::with_capacity(figure.panels.len());
    let mut row_top = y;
    for (index, panel) in figure.panels.iter().enumerate() {
        let (row, column) = (index / columns, index % columns);
        if column == 0 && row > 0 {
            let above = figure.panel_size_px(index - 1)[1];
            row_top += top[row - 1] + above + bottom[row - 1] + BETWEEN_PX;
        }
        let x0 = grid_left
            + left[..=column].iter().sum::<f64>()
            + right[..column].iter().sum::<f64>()
            + widths[..column].iter().sum::<f64>()
            + BETWEEN_PX * column as f64;
        // Whole pixels, so that areas whose edges are whole pixels from the corner meet without a seam.
        let [x0, y0] = [x0, row_top + top[row]].map(f64::round);
        let panel_height = figure.panel_size_px(index)[1];
        let [x_side, y_side] = sides[index].clone();
        frames.push(Frame {
            area: [x0, y0, widths[column], panel_height],
            x: Ruler::new(&panel.x, ranges[index][0], [x0, x0 + widths[column]]),
            y: Ruler::new(&panel.y, ranges[index][1], [y0 + panel_height, y0]),
            x_side,
            y_side,
        });
    }
    y = row_top + top.last().unwrap_or(&0.0) + bottom.last().unwrap_or(&0.0) + 10.0;
    if let Some(last) = figure.panels.len().checked_sub(1) {
        y += figure.panel_size_px(last)[1];
    }
    let caption = lines(caption, CAPTION_PX, text_width, &mut y);
    Layout {
        size_px: [width, y + BORDER_PX - 4.0],
        title,
        legend,
        frames,
        caption,
    }
}

/// Ranges of all panels, x and y, with sharing and equal aspect.
fn all_ranges(figure: &Figure) -> Vec<[[f64; 2]; 2]> {
    let x = ranges(figure, Along::X, figure.share_x);
    let y = ranges(figure, Along::Y, figure.share_y);
    figure
        .panels
        .iter()
        .enumerate()
        .map(|(index, panel)| {
            if panel.equal_aspect {
                with_equal_aspect(x[index], y[index], figure.panel_size_px(index))
            } else {
                [x[index], y[index]]
            }
        })
        .collect()
}

/// Sides of all panels; names of vertical axes in one column stand in line.
fn aligned_sides(figure: &Figure, ranges: &[[[f64; 2]; 2]]) -> Vec<[Side; 2]> {
    let columns = figure.columns.max(1);
    let mut all: Vec<[Side; 2]> = (0..figure.panels.len())
        .map(|index| sides(figure, index, ranges[index]))
        .collect();
    for column in 0..columns {
        let deepest = all
            .iter()
            .skip(column)
            .step_by(columns)
            .filter(|[_, side]| side.texts)
            .map(|[_, side]| side.depth_px)
            .fold(0.0, f64::max);
        for [_, side] in all.iter_mut().skip(column).step_by(columns) {
            side.depth_px = deepest;
        }
    }
    all
}

/// Ticks of both axes of a panel and what of them is written.
fn sides(figure: &Figure, index: usize, [x_range, y_range]: [[f64; 2]; 2]) -> [Side; 2] {
    let panel = &figure.panels[index];
    let [width_px, height_px] = figure.panel_size_px(index);
    let columns = figure.columns.max(1);
    let below = figure.panels.get(index + columns);
    let before = (!index.is_multiple_of(columns)).then(|| &figure.panels[index - 1]);
    let shares_column = matches!(figure.share_x, Sharing::All | Sharing::Column);
    let shares_row = matches!(figure.share_y, Sharing::All | Sharing::Row);

    let (x_ticks, upward) = horizontal_ticks(panel, x_range, width_px);
    let x_depth = if upward {
        widest_px(&x_ticks)
    } else {
        TICK_PX * 0.9
    };
    let y_ticks = vertical_ticks(panel, y_range, height_px);
    let y_depth = widest_px(&y_ticks);
    [
        Side {
            ticks: x_ticks,
            texts: !(shares_column && below.is_some()),
            named: !panel.x.label.is_empty()
                && below.is_none_or(|other| other.x.label != panel.x.label),
            upward,
            depth_px: x_depth,
        },
        Side {
            ticks: y_ticks,
            texts: !(shares_row && before.is_some()),
            named: !panel.y.label.is_empty()
                && before.is_none_or(|other| other.y.label != panel.y.label),
            upward: false,
            depth_px: y_depth,
        },
    ]
}

fn widest_px(ticks: &[Tick]) -> f64 {
    ticks
        .iter()
        .map(|tick| font::width_px(&tick.text, TICK_PX))
        .fold(0.0, f64::max)
}

/// Ticks of a horizontal axis whose texts do not touch, and whether they must read upward for that.
fn horizontal_ticks(panel: &Panel, range: [f64; 2], width_px: f64) -> (Vec<Tick>, bool) {
    let scale = &panel.x.scale;
    let values = range.map(|end| unspread(scale, end));
    let ruler = Ruler::new(&panel.x, range, [0.0, width_px]);
    let most = (width_px / 40.0).floor().max(2.0) as usize;
    let mut found = Vec::new();
    for wanted in (1..=most).rev() {
        found = ticks(scale, values, wanted);
        if touching(&found, &ruler).is_none() {
            return (found, false);
        }
    }
    if matches!(scale, AxisScale::Categories(_)) {
        // Of names that have no room even so, every second, fifth, tenth … is written.
        let room = (width_px / TICK_PX).floor().max(1.0) as usize;
        let every = step_of(found.len() as f64, room).max(1.0) as usize;
        return (found.into_iter().step_by(every).collect(), true);
    }
    // Two powers of ten side by side: the later text gives way, its tick stays.
    while let Some(place) = touching(&found, &ruler) {
        found[place].text.clear();
    }
    (found, false)
}

/// Place of the first tick whose text touches the one before it.
fn touching(ticks: &[Tick], ruler: &Ruler) -> Option<usize> {
    let mut before: Option<(f64, f64)> = None;
    for (index, tick) in ticks.iter().enumerate().filter(|(_, t)| !t.text.is_empty()) {
        let half = 0.5 * font::width_px(&tick.text, TICK_PX);
        let place = ruler.place(tick.value)?;
        if let Some((other, other_half)) = before
            && (place - other).abs() < half + other_half + 7.0
        {
            return Some(index);
        }
        before = Some((place, half));
    }
    None
}

fn vertical_ticks(panel: &Panel, range: [f64; 2], height_px: f64) -> Vec<Tick> {
    let scale = &panel.y.scale;
    let wanted = (height_px / 22.0).floor().max(2.0) as usize;
    ticks(scale, range.map(|end| unspread(scale, end)), wanted)
}

/// How far the texts of a horizontal axis may reach beyond its right end.
fn overhang_px(side: &Side) -> f64 {
    if side.texts && !side.upward {
        0.5 * side
            .ticks
            .last()
            .map_or(0.0, |tick| font::width_px(&tick.text, TICK_PX))
    } else {
        0.0
    }
}

fn heading_px(panel: &Panel) -> f64 {
    if panel.title.is_empty() {
        6.0
    } else {
        HEADING_PX * LINE + 4.0
    }
}

/// Wrapped lines from `y` downward; `y` moves below them.
fn lines(text: &str, size_px: f64, width_px: f64, y: &mut f64) -> Vec<TextLine> {
    font::wrap(text, size_px, width_px)
        .into_iter()
        .map(|text| {
            *y += size_px * LINE;
            TextLine {
                at: [BORDER_PX, *y - size_px * (LINE - 1.0)],
                text,
            }
        })
        .collect()
}

/// Labels of series, each once, then the entries of the figure.
fn legend_entries(figure: &Figure) -> Vec<LegendEntry> {
    let mut entries: Vec<LegendEntry> = Vec::new();
    for series in figure.panels.iter().flat_map(|panel| &panel.series) {
        let Some(label) = &series.label else {
            continue;
        };
        let sample = match &series.marks {
            Marks::Points(_) => LegendMark::Point,
            Marks::Band(_) | Marks::Polygons(_) => LegendMark::Area,
            Marks::Arrows(_) => LegendMark::Arrow,
            Marks::Line(_)
            | Marks::Segments(_)
            | Marks::Steps(_)
            | Marks::LevelAt(_)
            | Marks::UprightAt(_) => LegendMark::Line,
        };
        match entries.iter_mut().find(|entry| entry.label == *label) {
            None => entries.push(LegendEntry::new(label.clone(), series.style, sample)),
            Some(entry)
                if matches!(
                    (entry.sample, sample),
                    (LegendMark::Point, LegendMark::Line) | (LegendMark::Line, LegendMark::Point)
                ) =>
            {
                entry.sample = LegendMark::PointOnLine;
            }
            Some(_) => {}
        }
    }
    entries.extend(figure.legend.iter().cloned());
    entries
}

/// Entries side by side, in as many rows as they need; `y` moves below them.
fn place_legend(
    entries: Vec<LegendEntry>,
    width_px: f64,
    y: &mut f64,
) -> Vec<([f64; 2], LegendEntry)> {
    if entries.is_empty() {
        return Vec::new();
    }
    let row_px = LEGEND_PX * 1.6;
    *y += row_px + 2.0;
    let mut x = BORDER_PX;
    let mut placed = Vec::with_capacity(entries.len());
    for entry in entries {
        let needed = SAMPLE_PX + 6.0 + font::width_px(&entry.label, LEGEND_PX);
        if x > BORDER_PX && x + needed > BORDER_PX + width_px {
            x = BORDER_PX;
            *y += row_px;
        }
        placed.push(([x, *y], entry));
        x += needed + 18.0;
    }
    *y += 6.0;
    placed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Axis;

    #[test]
    fn columns_of_their_own_width_stand_beside_each_other() {
        let panel = || Panel::new("", Axis::linear("", ""), Axis::linear("", ""));
        let figure = Figure {
            columns: 3,
            panel_px: [100.0, 80.0],
            column_widths_px: vec![300.0, 20.0],
            panels: (0..6).map(|_| panel()).collect(),
            ..Figure::new("", "")
        };
        let placed = layout(&figure, "");
        let widths: Vec<f64> = placed.frames.iter().map(|frame| frame.area[2]).collect();
        assert_eq!(widths, [300.0, 20.0, 100.0, 300.0, 20.0, 100.0]);
        for row in placed.frames.chunks(3) {
            for pair in row.windows(2) {
                assert!(pair[0].area[0] + pair[0].area[2] < pair[1].area[0]);
            }
            assert!(row[2].area[0] + 100.0 < placed.size_px[0]);
        }
    }

    #[test]
    fn names_that_have_no_room_are_thinned() {
        for (names, written) in [(18, 18), (600, 12)] {
            let names = (0..names).map(|place| format!("pose {place}"));
            let x = Axis::categories("pose", names.collect());
            let panel = Panel::new("", x, Axis::linear("", ""));
            let width_px = 200.0;
            let (ticks, upward) = horizontal_ticks(&panel, [-0.5, 599.5], width_px);
            assert!(upward);
            assert_eq!(ticks.len(), written);
        }
    }
}
