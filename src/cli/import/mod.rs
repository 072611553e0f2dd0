//! `stiffbench import`: a table of another program to a session folder.

mod args;
mod joints;

use std::io::{BufRead, IsTerminal};
use std::path::Path;

use crate::analysis::{
    Inputs, LoadedSession, OpenSettings, add_poses, doubts_about_stiffness, is_dash, read_bytes,
    robot_source, sha256, shown,
};
use crate::import::{
    ImportDraft, ImportMapping, ImportNote, ImportedQuantity, ImportedReadings, MissingPart,
};
use crate::procedure::Procedure;
use crate::quantity::Kind;
use crate::readings::{ImportRecord, ProcedureRecord, SessionHeader, write_readings};
use crate::report::{ImportReport, columns_document};
use crate::robot::Robot;
use crate::source_text::SourceText;
use crate::stiffness::Branches;

use super::args::Global;
use super::failure::{CliError, Failure};
use super::figure_files::write;
use super::outcome::{Outcome, print_error};
use super::session::instrument_records;
use super::simulate::create_new;

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
    let bytes = read_bytes(&args.file)?;
    let log = args.displacement_log.as_ref();
    let log = log.map(|path| Ok::<_, Failure>((path.display().to_string(), read_bytes(path)?)));
    let log = log.transpose()?;
    let mut of_lines = Vec::new();
    let parsed = robot.as_ref().map(Robot::parse).transpose()?;
    let log_file = log
        .as_ref()
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    let draft = draft_of(
        args,
        global,
        &bytes,
        log_file,
        parsed.as_ref(),
        &mut of_lines,
    )?;
    let columns = draft.columns();
    let imported = draft.finish(&args.command())?;
    let of_poses = robot
        .as_ref()
        .map(|robot| check_poses(robot, &imported))
        .transpose()?;
    let source = SourceFile {
        name: file_name(&args.file),
        bytes: &bytes,
    };
    let log = log.as_ref().map(|(name, bytes)| SourceFile {
        name: file_name(Path::new(name)),
        bytes,
    });
    let (mapping_sha256, mut notes) =
        write_session(args, &imported, &source, log.as_ref(), robot.as_ref())?;
    let session = LoadedSession::open(&args.out, &OpenSettings::default())?;
    let stiffness = session.stiffness(Branches::LoadingOnly)?;
    notes.extend(of_lines);
    notes.extend(of_poses.unwrap_or_default());
    let warnings = doubts_about_stiffness(&stiffness);
    let in_doubt = !warnings.is_empty() || imported.notes.iter().any(ImportNote::is_doubt);
    let of_import = imported.notes.iter().map(ToString::to_string);
    notes.extend(of_import.chain(warnings));
    let poses = imported.table.poses();
    let report = ImportReport {
        folder: args.out.clone(),
        source: shown(&args.file),
        source_sha256: sha256(&bytes),
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

/// The tables with what their columns were taken for, asked for what is missing.
fn draft_of(
    args: &ImportArgs,
    global: &Global,
    bytes: &[u8],
    log: Option<(&str, &[u8])>,
    robot: Option<&Robot>,
    notes: &mut Vec<String>,
) -> Result<ImportDraft, Failure> {
    let name = shown(&args.file);
    let mut mapping = args.mapping()?;
    let table = args.table(Kind::Force, &name, bytes, &mut mapping, notes)?;
    let log = log
        .map(|(name, bytes)| {
            let table = args.table(Kind::Displacement, name, bytes, &mut mapping, notes)?;
            Ok::<_, Failure>((name, table))
        })
        .transpose()?;
    if let Some(robot) = robot {
        notes.extend(take_variables(&mut mapping, robot, &name, &table)?);
    }
    let log = log.as_ref().map(|(name, table)| (*name, &**table));
    asked(args, global, mapping, |mapping| {
        Ok(ImportDraft::read(&name, &table, log, mapping)?)
    })
}

/// A file as it goes into the folder `raw`.
struct SourceFile<'a> {
    name: String,
    bytes: &'a [u8],
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().filter(|_| !is_dash(path));
    name.map_or_else(
        || "standard-input".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// Refuses joint values that the robot cannot have, and poses that it has with others; returns what a user should know of them.
fn check_poses(robot: &SourceText, imported: &ImportedReadings) -> Result<Vec<String>, Failure> {
    let stated = Procedure {
        name: "of the import".to_owned(),
        joint_values: imported.poses.clone(),
        ..Procedure::default()
    };
    Ok(add_poses(&mut Robot::parse(robot)?, &stated)?)
}

/// Asks at a terminal for what is missing; elsewhere the import then fails with all of it.
fn asked(
    args: &ImportArgs,
    global: &Global,
    mut mapping: ImportMapping,
    read: impl Fn(&ImportMapping) -> Result<ImportDraft, Failure>,
) -> Result<ImportDraft, Failure> {
    let can_ask =
        !global.no_input && !global.json && !is_dash(&args.file) && std::io::stdin().is_terminal();
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

/// Writes the folder; returns the hash of the mapping and what a user should know.
fn write_session(
    args: &ImportArgs,
    imported: &ImportedReadings,
    source: &SourceFile<'_>,
    log: Option<&SourceFile<'_>>,
    robot: Option<&SourceText>,
) -> Result<(String, Vec<String>), Failure> {
    let mapping = imported.mapping.to_toml();
    let (instruments, notes) = instrument_records(args.instrument_records.as_deref())?;
    let procedure = (!imported.poses.is_empty()).then(|| ProcedureRecord {
        joint_values: imported.poses.clone(),
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
            source: Some(format!("raw/{}", source.name)),
            source_sha256: Some(sha256(source.bytes)),
            mapping_sha256: Some(sha256(&mapping)),
        }),
        ..SessionHeader::default()
    };
    let mut readings = Vec::new();
    write_readings(&imported.table, &mut readings)?;
    create_new(&args.out)?;
    let files = || -> Result<(), CliError> {
        let raw = args.out.join("raw");
        write(&raw.join(&source.name), source.bytes)?;
        if let Some(log) = log {
            let same = log.name == source.name;
            let name = if same {
                format!("displacement-{}", log.name)
            } else {
                log.name.clone()
            };
            write(&raw.join(name), log.bytes)?;
        }
        if let Some(robot) = robot {
            write(&args.out.join("robot.toml"), robot.text.as_bytes())?;
        }
        write(&args.out.join("mapping.toml"), mapping.as_bytes())?;
        write(&args.out.join("session.toml"), header.to_toml().as_bytes())?;
        write(&args.out.join("readings.csv"), &readings)
    };
    if let Err(error) = files() {
        // The folder is new: what is in it came from here.
        let _ = std::fs::remove_dir_all(&args.out);
        return Err(error.into());
    }
    Ok((sha256(&mapping), notes))
}
