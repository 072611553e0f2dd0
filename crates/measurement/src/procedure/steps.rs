//! The readings that a procedure plans, in order.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::readings::{LoadOrder, RepeatOrder, ZeroScope};
use stiffbench_units_and_text::test_point::Branch;

use super::plan::Procedure;
use super::shuffle::shuffled;

/// One reading to be made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedReading {
    /// Place in the load sequence from 0, counted on through unloading; the readings of a hold share it.
    pub step: u32,
    /// The load to set, N, signed.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// Whether the load grows or is taken off on the way to it.
    pub branch: Branch,
    /// n-th application of the sequence, or of this load, from 1; readings of one repeat are one run.
    pub repeat: u32,
    /// Seconds under the load at which an extra reading is made; none for the reading that follows settling.
    #[serde(rename = "hold_s")]
    pub extra_hold_s: Option<f64>,
    /// Whether the gauge is zeroed before the load is applied.
    pub zero_before: bool,
    /// Whether this is the first reading of its run, whose history begins here.
    #[serde(skip)]
    pub starts_run: bool,
}

impl Procedure {
    /// The sign of the first load that is not zero, 1 or -1; loads of this sign push on the robot and compress the force gauge.
    #[must_use]
    pub fn load_sense(&self) -> f64 {
        let first = self.loads_n.iter().find(|load_n| **load_n != 0.0);
        first.map_or(-1.0, |load_n| load_n.signum())
    }

    /// The readings of one pose and direction, in order.
    ///
    /// Loads come as listed or shuffled ([`shuffled`]). Unloading goes back through what was listed, one excursion at a time: neighbouring
    /// loads of one sign are an excursion, a 0 belongs to the one behind it, and the way back ends where it began: at its own first load, or
    /// at 0 if the load before it was 0.
    /// So `[0, -10, -20, 10, 20]` with unloading gives 0, -10, -20, -10, 0, 10, 20, 10, 0.
    ///
    /// Each load is applied `repeats` times before the next (`at-load`, released in between, [`Procedure::release_n`]), or the whole sequence
    /// is (`sweep`); the n-th applications of all loads are run n in both. A load whose size shrinks without changing sign is on the
    /// unloading branch, in whatever order it comes. Extra holds follow each time the largest load is reached.
    ///
    /// # Arguments
    /// - `cell`: place of the pose and direction in the order of measurement, from 0; a shuffled order depends on it.
    #[must_use]
    pub fn steps(&self, cell: u32) -> Vec<PlannedReading> {
        let mut planned = Vec::new();
        match self.repeat_order {
            RepeatOrder::Sweep => {
                for repeat in 1..=self.repeats {
                    let targets = self.targets(cell, repeat);
                    let branches = branches(&targets);
                    for (step, (&target_n, branch)) in (0..).zip(targets.iter().zip(branches)) {
                        self.plan(&mut planned, step, target_n, branch, repeat);
                    }
                }
            }
            RepeatOrder::AtLoad => {
                for (step, target_n) in (0..).zip(self.targets(cell, 0)) {
                    for repeat in 1..=self.repeats {
                        self.plan(&mut planned, step, target_n, Branch::Loading, repeat);
                    }
                }
            }
        }
        planned
    }

    /// Adds the reading of a load and of its holds.
    fn plan(
        &self,
        planned: &mut Vec<PlannedReading>,
        step: u32,
        target_n: f64,
        branch: Branch,
        repeat: u32,
    ) {
        let starts_run = step == 0;
        let zero_before = match self.zero {
            ZeroScope::Cell => planned.is_empty(),
            ZeroScope::Run => starts_run,
        };
        planned.push(PlannedReading {
            step,
            target_n,
            branch,
            repeat,
            extra_hold_s: None,
            zero_before,
            starts_run,
        });
        if target_n.abs() == self.largest_n() {
            let extra = self.holds_s.iter().map(|&hold_s| PlannedReading {
                step,
                target_n,
                branch,
                repeat,
                extra_hold_s: Some(hold_s),
                zero_before: false,
                starts_run: false,
            });
            planned.extend(extra);
        }
    }

    /// Size of the largest load, N.
    fn largest_n(&self) -> f64 {
        let sizes = self.loads_n.iter().map(|load_n| load_n.abs());
        sizes.fold(0.0, f64::max)
    }

    /// The loads of a run in the order in which they are set.
    fn targets(&self, cell: u32, repeat: u32) -> Vec<f64> {
        match self.load_order {
            LoadOrder::Shuffled => shuffled(&self.loads_n, self.seed, cell, repeat),
            LoadOrder::Ascending if self.unloading => there_and_back(&self.loads_n),
            LoadOrder::Ascending => self.loads_n.clone(),
        }
    }

    /// How many readings one pose and direction take, without listing them.
    pub(super) fn readings_of_a_cell(&self) -> u64 {
        let one_run = Self {
            repeats: 1,
            ..self.clone()
        };
        u64::from(self.repeats) * one_run.steps(0).len() as u64
    }
}

/// Loads as listed, each excursion followed by the way back.
fn there_and_back(loads_n: &[f64]) -> Vec<f64> {
    let mut targets: Vec<f64> = Vec::new();
    let mut rest = loads_n;
    while !rest.is_empty() {
        let (mut excursion, behind) = rest.split_at(length_of_excursion(rest));
        rest = behind;
        let before_n = targets.last().copied();
        // Back at 0 already: that reading is not made twice.
        if excursion
            .first()
            .is_some_and(|&first_n| before_n == Some(first_n))
        {
            excursion = &excursion[1..];
        }
        targets.extend(excursion);
        targets.extend(excursion.iter().rev().skip(1));
        // Back to 0, where it began.
        if before_n == Some(0.0) && !excursion.is_empty() {
            targets.push(0.0);
        }
    }
    targets
}

/// How many loads the first excursion has: leading zeros, and loads of one sign behind them.
fn length_of_excursion(loads_n: &[f64]) -> usize {
    let zeros = loads_n.iter().take_while(|&&load_n| load_n == 0.0).count();
    let same_sign = loads_n[zeros..].iter().take_while(|&&load_n| {
        load_n != 0.0 && load_n.is_sign_negative() == loads_n[zeros].is_sign_negative()
    });
    zeros + same_sign.count()
}

/// Whether the load grew or was taken off on the way to each target.
fn branches(targets_n: &[f64]) -> Vec<Branch> {
    let mut branch = Branch::Loading;
    let mut before_n = 0.0_f64;
    targets_n
        .iter()
        .map(|&target_n| {
            let turned = target_n * before_n < 0.0;
            if turned || target_n.abs() > before_n.abs() {
                branch = Branch::Loading;
            } else if target_n.abs() < before_n.abs() {
                branch = Branch::Unloading;
            }
            before_n = target_n;
            branch
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn there_and_back_of(loads_n: &[f64]) -> Vec<f64> {
        let procedure = Procedure {
            loads_n: loads_n.to_vec(),
            unloading: true,
            repeats: 1,
            ..Procedure::default()
        };
        procedure.steps(0).iter().map(|r| r.target_n).collect()
    }

    #[test]
    fn unloading_goes_back_excursion_by_excursion() {
        for (listed, expected) in [
            (
                &[0.0, -10.0, -20.0][..],
                &[0.0, -10.0, -20.0, -10.0, 0.0][..],
            ),
            (&[-10.0, -20.0], &[-10.0, -20.0, -10.0]),
            (
                &[0.0, -10.0, -20.0, 10.0, 20.0],
                &[0.0, -10.0, -20.0, -10.0, 0.0, 10.0, 20.0, 10.0, 0.0],
            ),
            (&[0.0, -10.0, 0.0, 10.0], &[0.0, -10.0, 0.0, 10.0, 0.0]),
            (&[10.0, -10.0], &[10.0, -10.0]),
            (&[0.0, -10.0, 0.0], &[0.0, -10.0, 0.0]),
            (
                &[-10.0, -20.0, 0.0, 10.0],
                &[-10.0, -20.0, -10.0, 0.0, 10.0, 0.0],
            ),
        ] {
            assert_eq!(there_and_back_of(listed), expected, "{listed:?}");
        }
    }

    #[test]
    fn a_load_that_shrinks_is_unloading_whatever_the_order() {
        use Branch::{Loading as L, Unloading as U};
        for (targets, expected) in [
            (&[0.0, -10.0, -20.0, -10.0, 0.0][..], &[L, L, L, U, U][..]),
            (&[-30.0, 0.0, 10.0, -10.0, -10.0, -5.0], &[L, U, L, L, L, U]),
            (&[-70.0, -30.0, -70.0], &[L, U, L]),
        ] {
            assert_eq!(branches(targets), expected, "{targets:?}");
        }
    }

    #[test]
    fn the_papers_order_repeats_each_load_on_one_zero() {
        let paper = Procedure {
            repeat_order: RepeatOrder::AtLoad,
            zero: ZeroScope::Cell,
            loads_n: vec![0.0, -10.0],
            repeats: 3,
            ..Procedure::default()
        };
        let steps = paper.steps(5);
        let of: Vec<(u32, u32)> = steps.iter().map(|r| (r.step, r.repeat)).collect();
        assert_eq!(of, [(0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3)]);
        let zeroed: Vec<bool> = steps.iter().map(|r| r.zero_before).collect();
        assert_eq!(zeroed, [true, false, false, false, false, false]);
        assert_eq!(steps.iter().filter(|r| r.starts_run).count(), 3);
        assert_eq!(paper.release_n(), Some(-1.0));
    }

    #[test]
    fn holds_share_the_step_of_the_largest_load_and_unloading_counts_on() {
        let procedure = Procedure {
            loads_n: vec![0.0, -10.0, -20.0],
            unloading: true,
            repeats: 2,
            holds_s: vec![60.0, 120.0],
            ..Procedure::default()
        };
        let steps = procedure.steps(0);
        let first_run: Vec<(u32, f64, Option<f64>)> = steps
            .iter()
            .take(7)
            .map(|r| (r.step, r.target_n, r.extra_hold_s))
            .collect();
        assert_eq!(
            first_run,
            [
                (0, 0.0, None),
                (1, -10.0, None),
                (2, -20.0, None),
                (2, -20.0, Some(60.0)),
                (2, -20.0, Some(120.0)),
                (3, -10.0, None),
                (4, 0.0, None)
            ]
        );
        let zeroed: Vec<usize> = (0..14).filter(|&i| steps[i].zero_before).collect();
        let started: Vec<usize> = (0..14).filter(|&i| steps[i].starts_run).collect();
        assert_eq!((zeroed, started), (vec![0, 7], vec![0, 7]));
    }

    #[test]
    fn both_largest_loads_are_held() {
        let procedure = Procedure {
            loads_n: vec![0.0, -10.0, -20.0, 10.0, 20.0],
            repeats: 1,
            holds_s: vec![30.0],
            ..Procedure::default()
        };
        let held: Vec<f64> = procedure
            .steps(0)
            .iter()
            .filter(|r| r.extra_hold_s.is_some())
            .map(|r| r.target_n)
            .collect();
        assert_eq!(held, [-20.0, 20.0]);
    }
}
