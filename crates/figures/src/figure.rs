//! What a figure is made of: panels with axes, and marks in them. Nothing here depends on robots or on pixels on paper.

use super::palette::{Colour, Marker};

/// A figure: a grid of panels under a title, with a legend above the panels and a caption below them.
///
/// The legend never covers data, because it stands outside the panels; its entries are the labels of the series, each once, then
/// `legend`.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// One line of what is shown.
    pub title: String,
    /// What the marks mean: what a bar is, how many readings a point has. Wrapped to the width of the figure.
    pub caption: String,
    /// Panels beside each other; the grid is filled row by row.
    pub columns: usize,
    /// Width and height of the plot area of a panel, px.
    pub panel_px: [f64; 2],
    /// Heights of the rows where they differ, px; rows beyond the list have the height of `panel_px`.
    pub row_heights_px: Vec<f64>,
    /// Widths of the columns where they differ, px; columns beyond the list have the width of `panel_px`.
    pub column_widths_px: Vec<f64>,
    /// Which panels have the same horizontal range.
    pub share_x: Sharing,
    /// Which panels have the same vertical range.
    pub share_y: Sharing,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Entries of the legend beyond the labels of the series.
    pub legend: Vec<LegendEntry>,
}

impl Figure {
    /// A figure without panels yet: one column, each panel with its own ranges.
    #[must_use]
    pub fn new(title: impl Into<String>, caption: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: caption.into(),
            columns: 1,
            panel_px: [420.0, 300.0],
            row_heights_px: Vec::new(),
            column_widths_px: Vec::new(),
            share_x: Sharing::Own,
            share_y: Sharing::Own,
            panels: Vec::new(),
            legend: Vec::new(),
        }
    }

    /// Size of the plot area of a panel, px.
    pub(super) fn panel_size_px(&self, panel: usize) -> [f64; 2] {
        let row = panel / self.columns.max(1);
        let height = self.row_heights_px.get(row).copied();
        let width = self.column_width_px(panel % self.columns.max(1));
        [width, height.unwrap_or(self.panel_px[1])]
    }

    /// Width of the plot areas of a column, px.
    pub(super) fn column_width_px(&self, column: usize) -> f64 {
        let width = self.column_widths_px.get(column).copied();
        width.unwrap_or(self.panel_px[0])
    }

    /// The figure as SVG 1.1 text; the same figure gives the same bytes.
    ///
    /// Points that cannot be placed (no finite value, not positive on a logarithmic axis, or outside a range that was fixed) are
    /// counted, and the caption states this.
    #[must_use]
    pub fn to_svg(&self) -> String {
        super::render::svg(self)
    }
}

/// Which panels of the grid have the same range along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sharing {
    /// None: every panel fits its own data.
    #[default]
    Own,
    /// All.
    All,
    /// Those of one column.
    Column,
    /// Those of one row.
    Row,
}

/// A pair of axes and what is drawn in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Short heading; empty for none.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Whether a unit is equally long along both axes; the range that has room to spare is widened. Needs linear axes, not shared.
    pub equal_aspect: bool,
    /// Whether a border is drawn around the plot area; a view in perspective brings its own.
    pub bordered: bool,
    /// Marks, the first at the bottom.
    pub series: Vec<Series>,
    /// Texts at points of the panel, over all marks.
    pub notes: Vec<FigureNote>,
}

impl Panel {
    /// An empty panel.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            equal_aspect: false,
            bordered: true,
            series: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Adds marks, if there are any, over those before.
    pub(super) fn draw(&mut self, style: Style, marks: Marks) {
        if !marks.is_empty() {
            self.series.push(Series::new(style, marks));
        }
    }

    /// The same with an entry in the legend.
    pub(super) fn draw_named(&mut self, label: impl Into<String>, style: Style, marks: Marks) {
        if !marks.is_empty() {
            self.series.push(Series::labelled(label, style, marks));
        }
    }
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit, for example `load (N)`.
    pub label: String,
    /// How values are spread.
    pub scale: AxisScale,
    /// Fixed ends; `None` fits the data with a margin.
    pub range: Option<[f64; 2]>,
    /// Whether values grow to the left or downward.
    pub reversed: bool,
    /// Whether thin lines cross the panel at the ticks.
    pub grid: bool,
}

impl Axis {
    /// An even axis for a quantity in a unit; an empty unit is a plain number.
    #[must_use]
    pub fn linear(quantity: &str, unit: &str) -> Self {
        Self {
            label: if unit.is_empty() {
                quantity.to_owned()
            } else {
                format!("{quantity} ({unit})")
            },
            scale: AxisScale::Linear,
            range: None,
            reversed: false,
            grid: true,
        }
    }

    /// A logarithmic axis for a positive quantity in a unit.
    #[must_use]
    pub fn log10(quantity: &str, unit: &str) -> Self {
        Self {
            scale: AxisScale::Log10,
            ..Self::linear(quantity, unit)
        }
    }

    /// An axis of names; the n-th name stands at the value n, counted from zero.
    #[must_use]
    pub fn categories(quantity: &str, names: Vec<String>) -> Self {
        Self {
            scale: AxisScale::Categories(names),
            grid: false,
            ..Self::linear(quantity, "")
        }
    }

    /// A vertical axis of names from the top down.
    pub(super) fn rows(names: Vec<String>) -> Self {
        Self {
            reversed: true,
            ..Self::categories("", names)
        }
    }

    /// The same axis with fixed ends.
    pub(super) fn within(self, range: [f64; 2]) -> Self {
        Self {
            range: Some(range),
            ..self
        }
    }
}

/// How values are spread along an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisScale {
    /// Evenly.
    Linear,
    /// Evenly in the logarithm.
    Log10,
    /// One place for each name.
    Categories(Vec<String>),
}

/// Marks of one look.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Entry in the legend; `None` for none. The same label in several panels or series is one entry.
    pub label: Option<String>,
    /// Look.
    pub style: Style,
    /// What is drawn.
    pub marks: Marks,
}

impl Series {
    /// Marks without a legend entry.
    #[must_use]
    pub fn new(style: Style, marks: Marks) -> Self {
        Self {
            label: None,
            style,
            marks,
        }
    }

    /// Marks with a legend entry.
    #[must_use]
    pub fn labelled(label: impl Into<String>, style: Style, marks: Marks) -> Self {
        Self {
            label: Some(label.into()),
            style,
            marks,
        }
    }
}

/// Look of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Colour of lines, points and areas.
    pub colour: Colour,
    /// Shape of points.
    pub marker: Marker,
    /// Half the width of a point, px.
    pub marker_px: f64,
    /// Width of lines, px.
    pub stroke_px: f64,
    /// Stroke and gap, px; `None` for a full line.
    pub dash_px: Option<[f64; 2]>,
}

impl Style {
    /// A look in one colour with the usual sizes.
    #[must_use]
    pub fn new(colour: Colour, marker: Marker) -> Self {
        Self {
            colour,
            marker,
            marker_px: 3.6,
            stroke_px: 1.4,
            dash_px: None,
        }
    }

    /// The look of a line, which has no points.
    #[must_use]
    pub fn line(colour: Colour, stroke_px: f64) -> Self {
        Self::new(colour, Marker::Dot).stroke(stroke_px)
    }

    /// The look of the n-th series: differs from all others in colour and in shape.
    #[must_use]
    pub fn nth(n: usize) -> Self {
        Self::new(super::palette::qualitative(n), Marker::nth(n))
    }

    /// The same look with another line width.
    #[must_use]
    pub fn stroke(self, stroke_px: f64) -> Self {
        Self { stroke_px, ..self }
    }

    /// The same look with a broken line.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self {
            dash_px: Some([6.0, 4.0]),
            ..self
        }
    }

    /// The same look with larger or smaller points.
    #[must_use]
    pub fn marker_size(self, marker_px: f64) -> Self {
        Self { marker_px, ..self }
    }
}

/// What a series draws, in the units of the axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Marks {
    /// Points, with or without bars.
    Points(Vec<FigurePoint>),
    /// A line through points.
    Line(Vec<[f64; 2]>),
    /// Lines between pairs of points.
    Segments(Vec<[[f64; 2]; 2]>),
    /// A line that stays at a value until the next.
    Steps(Vec<[f64; 2]>),
    /// The area between two values, as (x, low, high).
    Band(Vec<[f64; 3]>),
    /// Filled areas, each in its colour.
    Polygons(Vec<Polygon>),
    /// Arrows from the first point to the second.
    Arrows(Vec<[[f64; 2]; 2]>),
    /// A line across the panel at a vertical value.
    LevelAt(f64),
    /// A line from bottom to top at a horizontal value.
    UprightAt(f64),
}

impl Marks {
    pub(super) fn is_empty(&self) -> bool {
        match self {
            Self::Points(points) => points.is_empty(),
            Self::Line(points) | Self::Steps(points) => points.is_empty(),
            Self::Segments(pairs) | Self::Arrows(pairs) => pairs.is_empty(),
            Self::Band(points) => points.is_empty(),
            Self::Polygons(areas) => areas.is_empty(),
            Self::LevelAt(_) | Self::UprightAt(_) => false,
        }
    }
}

/// A point with its bars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigurePoint {
    /// Horizontal value.
    pub x: f64,
    /// Vertical value.
    pub y: f64,
    /// Ends of the horizontal bar.
    pub x_bar: Option<[f64; 2]>,
    /// Ends of the vertical bar.
    pub y_bar: Option<[f64; 2]>,
    /// Drawn as an outline: a flagged reading is shown, never hidden.
    pub hollow: bool,
}

impl FigurePoint {
    /// A point without bars.
    #[must_use]
    pub fn new(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            x_bar: None,
            y_bar: None,
            hollow: false,
        }
    }

    /// A reading with a bar of half length `bar`; an outline if it is flagged.
    pub(super) fn of_reading(x: f64, y: f64, bar: Option<f64>, flagged: bool) -> Self {
        Self {
            y_bar: bar.map(|half| [y - half, y + half]),
            ..Self::new(x, y).hollow(flagged)
        }
    }

    /// The same point, as an outline where this holds.
    pub(super) fn hollow(self, hollow: bool) -> Self {
        Self { hollow, ..self }
    }
}

/// A filled area.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Corners.
    pub corners: Vec<[f64; 2]>,
    /// Fill.
    pub colour: Colour,
}

impl Polygon {
    /// A rectangle between two horizontal and two vertical values.
    pub(super) fn rectangle(
        [left, right]: [f64; 2],
        [top, bottom]: [f64; 2],
        colour: Colour,
    ) -> Self {
        Self {
            corners: vec![[left, top], [right, top], [right, bottom], [left, bottom]],
            colour,
        }
    }

    /// A square around a place.
    pub(super) fn square([x, y]: [f64; 2], half: f64, colour: Colour) -> Self {
        Self::rectangle([x - half, x + half], [y - half, y + half], colour)
    }
}

/// A text at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureNote {
    /// The point, in the units of the axes.
    pub at: [f64; 2],
    /// The text, one line.
    pub text: String,
    /// Colour.
    pub colour: Colour,
    /// Height of the letters' em, px.
    pub size_px: f64,
    /// Where it stands.
    pub placement: NotePlacement,
}

impl FigureNote {
    /// A note in ink.
    pub(super) fn new(
        at: [f64; 2],
        text: impl Into<String>,
        size_px: f64,
        placement: NotePlacement,
    ) -> Self {
        Self {
            at,
            text: text.into(),
            colour: Colour::INK,
            size_px,
            placement,
        }
    }
}

/// Where a note stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NotePlacement {
    /// Centred on the point.
    Centred,
    /// Beside the point where it covers no point and no other note and as few lines as can be; left out if there is no such place.
    /// For names of nodes.
    Free,
    /// Beside the point in a direction (right, up), whose length does not matter.
    Toward([f64; 2]),
}

/// An entry of the legend that no series has.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendEntry {
    /// Text.
    pub label: String,
    /// Look.
    pub style: Style,
    /// What is shown of it.
    pub sample: LegendMark,
}

impl LegendEntry {
    /// An entry with its look.
    pub(super) fn new(label: impl Into<String>, style: Style, sample: LegendMark) -> Self {
        Self {
            label: label.into(),
            style,
            sample,
        }
    }
}

/// What a legend entry shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendMark {
    /// A point.
    Point,
    /// An outlined point.
    HollowPoint,
    /// A piece of line.
    Line,
    /// A point on a piece of line.
    PointOnLine,
    /// A filled square.
    Area,
    /// An arrow.
    Arrow,
}
