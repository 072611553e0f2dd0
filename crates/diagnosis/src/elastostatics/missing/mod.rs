//! What springs in the joints leave out of load cases: which further compliance, law of a joint or error of the set-up the data show.
//!
//! The baseline is the fit; candidates are columns beside its own. Levels, null samples, forward selection with swaps and what counts as
//! distinguishable are those of [`crate::search`].

mod bad_values;
mod candidates;
mod far_value;
mod find;
mod findings;
mod held_out_shares;
mod outcome;
mod possible;
mod scatter_model;
mod table_mistake;
mod undecided;
mod unexplained;

pub use bad_values::{BadLoadCaseValue, bad_load_case_values};
pub use candidates::CandidateKind;
pub use find::diagnose_load_cases;
pub use outcome::{
    ImplausibleSize, LoadCaseDiagnosis, LoadCaseFinding, LoadCaseRival, LoadCaseUnexplained,
};
pub use table_mistake::{TableMistake, table_mistake};
