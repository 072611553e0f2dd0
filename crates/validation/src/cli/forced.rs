//! The part of `prove` that states a law, simulates it, and counts how often the intervals of what is fitted hold the truth.

use rayon::prelude::*;

use stiffbench::analysis::{
    Data, DiagnoseSettings, DiagnosisData, ModelChoice, OpenSettings, Subject,
};
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::progress::progress;
use stiffbench::mismatch::{
    Baseline, Observations, ReadingNoise, RobotBaseline, TrialNoise, Truth, scale_to,
};
use stiffbench::physics::{Effect, Law, PlaceScale};
use stiffbench::specimen::ResponseVariable;

use crate::prove::{
    DoorAnswer, DoorBench, DoorJudge, ForcedPoint, PartBench, UNKNOWN_SCALE, coverage, may_be,
    stated_values,
};

use super::doors::{Doors, TrueFactors, temporary};
use super::prove_args::{ForcedDoor, ProveArgs};

/// What is counted.
pub(super) struct ForcedPlan {
    pub(super) laws: Vec<Law>,
    /// Standard errors.
    pub(super) sizes: Vec<f64>,
    /// Trials of each law, size and door.
    pub(super) trials: usize,
}

/// A law of a size by a door.
struct ForcedCase<'a> {
    door: &'static str,
    bench: &'a str,
    effect: Effect,
    size: f64,
    /// Of each factor, and of each value of the law.
    truth: TrueFactors,
    by: Readings<'a>,
}

/// Where the readings of a trial come from.
enum Readings<'a> {
    Robot(&'a DoorBench, DoorJudge),
    Part(&'a PartBench),
}

/// Counts intervals. Each law acts on the first bench that has a sample of it.
pub(super) fn judge_forced(
    args: &ProveArgs,
    global: &Global,
    plan: &ForcedPlan,
) -> Result<Vec<ForcedPoint>, Failure> {
    let doors = Doors::new(args)?;
    let parts = [
        ("force set", ResponseVariable::Displacement),
        ("displacement set", ResponseVariable::Force),
    ];
    let mut cases = Vec::new();
    let mut part_benches = Vec::new();
    for door in args.doors() {
        match door.judge() {
            Some(judge) => cases.extend(doors.forced((door.name(), judge), plan)?),
            None => {
                for (name, response) in parts {
                    part_benches.push((name, PartBench::new(response)?));
                }
            }
        }
    }
    for (bench, part) in &part_benches {
        let effects = part.effects.iter();
        for effect in effects.filter(|effect| plan.laws.contains(&effect.law)) {
            for &size in &plan.sizes {
                let Some(effect) = part.scaled(effect, size)? else {
                    continue;
                };
                cases.push(ForcedCase {
                    door: ForcedDoor::Part.name(),
                    bench,
                    size,
                    truth: part.true_values(&effect),
                    effect,
                    by: Readings::Part(part),
                });
            }
        }
    }
    let bar = progress(global, "laws stated", (cases.len() * plan.trials) as u64);
    let points = cases.iter().enumerate().map(|(number, case)| {
        let first = args.seed + (number * plan.trials) as u64;
        let answers = (1..=plan.trials as u64).into_par_iter().map(|trial| {
            let answer = doors.told(case, first + trial);
            bar.inc(1);
            answer
        });
        let answers = answers.collect::<Result<Vec<DoorAnswer>, Failure>>()?;
        Ok(ForcedPoint {
            law: case.effect.law.row,
            door: case.door,
            bench: case.bench.to_owned(),
            effect: case.effect.compact(),
            size: case.size,
            coverage: coverage(case.door, &answers, &case.truth),
        })
    });
    let points = points.collect();
    bar.finish_and_clear();
    points
}

impl Doors<'_> {
    /// What fit and diagnosis answer of a trial, told of its law.
    fn told(&self, case: &ForcedCase<'_>, seed: u64) -> Result<DoorAnswer, Failure> {
        let (bench, judge) = match case.by {
            Readings::Part(part) => return part.answer(&case.effect, seed),
            Readings::Robot(bench, judge) => (bench, judge),
        };
        let folder = temporary()?;
        let session = folder.path().join("session");
        let effect = case.effect.compact();
        // What cannot be simulated gives no answer, and its trials are missing in the table.
        Ok(
            match self.simulate(bench, Some(&effect), judge, seed, &session) {
                Ok(_) => self.answer(&session, Some(&effect)),
                Err(_) => DoorAnswer::default(),
            },
        )
    }

    /// The laws by a door, on the first bench that has a sample of each.
    fn forced(
        &self,
        (door, judge): (&'static str, DoorJudge),
        plan: &ForcedPlan,
    ) -> Result<Vec<ForcedCase<'_>>, Failure> {
        let mut cases: Vec<ForcedCase<'_>> = Vec::new();
        let scale = PlaceScale {
            force_n: self.largest_n,
            force_range_n: [-self.largest_n, self.largest_n],
            ..UNKNOWN_SCALE
        };
        let mut done: Vec<Law> = Vec::new();
        for bench in &self.benches.bench {
            let effects = bench.effects_for(judge);
            let effects = effects
                .iter()
                .filter_map(|effect| effect.parse::<Effect>().ok());
            let new = effects.filter(|one| {
                // What is there or is not has no size.
                !one.values.is_empty() && plan.laws.contains(&one.law) && !done.contains(&one.law)
            });
            let new: Vec<Effect> = new.collect();
            if new.is_empty() {
                continue;
            }
            let (factors, scaled) = self.sizes(bench, judge, &new, &plan.sizes)?;
            for (effect, size) in scaled {
                cases.push(ForcedCase {
                    door,
                    bench: &bench.name,
                    size,
                    truth: [factors.clone(), stated_values(&effect, &scale)].concat(),
                    effect,
                    by: Readings::Robot(bench, judge),
                });
            }
            done.extend(new.iter().map(|effect| effect.law));
        }
        Ok(cases)
    }

    /// The true factors of a bench, and effects of sizes in standard errors of what a door reads there.
    fn sizes(
        &self,
        bench: &DoorBench,
        judge: DoorJudge,
        effects: &[Effect],
        sizes: &[f64],
    ) -> Result<(TrueFactors, Vec<(Effect, f64)>), Failure> {
        let folder = temporary()?;
        let session = folder.path().join("session");
        let simulated = self.simulate(bench, None, judge, self.benches.seed, &session);
        let simulated = simulated.unwrap_or_default();
        let noise = |name: &str| {
            simulated["data"]["noise"][name]
                .as_f64()
                .unwrap_or_default()
        };
        let data = Data::open(&session, &OpenSettings::default())?;
        let mut data = DiagnosisData::new(&data, &ModelChoice::default())?;
        let choice = data.usual_choice()?;
        let nothing = DiagnoseSettings {
            without: Law::ALL.to_vec(),
            ..DiagnoseSettings::default()
        };
        let report = data.diagnose(nothing, &|| ())?;
        let (model, plan): (_, &Observations) = (&data.model, &report.observations);
        let Subject::Robot(subject) = &report.subject else {
            return Ok((Vec::new(), Vec::new()));
        };
        let poses = plan
            .poses
            .iter()
            .map(|pose| model.robot.pose(pose).cloned());
        let baseline = RobotBaseline::new(
            &model.robot,
            model.mechanism()?,
            subject.fitted_factors.clone(),
            poses.collect::<Result<_, _>>()?,
            &choice,
            plan.largest_m_per_n(0.0),
        )?;
        let truth = Truth {
            parameters: baseline.parameters().iter().map(|one| one.start).collect(),
            effects: Vec::new(),
            noise: TrialNoise {
                noise: ReadingNoise {
                    reading_sd_m: noise("reading_sd_m"),
                    zero_sd_m: noise("zero_sd_m"),
                    run_slope_sd: noise("run_slope_sd"),
                    ..ReadingNoise::default()
                },
                displacement_step_m: noise("displacement_step_m"),
                force_step_n: noise("force_step_n"),
                skewed: false,
            },
        };
        let mut scaled = Vec::new();
        for (effect, &size) in effects
            .iter()
            .flat_map(|effect| sizes.iter().map(move |size| (effect, size)))
        {
            let mut with = truth.clone();
            with.effects.push(effect.clone());
            let found = scale_to(&baseline, plan, &with, size)?;
            scaled.extend(
                found
                    .and_then(|mut truth| truth.effects.pop())
                    .filter(|one| may_be(one, &UNKNOWN_SCALE))
                    .map(|one| (one, size)),
            );
        }
        let factors = report.parameters.iter().map(|one| {
            let value = match one.spring_rad_per_nm {
                Some(unit) => one.start * unit,
                None => one.start.exp(),
            };
            (one.name.clone(), value)
        });
        Ok((factors.collect(), scaled))
    }
}
