//! Runs a plan of loads on a robot that exists as a beam model.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::readings::{
    Reading, ReadingTable, ReadingText, RepeatOrder, RunNumbers, Status, ZeroScope,
};
use crate::robot::{FittingFactors, Mechanism, Predictor, Robot, RobotError};
use crate::test_point::{Branch, Direction, PoseId};

use super::jack::Jack;
use super::noise::{NoiseModel, decimals, normal, rounded};

/// Micrometres in a metre.
const MICROMETRES: f64 = 1e6;

/// Which loads are applied where, in which order.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchPlan {
    /// Poses, in the order of measurement.
    pub poses: Vec<PoseId>,
    /// Directions, in the order of measurement.
    pub directions: Vec<Direction>,
    /// Target loads, N, signed, in the order of loading; unloading goes back through them.
    pub loads_n: Vec<f64>,
    /// Whether the loads are taken off in the same steps.
    pub unloading: bool,
    /// Applications of the sequence, or of each load.
    pub repeats: u32,
    /// Whether each load is repeated before the next, or the whole sequence.
    pub repeat_order: RepeatOrder,
    /// How long a gauge zero lasts.
    pub zero: ZeroScope,
}

impl BenchPlan {
    /// Sweeps of 0, -10, … -70 N in x, y, z, five times, zeroed before each run, in the given poses.
    #[must_use]
    pub fn sweeps(poses: Vec<PoseId>) -> Self {
        Self {
            poses,
            directions: Direction::ALL.to_vec(),
            loads_n: (0..8).map(|step| -10.0 * f64::from(step)).collect(),
            unloading: false,
            repeats: 5,
            repeat_order: RepeatOrder::Sweep,
            zero: ZeroScope::Run,
        }
    }

    /// Targets and branches of one application of the sequence.
    fn sequence(&self) -> Vec<(f64, Branch)> {
        let up = self.loads_n.iter().map(|&load| (load, Branch::Loading));
        let down = self
            .loads_n
            .iter()
            .rev()
            .skip(1)
            .map(|&load| (load, Branch::Unloading));
        up.chain(down.filter(|_| self.unloading)).collect()
    }

    /// Repeat and step of every reading of a cell, in the order in which they are made.
    fn order(&self, steps: u32) -> Vec<(u32, u32)> {
        let repeats = 1..=self.repeats;
        match self.repeat_order {
            RepeatOrder::Sweep => repeats
                .flat_map(|repeat| (0..steps).map(move |step| (repeat, step)))
                .collect(),
            RepeatOrder::AtLoad => (0..steps)
                .flat_map(|step| repeats.clone().map(move |repeat| (repeat, step)))
                .collect(),
        }
    }
}

/// Why a virtual bench cannot run.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum BenchError {
    /// The robot cannot take a pose, or its structure cannot carry a load.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// A plan that asks for nothing, or for what no gauge can read.
    #[error("the plan has {what}")]
    #[diagnostic(
        code(stiffbench::bench::plan),
        help(
            "give at least one pose, direction, load and repeat; loads are finite numbers of newtons"
        )
    )]
    Plan {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A size of the noise that is negative or not finite.
    #[error("{what} is {value}: it must be finite and not negative")]
    #[diagnostic(code(stiffbench::bench::noise))]
    Noise {
        /// Which size.
        what: &'static str,
        /// Its value, SI.
        value: f64,
    },
}

/// A robot on a bench, in software.
#[derive(Debug)]
pub struct VirtualBench<'a> {
    predictor: Predictor<'a>,
    robot: &'a Robot,
    noise: NoiseModel,
    jack: Jack,
}

impl<'a> VirtualBench<'a> {
    /// Sets a mechanism with its true factors on the bench.
    ///
    /// # Errors
    /// [`BenchError::Robot`], [`BenchError::Noise`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
        noise: NoiseModel,
        jack: Jack,
    ) -> Result<Self, BenchError> {
        for (what, value) in [
            ("the reading error", noise.reading_sd_m),
            ("the zero error", noise.zero_sd_m),
            ("the run-to-run slope", noise.run_slope_sd),
            (
                "the step of the displacement gauge",
                noise.displacement_step_m,
            ),
            ("the step of the force gauge", noise.force_step_n),
            ("the tolerance of the jack", jack.force_tolerance_n),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BenchError::Noise { what, value });
            }
        }
        Ok(Self {
            predictor: Predictor::new(robot, mechanism, factors)?,
            robot,
            noise,
            jack,
        })
    }

    /// Carries out a plan; the same seed gives the same readings.
    ///
    /// # Errors
    /// [`BenchError::Plan`]; [`BenchError::Robot`] for a pose that is unknown or cannot be reached.
    pub fn run(
        &mut self,
        plan: &BenchPlan,
        session: &str,
        seed: u64,
    ) -> Result<ReadingTable, BenchError> {
        check(plan)?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut recorder = Recorder::default();
        for pose in &plan.poses {
            self.predictor.place(self.robot.pose(pose)?)?;
            let compliance = self.predictor.translation_compliance();
            for &direction in &plan.directions {
                let i = direction.index();
                self.run_cell(
                    plan,
                    pose,
                    direction,
                    compliance[i][i],
                    &mut rng,
                    &mut recorder,
                );
            }
        }
        Ok(recorder.finish(session))
    }

    fn run_cell(
        &self,
        plan: &BenchPlan,
        pose: &PoseId,
        direction: Direction,
        compliance_m_per_n: f64,
        rng: &mut ChaCha8Rng,
        recorder: &mut Recorder,
    ) {
        let sequence = plan.sequence();
        let runs: Vec<f64> = (0..plan.repeats)
            .map(|_| normal(rng, self.noise.run_slope_sd))
            .collect();
        let mut zero_m = 0.0;
        let mut zeroed = None;
        for (repeat, step) in plan.order(sequence.len() as u32) {
            let zero_of = if plan.zero == ZeroScope::Cell {
                0
            } else {
                repeat
            };
            if zeroed != Some(zero_of) {
                zeroed = Some(zero_of);
                zero_m = normal(rng, self.noise.zero_sd_m);
                recorder.time_s += Jack::seconds(self.jack.seconds_per_zero, rng);
            }
            recorder.time_s += Jack::seconds(self.jack.seconds_per_reading, rng);
            let (target_n, branch) = sequence[step as usize];
            let force_n = self.jack.force_n(target_n, rng);
            let mechanics_m = force_n * compliance_m_per_n * (1.0 + runs[repeat as usize - 1]);
            let displacement_m = mechanics_m + zero_m + normal(rng, self.noise.reading_sd_m);
            let shown_n = rounded(force_n, self.noise.force_step_n);
            let shown_um = rounded(displacement_m, self.noise.displacement_step_m) * MICROMETRES;
            let force_raw = format!("{shown_n:.*}", decimals(self.noise.force_step_n));
            let displacement_raw = format!(
                "{shown_um:.*}",
                decimals(self.noise.displacement_step_m * MICROMETRES)
            );
            let cell_label = (plan.zero == ZeroScope::Cell).then_some("cell");
            let run = recorder.runs.number(pose, direction, repeat, None);
            let zero = recorder.zeros.number(pose, direction, repeat, cell_label);
            recorder.add(Reading {
                line: 0,
                seq: 0,
                run,
                zero,
                pose: pose.clone(),
                direction,
                branch,
                step,
                repeat,
                attempt: 1,
                status: Status::Accepted,
                target_n,
                // The numbers are those that the instruments show, so that text and number agree.
                force_n: force_raw.parse().unwrap_or(shown_n),
                displacement_m: displacement_raw.parse::<f64>().unwrap_or(shown_um) / MICROMETRES,
                time_s: Some((recorder.time_s * 100.0).round() / 100.0),
                hold_s: Some((Jack::seconds(self.jack.hold_s, rng) * 10.0).round() / 10.0),
                temperature_deg_c: None,
                text: Some(Box::new(ReadingText {
                    force_raw: force_raw.into(),
                    displacement_raw: displacement_raw.into(),
                    ..ReadingText::default()
                })),
            });
        }
    }
}

/// Readings as they come in.
#[derive(Debug, Default)]
struct Recorder {
    readings: Vec<Reading>,
    runs: RunNumbers,
    zeros: RunNumbers,
    time_s: f64,
}

impl Recorder {
    fn add(&mut self, mut reading: Reading) {
        reading.seq = self.readings.len() as u32 + 1;
        self.readings.push(reading);
    }

    fn finish(self, session: &str) -> ReadingTable {
        ReadingTable {
            source: format!("simulation {session}"),
            session: Some(session.to_owned()),
            readings: self.readings,
            runs: self.runs.into_keys(),
            zeros: self.zeros.into_keys(),
            ..ReadingTable::default()
        }
    }
}

/// Refuses plans that make no reading or no number.
fn check(plan: &BenchPlan) -> Result<(), BenchError> {
    let wrong = |what| Err(BenchError::Plan { what });
    if plan.poses.is_empty() {
        return wrong("no pose");
    }
    if plan.directions.is_empty() {
        return wrong("no direction");
    }
    if plan.loads_n.is_empty() {
        return wrong("no load");
    }
    if plan.repeats == 0 {
        return wrong("no repeat");
    }
    if plan.loads_n.iter().any(|load| !load.is_finite()) {
        return wrong("a load that is not a number");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::shipped_robot;

    fn robot() -> Robot {
        Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
    }

    fn table(noise: NoiseModel, plan: &BenchPlan, seed: u64) -> ReadingTable {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        VirtualBench::new(&robot, mechanism, &factors, noise, Jack::default())
            .unwrap()
            .run(plan, "s", seed)
            .unwrap()
    }

    #[test]
    fn a_bench_without_noise_reads_the_beam_model() {
        let robot = robot();
        let plan = BenchPlan {
            unloading: true,
            ..BenchPlan::sweeps(vec!["P1".into()])
        };
        let table = table(NoiseModel::NONE, &plan, 1);
        assert_eq!(table.readings.len(), 3 * 5 * 15);
        let mechanism = robot.mechanism(None).unwrap();
        let mut predictor =
            Predictor::new(&robot, mechanism, &robot.factor_set("m_fsd").unwrap()).unwrap();
        predictor.place(robot.pose(&"P1".into()).unwrap()).unwrap();
        let compliance = predictor.translation_compliance();
        for reading in &table.readings {
            let i = reading.direction.index();
            let expected = reading.force_n * compliance[i][i];
            // The text shows nine decimals of a micrometre.
            assert!((reading.displacement_m - expected).abs() < 1e-13 + 1e-9 * expected.abs());
            assert!((reading.force_n - reading.target_n).abs() <= 0.5);
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_readings_and_another_does_not() {
        let plan = BenchPlan::sweeps(vec!["P1".into(), "P3".into()]);
        let [a, b, c] = [7, 7, 8].map(|seed| table(NoiseModel::default(), &plan, seed).readings);
        assert_eq!(a, b);
        assert_ne!(a, c);
    }

    #[test]
    fn the_papers_order_repeats_each_load_on_one_zero() {
        let plan = BenchPlan {
            repeat_order: RepeatOrder::AtLoad,
            zero: ZeroScope::Cell,
            ..BenchPlan::sweeps(vec!["P2".into()])
        };
        let table = table(NoiseModel::default(), &plan, 0);
        let first: Vec<(u32, u32)> = table
            .readings
            .iter()
            .take(6)
            .map(|r| (r.step, r.repeat))
            .collect();
        assert_eq!(first, [(0, 1), (0, 2), (0, 3), (0, 4), (0, 5), (1, 1)]);
        assert_eq!((table.runs.len(), table.zeros.len()), (15, 3));
    }

    #[test]
    fn a_plan_without_loads_or_a_noise_below_zero_is_refused() {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let noise = NoiseModel {
            zero_sd_m: -1.0,
            ..NoiseModel::default()
        };
        let bench = VirtualBench::new(
            &robot,
            mechanism,
            &FittingFactors::UNIT,
            noise,
            Jack::default(),
        );
        assert!(matches!(
            bench,
            Err(BenchError::Noise {
                what: "the zero error",
                ..
            })
        ));
        let mut bench = VirtualBench::new(
            &robot,
            mechanism,
            &FittingFactors::UNIT,
            NoiseModel::NONE,
            Jack::default(),
        )
        .unwrap();
        let plan = BenchPlan {
            loads_n: Vec::new(),
            ..BenchPlan::sweeps(vec!["P1".into()])
        };
        assert!(matches!(
            bench.run(&plan, "s", 0),
            Err(BenchError::Plan { what: "no load" })
        ));
    }
}
