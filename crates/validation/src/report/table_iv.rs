//! Table IV as printed: the single-pose model beside its reference, load by load.

use stiffbench::test_point::Direction;

use stiffbench::report::paper::{Printed, direction, printed_rows};

/// Elements of the models of Table IV.
const CELLS: &str = include_str!("../../../../data/paper/cells.csv");

/// The paper's Table IV as printed.
#[derive(Debug)]
pub(crate) struct PaperTableIv {
    /// Elements of the reference and of the fitted beams.
    pub(crate) cells: [usize; 2],
    rows: Vec<PaperRow>,
}

/// Its numbers for one load.
#[derive(Debug)]
pub(crate) struct PaperRow {
    direction: Direction,
    force_n: f64,
    pub(crate) difference_percent: f64,
    pub(crate) reference_s: f64,
    pub(crate) fitted_s: f64,
    /// Of the reference's time, as printed.
    time_percent: f64,
}

impl PaperTableIv {
    /// The table, from the transcription.
    pub(crate) fn printed() -> Self {
        let count = |model: &str| {
            CELLS
                .lines()
                .find_map(|line| line.strip_prefix(model)?.split(',').nth(1)?.parse().ok())
                .unwrap_or(0)
        };
        let rows: Vec<Printed> = printed_rows()
            .into_iter()
            .filter(|row| row.table == "IV")
            .collect();
        let of_reference = rows
            .iter()
            .filter(|row| row.mechanism_or_model == "non-FSD" && row.unit == "um");
        Self {
            cells: [count("non-FSD"), count("S-FSD")],
            rows: of_reference
                .filter_map(|row| PaperRow::of(row, &rows))
                .collect(),
        }
    }

    /// The printed numbers for a load, if the table has it.
    pub(crate) fn row(&self, direction: Direction, force_n: f64) -> Option<&PaperRow> {
        // The printed loads are whole newtons.
        let same =
            |row: &&PaperRow| row.direction == direction && (row.force_n - force_n).abs() < 1e-9;
        self.rows.iter().find(same)
    }

    /// Largest difference of the fitted model from its reference, percent.
    pub(crate) fn largest_percent(&self) -> f64 {
        let sizes = self.rows.iter().map(|row| row.difference_percent.abs());
        sizes.fold(0.0, f64::max)
    }

    /// Fewest percent of the reference's time that the fitted model saves.
    pub(crate) fn time_saved_percent(&self) -> f64 {
        let shares = self.rows.iter().map(|row| row.time_percent);
        100.0 - shares.fold(0.0, f64::max)
    }
}

impl PaperRow {
    /// The numbers for the load of one row of displacements, `displacement at -50 N`.
    fn of(row: &Printed, all: &[Printed]) -> Option<Self> {
        let load = row.quantity.split(" at ").nth(1)?;
        let of = |model: &str, quantity: String| {
            let mut rows = all.iter();
            rows.find(|other| {
                other.mechanism_or_model == model
                    && other.physical_direction == row.physical_direction
                    && other.quantity == quantity
            })
            .map(|other| other.value)
        };
        let time = format!("computing time at {load}");
        Some(Self {
            direction: direction(&row.physical_direction)?,
            force_n: load.strip_suffix(" N")?.parse().ok()?,
            difference_percent: of("S-FSD/non-FSD", format!("{}, ratio", row.quantity))? - 100.0,
            reference_s: of("non-FSD", time.clone())?,
            fitted_s: of("S-FSD (single pose)", time.clone())?,
            time_percent: of("S-FSD/non-FSD", format!("{time}, ratio"))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_states_what_its_table_has() {
        // Section IV-A: 1,261,386 cells, at least 99.32 % less time, at most 0.61 % difference.
        let paper = PaperTableIv::printed();
        assert_eq!(paper.cells, [1_261_386, 36]);
        assert_eq!(paper.rows.len(), 12);
        assert!((paper.time_saved_percent() - 99.32).abs() < 1e-9);
        assert!((paper.largest_percent() - 0.61).abs() < 1e-9);
    }
}
