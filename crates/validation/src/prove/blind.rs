//! Verdicts without the answers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use stiffbench::analysis::Failure;
use stiffbench_diagnosis::mismatch::{
    Diagnosis, LawCriticalValues, MismatchError, SearchOptions, diagnose, screen_data,
};

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

/// Diagnoses all sessions; the verdicts stand in the order of the sessions, and are the same for any number of threads.
///
/// Critical values are computed at the first session of each key and used for its others.
///
/// # Arguments
/// - `done`: called after each session.
#[must_use]
pub fn diagnose_all(
    sessions: &[ValidationSession],
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
            let mut critical = None;
            let mut first = Vec::new();
            let mut rest = group.into_iter();
            // A session that cannot be diagnosed has no limits; the next may have.
            for place in rest.by_ref() {
                let (verdict, own) = blind(&sessions[place], options, None);
                first.push((place, verdict));
                done();
                critical = own;
                if critical.is_some() {
                    break;
                }
            }
            let rest: Vec<usize> = rest.collect();
            let others = rest.into_par_iter().map(|place| {
                let (verdict, _) = blind(&sessions[place], options, critical.as_ref());
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
    session: &ValidationSession,
    options: &SearchOptions,
    known: Option<&LawCriticalValues>,
) -> (BlindVerdict, Option<LawCriticalValues>) {
    let result = session.baseline().and_then(|baseline| {
        screen_data(&baseline, &session.observations, &options.noise)
            .and_then(|screened| diagnose(&baseline, &screened.observations, options, known))
            .map_err(|error: MismatchError| error.into())
    });
    let (diagnosis, critical) = match result {
        Ok((diagnosis, critical)) => (Ok(diagnosis), Some(critical)),
        Err(error) => (Err(error), None),
    };
    let verdict = BlindVerdict {
        session: session.id.clone(),
        bench: session.bench(),
        diagnosis,
    };
    (verdict, critical)
}
