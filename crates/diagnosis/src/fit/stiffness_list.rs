//! Stiffness values that come without readings: a published table, or the displacements another program computed.
//!
//! Columns `pose`, `direction` and either `stiffness_N_per_um` (with `u_N_per_um`, its standard uncertainty, if known) or `force_N` and
//! `displacement_um`. Of a cell with several loads the stiffness is the slope of force on displacement through the origin: a computed
//! displacement has no zero error.

use std::collections::BTreeMap;

use stiffbench_units_and_text::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE,
};
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use super::measured::{LnUncertainty, MeasuredCell, MeasuredStiffness, WeightBasis};

/// Why a list of stiffness values cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StiffnessListError {
    /// Neither of the two forms.
    #[error("{file}: the columns are {found}; a list of stiffness values needs {expected}")]
    #[diagnostic(
        code(stiffbench::fit::stiffness_list_columns),
        help(
            "pose, direction and stiffness_N_per_um; or pose, direction, force_N and displacement_um"
        )
    )]
    Columns {
        /// Name of the file.
        file: String,
        /// The columns it has.
        found: String,
        /// What is missing.
        expected: &'static str,
    },
    /// A field that is not what its column holds.
    #[error("{file}:{line}: {column} is `{value}`, expected {expected}")]
    #[diagnostic(
        code(stiffbench::fit::stiffness_list_value),
        help("correct this field; nothing of the file was used")
    )]
    Value {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Column name.
        column: &'static str,
        /// What stands there.
        value: String,
        /// What should.
        expected: &'static str,
    },
    /// A row with too many or too few fields, or text that is not UTF-8.
    #[error("{file}:{line}: not a row of the table")]
    #[diagnostic(code(stiffbench::fit::stiffness_list_csv))]
    Csv {
        /// Name of the file.
        file: String,
        /// Line of the row, from 1.
        line: u64,
        /// What the CSV reader says.
        #[source]
        source: csv::Error,
    },
    /// A cell with two stiffness values.
    #[error("{file}:{line}: {cell} has a stiffness already")]
    #[diagnostic(
        code(stiffbench::fit::stiffness_list_duplicate),
        help("keep one row a cell, or give force and displacement")
    )]
    Duplicate {
        /// Name of the file.
        file: String,
        /// Line of the second.
        line: u64,
        /// The cell.
        cell: Cell,
    },
    /// No rows.
    #[error("{file} has no rows")]
    #[diagnostic(code(stiffbench::fit::stiffness_list_empty))]
    Empty {
        /// Name of the file.
        file: String,
    },
}

/// Columns of a list, by place.
struct ListColumns {
    pose: usize,
    direction: usize,
    form: ListForm,
}

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

/// Whether a header line is that of a list of stiffness values (and not of readings).
#[must_use]
pub fn is_stiffness_list(header: &str) -> bool {
    let has = |name: &str| header.split(',').any(|column| column.trim() == name);
    has("stiffness_N_per_um") || (has("displacement_um") && !has("repeat"))
}

/// Reads a list of stiffness values.
///
/// # Errors
/// [`StiffnessListError`] with file and line.
pub fn read_stiffness_list(
    file: &str,
    text: &str,
) -> Result<MeasuredStiffness, StiffnessListError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let failed = |source: csv::Error| StiffnessListError::Csv {
        file: file.to_owned(),
        line: source.position().map_or(1, csv::Position::line),
        source,
    };
    let columns = columns(file, reader.headers().map_err(failed)?)?;
    let mut sums: Vec<(Cell, CellSums)> = Vec::new();
    let mut places: BTreeMap<Cell, usize> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(failed)?;
        let row = ListRow {
            file,
            line: record.position().map_or(0, csv::Position::line),
            record: &record,
        };
        let direction: Direction = record[columns.direction]
            .parse()
            .map_err(|_| row.error("direction", columns.direction, "x, y or z"))?;
        let cell = Cell::new(PoseId::new(&record[columns.pose]), direction);
        if cell.pose.as_str().is_empty() {
            return Err(row.error("pose", columns.pose, "the name of a pose"));
        }
        let place = *places.entry(cell.clone()).or_insert_with(|| {
            let line = u32::try_from(row.line).unwrap_or_default();
            let first = CellSums {
                line,
                ..CellSums::default()
            };
            sums.push((cell.clone(), first));
            sums.len() - 1
        });
        sums[place].1.add(&row, &columns.form, &cell)?;
    }
    if sums.is_empty() {
        return Err(StiffnessListError::Empty {
            file: file.to_owned(),
        });
    }
    let stated = sums.iter().all(|(_, sums)| sums.ln_uncertainty.is_some());
    let measured = |(cell, sums): (Cell, CellSums)| MeasuredCell {
        cell,
        line: sums.line,
        stiffness_n_per_m: sums.force_displacement / sums.displacement_squared,
        ln_uncertainty: sums
            .ln_uncertainty
            .filter(|_| stated)
            .map(|own| LnUncertainty {
                own,
                ..LnUncertainty::default()
            }),
        reading_noise: None,
    };
    Ok(MeasuredStiffness {
        cells: sums.into_iter().map(measured).collect(),
        basis: if stated {
            WeightBasis::Stated
        } else {
            WeightBasis::Equal
        },
        ..MeasuredStiffness::default()
    })
}

fn columns(file: &str, header: &csv::StringRecord) -> Result<ListColumns, StiffnessListError> {
    let find = |name: &str| header.iter().position(|column| column == name);
    let missing = |expected| StiffnessListError::Columns {
        file: file.to_owned(),
        found: header.iter().collect::<Vec<_>>().join(", "),
        expected,
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

/// One row with its place, for messages.
struct ListRow<'a> {
    file: &'a str,
    line: u64,
    record: &'a csv::StringRecord,
}

impl ListRow<'_> {
    fn error(
        &self,
        column: &'static str,
        place: usize,
        expected: &'static str,
    ) -> StiffnessListError {
        StiffnessListError::Value {
            file: self.file.to_owned(),
            line: self.line,
            column,
            value: self.record.get(place).unwrap_or("").to_owned(),
            expected,
        }
    }

    fn number(&self, column: &'static str, place: usize) -> Result<f64, StiffnessListError> {
        let value: Option<f64> = self.record.get(place).and_then(|text| text.parse().ok());
        value
            .filter(|value| value.is_finite())
            .ok_or_else(|| self.error(column, place, "a number with a decimal point"))
    }
}

/// Σ F δ and Σ δ² of a cell; a stated stiffness counts as one displacement of 1 m.
#[derive(Default)]
struct CellSums {
    /// Line of the first row.
    line: u32,
    force_displacement: f64,
    displacement_squared: f64,
    ln_uncertainty: Option<f64>,
}

impl CellSums {
    fn add(
        &mut self,
        row: &ListRow<'_>,
        form: &ListForm,
        cell: &Cell,
    ) -> Result<(), StiffnessListError> {
        match *form {
            ListForm::Stiffness { value, uncertainty } => {
                if self.displacement_squared > 0.0 {
                    return Err(StiffnessListError::Duplicate {
                        file: row.file.to_owned(),
                        line: row.line,
                        cell: cell.clone(),
                    });
                }
                let stiffness = row.number("stiffness_N_per_um", value)?;
                if stiffness <= 0.0 {
                    return Err(row.error("stiffness_N_per_um", value, "a stiffness above zero"));
                }
                self.force_displacement = stiffness * NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
                self.displacement_squared = 1.0;
                if let Some(place) = uncertainty {
                    let u = row.number("u_N_per_um", place)?;
                    if u <= 0.0 {
                        return Err(row.error(
                            "u_N_per_um",
                            place,
                            "a standard uncertainty above zero",
                        ));
                    }
                    self.ln_uncertainty = Some(u / stiffness);
                }
            }
            ListForm::Displacement {
                force,
                displacement,
            } => {
                let force_n = row.number("force_N", force)?;
                let displacement_m =
                    row.number("displacement_um", displacement)? * METRES_PER_MICROMETRE;
                if force_n == 0.0 && displacement_m == 0.0 {
                    return Ok(());
                }
                if force_n * displacement_m <= 0.0 {
                    return Err(row.error(
                        "displacement_um",
                        displacement,
                        "a displacement in the sense of the force",
                    ));
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

    #[test]
    fn stiffness_with_and_without_uncertainty() {
        let list = read_stiffness_list(
            "k.csv",
            "pose,direction,stiffness_N_per_um\nP1,x,0.00902\nP1,y,0.02698\n",
        )
        .unwrap();
        assert_eq!(list.basis, WeightBasis::Equal);
        assert!((list.cells[1].stiffness_n_per_m - 26980.0).abs() < 1e-9);
        let list = read_stiffness_list(
            "k.csv",
            "pose,direction,stiffness_N_per_um,u_N_per_um\nP1,x,0.01,0.0001\n",
        )
        .unwrap();
        assert!((list.cells[0].ln_uncertainty.unwrap().own - 0.01).abs() < 1e-15);
    }

    #[test]
    fn displacements_of_several_loads_give_one_stiffness() {
        // Table IV of the paper, lateral, finite elements: 50 N/2622 um to 500 N/26134 um.
        let text = "pose,direction,force_N,displacement_um\nP1,x,-50,-2622\nP1,x,-100,-5240.9\nP1,x,-300,-15698\nP1,x,-500,-26134\n";
        let list = read_stiffness_list("t4.csv", text).unwrap();
        let k = list.cells[0].stiffness_n_per_m;
        assert!((50.0 / 2622e-6..500.0 / 26134e-6).contains(&k), "{k}");
    }

    #[test]
    fn each_mistake_is_reported_with_its_line() {
        let error = |text: &str| read_stiffness_list("k.csv", text).unwrap_err().to_string();
        assert!(error("pose,K\n").contains("the columns are pose, K"));
        assert!(
            error("pose,direction,stiffness_N_per_um\nP1,w,1\n")
                .contains("k.csv:2: direction is `w`")
        );
        assert!(
            error("pose,direction,stiffness_N_per_um\nP1,x,1\nP1,x,2\n")
                .contains("k.csv:3: P1 x has a stiffness already")
        );
        assert!(
            error("pose,direction,stiffness_N_per_um\nP1,x,0\n")
                .contains("expected a stiffness above zero")
        );
        assert!(
            error("pose,direction,stiffness_N_per_um\nP1,x,nan\n").contains("expected a number")
        );
        assert!(
            error("pose,direction,force_N,displacement_um\nP1,x,-50,3\n")
                .contains("in the sense of the force")
        );
        assert!(error("pose,direction,stiffness_N_per_um\n").contains("has no rows"));
        assert!(error("pose,direction,stiffness_N_per_um\nP1,x\n").contains("k.csv:2: not a row"));
    }
}
