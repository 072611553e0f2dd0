//! Stiffness values that come without readings: a published table, or the displacements another program computed.
//!
//! Columns `pose`, `direction` and either `stiffness_N_per_um` (with `u_N_per_um`, its standard uncertainty, if known) or `force_N` and
//! `displacement_um`. Of a cell with several loads the stiffness is the slope of force on displacement through the origin: a computed
//! displacement has no zero error.

use indexmap::IndexMap;

use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use crate::readings::{Conversion, RecordTable, TableError};

/// The stiffness of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedStiffness {
    /// Line of its first row, from 1.
    pub line: u32,
    /// The cell.
    pub cell: Cell,
    /// Its stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Standard uncertainty as a share of it, if one is stated.
    pub relative_u: Option<f64>,
}

/// Columns of a list, by place.
struct ListColumns {
    pose: usize,
    direction: usize,
    form: ListForm,
}

#[derive(Clone, Copy)]
enum ListForm {
    Stiffness {
        value: usize,
        uncertainty: Option<usize>,
    },
    Displacement {
        force: usize,
        displacement: usize,
    },
}

/// Whether a table is a list of stiffness values, by its column names.
#[must_use]
pub fn is_stiffness_list(bytes: &[u8]) -> bool {
    let names = RecordTable::names_of(bytes);
    let has = |name: &str| names.iter().any(|column| column == name);
    has("stiffness_N_per_um") || (has("displacement_um") && !has("repeat"))
}

/// Reads a list of stiffness values. Delimiters, decimal signs and encodings are those of every table of this program.
///
/// # Errors
/// [`TableError`] with file and line.
pub fn read_stiffness_list(file: &str, input: &[u8]) -> Result<Vec<ListedStiffness>, TableError> {
    let mut text = RecordTable::open(file, input)?;
    let columns = columns(&text)?;
    let mut cells: IndexMap<Cell, CellSums> = IndexMap::new();
    while text.next_record()? {
        let field = text.field(columns.direction);
        let direction: Result<Direction, _> = text.text(field).parse();
        let direction = direction.map_err(|_| text.bad("direction", field, "x, y or z"))?;
        let pose = text.text(text.field(columns.pose)).into_owned();
        if pose.is_empty() {
            return Err(text.missing("pose", "the name of a pose"));
        }
        let cell = Cell::new(PoseId::new(&pose), direction);
        let sums = cells.entry(cell.clone()).or_insert(CellSums {
            line: text.line,
            ..CellSums::default()
        });
        sums.add(&mut text, columns.form, &cell)?;
    }
    if cells.is_empty() {
        return Err(text.no_readings());
    }
    let listed = cells.into_iter().map(|(cell, sums)| ListedStiffness {
        line: sums.line,
        cell,
        stiffness_n_per_m: sums.force_displacement / sums.displacement_squared,
        relative_u: sums.relative_u,
    });
    Ok(listed.collect())
}

fn columns(text: &RecordTable<'_>) -> Result<ListColumns, TableError> {
    let find = |name: &str| text.names.iter().position(|column| column == name);
    let missing = |expected| {
        TableError::new(
            "stiffbench::fit::stiffness_list_columns",
            format!(
                "{}: the columns are {}; a list of stiffness values needs {expected}",
                text.file(),
                text.names.join(", ")
            ),
            "pose, direction and stiffness_N_per_um; or pose, direction, force_N and displacement_um",
        )
    };
    let form = match (
        find("stiffness_N_per_um"),
        find("force_N"),
        find("displacement_um"),
    ) {
        (Some(value), _, _) => ListForm::Stiffness {
            value,
            uncertainty: find("u_N_per_um"),
        },
        (None, Some(force), Some(displacement)) => ListForm::Displacement {
            force,
            displacement,
        },
        _ => {
            return Err(missing(
                "stiffness_N_per_um, or force_N and displacement_um",
            ));
        }
    };
    Ok(ListColumns {
        pose: find("pose").ok_or_else(|| missing("pose"))?,
        direction: find("direction").ok_or_else(|| missing("direction"))?,
        form,
    })
}

/// A number in a column.
fn number(
    text: &mut RecordTable<'_>,
    index: usize,
    conversion: Conversion,
) -> Result<f64, TableError> {
    let number = text.number(index, conversion)?;
    number.ok_or_else(|| text.missing(&text.names[index], "a number"))
}

/// A number above zero.
fn positive(
    text: &mut RecordTable<'_>,
    index: usize,
    conversion: Conversion,
) -> Result<f64, TableError> {
    let value = number(text, index, conversion)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(text.bad(&text.names[index], text.field(index), "a number above zero"))
}

/// Σ F δ and Σ δ² of a cell; a stated stiffness counts as one displacement of 1 m.
#[derive(Default)]
struct CellSums {
    /// Line of the first row.
    line: u32,
    force_displacement: f64,
    displacement_squared: f64,
    relative_u: Option<f64>,
}

impl CellSums {
    fn add(
        &mut self,
        text: &mut RecordTable<'_>,
        form: ListForm,
        cell: &Cell,
    ) -> Result<(), TableError> {
        const NEWTON_PER_MICROMETRE: Conversion = Conversion::Shift(6);
        const MICROMETRE: Conversion = Conversion::Shift(-6);
        match form {
            ListForm::Stiffness { value, uncertainty } => {
                if self.displacement_squared > 0.0 {
                    return Err(TableError::new(
                        "stiffbench::fit::stiffness_list_duplicate",
                        format!("{}: {cell} has a stiffness already", text.at(text.line)),
                        "keep one row a cell, or give force and displacement",
                    ));
                }
                self.force_displacement = positive(text, value, NEWTON_PER_MICROMETRE)?;
                self.displacement_squared = 1.0;
                if let Some(index) = uncertainty {
                    let u = positive(text, index, NEWTON_PER_MICROMETRE)?;
                    self.relative_u = Some(u / self.force_displacement);
                }
            }
            ListForm::Displacement {
                force,
                displacement,
            } => {
                let force_n = number(text, force, Conversion::NONE)?;
                let displacement_m = number(text, displacement, MICROMETRE)?;
                if force_n == 0.0 && displacement_m == 0.0 {
                    return Ok(());
                }
                if force_n * displacement_m <= 0.0 {
                    let expected = "a displacement in the sense of the force";
                    let field = text.field(displacement);
                    return Err(text.bad("displacement_um", field, expected));
                }
                self.force_displacement += force_n * displacement_m;
                self.displacement_squared += displacement_m * displacement_m;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<ListedStiffness>, TableError> {
        read_stiffness_list("k.csv", text.as_bytes())
    }

    #[test]
    fn stiffness_with_and_without_uncertainty() {
        let list = read("pose,direction,stiffness_N_per_um\nP1,x,0.00902\nP1,y,0.02698\n").unwrap();
        assert_eq!(list[0].relative_u, None);
        assert!((list[1].stiffness_n_per_m - 26980.0).abs() < 1e-9);
        let list =
            read("pose;direction;stiffness_N_per_um;u_N_per_um\nP1;x;0,01;0,0001\n").unwrap();
        assert!((list[0].relative_u.unwrap() - 0.01).abs() < 1e-15);
    }

    #[test]
    fn displacements_of_several_loads_give_one_stiffness() {
        // Table IV of the paper, lateral, finite elements: 50 N/2622 um to 500 N/26134 um.
        let text = "pose,direction,force_N,displacement_um\nP1,x,-50,-2622\nP1,x,-100,-5240.9\nP1,x,-300,-15698\nP1,x,-500,-26134\n";
        let list = read(text).unwrap();
        let k = list[0].stiffness_n_per_m;
        assert!((50.0 / 2622e-6..500.0 / 26134e-6).contains(&k), "{k}");
    }

    #[test]
    fn each_mistake_is_reported_with_its_line() {
        let error = |text: &str| read(text).unwrap_err().to_string();
        assert!(error("pose,K\n").contains("the columns are pose, K"));
        let stiffness = |row: &str| error(&format!("pose,direction,stiffness_N_per_um\n{row}\n"));
        assert!(stiffness("P1,w,1").contains("k.csv, line 2, column `direction`: `w`"));
        assert!(
            stiffness("P1,x,1\nP1,x,2").contains("k.csv, line 3: P1 x has a stiffness already")
        );
        assert!(stiffness("P1,x,0").contains("expected a number above zero"));
        assert!(stiffness("P1,x,nan").contains("is not a finite number"));
        assert!(stiffness("P1,x,").contains("column `stiffness_N_per_um`"));
        assert!(
            error("pose,direction,force_N,displacement_um\nP1,x,-50,3\n")
                .contains("in the sense of the force")
        );
        assert!(stiffness("").contains("no reading follows the header"));
        assert!(stiffness("P1,x").contains("line 2"));
    }
}
