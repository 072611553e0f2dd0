//! The loop between loading and unloading of one cell, as numbers with their uncertainty.
//!
//! Width: displacement while unloading less displacement while loading at the same measured force, positive where the displacement lags behind
//! the force. A loop is one application of the loads, up and down, of both signs where both were applied; the scatter of the loops is that of the
//! gauges, of the forces through the slopes of the branches, and of the part. Drift and creep are not taken off. The branches of a continuous record
//! are compared at shares of the largest load.

use std::collections::{HashMap, HashSet};

use thiserror::Error;

use super::curve::{Branches, CurvePoint, LoadCurve};
use super::gauges::{GaugePair, GaugeTerms};
use crate::readings::Reading;
use stiffbench_numeric::statistics::{
    Estimate, mean, standard_deviation, student_t_quantile, welch_satterthwaite,
};
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// Observed standard deviation in steps of the display above which rounding differs from loop to loop and shows in the scatter (1): as of a
/// stiffness.
const ROUNDING_IS_AVERAGED_FROM_STEPS: f64 = 0.58;

/// Share of the largest load at whose two signs the centre line of the loop is taken for the lost motion (1). Definition.
const LOST_MOTION_AT: f64 = 0.03;

/// Largest distance of a load from [`LOST_MOTION_AT`], as a share of the largest load, that still stands for it (1): what lies between is
/// interpolated. Stated.
const NEAR: f64 = 0.011;

/// Loads at which the branches of a continuous record are compared, as shares of the largest, and as many of the other sign (1). The last one is
/// where the loop turns, and has no width. Definition.
const LEVELS: [f64; 11] = [
    LOST_MOTION_AT,
    0.1,
    0.2,
    0.3,
    0.4,
    0.5,
    0.6,
    0.7,
    0.8,
    0.9,
    1.0,
];

/// Number of loads in a cell above which they were not aimed at one by one: of a continuous record some come again by chance, or by the step of the
/// display. Stated.
const MOST_LOADS: usize = 40;

/// Share of the largest load by which the ends of a closed loop may differ (1). Stated.
const CLOSED_WITHIN: f64 = 0.02;

/// The loop between loading and unloading of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Hysteresis {
    /// Number of loops.
    pub n_loops: usize,
    /// Width at each load that was read in both branches, by growing size of the load.
    pub widths: Vec<LoopWidth>,
    /// The largest of these widths by size.
    pub largest: LargestWidth,
    /// Displacement that remains without load, the width at no load, m.
    pub residual_m: Result<Estimate, NoHysteresis>,
    /// Distance of the centre line of the loop between +3 and -3 % of the largest load, m.
    pub lost_motion_m: Result<Estimate, NoHysteresis>,
    /// Energy lost in a loop, J.
    pub energy_j: Estimate,
    /// Forces between which a straight line closes the loop, N; `None` of a loop that ends where it began.
    pub closing_line_n: Option<[f64; 2]>,
}

/// Width of a loop at one load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopWidth {
    /// The load that was aimed at, of a continuous record a share of the largest, N.
    pub target_n: f64,
    /// Force at which both branches are compared: the mean of those measured, N.
    pub force_n: f64,
    /// Displacement while unloading less that while loading, m.
    pub width_m: Estimate,
}

/// The largest width of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestWidth {
    /// The load of that width, N.
    pub target_n: f64,
    /// The width there, m.
    pub width_m: f64,
    /// 95 % interval of the largest width of that sign, wherever it is, m: a band that holds over all loads at once (Bonferroni). `None` without repeats.
    pub interval_m: Option<[f64; 2]>,
}

/// Why a number of the loop is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoHysteresis {
    /// Nothing was read without load in both branches.
    #[error("no reading without load before and after the loads")]
    NoUnloaded,
    /// Loads of one sign.
    #[error("the loads have one sign; lost motion needs both")]
    OneSign,
    /// Nothing was read close to no load.
    #[error("no loads of +3 and -3 % of the largest load in both branches")]
    NoSmallLoads,
}

impl Hysteresis {
    /// The loop of a cell; `None` if no load but zero was read in both branches: a return to zero is no loop.
    ///
    /// # Arguments
    /// - `readings`: accepted ones with finite numbers, of one gauge under loads in one direction.
    /// - `gauges`: their steps and reversibility, as far as they are known.
    #[must_use]
    pub fn of(cell: &Cell, readings: &[&Reading], gauges: &GaugePair) -> Option<Self> {
        let curve = LoadCurve::new(cell.clone(), readings, Branches::Both);
        let loops = Loops::of(&curve);
        let widths = loops.widths(gauges);
        if widths.iter().all(|width| width.target_n == 0.0) {
            return None;
        }
        let largest = LargestWidth::of(&widths)?;
        let unloaded = widths.iter().find(|width| width.target_n == 0.0);
        let residual = unloaded.map(|width| width.width_m);
        Some(Self {
            n_loops: loops.all.len(),
            residual_m: residual.ok_or(NoHysteresis::NoUnloaded),
            lost_motion_m: loops.lost_motion_m(),
            energy_j: loops.energy_j(),
            closing_line_n: loops.closing_line_n(),
            largest,
            widths,
        })
    }
}

impl LargestWidth {
    /// The largest of some widths; `None` if there is none.
    fn of(widths: &[LoopWidth]) -> Option<Self> {
        let size = |width: &LoopWidth| width.width_m.value.abs();
        let by_size = |a: &&LoopWidth, b: &&LoopWidth| size(a).total_cmp(&size(b));
        let widest = widths.iter().max_by(by_size)?;
        let sign = widest.width_m.value.signum();
        let tail = 0.025 / widths.len() as f64;
        let ends = widths.iter().map(|width| {
            let Estimate {
                value,
                standard_uncertainty,
                dof,
            } = width.width_m;
            let half = student_t_quantile(1.0 - tail, dof)? * standard_uncertainty;
            let ends = [sign * value - half, sign * value + half];
            half.is_finite().then_some(ends)
        });
        let ends: Option<Vec<[f64; 2]>> = ends.collect();
        let most = |ends: &[[f64; 2]], end: usize| {
            let of_all = ends.iter().map(|ends| ends[end]);
            of_all.fold(f64::NEG_INFINITY, f64::max)
        };
        Some(Self {
            target_n: widest.target_n,
            width_m: widest.width_m.value,
            interval_m: ends.map(|ends| {
                let mut interval = [0, 1].map(|end| sign * most(&ends, end));
                interval.sort_by(f64::total_cmp);
                interval
            }),
        })
    }
}

/// A reading of a loop.
#[derive(Debug, Clone, Copy)]
struct LoopPoint {
    branch: Branch,
    target_n: f64,
    force_n: f64,
    displacement_m: f64,
}

/// One application of the loads, up and down, in the order of measurement.
struct Loop {
    points: Vec<LoopPoint>,
    /// Those at which branches are compared.
    stations: Vec<LoopPoint>,
    /// Where each load stands among these while loading and while unloading, by its bits.
    places: [HashMap<u64, usize>; 2],
}

impl Loop {
    /// `None` without both branches.
    fn new(points: Vec<LoopPoint>) -> Option<Self> {
        let [up, down] = [Branch::Loading, Branch::Unloading]
            .map(|branch| points.iter().any(|point| point.branch == branch));
        let stations = points.clone();
        (up && down).then(|| Self {
            places: places_of(&stations),
            points,
            stations,
        })
    }

    /// Compared at [`LEVELS`] of a largest load: each reading stands for the level next to it, and of each branch the nearest counts.
    fn compare_at_levels(&mut self, largest_n: f64) {
        // To seven digits, as one would aim.
        let level = |share: f64| {
            let exact = share * largest_n;
            format!("{exact:.6e}").parse().unwrap_or(exact)
        };
        let of_side = |sign: f64| LEVELS.iter().map(move |share| level(sign * share));
        let levels: Vec<f64> = of_side(-1.0).chain([0.0]).chain(of_side(1.0)).collect();
        let nearest = |force_n: f64| {
            let off = |level: &f64| (level - force_n).abs();
            let by_distance = |a: &f64, b: &f64| off(a).total_cmp(&off(b));
            levels.iter().copied().min_by(by_distance)
        };
        self.stations.clear();
        for branch in self.points.chunk_by(|a, b| a.branch == b.branch) {
            let station = |level: &f64| {
                let off = |place: &usize| (branch[*place].force_n - level).abs();
                let by_distance = |a: &usize, b: &usize| off(a).total_cmp(&off(b));
                let place = (0..branch.len()).min_by(by_distance)?;
                let is_turn = level.abs() > 0.95 * largest_n;
                let stands_for = nearest(branch[place].force_n) == Some(*level) && !is_turn;
                stands_for.then_some((place, *level))
            };
            let mut stations: Vec<_> = levels.iter().filter_map(station).collect();
            stations.sort_by_key(|(place, _)| *place);
            let aimed = stations.into_iter().map(|(place, target_n)| LoopPoint {
                target_n,
                ..branch[place]
            });
            self.stations.extend(aimed);
        }
        self.places = places_of(&self.stations);
    }

    /// Where a load stands in both branches.
    fn both(&self, target_n: f64) -> Option<[usize; 2]> {
        let [up, down] = &self.places;
        let target = target_n.to_bits();
        Some([*up.get(&target)?, *down.get(&target)?])
    }

    /// Displacement at a force near one of the readings, interpolated towards the neighbour on that side, and the slope taken, m/N.
    fn at_force(&self, place: usize, force_n: f64) -> (f64, f64) {
        let own = self.stations[place];
        let off = force_n - own.force_n;
        let slope_to = |other: &LoopPoint| {
            let slope = (other.displacement_m - own.displacement_m) / (other.force_n - own.force_n);
            (other.target_n != own.target_n && slope.is_finite()).then_some(slope)
        };
        let neighbours = [place.checked_sub(1), Some(place + 1)];
        let neighbours = neighbours.map(|place| self.stations.get(place?));
        let is_beyond = |other: &&LoopPoint| (other.force_n - own.force_n) * off > 0.0;
        let beyond = neighbours.into_iter().flatten().filter(is_beyond);
        let either = neighbours.into_iter().flatten();
        let slope = beyond.chain(either).find_map(slope_to).unwrap_or(0.0);
        (own.displacement_m + slope * off, slope)
    }

    /// Its area, closed by a straight line.
    fn area_j(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        let pieces =
            self.points.iter().zip(next).map(|(a, b)| {
                0.5 * (a.force_n + b.force_n) * (b.displacement_m - a.displacement_m)
            });
        pieces.sum()
    }
}

/// Where each load stands among some readings while loading and while unloading, by its bits: of loads that come again, a loop is where it began
/// and where it ended.
fn places_of(points: &[LoopPoint]) -> [HashMap<u64, usize>; 2] {
    let [mut up, mut down] = [HashMap::new(), HashMap::new()];
    for (place, point) in points.iter().enumerate() {
        let target = point.target_n.to_bits();
        match point.branch {
            Branch::Loading => {
                up.entry(target).or_insert(place);
            }
            Branch::Unloading => {
                down.insert(target, place);
            }
        }
    }
    [up, down]
}

/// Readings in the order of measurement, split where a load of a sign is applied again.
fn applications(points: &[LoopPoint]) -> Vec<Vec<LoopPoint>> {
    let mut all: Vec<Vec<LoopPoint>> = Vec::new();
    let mut signs: Vec<f64> = Vec::new();
    for branch in points.chunk_by(|a, b| a.branch == b.branch) {
        let by_size = |a: &&LoopPoint, b: &&LoopPoint| a.force_n.abs().total_cmp(&b.force_n.abs());
        let most = branch
            .iter()
            .max_by(by_size)
            .map(|point| point.force_n.signum());
        let is_again =
            branch[0].branch == Branch::Loading && most.is_some_and(|most| signs.contains(&most));
        if is_again || all.is_empty() {
            all.push(Vec::new());
            signs.clear();
        }
        if branch[0].branch == Branch::Loading {
            signs.extend(most);
        }
        if let Some(last) = all.last_mut() {
            last.extend(branch);
        }
    }
    all
}

/// The loops of a cell.
struct Loops {
    all: Vec<Loop>,
}

impl Loops {
    fn of(curve: &LoadCurve) -> Self {
        let mut all = Vec::new();
        for run in &curve.runs {
            let mut points: Vec<&CurvePoint> = run.points.iter().collect();
            points.sort_by_key(|point| (point.repeat, point.seq, point.line));
            for repeat in points.chunk_by(|a, b| a.repeat == b.repeat) {
                let points = repeat.iter().map(|point| LoopPoint {
                    branch: curve.loads[point.load].branch,
                    target_n: curve.loads[point.load].target_n,
                    force_n: point.force_n,
                    displacement_m: point.displacement_m,
                });
                let points: Vec<LoopPoint> = points.collect();
                let applications = applications(&points).into_iter();
                all.extend(applications.filter_map(Loop::new));
            }
        }
        let mut loops = Self { all };
        let aimed = loops.stations().map(|point| point.target_n.to_bits());
        let aimed: HashSet<u64> = aimed.collect();
        if aimed.len() > MOST_LOADS || loops.targets().iter().all(|target| *target == 0.0) {
            let sizes = loops.points().map(|point| point.force_n.abs());
            let largest_n = sizes.fold(0.0, f64::max);
            for one in &mut loops.all {
                one.compare_at_levels(largest_n);
            }
        }
        loops
    }

    fn points(&self) -> impl DoubleEndedIterator<Item = &LoopPoint> {
        self.all.iter().flat_map(|one| &one.points)
    }

    fn stations(&self) -> impl DoubleEndedIterator<Item = &LoopPoint> {
        self.all.iter().flat_map(|one| &one.stations)
    }

    /// The loads that a loop has in both branches, by their size.
    fn targets(&self) -> Vec<f64> {
        let of_loop = |one: &Loop| {
            let down = one.places[1].keys().copied().map(f64::from_bits);
            let both = down.filter(|target| one.both(*target).is_some());
            both.collect::<Vec<_>>()
        };
        let mut targets: Vec<f64> = self.all.iter().flat_map(of_loop).collect();
        targets.sort_by(|a, b| a.abs().total_cmp(&b.abs()).then(a.total_cmp(b)));
        targets.dedup();
        targets
    }

    /// Whether the displacement grows (1) or falls (-1) with the size of loads of one sign.
    fn response_to(&self, sign: f64) -> f64 {
        let of_side = || self.stations().filter(|point| point.target_n * sign >= 0.0);
        let by_size =
            |a: &&LoopPoint, b: &&LoopPoint| a.target_n.abs().total_cmp(&b.target_n.abs());
        match (of_side().min_by(by_size), of_side().max_by(by_size)) {
            (Some(least), Some(most)) => (most.displacement_m - least.displacement_m).signum(),
            _ => sign,
        }
    }

    /// Widths at all loads of both branches.
    fn widths(&self, gauges: &GaugePair) -> Vec<LoopWidth> {
        let last = self.stations().rfind(|point| point.target_n != 0.0);
        // Without load the loop ends where it was loaded last.
        let last = last.map_or(1.0, |point| point.target_n.signum());
        let lags = [-1.0, 1.0].map(|sign| self.response_to(sign));
        let width = |target_n: f64| {
            let sign = if target_n == 0.0 {
                last
            } else {
                target_n.signum()
            };
            self.width(target_n, lags[usize::from(sign > 0.0)], gauges)
        };
        self.targets().into_iter().filter_map(width).collect()
    }

    /// The width at a load.
    ///
    /// # Arguments
    /// - `lag`: 1 where a displacement that lags behind is larger while unloading, else -1.
    fn width(&self, target_n: f64, lag: f64, gauges: &GaugePair) -> Option<LoopWidth> {
        let loops = self.all.iter();
        let both: Vec<(&Loop, [usize; 2])> = loops
            .filter_map(|one| Some((one, one.both(target_n)?)))
            .collect();
        let forces = both
            .iter()
            .flat_map(|(one, places)| places.map(|place| one.stations[place].force_n));
        let force_n = mean(&forces.collect::<Vec<_>>())?;
        let mut slopes = Vec::new();
        let widths = both.iter().map(|(one, places)| {
            let [up, down] = places.map(|place| one.at_force(place, force_n));
            slopes.extend([up.1, down.1]);
            lag * (down.0 - up.0)
        });
        let widths: Vec<f64> = widths.collect();
        let compliance = mean(&slopes)?.abs();
        Some(LoopWidth {
            target_n,
            force_n,
            width_m: estimate(&widths, &BranchKnowledge::of(gauges, compliance, force_n))?,
        })
    }

    /// Distance between the middles of both branches at +3 and -3 % of the largest load.
    fn lost_motion_m(&self) -> Result<Estimate, NoHysteresis> {
        let targets = self.targets();
        let has = |sign: f64| targets.iter().any(|target| target * sign > 0.0);
        if !(has(1.0) && has(-1.0)) {
            return Err(NoHysteresis::OneSign);
        }
        let loads = self.points().map(|point| point.target_n.abs());
        let largest = loads.fold(0.0, f64::max);
        let nearest = |sign: f64| {
            let at = sign * LOST_MOTION_AT * largest;
            let off = |target: &f64| (target - at).abs();
            let by_distance = |a: &f64, b: &f64| off(a).total_cmp(&off(b));
            let nearest = targets.iter().copied().min_by(by_distance)?;
            (off(&nearest) <= NEAR * largest && nearest != 0.0).then_some((at, nearest))
        };
        let ends = nearest(1.0).zip(nearest(-1.0));
        let (above, below) = ends.ok_or(NoHysteresis::NoSmallLoads)?;
        let response = self.response_to(1.0);
        let of_loop = |one: &Loop| {
            let middle = |(at, target): (f64, f64)| {
                let both = one.both(target)?.map(|place| one.at_force(place, at).0);
                Some(0.5 * (both[0] + both[1]))
            };
            Some(response * (middle(above)? - middle(below)?))
        };
        let all: Vec<f64> = self.all.iter().filter_map(of_loop).collect();
        estimate(&all, &BranchKnowledge::default()).ok_or(NoHysteresis::NoSmallLoads)
    }

    /// Area of the loops.
    fn energy_j(&self) -> Estimate {
        let all: Vec<f64> = self.all.iter().map(Loop::area_j).collect();
        estimate(&all, &BranchKnowledge::default()).unwrap_or(Estimate::without_uncertainty(0.0))
    }

    /// The forces at the ends of a loop that is open: the mean of all loops.
    fn closing_line_n(&self) -> Option<[f64; 2]> {
        let forces = |of: fn(&[LoopPoint]) -> Option<&LoopPoint>| {
            let ends = self.all.iter();
            let ends = ends.filter_map(|one| Some(of(&one.points)?.force_n));
            mean(&ends.collect::<Vec<_>>())
        };
        let [last, first] = [forces(<[_]>::last)?, forces(<[_]>::first)?];
        let sizes = self.points().map(|point| point.force_n.abs());
        let largest = sizes.fold(0.0, f64::max);
        ((last - first).abs() > CLOSED_WITHIN * largest).then_some([last, first])
    }
}

/// What is known beforehand of the difference between two branches, m.
#[derive(Debug, Clone, Copy, Default)]
struct BranchKnowledge {
    /// A step of both displays.
    step: f64,
    /// Standard uncertainty by the reversibility of both gauges.
    reversal: f64,
}

impl BranchKnowledge {
    fn of(gauges: &GaugePair, compliance_m_per_n: f64, force_n: f64) -> Self {
        let GaugePair {
            force,
            displacement,
        } = gauges;
        // Without load the force is zero, and no rounded one.
        let of_force = if force_n == 0.0 {
            0.0
        } else {
            compliance_m_per_n
        };
        let both = |of: fn(&GaugeTerms) -> Option<f64>| {
            let [in_force, in_displacement] =
                [force, displacement].map(|one| of(one).unwrap_or(0.0));
            (in_force * of_force).hypot(in_displacement)
        };
        Self {
            step: both(GaugeTerms::resolution),
            reversal: both(GaugeTerms::reversibility) / 3.0_f64.sqrt(),
        }
    }
}

/// The mean of one value a loop; `None` without any.
fn estimate(values: &[f64], known: &BranchKnowledge) -> Option<Estimate> {
    let value = mean(values)?;
    let Some(sd) = standard_deviation(values) else {
        return Some(Estimate::without_uncertainty(value));
    };
    let count = values.len() as f64;
    let is_averaged = sd >= ROUNDING_IS_AVERAGED_FROM_STEPS * known.step;
    // Both readings of a difference are rounded.
    let of_step = if is_averaged {
        0.0
    } else {
        known.step / 6.0_f64.sqrt()
    };
    let parts = [
        (sd / count.sqrt(), count - 1.0),
        (of_step.hypot(known.reversal), f64::INFINITY),
    ];
    Some(Estimate {
        value,
        standard_uncertainty: parts[0].0.hypot(parts[1].0),
        dof: if parts[1].0 == 0.0 {
            count - 1.0
        } else {
            welch_satterthwaite(&parts)
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stiffness::sample::{cell, reading};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Compliance of the part, m/N.
    const COMPLIANCE: f64 = 0.1e-6;

    /// A spring and, in series, a slider that lags behind by a friction, N, in a loop of loads; play beside it where the load changes its sign, m.
    fn part(loads_n: &[f64], friction_n: f64, play_m: f64) -> Vec<f64> {
        let mut slider = 0.0_f64;
        let one = |force: &f64| {
            slider = slider.clamp(force - friction_n, force + friction_n);
            let play = 0.5 * play_m * force.signum() * f64::from(u8::from(*force != 0.0));
            COMPLIANCE * (force + 0.5 * slider) + play
        };
        loads_n.iter().map(one).collect()
    }

    /// Loads up and down, `step` N each, to `count` steps.
    fn up_and_down(step: f64, count: i32) -> Vec<f64> {
        let up = 0..=count;
        up.clone()
            .chain(up.rev().skip(1))
            .map(|k| step * f64::from(k))
            .collect()
    }

    /// Readings of some runs of such loads. The forces are set about their targets, and both gauges have noise.
    fn bench(
        targets: &[f64],
        [friction_n, play_m]: [f64; 2],
        [setting_n, force_sd_n, sd_m]: [f64; 3],
        runs: u32,
        seed: u64,
    ) -> Vec<Reading> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = move || -> f64 { random.sample(StandardNormal) };
        let top = targets.iter().map(|n| n.abs()).fold(0.0, f64::max);
        let mut all = Vec::new();
        for run in 1..=runs {
            let mut is_back = false;
            let mut set = |target: &f64| {
                target
                    + if *target == 0.0 {
                        0.0
                    } else {
                        setting_n * normal()
                    }
            };
            let forces: Vec<f64> = targets.iter().map(&mut set).collect();
            let answers = part(&forces, friction_n, play_m);
            for (step, &target) in targets.iter().enumerate() {
                let of_gauge = if target == 0.0 {
                    0.0
                } else {
                    force_sd_n * normal()
                };
                let answer = answers[step] + sd_m * normal();
                let force = forces[step] + of_gauge;
                let mut one = reading(run, step as u32, target, force, answer);
                if is_back {
                    one.branch = Branch::Unloading;
                }
                is_back = (is_back || target.abs() == top) && !(is_back && target == 0.0);
                all.push(one);
            }
        }
        all
    }

    fn loop_of(readings: &[Reading], gauges: &GaugePair) -> Hysteresis {
        let all: Vec<&Reading> = readings.iter().collect();
        Hysteresis::of(&cell(), &all, gauges).unwrap()
    }

    #[test]
    fn the_loop_of_a_slider_has_its_width_rest_and_area() {
        let loads = up_and_down(-10.0, 7);
        let loop_of_part = part(&loads, 4.0, 0.0);
        let found = loop_of(
            &bench(&loads, [4.0, 0.0], [0.0; 3], 2, 1),
            &GaugePair::default(),
        );
        assert_eq!((found.n_loops, found.widths.len()), (2, 7));
        // Twice the friction on the slider, but for no load, where it never slid on the way up.
        for width in &found.widths {
            let friction = if width.target_n == 0.0 { 4.0 } else { 8.0 };
            let expected = COMPLIANCE * 0.5 * friction;
            assert!((width.width_m.value - expected).abs() < 1e-12, "{width:?}");
        }
        assert!((found.largest.width_m - 0.4e-6).abs() < 1e-12);
        let rest = found.residual_m.unwrap();
        assert!((rest.value - 0.2e-6).abs() < 1e-12);
        // 8 N of width at the slider over 62 N, and the corners at both ends.
        let steps = loads.iter().zip(&loop_of_part);
        let pairs: Vec<_> = steps.collect();
        let area: f64 = pairs
            .windows(2)
            .map(|w| 0.5 * (w[0].0 + w[1].0) * (w[1].1 - w[0].1))
            .sum();
        assert!((found.energy_j.value - area).abs() < 1e-15 && area > 0.0);
        assert_eq!(found.closing_line_n, None);
        assert_eq!(found.lost_motion_m, Err(NoHysteresis::OneSign));
    }

    #[test]
    fn play_is_lost_motion_where_small_loads_of_both_signs_were_read() {
        let mut loads = vec![0.0];
        let there = [3.0, 50.0, 100.0, 50.0, 3.0, 0.0];
        loads.extend(there);
        loads.extend(there.map(|n| -n));
        let readings = bench(&loads, [0.0, 20e-6], [0.0; 3], 3, 1);
        let lost = loop_of(&readings, &GaugePair::default())
            .lost_motion_m
            .unwrap();
        // The play, and the spring of 0.15 µm/N over 6 N.
        assert!((lost.value - 20.9e-6).abs() < 1e-12, "{lost:?}");
        let coarse: Vec<Reading> = readings
            .iter()
            .filter(|one| one.target_n.abs() != 3.0)
            .cloned()
            .collect();
        let lost = loop_of(&coarse, &GaugePair::default()).lost_motion_m;
        assert_eq!(lost, Err(NoHysteresis::NoSmallLoads));
    }

    /// Loads of a continuous record, -70 N and back in `count` readings each way: none is aimed at.
    fn ramps(count: i32) -> Vec<f64> {
        let up = up_and_down(-70.0 / f64::from(count), count);
        // Not the same loads on the way back.
        let off = 0.3 * 70.0 / f64::from(count);
        let shift =
            |(place, load): (usize, &f64)| load + off * f64::from(u8::from(place > count as usize));
        up.iter().enumerate().map(shift).collect()
    }

    #[test]
    fn a_continuous_record_is_compared_at_shares_of_its_largest_load() {
        let mut readings = bench(&ramps(100), [4.0, 0.0], [0.0; 3], 1, 1);
        let mut later = readings.clone();
        for one in &mut later {
            one.seq += 1000;
            one.step += 1000;
        }
        readings.extend(later);
        let found = loop_of(&readings, &GaugePair::default());
        // Two cycles in one run. 3 % and tenths; where the record ends it is not quite without load.
        assert_eq!((found.n_loops, found.widths.len()), (2, 11));
        for width in found.widths.iter().skip(1) {
            // The slider stands still near both turns, from no load on by its friction and from 70 N back by twice that.
            let slid = (4.0 - width.force_n).min(70.0 + width.force_n);
            let expected = COMPLIANCE * 0.5 * slid.min(8.0);
            assert!(
                (width.width_m.value - expected).abs() < 0.02e-6,
                "{width:?}"
            );
            assert!((width.force_n - width.target_n).abs() < 0.5, "{width:?}");
        }
        let rest = found.residual_m.unwrap();
        assert!(
            (rest.value - 0.2e-6).abs() < 0.02e-6,
            "{:?}",
            found.widths[0]
        );
    }

    #[test]
    fn an_open_loop_names_the_line_that_closes_it() {
        let loads: Vec<f64> = up_and_down(-10.0, 7).into_iter().skip(1).collect();
        let readings = bench(&loads, [4.0, 0.0], [0.0; 3], 2, 1);
        let found = loop_of(&readings[..14], &GaugePair::default());
        assert_eq!(found.residual_m, Err(NoHysteresis::NoUnloaded));
        assert_eq!(found.closing_line_n, Some([0.0, -10.0]));
    }

    #[test]
    fn one_branch_has_no_loop_and_one_run_no_uncertainty() {
        let loads: Vec<f64> = (0..8).map(|k| -10.0 * f64::from(k)).collect();
        let mut readings = bench(&loads, [4.0, 0.0], [0.0; 3], 1, 1);
        for one in &mut readings {
            one.branch = Branch::Loading;
        }
        let all: Vec<&Reading> = readings.iter().collect();
        assert_eq!(Hysteresis::of(&cell(), &all, &GaugePair::default()), None);
        let loads = up_and_down(-10.0, 7);
        let readings = bench(&loads, [4.0, 0.0], [0.0; 3], 1, 1);
        let found = loop_of(&readings, &GaugePair::default());
        assert_eq!(found.largest.interval_m, None);
        assert_eq!(found.energy_j.expanded_95(), None);
    }

    #[test]
    fn a_return_to_zero_is_no_loop() {
        let mut loads: Vec<f64> = (0..8).map(|k| -10.0 * f64::from(k)).collect();
        loads.push(0.0);
        let readings = bench(&loads, [4.0, 0.0], [0.0; 3], 2, 1);
        let all: Vec<&Reading> = readings.iter().collect();
        assert_eq!(Hysteresis::of(&cell(), &all, &GaugePair::default()), None);
    }

    #[test]
    fn what_the_gauges_cannot_tell_counts_where_nothing_scatters() {
        let loads = up_and_down(-10.0, 7);
        let readings = bench(&loads, [4.0, 0.0], [0.0; 3], 5, 1);
        let terms = |resolution| crate::stiffness::GaugeTerms::new(Some(resolution), None, None);
        let gauges = GaugePair {
            force: terms(0.1).unwrap().with_reversibility(Some(0.3)),
            displacement: terms(1e-6).unwrap(),
        };
        let found = loop_of(&readings, &gauges);
        let at = found.widths.iter().find(|width| width.target_n == -40.0);
        // Steps of 1 µm and of 0.1 N through 0.15 µm/N, two readings; 0.3 N of reversibility through the same.
        let step = 1e-6_f64.hypot(0.015e-6) / 6.0_f64.sqrt();
        let expected = step.hypot(0.045e-6 / 3.0_f64.sqrt());
        let u = at.unwrap().width_m.standard_uncertainty;
        assert!((u / expected - 1.0).abs() < 1e-9, "{u}");
    }

    /// Counts over 1000 benches each, without friction and with three sizes of it, how often the intervals hold the truth: 93 to 97 %, the band of
    /// the largest width at least 93 %.
    #[test]
    fn intervals_hold_the_truth() {
        let there = [
            3.0, 20.0, 40.0, 60.0, 80.0, 100.0, 80.0, 60.0, 40.0, 20.0, 3.0, 0.0,
        ];
        let both: Vec<f64> = std::iter::once(0.0)
            .chain(there)
            .chain(there.map(|n| -n))
            .collect();
        for (size, friction_n) in [0.0, 2.0, 5.0, 20.0].into_iter().enumerate() {
            for loads in [up_and_down(-10.0, 7), ramps(60), both.clone()] {
                let exact = bench(&loads, [friction_n, 0.0], [0.0; 3], 2, 0);
                let truth = loop_of(&exact, &GaugePair::default());
                let (mut widths, mut rest, mut lost, mut band) = (0, 0, 0, 0);
                let count = 1000;
                for seed in 1..=count {
                    let seed = seed + count * size as u64;
                    let noise = [0.3, 0.05, 0.3e-6];
                    let readings = bench(&loads, [friction_n, 0.0], noise, 5, seed);
                    let found = loop_of(&readings, &GaugePair::default());
                    let holds = |own: &Estimate, truth: &Estimate| {
                        let [low, high] = own.interval_95().unwrap();
                        u32::from((low..=high).contains(&truth.value))
                    };
                    let pairs = found.widths.iter().zip(&truth.widths);
                    widths += pairs
                        .map(|(a, b)| holds(&a.width_m, &b.width_m))
                        .sum::<u32>();
                    rest += holds(&found.residual_m.unwrap(), &truth.residual_m.unwrap());
                    if let (Ok(own), Ok(truth)) = (&found.lost_motion_m, &truth.lost_motion_m) {
                        lost += holds(own, truth);
                    }
                    let [low, high] = found.largest.interval_m.unwrap();
                    band += u32::from((low..=high).contains(&truth.largest.width_m));
                }
                let share = |hits: u32, of: u64| f64::from(hits) / of as f64;
                let widths = share(widths, count * truth.widths.len() as u64);
                let one = [widths, share(rest, count), share(band, count)];
                assert!((0.93..=0.97).contains(&one[0]), "{friction_n}: {one:?}");
                assert!((0.93..=0.97).contains(&one[1]), "{friction_n}: {one:?}");
                assert!(one[2] >= 0.93, "{friction_n}: {one:?}");
                if truth.lost_motion_m.is_ok() {
                    let lost = share(lost, count);
                    assert!((0.93..=0.97).contains(&lost), "{friction_n}: {lost}");
                }
            }
        }
    }
}
