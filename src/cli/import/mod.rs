//! `stiffbench import`: a table of another program to a session folder.

mod args;
mod joints;

use std::io::{BufRead, IsTerminal};
use std::path::Path;

use crate::analysis::{
    ArgumentError, Data, Inputs, LoadedSession, OpenSettings, add_poses, doubts_about_stiffness,
    is_dash, read_bytes, robot_source, sha256, shown,
};
use crate::import::{
    ImportDraft, ImportMapping, ImportedQuantity, ImportedReadings, MissingPart, VectorText,
};
use crate::procedure::Procedure;
use crate::quantity::Kind;
use crate::readings::{ImportRecord, PoseJoints, ProcedureRecord, SessionHeader, write_readings};
use crate::report::{ImportReport, columns_document};
use crate::robot::Robot;
use crate::source_text::SourceText;
use crate::stiffness::{Branches, GaugePair, StiffnessOptions, stiffness_table};

use super::figure_files::write;
use super::outcome::print_error;
use super::session::instrument_records;
use super::simulate::create_new;
use super::{CliError, Failure, Global, Outcome};

use joints::take_variables;

pub(super) use args::{ImportArgs, column_pairs};

/// Makes a session folder.
pub(super) fn run(args: &ImportArgs, global: &Global) -> Result<Outcome, Failure> {
    if args.out.exists() {
        // Said before any question.
        create_new(&args.out)?;
    }
    let robot = args.robot.as_ref().map(|name| robot_source(name, None));
    let robot = robot.transpose()?;
    let sources = args.files.iter().map(|path| SourceFile::read(path));
    let sources = sources.collect::<Result<Vec<_>, _>>()?;
    let log = args.displacement_log.as_ref();
    let log = log.map(|path| SourceFile::read(path)).transpose()?;
    if let Some(vectors) = vectors_of(args, &sources, log.is_some())? {
        return import_vectors(args, &vectors, &sources, robot.as_ref());
    }
    let mut of_lines = Vec::new();
    let parsed = robot.as_ref().map(Robot::parse).transpose()?;
    let files = (&sources[..], log.as_ref());
    let draft = draft_of(args, global, files, parsed.as_ref(), &mut of_lines)?;
    let columns = draft.columns();
    let imported = draft.finish(&args.command())?;
    let of_poses = parsed.map(|robot| check_poses(robot, &imported));
    let of_poses = of_poses.transpose()?;
    let record = import_record(&sources);
    let mut readings = Vec::new();
    write_readings(&imported.table, &mut readings)?;
    let made = MadeSession {
        readings,
        mapping: imported.mapping.to_toml(),
        poses: &imported.poses,
        is_of_vectors: false,
    };
    let (mapping_sha256, mut notes) = write_session(
        args,
        &made,
        (&sources, log.as_ref(), &record),
        robot.as_ref(),
    )?;
    let session = LoadedSession::open(&args.out, &OpenSettings::default())?;
    let stiffness = session.stiffness(Branches::LoadingOnly)?;
    notes.extend(of_lines);
    notes.extend(of_poses.unwrap_or_default());
    let warnings = doubts_about_stiffness(&stiffness);
    let in_doubt = !warnings.is_empty() || imported.notes.are_doubtful;
    notes.extend(imported.notes.texts.iter().cloned().chain(warnings));
    let poses = imported.table.poses();
    let report = ImportReport {
        folder: args.out.clone(),
        source: record.source.unwrap_or_default(),
        source_sha256: record.source_sha256.unwrap_or_default(),
        mapping_sha256,
        columns,
        readings: imported.table.readings.len(),
        runs: imported.table.runs.len(),
        poses: poses.iter().map(ToString::to_string).collect(),
        stiffness,
    };
    let inputs = Inputs::default().with_session(&session);
    Ok(Outcome::new("import", report.document(), report)
        .with_inputs(inputs)
        .with_warnings(notes)
        .with_strict_exit(u8::from(in_doubt)))
}

/// Files that hold vectors, under the names of load cases.
fn vectors_of(
    args: &ImportArgs,
    sources: &[SourceFile],
    has_log: bool,
) -> Result<Option<VectorText>, Failure> {
    if has_log || args.gauge_lines.description(Kind::Force)?.is_some() {
        return Ok(None);
    }
    let named = sources.iter().map(|of| (of.shown.as_str(), &of.bytes[..]));
    let named: Vec<(&str, &[u8])> = named.collect();
    Ok(VectorText::read(&named, &args.mapping()?)?)
}

/// Makes a session folder of load cases.
fn import_vectors(
    args: &ImportArgs,
    vectors: &VectorText,
    sources: &[SourceFile],
    robot: Option<&SourceText>,
) -> Result<Outcome, Failure> {
    let record = import_record(sources);
    let lines = vectors.text.lines().filter(|line| !line.is_empty());
    let lines: Vec<&str> = lines.collect();
    let made = MadeSession {
        readings: (lines.join("\n") + "\n").into_bytes(),
        mapping: vectors.mapping.to_toml(),
        poses: &[],
        is_of_vectors: true,
    };
    let (mapping_sha256, mut notes) = write_session(args, &made, (sources, None, &record), robot)?;
    let data = Data::open_readings(&args.out, &OpenSettings::default())?;
    notes.extend(vectors.notes.iter().cloned());
    notes.extend(data.warnings());
    let of_table = match &data {
        Data::LoadCases(all) => all.first().map(|one| {
            let cases = one.table.cases.len();
            (cases, cases, one.table.poses())
        }),
        Data::Readings(all) => all.first().map(|one| {
            let table = &one.table;
            (table.readings.len(), table.runs.len(), table.poses())
        }),
        Data::Stiffness { .. } => None,
    };
    let (readings, runs, poses) = of_table.unwrap_or_default();
    let report = ImportReport {
        folder: args.out.clone(),
        source: record.source.unwrap_or_default(),
        source_sha256: record.source_sha256.unwrap_or_default(),
        mapping_sha256,
        columns: vectors.columns.clone(),
        readings,
        runs,
        poses: poses.iter().map(ToString::to_string).collect(),
        stiffness: stiffness_table(&[], &GaugePair::default(), StiffnessOptions::default()),
    };
    Ok(Outcome::new("import", report.document(), report)
        .with_inputs(Inputs::default().with_data(&data))
        .with_warnings(notes))
}

/// The tables with what their columns were taken for, asked for what is missing.
fn draft_of(
    args: &ImportArgs,
    global: &Global,
    (sources, log): (&[SourceFile], Option<&SourceFile>),
    robot: Option<&Robot>,
    notes: &mut Vec<String>,
) -> Result<ImportDraft, Failure> {
    let mut mapping = args.mapping()?;
    let mut tables = Vec::new();
    for source in sources {
        tables.push(args.table(Kind::Force, source, &mut mapping, notes)?);
    }
    let named = sources.iter().zip(&tables);
    let named: Vec<(&str, &[u8])> = named
        .map(|(of, table)| (of.shown.as_str(), &**table))
        .collect();
    let log = log
        .map(|log| {
            let table = args.table(Kind::Displacement, log, &mut mapping, notes)?;
            Ok::<_, Failure>((log.shown.as_str(), table))
        })
        .transpose()?;
    if let Some(robot) = robot {
        notes.extend(take_variables(&mut mapping, robot, &named)?);
    }
    let log = log.as_ref().map(|(name, table)| (*name, &**table));
    asked(args, global, mapping, |mapping| {
        Ok(ImportDraft::read(&named, log, mapping)?)
    })
}

/// A file as it goes into the folder `raw`.
pub(super) struct SourceFile {
    /// For messages.
    shown: String,
    name: String,
    bytes: Vec<u8>,
}

impl SourceFile {
    fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self {
            shown: shown(path),
            name: file_name(path),
            bytes: read_bytes(path)?,
        })
    }
}

/// Where files stand in the folder, each under a name of its own.
fn places_in_folder(sources: &[SourceFile]) -> Vec<String> {
    let place = |(index, source): (usize, &SourceFile)| {
        let mut before = sources[..index].iter();
        if before.any(|other| other.name == source.name) {
            format!("raw/{}-{}", index + 1, source.name)
        } else {
            format!("raw/{}", source.name)
        }
    };
    sources.iter().enumerate().map(place).collect()
}

/// The files that readings are from, with the hash of one, or of the list of the hashes of several as `sha256sum` prints it.
fn import_record(sources: &[SourceFile]) -> ImportRecord {
    let places = places_in_folder(sources);
    let hash = match sources {
        [one] => sha256(&one.bytes),
        all => {
            let lines = all.iter().zip(&places);
            let lines = lines.map(|(file, place)| format!("{}  {place}\n", sha256(&file.bytes)));
            sha256(lines.collect::<String>())
        }
    };
    ImportRecord {
        source: Some(places.join(", ")),
        source_sha256: Some(hash),
        mapping_sha256: None,
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().filter(|_| !is_dash(path));
    name.map_or_else(
        || "standard-input".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// Refuses joint values that the robot cannot have, and poses that it has with others; returns what a user should know of them.
fn check_poses(
    mut robot: Robot,
    imported: &ImportedReadings,
) -> Result<Vec<String>, ArgumentError> {
    let stated = Procedure {
        name: "of the import".to_owned(),
        joint_values: imported.poses.clone(),
        ..Procedure::default()
    };
    add_poses(&mut robot, &stated)
}

/// Asks at a terminal for what is missing; elsewhere the import then fails with all of it.
fn asked(
    args: &ImportArgs,
    global: &Global,
    mut mapping: ImportMapping,
    read: impl Fn(&ImportMapping) -> Result<ImportDraft, Failure>,
) -> Result<ImportDraft, Failure> {
    let can_ask = !global.no_input
        && !global.json
        && !args.files.iter().any(|file| is_dash(file))
        && std::io::stdin().is_terminal();
    let mut is_shown = false;
    loop {
        let draft = read(&mapping)?;
        let Some(missing) = draft.missing().into_iter().next() else {
            return Ok(draft);
        };
        if !is_shown && !global.json && !global.quiet {
            print_error(&columns_document(&draft.columns()).text());
            is_shown = true;
        }
        if !can_ask {
            return Ok(draft);
        }
        print_error(&format!(
            "Missing: {missing}. Enter it, or nothing to give up:"
        ));
        let mut answer = String::new();
        let read = std::io::stdin().lock().read_line(&mut answer);
        let answer = answer.trim();
        if read.is_err() || answer.is_empty() {
            return Ok(draft);
        }
        answered(&mut mapping, &missing, answer);
    }
}

fn answered(mapping: &mut ImportMapping, missing: &MissingPart, answer: &str) {
    let answer = Some(answer.to_owned());
    match missing {
        MissingPart::Column { quantity, .. } => match quantity {
            ImportedQuantity::Force => mapping.columns.force = answer,
            ImportedQuantity::Displacement => mapping.columns.displacement = answer,
        },
        MissingPart::Unit { quantity, .. } => match quantity {
            ImportedQuantity::Force => mapping.units.force = answer,
            ImportedQuantity::Displacement => mapping.units.displacement = answer,
        },
        MissingPart::JointUnit { .. } => mapping.units.joint = answer,
        MissingPart::Direction => mapping.direction = answer,
    }
}

/// What stands in the folder of an import beside its source.
struct MadeSession<'a> {
    readings: Vec<u8>,
    mapping: String,
    poses: &'a [PoseJoints],
    is_of_vectors: bool,
}

/// Writes the folder; returns the hash of the mapping and what a user should know.
fn write_session(
    args: &ImportArgs,
    made: &MadeSession<'_>,
    (sources, log, record): (&[SourceFile], Option<&SourceFile>, &ImportRecord),
    robot: Option<&SourceText>,
) -> Result<(String, Vec<String>), Failure> {
    let mapping = &made.mapping;
    let (instruments, notes) = instrument_records(args.instrument_records.as_deref())?;
    let procedure = (!made.poses.is_empty()).then(|| ProcedureRecord {
        joint_values: made.poses.to_vec(),
        ..ProcedureRecord::default()
    });
    let header = SessionHeader {
        id: Some(file_name(&args.out)),
        robot: robot.map(|_| "robot.toml".to_owned()),
        robot_sha256: robot.map(|robot| sha256(&robot.text)),
        software: Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned()),
        procedure,
        instruments,
        import: Some(ImportRecord {
            mapping_sha256: Some(sha256(mapping)),
            ..record.clone()
        }),
        ..SessionHeader::default()
    };
    let header = if made.is_of_vectors {
        header.to_load_case_toml()
    } else {
        header.to_toml()
    };
    create_new(&args.out)?;
    let files = || -> Result<(), CliError> {
        for (source, place) in sources.iter().zip(places_in_folder(sources)) {
            write(&args.out.join(place), &source.bytes)?;
        }
        if let Some(log) = log {
            let same = sources.iter().any(|source| source.name == log.name);
            let before = if same { "displacement-" } else { "" };
            let place = args.out.join(format!("raw/{before}{}", log.name));
            write(&place, &log.bytes)?;
        }
        if let Some(robot) = robot {
            write(&args.out.join("robot.toml"), robot.text.as_bytes())?;
        }
        write(&args.out.join("mapping.toml"), mapping.as_bytes())?;
        write(&args.out.join("session.toml"), header.as_bytes())?;
        write(&args.out.join("readings.csv"), &made.readings)
    };
    if let Err(error) = files() {
        // The folder is new: what is in it came from here.
        let _ = std::fs::remove_dir_all(&args.out);
        return Err(error.into());
    }
    Ok((sha256(mapping), notes))
}
