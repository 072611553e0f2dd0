//! The uncertainty of ln K split into what each cell has for itself and what cells share through their gauges.

use stiffbench_units_and_text::test_point::Cell;

/// Standard uncertainty of ln K of one cell in three parts, each relative (1).
///
/// A calibration error is the same for all readings of a gauge: repeats do not reduce it, and it moves all cells together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LnParts {
    /// Everything that other cells do not share; `None` if scatter could not be seen.
    pub independent: Option<f64>,
    /// Degrees of freedom of `independent`.
    pub independent_dof: f64,
    /// From the calibration of the force gauge; zero if it is not stated.
    pub force_calibration: f64,
    /// From the calibration of the displacement gauge; zero if it is not stated.
    pub displacement_calibration: f64,
}

/// Covariance of ln K between cells measured with the same two gauges: V = diag(i²) + f fᵀ + d dᵀ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LnStiffnessCovariance {
    /// Row and column of the matrix: the cells with an uncertainty.
    pub cells: Vec<Cell>,
    /// i: standard uncertainty of each cell's own part, relative.
    pub independent: Vec<f64>,
    /// f: effect of one standard uncertainty of the force gauge's calibration on each cell, relative.
    pub force_calibration: Vec<f64>,
    /// d: effect of one standard uncertainty of the displacement gauge's calibration on each cell, relative.
    pub displacement_calibration: Vec<f64>,
    /// Cells without a stiffness or without an uncertainty; they are in no row.
    pub left_out: Vec<Cell>,
}

impl LnStiffnessCovariance {
    /// The structure over `cells`; a cell without parts is listed in `left_out`.
    pub(super) fn new<'a>(cells: impl Iterator<Item = (&'a Cell, Option<LnParts>)>) -> Self {
        let mut covariance = Self::default();
        for (cell, parts) in cells {
            match parts.and_then(|parts| Some((parts, parts.independent?))) {
                Some((parts, independent)) => {
                    covariance.cells.push(cell.clone());
                    covariance.independent.push(independent);
                    covariance.force_calibration.push(parts.force_calibration);
                    let displacement = parts.displacement_calibration;
                    covariance.displacement_calibration.push(displacement);
                }
                None => covariance.left_out.push(cell.clone()),
            }
        }
        covariance
    }

    /// Covariance of ln K of cells `i` and `j` (1), places in `cells`; `None` beyond them.
    #[must_use]
    pub fn entry(&self, i: usize, j: usize) -> Option<f64> {
        let own = if i == j {
            self.independent.get(i)?.powi(2)
        } else {
            0.0
        };
        let force = self.force_calibration.get(i)? * self.force_calibration.get(j)?;
        let displacement =
            self.displacement_calibration.get(i)? * self.displacement_calibration.get(j)?;
        Some(own + force + displacement)
    }

    /// The whole matrix, row by row: cells × cells, symmetric.
    #[must_use]
    pub fn matrix(&self) -> Vec<Vec<f64>> {
        let n = self.cells.len();
        (0..n)
            .map(|i| (0..n).filter_map(|j| self.entry(i, j)).collect())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_units_and_text::test_point::{Direction, PoseId};

    fn cell(direction: Direction) -> Cell {
        Cell::new(PoseId::new("P1"), direction)
    }

    #[test]
    fn calibration_correlates_cells_and_a_cell_without_scatter_is_listed() {
        let parts = |independent, force_calibration, displacement_calibration| LnParts {
            independent,
            independent_dof: 4.0,
            force_calibration,
            displacement_calibration,
        };
        let cells = [cell(Direction::X), cell(Direction::Y), cell(Direction::Z)];
        let of_cells = [
            Some(parts(Some(0.03), 0.01, 0.02)),
            Some(parts(Some(0.04), 0.01, 0.05)),
            Some(parts(None, 0.01, 0.05)),
        ];
        let covariance = LnStiffnessCovariance::new(cells.iter().zip(of_cells));
        assert_eq!(covariance.left_out, [cell(Direction::Z)]);
        let expected = [[0.0014, 0.0011], [0.0011, 0.0042]];
        for (row, expected) in covariance.matrix().iter().zip(expected) {
            for (entry, expected) in row.iter().zip(expected) {
                assert!((entry - expected).abs() < 1e-15);
            }
        }
        assert_eq!(covariance.entry(0, 2), None);
    }
}
