//! Several sessions of one robot, laid out for one analysis.

use std::collections::BTreeSet;

use serde::Deserialize;

use crate::mismatch::{
    BadReading, BadRun, KnownNoise, LawAtPlace, Observations, ReadingNoise, noise_alone,
    screen_data,
};
use crate::parameters::ParameterChoice;
use crate::session::read_inside;
use crate::test_point::{Direction, PoseId};

use super::data::LoadedSession;
use super::design::baseline_of;
use super::error::{ArgumentError, Failure};
use super::hash::sha256;
use super::model::{ModelChoice, ResolvedModel, resolve};
use super::procedure::add_pose;
use super::session_table::SessionTable;
use super::stored::StoredResult;

/// One of several sessions that are analysed together.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionShare {
    /// What the page calls it: its poses are `name/pose`.
    pub name: String,
    /// What the user calls it.
    pub data: String,
    /// Readings that were searched.
    pub readings: usize,
    /// Its runs.
    pub runs: usize,
    /// Readings that its repeats contradict.
    pub bad_readings: usize,
    /// Its noise, as it stands at the end.
    pub noise: ReadingNoise,
    /// Between what an earlier diagnosis, stored beside this session, could not decide.
    pub open_before: Option<OpenBefore>,
}

/// What an earlier diagnosis left open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenBefore {
    /// How many sessions it was of: this one, and others of those that are analysed together now.
    pub sessions: usize,
    /// Laws and places.
    pub open: Vec<LawAtPlace>,
}

/// Of a stored diagnosis what it left open.
#[derive(Deserialize)]
struct EarlierDiagnosis {
    findings: Vec<EarlierFinding>,
}

#[derive(Deserialize)]
struct EarlierFinding {
    #[serde(flatten)]
    law: LawAtPlace,
    alternative_group: Option<u32>,
}

/// A reading that is part of a data finding.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkedReading {
    /// Its pose.
    pub pose: PoseId,
    /// Its direction.
    pub direction: Direction,
    /// Signed force, N.
    pub force_n: f64,
    /// What was read, m.
    pub displacement_m: f64,
}

/// Readings of some lines.
pub(super) fn marked<'o>(
    observations: &'o Observations,
    is_of: &'o dyn Fn(u32) -> bool,
) -> impl Iterator<Item = MarkedReading> + 'o {
    let readings = observations.readings.iter().enumerate();
    let found = readings.filter(|(_, detail)| is_of(detail.line));
    found.map(|(reading, _)| {
        let cell = &observations.cells[observations.cell_of(reading)];
        MarkedReading {
            pose: observations.poses[cell.pose].clone(),
            direction: cell.axis(),
            force_n: observations.loads[reading].force_n,
            displacement_m: observations.displacement_m[reading],
        }
    })
}

/// The readings of one session or several.
pub(super) struct LaidOut {
    pub(super) observations: Observations,
    /// The same with every pose under its own name.
    pub(super) done: Observations,
    /// Poses as the robot names them, one for each of the observations'.
    pub(super) poses: Vec<PoseId>,
    pub(super) bad_runs: Vec<BadRun>,
    pub(super) bad_readings: Vec<BadReading>,
    pub(super) marked: Vec<MarkedReading>,
    pub(super) tails_dof: Option<f64>,
    /// Largest displacement without load from which a cell counts, m, of sessions whose gauge was not zeroed there.
    pub(super) unloaded_shift_m: Option<f64>,
    /// Empty of one session.
    pub(super) sessions: Vec<SessionShare>,
}

/// Readings as a search takes them, with the session they belong to.
pub(super) type SessionObservations = SessionTable<Observations>;

impl LoadedSession {
    /// Its readings as a search takes them.
    pub(super) fn observed(&self) -> SessionObservations {
        self.with_table(Observations::new(&self.table, self.header.as_ref()))
    }
}

/// Lays out sessions, each without the readings that its own repeats contradict.
pub(super) fn lay_out(
    sessions: &[SessionObservations],
    model: &ResolvedModel,
    parameters: &ParameterChoice,
    keep_outliers: bool,
) -> Result<LaidOut, Failure> {
    let names = names(sessions);
    let (mut own, mut shares) = (Vec::new(), Vec::new());
    let (mut bad_runs, mut bad_readings) = (Vec::new(), Vec::new());
    let mut marked_readings = Vec::new();
    let several = sessions.len() > 1;
    let mut tails_dof: Option<f64> = None;
    let mut unloaded_shift_m: Option<f64> = None;
    for (session, name) in sessions.iter().zip(&names) {
        let observations = session.table.clone();
        let shifts = [unloaded_shift_m, observations.unloaded_shift_m];
        unloaded_shift_m = shifts.into_iter().flatten().reduce(f64::max);
        let baseline = baseline_of(model, &observations, &observations.poses, parameters)?;
        let screened = screen_data(&baseline, &observations, &KnownNoise::Nothing)?;
        let named = |pose: PoseId| {
            if several {
                PoseId::new(&format!("{name}/{pose}"))
            } else {
                pose
            }
        };
        let of_runs = screened.bad_runs.iter().flat_map(|bad| &bad.lines);
        let bad_lines: BTreeSet<u32> = of_runs
            .chain(screened.bad_readings.iter().map(|bad| &bad.line))
            .copied()
            .collect();
        let is_bad = |line| bad_lines.contains(&line);
        let marks = marked(&observations, &is_bad);
        marked_readings.extend(marks.map(|one| MarkedReading {
            pose: named(one.pose),
            ..one
        }));
        let kept = if keep_outliers {
            observations
        } else {
            screened.observations
        };
        // The longest tails.
        tails_dof = match (tails_dof, screened.tails_dof) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
        if sessions.len() > 1 {
            shares.push(SessionShare {
                name: name.clone(),
                data: session.name.clone(),
                readings: kept.len(),
                runs: kept.runs.len(),
                bad_readings: screened.bad_readings.len(),
                noise: noise_alone(&baseline, &kept)?,
                open_before: open_before(session, sessions),
            });
        }
        bad_runs.extend(screened.bad_runs.into_iter().map(|bad| {
            BadRun {
                pose: named(bad.pose),
                exchanged_with: bad
                    .exchanged_with
                    .map(|(pose, direction)| (named(pose), direction)),
                ..bad
            }
        }));
        bad_readings.extend(screened.bad_readings.into_iter().map(|bad| BadReading {
            pose: named(bad.pose),
            ..bad
        }));
        own.push(kept);
    }
    let poses = own.iter().flat_map(|one| one.poses.iter().cloned());
    let poses: Vec<PoseId> = poses.collect();
    let observations = if let [one] = &own[..] {
        one.clone()
    } else {
        let joined: Vec<(&str, &Observations, ReadingNoise)> = shares
            .iter()
            .zip(&own)
            .map(|(share, own)| (&share.name[..], own, share.noise))
            .collect();
        Observations::joined(&joined)
    };
    Ok(LaidOut {
        done: observations.with_pose_names(&poses),
        observations,
        poses,
        bad_runs,
        bad_readings,
        marked: marked_readings,
        tails_dof,
        unloaded_shift_m,
        sessions: shares,
    })
}

/// What a diagnosis that is stored beside a session left open, if it was of fewer sessions than now.
fn open_before<T>(session: &SessionTable<T>, now: &[SessionTable<T>]) -> Option<OpenBefore> {
    let bytes = read_inside(&session.folder, "diagnosis/diagnosis.json").ok()?;
    let text = String::from_utf8(bytes).ok()?;
    let stored = StoredResult::<EarlierDiagnosis>::read("diagnosis", &text).ok()?;
    let before: Vec<&str> = stored.inputs.hashes_of_data().collect();
    let is_there = |hash: &&str| now.iter().any(|session| session.sha256 == *hash);
    let is_earlier = before.len() < now.len() && before.iter().all(is_there);
    let findings = stored.data.findings.into_iter().filter(|_| is_earlier);
    let open = findings.filter(|finding| finding.alternative_group.is_some());
    let open: Vec<LawAtPlace> = open.map(|finding| finding.law).collect();
    (!open.is_empty()).then_some(OpenBefore {
        sessions: before.len(),
        open,
    })
}

/// Short names, each of one session only, that places can hold.
pub(super) fn names<T>(sessions: &[SessionTable<T>]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for session in sessions {
        let plain = |c: char| if "./@:,= ".contains(c) { '-' } else { c };
        let short: String = session.short_name().chars().map(plain).collect();
        let mut name = short.clone();
        let mut number = 2;
        while names.contains(&name) {
            name = format!("{short}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// The model of sessions of one robot, with the poses of all of them.
///
/// # Errors
/// For a session that is there already, another robot file, another mechanism, and a pose with other joint values than before; as
/// [`resolve`] besides.
pub(super) fn resolve_together(
    sessions: &[LoadedSession],
    choice: &ModelChoice,
) -> Result<ResolvedModel, Failure> {
    let mut model = resolve(choice, sessions.first())?;
    for (place, session) in sessions.iter().enumerate().skip(1) {
        let own = resolve(choice, Some(session))?;
        join_session(&mut model, &sessions[..place], session, &own)?;
    }
    Ok(model)
}

/// Takes a further session of the same robot into a model: its poses, where they are not there.
///
/// # Arguments
/// - `before`: the sessions that the model has already, at least one.
/// - `own`: the model of the further session by itself.
fn join_session(
    model: &mut ResolvedModel,
    before: &[LoadedSession],
    session: &LoadedSession,
    own: &ResolvedModel,
) -> Result<(), Failure> {
    let wrong = |problem: String, remedy: &str| -> Failure {
        ArgumentError::new(session.name.clone(), problem, remedy).into()
    };
    let first = before.first().map_or("the first data", |first| &first.name);
    if let Some(same) = before.iter().find(|one| one.sha256 == session.sha256) {
        return Err(wrong(
            format!(
                "it has the same readings as {}: they would count twice",
                same.name
            ),
            "name each session once",
        ));
    }
    if sha256(&own.source.text) != sha256(&model.source.text) {
        return Err(wrong(
            format!(
                "it was measured on another robot file ({}) than {first} ({}): their SHA-256 differ",
                own.source.name, model.source.name
            ),
            "name sessions of one robot; --robot FILE gives all of them the same file",
        ));
    }
    if own.mechanism != model.mechanism {
        return Err(wrong(
            format!(
                "it was measured with mechanism {}, {first} with {}",
                own.mechanism, model.mechanism
            ),
            "name sessions of one mechanism, or give --mechanism",
        ));
    }
    for pose in session.table.poses() {
        let placed = own.robot.pose(&pose)?;
        match model.robot.pose(&pose) {
            Ok(known) if known != placed => {
                return Err(wrong(
                    format!("its pose {pose} has other joint values than in {first}"),
                    "rename the pose in one of the sessions (procedure and readings)",
                ));
            }
            Ok(_) => {}
            Err(_) => add_pose(&mut model.robot, &pose, placed.clone()),
        }
    }
    Ok(())
}
