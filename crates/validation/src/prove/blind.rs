//! Verdicts without the answers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use stiffbench_diagnosis::mismatch::{
    CriticalValues, Diagnosis, MismatchError, SearchOptions, diagnose,
};

use super::error::ProveError;
use super::session::Session;

/// A verdict that was given before any answer was opened.
#[derive(Debug)]
pub struct BlindVerdict {
    /// The session.
    pub session: String,
    /// Robot and mechanism in words.
    pub bench: String,
    /// The diagnosis, or why there is none.
    pub diagnosis: Result<Diagnosis, ProveError>,
}

/// Diagnoses all sessions; the verdicts stand in the order of the sessions, and are the same for any number of threads.
///
/// CriticalValues are worked out at the first session of each key and used for its others.
///
/// # Arguments
/// - `done`: called after each session.
#[must_use]
pub fn diagnose_all(
    sessions: &[Session],
    options: &SearchOptions,
    done: &(dyn Fn() + Sync),
) -> Vec<BlindVerdict> {
    let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (place, session) in sessions.iter().enumerate() {
        groups.entry(session.limit_key()).or_default().push(place);
    }
    let groups: Vec<Vec<usize>> = groups.into_values().collect();
    let mut verdicts: Vec<(usize, BlindVerdict)> = groups
        .into_par_iter()
        .flat_map(|group| {
            let mut limits = None;
            let mut first = Vec::new();
            let mut rest = group.into_iter();
            // A session that cannot be diagnosed has no limits; the next may have.
            for place in rest.by_ref() {
                let (verdict, own) = blind(&sessions[place], options, None);
                first.push((place, verdict));
                done();
                limits = own;
                if limits.is_some() {
                    break;
                }
            }
            let rest: Vec<usize> = rest.collect();
            let others = rest.into_par_iter().map(|place| {
                let (verdict, _) = blind(&sessions[place], options, limits.as_ref());
                done();
                (place, verdict)
            });
            first.extend(others.collect::<Vec<_>>());
            first
        })
        .collect();
    verdicts.sort_by_key(|(place, _)| *place);
    verdicts.into_iter().map(|(_, verdict)| verdict).collect()
}

fn blind(
    session: &Session,
    options: &SearchOptions,
    known: Option<&CriticalValues>,
) -> (BlindVerdict, Option<CriticalValues>) {
    let result = session.baseline().and_then(|baseline| {
        diagnose(&baseline, &session.observations, options, known)
            .map_err(|error: MismatchError| error.into())
    });
    let (diagnosis, limits) = match result {
        Ok((diagnosis, limits)) => (Ok(diagnosis), Some(limits)),
        Err(error) => (Err(error), None),
    };
    let verdict = BlindVerdict {
        session: session.id.clone(),
        bench: session.bench(),
        diagnosis,
    };
    (verdict, limits)
}
