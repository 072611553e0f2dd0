//! `stiffbench stiffness`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;

use crate::analysis::{ArgumentError, Inputs, LoadedSession, doubts_about_stiffness};
use crate::readings::{Reading, ReadingTable};
use crate::report::{VectorStiffnessReport, load_displacement_figure, stiffness_document};
use crate::stiffness::{Branches, StiffnessReport};

use super::data_args::DataArgs;
use super::failure::refuse_given;
use super::figure_files::write_figures;
use super::option_values::{BRANCHES, one_of};
use super::{Failure, Global, Outcome};
use crate::count::counted;

/// Arguments of `stiffness`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench stiffness my-session --budget\n  stiffbench stiffness readings.csv --branches both --json\n  stiffbench stiffness gauge-log.txt --direction x"
)]
pub(super) struct StiffnessArgs {
    /// Session folder, readings file, or table of another program
    data: PathBuf,
    /// Branches to use
    #[arg(long, value_parser = one_of(BRANCHES), default_value = "loading")]
    branches: Branches,
    /// Magnitude of the smallest load to use, N
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        hide_default_value = true
    )]
    from_load: f64,
    /// Magnitude of the largest load to use, N
    #[arg(long, value_name = "N", default_value_t = f64::INFINITY, hide_default_value = true)]
    to_load: f64,
    /// Print the uncertainty budget of every cell
    #[arg(long)]
    budget: bool,
    /// Write the figure of load against displacement into this folder
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    reading: DataArgs,
}

/// Readings to stiffness.
pub(super) fn run(args: &StiffnessArgs, global: &Global) -> Result<Outcome, Failure> {
    let options = args.reading.open_settings(global)?;
    let branches = args.branches;
    let mut session = LoadedSession::open_series(&args.data, &options)?;
    let note = keep(&mut session.table, &(args.from_load..=args.to_load))?;
    session.warnings.extend(note);
    if session.table.is_of_vectors() {
        let of_one_gauge = [("--figures", args.figures.is_some())];
        refuse_given(&of_one_gauge, OF_VECTORS, |_| {
            "leave it out; fit --figures draws a session of several gauges".to_owned()
        })?;
        return Ok(of_vectors(session, branches));
    }
    let table = session.stiffness(branches)?;
    let flagged = table.cells.iter().any(|cell| !cell.flags.is_empty());
    let inputs = Inputs::default().with_session(&session);
    let mut warnings = std::mem::take(&mut session.warnings);
    warnings.extend(doubts_about_stiffness(&table));
    let excluded = &session.table.excluded;
    let left_out = excluded.superseded.len() + excluded.rejected.len();
    warnings.extend(not_counted(left_out));
    let mut drawn = Vec::new();
    if let Some(folder) = &args.figures {
        let figure = load_displacement_figure(&[(&session.name, &table)]);
        drawn = write_figures(folder, vec![("load-displacement", figure)], &inputs)?;
    }
    let document = stiffness_document(&table, args.budget);
    let report = StiffnessReport::from(&table);
    Ok(Outcome::new("stiffness", document, report)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_written(&drawn)
        .with_strict_exit(u8::from(flagged)))
}

/// Why an option has no effect.
const OF_VECTORS: &str = "the session has several displacement gauges";

/// Keeps the readings whose loads count; what to say of the others.
fn keep(
    table: &mut ReadingTable,
    range_n: &RangeInclusive<f64>,
) -> Result<Option<String>, ArgumentError> {
    let all = table.one_of_each_load().count();
    let counts = |reading: &Reading| range_n.contains(&reading.target_n.abs());
    table.readings.retain(counts);
    table.unloaded.retain(counts);
    let kept = table.one_of_each_load().count();
    if kept == 0 {
        return Err(ArgumentError::new(
            "--from-load, --to-load",
            "no reading has a load in this range",
            "state sizes of loads in N, without a sign: the smallest, then the largest",
        ));
    }
    let beyond = counted(all - kept, "reading");
    let note = format!("not counted: {beyond} at loads outside --from-load, --to-load");
    Ok((kept < all).then_some(note))
}

/// What to say of readings that were left out because of their status, if any were.
fn not_counted(left_out: usize) -> Option<String> {
    let readings = counted(left_out, "reading");
    (left_out > 0).then(|| format!("not counted: {readings} superseded or rejected"))
}

/// The compliance along each axis of a session with several displacement gauges.
fn of_vectors(session: LoadedSession, branches: Branches) -> Outcome {
    let cells = session.compliances(branches);
    let report = VectorStiffnessReport::new(cells, session.procedure());
    let inputs = Inputs::default().with_session(&session);
    let mut warnings = session.warnings;
    let loads = session.table.one_of_each_load();
    warnings.extend(not_counted(loads.filter(|one| !one.is_accepted()).count()));
    Outcome::new("stiffness-vectors", report.document(), report)
        .with_inputs(inputs)
        .with_warnings(warnings)
}
