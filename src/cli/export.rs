//! `stiffbench export`: readings and stiffness for other programs.

use std::path::{Path, PathBuf};

use clap::Args;
use jiff::Timestamp;

use crate::analysis::{Inputs, LoadedLoadCases, LoadedSession, SessionTable, gauges_text, sha256};
use crate::export::tidy::{
    PackageResource, TableProvenance, TidyTable, csv, data_package, load_case_table, reading_table,
    ro_crate, stiffness_tables, vector_stiffness_tables, xlsx,
};
use crate::procedure::Procedure;
use crate::readings::OverdueGauge;
use crate::report::{DataExportReport, ExportedFile, ExportedTable, TableFormat};
use crate::stiffness::{Branches, StiffnessReport};

use super::data_args::DataArgs;
use super::figure_files::write;
use super::option_values::{BRANCHES, one_of};
use super::{CliError, Failure, Global, Outcome};

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench export my-session --out my-tables\n  stiffbench export my-session --format xlsx --out my-spreadsheet\n  stiffbench export my-session --ro-crate --out my-crate\n\nTables: readings, stiffness (with u and U), budget, loads, flags. docs/export.md and datapackage.json explain the columns."
)]
pub(super) struct DataExportArgs {
    /// Session folder, readings file, load cases, or table of another program
    data: PathBuf,
    /// Folder to write into; it must be new or empty
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Format of the tables; CSV and datapackage.json are always written
    #[arg(long, value_enum, default_value_t = TableFormat::Csv)]
    format: TableFormat,
    /// Also write ro-crate-metadata.json, for research data repositories
    #[arg(long)]
    ro_crate: bool,
    /// Branches used for the stiffness
    #[arg(long, value_parser = one_of(BRANCHES), default_value = "loading")]
    branches: Branches,
    /// How the data are read.
    #[command(flatten)]
    reading: DataArgs,
}

/// What is exported.
struct Exported {
    tables: Vec<TidyTable>,
    about: TableProvenance,
    inputs: Inputs,
}

/// Writes the tables of a session.
pub(super) fn run(args: &DataExportArgs, global: &Global) -> Result<Outcome, Failure> {
    let format = args.format;
    #[cfg(not(feature = "parquet"))]
    if format == TableFormat::Parquet {
        return Err(CliError::NoParquet.into());
    }
    check_free(&args.out)?;
    let exported = open(args, global)?;
    let mut files = Vec::new();
    let mut put = |name: &str, content: &[u8]| -> Result<(), CliError> {
        let path = args.out.join(name);
        write(&path, content)?;
        files.push(ExportedFile {
            path,
            bytes: content.len(),
            sha256: sha256(content),
        });
        Ok(())
    };
    let written = contents(&exported, format, args.ro_crate)?
        .iter()
        .try_for_each(|(name, content)| put(name, content));
    if let Err(error) = written {
        // A part of the tables is worth nothing; what was there before was an empty folder at most.
        for file in &files {
            let _ = std::fs::remove_file(&file.path);
        }
        let _ = std::fs::remove_dir(&args.out);
        return Err(error.into());
    }
    let report = DataExportReport {
        format,
        folder: args.out.clone(),
        tables: exported.tables.iter().map(ExportedTable::from).collect(),
        files,
    };
    Ok(Outcome::new("export", report.document(), report)
        .with_inputs(exported.inputs)
        .with_warnings(exported.about.notes))
}

/// The tables of a session, not written.
pub(super) fn tables(args: &DataExportArgs, global: &Global) -> Result<Vec<TidyTable>, Failure> {
    Ok(open(args, global)?.tables)
}

/// Refuses a folder that holds something, and a file.
pub(super) fn check_free(folder: &Path) -> Result<(), CliError> {
    let is_free = std::fs::read_dir(folder)
        .map_or_else(|_| !folder.exists(), |mut entries| entries.next().is_none());
    if is_free {
        return Ok(());
    }
    Err(CliError::NotEmpty {
        path: folder.to_owned(),
    })
}

/// The files by name, the description last.
fn contents(
    exported: &Exported,
    format: TableFormat,
    has_crate: bool,
) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let (tables, about) = (&exported.tables, &exported.about);
    let mut files = Vec::new();
    for table in tables {
        files.push((table, "csv", csv(table)));
    }
    if format == TableFormat::Parquet {
        for table in tables {
            files.push((table, "parquet", parquet_of(about, table)?));
        }
    }
    let names = files.iter();
    let names = names.map(|(table, ending, _)| format!("{}.{ending}", table.name));
    let names: Vec<String> = names.collect();
    let hashes: Vec<String> = files.iter().map(|(.., content)| sha256(content)).collect();
    let of_file = files.iter().zip(&names).zip(&hashes);
    let resources: Vec<PackageResource<'_>> = of_file
        .map(
            |(((table, format, content), file), sha256)| PackageResource {
                table,
                file,
                format,
                bytes: content.len(),
                sha256,
            },
        )
        .collect();
    let mut described = vec![("datapackage.json", data_package(about, &resources))];
    if has_crate {
        let today = Timestamp::now().strftime("%Y-%m-%d").to_string();
        described.push((
            "ro-crate-metadata.json",
            ro_crate(about, &resources, &today),
        ));
    }
    let contents = files.into_iter().map(|(.., content)| content);
    let mut all: Vec<(String, Vec<u8>)> = names.into_iter().zip(contents).collect();
    if format == TableFormat::Xlsx {
        all.push(("tables.xlsx".to_owned(), xlsx(about, tables)?));
    }
    let described = described.into_iter();
    all.extend(described.map(|(name, json)| (name.to_owned(), format!("{json:#}\n").into_bytes())));
    Ok(all)
}

#[cfg(feature = "parquet")]
fn parquet_of(about: &TableProvenance, table: &TidyTable) -> Result<Vec<u8>, Failure> {
    let content = crate::export::tidy::parquet(about, table);
    Ok(content.map_err(|error| CliError::Write {
        path: format!("{}.parquet", table.name).into(),
        source: std::io::Error::other(error),
    })?)
}

#[cfg(not(feature = "parquet"))]
fn parquet_of(_about: &TableProvenance, _table: &TidyTable) -> Result<Vec<u8>, Failure> {
    Err(CliError::NoParquet.into())
}

/// Opens the data and makes their tables.
fn open(args: &DataExportArgs, global: &Global) -> Result<Exported, Failure> {
    let settings = args.reading.open_settings(global)?;
    let branches = args.branches;
    if LoadedLoadCases::is_at(&args.data, &settings) {
        return Ok(of_load_cases(&LoadedLoadCases::open(
            &args.data, &settings,
        )?));
    }
    of_readings(LoadedSession::open_series(&args.data, &settings)?, branches)
}

fn of_readings(session: LoadedSession, branches: Branches) -> Result<Exported, Failure> {
    let mut tables = vec![reading_table(&session.table, session.origin.as_deref())?];
    let mut about = provenance(&session);
    if session.table.is_of_vectors() {
        tables.extend(vector_stiffness_tables(&session.compliances(branches)));
    } else {
        let table = session.stiffness(branches)?;
        tables.extend(stiffness_tables(&StiffnessReport::from(&table)));
        about
            .facts
            .push(("branches".to_owned(), words_of(branches).to_owned()));
    }
    about.measured_until = last_time(&tables[0]);
    let inputs = Inputs::default().with_session(&session);
    about.notes = session.warnings;
    Ok(Exported {
        tables: marked(tables, &session.overdue),
        about,
        inputs,
    })
}

fn of_load_cases(loaded: &LoadedLoadCases) -> Exported {
    let mut about = provenance(loaded);
    let inputs = Inputs::default().with_table(loaded);
    about.notes.clone_from(&loaded.warnings);
    Exported {
        tables: marked(vec![load_case_table(&loaded.table)], &loaded.overdue),
        about,
        inputs,
    }
}

/// The tables; with a column that names the gauges whose calibration is overdue, if there are any.
fn marked(tables: Vec<TidyTable>, overdue: &[OverdueGauge]) -> Vec<TidyTable> {
    if overdue.is_empty() {
        return tables;
    }
    let gauges = gauges_text(overdue);
    let meaning = "Gauges whose calibration is overdue, with the day on which it was due";
    let tables = tables.into_iter();
    let mark = |table: TidyTable| table.with_mark("calibration_overdue", meaning, &gauges);
    tables.map(mark).collect()
}

fn words_of(branches: Branches) -> &'static str {
    match branches {
        Branches::LoadingOnly => "loading",
        Branches::Both => "loading and unloading",
    }
}

/// The latest time of the readings; none if one of their times is no time.
fn last_time(readings: &TidyTable) -> Option<String> {
    let times = readings.column("utc").filter(|time| !time.is_empty());
    let times = times.map(|time| time.parse::<Timestamp>().ok());
    let times: Vec<Timestamp> = times.collect::<Option<_>>()?;
    Some(
        times
            .into_iter()
            .max()?
            .strftime("%Y-%m-%dT%H:%M:%SZ")
            .to_string(),
    )
}

/// What is known of the data, by name.
fn provenance<T>(session: &SessionTable<T>) -> TableProvenance {
    let name = session.short_name();
    let mut facts = vec![
        (
            "program".to_owned(),
            format!("stiffbench {}", env!("CARGO_PKG_VERSION")),
        ),
        ("data".to_owned(), name.clone()),
        ("data_sha256".to_owned(), session.sha256.clone()),
    ];
    let mut fact = |name: &str, value: Option<String>| {
        facts.extend(value.map(|value| (name.to_owned(), value)));
    };
    fact("not_measured", session.origin.clone());
    if let Some(header) = &session.header {
        fact("measured_with", header.software.clone());
        fact("operator", header.operator.clone());
        fact("place", header.place.clone());
        fact("robot", header.robot.clone());
        fact("robot_sha256", header.robot_sha256.clone());
        fact("mechanism", header.mechanism.clone());
        let procedure = header.procedure.as_ref();
        fact(
            "procedure",
            procedure.and_then(|procedure| procedure.name.clone()),
        );
        let whole = procedure.and_then(|record| Procedure::from_record(record).ok());
        fact(
            "procedure_sha256",
            whole.map(|procedure| sha256(procedure.to_toml())),
        );
        for (what, record) in header.instruments.named() {
            let known = [&record.model, &record.serial, &record.certificate];
            let known: Vec<&str> = known.into_iter().flatten().map(String::as_str).collect();
            fact(
                &what.replace(' ', "_"),
                Some(known.join(", ")).filter(|text| !text.is_empty()),
            );
        }
    }
    TableProvenance {
        title: format!("Stiffness measurement {name}"),
        name,
        source_sha256: session.sha256.clone(),
        facts,
        ..TableProvenance::default()
    }
}
