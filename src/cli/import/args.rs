//! The arguments of `import`.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::SourceFile;
use crate::analysis::{ArgumentError, read_text};
use crate::cli::failure::Failure;
use crate::cli::gauge::lines::{GaugeLineArgs, table_of};
use crate::cli::option_values::{ENCODINGS, OptionValue, decimal_signs, one_of, word_of};
use crate::cli::outcome::shell_word;
use crate::import::{ImportMapping, ImportedQuantity, MarkWord};
use crate::quantity::Kind;
use crate::table_files::{FieldDelimiter, TextEncoding};

/// Arguments of `import`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench import messung.csv --out messung --direction y\n  stiffbench import log.lvm --out log --map force=Channel_1,displacement=Channel_2 --units N,mm --pose P1 --direction y\n  stiffbench import tuesday.csv --out tuesday --mapping monday/mapping.toml\n  stiffbench import force.log --displacement-log travel.log --out logs --direction z\n  stiffbench import force.txt --instrument mark10-series5 --displacement-log travel.csv --out raw-logs --direction z"
)]
pub(in crate::cli) struct ImportArgs {
    /// Table of any program: CSV, TSV, LabVIEW, XLSX, export of a testing machine, gauge log; several files with the same columns are repeats
    #[arg(value_name = "FILE", required = true)]
    pub(super) files: Vec<PathBuf>,
    /// Session folder to create
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: PathBuf,
    /// Assign columns to quantities, WHAT=COLUMN,...: force, displacement, pose, direction, repeat, branch, time, temperature, joint.NAME; give a column by name or number, and each repeat's displacement if they stand side by side
    #[arg(long, value_name = "WHAT=COLUMN")]
    pub(super) map: Vec<String>,
    /// Mapping of an earlier import, mapping.toml in its folder; the other options override it
    #[arg(long, value_name = "FILE")]
    pub(super) mapping: Option<PathBuf>,
    /// Pose of all rows, if no column states it
    #[arg(long)]
    pub(super) pose: Option<String>,
    /// Direction of all rows: x, y, z, or -x for loads counted along the negative axis
    #[arg(long, allow_hyphen_values = true)]
    pub(super) direction: Option<String>,
    /// Units of force and displacement, for example kgf,mm
    #[arg(long, value_name = "FORCE,DISPLACEMENT")]
    pub(super) units: Option<String>,
    /// Unit of the force, if the file states none or a wrong one
    #[arg(long, value_name = "UNIT")]
    pub(super) force_unit: Option<String>,
    /// Unit of the displacement, if the file states none or a wrong one
    #[arg(long, value_name = "UNIT")]
    pub(super) displacement_unit: Option<String>,
    /// Unit of the time [default: that of the file, else s]
    #[arg(long, value_name = "UNIT")]
    pub(super) time_unit: Option<String>,
    /// Unit of joint values: deg or rad [default: that of the file]
    #[arg(long, value_name = "UNIT")]
    pub(super) joint_unit: Option<String>,
    /// Reverse the sign of every force or displacement
    #[arg(long, value_parser = one_of(FLIPS))]
    flip: Vec<ImportedQuantity>,
    /// Field delimiter: tab, ;, comma or blanks [default: detected from all lines]
    #[arg(long, value_parser = one_of(DELIMITERS))]
    delimiter: Option<FieldDelimiter>,
    /// Decimal sign of the numbers [default: detected from all of them]
    #[arg(long, value_parser = one_of(decimals()))]
    decimal: Option<MarkWord>,
    /// Thousands separator; none: a mark followed by three digits is the decimal sign
    #[arg(long, value_parser = one_of(THOUSANDS))]
    thousands: Option<MarkWord>,
    /// Encoding of the text [default: detected from its words]
    #[arg(long, value_parser = one_of(ENCODINGS))]
    encoding: Option<TextEncoding>,
    /// Sheet of a spreadsheet [default: all with rows of numbers under the same names]
    #[arg(long, value_name = "NAME")]
    pub(super) sheet: Option<String>,
    /// Log of the displacement gauge, paired by time with FILE, the log of the force gauge
    #[arg(long, value_name = "FILE")]
    pub(super) displacement_log: Option<PathBuf>,
    /// Lines as gauges send them.
    #[command(flatten)]
    pub(super) gauge_lines: GaugeLineArgs,
    /// Name of a shipped robot, or a robot file: it is copied into the session, and columns named like its variables hold joint values
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) robot: Option<String>,
    /// Records of the gauges in the form of session.toml
    #[arg(long, value_name = "FILE")]
    pub(super) instrument_records: Option<PathBuf>,
}

/// A quantity whose sign is turned.
const FLIPS: [OptionValue<ImportedQuantity>; 2] = [
    ("force", "Every force", ImportedQuantity::Force),
    (
        "displacement",
        "Every displacement",
        ImportedQuantity::Displacement,
    ),
];

/// What delimits fields.
const DELIMITERS: [OptionValue<FieldDelimiter>; 4] = [
    ("tab", "A tab", FieldDelimiter::Tab),
    ("semicolon|;", ";", FieldDelimiter::Semicolon),
    ("comma|,", ",", FieldDelimiter::Comma),
    (
        "blanks",
        "One or more blanks or tabs",
        FieldDelimiter::Blanks,
    ),
];

/// The decimal sign.
fn decimals() -> [OptionValue<MarkWord>; 2] {
    decimal_signs(MarkWord::Point, MarkWord::Comma)
}

/// The mark between thousands.
const THOUSANDS: [OptionValue<MarkWord>; 3] = [
    ("point", "1.000,5", MarkWord::Point),
    ("comma", "1,000.5", MarkWord::Comma),
    ("none", "1.000 is 1", MarkWord::None),
];

impl ImportArgs {
    /// A file as a table: as it is, or decoded by the description of its gauge.
    pub(super) fn table<'b>(
        &self,
        kind: Kind,
        file: &'b SourceFile,
        mapping: &mut ImportMapping,
        notes: &mut Vec<String>,
    ) -> Result<Cow<'b, [u8]>, Failure> {
        let Some(description) = self.gauge_lines.description(kind)? else {
            return Ok(Cow::Borrowed(&file.bytes));
        };
        let units = &mapping.units;
        let unit = match kind {
            Kind::Force => units.force.as_deref(),
            _ => units.displacement.as_deref(),
        };
        let table = table_of(&file.shown, &file.bytes, &description, unit)?;
        notes.extend(table.note);
        // Decoded values have points.
        mapping.decimal.get_or_insert(MarkWord::Point);
        Ok(Cow::Owned(table.bytes))
    }

    /// The command without what is missing, for messages.
    pub(super) fn command(&self) -> String {
        let path = |path: &Path| shell_word(&path.display().to_string());
        let files: Vec<String> = self.files.iter().map(|file| path(file)).collect();
        let (files, out) = (files.join(" "), path(&self.out));
        let mut command = format!("stiffbench import {files} --out {out}");
        let mut add = |option: &str, value: Option<String>| {
            if let Some(value) = value {
                let _ = write!(command, " --{option} {value}");
            }
        };
        for map in &self.map {
            add("map", Some(shell_word(map)));
        }
        for (option, file) in [
            ("mapping", &self.mapping),
            ("displacement-log", &self.displacement_log),
            ("instrument-records", &self.instrument_records),
        ] {
            add(option, file.as_deref().map(path));
        }
        for (option, word) in [
            ("pose", &self.pose),
            ("direction", &self.direction),
            ("units", &self.units),
            ("force-unit", &self.force_unit),
            ("displacement-unit", &self.displacement_unit),
            ("time-unit", &self.time_unit),
            ("joint-unit", &self.joint_unit),
            ("sheet", &self.sheet),
            ("robot", &self.robot),
        ]
        .into_iter()
        .chain(self.gauge_lines.named())
        {
            add(option, word.as_deref().map(shell_word));
        }
        for flip in &self.flip {
            add("flip", word_of(FLIPS, flip));
        }
        let delimiter = self.delimiter.as_ref();
        add(
            "delimiter",
            delimiter.and_then(|one| word_of(DELIMITERS, one)),
        );
        let encoding = self.encoding.as_ref();
        add("encoding", encoding.and_then(|one| word_of(ENCODINGS, one)));
        let decimal = self.decimal.as_ref();
        add("decimal", decimal.and_then(|one| word_of(decimals(), one)));
        let thousands = self.thousands.as_ref();
        add(
            "thousands",
            thousands.and_then(|one| word_of(THOUSANDS, one)),
        );
        command
    }

    /// What the options state of the columns, over the mapping that they name.
    pub(super) fn mapping(&self) -> Result<ImportMapping, Failure> {
        let mut mapping = match &self.mapping {
            Some(path) => ImportMapping::from_toml(&path.display().to_string(), &read_text(path)?)?,
            None => ImportMapping::default(),
        };
        let mut seen: Vec<String> = Vec::new();
        let pairs = column_pairs(&self.map)?;
        if pairs.iter().any(|(role, _)| role == "displacement") {
            // What is stated replaces what the mapping has.
            mapping.columns.displacement = None;
            mapping.columns.repeats.clear();
        }
        for (role, column) in pairs {
            if role != "displacement" && seen.contains(&role) {
                return ArgumentError::refuse(
                    format!("--map {role}={column}"),
                    format!("{role} has a column already"),
                    "name one column for each",
                );
            }
            mapping.set(&role, &column)?;
            seen.push(role);
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
            mapping.flip.clone_from(&self.flip);
        }
        mapping.delimiter = self.delimiter.or(mapping.delimiter);
        mapping.encoding = self.encoding.or(mapping.encoding);
        mapping.decimal = self.decimal.or(mapping.decimal);
        mapping.thousands = self.thousands.or(mapping.thousands);
        Ok(mapping)
    }
}

/// `force=Kraft,displacement=Weg, mm`: a part without an equals sign belongs to the name before it.
pub(in crate::cli) fn column_pairs(map: &[String]) -> Result<Vec<(String, String)>, ArgumentError> {
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
