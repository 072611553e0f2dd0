//! How far other names are from what acts in a concealed session, for an observer who knows its noise: among today's laws, of which the program
//! that made the sessions does not know all.

use stiffbench::analysis::Failure;
use stiffbench_beams::physics::Effect;
use stiffbench_diagnosis::mismatch::{
    Baseline, Observations, ReadingNoise, RobotBaseline, TrialNoise, Truth,
    standard_errors_after_fit,
};

use super::answers::{SealedAnswer, TrueEffect};
use super::session::ValidationSession;

/// One metre, µm.
const UM: f64 = 1e6;

/// An observer who knows what acts in a session, and its noise.
#[derive(Debug)]
pub struct Observer<'a> {
    baseline: RobotBaseline<'a>,
    plan: Observations,
    truth: Truth,
}

impl<'a> Observer<'a> {
    /// The observer of a session; `None` where something outside the library acts.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn new(
        session: &'a ValidationSession,
        answer: &SealedAnswer,
    ) -> Result<Option<Self>, Failure> {
        if answer.truth.iter().any(|effect| effect.law().is_none()) {
            return Ok(None);
        }
        let effects = answer.truth.iter().map(TrueEffect::effect);
        let effects = effects.collect::<Result<_, _>>()?;
        let baseline = session.baseline()?;
        let parameters = baseline.parameters().iter().map(|parameter| {
            let property = parameter.name.trim_start_matches("beam.");
            let factor = answer.beam_factors.get(property);
            factor.map_or(parameter.start, |factor| factor.ln())
        });
        let parameters = parameters.collect();
        let given = &answer.noise;
        let noise = TrialNoise {
            noise: ReadingNoise {
                reading_sd_m: given.sigma / UM,
                zero_sd_m: given.sigma0 / UM,
                run_slope_sd: given.slope,
                ..ReadingNoise::default()
            },
            displacement_step_m: given.res_um / UM,
            force_step_n: given.force_resolution_n,
            // Of the errors the covariance alone counts.
            skewed: false,
        };
        let mut plan = session.observations.clone();
        plan.steps.displacement_m = Some(noise.displacement_step_m);
        plan.steps.force_n = Some(noise.force_step_n);
        let truth = Truth {
            parameters,
            effects,
            noise,
        };
        Ok(Some(Self {
            baseline,
            plan,
            truth,
        }))
    }

    /// What a name leaves of one of the true effects, standard errors.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn between(&self, number: usize, member: &Effect) -> Result<f64, Failure> {
        let mut as_last = self.truth.clone();
        let own = as_last.effects.remove(number);
        // A richer law is as near as the simpler one that it contains.
        if member.law.contains(own.law) && member.place == own.place {
            return Ok(0.0);
        }
        as_last.effects.push(own);
        Ok(standard_errors_after_fit(
            &self.baseline,
            &self.plan,
            &as_last,
            member,
        )?)
    }
}
