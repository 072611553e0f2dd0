//! Forces and displacements in SI.

use super::columns::{ColumnRole, ImportedQuantity};
use super::draft::ImportDraft;
use super::note::ImportNotes;
use super::values::no_value;
use crate::readings::{Conversion, TableError};
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::quantity::Kind;

/// Forces and displacements in SI of the rows that have both, and which rows these are.
pub(super) fn measured(
    draft: &ImportDraft,
    notes: &mut ImportNotes,
) -> Result<(Vec<usize>, Vec<[f64; 2]>), TableError> {
    let (force, forces) = column(draft, ImportedQuantity::Force)?;
    let displacements = if let Some(log) = &draft.log {
        let time = draft.found.place(&ColumnRole::Time);
        let sign = draft.mapping.sign(ImportedQuantity::Displacement);
        let paired = log.displacements_m(&draft.table, time, notes)?;
        paired
            .into_iter()
            .map(|value| Some(sign * value?))
            .collect()
    } else {
        let (column, values) = column(draft, ImportedQuantity::Displacement)?;
        refuse_half_rows(draft, [force, column], [&forces, &values])?;
        values
    };
    let mut rows = Vec::new();
    let mut values = Vec::new();
    let (mut left_out, mut first) = (0, 0);
    for (row, pair) in forces.iter().zip(&displacements).enumerate() {
        if let (Some(force), Some(displacement)) = pair {
            rows.push(row);
            values.push([*force, *displacement]);
        } else {
            left_out += 1;
            if first == 0 {
                first = draft.table.rows[row].line;
            }
        }
    }
    if left_out > 0 {
        let what = match draft.log {
            Some(_) => format!(
                "{} outside the times of the displacements or in a gap of them",
                counted(left_out, "force")
            ),
            None => format!(
                "{} without force and displacement",
                counted(left_out, "row")
            ),
        };
        notes.note(format!("left out: {what}, first in line {first}"));
    }
    if rows.is_empty() {
        let at = draft.table.header();
        return Err(TableError::new(
            "stiffbench::import::no_rows",
            format!("{at}: no row has a force and a displacement"),
            "rows of numbers must follow the names of the columns",
        ));
    }
    refuse_all_zero(draft, &values)?;
    for quantity in ImportedQuantity::ALL {
        let column = draft.found.place(&quantity.role());
        if let Some(doubt) =
            column.and_then(|column| unit_over_file(draft, column, quantity.kind()))
        {
            notes.doubt(doubt);
        }
    }
    for quantity in ImportedQuantity::ALL {
        if draft.mapping.flip.contains(&quantity) {
            notes.note(format!("the sign of every {quantity} was reversed"));
        }
    }
    Ok((rows, values))
}

/// A note on a unit that was stated over another of the file.
fn unit_over_file(draft: &ImportDraft, column: usize, kind: Kind) -> Option<String> {
    let of_file = draft.table.layout.columns[column].unit.as_ref()?;
    let unit = draft.unit(column, kind)?;
    let [known, stated] = [of_file, &unit].map(|unit| Conversion::from_unit(kind, unit));
    (known.is_some() && known != stated).then(|| {
        format!(
            "the file states {of_file} for column `{}`, and the options or the mapping {unit}: {unit} is used",
            draft.name(column)
        )
    })
}

/// A column in SI.
fn column(
    draft: &ImportDraft,
    quantity: ImportedQuantity,
) -> Result<(usize, Vec<Option<f64>>), TableError> {
    let column = draft.found.place(&quantity.role()).unwrap_or(0);
    let conversion = draft.conversion(column, quantity.kind());
    let sign = draft.mapping.sign(quantity);
    let mut values = draft.table.numbers_in(column, conversion)?;
    values.iter_mut().flatten().for_each(|value| *value *= sign);
    Ok((column, values))
}

/// A row with one of its two values, or with a word for none, is damaged.
fn refuse_half_rows(
    draft: &ImportDraft,
    columns: [usize; 2],
    values: [&[Option<f64>]; 2],
) -> Result<(), TableError> {
    for row in 0..draft.table.rows.len() {
        for side in 0..2 {
            let word = !draft.table.text(row, columns[side]).is_empty();
            let half = values[1 - side][row].is_some();
            if values[side][row].is_none() && (half || word) {
                return Err(no_value(draft, row, columns[side]));
            }
        }
    }
    Ok(())
}

fn refuse_all_zero(draft: &ImportDraft, values: &[[f64; 2]]) -> Result<(), TableError> {
    for (side, quantity) in ImportedQuantity::ALL.into_iter().enumerate() {
        if values.iter().any(|pair| pair[side] != 0.0) {
            continue;
        }
        let column = draft.found.place(&quantity.role());
        let column = column.map_or("displacement", |index| draft.name(index));
        let table = &draft.table;
        return Err(TableError::new(
            "stiffbench::import::all_zero",
            format!(
                "{}, lines {} to {}, column `{column}`: all values are 0",
                table.source, table.layout.first_line, table.layout.last_line
            ),
            format!("the gauge was not recorded: name another column with --map {quantity}=COLUMN"),
        ));
    }
    Ok(())
}
