//! `stiffbench diagnose --design`: what a procedure can and cannot show, before any session.

use crate::analysis::{Inputs, design, named_procedure};
use crate::report::design_document;

use super::diagnose_args::DiagnoseArgs;
use super::failure::Failure;
use super::outcome::Outcome;

/// Says what a procedure can and cannot distinguish.
pub(super) fn run(args: &DiagnoseArgs, name: &str) -> Result<Outcome, Failure> {
    let (procedure, mut warnings) = named_procedure(name)?;
    let model = args.model.resolve()?;
    let report = design(
        &model,
        procedure,
        &args.parameters.choice(&model)?,
        args.seed,
    )?;
    warnings.extend(model.robot.warnings.iter().cloned());
    Ok(Outcome::new("design", design_document(&report), report)
        .with_inputs(Inputs::default().with_model(&model))
        .with_warnings(warnings))
}
