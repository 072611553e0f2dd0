//! Whether a model leaves more than noise does: the largest pattern, and what cells, load steps, branches and time have in common.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_beams::physics::TestObject;

use super::largest_pattern::UnexplainedStructure;
use super::strata::{Contrast, holm, stratum_tests};
use super::stratum::Stratum;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::NoiseBasis;
use crate::mismatch::problem::{DiagnosisProblem, State};

/// Contrasts whose sums are compared with the scatter between repeats.
const CONTRASTS: [Contrast; 9] = [
    Contrast::CellSlope,
    Contrast::Repeat,
    Contrast::Clock,
    Contrast::Sign,
    Contrast::Curve,
    Contrast::LoadStep,
    Contrast::Loop,
    Contrast::Branch,
    Contrast::Hold,
];

/// Standard deviations of the noise that no noise leaves in the root mean square over all readings (1).
const BEYOND_NOISE: f64 = 3.0;

/// A test of everything that a model leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Omnibus {
    /// Chance that noise alone leaves as much in any of its tests.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
    /// The test that shows most.
    pub contrast: OmnibusTest,
}

/// One of the tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OmnibusTest {
    /// The largest single pattern.
    Pattern(Stratum),
    /// A sum over all cells.
    Sum(Contrast),
}

/// Tests what a state leaves. The largest pattern and the sums share the level by halves, the sums theirs by Holm's step-down.
pub(crate) fn omnibus(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    left: &UnexplainedStructure,
) -> Result<Omnibus, MismatchError> {
    let stratum = left
        .pattern
        .as_ref()
        .map_or(Stratum::Rest, |pattern| pattern.stratum);
    let mut omnibus = Omnibus {
        p: left.p,
        contrast: OmnibusTest::Pattern(stratum),
    };
    let mut tests = stratum_tests(problem, state)?;
    tests.retain(|test| CONTRASTS.contains(&test.contrast));
    let family = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    let both = tests.iter().zip(family);
    if let Some((test, p)) = both.min_by(|a, b| a.1.total_cmp(&b.1))
        && p < omnibus.p
    {
        omnibus = Omnibus {
            p,
            contrast: OmnibusTest::Sum(test.contrast),
        };
    }
    omnibus.p = (2.0 * omnibus.p).min(1.0);
    // A structure that gives no way, or springs that stand at their bounds, may have no patterns: the size of what is left says enough. Of a part
    // it says nothing, for there only the scatter of neighbours is noise.
    let is_known = problem.observations.object == TestObject::Robot
        && state.noise.basis != NoiseBasis::Neighbours;
    let readings = problem.observations.len() as f64;
    if is_known && state.fitted.squares > BEYOND_NOISE * BEYOND_NOISE * readings {
        omnibus.p = 0.0;
    }
    Ok(omnibus)
}
