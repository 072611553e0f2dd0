//! The curve of a calibration table.

use crate::readings::{Conversion, TableError, line_of};
use crate::table_files::{FileRow, MachineTable, TableFileOptions, read_table_file};
use stiffbench_units_and_text::quantity::Kind;

/// Coverage factor of a row that states none; the usual one for 95 % (GUM 6.3.3).
const USUAL_K: f64 = 2.0;

/// A point of a certificate, N or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationPoint {
    /// The value of the standard.
    pub applied: f64,
    /// What the gauge showed.
    pub indicated: f64,
    /// Standard uncertainty U/k.
    pub standard_uncertainty: f64,
}

/// Applied values over indicated ones.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationCurve {
    /// The points, rising; with zero, where the table does not begin below it.
    points: Vec<CalibrationPoint>,
    /// Whether the curve of negative values is that of positive ones, turned: the table has one sign only.
    is_mirrored: bool,
}

impl CalibrationCurve {
    /// Reads a table with the columns applied, indicated, U and k.
    ///
    /// # Arguments
    /// - `kind`: force or displacement.
    ///
    /// # Errors
    /// [`TableError`] with the line of what is wrong.
    pub fn read(file: &str, bytes: &[u8], kind: Kind) -> Result<Self, TableError> {
        let table = read_table_file(file, bytes, &TableFileOptions::default())?;
        let applied = column(&table, "applied")?;
        let indicated = column(&table, "indicated")?;
        let expanded = column(&table, "U")?;
        let factor = column(&table, "k").ok();
        let units = [applied, indicated, expanded].map(|index| unit(&table, index, kind));
        let [of_applied, of_indicated, of_expanded] = units;
        let (of_applied, of_indicated, of_expanded) = (of_applied?, of_indicated?, of_expanded?);
        let mut points = Vec::new();
        for (row, FileRow { line, .. }) in table.rows.iter().enumerate() {
            let refused = |problem| {
                TableError::new(
                    "stiffbench::calibration_table::row",
                    format!("{}: {problem}", line_of(file, *line)),
                    "each row needs applied, indicated and U; k may be absent and is 2 then",
                )
            };
            let read = |index, conversion| {
                let value = table.number(row, index, conversion)?;
                value.ok_or_else(|| refused("a value is missing"))
            };
            let expanded = read(expanded, of_expanded)?;
            let k = match factor {
                Some(index) => table.number(row, index, Conversion::NONE)?,
                None => None,
            };
            let k = k.unwrap_or(USUAL_K);
            if expanded < 0.0 || k <= 0.0 {
                return Err(refused("U is below zero, or k is not above it"));
            }
            let point = CalibrationPoint {
                applied: read(applied, of_applied)?,
                indicated: read(indicated, of_indicated)?,
                standard_uncertainty: expanded / k,
            };
            points.push((*line, point));
        }
        Self::of_points(file, points)
    }

    fn of_points(file: &str, mut points: Vec<(u32, CalibrationPoint)>) -> Result<Self, TableError> {
        points.sort_by(|a, b| a.1.applied.total_cmp(&b.1.applied));
        if points.len() < 2 {
            return Err(TableError::new(
                "stiffbench::calibration_table::too_few",
                format!("{file}: fewer than two points"),
                "give at least two rows, or the uncertainty alone with --force-u or --displacement-u",
            ));
        }
        let falls = |pair: &&[(u32, CalibrationPoint)]| pair[1].1.indicated <= pair[0].1.indicated;
        if let Some(pair) = points.windows(2).find(falls) {
            return Err(TableError::new(
                "stiffbench::calibration_table::not_rising",
                format!(
                    "{}: the indicated value does not rise with the applied one",
                    line_of(file, pair[1].0)
                ),
                "give one row for each applied value, for example the mean of the series up",
            ));
        }
        let mut points: Vec<CalibrationPoint> =
            points.into_iter().map(|(_, point)| point).collect();
        count_from_zero(&mut points);
        let is_mirrored = points[0].applied >= 0.0 && points[0].indicated >= 0.0;
        if is_mirrored && points[0].indicated > 0.0 {
            // A gauge that was zeroed shows nothing of nothing.
            points.insert(
                0,
                CalibrationPoint {
                    applied: 0.0,
                    indicated: 0.0,
                    standard_uncertainty: points[0].standard_uncertainty,
                },
            );
        }
        Ok(Self {
            points,
            is_mirrored,
        })
    }

    /// The value behind an indication, N or m; beyond the table along its last line.
    #[must_use]
    pub fn corrected(&self, indicated: f64) -> f64 {
        if self.is_mirrored && indicated < 0.0 {
            return -self.corrected(-indicated);
        }
        let next = self
            .points
            .partition_point(|point| point.indicated < indicated);
        let next = next.clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[next - 1], self.points[next]);
        let share = (indicated - a.indicated) / (b.indicated - a.indicated);
        a.applied + share * (b.applied - a.applied)
    }

    /// The largest standard uncertainty of the points, N or m.
    #[must_use]
    pub fn standard_uncertainty(&self) -> f64 {
        let points = self.points.iter();
        points.fold(0.0, |largest, point| {
            largest.max(point.standard_uncertainty)
        })
    }

    /// Whether an indication lies beyond the table.
    #[must_use]
    pub fn is_beyond(&self, indicated: f64) -> bool {
        let size = if self.is_mirrored {
            indicated.abs()
        } else {
            indicated
        };
        let ends = self.points.first().zip(self.points.last());
        ends.is_none_or(|(first, last)| size < first.indicated || size > last.indicated)
    }
}

/// Takes the indication at zero load off all indications, where the table states it: readings count from the gauge zero, and so must the curve.
fn count_from_zero(points: &mut [CalibrationPoint]) {
    let at_zero = points.iter().find(|point| point.applied == 0.0);
    let Some(zero) = at_zero.map(|point| point.indicated) else {
        return;
    };
    for point in points {
        point.indicated -= zero;
    }
}

/// The column of a name, with or without a unit.
fn column(table: &MachineTable, name: &'static str) -> Result<usize, TableError> {
    let columns = &table.layout.columns;
    let found = columns
        .iter()
        .position(|column| column.stem.eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        TableError::new(
            "stiffbench::calibration_table::missing_column",
            format!("{}: no column `{name}`", table.header()),
            "a calibration table has the columns applied, indicated, U and k, with their units: applied_N, indicated_N, U_N, k",
        )
    })
}

fn unit(table: &MachineTable, index: usize, kind: Kind) -> Result<Conversion, TableError> {
    let column = &table.layout.columns[index];
    let unit = column.unit.as_deref();
    unit.and_then(|unit| Conversion::from_unit(kind, unit))
        .ok_or_else(|| {
            let quantity = if kind == Kind::Force {
                "force"
            } else {
                "displacement"
            };
            TableError::new(
                "stiffbench::calibration_table::unit",
                format!(
                    "{}, column `{}`: no unit of a {quantity}",
                    table.header(),
                    column.name
                ),
                format!("put the unit behind the name: known are {}", kind.units()),
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str =
        "applied_N,indicated_N,U_N,k\n20,20.2,0.1,2\n50,50.5,0.2,2\n100,102,0.3,2\n";

    #[test]
    fn values_lie_on_the_lines_between_points() {
        let curve = CalibrationCurve::read("c.csv", TABLE.as_bytes(), Kind::Force).unwrap();
        for (indicated, applied) in [
            (0.0, 0.0),
            (10.1, 10.0),
            (20.2, 20.0),
            (-50.5, -50.0),
            (102.0, 100.0),
            (112.3, 110.0),
        ] {
            assert!(
                (curve.corrected(indicated) - applied).abs() < 1e-9,
                "{indicated}"
            );
        }
        assert!((curve.standard_uncertainty() - 0.15).abs() < 1e-12);
        assert!(curve.is_beyond(-103.0) && !curve.is_beyond(-102.0));
    }

    #[test]
    fn an_indication_at_zero_load_is_the_zero_of_the_curve() {
        for zero in ["0.3", "-0.3"] {
            let text =
                format!("applied_N,indicated_N,U_N\n0,{zero},0.1\n10,10.3,0.1\n20,20.3,0.1\n");
            let curve = CalibrationCurve::read("c.csv", text.as_bytes(), Kind::Force).unwrap();
            let zero: f64 = zero.parse().unwrap();
            assert_eq!(curve.corrected(0.0), 0.0);
            // No dead band: a small reading of either sign keeps its size and sign.
            let small = 0.1 * 10.0 / (10.3 - zero);
            for (indicated, applied) in [(0.1, small), (-0.1, -small), (10.3 - zero, 10.0)] {
                let found = curve.corrected(indicated);
                assert!(
                    (found - applied).abs() < 1e-9,
                    "{zero}: {indicated} {found}"
                );
            }
            assert!(!curve.is_beyond(0.1) && !curve.is_beyond(-0.1));
        }
        // A table of both signs too.
        let text = "applied_N,indicated_N,U_N\n-10,-9.5,0.1\n0,0.5,0.1\n10,10.5,0.1\n";
        let curve = CalibrationCurve::read("c.csv", text.as_bytes(), Kind::Force).unwrap();
        assert!((curve.corrected(-10.0) + 10.0).abs() < 1e-9);
        assert!((curve.corrected(2.0) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn tables_that_cannot_be_are_refused_with_their_line() {
        let read = |text: &str| {
            let read = CalibrationCurve::read("c.csv", text.as_bytes(), Kind::Force);
            read.unwrap_err().to_string()
        };
        assert!(read("applied_N,U_N,k\n1,1,2\n2,1,2\n").contains("no column `indicated`"));
        assert!(read("applied_N,indicated_N,U_N\n1,1,0.1\n2,1,0.1\n").contains("line 3"));
        assert!(read("applied_mm,indicated_mm,U_mm\n1,1,0.1\n").contains("no unit of a force"));
        assert!(read("applied_N,indicated_N,U_N\n1,1,0.1\n").contains("fewer than two"));
        assert!(read("applied_N,indicated_N,U_N\n1,1,\n2,2,0.1\n").contains("line 2"));
    }
}
