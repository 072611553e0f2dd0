//! Compliance along each base axis of readings of several displacement gauges.

use indexmap::{IndexMap, IndexSet};
use stiffbench_numeric::statistics::{Estimate, LeastSquaresLine, mean, standard_deviation};
use stiffbench_units_and_text::test_point::PoseId;

use super::curve::Branches;
use crate::readings::{Reading, ReadingTable};

/// Components of a unit vector below this are none.
const NO_COMPONENT: f64 = 1e-9;

/// Compliance of the end in one pose under a load in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorStiffness {
    /// The pose held.
    pub pose: PoseId,
    /// Name of the direction of the load.
    pub direction: String,
    /// The direction, a unit vector along the base axes.
    pub unit: [f64; 3],
    /// Number of runs.
    pub runs: usize,
    /// Number of readings.
    pub readings: usize,
    /// Largest load in size, N.
    pub largest_n: f64,
    /// Displacement along x, y, z per force along the load, m/N: the slope of each run over its readings, averaged over the runs; `None`
    /// along an axis that was not read, or without two different loads.
    pub compliance_m_per_n: [Option<Estimate>; 3],
    /// The same along the load; `None` where the load has a component along an axis that was not read.
    pub along_m_per_n: Option<Estimate>,
    /// Displacement along x, y, z at the largest load per that load from the zero of the gauges, m/N, averaged over the runs.
    pub at_largest_m_per_n: [Option<Estimate>; 3],
}

/// Force along the load and displacement of a reading.
type ForcePoint = (f64, f64);

/// Compliances of every pose and direction, in the order in which they first appear.
///
/// The uncertainty is that of the scatter between runs, u = s/√n with n - 1 degrees of freedom; of a single run that of its residuals about
/// the line, n - 2. The calibration of the gauges is not in it.
///
/// # Arguments
/// - `preload_n`: force along the load at which the displacement gauges were zeroed, N.
#[must_use]
pub fn vector_stiffness(
    table: &ReadingTable,
    branches: Branches,
    preload_n: f64,
) -> Vec<VectorStiffness> {
    let mut groups: IndexMap<(&PoseId, String), Vec<&[Reading]>> = IndexMap::new();
    for load in table.loads() {
        let first = &load[0];
        if first.is_accepted() && branches.include(first.branch) {
            let cell = (&first.pose, table.load_name(first));
            groups.entry(cell).or_default().push(load);
        }
    }
    groups
        .into_iter()
        .filter_map(|((_, name), group)| of_group(table, name, &group, preload_n))
        .collect()
}

/// `None` for a group whose forces are all zero.
fn of_group(
    table: &ReadingTable,
    name: String,
    group: &[&[Reading]],
    preload_n: f64,
) -> Option<VectorStiffness> {
    let unit = table.load_direction(&group[0][0]).unit_vector();
    let sizes = group.iter().map(|load| load[0].force_n.abs());
    let largest_n = sizes.fold(0.0, f64::max);
    if largest_n == 0.0 {
        return None;
    }
    let displacement_m = |load: &[Reading], axis: usize| {
        let mut gauges = load.iter();
        let gauge = gauges.find(|reading| reading.direction.index() == axis)?;
        Some(gauge.displacement_m)
    };
    let largest_target =
        group
            .iter()
            .map(|load| load[0].target_n)
            .fold(0.0, |most: f64, target| {
                if target.abs() > most.abs() {
                    target
                } else {
                    most
                }
            });
    // A zero that was set anew within a run begins a line of its own.
    let label = |load: &[Reading]| {
        let zero = table.zeros.get(load[0].zero as usize);
        (load[0].run, zero.and_then(|zero| zero.label.as_deref()))
    };
    let labels: IndexSet<_> = group.iter().map(|load| label(load)).collect();
    let runs = |of: &dyn Fn(&[Reading]) -> Option<f64>| -> Vec<Vec<ForcePoint>> {
        let of_run = |named: &(u32, Option<&str>)| {
            let run = group.iter().filter(|load| label(load) == *named);
            run.filter_map(|load| Some((load[0].force_n, of(load)?)))
                .collect()
        };
        labels.iter().map(of_run).collect()
    };
    let axis = |axis: usize| move |load: &[Reading]| displacement_m(load, axis);
    let along = |load: &[Reading]| {
        let parts = (0..3).map(|axis| {
            if unit[axis].abs() < NO_COMPONENT {
                Some(0.0)
            } else {
                displacement_m(load, axis).map(|part_m| unit[axis] * part_m)
            }
        });
        parts.sum::<Option<f64>>()
    };
    let at_largest = |number: usize| {
        let at = group
            .iter()
            .filter(|load| load[0].target_n == largest_target);
        let ratios: Vec<f64> = at
            .filter_map(|load| {
                let from_zero_n = load[0].force_n - preload_n;
                Some(displacement_m(load, number)? / from_zero_n)
            })
            .filter(|ratio| ratio.is_finite())
            .collect();
        averaged(&ratios)
    };
    Some(VectorStiffness {
        pose: group[0][0].pose.clone(),
        direction: name,
        unit,
        runs: labels.len(),
        readings: group.len(),
        largest_n,
        compliance_m_per_n: std::array::from_fn(|number| slope(&runs(&axis(number)))),
        along_m_per_n: slope(&runs(&along)),
        at_largest_m_per_n: std::array::from_fn(at_largest),
    })
}

/// Mean slope of the runs that have one.
fn slope(runs: &[Vec<ForcePoint>]) -> Option<Estimate> {
    let line = |run: &Vec<ForcePoint>| {
        let line = LeastSquaresLine::through(run.iter().copied())?;
        Some((line, run.len() as f64 - 2.0))
    };
    let lines: Vec<(LeastSquaresLine, f64)> = runs.iter().filter_map(line).collect();
    if let [(line, dof)] = lines[..] {
        return Some(if dof > 0.0 {
            Estimate {
                value: line.slope,
                standard_uncertainty: (line.residual_squares / dof / line.sxx).sqrt(),
                dof,
            }
        } else {
            Estimate::without_uncertainty(line.slope)
        });
    }
    averaged(&lines.iter().map(|(line, _)| line.slope).collect::<Vec<_>>())
}

/// A mean with the standard uncertainty of its scatter.
fn averaged(values: &[f64]) -> Option<Estimate> {
    let value = mean(values)?;
    Some(match standard_deviation(values) {
        Some(sd) if values.len() > 1 => Estimate {
            value,
            standard_uncertainty: sd / (values.len() as f64).sqrt(),
            dof: values.len() as f64 - 1.0,
        },
        _ => Estimate::without_uncertainty(value),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::{ReadingStatus, RunKey};
    use stiffbench_numeric::vector::dot;
    use stiffbench_units_and_text::load_direction::LoadDirection;
    use stiffbench_units_and_text::test_point::{Branch, Direction};

    /// Displacements of an end with a symmetric compliance, µm/N, under a load `f` along (0.6, 0, 0.8).
    fn displaced(f: f64, extra_m: f64) -> [Option<f64>; 3] {
        let matrix = [[5.0, 1.0, 2.0], [1.0, 3.0, 0.5], [2.0, 0.5, 8.0]];
        matrix.map(|row: [f64; 3]| Some(1e-6 * dot(row, [0.6 * f, 0.0, 0.8 * f]) + extra_m))
    }

    /// Readings of loads along (0.6, 0, 0.8): the run from 1, the load and the displacements of each.
    fn table(loads: &[(u32, f64, [Option<f64>; 3])]) -> ReadingTable {
        let mut table = ReadingTable::default();
        let oblique = LoadDirection::from_vector([0.6, 0.0, 0.8]).unwrap();
        table.place_of(&oblique.named("oblique"));
        table.runs = [1, 2]
            .map(|run| RunKey::of_repeat(PoseId::new("P1"), Direction::X, run))
            .to_vec();
        table.zeros = table.runs.clone();
        for (seq, (run, f, displacement_m)) in (1..).zip(loads) {
            for direction in Direction::ALL {
                let Some(displacement_m) = displacement_m[direction.index()] else {
                    continue;
                };
                table.readings.push(Reading {
                    line: 0,
                    seq,
                    pose: PoseId::new("P1"),
                    direction,
                    load: Some(0),
                    branch: Branch::Loading,
                    step: 0,
                    repeat: *run,
                    attempt: 1,
                    run: run - 1,
                    zero: run - 1,
                    status: ReadingStatus::Accepted,
                    target_n: *f,
                    force_n: *f,
                    displacement_m,
                    time_s: None,
                    hold_s: None,
                    temperature_deg_c: None,
                    text: None,
                });
            }
        }
        table
    }

    #[test]
    fn compliances_are_those_of_the_matrix_and_zeros_do_not_count() {
        // Each run has a zero of its own; by hand c = C d: (0.6·5 + 0.8·2, 0.6·1 + 0.8·0.5, 0.6·2 + 0.8·8) µm/N.
        let loads: Vec<_> = [(1, 3e-6), (2, -1e-6)]
            .into_iter()
            .flat_map(|(run, zero_m)| [-10.0, -20.0, -30.0].map(|f| (run, f, displaced(f, zero_m))))
            .collect();
        let cells = vector_stiffness(&table(&loads), Branches::LoadingOnly, 0.0);
        assert_eq!(cells.len(), 1);
        let cell = &cells[0];
        assert_eq!((cell.runs, cell.readings), (2, 6));
        assert!((cell.unit[0] - 0.6).abs() < 1e-12 && (cell.unit[2] - 0.8).abs() < 1e-12);
        for (found, expected) in cell.compliance_m_per_n.iter().zip([4.6e-6, 1.0e-6, 7.6e-6]) {
            let found = found.unwrap();
            assert!((found.value - expected).abs() < 1e-15, "{found:?}");
            assert!(found.standard_uncertainty < 1e-15);
        }
        // dᵀ C d = 0.6·4.6 + 0.8·7.6 µm/N.
        let along = cell.along_m_per_n.unwrap();
        assert!((along.value - 8.84e-6).abs() < 1e-15);
        // At -30 N the zeros are 3 and -1 µm: the mean of (4.6·-30 + 3)/-30 and (4.6·-30 - 1)/-30.
        let at_largest = cell.at_largest_m_per_n[0].unwrap().value;
        assert!((at_largest - (4.6e-6 - 1e-6 / 30.0)).abs() < 1e-15);
    }

    #[test]
    fn an_axis_that_was_not_read_has_no_value_and_none_along_the_load() {
        let loads = [10.0, 20.0].map(|f| (1, f, [None, Some(f * 1e-6), None]));
        let cell = &vector_stiffness(&table(&loads), Branches::Both, 0.0)[0];
        assert_eq!(
            (cell.compliance_m_per_n[0], cell.along_m_per_n),
            (None, None)
        );
        let read = cell.compliance_m_per_n[1].unwrap();
        assert!((read.value - 1e-6).abs() < 1e-18 && read.expanded_95().is_none());
    }
}
