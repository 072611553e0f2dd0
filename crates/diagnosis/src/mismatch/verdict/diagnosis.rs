//! The answer of a search, ready to be told.

use stiffbench_beams::physics::{Effect, Law, ParameterSpec, Place};

use super::grade::{Verdict, VerdictGrade};
use super::stated_values::EstimatedValue;
use crate::mismatch::candidates::ConfigurationSizes;
use crate::mismatch::hold_out::{MisfitShares, MisfitSteps, Quality};
use crate::mismatch::noise::{EarlierNoise, NoiseBasis};
use crate::mismatch::observed::ReadingNoise;
use crate::mismatch::observed::{Beginnings, Observations};
use crate::mismatch::unexplained::{Location, Omnibus};

/// A rival of a finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// The rival with its fitted values.
    pub effect: Effect,
    /// Log Bayes factor of the winner against it.
    pub log_bayes_to_winner: f64,
    /// Cosine of its effect with the winner's, after projection.
    pub cosine: f64,
}

/// A found effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The effect.
    pub effect: Effect,
    /// How far its name may be relied on.
    pub grade: VerdictGrade,
    /// Shares of the misfit that it explains beside the others; those of a set belong to all its members.
    pub shares: MisfitShares,
    /// Its values with uncertainty, in the order of the law's parameters.
    pub values: Vec<EstimatedValue>,
    /// What readings determine where they do not tell those apart, if the law has such a number.
    pub combination: Option<EstimatedValue>,
    /// Whether its size stands at the bound of what is plausible.
    pub at_bound: bool,
    /// Whether the interval of its size reaches both ends of what is plausible: the readings do not determine it.
    pub spans_range: bool,
    /// Members of one group exclude each other and are indistinguishable; `None` where the finding stands alone.
    pub alternative_group: Option<u32>,
    /// Largest change of a reading, m.
    pub end_effect_m: f64,
    /// Share of the effect that the factors absorb.
    pub absorbed_share: f64,
    /// Logarithm of the Bayes factor against the model without it; of a jump, against a gradual change in its stead if that is likelier.
    pub log_bayes: f64,
    /// Length of the effect in standard errors.
    pub standard_errors: f64,
    /// Chance that noise alone gives any law as much.
    pub p_family: f64,
    /// Rivals that are distinguished, the nearest first.
    pub rivals: Vec<Rival>,
}

impl Finding {
    /// What is stated of the effect: the values of its parameters, and the number made of them.
    pub fn stated(&self) -> impl Iterator<Item = (ParameterSpec, &EstimatedValue)> {
        let Effect { law, place, .. } = &self.effect;
        let made = law.combination.as_ref().zip(self.combination.as_ref());
        let made = made.map(|(combination, value)| (combination.spec.at(place), value));
        law.parameters_at(place).zip(&self.values).chain(made)
    }
}

/// The smallest effect that these data would have shown.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectionLimit {
    /// The law.
    pub law: Law,
    /// The place.
    pub place: Place,
    /// Size found in 80 % of sessions, SI; `None` if no possible size is.
    pub size_80: Option<f64>,
    /// Its largest change of a reading, m.
    pub end_effect_m: Option<f64>,
    /// Upper 95 % limit of the size, given these readings, SI; `None` where something was found.
    pub upper_95: Option<f64>,
}

/// A factor before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorChange {
    /// Name.
    pub name: String,
    /// Compliance of a spring at a fitted value of one, rad/(N·m); `None` for a factor, which is fitted by its logarithm.
    pub spring_rad_per_nm: Option<f64>,
    /// In the model without effects.
    pub before: EstimatedValue,
    /// In the final model.
    pub after: EstimatedValue,
    /// Whether the data determine it in the final model.
    pub identified: bool,
}

/// Physics that was known beforehand, its values fitted again.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownEffect {
    /// As it was given.
    pub given: Effect,
    /// Without what was found: its values in the order of the law's parameters.
    pub before: Vec<EstimatedValue>,
    /// The same in the final model.
    pub after: Vec<EstimatedValue>,
    /// In both what readings determine where they do not tell those apart, if the law has such a number.
    pub combination: Option<[EstimatedValue; 2]>,
}

/// A law that would explain the readings with an impossible value.
#[derive(Debug, Clone, PartialEq)]
pub struct Impossible {
    /// The law.
    pub law: Law,
    /// The place.
    pub place: Place,
    /// Drop of the weighted squares that the impossible sign would give.
    pub delta_chi2: f64,
}

/// A diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// How far it may be relied on.
    pub grade: VerdictGrade,
    /// What the data lack, where they cannot decide.
    pub lacking: Vec<String>,
    /// Where the baseline fails.
    pub locations: Vec<Location>,
    /// What is missing; with the verdict unknown what explains part of it.
    pub findings: Vec<Finding>,
    /// What their sizes follow from configuration to configuration of a part.
    pub sizes: ConfigurationSizes,
    /// How the runs begin.
    pub beginnings: Beginnings,
    /// What the final model leaves.
    pub unexplained: Location,
    /// Its length in standard errors.
    pub unexplained_standard_errors: f64,
    /// Whether the final model leaves more than noise does.
    pub omnibus: Omnibus,
    /// Shares of the misfit that all findings explain together.
    pub shares: MisfitShares,
    /// The misfit divided between what was found, where it is large enough.
    pub misfit_steps: Option<MisfitSteps>,
    /// The model without findings.
    pub before: Quality,
    /// The final model.
    pub after: Quality,
    /// Physics that was known beforehand; the first effects of the final model.
    pub known_effects: Vec<KnownEffect>,
    /// Factors (or slopes), logarithms for a robot.
    pub factors: Vec<FactorChange>,
    /// The noise of the final model.
    pub noise: ReadingNoise,
    /// Where it comes from.
    pub noise_basis: NoiseBasis,
    /// Degrees of freedom of its three standard deviations: reading, zero, run slope; a million and more where one was given.
    pub noise_dof: [f64; 3],
    /// 95 % intervals of its growth with the displacement and of its correlation within a run, where it has them.
    pub further_noise: [Option<[f64; 2]>; 2],
    /// What each law would have needed.
    pub detection_limits: Vec<DetectionLimit>,
    /// Laws rejected because only an impossible value would serve.
    pub impossible: Vec<Impossible>,
    /// Parameters and effects of the final model.
    pub parameters: Vec<f64>,
    /// Effects of the final model: of alternatives the first.
    pub effects: Vec<Effect>,
}

impl EarlierNoise {
    /// What a diagnosed session tells: the scatter that is left once what was missing has been found. `None` if its readings could not decide, or
    /// nothing was repeated.
    #[must_use]
    pub fn of(diagnosis: &Diagnosis) -> Option<Self> {
        let is_seen = diagnosis.noise_basis != NoiseBasis::Fit;
        (is_seen && diagnosis.verdict != Verdict::InsufficientData)
            .then(|| Self::new(&diagnosis.noise, diagnosis.noise_dof))
    }
}

impl Diagnosis {
    /// Readings of a part with effects whose sizes follow what was found.
    #[must_use]
    pub fn sized(&self, observations: &Observations) -> Observations {
        let slopes: Vec<f64> = self.factors.iter().map(|f| f.before.value).collect();
        let factors = self.sizes.size_factors(observations, &slopes);
        factors.map_or_else(
            || observations.clone(),
            |factors| observations.with_size_factors(&factors),
        )
    }
}
