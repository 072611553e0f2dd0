//! Sessions, files of readings and lists of stiffness values, by the names that a user gives them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use jiff::civil::Date;

use crate::fit::MeasuredStiffness;
use crate::import::{ImportDraft, ImportMapping, VectorText};
use crate::load_cases::{LoadCaseTable, is_load_case_table, read_load_cases};
use crate::nearest::nearest;
use crate::readings::{
    OverdueGauge, PoseJoints, Reading, ReadingTable, SessionHeader, TableError, is_vector_table,
    read_readings, write_readings,
};
use crate::stiffness::{
    Branches, GaugePair, GaugeTerms, Method, StiffnessOptions, StiffnessTable,
    stiffness_table_with_drifts,
};
use crate::stiffness_list::{is_stiffness_list, read_stiffness_list};

use super::calibration::GivenCalibration;
use super::data_check::asked_about_runs;
use super::error::{AnalysisError, ArgumentError, Failure};
use super::files::{
    first_line, folder_of, is_file, is_there, read_bytes, read_text, session_file, shown,
};
use super::hash::sha256;
use super::integrity::compare_with_journal;
use super::plausible::doubts_about_readings;
use super::session_table::{SessionTable, origin_of};

/// Stiffness lists that come with the program.
const SHIPPED_LISTS: [(&str, &str); 3] = [
    (
        "paper-experiment",
        include_str!("../../data/paper/experiment.csv"),
    ),
    (
        "paper-reference",
        include_str!("../../data/paper/reference.csv"),
    ),
    (
        "calculix-reference",
        include_str!("../../data/reference/hp-robot-P1/reference.csv"),
    ),
];

/// How data are opened.
#[derive(Debug, Clone, Default)]
pub struct OpenSettings {
    /// Use a `readings.csv` that differs from the journal beside it; the session then has a warning.
    pub trust_csv: bool,
    /// Whether the gauges must be calibrated.
    pub calibration: CalibrationCheck,
    /// Calibration of the gauges, beside what the session states.
    pub gauges: GivenCalibration,
    /// What the columns of a table of another program mean, and what holds for all its rows.
    pub columns: ImportMapping,
}

/// What is done about a gauge whose calibration had run out on the last day of the measurement, or on the day given here (today) if that
/// day is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CalibrationCheck {
    /// Nothing.
    #[default]
    None,
    /// The gauge is named in the session.
    Name(Date),
    /// The session has a warning too.
    Warn(Date),
    /// The session is not opened.
    Refuse(Date),
}

impl CalibrationCheck {
    /// Today, if it was given.
    fn day(self) -> Option<Date> {
        match self {
            Self::None => None,
            Self::Name(day) | Self::Warn(day) | Self::Refuse(day) => Some(day),
        }
    }
}

/// Readings with the session they belong to.
pub type LoadedSession = SessionTable<ReadingTable>;

/// Load cases with the session they belong to.
pub type LoadedLoadCases = SessionTable<LoadCaseTable>;

/// Data to fit or to diagnose.
#[derive(Debug, Clone)]
pub enum Data {
    /// Readings of sessions of one robot.
    Readings(Vec<LoadedSession>),
    /// Loads and readings as vectors, of one robot.
    LoadCases(Vec<LoadedLoadCases>),
    /// Stiffness values without readings.
    Stiffness {
        /// What the user called them.
        name: String,
        /// SHA-256 of their text, in hexadecimal.
        sha256: String,
        /// The values.
        measured: MeasuredStiffness,
    },
}

const LOAD_CASES: &str = "load cases (loads and displacements as vectors)";
const SERIES: &str = "readings of one direction over several loads";

impl Data {
    /// Opens a session folder, a readings file, a list of stiffness values or a shipped list
    /// (`paper-experiment`, `paper-reference`, `calculix-reference`).
    ///
    /// # Errors
    /// For data that are not there, cannot be read or are not what they should be.
    pub fn open(path: &Path, options: &OpenSettings) -> Result<Self, Failure> {
        if let Some((name, text)) = shipped_list(path) {
            return Ok(Self::Stiffness {
                name: name.to_owned(),
                sha256: sha256(text),
                measured: MeasuredStiffness::of_list(&read_stiffness_list(name, text.as_bytes())?),
            });
        }
        let may_be_list = is_file(path) && !LoadedLoadCases::is_at(path, options);
        if may_be_list && is_stiffness_list(first_line(path)?.as_bytes()) {
            let name = shown(path);
            let bytes = read_bytes(path)?;
            return Ok(Self::Stiffness {
                measured: MeasuredStiffness::of_list(&read_stiffness_list(&name, &bytes)?),
                sha256: sha256(&bytes),
                name,
            });
        }
        Self::open_readings(path, options)
    }

    /// The same without lists of stiffness values.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_readings(path: &Path, options: &OpenSettings) -> Result<Self, Failure> {
        if LoadedLoadCases::is_at(path, options) {
            let loaded = LoadedLoadCases::open(path, options)?;
            return Ok(Self::LoadCases(vec![loaded]));
        }
        let session = LoadedSession::open_series(path, options)?;
        Ok(Self::Readings(vec![session]))
    }

    /// Opens further data of one kind with these.
    ///
    /// # Errors
    /// As [`open`](Self::open), for data of another kind, and for stiffness values, which are fitted alone.
    pub fn with(self, further: &[PathBuf], options: &OpenSettings) -> Result<Self, Failure> {
        const OF_ONE_KIND: &str = "name data of one kind";
        match self {
            Self::Readings(mut all) => {
                for path in further {
                    if LoadedLoadCases::is_at(path, options) {
                        let first = all.first().map_or("the first data", |one| &one.name);
                        let problem = format!("it holds {LOAD_CASES}, {first} {SERIES}");
                        return ArgumentError::refuse(shown(path), problem, OF_ONE_KIND);
                    }
                    all.push(LoadedSession::open_series(path, options)?);
                }
                Ok(Self::Readings(all))
            }
            Self::LoadCases(mut all) => {
                for path in further {
                    if is_there(path) && !LoadedLoadCases::is_at(path, options) {
                        let first = all.first().map_or("the first data", |one| &one.name);
                        let problem = format!("it holds no {LOAD_CASES}, as {first} does");
                        return ArgumentError::refuse(shown(path), problem, OF_ONE_KIND);
                    }
                    all.push(LoadedLoadCases::open(path, options)?);
                }
                Ok(Self::LoadCases(all))
            }
            Self::Stiffness { name, .. } if !further.is_empty() => ArgumentError::refuse(
                name,
                "it holds stiffness values, and several data are fitted together if all hold readings",
                "name sessions, or one list alone",
            ),
            list @ Self::Stiffness { .. } => Ok(list),
        }
    }

    /// What a user should know of the data.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        match self {
            Self::Readings(all) => all.iter().flat_map(|one| one.warnings.clone()).collect(),
            Self::LoadCases(all) => all.iter().flat_map(|one| one.warnings.clone()).collect(),
            Self::Stiffness { .. } => Vec::new(),
        }
    }

    /// Refuses load cases.
    ///
    /// # Errors
    /// For load cases.
    pub fn refuse_load_cases(&self, needs: &'static str) -> Result<(), Failure> {
        match self {
            Self::LoadCases(all) => all.first().map_or(Ok(()), |one| Err(one.needs_runs(needs))),
            Self::Readings(_) | Self::Stiffness { .. } => Ok(()),
        }
    }

    /// The stiffness values, or those to which the readings reduce: loading branches, regression.
    ///
    /// # Errors
    /// For a session whose record of a gauge cannot be.
    pub fn measured(self) -> Result<MeasuredStiffness, Failure> {
        self.refuse_load_cases("this subcommand")?;
        Ok(match self {
            Self::Stiffness { measured, .. } => measured,
            Self::Readings(all) if !all.is_empty() => {
                let table = all[0].stiffness(Branches::LoadingOnly)?;
                MeasuredStiffness::from_table(&table, Method::Regression)
            }
            Self::Readings(_) | Self::LoadCases(_) => MeasuredStiffness::default(),
        })
    }
}

/// A list that comes with the program; a file of that name goes first.
fn shipped_list(path: &Path) -> Option<(&'static str, &'static str)> {
    SHIPPED_LISTS
        .into_iter()
        .find(|(name, _)| !path.exists() && path.as_os_str() == *name)
}

/// Whether data of this name came with the program, with the paper's robot as theirs.
pub(super) fn is_shipped_list(name: &str) -> bool {
    shipped_list(Path::new(name)).is_some()
}

/// The file with the readings of a session folder, or the file itself.
pub(super) fn readings_file(path: &Path) -> Result<PathBuf, Failure> {
    if path.is_dir() {
        if let Some(file) = session_file(path, "readings.csv")? {
            return Ok(file);
        }
        let path = path.to_owned();
        return Err(AnalysisError::NoSession { path }.into());
    }
    let is_toml = path.extension().is_some_and(|ending| ending == "toml");
    if is_toml && path.is_file() {
        return ArgumentError::refuse(
            path.display().to_string(),
            "this is a TOML file, not readings",
            "name a session folder or a table of readings; a robot goes behind --robot, a procedure behind --procedure",
        );
    }
    if is_there(path) {
        return Ok(path.to_owned());
    }
    let shipped = SHIPPED_LISTS.map(|(name, _)| name);
    let help = match nearest(&path.to_string_lossy(), shipped) {
        Some(near) => format!("did you mean {near}, which comes with the program?"),
        None => "name a session folder or a readings file; paths start in the folder you are in"
            .to_owned(),
    };
    Err(AnalysisError::NotFound {
        path: path.to_owned(),
        help,
    }
    .into())
}

/// `session.toml` in a folder, if there is one.
///
/// # Errors
/// For a file that cannot be read or is no session's.
pub fn session_header(
    folder: &Path,
    warnings: &mut Vec<String>,
) -> Result<Option<SessionHeader>, Failure> {
    let Some(path) = session_file(folder, "session.toml")? else {
        return Ok(None);
    };
    let text = read_text(&path)?;
    let name = path.display().to_string();
    let read = SessionHeader::from_toml(&name, &text)?;
    warnings.extend(read.unknown_keys.iter().map(|key| key.warning(&name)));
    Ok(Some(read.header))
}

impl LoadedSession {
    /// Opens readings of one gauge ([`LoadedSession::open`]) or of several along the base axes.
    ///
    /// # Errors
    /// As [`LoadedSession::open`].
    pub fn open_series(path: &Path, options: &OpenSettings) -> Result<Self, Failure> {
        Self::open_gauges(path, options, true)
    }

    /// Opens a session folder, a readings file, or a table of another program.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, a list of stiffness values, a table that differs from its journal, and an
    /// overdue calibration, as the options have it; and for readings of several gauges.
    pub fn open(path: &Path, options: &OpenSettings) -> Result<Self, Failure> {
        Self::open_gauges(path, options, false)
    }

    fn open_gauges(
        path: &Path,
        options: &OpenSettings,
        takes_several: bool,
    ) -> Result<Self, Failure> {
        // Displacements without repeats, which also can be a list, may be readings that lack the column.
        let is_list = is_file(path) && first_line(path)?.contains("stiffness_N_per_um");
        if shipped_list(path).is_some() || is_list {
            return Err(AnalysisError::NeedsReadings {
                data: path.display().to_string(),
                needs: "this subcommand",
            }
            .into());
        }
        let file = readings_file(path)?;
        let folder = folder_of(&file);
        let name = shown(&file);
        let bytes = read_bytes(&file)?;
        let own = own_names(&name, &bytes, options)?;
        let text = own.as_ref().map_or(&bytes[..], |own| own.text.as_bytes());
        let of_vectors = is_vector_table(text);
        if of_vectors && !takes_several {
            return Err(AnalysisError::Vectors { path: file }.into());
        }
        if of_vectors {
            options.gauges.refuse(&name)?;
        }
        if LoadedLoadCases::is_at(path, options) {
            return Err(LoadedLoadCases::open(path, options)?.needs_runs("this subcommand"));
        }
        let mut read = if of_vectors {
            read_readings(&name, text)?.into()
        } else {
            read_or_imported(&name, &bytes, &options.columns)?
        };
        let warnings = &mut read.warnings;
        warnings.extend(own.into_iter().flat_map(|own| own.notes));
        // Of several gauges the notes would be on each.
        let notes = read.table.notes.iter().filter(|_| !of_vectors);
        warnings.extend(notes.cloned());
        let mut header = session_header(&folder, warnings)?;
        if !read.poses.is_empty() {
            let header = header.get_or_insert_default();
            header.procedure.get_or_insert_default().joint_values = read.poses;
        }
        let mut differs_from_journal = false;
        let is_of_session = file.file_name().is_some_and(|name| name == "readings.csv");
        if is_of_session
            && !read.is_foreign
            && let Some(check) = compare_with_journal(&folder, &read.table, header.as_ref())?
        {
            differs_from_journal = check.judge(&file, options.trust_csv, warnings)?;
        }
        let calibration = options.gauges.apply(&mut read.table, &mut header, warnings);
        let today = options.calibration.day();
        warnings.extend(doubts_about_readings(&read.table, header.as_ref(), today));
        warnings.extend(asked_about_runs(&read.table, header.as_ref()));
        let mut session = Self {
            origin: origin_of(read.table.origin.as_ref(), header.as_ref()),
            header,
            folder,
            warnings: read.warnings,
            calibration,
            differs_from_journal,
            ..Self::bare(shown(path), &bytes, read.table)
        };
        if !of_vectors {
            let read_off = session.gauges()?;
            session.warnings.extend(read_off.read_off());
        }
        let texts = session.table.one_of_each_load();
        let texts = texts.filter_map(|reading| reading.text.as_ref());
        session.overdue = check_calibration(
            session.header.as_ref(),
            last_day(texts.map(|text| &*text.utc)),
            options.calibration,
            &mut session.warnings,
        )?;
        Ok(session)
    }

    /// A session of readings from memory, for example simulated ones, without `session.toml`.
    ///
    /// # Errors
    /// For readings that no file could hold.
    pub fn from_table(name: &str, table: ReadingTable) -> Result<Self, Failure> {
        let mut bytes = Vec::new();
        write_readings(&table, &mut bytes)?;
        Ok(Self {
            origin: table.origin.clone(),
            ..Self::bare(name.to_owned(), &bytes, table)
        })
    }

    /// The gauges' resolution and calibration, as far as the session states them; a resolution that it does not is that of its readings.
    ///
    /// # Errors
    /// For a resolution, uncertainty or coverage factor that cannot be.
    pub fn gauges(&self) -> Result<GaugePair, Failure> {
        let instruments = self.header.as_ref().map(|header| &header.instruments);
        let stated = GaugePair {
            force: GaugeTerms::of(instruments.and_then(|i| i.force.as_ref()))?,
            displacement: GaugeTerms::of(instruments.and_then(|i| i.displacement.as_ref()))?,
        };
        Ok(stated.with_steps_of(&self.table.readings))
    }

    /// Stiffness of every pose and direction, with its uncertainty; of several gauges that along the load.
    ///
    /// # Errors
    /// As [`LoadedSession::gauges`].
    pub fn stiffness(&self, branches: Branches) -> Result<StiffnessTable, Failure> {
        let history = self.history()?;
        let drifts = history.map(|history| history.zero_drifts);
        let all = &self.table.readings;
        let is_along = |reading: &Reading| self.table.cell(reading).load.is_none();
        let along: Cow<'_, [Reading]> = if self.table.is_of_one_gauge() {
            all.into()
        } else {
            let along = all.iter().filter(|reading| is_along(reading));
            along.cloned().collect::<Vec<_>>().into()
        };
        Ok(stiffness_table_with_drifts(
            &along,
            &self.gauges()?,
            StiffnessOptions { branches },
            &drifts.unwrap_or_default(),
        ))
    }

    /// Name of its procedure.
    #[must_use]
    pub fn procedure(&self) -> Option<&str> {
        let procedure = self.header.as_ref()?.procedure.as_ref()?;
        procedure.name.as_deref()
    }
}

impl LoadedLoadCases {
    /// Whether a session folder or file holds load cases.
    #[must_use]
    pub fn is_at(path: &Path, options: &OpenSettings) -> bool {
        let file = readings_file(path).ok();
        let bytes = file.and_then(|file| read_bytes(&file).ok());
        bytes.is_some_and(|bytes| match own_names("", &bytes, options) {
            Ok(Some(own)) => !is_vector_table(own.text.as_bytes()),
            Ok(None) => is_load_case_table(&bytes) && !is_vector_table(&bytes),
            // What is wrong with them is stated where they are opened.
            Err(_) => true,
        })
    }

    /// Opens a session folder or a file of load cases.
    ///
    /// # Errors
    /// For data that are not there or cannot be read, and an overdue calibration, as the options have it.
    pub fn open(path: &Path, options: &OpenSettings) -> Result<Self, Failure> {
        let file = readings_file(path)?;
        let folder = folder_of(&file);
        let bytes = read_bytes(&file)?;
        let name = shown(&file);
        let scatter = options.gauges.scatter(&name)?;
        let own = own_names(&name, &bytes, options)?;
        let text = own.as_ref().map_or(&bytes[..], |own| own.text.as_bytes());
        let table = read_load_cases(&name, text)?;
        let mut warnings: Vec<String> = own.into_iter().flat_map(|own| own.notes).collect();
        warnings.extend(table.notes.iter().cloned());
        let header = session_header(&folder, &mut warnings)?;
        let overdue = check_calibration(header.as_ref(), None, options.calibration, &mut warnings)?;
        Ok(Self {
            origin: origin_of(table.origin.as_ref(), header.as_ref()),
            header,
            folder,
            warnings,
            scatter,
            overdue,
            ..Self::bare(shown(path), &bytes, table)
        })
    }

    /// The error of what needs series of loads.
    fn needs_runs(&self, needs: &'static str) -> Failure {
        AnalysisError::NeedsRuns {
            data: self.name.clone(),
            needs,
        }
        .into()
    }
}

/// A table of vectors that is no text under the names of load cases, as that text.
fn own_names(
    name: &str,
    bytes: &[u8],
    options: &OpenSettings,
) -> Result<Option<VectorText>, Failure> {
    Ok(VectorText::read(&[(name, bytes)], &options.columns)?)
}

/// Readings as they were read, with what was assumed.
struct ReadTable {
    table: ReadingTable,
    /// Joint values of poses, of a table of another program.
    poses: Vec<PoseJoints>,
    warnings: Vec<String>,
    is_foreign: bool,
}

impl From<ReadingTable> for ReadTable {
    fn from(table: ReadingTable) -> Self {
        let assumed = table.assumptions.iter();
        let assumed = assumed.map(|assumption| format!("assumed: {assumption}"));
        Self {
            warnings: assumed.collect(),
            poses: Vec::new(),
            is_foreign: false,
            table,
        }
    }
}

/// Whether a table has neither force nor displacement by the names of readings.
fn lacks_both_values(error: &TableError) -> bool {
    let mut values = ["force_N", "displacement_um"].iter();
    values.all(|name| error.missing.iter().any(|missing| missing == name))
}

/// Readings; a table that has no values by their names, or whose columns are stated, as `import` reads it.
fn read_or_imported(
    name: &str,
    bytes: &[u8],
    columns: &ImportMapping,
) -> Result<ReadTable, Failure> {
    let is_stated = *columns != ImportMapping::default();
    let lacking = if is_stated {
        None
    } else {
        match read_readings(name, bytes) {
            Ok(table) => return Ok(table.into()),
            Err(error) if lacks_both_values(&error) => Some(error),
            Err(error) => return Err(error.into()),
        }
    };
    let draft = ImportDraft::read(&[(name, bytes)], None, columns);
    match (draft.and_then(|draft| draft.finish("add")), lacking) {
        (Ok(imported), _) => Ok(ReadTable {
            warnings: imported.notes.texts,
            table: imported.table,
            poses: imported.poses,
            is_foreign: true,
        }),
        // What is no table of another program either lacks the columns of readings.
        (Err(error), Some(lacking)) if error.code != "stiffbench::import::missing" => {
            Err(lacking.into())
        }
        (Err(error), _) => Err(error.into()),
    }
}

/// The day on which readings were taken last, by their RFC 3339 times; `None` if no time begins with a day.
pub(super) fn last_day<'a>(times: impl Iterator<Item = &'a str>) -> Option<Date> {
    times.filter_map(|time| time.get(..10)?.parse().ok()).max()
}

/// Looks for overdue calibrations; warns of them or refuses them.
///
/// # Arguments
/// - `measured`: last day of the measurement, if it is known.
///
/// # Returns
/// The gauges whose calibration is overdue.
pub(super) fn check_calibration(
    header: Option<&SessionHeader>,
    measured: Option<Date>,
    check: CalibrationCheck,
    warnings: &mut Vec<String>,
) -> Result<Vec<OverdueGauge>, Failure> {
    use CalibrationCheck::{Refuse, Warn};
    let (Some(header), Some(today)) = (header, check.day()) else {
        return Ok(Vec::new());
    };
    let overdue = header.instruments.overdue(measured.unwrap_or(today));
    if overdue.is_empty() {
        return Ok(overdue);
    }
    let instruments = gauges_text(&overdue);
    if matches!(check, Refuse(_)) {
        return Err(AnalysisError::CalibrationOverdue { instruments }.into());
    }
    if matches!(check, Warn(_)) {
        warnings.push(format!("calibration overdue: {instruments}"));
    }
    Ok(overdue)
}

/// Gauges whose calibration is overdue, in words.
#[must_use]
pub fn gauges_text(overdue: &[OverdueGauge]) -> String {
    let gauges: Vec<String> = overdue.iter().map(ToString::to_string).collect();
    gauges.join(", ")
}
