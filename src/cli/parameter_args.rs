//! Which parameters of a model are free, as the user says.

use clap::Args;

use crate::analysis::{ArgumentError, ResolvedModel};
use crate::parameters::{FitRole, ParameterChoice};
use crate::robot::ModelParameter;

use super::failure::Failure;

/// What a fit does with parameters of the model.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct ParameterArgs {
    /// What a fit does with parameters: beam.J=fixed, link.A,joint.A3=free, link.A=tied:beam.A, joint.A3=0..1e-4 as bounds in its unit, all=0.1..10 as bounds of all factors in multiples of their start; repeatable [default: the springs that the robot file frees are free; if it frees none, those of all joints on rigid links, else the factors of beams]
    #[arg(
        long = "parameter",
        allow_hyphen_values = true,
        value_name = "NAME=free|fixed|tied:NAME|LOW..HIGH"
    )]
    parameters: Vec<String>,
}

/// The word for all factors.
const ALL: &str = "all";

/// Parameters with what is said of them.
#[derive(Debug, Default)]
struct ParameterWords<'a> {
    free: Vec<&'a str>,
    fixed: Vec<&'a str>,
    tied: Vec<(&'a str, &'a str)>,
    bounds: Vec<(&'a str, &'a str)>,
}

impl ParameterArgs {
    /// Whether the user said nothing of them.
    pub(super) fn is_default(&self) -> bool {
        self.parameters.is_empty()
    }

    /// What is said of which parameters; a value counts for all names before it that have none.
    fn words(&self) -> Result<ParameterWords<'_>, ArgumentError> {
        let mut words = ParameterWords::default();
        for given in &self.parameters {
            let mut names: Vec<&str> = Vec::new();
            let mut parts = given.split(',').peekable();
            while let Some(part) = parts.next() {
                let (name, value) = part
                    .split_once('=')
                    .map_or((part, None), |(name, value)| (name, Some(value)));
                names.push(name.trim());
                match value {
                    Some(value) => words.take(std::mem::take(&mut names), value.trim()),
                    None if parts.peek().is_some() => {}
                    None => return Err(wrong(given, "what happens to it is missing")),
                }
            }
        }
        Ok(words)
    }

    /// Which parameters may move, as the user says.
    pub(super) fn choice(&self, chosen: &ResolvedModel) -> Result<ParameterChoice, Failure> {
        self.choice_beside(chosen, chosen.usual_parameters()?)
    }

    /// The same with what is free by default; parameters that are named as free replace its springs.
    pub(super) fn choice_beside(
        &self,
        chosen: &ResolvedModel,
        mut usual: ParameterChoice,
    ) -> Result<ParameterChoice, Failure> {
        let words = self.words()?;
        if !words.free.is_empty() {
            usual.members.retain(|member| member.parameter.is_factor());
        }
        words.choice(chosen, usual)
    }
}

/// A `--parameter` that cannot be.
fn wrong(given: &str, problem: &str) -> ArgumentError {
    ArgumentError::new(
        format!("--parameter {given}"),
        problem,
        "--parameter beam.J=fixed, --parameter link.A=tied:beam.A, --parameter joint.A3=0..1e-4, or --parameter all=0.1..10",
    )
}

impl<'a> ParameterWords<'a> {
    fn take(&mut self, names: Vec<&'a str>, value: &'a str) {
        match value.split_once(':') {
            Some(("tied", other)) => self.tied.extend(names.into_iter().map(|one| (one, other))),
            _ if value == "free" => self.free.extend(names),
            _ if value == "fixed" => self.fixed.extend(names),
            _ => self
                .bounds
                .extend(names.into_iter().map(|one| (one, value))),
        }
    }

    fn choice(
        &self,
        chosen: &ResolvedModel,
        mut choice: ParameterChoice,
    ) -> Result<ParameterChoice, Failure> {
        let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
        let find = |name: &str| ModelParameter::find(&chosen.robot, mechanism, name);
        for name in &self.free {
            choice.set(&find(name)?, FitRole::Free);
        }
        for name in &self.fixed {
            choice.set(&find(name)?, FitRole::Fixed);
        }
        for (one, other) in &self.tied {
            choice.set(&find(one)?, FitRole::TiedTo(find(other)?));
        }
        for (name, range) in &self.bounds {
            let wrong = |problem: &str| wrong(&format!("{name}={range}"), problem);
            let ends = range.split_once("..").and_then(|(low, high)| {
                Some([low.trim().parse::<f64>().ok()?, high.trim().parse().ok()?])
            });
            let ends = ends.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high);
            let [low, high] = ends.ok_or_else(|| {
                wrong("free, fixed, tied:NAME or two numbers are needed, the lower one first")
            })?;
            if *name == ALL {
                if !(low > 0.0 && low < 1.0 && high > 1.0) {
                    return Err(wrong(
                        "bounds as multiples must lie on both sides of 1, the start",
                    )
                    .into());
                }
                choice.range = [low, high];
                continue;
            }
            let parameter = find(name)?;
            let start = (chosen.robot.with_own_springs(&chosen.factors)).get(&parameter);
            let (least, word) = if parameter.is_factor() {
                (f64::MIN_POSITIVE, "a factor is above zero")
            } else {
                (0.0, "a compliance is not below zero")
            };
            if low < least {
                return Err(wrong(word).into());
            }
            if !(low..=high).contains(&start) {
                return Err(
                    wrong(&format!("the start of {parameter}, {start}, lies outside")).into(),
                );
            }
            choice.bound(&parameter, [low, high]);
        }
        Ok(choice)
    }
}
