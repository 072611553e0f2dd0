//! Which laws at which places explain what is left: scores, fits, evidence, critical values, and the search through all of them.
//!
//! The rules of the search are those of [`crate::search`], which knows rows and columns only.
//!
//! Owner: [`Candidates`]. It imports `hold_out`, `unexplained` and the rooms below them, and from `screen` only what data lack.

mod beginnings;
mod candidate;
mod candidate_scores;
mod changes;
mod configurations;
mod critical_values;
mod first_state;
mod law_search;
mod missing_members;
mod outlier;
mod part_evidence;
mod problem_candidates;
mod ranked_candidate;
mod ranking;
mod sharpness;
mod stand_ins;
mod trial;
mod white_laws;

pub(crate) use beginnings::{fitted_beginnings, log_bayes_over, scored_beginnings};
pub(crate) use candidate::candidates;
pub(crate) use candidate_scores::{
    BestShape, CANDIDATES_AT_A_TIME, ScoredCandidate, ScoredShape, WhiteCandidate, WhiteCandidates,
    WhiteShape, best_shapes,
};
pub use configurations::ConfigurationSizes;
pub(crate) use configurations::changing_sizes;
pub(crate) use critical_values::critical_values;
pub use critical_values::{Family, LawCriticalValues};
pub(crate) use law_search::{Depth, ResolvedEffect, SearchResult};
pub(crate) use problem_candidates::{CandidateMemo, Candidates};
pub(crate) use ranked_candidate::{Ranked, same};
pub(crate) use ranking::{CandidateScores, see};
pub use trial::{
    TrialNoise, Truth, scale_to, simulate, standard_errors, standard_errors_after_fit,
    standard_errors_between, standard_errors_of_readings,
};
pub use white_laws::{WhiteLaw, WhiteLawShape, white_laws};
