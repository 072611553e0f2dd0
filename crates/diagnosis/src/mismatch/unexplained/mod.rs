//! What a model leaves beyond the noise, and where, without asking which law it may be.
//!
//! Owner: [`Omnibus`]. It imports `problem` and the rooms below it.

mod largest_pattern;
mod omnibus;
mod patterns;
mod profiles;
mod strata;
mod stratum;

pub(crate) use largest_pattern::{
    UnexplainedStructure, largest_left, largest_patterns, unexplained,
};
pub(crate) use omnibus::omnibus;
pub use omnibus::{Omnibus, OmnibusTest};
pub(crate) use patterns::{PatternScratch, Patterns, ResidualPattern, places_alike};
pub(crate) use strata::located_at_start;
#[cfg(test)]
pub(crate) use strata::tests as strata_tests;
pub use strata::{
    Contrast, ExplainedShare, Located, MapEntry, STRATUM_LEVEL, Spot, StratumTest,
    SuspectComponent, Untested, locate,
};
pub use stratum::{Location, Stratum};
