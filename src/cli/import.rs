//! `stiffbench import`: a table of another program to a session folder.

use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::analysis::{
    ArgumentError, Inputs, LoadedSession, OpenSettings, add_poses, doubts_about_stiffness, is_dash,
    read_bytes, read_text, robot_source, sha256, shown,
};
use crate::import::{
    FlippedSign, ImportDraft, ImportMapping, ImportedReadings, MarkWord, MissingPart,
};
use crate::procedure::Procedure;
use crate::readings::{ImportRecord, ProcedureRecord, SessionHeader, write_readings};
use crate::report::{ImportReport, columns_text};
use crate::robot::Robot;
use crate::source_text::SourceText;
use crate::stiffness::Branches;

use super::args::Global;
use super::failure::Failure;
use super::figure_files::write;
use super::outcome::{Outcome, print_error};
use super::session::instrument_records;
use super::simulate::create_new;

/// Arguments of `import`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench import messung.csv --out messung --direction y\n  stiffbench import log.lvm --out log --map force=Channel_1,displacement=Channel_2 --units N,mm --pose P1 --direction y\n  stiffbench import tuesday.csv --out tuesday --mapping monday/mapping.toml\n  stiffbench import force.log --displacement-log travel.log --out logs --direction z"
)]
pub(super) struct ImportArgs {
    /// Table of any program: CSV, TSV, LabVIEW, XLSX, exports of testing machines, logs of gauges
    file: PathBuf,
    /// Session folder to make
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// What columns hold, WHAT=COLUMN,...: force, displacement, pose, direction, repeat, branch, time, temperature, joint.NAME; a column by its name or number
    #[arg(long, value_name = "WHAT=COLUMN")]
    map: Vec<String>,
    /// Mapping of an earlier import, mapping.toml in its folder; the other options go before it
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,
    /// Pose of all rows, where no column names it
    #[arg(long)]
    pose: Option<String>,
    /// Direction of all rows: x, y, z, or -x for loads that count along the negative axis
    #[arg(long, allow_hyphen_values = true)]
    direction: Option<String>,
    /// Units of force and displacement, for example kgf,mm
    #[arg(long, value_name = "FORCE,DISPLACEMENT")]
    units: Option<String>,
    /// Unit of the force, where the file states none or a wrong one
    #[arg(long, value_name = "UNIT")]
    force_unit: Option<String>,
    /// Unit of the displacement, where the file states none or a wrong one
    #[arg(long, value_name = "UNIT")]
    displacement_unit: Option<String>,
    /// Unit of the time [default: that of the file, else s]
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<String>,
    /// Unit of joint values: deg or rad [default: that of the file]
    #[arg(long, value_name = "UNIT")]
    joint_unit: Option<String>,
    /// Turn the sign of every force or displacement
    #[arg(long, value_enum)]
    flip: Vec<FlipChoice>,
    /// Decimal sign of the numbers [default: found from all of them]
    #[arg(long, value_enum)]
    decimal: Option<DecimalMark>,
    /// Mark between thousands; none: a mark with three digits behind it is the decimal sign
    #[arg(long, value_enum)]
    thousands: Option<ThousandsMark>,
    /// Sheet of a spreadsheet [default: the only one with rows of numbers]
    #[arg(long, value_name = "NAME")]
    sheet: Option<String>,
    /// Log of the displacement gauge, paired by time with FILE, the log of the force gauge
    #[arg(long, value_name = "FILE")]
    displacement_log: Option<PathBuf>,
    /// Name of a shipped robot, or a robot file: it goes into the session, and columns named like its variables hold joint values
    #[arg(long, value_name = "NAME|FILE")]
    robot: Option<String>,
    /// Records of the gauges in the form of session.toml
    #[arg(long, value_name = "FILE")]
    instrument_records: Option<PathBuf>,
    /// Never wait for an answer
    #[arg(long)]
    no_input: bool,
}

/// A quantity whose sign is turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FlipChoice {
    /// Every force
    Force,
    /// Every displacement
    Displacement,
}

/// The decimal sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DecimalMark {
    /// 1.5
    Point,
    /// 1,5
    Comma,
}

/// The mark between thousands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ThousandsMark {
    /// 1.000,5
    Point,
    /// 1,000.5
    Comma,
    /// 1.000 is one
    None,
}

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
    let mut mapping = args.mapping()?;
    if let Some(robot) = &robot {
        take_variables(&mut mapping, &Robot::parse(robot)?, &args.file, &bytes)?;
    }
    let name = shown(&args.file);
    let log_bytes = log
        .as_ref()
        .map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    let draft = asked(args, global, mapping, |mapping| {
        Ok(ImportDraft::read(&name, &bytes, log_bytes, mapping)?)
    })?;
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
    notes.extend(of_poses.unwrap_or_default());
    let of_import = imported.notes.iter().map(ToString::to_string);
    notes.extend(of_import.chain(doubts_about_stiffness(&stiffness)));
    let report = ImportReport {
        folder: args.out.clone(),
        source: name,
        source_sha256: sha256(&bytes),
        mapping_sha256,
        columns,
        readings: imported.table.readings.len(),
        runs: imported.table.runs.len(),
        poses: poses(&imported),
        stiffness,
    };
    let inputs = Inputs::default().with_session(&session);
    Ok(Outcome::new("import", report.text(), report)
        .with_inputs(inputs)
        .with_warnings(notes))
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

impl ImportArgs {
    /// The command without what is missing, for messages.
    fn command(&self) -> String {
        format!(
            "stiffbench import {} --out {}",
            self.file.display(),
            self.out.display()
        )
    }

    /// What the options state of the columns, over the mapping that they name.
    fn mapping(&self) -> Result<ImportMapping, Failure> {
        let mut mapping = match &self.mapping {
            Some(path) => ImportMapping::from_toml(&path.display().to_string(), &read_text(path)?)?,
            None => ImportMapping::default(),
        };
        for (role, column) in pairs(&self.map)? {
            mapping.set(&role, &column)?;
        }
        if let Some(units) = &self.units {
            let (force, displacement) = units.split_once(',').ok_or_else(|| {
                ArgumentError::new(
                    format!("--units {units}"),
                    "two units with a comma between them are needed",
                    "--units kgf,mm",
                )
            })?;
            mapping.units.force = Some(force.trim().to_owned());
            mapping.units.displacement = Some(displacement.trim().to_owned());
        }
        let units = &mut mapping.units;
        for (stated, unit) in [
            (&self.force_unit, &mut units.force),
            (&self.displacement_unit, &mut units.displacement),
            (&self.time_unit, &mut units.time),
            (&self.joint_unit, &mut units.joint),
            (&self.pose, &mut mapping.pose),
            (&self.direction, &mut mapping.direction),
            (&self.sheet, &mut mapping.sheet),
        ] {
            if stated.is_some() {
                unit.clone_from(stated);
            }
        }
        if !self.flip.is_empty() {
            mapping.flip = self.flip.iter().map(|flip| flip.word()).collect();
        }
        mapping.decimal = self.decimal.map(DecimalMark::word).or(mapping.decimal);
        mapping.thousands = self
            .thousands
            .map(ThousandsMark::word)
            .or(mapping.thousands);
        Ok(mapping)
    }
}

impl FlipChoice {
    fn word(self) -> FlippedSign {
        match self {
            Self::Force => FlippedSign::Force,
            Self::Displacement => FlippedSign::Displacement,
        }
    }
}

impl DecimalMark {
    fn word(self) -> MarkWord {
        match self {
            Self::Point => MarkWord::Point,
            Self::Comma => MarkWord::Comma,
        }
    }
}

impl ThousandsMark {
    fn word(self) -> MarkWord {
        match self {
            Self::Point => MarkWord::Point,
            Self::Comma => MarkWord::Comma,
            Self::None => MarkWord::None,
        }
    }
}

/// `force=Kraft,displacement=Weg, mm`: a part without an equals sign belongs to the name before it.
fn pairs(map: &[String]) -> Result<Vec<(String, String)>, ArgumentError> {
    let mut pairs: Vec<(String, String)> = Vec::new();
    for text in map {
        let mut is_first = true;
        for part in text.split(',') {
            match (part.split_once('='), pairs.last_mut()) {
                (Some((role, column)), _) => {
                    pairs.push((role.trim().to_owned(), column.to_owned()));
                }
                (None, Some((_, column))) if !is_first => {
                    column.push(',');
                    column.push_str(part);
                }
                (None, _) => {
                    return Err(ArgumentError::new(
                        format!("--map {text}"),
                        "an equals sign between what it is and the column is needed",
                        "--map force=Kraft,displacement=Weg",
                    ));
                }
            }
            is_first = false;
        }
    }
    Ok(pairs)
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

/// Columns that are named like variables of the robot hold joint values.
fn take_variables(
    mapping: &mut ImportMapping,
    robot: &Robot,
    file: &Path,
    bytes: &[u8],
) -> Result<(), Failure> {
    let name = shown(file);
    let draft = ImportDraft::read(&name, bytes, None, mapping)?;
    let columns = draft.columns();
    for variable in &robot.variables {
        let variable = variable.name.as_str();
        let is_it = |name: &str| {
            let stem = name.split([' ', '[', '(']).next().unwrap_or(name);
            stem.eq_ignore_ascii_case(variable)
        };
        let mut alike = columns.iter().filter(|column| is_it(&column.name));
        if let (Some(column), None) = (alike.next(), mapping.joints.get(variable)) {
            mapping
                .joints
                .insert(variable.to_owned(), column.name.clone());
        }
    }
    Ok(())
}

/// Asks at a terminal for what is missing; elsewhere the import then fails with all of it.
fn asked(
    args: &ImportArgs,
    global: &Global,
    mut mapping: ImportMapping,
    read: impl Fn(&ImportMapping) -> Result<ImportDraft, Failure>,
) -> Result<ImportDraft, Failure> {
    let can_ask =
        !args.no_input && !global.json && !is_dash(&args.file) && std::io::stdin().is_terminal();
    let mut is_shown = false;
    loop {
        let draft = read(&mapping)?;
        let Some(missing) = draft.missing().into_iter().next() else {
            return Ok(draft);
        };
        if !is_shown && !global.json && !global.quiet {
            print_error(&columns_text(&draft.columns()));
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
        MissingPart::ForceColumn { .. } => mapping.columns.force = answer,
        MissingPart::DisplacementColumn { .. } => mapping.columns.displacement = answer,
        MissingPart::ForceUnit { .. } => mapping.units.force = answer,
        MissingPart::DisplacementUnit { .. } => mapping.units.displacement = answer,
        MissingPart::JointUnit { .. } => mapping.units.joint = answer,
        MissingPart::Direction => mapping.direction = answer,
    }
}

fn poses(imported: &ImportedReadings) -> Vec<String> {
    let mut poses: Vec<String> = Vec::new();
    for reading in &imported.table.readings {
        let pose = reading.pose.to_string();
        if !poses.contains(&pose) {
            poses.push(pose);
        }
    }
    poses
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
    write(&args.out.join("readings.csv"), &readings)?;
    Ok((sha256(&mapping), notes))
}
