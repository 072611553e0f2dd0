//! The model that a diagnosis gives back.

use stiffbench_beams::physics::{Effect, FoundEffect, ModelFile, ParameterUncertainty, Provenance};
use stiffbench_beams::robot::FittingFactors;

use super::diagnosis::{Diagnosis, Finding};
use super::stated_values::EstimatedValue;

impl Diagnosis {
    /// The final model as a file holds it: factors, the effects that act, and the alternatives that these data do not distinguish from them.
    ///
    /// The first member of a set of alternatives acts; the others stand beside it. Robot and session are the caller's to name.
    ///
    /// # Arguments
    /// - `factors`: those of the final model; none where there is no robot.
    #[must_use]
    pub fn model_file(&self, factors: Option<FittingFactors>) -> ModelFile {
        let mut model = ModelFile {
            factors,
            provenance: Provenance {
                verdict: Some(self.verdict.to_string()),
                ..Provenance::default()
            },
            ..ModelFile::default()
        };
        for known in &self.known_effects {
            let effect = Effect {
                values: known.after.iter().map(|value| value.value).collect(),
                ..known.given.clone()
            };
            model.effects.push(FoundEffect {
                effect,
                uncertainties: uncertainties(&known.after),
                alternative_group: None,
            });
        }
        for finding in &self.findings {
            let group = finding.alternative_group;
            let acts = |known: &FoundEffect| known.alternative_group == group;
            let to = if group.is_some() && model.effects.iter().any(acts) {
                &mut model.alternatives
            } else {
                &mut model.effects
            };
            to.push(found(finding));
        }
        model
    }
}

fn found(finding: &Finding) -> FoundEffect {
    FoundEffect {
        effect: finding.effect.clone(),
        uncertainties: uncertainties(&finding.values),
        alternative_group: finding.alternative_group,
    }
}

fn uncertainties(values: &[EstimatedValue]) -> Vec<ParameterUncertainty> {
    values
        .iter()
        .map(|value| ParameterUncertainty {
            u: value.u,
            dof: Some(value.dof).filter(|dof| dof.is_finite() && value.u.is_some()),
            ci95: value.interval_95(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::{
        Location, MisfitShares, NoiseBasis, Omnibus, OmnibusTest, Quality, ReadingNoise, Stratum,
        Verdict, VerdictGrade,
    };

    fn finding(effect: &str, alternative_group: Option<u32>) -> Finding {
        crate::tests::finding(effect.parse().unwrap(), alternative_group)
    }

    #[test]
    fn the_first_of_several_alternatives_is_written_with_a_note() {
        let quality = Quality {
            rms_m: 1e-6,
            held_out_rms_m: None,
            held_out_noise_units: None,
            held_out: Vec::new(),
            reduced_chi2: 1.0,
        };
        let findings = vec![
            finding("creep:k=1%/decade,t0=1s", None),
            finding("joint-compliance@A5B:c=1urad/(N*m)", Some(1)),
            finding("gauge-stand-compliance@y:c=1um/N", Some(1)),
            finding("joint-compliance@B3:c=1urad/(N*m)", Some(2)),
        ];
        let diagnosis = Diagnosis {
            verdict: Verdict::Ambiguous,
            grade: VerdictGrade::Is,
            lacking: Vec::new(),
            locations: Vec::new(),
            effects: [0, 1, 3]
                .map(|place: usize| findings[place].effect.clone())
                .to_vec(),
            findings,
            sizes: crate::mismatch::ConfigurationSizes::Common,
            beginnings: crate::mismatch::Beginnings::default(),
            unexplained: Location {
                stratum: Stratum::Rest,
                pose: None,
                direction: None,
                period_s: None,
                p_family: 0.5,
                p_at_floor: false,
                size_m: 0.0,
            },
            unexplained_standard_errors: 0.0,
            omnibus: Omnibus {
                p: 1.0,
                contrast: OmnibusTest::Pattern(Stratum::Rest),
            },
            shares: MisfitShares::default(),
            misfit_steps: None,
            before: quality.clone(),
            after: quality,
            known_effects: Vec::new(),
            factors: Vec::new(),
            noise_basis: NoiseBasis::Repeats,
            noise: ReadingNoise {
                reading_sd_m: 1e-6,
                zero_sd_m: 0.0,
                run_slope_sd: 0.0,
                ..ReadingNoise::default()
            },
            noise_dof: [1e6; 3],
            further_noise: [None; 2],
            detection_limits: Vec::new(),
            impossible: Vec::new(),
            parameters: vec![0.0; 4],
        };
        let model = diagnosis.model_file(Some(FittingFactors::UNIT));
        assert_eq!(model.acting(), diagnosis.effects);
        let [stand] = &model.alternatives[..] else {
            panic!("{model:?}")
        };
        assert_eq!(stand.effect, diagnosis.findings[2].effect);
        let uncertainty = &model.effects[0].uncertainties[0];
        assert_eq!((uncertainty.u, uncertainty.dof), (Some(0.001), Some(300.0)));
        assert!(uncertainty.ci95.unwrap()[0] < 0.00805);
        assert!(
            model
                .to_toml()
                .contains("[[alternatives]]\nphysics = \"gauge-stand-compliance\"")
        );
    }
}
