//! From what the user names to data, robot, mechanism and factors.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::fit::{MeasuredStiffness, is_stiffness_list, read_stiffness_list};
use crate::nearest::nearest;
use crate::readings::{
    GaugeLogOptions, InstrumentRecord, LoadSign, ReadOptions, ReadingTable, SessionHeader,
    read_gauge_log, read_readings,
};
use crate::stiffness::{
    Branches, GaugeTerms, Gauges, StiffnessOptions, StiffnessTable, stiffness_table,
};
use crate::test_point::PoseId;

use super::args::{Global, LogArgs};
use super::failure::{CliError, Failure};
use super::hash::sha256;
use super::integrity::compare_with_journal;

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

/// Readings with the session they belong to.
#[derive(Debug)]
pub struct Session {
    /// What the user called it.
    pub(super) name: String,
    /// SHA-256 of the file, in hexadecimal.
    pub(super) sha256: String,
    /// The readings.
    pub(super) table: ReadingTable,
    /// `session.toml` beside them, if there is one.
    pub(super) header: Option<SessionHeader>,
    /// Folder of `session.toml`.
    pub(super) folder: PathBuf,
    /// What was assumed, and what a user should know.
    pub(super) warnings: Vec<String>,
}

/// Data to fit.
#[derive(Debug)]
pub(super) enum Data {
    /// Readings.
    Readings(Box<Session>),
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

/// Reads a session folder, a readings file, a list of stiffness values or a shipped list.
pub(super) fn load(path: &Path, global: &Global) -> Result<Data, Failure> {
    if let Some((name, text)) = shipped_list(path) {
        return Ok(Data::Stiffness {
            name: name.to_owned(),
            sha256: sha256(text),
            measured: read_stiffness_list(name, text)?,
        });
    }
    if path.is_file() && is_stiffness_list(&first_line(path)?) {
        let name = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|source| CliError::Read {
            path: path.to_owned(),
            source,
        })?;
        return Ok(Data::Stiffness {
            measured: read_stiffness_list(&name, &text)?,
            sha256: sha256(&text),
            name,
        });
    }
    Ok(Data::Readings(Box::new(load_session(
        path,
        &LogArgs::default(),
        global,
    )?)))
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
fn readings_file(path: &Path) -> Result<PathBuf, CliError> {
    if path.is_dir() {
        let file = path.join("readings.csv");
        if file.is_file() {
            return Ok(file);
        }
        let path = path.to_owned();
        return Err(CliError::NoSession { path });
    }
    if path.exists() {
        return Ok(path.to_owned());
    }
    let shipped = SHIPPED_LISTS.map(|(name, _)| name);
    let help = match nearest(&path.to_string_lossy(), shipped) {
        Some(near) => format!("did you mean {near}, which comes with the program?"),
        None => "name a session folder or a readings file; paths start in the folder you are in"
            .to_owned(),
    };
    Err(CliError::NotFound {
        path: path.to_owned(),
        help,
    })
}

/// Reads a list of stiffness values or reduces readings to one.
pub(super) fn load_measured(path: &Path, global: &Global) -> Result<MeasuredStiffness, Failure> {
    Ok(match load(path, global)? {
        Data::Stiffness { measured, .. } => measured,
        Data::Readings(session) => {
            let table = session.stiffness(Branches::LoadingOnly)?;
            MeasuredStiffness::from_table(&table, crate::stiffness::Method::Regression)
        }
    })
}

/// Reads a session folder, a readings file, or a gauge's own log.
pub(super) fn load_session(
    path: &Path,
    log: &LogArgs,
    global: &Global,
) -> Result<Session, Failure> {
    // Displacements without repeats, which also can be a list, may be readings that lack the column.
    let is_list = path.is_file() && first_line(path)?.contains("stiffness_N_per_um");
    if shipped_list(path).is_some() || is_list {
        return Err(CliError::NeedsReadings {
            data: path.display().to_string(),
            needs: "this subcommand",
        }
        .into());
    }
    let file = readings_file(path)?;
    let folder = file.parent().map(Path::to_owned).unwrap_or_default();
    let name = file.display().to_string();
    let bytes = fs::read(&file).map_err(|source| CliError::Read {
        path: file.clone(),
        source,
    })?;
    let options = ReadOptions::default();
    let table = match (&log.pose, log.direction) {
        (Some(pose), Some(direction)) => {
            let options = GaugeLogOptions {
                pose: PoseId::new(pose),
                direction,
                repeat: log.repeat,
                sign: if log.positive {
                    LoadSign::Positive
                } else {
                    LoadSign::Negative
                },
                text: options,
            };
            read_gauge_log(&name, bytes.as_slice(), &options)?
        }
        (None, None) => read_readings(&name, bytes.as_slice(), &options)?,
        _ => {
            return Err(CliError::Argument {
                argument: "--pose and --direction".to_owned(),
                problem: "a gauge's own log needs both".to_owned(),
                help: Some("stiffbench stiffness LOG --pose P1 --direction x".to_owned()),
            }
            .into());
        }
    };
    let mut warnings: Vec<String> = table
        .assumptions
        .iter()
        .map(|assumption| format!("assumed: {assumption}"))
        .collect();
    warnings.extend(table.notes.iter().map(ToString::to_string));
    let header = session_header(&folder, &mut warnings)?;
    if file.file_name().is_some_and(|name| name == "readings.csv") && log.pose.is_none() {
        compare_with_journal(&folder, &table, header.as_ref())?.judge(
            &file,
            global.trust_csv,
            &mut warnings,
        )?;
    }
    let mut session = Session {
        name: path.display().to_string(),
        sha256: sha256(&bytes),
        table,
        header,
        folder,
        warnings,
    };
    let read_off = session.gauges()?;
    session.warnings.extend(read_off.read_off());
    session.check_calibration(global)
}

/// `session.toml` in a folder, if there is one.
fn session_header(
    folder: &Path,
    warnings: &mut Vec<String>,
) -> Result<Option<SessionHeader>, Failure> {
    let path = folder.join("session.toml");
    if !path.is_file() {
        return Ok(None);
    }
    let text = fs::read_to_string(&path).map_err(|source| CliError::Read {
        path: path.clone(),
        source,
    })?;
    let name = path.display().to_string();
    let read = SessionHeader::from_toml(&name, &text)?;
    warnings.extend(read.unknown_keys.iter().map(|key| key.warning(&name)));
    Ok(Some(read.header))
}

/// The first line of a file, for telling its form.
fn first_line(path: &Path) -> Result<String, CliError> {
    let mut head = [0; 512];
    let read = fs::File::open(path)
        .and_then(|mut file| file.read(&mut head))
        .map_err(|source| CliError::Read {
            path: path.to_owned(),
            source,
        })?;
    let text = String::from_utf8_lossy(&head[..read]);
    Ok(text
        .trim_start_matches('\u{feff}')
        .lines()
        .next()
        .unwrap_or("")
        .to_owned())
}

impl Session {
    /// The gauges' resolution and calibration, as far as the session states them; a resolution that it does not is that of its readings.
    pub(super) fn gauges(&self) -> Result<Gauges, Failure> {
        let instruments = self.header.as_ref().map(|header| &header.instruments);
        let terms = |record: Option<&InstrumentRecord>| match record {
            Some(record) => {
                GaugeTerms::new(record.resolution, record.expanded_uncertainty, record.k)
            }
            None => Ok(GaugeTerms::not_stated()),
        };
        let stated = Gauges {
            force: terms(instruments.and_then(|i| i.force.as_ref()))?,
            displacement: terms(instruments.and_then(|i| i.displacement.as_ref()))?,
        };
        Ok(stated.with_steps_of(&self.table.readings))
    }

    /// How the readings came about if nobody measured them.
    pub(super) fn origin(&self) -> Option<String> {
        let header = self
            .header
            .as_ref()
            .and_then(|header| header.origin.clone());
        self.table.origin.clone().or(header)
    }

    /// Stiffness of every cell.
    pub(super) fn stiffness(&self, branches: Branches) -> Result<StiffnessTable, Failure> {
        Ok(stiffness_table(
            &self.table.readings,
            &self.gauges()?,
            StiffnessOptions { branches },
        ))
    }

    /// Warns of overdue calibration, or refuses under `--strict`.
    fn check_calibration(mut self, global: &Global) -> Result<Self, Failure> {
        let today = jiff::Timestamp::now()
            .to_zoned(jiff::tz::TimeZone::UTC)
            .date();
        let instruments = self.header.as_ref().map(|header| &header.instruments);
        let records = instruments.map(|i| {
            [
                ("force gauge", &i.force),
                ("displacement gauge", &i.displacement),
            ]
        });
        let overdue: Vec<String> = records
            .into_iter()
            .flatten()
            .filter_map(|(what, record)| record.as_ref().map(|record| (what, record)))
            .filter(|(_, record)| record.calibration_overdue(today) == Some(true))
            .map(|(what, record)| {
                format!(
                    "{what} (due {})",
                    record.due.map_or_else(String::new, |due| due.to_string())
                )
            })
            .collect();
        if overdue.is_empty() {
            return Ok(self);
        }
        let instruments = overdue.join(", ");
        if global.strict {
            return Err(CliError::CalibrationOverdue { instruments }.into());
        }
        self.warnings
            .push(format!("calibration overdue: {instruments}"));
        Ok(self)
    }
}
