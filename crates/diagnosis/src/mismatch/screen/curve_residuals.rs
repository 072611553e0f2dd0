//! Readings without enough repeats: each against the curve of its neighbours in its run.
//!
//! Near each reading a parabola in the force is free, and beside it a kink or a jump wherever that leaves least of the reading's own shift:
//! whatever a law makes of a curve is one of these, and no reading is bad for it. The last readings of a branch are not tested, for there
//! physics and a bad reading look alike. A second run of the cell must show the shift as the difference of both: what repeats is no mistake.

use stiffbench_units_and_text::test_point::Branch;

use crate::mismatch::noise::NoiseCovariance;
use crate::mismatch::observed::Observations;
use crate::search::constants::{AFTER_A_JUMP, ROUNDING, UNSEEN_READING};
use crate::search::{FittedRows, RowVector, largest};

/// Readings on either side that show the curve of a run near one of them (1): a parabola, a kink and a jump need so many. By judgement.
const NEIGHBOURS: usize = 4;

/// A reading against its repeats.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tested {
    pub(crate) reading: usize,
    /// Its shift over its standard error.
    pub(crate) ratio: f64,
    /// What it shows of the scatter of good readings: the same, but for those that are compared with their neighbours.
    pub(crate) scatter: f64,
    pub(crate) shift_m: f64,
    /// Whether its force is larger, or smaller, than that of all its repeats.
    pub(crate) is_outermost: bool,
    /// Whether it was compared with its neighbours, for want of repeats.
    pub(crate) is_by_curve: bool,
    /// Share of its own error in its variance; the rest is the step of the force.
    pub(crate) own_share: f64,
}

/// A reading beside others under the same branch, in the order of their loads.
struct Neighbour {
    force_n: f64,
    displacement_m: f64,
    /// One over the standard deviation.
    weight: f64,
}

/// Whether neighbours can be compared with readings of a cell.
pub(crate) fn has_neighbours(observations: &Observations, cell: usize) -> bool {
    let mut runs = observations.cells[cell].runs.clone();
    runs.any(|run| {
        let stretches = stretches(observations, run);
        stretches.iter().any(|one| !inner(one.len()).is_empty())
    })
}

/// Shifts of the readings of a cell against their neighbours.
pub(crate) fn curve_residuals(
    observations: &Observations,
    cell: usize,
    whitening: &NoiseCovariance,
) -> Vec<Tested> {
    let weights = whitening.covariance.weights();
    let own = |reading: usize| Neighbour {
        force_n: observations.loads[reading].force_n,
        displacement_m: observations.displacement_m[reading],
        weight: weights[reading],
    };
    let runs = observations.cells[cell].runs.clone();
    let mut out = Vec::new();
    for run in runs.clone() {
        let others: Vec<usize> = runs.clone().filter(|other| *other != run).collect();
        for stretch in stretches(observations, run) {
            for place in inner(stretch.len()) {
                let near = place.saturating_sub(NEIGHBOURS)..stretch.len();
                let near = near.start..near.end.min(place + NEIGHBOURS + 1);
                let at = place - near.start;
                let window = &stretch[near];
                let alone: Vec<Neighbour> = window.iter().map(|one| own(*one)).collect();
                let Some(mut shift) = shift_at(&alone, at) else {
                    continue;
                };
                for other in &others {
                    let repeat = |reading: usize| same_load(observations, *other, reading);
                    let Some(there) = repeat(stretch[place]) else {
                        continue;
                    };
                    let pairs = window.iter().filter_map(|one| Some((*one, repeat(*one)?)));
                    let pairs: Vec<(usize, usize)> = pairs.collect();
                    let at = pairs.iter().position(|(_, repeat)| *repeat == there);
                    let less: Vec<Neighbour> = pairs
                        .iter()
                        .map(|(one, repeat)| {
                            let by_force_m = whitening.slope_m[*one] - whitening.slope_m[*repeat];
                            own(*one).less(&own(*repeat), by_force_m)
                        })
                        .collect();
                    let both = at.and_then(|at| shift_at(&less, at)).unwrap_or_default();
                    // What repeats is not in it.
                    shift.scatter = both.scatter;
                    if both.ratio * shift.ratio < 0.0 {
                        shift.ratio = 0.0;
                    } else if both.ratio.abs() < shift.ratio.abs() {
                        shift.ratio = both.ratio;
                    }
                }
                out.push(Tested {
                    reading: stretch[place],
                    ratio: shift.ratio,
                    scatter: shift.scatter,
                    shift_m: shift.shift_m,
                    is_outermost: false,
                    is_by_curve: true,
                    own_share: whitening.own_share(stretch[place]),
                });
            }
        }
    }
    out
}

/// Loaded readings of each branch of a run, without later readings of a hold.
fn stretches(observations: &Observations, run: usize) -> [Vec<usize>; 2] {
    [Branch::Loading, Branch::Unloading].map(|branch| {
        let readings = observations.runs[run].readings.clone();
        let here = readings.filter(|one| {
            let detail = &observations.readings[*one];
            let is_loaded = !observations.loads[*one].is_unloaded;
            detail.branch == branch && detail.hold_number == 0 && is_loaded
        });
        here.collect()
    })
}

/// Places that have enough readings on either side.
fn inner(count: usize) -> std::ops::Range<usize> {
    AFTER_A_JUMP..count.saturating_sub(AFTER_A_JUMP).max(AFTER_A_JUMP)
}

/// A reading of another run under the same load.
fn same_load(observations: &Observations, run: usize, reading: usize) -> Option<usize> {
    let key = |one: usize| observations.load_key(one);
    let mut readings = observations.runs[run].readings.clone();
    readings.find(|other| key(*other) == key(reading))
}

impl Neighbour {
    /// What it has beyond a repeat, and beyond what the difference of their forces moves.
    fn less(self, repeat: &Self, by_force_m: f64) -> Self {
        let sd = self.weight.recip().hypot(repeat.weight.recip());
        Self {
            displacement_m: self.displacement_m - repeat.displacement_m - by_force_m,
            weight: sd.recip(),
            ..self
        }
    }
}

/// A shift of one reading.
#[derive(Debug, Clone, Copy, Default)]
struct CurveShift {
    shift_m: f64,
    /// Over its standard error, by noise and by what the curve leaves of the neighbours.
    ratio: f64,
    /// The same beside a parabola alone.
    scatter: f64,
}

/// The shift of a reading from the curve of the others, beside the kink or jump that leaves least of it; `None` with too few others.
fn shift_at(window: &[Neighbour], at: usize) -> Option<CurveShift> {
    let count = window.len();
    let largest_n = largest(window.iter().map(|one| &one.force_n));
    if largest_n == 0.0 {
        return None;
    }
    let column = |of: &dyn Fn(usize, f64) -> f64| {
        let rows = window.iter().enumerate();
        let rows = rows.map(|(place, one)| one.weight * of(place, one.force_n / largest_n));
        RowVector::from(rows.collect::<Vec<f64>>())
    };
    let parabola: [&dyn Fn(usize, f64) -> f64; 3] =
        [&|_, _| 1.0, &|_, force| force, &|_, force| force * force];
    let mut smooth = FittedRows::new(column(&|place, _| window[place].displacement_m).values);
    for of in parabola {
        smooth.set_free(column(of), ROUNDING);
    }
    let scaled = |place: usize| window[place].force_n / largest_n;
    let kinks = (1..count.saturating_sub(1)).map(|from| {
        column(&|place, force| {
            let beyond = f64::from(u8::from(place >= from));
            beyond * (force - scaled(from))
        })
    });
    let jumps = (1..count).map(|from| column(&|place, _| f64::from(u8::from(place >= from))));
    let shifts = std::iter::once(None).chain(kinks.chain(jumps).map(Some));
    let shifts = shifts.map(|more| {
        let mut fitted = smooth.clone();
        if let Some(column) = more {
            fitted.set_free(column, ROUNDING.sqrt());
        }
        let rest = fitted.dof_without(1)?;
        let own = fitted.shift(column(&|place, _| f64::from(u8::from(place == at))));
        if !own.is_seen(UNSEEN_READING) {
            return None;
        }
        let others = (fitted.squares() - own.fall()) / rest;
        Some((own.ratio() / others.max(1.0).sqrt(), own.size()))
    });
    let shifts: Vec<(f64, f64)> = shifts.collect::<Option<_>>()?;
    let least = |a: &&(f64, f64), b: &&(f64, f64)| a.0.abs().total_cmp(&b.0.abs());
    let (ratio, shift_m) = *shifts.iter().min_by(least)?;
    Some(CurveShift {
        shift_m,
        ratio,
        scatter: shifts[0].0,
    })
}
