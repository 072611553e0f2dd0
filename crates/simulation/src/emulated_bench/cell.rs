//! One pose and direction: where force and displacement stand at rest, for every load of the procedure.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use crate::jack;
use crate::mechanics::{ActingLoad, CellMechanics};
use crate::temperature::TemperatureTrack;
use stiffbench_beams::physics::{LawSet, LoadPoint, PoseMechanics};
use stiffbench_measurement::procedure::{PlannedReading, Procedure};
use stiffbench_measurement::readings::ZeroScope;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::EmulatedSetup;
use super::motion::Stand;

/// The operator stops within this share of the tolerance, so that a load counts as set.
const STOPPING_SHARE: f64 = 0.8;

/// Where the tip of the gauge is set up within its range, m.
const TIP_M: [f64; 2] = [0.2e-3, 2.2e-3];

/// How long before an extra reading under a load the displacement goes on to where it stands then, s.
const BEFORE_EXTRA_READING_S: f64 = 10.0;

/// Which cell.
#[derive(Debug, Clone)]
pub(super) struct CellKey {
    pub(super) pose: PoseId,
    pub(super) direction: LoadDirection,
    /// Place in the order of measurement, from 0.
    pub(super) number: u32,
}

/// A cell, computed.
#[derive(Debug)]
pub(super) struct SolvedCell {
    key: CellKey,
    setup: EmulatedSetup,
    planned: Vec<PlannedReading>,
    /// Where everything stands at each planned reading.
    stands: Vec<Stand>,
    /// By how much each gauge has drifted since its zero at each of them, m.
    drifts_m: Vec<[f64; 3]>,
    tolerance_n: f64,
    zero: ZeroScope,
    /// Displacement per force of a first load where gauges stand, m/N.
    first_load_m_per_n: [f64; 3],
    /// Whether gauges stay along base axes, each with a noise of its own.
    several_gauges: bool,
    /// Where the tips of the gauges were set up, m.
    tip_m: f64,
}

impl SolvedCell {
    pub(super) fn new(
        key: CellKey,
        [laws, drift]: [&LawSet; 2],
        structure: &PoseMechanics,
        procedure: &Procedure,
        setup: &EmulatedSetup,
    ) -> Self {
        let planned = procedure.steps(key.number);
        let mut cell = Self {
            setup: *setup,
            stands: Vec::new(),
            drifts_m: Vec::new(),
            tolerance_n: procedure.settle.force_tolerance_n,
            zero: procedure.zero,
            first_load_m_per_n: [0.0; 3],
            several_gauges: !procedure.displacement_axes.is_empty(),
            tip_m: 0.0,
            key,
            planned,
        };
        cell.tip_m = TIP_M[0] + (TIP_M[1] - TIP_M[0]) * cell.random("tip", &[]).random::<f64>();
        let loads = cell.loads(procedure);
        let load = &cell.key.direction;
        let read = procedure.axes_read_under(load);
        let mechanics = CellMechanics {
            laws,
            structure,
            pose: &cell.key.pose,
            load,
            release_n: procedure.release_n(),
            keep_history: false,
            zero_each_run: false,
        };
        let drifting = CellMechanics {
            laws: drift,
            ..mechanics
        };
        let unloaded: Vec<ActingLoad> = loads.iter().map(ActingLoad::unloaded).collect();
        cell.drifts_m = drifting.along_m(&read, &unloaded);
        let first = ActingLoad {
            point: LoadPoint {
                force_n: match procedure.preload_n {
                    0.0 => procedure.load_sense(),
                    preload_n => preload_n,
                },
                ..LoadPoint::default()
            },
            run_slope: 0.0,
            repeat: 1,
            branch: Branch::Loading,
            time_s: 0.0,
            temperature_deg_c: 0.0,
        };
        let first_m = mechanics.along_m(&Direction::ALL, &[first])[0];
        cell.first_load_m_per_n = first_m.map(|along_m| along_m / first.point.force_n);
        let m_per_n = Direction::ALL.map(|axis| structure.compliance(&axis.into(), load));
        let stands = loads
            .iter()
            .zip(mechanics.along_m(&read, &loads))
            .enumerate();
        let stands = stands.map(|(place, (load, along_m))| {
            let planned = &cell.planned[place];
            let slope = cell.error("slope", setup.noise.run_slope_sd, &[planned.repeat]);
            let numbers = [planned.step, planned.repeat, cell.hold_number(place)];
            let errors_m = cell.gauge_errors_m("reading", setup.noise.reading_sd_m, &numbers);
            let force_n = load.point.force_n;
            Stand {
                force_n,
                along_m: [0, 1, 2].map(|axis| {
                    cell.tip_m + along_m[axis] + slope * m_per_n[axis] * force_n + errors_m[axis]
                }),
            }
        });
        cell.stands = stands.collect();
        cell
    }

    /// Where everything stands under a force without the errors of a reading.
    fn first_load(&self, force_n: f64) -> Stand {
        Stand {
            force_n,
            along_m: self
                .first_load_m_per_n
                .map(|m_per_n| self.tip_m + m_per_n * force_n),
        }
    }

    /// Where everything stands under a force at which nothing is read: free, or under the preload. The errors of the gauges' zeros stand here.
    pub(super) fn at_rest(&self, force_n: f64, repeat: u32) -> Stand {
        let numbers: &[u32] = match self.zero {
            ZeroScope::Cell => &[],
            ZeroScope::Run => &[repeat],
        };
        let zeros_m = self.gauge_errors_m("zero", self.setup.noise.zero_sd_m, numbers);
        let mut stand = self.first_load(force_n);
        for (along_m, zero_m) in stand.along_m.iter_mut().zip(zeros_m) {
            *along_m -= zero_m;
        }
        stand
    }

    /// By how much each gauge has drifted since its zero at a load of the procedure, m.
    pub(super) fn drift_m(&self, step: u32, repeat: u32) -> [f64; 3] {
        let mut readings = self.planned.iter().zip(&self.drifts_m);
        let at = readings.find(|(planned, _)| (planned.step, planned.repeat) == (step, repeat));
        at.map_or([0.0; 3], |(_, drift_m)| *drift_m)
    }

    /// By how much everything moves under a little more force.
    pub(super) fn more_load(&self, by_n: f64) -> Stand {
        Stand {
            force_n: by_n,
            along_m: self.first_load_m_per_n.map(|m_per_n| m_per_n * by_n),
        }
    }

    /// Where everything stands under a load and, under the same load, at its extra readings: times after the jack has stopped, s, and stands.
    pub(super) fn stages(&self, target_n: f64, step: u32, repeat: u32) -> Vec<(f64, Stand)> {
        let readings = self.planned.iter().zip(&self.stands);
        let of_load = readings.filter(|(planned, _)| {
            (planned.step, planned.repeat, planned.target_n) == (step, repeat, target_n)
        });
        let mut before_s = 0.0;
        let stages: Vec<(f64, Stand)> = of_load
            .map(|(planned, stand)| {
                let hold_s = planned.extra_hold_s.unwrap_or(0.0);
                let lead_s = BEFORE_EXTRA_READING_S.min((hold_s - before_s) / 2.0);
                before_s = hold_s;
                (hold_s - lead_s, *stand)
            })
            .collect();
        if stages.is_empty() {
            return vec![(0.0, self.not_planned(target_n, step, repeat))];
        }
        stages
    }

    /// A load that the procedure does not have.
    fn not_planned(&self, target_n: f64, step: u32, repeat: u32) -> Stand {
        self.first_load(self.force_n(target_n, step, repeat))
    }

    /// The loads of the procedure as the operator sets them, at the times that its pace plans.
    fn loads(&self, procedure: &Procedure) -> Vec<ActingLoad> {
        let pace = &self.setup.jack.pace;
        let released_s = procedure.release_n().map_or(0.0, |_| pace.release_s);
        let cell_s = pace.direction_s + pace.seconds(procedure, &self.planned);
        let mut time_s = f64::from(self.key.number) * cell_s;
        let mut zero_at_s = time_s;
        let mut hold_s = 0.0;
        let temperature = TemperatureTrack::new(self.setup.seed);
        let loads = self.planned.iter().map(|planned| {
            if planned.zero_before {
                time_s += pace.zero_s;
                zero_at_s = time_s;
            }
            if let Some(extra_s) = planned.extra_hold_s {
                time_s += (extra_s - hold_s).max(0.0);
                hold_s = extra_s;
            } else {
                time_s += pace.reading_s + released_s;
                hold_s = pace.hold_s;
            }
            let temperature_deg_c = temperature.at(time_s);
            ActingLoad {
                point: LoadPoint {
                    force_n: self.force_n(planned.target_n, planned.step, planned.repeat),
                    step: planned.step,
                    hold_s,
                    since_zero_s: time_s - zero_at_s,
                    warming_k: temperature_deg_c - temperature.at(zero_at_s),
                    position_m: None,
                    seated_m: 0.0,
                    is_unloaded: planned.target_n == 0.0,
                },
                run_slope: 0.0,
                repeat: planned.repeat,
                branch: planned.branch,
                time_s,
                temperature_deg_c,
            }
        });
        loads.collect()
    }

    /// The force at which the operator stops.
    fn force_n(&self, target_n: f64, step: u32, repeat: u32) -> f64 {
        let mut random = self.random("stop", &[step, repeat]);
        jack::force_n(target_n, STOPPING_SHARE * self.tolerance_n, &mut random)
    }

    /// Which reading under its load a planned one is, from 0.
    fn hold_number(&self, place: usize) -> u32 {
        let reading = &self.planned[place];
        let before = self.planned[..place].iter().rev();
        let of_load = before
            .take_while(|earlier| (earlier.step, earlier.repeat) == (reading.step, reading.repeat));
        of_load.count() as u32
    }

    fn error(&self, what: &str, sd: f64, numbers: &[u32]) -> f64 {
        self.setup.noise.error(sd, &mut self.random(what, numbers))
    }

    /// An error of each gauge; of one gauge along the load the same wherever it stands.
    fn gauge_errors_m(&self, what: &str, sd_m: f64, numbers: &[u32]) -> [f64; 3] {
        if !self.several_gauges {
            return [self.error(what, sd_m, numbers); 3];
        }
        [0, 1, 2].map(|axis| self.error(what, sd_m, &[numbers, &[axis]].concat()))
    }

    /// Random numbers that belong to one thing of this cell and to no other.
    fn random(&self, what: &str, numbers: &[u32]) -> ChaCha8Rng {
        let CellKey {
            pose, direction, ..
        } = &self.key;
        let name = format!("{} {what} {numbers:?} {direction} {pose}", self.setup.seed);
        ChaCha8Rng::from_seed(Sha256::digest(name.as_bytes()).into())
    }
}
