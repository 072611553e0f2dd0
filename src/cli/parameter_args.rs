//! Which parameters of a model are free, as the user says.

use clap::Args;

use crate::analysis::{ArgumentError, ResolvedModel};
use crate::parameters::{FitRole, ParameterChoice};
use crate::robot::ModelParameter;

use super::failure::Failure;

/// The list of model parameters that a fit moves, keeps or ties.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct ParameterArgs {
    /// Parameters to free: link.A, section.NAME.Iz, joint.NAME, base.rx [default: the springs that the robot file frees; if it frees none, those of all joints on rigid links, else the factors of beams]
    #[arg(long, value_delimiter = ',', value_name = "PARAMETER")]
    pub(super) free: Vec<String>,
    /// Parameters to keep at their start, for example beam.J
    #[arg(long, value_delimiter = ',', value_name = "PARAMETER")]
    pub(super) fix: Vec<String>,
    /// Parameters to keep in proportion, for example link.A=beam.A or joint.J1=joint.J2
    #[arg(long, value_delimiter = ',', value_name = "PARAMETER=PARAMETER")]
    pub(super) tie: Vec<String>,
    /// Bounds of all free factors as multiples of their start, or of one parameter in its unit [default: 0.1..10]
    #[arg(
        long,
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_name = "LOW..HIGH|PARAMETER=LOW..HIGH"
    )]
    pub(super) bounds: Vec<String>,
}

impl ParameterArgs {
    /// Whether the user said nothing of them.
    pub(super) fn is_default(&self) -> bool {
        let lists = [&self.free, &self.fix, &self.tie, &self.bounds];
        lists.iter().all(|list| list.is_empty())
    }

    /// Which parameters may move, as the user says.
    pub(super) fn choice(&self, chosen: &ResolvedModel) -> Result<ParameterChoice, Failure> {
        self.choice_beside(chosen, chosen.usual_parameters()?)
    }

    /// The same with what is free by default; of that `--free` replaces the springs.
    pub(super) fn choice_beside(
        &self,
        chosen: &ResolvedModel,
        mut usual: ParameterChoice,
    ) -> Result<ParameterChoice, Failure> {
        if !self.free.is_empty() {
            usual.members.retain(|member| member.parameter.is_factor());
        }
        self.choice_from(chosen, usual)
    }

    fn choice_from(
        &self,
        chosen: &ResolvedModel,
        mut choice: ParameterChoice,
    ) -> Result<ParameterChoice, Failure> {
        let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
        let find = |name: &str| ModelParameter::find(&chosen.robot, mechanism, name);
        for name in &self.free {
            choice.set(&find(name)?, FitRole::Free);
        }
        for name in &self.fix {
            choice.set(&find(name)?, FitRole::Fixed);
        }
        for tie in &self.tie {
            let Some((one, other)) = tie.split_once('=') else {
                return ArgumentError::refuse(
                    format!("--tie {tie}"),
                    "two parameters with an equals sign between them are needed",
                    "--tie link.A=beam.A",
                );
            };
            choice.set(&find(one)?, FitRole::TiedTo(find(other)?));
        }
        for bounds in &self.bounds {
            let wrong = |problem: &str| {
                ArgumentError::new(
                    format!("--bounds {bounds}"),
                    problem,
                    "--bounds 0.1..10, or of one parameter --bounds beam.Iz=0.5..4",
                )
            };
            let (name, range) = bounds.split_once('=').unwrap_or(("", bounds));
            let ends = range.split_once("..").and_then(|(low, high)| {
                Some([low.trim().parse::<f64>().ok()?, high.trim().parse().ok()?])
            });
            let ends = ends.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high);
            let [low, high] =
                ends.ok_or_else(|| wrong("two numbers are needed, the lower one first"))?;
            if name.is_empty() {
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
