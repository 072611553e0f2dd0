//! Reads a table of a specimen.

use indexmap::IndexSet;

use super::branches::follow;
use super::clock::{is_one_sweep, response_by_clock, response_by_scatter};
use super::columns::SpecimenColumns;
use super::excluded::ExcludedLines;
use super::options::{SpecimenOptions, TURN_SHARE};
use super::order::{put_in_order, time_goes_back};
use super::response::{ResponseDoubt, ResponseVariable};
use super::row::{SpecimenRow, SpecimenRowReader};
use super::table::{ColumnUnit, SpecimenReading, SpecimenRun, SpecimenTable};
use crate::readings::TableError;
use crate::table_files::{MachineTable, read_table_files};
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::quantity::Kind;

/// Readings from a table whose columns the caller names.
///
/// The files may be anything that [`read_table_files`] reads. A row that lacks a value (an empty field, `NA`,
/// `N/A`, `NaN`, `null`) in a named column is left out and listed, but for time, hold and temperature, which may be absent.
///
/// # Arguments
/// - `files`: names, for messages, and bytes; several with the same columns are read as one table, in which each is a run.
///
/// # Errors
/// [`TableError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_specimen(
    files: &[(&str, &[u8])],
    options: &SpecimenOptions,
) -> Result<SpecimenTable, TableError> {
    let turn_share = options.turn_share.unwrap_or(TURN_SHARE);
    if !(turn_share > 0.0 && turn_share < 1.0) {
        return Err(TableError::new(
            "stiffbench::specimen::bad_turn_share",
            format!("a turn share of {turn_share} is not between 0 and 1"),
            "--turn-share is the part of a run's range by which the path must come back, 0.05 unless given",
        ));
    }
    let mut file = read_table_files(files, &options.of_file())?;
    let are_runs_stated = !options.run_column.is_empty();
    let options = &options.with_runs_of(&mut file)?;
    let columns = SpecimenColumns::find(&file, options)?;
    let mut reader = SpecimenRowReader::new(&file, &columns);
    for row in 0..file.rows.len() {
        reader.take(row)?;
    }
    if reader.rows.is_empty() {
        let incomplete = counted(reader.incomplete.len(), "row");
        return Err(TableError::new(
            "stiffbench::specimen::no_readings",
            format!(
                "{}: no complete reading follows the header ({incomplete} without a value)",
                file.header()
            ),
            "a reading needs a value in every named column but those of time, hold and temperature",
        ));
    }
    let mut assumptions = assumptions_of_file(&file, &reader, &columns, options);
    if let Some(run) = columns.run.first().filter(|_| !are_runs_stated) {
        let column = &run.name;
        assumptions.push(format!("each {column} is a run, with a zero of its own"));
    }
    let excluded = ExcludedLines {
        incomplete: std::mem::take(&mut reader.incomplete),
        blank: file.blank.clone(),
        comments: file.comments.clone(),
    };
    let mut found = reader.rows;
    let order = put_in_order(&mut found);
    let mut table = tabulate(&file, found, &columns);
    table.assumptions = assumptions;
    table.set_response(&columns, options.response, turn_share);
    table.excluded = excluded;
    table.assumptions.extend(order);
    table.assumptions.extend(time_goes_back(&table.readings));
    if columns.branch.is_none() && columns.is_driven(table.response) {
        assign_branches(&mut table, turn_share);
    }
    Ok(table)
}

impl SpecimenOptions {
    /// The same with the runs that a table has without a column that names them: files, sheets, and columns of repeats, which are put below each
    /// other; dates are put before the times of day.
    fn with_runs_of(&self, file: &mut MachineTable) -> Result<Self, TableError> {
        let mut with = self.clone();
        let mut runs = Vec::new();
        if let (Some(dates), Some(times)) = (&self.date_column, &self.time_column) {
            file.join_dates(file.column(dates, "date")?, file.column(times, "time")?);
        }
        if !file.is_of_one_file() {
            runs.extend(["file", "sheet"]);
        }
        if !self.repeat_columns.is_empty() && !self.may_lack(ResponseVariable::Displacement) {
            let first = std::iter::once(&self.displacement_column);
            let all = first.chain(&self.repeat_columns);
            let places = all.map(|name| file.column(name, "displacement"));
            let places: Vec<usize> = places.collect::<Result<_, _>>()?;
            *file = file.stacked(&places, "series");
            with.displacement_column = (places[0] + 1).to_string();
            runs.push("series");
        }
        let named = |name: &&str| {
            file.names().any(|own| own == *name)
                && !self.configuration_column.iter().any(|own| own == *name)
        };
        if self.run_column.is_empty() {
            with.run_column = runs.into_iter().filter(named).map(str::to_owned).collect();
        }
        Ok(with)
    }
}

impl SpecimenColumns {
    /// Whether the quantity that is set was recorded.
    fn is_driven(&self, response: ResponseVariable) -> bool {
        self.force.is_some() || response == ResponseVariable::Force
    }
}

fn assumptions_of_file(
    file: &MachineTable,
    reader: &SpecimenRowReader<'_>,
    columns: &SpecimenColumns,
    options: &SpecimenOptions,
) -> Vec<String> {
    let mut all = vec![file.layout.to_string()];
    if columns.force.is_none() && options.force_column.is_none() {
        all.push("no force column: the load is the same throughout".to_owned());
    }
    all.extend(columns.assumptions.iter().cloned());
    if columns.configuration.is_empty() {
        all.push("all readings are of one specimen".to_owned());
    }
    if columns.run.is_empty() {
        all.push("all readings of a specimen are one run, with one zero".to_owned());
    }
    all.extend(reader.absent());
    all
}

/// Numbers configurations and runs in the order in which they appear.
fn tabulate(
    file: &MachineTable,
    rows: Vec<SpecimenRow>,
    columns: &SpecimenColumns,
) -> SpecimenTable {
    let mut configurations: IndexSet<String> = IndexSet::new();
    let mut runs: IndexSet<(u32, String)> = IndexSet::new();
    let mut readings = Vec::with_capacity(rows.len());
    for row in rows {
        let named = if columns.configuration.is_empty() {
            "specimen".to_owned()
        } else {
            row.configuration
        };
        let label = if columns.run.is_empty() {
            named.clone()
        } else {
            row.run
        };
        let configuration = configurations.insert_full(named).0 as u32;
        let run = runs.insert_full((configuration, label)).0 as u32;
        readings.push(SpecimenReading {
            configuration,
            run,
            order: row.order.unwrap_or(readings.len() as u32 + 1),
            ..row.reading
        });
    }
    let run = |(configuration, label)| SpecimenRun {
        label,
        configuration,
    };
    SpecimenTable {
        has_order: columns.order.is_some(),
        source: file.source.clone(),
        response: ResponseVariable::default(),
        response_doubt: None,
        is_one_sweep: false,
        force_unit: columns
            .force
            .as_ref()
            .map_or_else(|| ColumnUnit::si(Kind::Force), |force| force.unit.clone()),
        displacement_unit: columns
            .displacement
            .as_ref()
            .map_or_else(ColumnUnit::none, |column| column.unit.clone()),
        has_response: true,
        layout: file.layout.clone(),
        configurations: configurations.into_iter().collect(),
        runs: runs.into_iter().map(run).collect(),
        readings,
        assumptions: Vec::new(),
        excluded: ExcludedLines::default(),
        unused_columns: columns.unused.clone(),
    }
}

impl SpecimenTable {
    /// Takes the response that is stated, else the one that the clock shows.
    fn set_response(
        &mut self,
        columns: &SpecimenColumns,
        stated: Option<ResponseVariable>,
        turn_share: f64,
    ) {
        let are_both_read = columns.force.is_some() && columns.displacement.is_some();
        let by_clock = if are_both_read {
            response_by_clock(self, turn_share)
        } else {
            None
        };
        let by_scatter = if are_both_read && by_clock.is_none() {
            response_by_scatter(self, turn_share)
        } else {
            None
        };
        self.response = stated.or(by_clock).or(by_scatter).unwrap_or_default();
        self.response_doubt = ResponseDoubt::about(self.response, by_clock);
        self.is_one_sweep = is_one_sweep(self);
        self.has_response = match self.response {
            ResponseVariable::Displacement => columns.displacement.is_some(),
            ResponseVariable::Force => columns.force.is_some(),
        };
        if stated.is_none() && are_both_read {
            self.assumptions.push(match (by_clock, by_scatter) {
                (Some(response), _) => {
                    let [set, answer] = response.set_and_answer();
                    format!(
                        "the {set} is a ramp or a sine of time, or of the order of the readings: it was set, and the {answer} is the response"
                    )
                }
                (None, Some(response)) => {
                    let [set, answer] = response.set_and_answer();
                    format!(
                        "the {answer} scatters more than the {set}, so it is taken for the response: the clock does not show what was set; state otherwise with --response {set}"
                    )
                }
                (None, None) => "loads were set and displacements measured: the table does not show which; state otherwise with --response force".to_owned(),
            });
        }
    }
}

/// Assigns branches run by run.
fn assign_branches(table: &mut SpecimenTable, turn_share: f64) {
    let mut of_run: Vec<Vec<usize>> = vec![Vec::new(); table.runs.len()];
    for (index, reading) in table.readings.iter().enumerate() {
        of_run[reading.run as usize].push(index);
    }
    let (mut turns, mut cycles, mut shuffled, mut line) = (0, 0, 0, None);
    let mut largest_share = turn_share;
    for indices in &of_run {
        let values: Vec<f64> = indices
            .iter()
            .map(|index| table.driver(&table.readings[*index]))
            .collect();
        let path = follow(&values, table.response.origin(&values), turn_share);
        turns += path.turns.len() as u32;
        cycles += path.cycles();
        largest_share = largest_share.max(path.turn_share);
        if path.shuffled {
            shuffled += 1;
            line = line.or_else(|| indices.first().map(|index| table.readings[*index].line));
        }
        for (index, branch) in indices.iter().zip(path.branches) {
            table.readings[*index].branch = branch;
        }
    }
    table.assumptions.push(format!(
        "branches are derived from the path: {} and {}, where a turn is a return by more than {} % of the run's range",
        counted(cycles, "cycle"),
        counted(turns, "turn"),
        (largest_share * 1e4).round() / 100.0
    ));
    table.assumptions.extend(line.map(|line| {
        format!(
            "in {}, the first from line {line}, the path turns in more than a third of the readings: taken as loads in shuffled order, all loading; add a branch column to change this",
            counted(shuffled, "run")
        )
    }));
}
