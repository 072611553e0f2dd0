//! Measured stiffness of every cell.

use thiserror::Error;

use super::budget::{StiffnessEstimate, combine};
use super::budget_row::BudgetInputs;
use super::checks::{CellWork, check};
use super::covariance::LnStiffnessCovariance;
use super::curve::{Branches, LoadMean};
use super::estimate::{Elsewhere, Method, paper_stiffness, regression_stiffness};
use super::flags::Flag;
use super::gauges::GaugePair;
use super::grouping::{LeftOut, group_by_cell};
use super::hysteresis::Hysteresis;
use super::line::{LineFit, NoStiffness};
use super::run_slope::PooledRunSlope;
use super::scatter::PooledScatter;
use super::straight_part::StraightPart;
use super::straightness::straight_readings;
use super::zeros::ZeroDrifts;
use crate::readings::Reading;
use stiffbench_numeric::statistics::Estimate;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// What the stiffness is computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StiffnessOptions {
    /// Branches that take part.
    pub branches: Branches,
}

/// Stiffness of one cell with everything it rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct CellStiffness {
    /// Pose and direction.
    pub cell: Cell,
    /// Number of runs.
    pub n_runs: usize,
    /// Number of gauge zeros.
    pub n_zeros: usize,
    /// Mean readings by load.
    pub loads: Vec<LoadMean>,
    /// Mean of F/δ over the loads that are not zero, with its budget, or why there is none.
    pub paper: Result<StiffnessEstimate, NoStiffness>,
    /// 1/slope of displacement on force, with its budget, or why there is none.
    pub regression: Result<StiffnessEstimate, NoStiffness>,
    /// The line behind `regression`: compliance in m/N with both its uncertainties.
    pub line: Result<LineFit, NoStiffness>,
    /// What looks wrong.
    pub flags: Vec<Flag>,
    /// The loop between loading and unloading, whichever branches the stiffness is of; `None` if no load was read in both.
    pub hysteresis: Option<Hysteresis>,
    /// 1/slope while loading and while unloading.
    pub branches: [Result<StiffnessEstimate, NoStiffness>; 2],
}

impl CellStiffness {
    /// The stiffness by `method`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn by(&self, method: Method) -> Result<&StiffnessEstimate, NoStiffness> {
        let found = match method {
            Method::PaperMean => &self.paper,
            Method::Regression => &self.regression,
        };
        found.as_ref().map_err(|reason| *reason)
    }

    /// Mean intercept of the line, m; `None` without a line.
    #[must_use]
    pub fn zero_offset_m(&self) -> Option<Estimate> {
        self.line.as_ref().ok().map(|line| line.zero_offset_m)
    }
}

/// Why a cell of the readings is not in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum SkipReason {
    /// None of its readings was accepted.
    #[error("of its {}, none is accepted and finite", counted(.n_readings, "reading"))]
    NothingAccepted {
        /// Number of its readings.
        n_readings: usize,
    },
    /// Its accepted readings are all of another branch.
    #[error("of its {}, none is of a branch that was asked for", counted(.n_accepted, "accepted reading"))]
    OtherBranch {
        /// Number of accepted readings.
        n_accepted: usize,
    },
}

/// A cell without readings to work with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkippedCell {
    /// Pose and direction.
    pub cell: Cell,
    /// Why.
    pub reason: SkipReason,
}

/// Measured stiffness of all cells of a set of readings.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessTable {
    /// The branches used.
    pub branches: Branches,
    /// Cells in the order in which they first appear.
    pub cells: Vec<CellStiffness>,
    /// Scatter of single readings over all cells; `None` without repeats.
    pub pooled_scatter: Option<PooledScatter>,
    /// Scatter of the slope from run to run beyond reading noise, over all cells; `None` if no cell has two runs.
    pub run_slope: Option<PooledRunSlope>,
    /// Cells without a row, with the reason.
    pub skipped: Vec<SkippedCell>,
    /// Readings left out.
    pub left_out: LeftOut,
}

impl StiffnessTable {
    /// The row of a cell.
    #[must_use]
    pub fn cell(&self, cell: &Cell) -> Option<&CellStiffness> {
        self.cells.iter().find(|row| row.cell == *cell)
    }

    /// How the uncertainties of ln K of the cells hang together through the gauges they share.
    #[must_use]
    pub fn covariance(&self, method: Method) -> LnStiffnessCovariance {
        LnStiffnessCovariance::new(self.cells.iter().map(|row| {
            let parts = row.by(method).ok().map(|estimate| estimate.ln_parts);
            (&row.cell, parts)
        }))
    }
}

/// Works out the stiffness of every cell, by both methods, with budgets and flags.
///
/// # Arguments
/// - `readings`: in any order; only accepted ones with finite numbers count, the rest is counted in `left_out`.
/// - `gauges`: resolution and calibration, as far as they are stated.
///
/// # Returns
/// Cells in the order of their first reading. Every cell that has readings is either a row or in `skipped`.
#[must_use]
pub fn stiffness_table(
    readings: &[Reading],
    gauges: &GaugePair,
    options: StiffnessOptions,
) -> StiffnessTable {
    stiffness_table_with_drifts(readings, gauges, options, &ZeroDrifts::new())
}

/// The same where a session checked its zeros: what was found of the force gauge counts in every cell, what was found of the displacement
/// gauge in cells that have no unloaded reading after the loads.
#[must_use]
pub fn stiffness_table_with_drifts(
    readings: &[Reading],
    gauges: &GaugePair,
    options: StiffnessOptions,
    drifts: &ZeroDrifts,
) -> StiffnessTable {
    let (groups, mut left_out) = group_by_cell(readings);
    let mut skipped = Vec::new();
    let (mut works, mut of_works) = (Vec::new(), Vec::new());
    for group in groups {
        if group.usable.is_empty() {
            let reason = SkipReason::NothingAccepted {
                n_readings: group.n_readings,
            };
            skipped.push(SkippedCell {
                cell: group.cell,
                reason,
            });
            continue;
        }
        let work = CellWork::new(group.cell, &group.usable, options.branches);
        left_out.later_in_step += work.curve.n_later_in_step;
        left_out.other_branch += work.curve.n_other_branch;
        if work.curve.runs.is_empty() {
            let reason = SkipReason::OtherBranch {
                n_accepted: group.usable.len(),
            };
            skipped.push(SkippedCell {
                cell: work.curve.cell,
                reason,
            });
        } else {
            works.push(work);
            of_works.push(group.usable);
        }
    }
    let pooled_scatter = check(&mut works, gauges);
    let with_line = works.iter();
    let with_line = with_line.filter_map(|work| Some((&work.curve, work.line.as_ref().ok()?)));
    let scatter = pooled_scatter.unwrap_or(PooledScatter::UNSEEN);
    let run_slope = PooledRunSlope::over(with_line, &scatter);
    let elsewhere = run_slope.as_ref().map(|run_slope| Elsewhere {
        run_slope,
        scatter: &scatter,
    });
    let known = BudgetContext {
        gauges,
        drifts,
        branches: options.branches,
        pooled: pooled_scatter.as_ref(),
        elsewhere: elsewhere.as_ref(),
    };
    let works = works.into_iter().zip(of_works);
    let cells = works
        .map(|(work, readings)| finish(work, &readings, &known))
        .collect();
    StiffnessTable {
        branches: options.branches,
        cells,
        pooled_scatter,
        run_slope,
        skipped,
        left_out,
    }
}

/// What is known besides the readings of a cell.
struct BudgetContext<'a> {
    gauges: &'a GaugePair,
    drifts: &'a ZeroDrifts,
    branches: Branches,
    pooled: Option<&'a PooledScatter>,
    elsewhere: Option<&'a Elsewhere<'a>>,
}

impl BudgetContext<'_> {
    /// What the budget of a cell rests on.
    fn inputs<'w>(&'w self, work: &'w CellWork) -> BudgetInputs<'w> {
        let change = self.drifts.get(&work.curve.cell);
        BudgetInputs {
            curve: &work.curve,
            line: work.line.as_ref().ok(),
            gauges: self.gauges,
            pooled: self.pooled,
            back_to_zero: work.back_to_zero(self.pooled.is_some(), self.drifts),
            force_drift_n: change.and_then(|change| change.force_n).unwrap_or_default(),
        }
    }

    /// 1/slope with its budget.
    fn regression(&self, work: &CellWork) -> Result<StiffnessEstimate, NoStiffness> {
        let line = work.line.as_ref().map_err(|reason| *reason)?;
        let bare = regression_stiffness(&work.curve, line, self.elsewhere)?;
        Ok(combine(&bare, &self.inputs(work)))
    }

    /// 1/slope of each branch.
    fn branches(
        &self,
        cell: &Cell,
        readings: &[&Reading],
    ) -> [Result<StiffnessEstimate, NoStiffness>; 2] {
        [Branch::Loading, Branch::Unloading].map(|branch| {
            let own = readings.iter().copied().filter(|one| one.branch == branch);
            let own: Vec<&Reading> = own.collect();
            let work = CellWork::new(cell.clone(), &own, Branches::Both);
            self.regression(&work)
        })
    }

    /// The loads of a cell that lie on a line, though not all of them do.
    fn straight_part(&self, readings: &[&Reading]) -> Option<StraightPart> {
        let (inside, ends_n) = straight_readings(readings, self.branches, self.gauges)?;
        let work = CellWork::new(inside.first()?.cell(), &inside, self.branches);
        let found = self.regression(&work).ok()?;
        Some(StraightPart {
            ends_n,
            stiffness: found.estimate,
        })
    }
}

fn finish(mut work: CellWork, readings: &[&Reading], known: &BudgetContext<'_>) -> CellStiffness {
    let paper = paper_stiffness(&work.curve, known.elsewhere);
    let paper = paper.map(|bare| combine(&bare, &known.inputs(&work)));
    let regression = known.regression(&work);
    if let Ok(found) = &regression {
        let expanded_n_per_m = found.estimate.expanded_95();
        let part = || known.straight_part(readings);
        let flag = work.not_straight(known.gauges, expanded_n_per_m, part);
        work.flags.extend(flag);
    }
    let hysteresis = Hysteresis::of(&work.curve.cell, readings, known.gauges);
    CellStiffness {
        branches: known.branches(&work.curve.cell, readings),
        hysteresis,
        n_runs: work.curve.runs.len(),
        n_zeros: work.curve.n_zeros,
        paper,
        regression,
        line: work.line,
        flags: work.flags,
        cell: work.curve.cell,
        loads: work.curve.loads,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::ReadingStatus;
    use crate::stiffness::sample::{SimulatedBench, cell, reading};
    use crate::stiffness::{GaugeTerms, ScatterBasis};
    use stiffbench_units_and_text::test_point::Direction;

    fn table(readings: &[Reading]) -> StiffnessTable {
        stiffness_table(readings, &GaugePair::default(), StiffnessOptions::default())
    }

    fn has(row: &CellStiffness, rule: &str) -> bool {
        row.flags.iter().any(|flag| flag.rule == rule)
    }

    #[test]
    fn cells_stand_in_the_order_of_their_first_reading_whatever_the_order_of_the_rest() {
        let mut readings = SimulatedBench::paper(6, 1).readings();
        let names = |table: &StiffnessTable| -> Vec<String> {
            table.cells.iter().map(|row| row.cell.to_string()).collect()
        };
        let sorted = table(&readings);
        assert_eq!(
            names(&sorted),
            ["P1 x", "P1 y", "P1 z", "P2 x", "P2 y", "P2 z"]
        );
        readings.reverse();
        let reversed = table(&readings);
        assert_eq!(
            names(&reversed),
            ["P2 z", "P2 y", "P2 x", "P1 z", "P1 y", "P1 x"]
        );
        for row in &sorted.cells {
            assert_eq!(reversed.cell(&row.cell).unwrap().regression, row.regression);
        }
    }

    #[test]
    fn everything_left_out_is_counted_and_a_cell_without_readings_is_listed() {
        let mut readings: Vec<Reading> = (0..4)
            .map(|i| {
                reading(
                    1,
                    i,
                    -10.0 * f64::from(i),
                    -10.0 * f64::from(i),
                    -2e-4 * f64::from(i),
                )
            })
            .collect();
        readings.push(Reading {
            status: ReadingStatus::Superseded,
            ..reading(1, 4, -40.0, -40.0, -8e-4)
        });
        readings.push(Reading {
            status: ReadingStatus::Rejected,
            ..reading(1, 4, -40.0, -40.0, -8e-4)
        });
        readings.push(reading(1, 4, -40.0, f64::NAN, -8e-4));
        readings.push(reading(1, 3, -30.0, -30.0, -6.1e-4));
        readings.push(Reading {
            status: ReadingStatus::Rejected,
            direction: Direction::X,
            ..reading(1, 0, -10.0, -10.0, -2e-4)
        });
        readings.push(Reading {
            branch: Branch::Unloading,
            direction: Direction::Z,
            ..reading(1, 0, -10.0, -10.0, -2e-4)
        });
        let table = table(&readings);
        assert_eq!(table.cells.len(), 1);
        let expected = LeftOut {
            superseded: 1,
            rejected: 2,
            later_in_step: 1,
            other_branch: 1,
            not_finite: vec![104],
        };
        assert_eq!(table.left_out, expected);
        let reasons: Vec<SkipReason> = table.skipped.iter().map(|s| s.reason).collect();
        assert_eq!(
            reasons,
            [
                SkipReason::NothingAccepted { n_readings: 1 },
                SkipReason::OtherBranch { n_accepted: 1 }
            ]
        );
        assert!(
            table
                .skipped
                .iter()
                .all(|s| s.reason.to_string().len() > 20)
        );
        assert_eq!(
            stiffness_table(&[], &GaugePair::default(), StiffnessOptions::default()).cells,
            []
        );
    }

    #[test]
    fn three_runs_stand_for_themselves_two_borrow_and_one_has_no_uncertainty() {
        for (repeats, dof) in [(1, None), (2, Some(1.0)), (3, Some(2.0))] {
            let bench = SimulatedBench {
                repeats,
                ..SimulatedBench::paper(1, 2)
            };
            let table = table(&bench.readings());
            let regression = table.cells[0].by(Method::Regression).unwrap();
            let by_runs = matches!(regression.basis, ScatterBasis::RunToRun { .. });
            assert_eq!(by_runs, repeats == 3);
            assert_eq!(regression.type_a.map(|type_a| type_a.dof), dof);
            assert_eq!(regression.estimate.expanded_95().is_some(), dof.is_some());
        }
    }

    #[test]
    fn a_gauge_of_the_wrong_polarity_is_flagged_and_its_ratio_has_no_value() {
        let mut readings = SimulatedBench::paper(1, 2).readings();
        for reading in &mut readings {
            reading.displacement_m = -reading.displacement_m;
        }
        let table = table(&readings);
        let row = &table.cells[0];
        assert!(has(row, "negative-stiffness") && has(row, "displacement-sign"));
        assert_eq!(
            row.paper,
            Err(NoStiffness::OppositeSigns { target_n: -10.0 })
        );
        assert!(row.by(Method::Regression).unwrap().estimate.value < 0.0);
    }

    #[test]
    fn loads_with_little_information_are_flagged() {
        let forces = |target: f64, force: f64, displacement: f64| {
            (1..=5).flat_map(move |repeat| {
                [
                    reading(repeat, 0, 0.0, 0.0, 0.0),
                    reading(
                        repeat,
                        1,
                        target,
                        force,
                        displacement + 1e-6 * f64::from(repeat),
                    ),
                ]
            })
        };
        let readings: Vec<Reading> = forces(-10.0, 10.0, 2e-4).collect();
        let found = table(&readings);
        assert!(has(&found.cells[0], "too-few-loads") && has(&found.cells[0], "force-sign"));
        let readings: Vec<Reading> = forces(-10.0, 0.0, -2e-4).collect();
        let found = table(&readings);
        assert!(has(&found.cells[0], "zero-force"));
        assert_eq!(found.cells[0].regression, Err(NoStiffness::OneForce));
        let readings: Vec<Reading> = forces(-10.0, -10.0, -3.5e-6).collect();
        let found = table(&readings);
        assert!(has(&found.cells[0], "displacement-not-resolved"));
        assert!(has(&found.cells[0], "slope-not-resolved"));
    }

    #[test]
    fn both_branches_together_move_the_ratio_when_there_is_a_loop() {
        let bench = SimulatedBench {
            unloading: true,
            ..SimulatedBench::paper(1, 6)
        };
        let mut readings = bench.readings();
        for reading in readings
            .iter_mut()
            .filter(|r| r.branch == Branch::Unloading)
        {
            reading.displacement_m -= 40e-6;
        }
        let options = StiffnessOptions {
            branches: Branches::Both,
        };
        let both = stiffness_table(&readings, &GaugePair::default(), options);
        let loading = table(&readings);
        let value =
            |table: &StiffnessTable| table.cells[0].by(Method::PaperMean).unwrap().estimate.value;
        assert!(value(&both) < 0.99 * value(&loading));
        assert_eq!(
            (both.cells[0].loads.len(), loading.cells[0].loads.len()),
            (15, 8)
        );
    }

    #[test]
    fn the_covariance_of_cells_is_that_of_their_parts() {
        let gauges = GaugePair {
            force: GaugeTerms::new(None, Some(0.14), Some(2.0)).unwrap(),
            ..GaugePair::default()
        };
        let readings = SimulatedBench::paper(2, 8).readings();
        let table = stiffness_table(&readings, &gauges, StiffnessOptions::default());
        let covariance = table.covariance(Method::Regression);
        // 0.07 N of 70 N: a thousandth, the same for both.
        let common = covariance.entry(0, 1).unwrap();
        assert!((common / 1e-6 - 1.0).abs() < 0.01, "{common}");
        let estimate = table.cells[0].by(Method::Regression).unwrap().estimate;
        let relative = estimate.standard_uncertainty / estimate.value;
        assert!((covariance.entry(0, 0).unwrap() / relative.powi(2) - 1.0).abs() < 1e-9);
        assert!(table.cell(&cell()).is_some());
    }
}
