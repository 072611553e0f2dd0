//! `stiffbench stiffness`.

use crate::analysis::{
    ArgumentError, Inputs, LoadedSession, OpenSettings, VectorSession, doubts_about_stiffness,
};
use crate::readings::{Reading, VectorReading};
use crate::report::{VectorStiffnessReport, stiffness_text};
use crate::stiffness::Branches;

use super::args::{Global, StiffnessArgs};
use super::failure::Failure;
use super::outcome::Outcome;
use crate::count::counted;

/// Readings to stiffness.
pub(super) fn run(args: &StiffnessArgs, global: &Global) -> Result<Outcome, Failure> {
    let options = OpenSettings {
        gauge_log: args.log.options()?,
        ..args.calibration.open_settings(global)?
    };
    let branches = Branches::from(args.branches);
    let range_n = args.from_load..=args.to_load;
    if let Some(mut session) = VectorSession::open(&args.data, &options)? {
        let loads = |reading: &VectorReading| range_n.contains(&reading.target_n.abs());
        let note = keep(&mut session.table.readings, loads)?;
        session.warnings.extend(note);
        return Ok(of_vectors(session, branches));
    }
    let mut session = LoadedSession::open(&args.data, &options)?;
    let loads = |reading: &Reading| range_n.contains(&reading.target_n.abs());
    let note = keep(&mut session.table.readings, loads)?;
    session.warnings.extend(note);
    let table = session.stiffness(branches)?;
    let flagged = table.cells.iter().any(|cell| !cell.flags.is_empty());
    let inputs = Inputs::default().with_session(&session);
    let mut warnings = session.warnings;
    warnings.extend(doubts_about_stiffness(&table));
    let excluded = &session.table.excluded;
    let left_out = excluded.superseded.len() + excluded.rejected.len();
    warnings.extend(not_counted(left_out));
    let text = stiffness_text(&table, args.budget);
    Ok(Outcome::new("stiffness", text, table)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_strict_exit(u8::from(flagged)))
}

/// Keeps the readings whose loads count; what to say of the others.
fn keep<R>(
    readings: &mut Vec<R>,
    loads: impl Fn(&R) -> bool,
) -> Result<Option<String>, ArgumentError> {
    let all = readings.len();
    readings.retain(loads);
    if readings.is_empty() {
        return Err(ArgumentError::new(
            "--from-load, --to-load",
            "no reading has a load in this range",
            "state sizes of loads in N, without a sign: the smallest, then the largest",
        ));
    }
    let beyond = counted(all - readings.len(), "reading");
    let note = format!("not counted: {beyond} at loads outside --from-load, --to-load");
    Ok((readings.len() < all).then_some(note))
}

/// What to say of readings that were left out because of their status, if any were.
fn not_counted(left_out: usize) -> Option<String> {
    let readings = counted(left_out, "reading");
    (left_out > 0).then(|| format!("not counted: {readings} superseded or rejected"))
}

/// The compliance along each axis of a session with several displacement gauges.
fn of_vectors(session: VectorSession, branches: Branches) -> Outcome {
    let cells = session.stiffness(branches);
    let report = VectorStiffnessReport::new(&cells, session.procedure());
    let inputs = Inputs::default().with_table(&session);
    let mut warnings = session.warnings;
    let left_out = session.table.readings.len() - session.table.accepted().count();
    warnings.extend(not_counted(left_out));
    let text = report.text();
    Outcome::new("stiffness-vectors", text, report)
        .with_inputs(inputs)
        .with_warnings(warnings)
}
