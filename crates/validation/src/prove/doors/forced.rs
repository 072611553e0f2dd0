//! Laws that are stated and not searched: how often the intervals of their values hold the truth, whatever the search would have found.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_beams::physics::{Effect, PlaceScale, values_of};

use crate::prove::share::Share;

use super::coverage::CoverageRow;

/// One law of one size by one door.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ForcedPoint {
    /// Its name in tables.
    pub law: &'static str,
    /// How the readings came.
    pub door: &'static str,
    /// The bench.
    pub bench: String,
    /// What acts and is stated, as `--effect` takes it.
    pub effect: String,
    /// Its size, standard errors of what this door reads.
    #[serde(rename = "standard_errors")]
    pub size: f64,
    /// How often intervals hold the truth.
    pub coverage: Vec<CoverageRow>,
}

impl ForcedPoint {
    /// Intervals that hold the truth, and those that reach both ends of what is plausible.
    ///
    /// # Arguments
    /// - `of_law`: of the values of the law, not of the factors.
    #[must_use]
    pub fn held(&self, command: &str, of_law: bool) -> (Share, usize) {
        let rows = self.coverage.iter().filter(|row| {
            let name = row.parameter.as_ref();
            row.command == command && name.is_some_and(|name| name.contains('@') == of_law)
        });
        rows.fold((Share::default(), 0), |(share, undetermined), row| {
            (share.with(row.share), undetermined + row.undetermined)
        })
    }
}

/// The values of an effect, and the number that its law makes of them, by the names that a diagnosis gives them, as `creep@structure:k`.
#[must_use]
pub fn stated_values(effect: &Effect, scale: &PlaceScale) -> Vec<(String, f64)> {
    let law = effect.law;
    let values = law.parameters.iter().zip(effect.values.iter().copied());
    let made = law.combination.as_ref();
    let made = made.map(|made| (&made.spec, (made.of)(&values_of(&effect.values), scale)));
    values
        .chain(made)
        .map(|(spec, value)| {
            let place = effect.place.compact();
            (format!("{law}@{place}:{}", spec.name), value)
        })
        .collect()
}
