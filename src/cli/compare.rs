//! `stiffbench compare`.

use std::path::PathBuf;

use clap::Args;

use stiffbench_document::Document;

use crate::analysis::{ArgumentError, Inputs, LoadedSession};
use crate::readings::InstrumentRecord;
use crate::report::{ComparisonReport, load_displacement_figure};
use crate::stiffness::{
    Branches, CellStiffness, Comparison, Flag, SameGauges, StiffnessAgreement, StiffnessTable,
    compare,
};

use super::data_args::DataArgs;
use super::figure_files::write_figures;
use super::report::{PageArgs, write_comparison};
use super::{Failure, Global, Outcome};

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench compare monday friday\n  stiffbench compare monday friday --report friday.html"
)]
pub(super) struct CompareArgs {
    /// First session
    a: PathBuf,
    /// Second session
    b: PathBuf,
    /// Write the figure of both sessions, load against displacement, into this folder
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// Write the comparison as a report, one HTML file
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// What the report states.
    #[command(flatten)]
    page: PageArgs,
    /// Calibration of the gauges, the same in both sessions.
    #[command(flatten)]
    reading: DataArgs,
}

/// The comparison of two sessions, the gauges they share, and words for sessions of two robots.
pub(super) fn compared(
    a: &LoadedSession,
    b: &LoadedSession,
) -> Result<(Comparison, SameGauges, Option<String>), Failure> {
    let same = same_gauges(a, b);
    let tables = [a, b].map(|session| session.stiffness(Branches::LoadingOnly));
    let [table_a, table_b] = tables;
    let comparison = compare(&table_a?, &table_b?, same);
    Ok((comparison, same, two_robots(a, b)))
}

/// The difference of two sessions.
pub(super) fn run(args: &CompareArgs, global: &Global) -> Result<Outcome, Failure> {
    if args.report.is_none() && args.page != PageArgs::default() {
        return ArgumentError::refuse(
            "--details, --issued, --amends, --template",
            "they belong to --report",
            "add --report FILE, or leave them out",
        );
    }
    let options = args.reading.open_settings(global)?;
    let [a, b] = [
        LoadedSession::open(&args.a, &options)?,
        LoadedSession::open(&args.b, &options)?,
    ];
    let inputs = Inputs::default().with_session(&a).with_session(&b);
    let [table_a, table_b] = [
        a.stiffness(Branches::LoadingOnly)?,
        b.stiffness(Branches::LoadingOnly)?,
    ];
    let (comparison, same, robots) = compared(&a, &b)?;
    let mut warnings: Vec<String> = [&a, &b]
        .into_iter()
        .flat_map(|session| {
            session
                .warnings
                .iter()
                .map(|w| format!("{}: {w}", session.name))
        })
        .collect();
    let tables = [(&a, &table_a), (&b, &table_b)];
    let in_doubt = tables.map(|(session, table)| cells_in_doubt(&session.name, table));
    warnings.splice(0..0, in_doubt.into_iter().flatten());
    warnings.push(gauge_note(same));
    warnings.extend(metadata_differences(&a, &b));
    let mut drawn = Vec::new();
    if let Some(folder) = &args.figures {
        let figure = load_displacement_figure(&[(&a.name, &table_a), (&b.name, &table_b)]);
        drawn = write_figures(folder, vec![("load-displacement", figure)], &inputs)
            .map_err(|failure| failure.with_warnings(&warnings))?;
    }
    if let Some(out) = &args.report {
        let two = robots.is_some();
        let written = write_comparison(
            [&args.a, &args.b],
            &comparison,
            two,
            (&args.page, &args.reading),
            (out, global),
        );
        let page = written.map_err(|failure| failure.with_warnings(&warnings))?;
        let missing = page.missing();
        warnings.push(format!("wrote {}, report {}", out.display(), page.number));
        if !missing.is_empty() {
            warnings.push(format!(
                "the report lacks, according to ISO/IEC 17025: {}",
                missing.join("; ")
            ));
        }
    }
    let differs = comparison.agreement == StiffnessAgreement::Differs;
    let report = ComparisonReport::new(&comparison, robots.is_some());
    let mut document = robots.as_ref().map(Document::of).unwrap_or_default();
    document.append(report.document(&a.name, &b.name));
    warnings.splice(0..0, robots);
    Ok(Outcome::new("compare", document, report)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_written(&drawn)
        .with_strict_exit(u8::from(differs)))
}

/// The cells whose flags put their stiffness in doubt; `None` if there are none.
fn cells_in_doubt(name: &str, table: &StiffnessTable) -> Option<String> {
    let in_doubt = |cell: &&CellStiffness| cell.flags.iter().any(Flag::spoils_stiffness);
    let cells = table.cells.iter().filter(in_doubt);
    let cells: Vec<String> = cells.map(|cell| cell.cell.to_string()).collect();
    (!cells.is_empty()).then(|| {
        format!(
            "{name}: K of {} is in doubt; `stiffness {name}` gives the reasons",
            cells.join(", ")
        )
    })
}

/// Gauges are the same if both sessions name the same serial number.
fn same_gauges(a: &LoadedSession, b: &LoadedSession) -> SameGauges {
    let serial =
        |session: &LoadedSession,
         of: fn(&crate::readings::Instruments) -> Option<&InstrumentRecord>| {
            session
                .header
                .as_ref()
                .and_then(|header| of(&header.instruments))
                .and_then(|record| record.serial.clone())
        };
    let same = |of: fn(&crate::readings::Instruments) -> Option<&InstrumentRecord>| {
        let serials = [serial(a, of), serial(b, of)];
        serials[0].is_some() && serials[0] == serials[1]
    };
    SameGauges {
        force: same(|i| i.force.as_ref()),
        displacement: same(|i| i.displacement.as_ref()),
    }
}

fn gauge_note(same: SameGauges) -> String {
    let word = |same| {
        if same {
            "the same (its calibration error cancels)"
        } else {
            "another, or without serial number"
        }
    };
    format!(
        "force gauge: {}; displacement gauge: {}",
        word(same.force),
        word(same.displacement)
    )
}

/// Words for sessions of two robots.
fn two_robots(a: &LoadedSession, b: &LoadedSession) -> Option<String> {
    let hash = |session: &LoadedSession| session.header.as_ref()?.robot_sha256.clone();
    let [of_a, of_b] = [hash(a)?, hash(b)?];
    (of_a != of_b).then(|| {
        format!(
            "Two robots were measured: the robot file of {} is not that of {}. Their stiffness differs for that reason alone.",
            a.name, b.name
        )
    })
}

/// What else the headers do not have in common.
fn metadata_differences(a: &LoadedSession, b: &LoadedSession) -> Vec<String> {
    let (Some(a), Some(b)) = (&a.header, &b.header) else {
        return Vec::new();
    };
    let procedure = |header: &crate::readings::SessionHeader| {
        header.procedure.as_ref().and_then(|p| p.name.clone())
    };
    let fields = [
        ("robot", a.robot.clone(), b.robot.clone()),
        ("mechanism", a.mechanism.clone(), b.mechanism.clone()),
        ("procedure", procedure(a), procedure(b)),
        ("operator", a.operator.clone(), b.operator.clone()),
        ("place", a.place.clone(), b.place.clone()),
    ];
    let word = |value: Option<String>| value.unwrap_or_else(|| "not stated".to_owned());
    fields
        .into_iter()
        .filter(|(_, a, b)| a != b)
        .map(|(what, a, b)| format!("{what} differs: {} and {}", word(a), word(b)))
        .collect()
}
