//! How earlier sessions on the same bench scattered.

use std::path::Path;

use crate::mismatch::{
    Baseline, EarlierNoise, KnownNoise, Observations, SearchOptions, diagnose, screen_data,
};
use crate::parameters::ParameterChoice;
use crate::physics::Law;
use crate::readings::{InstrumentRecord, SessionHeader};

use super::data::LoadedSession;
use super::design::baseline_of;
use super::error::{ArgumentError, Failure};
use super::model::ResolvedModel;
use super::session_table::SessionTable;
use super::together::SessionObservations;

/// An earlier session and how it scattered.
#[derive(Debug)]
pub struct MeasuredNoise {
    session: LoadedSession,
    noise: EarlierNoise,
}

/// What an earlier session shows of the noise.
#[derive(Debug, Clone, PartialEq)]
pub struct EarlierSession {
    /// What the user calls it.
    pub name: String,
    /// How it scattered.
    pub noise: EarlierNoise,
    /// Chance that two sessions with the same noise differ as much as this one and that of the diagnosis.
    pub chance: f64,
    /// Whether it counts; one that scatters otherwise does not.
    pub used: bool,
}

/// How a session scatters once what the model lacks has been found.
///
/// # Arguments
/// - `parameters`, `without`, `seed`: as in the diagnosis for which the noise is measured.
///
/// # Errors
/// For readings that do not show how they scatter.
pub fn noise_of(
    mut session: LoadedSession,
    model: &ResolvedModel,
    parameters: &ParameterChoice,
    without: &[Law],
    seed: u64,
) -> Result<MeasuredNoise, Failure> {
    let observations = Observations::new(&session.table, session.header.as_ref());
    let baseline = baseline_of(model, &observations, &observations.poses, parameters)?;
    let search = SearchOptions {
        noise: KnownNoise::Nothing,
        seed,
        without: without.to_vec(),
        known_effects: model.physics.effects.clone(),
    };
    let observations = screen_data(&baseline, &observations, &KnownNoise::Nothing)?.observations;
    let (diagnosis, _) = diagnose(&baseline, &observations, &search, None)?;
    let noise = EarlierNoise::of(&diagnosis).ok_or_else(|| {
        ArgumentError::new(
            format!("--earlier {}", session.name),
            format!(
                "its readings do not determine their scatter: {}",
                diagnosis.lacking.join("; ")
            ),
            "leave it out, or name a session with repeats",
        )
    })?;
    session.warnings.extend(model.warnings.iter().cloned());
    Ok(MeasuredNoise { session, noise })
}

/// The scatter of earlier sessions that is that of this one, and what each shows.
///
/// # Arguments
/// - `own`: how this session is searched, of whose noise nothing is known yet.
pub(super) fn pooled_noise(
    session: &SessionObservations,
    (baseline, observations, search): (&dyn Baseline, &Observations, &SearchOptions),
    others: Vec<MeasuredNoise>,
    warnings: &mut Vec<String>,
) -> Result<(KnownNoise, Vec<EarlierSession>), Failure> {
    for (place, MeasuredNoise { session: other, .. }) in others.iter().enumerate() {
        let mut before = others[..place].iter().map(|before| &before.session);
        if is_same(other, session) || before.any(|before| is_same(other, before)) {
            return Err(counted_twice(other).into());
        }
    }
    let own = EarlierNoise::of(&diagnose(baseline, observations, search, None)?.0);
    let mut sessions = Vec::new();
    for MeasuredNoise {
        session: other,
        noise,
    } in others
    {
        let name = other.short_name();
        warnings.extend(
            other
                .warnings
                .iter()
                .map(|warning| format!("{name}: {warning}")),
        );
        warnings.extend(other_gauges(
            &name,
            other.header.as_ref(),
            session.header.as_ref(),
        ));
        let chance = own
            .as_ref()
            .map_or(1.0, |own| noise.chance_of_the_same(own));
        let used = own.as_ref().is_none_or(|own| noise.is_like(own));
        if !used {
            warnings.push(format!(
                "{name} has a different scatter than this session (p = {chance:.1e}) and is left out: what was changed on the bench since?"
            ));
        }
        sessions.push(EarlierSession {
            name,
            noise,
            chance,
            used,
        });
    }
    let used: Vec<EarlierNoise> = sessions
        .iter()
        .filter(|earlier| earlier.used)
        .map(|earlier| earlier.noise)
        .collect();
    let known = EarlierNoise::pooled(&used).map_or(KnownNoise::Nothing, KnownNoise::Earlier);
    Ok((known, sessions))
}

/// Whether two sessions are one.
fn is_same<T, U>(session: &SessionTable<T>, other: &SessionTable<U>) -> bool {
    let id = |header: &Option<SessionHeader>| header.as_ref().and_then(|header| header.id.clone());
    let ids = (id(&session.header), id(&other.header));
    let place = |name: &str| Path::new(name).canonicalize().ok();
    place(&session.name) == place(&other.name) || (ids.0.is_some() && ids.0 == ids.1)
}

fn counted_twice(session: &LoadedSession) -> ArgumentError {
    ArgumentError::new(
        format!("--earlier {}", session.name),
        "this session is given already: its scatter would count twice",
        "name other sessions of the same bench",
    )
}

/// A warning for each gauge that is known to be another than in this session.
fn other_gauges(
    name: &str,
    there: Option<&SessionHeader>,
    here: Option<&SessionHeader>,
) -> Vec<String> {
    let (Some(there), Some(here)) = (there, here) else {
        return Vec::new();
    };
    let gauges = [
        ("force", &there.instruments.force, &here.instruments.force),
        (
            "displacement",
            &there.instruments.displacement,
            &here.instruments.displacement,
        ),
    ];
    gauges
        .into_iter()
        .filter(|(_, there, here)| is_another(there.as_ref(), here.as_ref()))
        .map(|(gauge, ..)| format!("{name} was measured with another {gauge} gauge: its scatter counts only if both scatter alike"))
        .collect()
}

fn is_another(there: Option<&InstrumentRecord>, here: Option<&InstrumentRecord>) -> bool {
    let (Some(there), Some(here)) = (there, here) else {
        return false;
    };
    let differ = |a: &Option<String>, b: &Option<String>| a.is_some() && b.is_some() && a != b;
    differ(&there.model, &here.model) || differ(&there.serial, &here.serial)
}
