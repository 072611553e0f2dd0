//! `stiffbench stiffness`.

use crate::analysis::{Inputs, LoadedSession, OpenSettings, doubts_about_stiffness};
use crate::report::stiffness_text;
use crate::stiffness::Branches;

use super::args::{BranchChoice, Global, StiffnessArgs};
use super::failure::Failure;
use super::outcome::Outcome;

/// Readings to stiffness.
pub(super) fn run(args: &StiffnessArgs, global: &Global) -> Result<Outcome, Failure> {
    let options = OpenSettings {
        gauge_log: args.log.options()?,
        ..global.open_settings()
    };
    let session = LoadedSession::open(&args.data, &options)?;
    let branches = match args.branches {
        BranchChoice::Loading => Branches::LoadingOnly,
        BranchChoice::Both => Branches::Both,
    };
    let table = session.stiffness(branches)?;
    let flagged = table.cells.iter().any(|cell| !cell.flags.is_empty());
    let inputs = Inputs::default().with_session(&session);
    let mut warnings = session.warnings;
    warnings.extend(doubts_about_stiffness(&table));
    let excluded = &session.table.excluded;
    let left_out = excluded.superseded.len() + excluded.rejected.len();
    if left_out > 0 {
        warnings.push(format!(
            "{left_out} reading(s) superseded or rejected do not count"
        ));
    }
    let text = stiffness_text(&table, args.budget);
    Ok(Outcome::new("stiffness", text, table)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_strict_exit(u8::from(flagged)))
}
