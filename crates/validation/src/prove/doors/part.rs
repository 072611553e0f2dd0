//! A part without a robot file on which a law acts that is stated: it has no option by which a user could state one.

use std::fmt::Write;
use stiffbench::analysis::Failure;

use stiffbench_beams::physics::{Effect, Law, PlaceScale};
use stiffbench_diagnosis::mismatch::{
    Baseline, EstimatedValue, Line, Observations, ReadingNoise, SearchOptions, TrialNoise, Truth,
    diagnose, scale_to, simulate,
};
use stiffbench_measurement::specimen::{ResponseVariable, SpecimenOptions, read_specimen};

use crate::prove::cases::{may_be, small_values};
use crate::prove::error::ProveError;

use super::answer::{DoorAnswer, DoorEstimate};
use super::forced::stated_values;

/// Where the path turns, and readings of one way: cycles of growing size through both signs.
const TURNS: [f64; 8] = [0.0, 0.6, -0.6, 0.8, -0.8, 1.0, -1.0, 0.0];
const READINGS: usize = 60;

/// Time between two readings, s.
const STEP_S: f64 = 0.1;

/// Standard deviation of a reading, of the largest one.
const READING_SD: f64 = 0.002;

/// The recording of a part whose largest load and answer are one.
#[derive(Debug)]
pub struct PartBench {
    line: Line,
    plan: Observations,
    /// What its laws know of it.
    scale: PlaceScale,
    /// One of each law that such a recording can show, small.
    pub effects: Vec<Effect>,
}

impl PartBench {
    /// The recording of a part.
    ///
    /// # Errors
    /// [`ProveError`].
    pub fn new(response: ResponseVariable) -> Result<Self, Failure> {
        let (force, displacement) = match response {
            ResponseVariable::Displacement => ("set", "answer"),
            ResponseVariable::Force => ("answer", "set"),
        };
        let options = SpecimenOptions {
            force_column: Some(force.to_owned()),
            displacement_column: displacement.to_owned(),
            time_column: Some("t_s".to_owned()),
            force_unit: Some("1".to_owned()),
            displacement_unit: Some("1".to_owned()),
            response: Some(response),
            ..SpecimenOptions::default()
        };
        let ways = TURNS.windows(2);
        let path = ways.flat_map(|way| {
            (0..READINGS).map(|place| way[0] + (way[1] - way[0]) * place as f64 / READINGS as f64)
        });
        let mut table = "t_s,set,answer\n".to_owned();
        for (place, set) in path.enumerate() {
            let _ = writeln!(table, "{:.1},{set},{set}", STEP_S * place as f64);
        }
        let form = |error: &dyn std::fmt::Display| ProveError::Form {
            file: "part.csv".to_owned(),
            problem: error.to_string(),
        };
        let table = read_specimen(&[("part.csv", table.as_bytes())], &options)
            .map_err(|error| form(&error))?;
        let (line, plan) = Line::of_table(&table)?;
        let scale = PlaceScale {
            force_n: 1.0,
            force_range_n: [-1.0, 1.0],
            displacement_m: 1.0,
            moment_nm: 1.0,
            compliance: 1.0,
            time_s: STEP_S * plan.len() as f64,
            has_clock: true,
            ..PlaceScale::default()
        };
        let mut bench = Self {
            line,
            plan,
            scale,
            effects: Vec::new(),
        };
        let readings = simulate(&bench.line, &bench.plan, &bench.truth(None), 0)?;
        let search = SearchOptions::default();
        let (diagnosis, _) = diagnose(&bench.line, &readings, &search, None)?;
        let mut effects: Vec<Effect> = Vec::new();
        for limit in diagnosis.detection_limits {
            if limit.size_80.is_some() && effects.iter().all(|one| one.law != limit.law) {
                let values = small_values(limit.law, &bench.scale);
                effects.push(Effect::new(limit.law, limit.place, values)?);
            }
        }
        bench.effects = effects;
        Ok(bench)
    }

    fn truth(&self, effect: Option<&Effect>) -> Truth {
        let parameters = self.line.parameters().iter();
        Truth {
            parameters: parameters.map(|slope| slope.start).collect(),
            effects: effect.into_iter().cloned().collect(),
            noise: TrialNoise {
                noise: ReadingNoise {
                    reading_sd_m: READING_SD,
                    ..ReadingNoise::default()
                },
                displacement_step_m: 0.0,
                force_step_n: 0.0,
                skewed: false,
            },
        }
    }

    /// An effect of a size, standard errors; `None` if no multiple of it that may be has that size.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn scaled(&self, effect: &Effect, size: f64) -> Result<Option<Effect>, Failure> {
        let truth = scale_to(&self.line, &self.plan, &self.truth(Some(effect)), size)?;
        let effect = truth.and_then(|truth| truth.effects.into_iter().next());
        Ok(effect.filter(|effect| may_be(effect, &self.scale)))
    }

    /// What is true where an effect acts.
    #[must_use]
    pub fn true_values(&self, effect: &Effect) -> Vec<(String, f64)> {
        let values = stated_values(effect, &self.scale);
        self.slopes().chain(values).collect()
    }

    fn slopes(&self) -> impl Iterator<Item = (String, f64)> + '_ {
        let slopes = self.line.parameters().iter();
        slopes.map(|slope| (slope.name.clone(), slope.start))
    }

    /// What a diagnosis answers that is told of an effect and searches for nothing else.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn answer(&self, effect: &Effect, seed: u64) -> Result<DoorAnswer, Failure> {
        let readings = simulate(&self.line, &self.plan, &self.truth(Some(effect)), seed)?;
        let search = SearchOptions {
            known_effects: vec![effect.clone()],
            without: Law::ALL.to_vec(),
            ..SearchOptions::default()
        };
        let (diagnosis, _) = diagnose(&self.line, &readings, &search, None)?;
        let estimate = |(name, value): (String, &EstimatedValue)| DoorEstimate {
            name,
            value: value.value,
            ci95: value.interval_95(),
            is_open: value.is_open(),
        };
        let known = diagnosis.known_effects.iter().flat_map(|known| {
            let made = known.combination.as_ref().map(|[_, after]| after);
            known.after.iter().chain(made)
        });
        let fitted = diagnosis
            .factors
            .iter()
            .map(|factor| &factor.after)
            .chain(known);
        let names = self.true_values(effect).into_iter().map(|(name, _)| name);
        Ok(DoorAnswer {
            parameters: names.zip(fitted).map(estimate).collect(),
            ..DoorAnswer::default()
        })
    }
}
