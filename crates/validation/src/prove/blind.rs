//! Verdicts without the answers.

use rayon::prelude::*;

use stiffbench::analysis::Failure;
use stiffbench_diagnosis::mismatch::{Diagnosis, SearchOptions, diagnose, screen_data};

use super::session::ValidationSession;

/// A verdict that was given before any answer was opened.
#[derive(Debug)]
pub struct BlindVerdict {
    /// The session.
    pub session: String,
    /// Robot and mechanism in words.
    pub bench: String,
    /// The diagnosis, or why there is none.
    pub diagnosis: Result<Diagnosis, Failure>,
}

/// Diagnoses all sessions, each by itself as the program does; the verdicts stand in the order of the sessions, and are the same for any
/// number of threads.
///
/// # Arguments
/// - `done`: called after each session.
#[must_use]
pub fn diagnose_all(
    sessions: &[ValidationSession],
    options: &SearchOptions,
    done: &(dyn Fn() + Sync),
) -> Vec<BlindVerdict> {
    let verdict = |session: &ValidationSession| {
        let diagnosis = diagnosed(session, options);
        done();
        BlindVerdict {
            session: session.id.clone(),
            bench: session.bench(),
            diagnosis,
        }
    };
    sessions.par_iter().map(verdict).collect()
}

fn diagnosed(session: &ValidationSession, options: &SearchOptions) -> Result<Diagnosis, Failure> {
    let baseline = session.baseline()?;
    let screened = screen_data(&baseline, &session.observations, &options.noise)?;
    let (diagnosis, _) = diagnose(&baseline, &screened.observations, options, None)?;
    Ok(diagnosis)
}
