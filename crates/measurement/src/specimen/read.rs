//! Reads a table of a specimen.

use std::io::Read;

use indexmap::IndexSet;

use super::assumption::{ExcludedLines, SpecimenAssumption};
use super::branches::follow;
use super::columns::SpecimenColumns;
use super::error::SpecimenError;
use super::options::{ResponseVariable, SpecimenOptions, TURN_SHARE};
use super::order::{put_in_order, time_goes_back};
use super::row::{SpecimenRow, SpecimenRowReader};
use super::table::{ColumnUnit, SpecimenReading, SpecimenRun, SpecimenTable};
use crate::table_files::{MachineTable, read_table_file};
use stiffbench_units_and_text::quantity::Kind;

/// Readings from a table whose columns the caller names.
///
/// The file may be anything that [`read_table_file`] reads. A row that lacks a value (an empty field, `NA`,
/// `N/A`, `NaN`, `null`) in a named column is left out and listed, but for time, hold and temperature, which may be absent.
///
/// # Arguments
/// - `source`: the name of the input, for messages.
/// - `input`: its bytes; read once, in pieces.
///
/// # Errors
/// [`SpecimenError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_specimen(
    source: &str,
    input: impl Read,
    options: &SpecimenOptions,
) -> Result<SpecimenTable, SpecimenError> {
    let turn_share = options.turn_share.unwrap_or(TURN_SHARE);
    if !(turn_share > 0.0 && turn_share < 1.0) {
        return Err(SpecimenError::BadTurnShare { share: turn_share });
    }
    let file = read_table_file(source, input, &options.of_file())?;
    let columns = SpecimenColumns::find(&file, options)?;
    let mut reader = SpecimenRowReader::new(&file, &columns);
    for row in 0..file.rows.len() {
        reader.take(row)?;
    }
    if reader.rows.is_empty() {
        return Err(SpecimenError::NoReadings {
            at: file.header(),
            incomplete: reader.incomplete.len(),
        });
    }
    let assumptions = assumptions_of_file(&file, &reader, &columns, options);
    let excluded = ExcludedLines {
        incomplete: std::mem::take(&mut reader.incomplete),
        blank: file.blank.clone(),
        comments: file.comments.clone(),
    };
    let mut found = reader.rows;
    let order = put_in_order(&mut found);
    let mut table = tabulate(&file, found, &columns, options);
    table.assumptions = assumptions;
    table.excluded = excluded;
    table.assumptions.extend(order);
    table.assumptions.extend(time_goes_back(&table.readings));
    if columns.branch.is_none() && columns.is_driven(options.response) {
        assign_branches(&mut table, turn_share);
    }
    Ok(table)
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
) -> Vec<SpecimenAssumption> {
    let mut all = vec![SpecimenAssumption::Layout(Box::new(file.layout.clone()))];
    if columns.force.is_none() && options.force_column.is_none() {
        all.push(SpecimenAssumption::ConstantLoad);
    }
    all.extend(columns.assumptions.iter().cloned());
    if columns.configuration.is_empty() {
        all.push(SpecimenAssumption::OneConfiguration);
    }
    if columns.run.is_empty() {
        all.push(SpecimenAssumption::OneRunEach);
    }
    all.extend(reader.absent());
    all
}

/// Numbers configurations and runs in the order in which they appear.
fn tabulate(
    file: &MachineTable,
    rows: Vec<SpecimenRow>,
    columns: &SpecimenColumns,
    options: &SpecimenOptions,
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
        response: options.response,
        force_unit: columns
            .force
            .as_ref()
            .map_or_else(|| ColumnUnit::si(Kind::Force), |force| force.unit.clone()),
        displacement_unit: columns
            .displacement
            .as_ref()
            .map_or_else(ColumnUnit::none, |column| column.unit.clone()),
        has_response: match options.response {
            ResponseVariable::Displacement => columns.displacement.is_some(),
            ResponseVariable::Force => columns.force.is_some(),
        },
        layout: file.layout.clone(),
        configurations: configurations.into_iter().collect(),
        runs: runs.into_iter().map(run).collect(),
        readings,
        assumptions: Vec::new(),
        excluded: ExcludedLines::default(),
        unused_columns: columns.unused.clone(),
    }
}

/// Assigns branches run by run.
///
/// A force counts from zero; a displacement, whose zero is arbitrary, from the first reading of the run.
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
        let origin = match table.response {
            ResponseVariable::Displacement => 0.0,
            ResponseVariable::Force => values.first().copied().unwrap_or(0.0),
        };
        let path = follow(&values, origin, turn_share);
        turns += path.turns;
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
    table
        .assumptions
        .push(SpecimenAssumption::BranchesFromPath {
            turn_share: largest_share,
            turns,
            cycles,
        });
    if let Some(line) = line {
        let runs = shuffled;
        table
            .assumptions
            .push(SpecimenAssumption::Shuffled { runs, line });
    }
}
