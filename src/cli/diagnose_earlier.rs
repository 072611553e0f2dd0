//! `diagnose --earlier`: how earlier sessions on the same bench scattered.

use std::path::Path;

use crate::mismatch::{Baseline, EarlierNoise, KnownNoise, Observations, SearchOptions, diagnose};
use crate::readings::{InstrumentRecord, SessionHeader};
use crate::report::EarlierSession;

use super::args::{Global, LogArgs};
use super::data::{Session, load_session};
use super::design;
use super::diagnose::called;
use super::diagnose_args::DiagnoseArgs;
use super::failure::{CliError, Failure};
use super::progress::progress;
use super::resolve::resolve;

/// The scatter of earlier sessions that is that of this one, and what each told.
///
/// # Arguments
/// - `search`: how this session is searched, of whose noise nothing is known yet.
pub(super) fn earlier_noise(
    args: &DiagnoseArgs,
    baseline: &dyn Baseline,
    observations: &Observations,
    (search, session): (&SearchOptions, &mut Session),
    global: &Global,
) -> Result<(KnownNoise, Vec<EarlierSession>), Failure> {
    let here = design::data(args)?;
    let bar = progress(
        global,
        "scatter of earlier sessions",
        args.earlier.len() as u64,
    );
    let mut others = Vec::new();
    for path in &args.earlier {
        others.push(scatter_of(path, args, search, global)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    for (place, (path, (other, _))) in args.earlier.iter().zip(&others).enumerate() {
        let twice = is_same(path, other, (here, session))
            || (0..place)
                .any(|before| is_same(path, other, (&args.earlier[before], &others[before].0)));
        if twice {
            return Err(counted_twice(path).into());
        }
    }
    let own = EarlierNoise::of(&diagnose(baseline, observations, search, None)?.0);
    let mut sessions = Vec::new();
    for (path, (other, noise)) in args.earlier.iter().zip(others) {
        let name = called(&other, path);
        let warnings = other
            .warnings
            .iter()
            .map(|warning| format!("{name}: {warning}"));
        session.warnings.extend(warnings);
        session.warnings.extend(other_gauges(
            &name,
            other.header.as_ref(),
            session.header.as_ref(),
        ));
        let chance = own
            .as_ref()
            .map_or(1.0, |own| noise.chance_of_the_same(own));
        let used = own.as_ref().is_none_or(|own| noise.is_like(own));
        if !used {
            session.warnings.push(format!(
                "{name} scatters otherwise than this session (p = {chance:.1e}) and is left out: what was changed on the bench since?"
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
        .filter(|told| told.used)
        .map(|told| told.noise)
        .collect();
    let known = EarlierNoise::pooled(&used).map_or(KnownNoise::Nothing, KnownNoise::Earlier);
    Ok((known, sessions))
}

/// A session of its own, and how it scatters once what it lacks has been found.
fn scatter_of(
    path: &Path,
    args: &DiagnoseArgs,
    search: &SearchOptions,
    global: &Global,
) -> Result<(Session, EarlierNoise), Failure> {
    let mut session = load_session(path, &LogArgs::default(), global)?;
    let chosen = resolve(&args.model, Some(&mut session))?;
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let observations = Observations::new(&session.table, session.header.as_ref());
    let baseline = design::baseline(&chosen, mechanism, &observations.poses, &args.parameters)?;
    let (diagnosis, _) = diagnose(&baseline, &observations, search, None)?;
    let noise = EarlierNoise::of(&diagnosis).ok_or_else(|| CliError::Argument {
        argument: format!("--earlier {}", path.display()),
        problem: format!(
            "its readings cannot tell how they scatter: {}",
            diagnosis.lacking.join("; ")
        ),
        help: Some("leave it out, or name a session with repeats".to_owned()),
    })?;
    Ok((session, noise))
}

/// Whether two sessions are one.
fn is_same(path: &Path, session: &Session, (other_path, other): (&Path, &Session)) -> bool {
    let id = |session: &Session| session.header.as_ref().and_then(|header| header.id.clone());
    let place = |path: &Path| path.canonicalize().ok();
    place(path) == place(other_path) || (id(session).is_some() && id(session) == id(other))
}

fn counted_twice(path: &Path) -> CliError {
    CliError::Argument {
        argument: format!("--earlier {}", path.display()),
        problem: "this session is there already: its scatter would count twice".to_owned(),
        help: Some("name other sessions of the same bench".to_owned()),
    }
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
