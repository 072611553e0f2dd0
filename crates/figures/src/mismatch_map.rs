//! Where residuals sit: a coloured table of cells against load steps, and of cells against runs.

use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::{Branch, Cell};

use super::caption::{count_range, if_any, joined};
use super::figure::{Axis, AxisScale, Figure, FigureNote, Marks, NotePlacement, Panel, Style};
use super::font;
use super::palette::{Colour, diverging};
use super::residuals::ResidualMeasure;
use super::ticks::signed;
use super::value_table::{SIGNED_SHARE, ValueTable, colour_bar, number};

/// Height of a row of the tables, px.
const ROW_PX: f64 = 17.0;
/// Least and largest width of a square, px.
const SQUARE_PX: [f64; 2] = [18.0, 36.0];
/// Width that the table of load steps fills if its squares can be wide enough, px.
const TABLE_PX: f64 = 540.0;
/// Least width of a table, px: its heading must fit.
const LEAST_TABLE_PX: f64 = 92.0;
/// Width of the colour bar, size of the names of the branches, px.
const BAR_PX: f64 = 14.0;
const BRANCH_PX: f64 = 9.5;
/// Rows for which there is always room, so that the colour bar can be read.
const LEAST_ROWS: usize = 8;
/// Standardised residuals beyond this are counted, and the share of them that normal noise alone makes.
const BEYOND: f64 = 3.0;
const BEYOND_BY_NOISE: f64 = 0.0027;
/// Standardised residuals below this take pale colours even if nothing larger is there: noise alone should not look loud.
const LEAST_STANDARDISED: f64 = 4.0;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct MismatchMap {
    /// Name of what was subtracted, for example `fitted beam structure`.
    pub prediction: String,
    /// Measure of all values; standardised means are multiples of the standard uncertainty of that mean.
    pub measure: ResidualMeasure,
    /// Rows, the first at the top.
    pub cells: Vec<Cell>,
    /// Columns of the first table in the order in which they were loaded.
    pub load_steps: Vec<MapLoadStep>,
    /// A row for each cell, an entry for each load step; `None` or a missing entry where nothing was read.
    pub by_load_step: Vec<Vec<Option<MapValue>>>,
    /// Columns of the second table: numbers of the repeats.
    pub repeats: Vec<u32>,
    /// What is shown of a run.
    pub run_summary: RunSummary,
    /// A row for each cell, an entry for each repeat.
    pub by_run: Vec<Vec<Option<MapValue>>>,
}

/// A column of the first table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapLoadStep {
    /// Target load, N.
    pub target_n: f64,
    /// Loading or unloading.
    pub branch: Branch,
}

/// A value of the tables and what stands behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapValue {
    /// Measured minus predicted displacement, m, or as a multiple of its standard uncertainty.
    pub value: f64,
    /// Readings behind it.
    pub n: usize,
}

/// What is shown of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunSummary {
    /// Mean of its residuals.
    Mean,
    /// Slope of its residuals over the load, times the largest load.
    SlopeAtLargestLoad,
}

/// The figure: two tables side by side with one colour scale; the number stands in every square that has room for it.
#[must_use]
pub fn mismatch_map(input: &MismatchMap) -> Figure {
    let limit = limit(input);
    let [steps, runs] = [input.load_steps.len(), input.repeats.len()].map(|n| n.max(1) as f64);
    let square_px = (TABLE_PX / steps).clamp(SQUARE_PX[0], SQUARE_PX[1]);
    let [steps_px, runs_px] = [steps, runs].map(|n| (square_px * n).max(LEAST_TABLE_PX));
    let (by_load, load_numbered) = load_steps_panel(input, limit, steps_px / steps);
    let (by_run, run_numbered) = runs_panel(input, limit, runs_px / runs);
    let scale = match input.measure {
        ResidualMeasure::Micrometres => Axis::linear("residual", "µm"),
        ResidualMeasure::StandardUncertainties => Axis::linear("standardised residual", ""),
    };
    Figure {
        columns: 3,
        panel_px: [
            steps_px,
            ROW_PX * (input.cells.len().max(LEAST_ROWS) + 1) as f64,
        ],
        column_widths_px: vec![steps_px, runs_px, BAR_PX],
        panels: vec![
            by_load,
            by_run,
            colour_bar(scale, [-limit, limit], |value| diverging(value / limit)),
        ],
        ..Figure::new(
            format!("Where the residuals of the {} sit", input.prediction),
            caption(input, load_numbered && run_numbered, limit),
        )
    }
}

/// The table of cells against load steps, and whether its numbers had room.
fn load_steps_panel(input: &MismatchMap, limit: f64, square_px: f64) -> (Panel, bool) {
    let loads = input
        .load_steps
        .iter()
        .map(|step| signed(step.target_n, decimals(step.target_n)));
    let panel = Panel::new(
        "mean of each load step",
        Axis::categories("load (N)", loads.collect()),
        names(input, true),
    );
    let (mut panel, numbered) = table(input, &input.by_load_step, (limit, square_px), panel);
    push_branches(&mut panel, input, square_px);
    (panel, numbered)
}

/// The table of cells against runs, and whether its numbers had room.
fn runs_panel(input: &MismatchMap, limit: f64, square_px: f64) -> (Panel, bool) {
    let heading = match input.run_summary {
        RunSummary::Mean => "mean of each run",
        RunSummary::SlopeAtLargestLoad => "slope of each run",
    };
    let repeats = input.repeats.iter().map(ToString::to_string).collect();
    let panel = Panel::new(
        heading,
        Axis::categories("repeat", repeats),
        names(input, false),
    );
    table(input, &input.by_run, (limit, square_px), panel)
}

/// Decimals of a target load: none for whole newtons.
fn decimals(target_n: f64) -> usize {
    usize::from(target_n != target_n.round())
}

/// Rows: above the cells stands one that names the branches.
fn names(input: &MismatchMap, written: bool) -> Axis {
    let cells = input.cells.iter().map(|cell| {
        if written {
            cell.to_string()
        } else {
            String::new()
        }
    });
    Axis::rows(std::iter::once(String::new()).chain(cells).collect())
}

/// Value in the unit that is printed.
fn printed(measure: ResidualMeasure, value: f64) -> f64 {
    match measure {
        ResidualMeasure::Micrometres => value / METRES_PER_MICROMETRE,
        ResidualMeasure::StandardUncertainties => value,
    }
}

/// The finite entry of a table in the unit that is printed.
fn entry(
    measure: ResidualMeasure,
    values: &[Vec<Option<MapValue>>],
    row: usize,
    column: usize,
) -> Option<(f64, usize)> {
    let found = (*values.get(row)?.get(column)?)?;
    let value = printed(measure, found.value);
    value.is_finite().then_some((value, found.n))
}

/// All entries that are drawn as values: row, column, value and readings behind it.
fn entries<'a>(
    input: &'a MismatchMap,
    values: &'a [Vec<Option<MapValue>>],
    columns: usize,
) -> impl Iterator<Item = (usize, usize, f64, usize)> + 'a {
    (0..input.cells.len()).flat_map(move |row| {
        (0..columns).filter_map(move |column| {
            let (value, n) = entry(input.measure, values, row, column)?;
            Some((row, column, value, n))
        })
    })
}

/// Value at the ends of the colour scale.
fn limit(input: &MismatchMap) -> f64 {
    let least = match input.measure {
        ResidualMeasure::Micrometres => 0.0,
        ResidualMeasure::StandardUncertainties => LEAST_STANDARDISED,
    };
    let steps = entries(input, &input.by_load_step, input.load_steps.len());
    let largest = steps
        .chain(entries(input, &input.by_run, input.repeats.len()))
        .map(|(_, _, value, _)| value.abs())
        .fold(least, f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// One of the two tables: squares, their numbers, and lines between groups of rows; and whether the numbers had room.
fn table(
    input: &MismatchMap,
    values: &[Vec<Option<MapValue>>],
    (limit, square_px): (f64, f64),
    mut panel: Panel,
) -> (Panel, bool) {
    let columns = match &panel.x.scale {
        AxisScale::Categories(names) => names.len(),
        AxisScale::Linear | AxisScale::Log10 => 0,
    };
    let value = |row: usize, column: usize| {
        entry(input.measure, values, row, column).map(|(value, _)| value)
    };
    let table = ValueTable {
        size: [input.cells.len(), columns],
        first_row: 1.0,
        limit,
        square_px,
        value: &value,
    };
    let numbered = table.push_to(&mut panel);
    let border = Style::line(Colour::GREY, 1.2);
    for place in group_borders(&input.cells) {
        panel.draw(border, Marks::LevelAt(place as f64 + 0.5));
    }
    (panel, numbered)
}

/// Rows after which a new group begins: a group is what changes less often from row to row, the pose or the direction.
fn group_borders(cells: &[Cell]) -> Vec<usize> {
    let changes = |differ: &dyn Fn(&Cell, &Cell) -> bool| -> Vec<usize> {
        (1..cells.len())
            .filter(|row| differ(&cells[row - 1], &cells[*row]))
            .collect()
    };
    let poses = changes(&|a, b| a.pose != b.pose);
    let directions = changes(&|a, b| a.direction != b.direction);
    if poses.len() <= directions.len() {
        poses
    } else {
        directions
    }
}

/// Names of the branches above their columns, and a line where one ends.
fn push_branches(panel: &mut Panel, input: &MismatchMap, square_px: f64) {
    let mut start = 0;
    for pieces in input.load_steps.chunk_by(|a, b| a.branch == b.branch) {
        let end = start + pieces.len();
        let text = pieces[0].branch.to_string();
        if font::width_px(&text, BRANCH_PX) < square_px * pieces.len() as f64 {
            panel.notes.push(FigureNote::new(
                [0.5 * (start + end - 1) as f64, 0.0],
                text,
                BRANCH_PX,
                NotePlacement::Centred,
            ));
        }
        if end < input.load_steps.len() {
            panel.draw(
                Style::line(Colour::GREY, 1.2),
                Marks::UprightAt(end as f64 - 0.5),
            );
        }
        start = end;
    }
}

fn caption(input: &MismatchMap, numbered: bool, limit: f64) -> String {
    let [steps, runs] = [input.load_steps.len(), input.repeats.len()];
    let by_load = || entries(input, &input.by_load_step, steps);
    let by_run = || entries(input, &input.by_run, runs);
    let squares = input.cells.len() * (steps + runs);
    let empty = squares - by_load().count() - by_run().count();
    let measure = match input.measure {
        ResidualMeasure::Micrometres => "",
        ResidualMeasure::StandardUncertainties => {
            ", divided by the standard uncertainty of what is shown"
        }
    };
    let summary = match input.run_summary {
        RunSummary::Mean => "mean of its residuals",
        RunSummary::SlopeAtLargestLoad => {
            "slope of its residuals over the load, times the largest load"
        }
    };
    joined([
        Some(format!(
            "Residual: measured minus predicted displacement{measure}; blue is negative, orange positive, white zero."
        )),
        Some(format!(
            "Load steps: {} readings a square. Run: {summary}, {} readings a square.",
            count_range(by_load().map(|(_, _, _, n)| n)),
            count_range(by_run().map(|(_, _, _, n)| n)),
        )),
        (!numbered).then(|| {
            format!(
                "Where squares have no room for numbers, + and − mark values beyond ±{}.",
                number(SIGNED_SHARE * limit)
            )
        }),
        largest(input),
        (input.measure == ResidualMeasure::StandardUncertainties).then(|| {
            let filled = by_load().chain(by_run());
            beyond(filled.map(|(_, _, value, _)| value))
        }),
        if_any(
            empty,
            format!(
                "{empty} of {squares} squares {} hatched.",
                if empty == 1 {
                    "has no value and is"
                } else {
                    "have no value and are"
                },
            ),
        ),
    ])
}

/// Where the largest mean of a load step is, as a sentence.
fn largest(input: &MismatchMap) -> Option<String> {
    let all = entries(input, &input.by_load_step, input.load_steps.len());
    let (row, column, value, _) = all.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    let step = input.load_steps[column];
    let unit = match input.measure {
        ResidualMeasure::Micrometres => "\u{a0}µm",
        ResidualMeasure::StandardUncertainties => "",
    };
    Some(format!(
        "Largest mean of a load step: {}{unit} in {} at {}\u{a0}N, {}.",
        number(value),
        input.cells[row],
        signed(step.target_n, decimals(step.target_n)),
        step.branch
    ))
}

/// How many standardised values lie beyond what noise makes, as a sentence.
fn beyond(values: impl Iterator<Item = f64>) -> String {
    let (count, all) = values.fold((0, 0), |(count, all), value| {
        (count + usize::from(value.abs() > BEYOND), all + 1)
    });
    let by_noise = BEYOND_BY_NOISE * f64::from(all);
    format!(
        "Beyond ±{BEYOND}: {count} of {all} squares; normal noise alone makes about {by_noise:.1}."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Polygon;
    use crate::png::parse;
    use crate::reading::{areas_of, assert_says, notes_of};
    use stiffbench_units_and_text::test_point::Direction;

    fn input(measure: ResidualMeasure) -> MismatchMap {
        let cell = |pose: &str, direction| Cell::new(pose.into(), direction);
        let step = |target_n, branch| MapLoadStep { target_n, branch };
        let of = |value| Some(MapValue { value, n: 5 });
        MismatchMap {
            prediction: "fitted structure".to_owned(),
            measure,
            cells: vec![
                cell("P1", Direction::X),
                cell("P1", Direction::Y),
                cell("P2", Direction::X),
            ],
            load_steps: vec![
                step(0.0, Branch::Loading),
                step(-10.0, Branch::Loading),
                step(-5.5, Branch::Unloading),
            ],
            by_load_step: vec![
                vec![of(1e-6), of(-8e-6), None],
                vec![of(2e-6), of(f64::NAN), of(-12.4e-6)],
            ],
            repeats: vec![1, 2],
            run_summary: RunSummary::Mean,
            by_run: vec![
                vec![of(3e-6), of(0.0)],
                vec![None, of(1e-6)],
                vec![of(1e-6)],
            ],
        }
    }

    fn squares(panel: &Panel) -> &[Polygon] {
        areas_of(&panel.series[0])
    }

    #[test]
    fn numbers_and_shades_are_those_given_and_the_rest_is_hatched_and_counted() {
        let figure = mismatch_map(&input(ResidualMeasure::Micrometres));
        let texts = notes_of(&figure.panels[0]);
        assert_eq!(texts, ["1.0", "−8.0", "2.0", "−12", "loading"]);
        assert_eq!(squares(&figure.panels[0])[5].colour, diverging(-1.0));
        assert_eq!(squares(&figure.panels[0])[2].colour, Colour::FAINT);
        let Marks::Segments(hatching) = &figure.panels[0].series[1].marks else {
            panic!("hatching comes second");
        };
        assert_eq!(hatching.len(), 3 * 5);
        assert_eq!(squares(&figure.panels[1]).len(), 6);
        assert_says(&figure, "7 of 15 squares have no value");
        assert_says(&figure, "−12 µm in P1 y at −5.5 N, unloading");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn the_colour_scale_is_shared_and_noise_alone_stays_pale() {
        let figure = mismatch_map(&input(ResidualMeasure::Micrometres));
        let [low, high] = figure.panels[2].y.range.unwrap();
        assert!((low + 12.4).abs() < 1e-9 && (high - 12.4).abs() < 1e-9);
        // These values are tiny as multiples of an uncertainty, so the scale does not follow them.
        let figure = mismatch_map(&input(ResidualMeasure::StandardUncertainties));
        assert_eq!(figure.panels[2].y.range, Some([-4.0, 4.0]));
        assert_says(&figure, "Beyond ±3: 0 of 8 squares");
    }

    #[test]
    fn without_room_for_numbers_the_sign_is_written() {
        let mut input = input(ResidualMeasure::Micrometres);
        input.load_steps = vec![input.load_steps[0]; 60];
        let figure = mismatch_map(&input);
        let texts = notes_of(&figure.panels[0]);
        // A quarter of 12.4 is 3.1: two of the four values lie beyond.
        assert_eq!(texts, ["−", "−", "loading"]);
        assert_says(&figure, "beyond ±3.1");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn rows_are_grouped_by_the_slower_factor() {
        let cells = input(ResidualMeasure::Micrometres).cells;
        assert_eq!(group_borders(&cells), [2]);
        assert_eq!(group_borders(&[]), [0_usize; 0]);
    }

    #[test]
    fn nothing_measured_makes_an_empty_figure() {
        let empty = MismatchMap {
            cells: Vec::new(),
            load_steps: Vec::new(),
            by_load_step: Vec::new(),
            repeats: Vec::new(),
            by_run: Vec::new(),
            ..input(ResidualMeasure::Micrometres)
        };
        parse(&mismatch_map(&empty).to_svg()).unwrap();
    }
}
