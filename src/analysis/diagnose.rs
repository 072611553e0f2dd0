//! Diagnoses: what the model leaves out.

use crate::fit::{PoseRules, TableMistake};
use crate::mismatch::{
    BadReading, BadRun, Baseline, BaselineParameter, Diagnosis, DiagnosisTrace, EstimatedNoise,
    KnownNoise, LawCriticalValues, Line, Located, Location, MismatchError, NextMeasurement,
    Observations, PartModel, PartUnits, RobotBaseline, SearchOptions, StatedScatter,
    diagnose_and_locate, given_noise, reading_between_slips, trace,
};
use crate::parameters::ParameterChoice;
use crate::physics::{Effect, FileLine, Law};
use crate::specimen::SpecimenTable;

use super::data::{Data, LoadedLoadCases, LoadedSession};
use super::design::{baseline_of, proposals, proposals_for_part};
use super::earlier::{EarlierSession, MeasuredNoise, pooled_noise};
use super::error::{AnalysisError, ArgumentError, Failure};
use super::inputs::Inputs;
use super::listed_stiffness::listed_load_cases;
use super::model::{ModelChoice, ResolvedModel};
use super::posed::PosedData;
use super::session_table::SessionTable;
use super::subject::{RobotSubject, Subject};
use super::together::{
    MarkedReading, SessionObservations, SessionShare, lay_out, marked, resolve_together,
};
use super::unknown_springs::UnknownSprings;

/// The scatter of the readings may exceed what the records state by this much before there is a warning.
const RECORD_TOO_GOOD: f64 = 1.5;

/// How a diagnosis searches.
#[derive(Debug, Default)]
pub struct DiagnoseSettings {
    /// Which parameters of the model are free beside every candidate. `None`: those of [`DiagnosisData::usual_choice`].
    pub parameters: Option<ParameterChoice>,
    /// Laws that the search leaves out.
    pub without: Vec<Law>,
    /// Seed of the simulated noise from which the critical values come.
    pub seed: u64,
    /// Where the noise of single readings comes from.
    pub noise: NoiseSource,
    /// Whether readings and runs that their repeats contradict stay in.
    pub keep_outliers: bool,
    /// What is stated of the poses that may be proposed.
    pub rules: PoseRules,
}

/// Where the noise of single readings comes from.
#[derive(Debug, Default)]
pub enum NoiseSource {
    /// What is stated with the readings, else these.
    #[default]
    Readings,
    /// The records of the instruments: step of the displacement gauge and spread when settled.
    Records,
    /// The readings, together with those of earlier sessions on the same bench, each as [`noise_of`](super::noise_of) has it.
    EarlierSessions(Vec<MeasuredNoise>),
}

impl NoiseSource {
    /// Refuses noise that is known for one session where several are diagnosed.
    fn serves(&self, sessions: usize) -> Result<(), ArgumentError> {
        if sessions > 1 && !matches!(self, Self::Readings) {
            return Err(ArgumentError::new(
                "--noise, --earlier",
                "each of several sessions has its own noise, by its own readings",
                "leave it out, or diagnose one session",
            ));
        }
        Ok(())
    }
}

/// Where the noise of a diagnosis came from.
#[derive(Debug, Clone, PartialEq)]
pub enum NoiseOrigin {
    /// The readings.
    Readings,
    /// The user, or a list of stiffness values, states it.
    Stated,
    /// The readings, but for that of single ones, which the records of the instruments give.
    Records,
    /// The readings, together with those of earlier sessions on the same bench.
    EarlierSessions(Vec<EarlierSession>),
}

/// A diagnosis with everything that is reported beside it.
#[derive(Debug, Clone)]
pub struct DiagnosisReport {
    /// What the data are called.
    pub data: String,
    /// What it is of.
    pub subject: Subject,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// Its critical values.
    pub critical: LawCriticalValues,
    /// Factors of the baseline, their values as logarithms; of a part its slopes.
    pub parameters: Vec<BaselineParameter>,
    /// Runs that their repeats contradict, and cells that cannot be.
    pub bad_runs: Vec<BadRun>,
    /// Readings that their repeats contradict.
    pub bad_readings: Vec<BadReading>,
    /// The readings of both.
    pub marked_readings: Vec<MarkedReading>,
    /// Degrees of freedom of Student's t of the others; none where a normal distribution fits as well.
    pub tails_dof: Option<f64>,
    /// What a table of load cases has wrong as a whole.
    pub table_mistake: Option<TableMistake>,
    /// Whether they were kept for the search all the same.
    pub outliers_kept: bool,
    /// Lines of the robot file that findings accuse.
    pub file_lines: Vec<(Effect, FileLine)>,
    /// The readings that were searched.
    pub observations: Observations,
    /// The sessions, where they are several.
    pub sessions: Vec<SessionShare>,
    /// Where the model without effects fails, and what carries it.
    pub located: Located,
    /// What the models say of every reading.
    pub trace: DiagnosisTrace,
    /// Plans that would separate what is open.
    pub next: Vec<NextMeasurement>,
    /// The procedures of these plans: file name and text (TOML).
    pub procedures: Vec<(String, String)>,
    /// Laws that the search left out.
    pub without: Vec<Law>,
    /// Where the noise comes from.
    pub noise_origin: NoiseOrigin,
    /// Seed of the simulated noise.
    pub seed: u64,
    /// What a user should know, beside the warnings of session and model.
    pub warnings: Vec<String>,
}

impl DiagnosisReport {
    /// Where the model without effects fails: strata that noise does not explain, and swings of the clock; where no stratum shows
    /// anything, the pattern that stands out most.
    ///
    /// The strata are tested apart from each other. Patterns are not: what misfits in one stratum leaks into those of others.
    #[must_use]
    pub fn locations(&self) -> Vec<Location> {
        let mut locations = self.located.locations();
        let is_told = !locations.is_empty();
        let (swings, patterns): (Vec<&Location>, Vec<_>) = self
            .diagnosis
            .locations
            .iter()
            .partition(|pattern| pattern.period_s.is_some());
        let first = patterns.into_iter().take(usize::from(!is_told));
        locations.extend(first.chain(swings).cloned());
        locations
    }

    /// Where the misfit sits that no finding explains.
    #[must_use]
    pub fn unexplained(&self) -> Location {
        let first = self.locations().into_iter().next();
        let first = first.filter(|_| self.diagnosis.findings.is_empty());
        first.unwrap_or_else(|| self.diagnosis.unexplained.clone())
    }
}

/// Data ready to be diagnosed.
#[derive(Debug)]
pub struct DiagnosisData {
    /// Robot, mechanism, factors.
    pub model: ResolvedModel,
    /// What a user should know of the data and the model.
    pub warnings: Vec<String>,
    /// Data, robot, mechanism and factors.
    pub inputs: Inputs,
    observed: Observed,
    /// Whether the loads were never applied, as those of a list of stiffness values.
    is_list: bool,
}

/// What a diagnosis searches.
#[derive(Debug)]
enum Observed {
    /// Readings of runs.
    Series(Vec<SessionObservations>),
    /// Load cases, with the first session they belong to.
    Loads(Box<(SessionTable<()>, PosedData)>),
}

impl Observed {
    /// Load cases of one robot with its model, and what a user should know.
    fn loads(
        loaded: &[LoadedLoadCases],
        choice: &ModelChoice,
    ) -> Result<(ResolvedModel, Self, Vec<String>), Failure> {
        let (model, posed, warnings) = PosedData::new(loaded, choice)?;
        let first = loaded.first().ok_or(MismatchError::Empty)?;
        let loads = Box::new((first.with_table(()), posed));
        Ok((model, Self::Loads(loads), warnings))
    }
}

impl DiagnosisData {
    /// Resolves the model of sessions, load cases or stiffness values of one robot.
    ///
    /// # Errors
    /// For a model that cannot be resolved, and data that do not go together.
    pub fn new(data: &Data, choice: &ModelChoice) -> Result<Self, Failure> {
        let (model, observed, warnings) = match data {
            Data::Readings(sessions) => {
                let model = resolve_together(sessions, choice)?;
                let warnings = [data.warnings(), model.warnings.clone()].concat();
                let observed = sessions.iter().map(LoadedSession::observed).collect();
                (model, Observed::Series(observed), warnings)
            }
            Data::LoadCases(loaded) => Observed::loads(loaded, choice)?,
            Data::Stiffness { name, measured, .. } => {
                Observed::loads(&[listed_load_cases(name, measured)], choice)?
            }
        };
        Ok(Self {
            inputs: Inputs::default().with_data(data).with_model(&model),
            model,
            warnings,
            observed,
            is_list: matches!(data, Data::Stiffness { .. }),
        })
    }

    /// The parameters that are free unless the user says, as of [`FitData::usual_choice`](super::FitData::usual_choice).
    ///
    /// # Errors
    /// As there.
    pub fn usual_choice(&self) -> Result<ParameterChoice, Failure> {
        match &self.observed {
            Observed::Series(_) => Ok(self.model.usual_parameters()?),
            Observed::Loads(loads) => loads.1.usual_choice(&self.model),
        }
    }

    /// Finds what the model leaves out; it then has the poses that the report names. The physics of the model is known to act: its values are
    /// fitted again, and the search asks what is missing beside it.
    ///
    /// # Arguments
    /// - `step`: called after each of three steps: read, search, judge.
    ///
    /// # Errors
    /// For records without the step of the gauge, an earlier session that is this one, noise that is known for one session only, load cases
    /// that cannot be fitted, and readings that no search can begin with.
    pub fn diagnose(
        &mut self,
        mut options: DiagnoseSettings,
        step: &dyn Fn(),
    ) -> Result<DiagnosisReport, Failure> {
        if self.is_list {
            let unseen = Law::ALL
                .iter()
                .filter(|law| !law.is_in_proportion_to_load());
            options.without.extend(unseen);
        }
        match &self.observed {
            Observed::Series(sessions) => diagnose_together(sessions, &self.model, options, step),
            Observed::Loads(loads) => {
                let (first, posed) = &**loads;
                posed.diagnose(first, &mut self.model, options, step)
            }
        }
    }
}

/// Finds what a model leaves out of the readings of sessions: each with its own zeros, runs and noise, all with one structure and physics.
///
/// # Arguments
/// - `model`: with the poses of all sessions; its physics is known to act: its values are fitted again, and the search asks what is missing
///   beside it.
/// - `step`: called after each of three steps: read, search, judge.
///
/// # Errors
/// For no session, records without the step of the gauge, an earlier session that is this one, noise that is known for one session only, and
/// readings that no search can begin with.
pub(super) fn diagnose_together(
    sessions: &[SessionObservations],
    model: &ResolvedModel,
    options: DiagnoseSettings,
    step: &dyn Fn(),
) -> Result<DiagnosisReport, Failure> {
    let (Some(session), Some(last)) = (sessions.first(), sessions.last()) else {
        return Err(MismatchError::Empty.into());
    };
    options.noise.serves(sessions.len())?;
    let parameters = &(options.parameters).map_or_else(|| model.usual_parameters(), Ok)?;
    let mut laid = lay_out(sessions, model, parameters, options.keep_outliers)?;
    let mut baseline = baseline_of(model, &laid.observations, &laid.poses, parameters)?;
    baseline.suspect_file();
    step();
    let mut warnings: Vec<String> = laid.unloaded_shift_m.map(shifted).into_iter().collect();
    warnings.extend(kept(&baseline, model, parameters));
    let mut search = SearchOptions {
        noise: KnownNoise::Nothing,
        seed: options.seed,
        without: options.without,
        known_effects: model.physics.effects.clone(),
    };
    let own = (&baseline, &laid.observations, &search);
    let (known, noise_origin) = noise_from(options.noise, session, own, &mut warnings)?;
    search.noise = known;
    let mut found = diagnose_and_locate(&baseline, &laid.observations, &search)?;
    while !options.keep_outliers
        && let Some(bad) = reading_between_slips(&baseline, &laid.observations, &found.0)?
    {
        let mark = leave_out(&mut laid.observations, &bad);
        if bad.is_named() {
            laid.marked.extend(mark);
            laid.bad_readings.push(bad);
        } else {
            warnings.push(far_but_not_rare(&bad));
        }
        found = diagnose_and_locate(&baseline, &laid.observations, &search)?;
    }
    let (diagnosis, critical, located) = found;
    step();
    let trace = trace(&baseline, &laid.observations, &diagnosis)?;
    for (place, one) in laid.sessions.iter_mut().enumerate() {
        let noise = laid.observations.noise_of_session(place, &diagnosis.noise);
        one.noise = noise.unwrap_or(one.noise);
    }
    let header = last.header.as_ref();
    let fitted_factors = baseline.factors(&diagnosis.parameters);
    let known = (&diagnosis, &fitted_factors);
    let file_lines = file_lines(&baseline, model, &diagnosis);
    let proposed = proposals(
        model,
        header,
        &laid.done,
        known,
        (parameters, &options.rules),
    )?;
    warnings.extend(unseen_known_effects(&diagnosis).chain(proposed.note));
    step();
    Ok(DiagnosisReport {
        data: joined_name(session, &laid.sessions),
        sessions: laid.sessions,
        subject: Subject::Robot(RobotSubject {
            robot: model.robot.name.clone(),
            mechanism: model.mechanism.clone(),
            start_factors: model.factors_name.clone(),
            fitted_factors,
        }),
        diagnosis,
        critical,
        parameters: baseline.parameters().to_vec(),
        bad_runs: laid.bad_runs,
        bad_readings: laid.bad_readings,
        marked_readings: laid.marked,
        tails_dof: laid.tails_dof,
        table_mistake: None,
        outliers_kept: options.keep_outliers,
        file_lines,
        observations: laid.observations,
        located,
        trace,
        next: proposed.next,
        procedures: proposed.files,
        without: search.without,
        noise_origin,
        seed: search.seed,
        warnings,
    })
}

/// Finds what a straight line leaves out of the readings of a part without a robot file.
///
/// # Arguments
/// - `data`: what the table is called.
/// - `step`: called after each of three steps: read, search, judge.
///
/// # Returns
/// The report, and the model of the part; none where the readings cannot decide.
///
/// # Errors
/// For a table without readings that count, and readings that no search can begin with.
pub fn diagnose_part(
    data: &str,
    table: &SpecimenTable,
    search: &SearchOptions,
    step: &dyn Fn(),
) -> Result<(DiagnosisReport, Option<PartModel>), Failure> {
    let (line, observations) = Line::of_table(table)?;
    step();
    let (diagnosis, critical, located) = diagnose_and_locate(&line, &observations, search)?;
    step();
    let observations = diagnosis.sized(&observations);
    let trace = trace(&line, &observations, &diagnosis)?;
    let model = PartModel::new(table, (&line, &observations), &diagnosis)?;
    let next = proposals_for_part(&line, &observations, &diagnosis)?;
    step();
    let mut warnings = table.assumptions.clone();
    let excluded = table.excluded.to_string();
    warnings.extend((!excluded.is_empty()).then_some(excluded));
    let report = DiagnosisReport {
        data: data.to_owned(),
        subject: Subject::Part {
            units: PartUnits::new(table),
            layout: table.layout.clone(),
        },
        critical,
        parameters: line.parameters().to_vec(),
        bad_runs: Vec::new(),
        bad_readings: Vec::new(),
        marked_readings: Vec::new(),
        tails_dof: None,
        table_mistake: None,
        outliers_kept: true,
        file_lines: Vec::new(),
        sessions: Vec::new(),
        located,
        trace,
        next,
        procedures: Vec::new(),
        without: search.without.clone(),
        noise_origin: NoiseOrigin::Readings,
        seed: search.seed,
        warnings,
        diagnosis,
        observations,
    };
    Ok((report, model))
}

/// Lines of the robot file that findings accuse.
fn file_lines(
    baseline: &RobotBaseline<'_>,
    model: &ResolvedModel,
    diagnosis: &Diagnosis,
) -> Vec<(Effect, FileLine)> {
    let line = |effect: &Effect| {
        let suspects = baseline.suspects();
        let line = FileLine::of(&model.robot, suspects, &model.factors_name, effect)?;
        Some((effect.clone(), line))
    };
    let found = diagnosis.findings.iter();
    found.filter_map(|finding| line(&finding.effect)).collect()
}

/// What the data are called: a session by its name, several by all of them.
fn joined_name(session: &SessionObservations, shares: &[SessionShare]) -> String {
    if shares.is_empty() {
        return session.short_name();
    }
    let names: Vec<&str> = shares.iter().map(|one| &one.name[..]).collect();
    names.join(" + ")
}

/// Leaves a reading out, and hands it back as one that stands out.
fn leave_out(observations: &mut Observations, bad: &BadReading) -> Vec<MarkedReading> {
    let is_bad = |line| line == bad.line;
    let of_line = marked(observations, &is_bad);
    let mark = of_line.filter(|one| one.pose == bad.pose).collect();
    let keep: Vec<bool> = (0..observations.len())
        .map(|one| one != bad.reading)
        .collect();
    *observations = observations.filtered(&keep);
    mark
}

/// Springs that no reading tells of, and those without a value that are not free, in words.
fn kept(
    baseline: &RobotBaseline<'_>,
    model: &ResolvedModel,
    parameters: &ParameterChoice,
) -> Vec<String> {
    let unloaded = baseline.unloaded().iter();
    let unloaded = unloaded.map(|spring| format!("{spring} is kept: {}", spring.unloaded_words()));
    let unknown = UnknownSprings::of(model);
    let rigid = unknown.kept(parameters).into_iter();
    let rigid = rigid.map(|(spring, words)| format!("{spring}: {words}"));
    unloaded.chain(rigid).collect()
}

/// A reading that the search leaves out, though it is not bad, in words.
fn shifted(shift_m: f64) -> String {
    format!(
        "the displacement gauge was not zeroed without load, where it shows up to {:.1} µm: displacements are counted from there",
        shift_m * 1e6
    )
}

fn far_but_not_rare(reading: &BadReading) -> String {
    let off_m = reading.value_m - reading.expected_m;
    format!(
        "line {}: {} {}, repeat {}, step {} is {:.2} µm off its repeats, which happens in some sessions with such long-tailed errors (p = {:.2}): it is not called bad, but the search left it out, because it would take two opposite slips for it",
        reading.line,
        reading.pose,
        reading.direction,
        reading.repeat,
        reading.step,
        off_m * 1e6,
        reading.p_family
    )
}

/// Known effects that change no reading, in words.
fn unseen_known_effects(diagnosis: &Diagnosis) -> impl Iterator<Item = String> + '_ {
    let known = diagnosis.known_effects.iter();
    let unseen = known.filter(|known| known.before.iter().all(|value| value.u.is_none()));
    unseen
        .filter(|known| !known.given.values.is_empty())
        .map(|known| {
            format!(
                "{} changes none of these readings: its values stay as given",
                known.given
            )
        })
}

/// What is known of the noise before the search, and from where.
fn noise_from(
    source: NoiseSource,
    session: &SessionObservations,
    own: (&RobotBaseline<'_>, &Observations, &SearchOptions),
    warnings: &mut Vec<String>,
) -> Result<(KnownNoise, NoiseOrigin), Failure> {
    let (baseline, observations, search) = own;
    Ok(match (source, session.scatter) {
        (NoiseSource::Readings, None) => (KnownNoise::Nothing, NoiseOrigin::Readings),
        (NoiseSource::Readings, Some(stated)) => {
            let noise = given_noise(baseline, observations, stated)?.noise;
            (KnownNoise::Given(noise), NoiseOrigin::Stated)
        }
        (NoiseSource::Records, Some(_)) => {
            return ArgumentError::refuse(
                "--noise records",
                "--displacement-u states the scatter of load cases already",
                "leave out one of them",
            );
        }
        (NoiseSource::Records, None) => {
            let noise = recorded_noise(baseline, observations, session, warnings)?;
            (KnownNoise::Given(noise), NoiseOrigin::Records)
        }
        (NoiseSource::EarlierSessions(others), _) => {
            let own = (baseline as &dyn Baseline, observations, search);
            let (known, sessions) = pooled_noise(session, own, others, warnings)?;
            (known, NoiseOrigin::EarlierSessions(sessions))
        }
    })
}

/// The noise, its part of single readings from the records of the instruments.
fn recorded_noise(
    baseline: &RobotBaseline<'_>,
    observations: &Observations,
    session: &SessionObservations,
    warnings: &mut Vec<String>,
) -> Result<EstimatedNoise, Failure> {
    let Some(step_m) = observations.steps.displacement_m else {
        return Err(AnalysisError::NoResolution {
            data: session.name.clone(),
        }
        .into());
    };
    let header = session.header.as_ref();
    let procedure = header.and_then(|header| header.procedure.as_ref());
    let spread_m = procedure.and_then(|procedure| procedure.settle.spread_m);
    // A step, and a spread within which readings count as settled, are widths: anything within is as likely.
    let sd_m = step_m.hypot(spread_m.unwrap_or(0.0)) / 12f64.sqrt();
    let recorded = StatedScatter {
        displacement_sd_m: sd_m,
        force_sd_n: None,
    };
    let given = given_noise(baseline, observations, recorded)?;
    if given.seen_sd_m > RECORD_TOO_GOOD * sd_m {
        warnings.push(format!(
            "single readings scatter by {:.2} µm, the instrument records allow {:.2} µm: the excess scatter is taken for missing physics; --noise estimated avoids that",
            given.seen_sd_m * 1e6,
            sd_m * 1e6
        ));
    }
    Ok(given.noise)
}
