//! `stiffbench robot export`.

use std::path::PathBuf;

use clap::Args;

use crate::analysis::{ArgumentError, Inputs, is_dash, sha256};
use crate::export::ExportModel;
use crate::report::{ExportFormat, ModelExportReport};
use crate::shipped::{shipped_robot, shipped_robots};

use super::args::RobotModelArgs;
use super::figure_files::write;
use super::map::read_fit;
use super::pose_args::{PoseArgs, limits_passed};
use super::{Failure, Outcome};

/// Arguments of `robot export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot export serial-arm --format mjcf --pose P1 --out arm.xml\n  stiffbench fit my-session --json > fit.json\n  stiffbench robot export --format csv --fit fit.json > parameters.csv\n  stiffbench robot export --format sdf --model diagnosis/model.toml --pose P1 --out robot.sdf\n\nWithout --pose and --set, csv and json hold every named pose. docs/simulators.md lists what each format holds."
)]
pub(super) struct RobotExportArgs {
    /// Format of the file
    #[arg(long, value_enum)]
    format: ExportFormat,
    /// Which robot, mechanism and factors.
    #[command(flatten)]
    model: RobotModelArgs,
    /// Output of stiffbench fit --json: its factors with their intervals
    #[arg(long, value_name = "FILE", conflicts_with = "factors")]
    fit: Option<PathBuf>,
    /// Which pose.
    #[command(flatten)]
    pose: PoseArgs,
    /// Write to this file instead of standard output; - is standard output too
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// The shipped robot whose file has this SHA-256.
fn shipped_of_hash(hash: &str) -> Option<String> {
    let mut known = shipped_robots();
    let has = |name: &&str| shipped_robot(name).is_some_and(|text| sha256(&text.text) == hash);
    known.find(has).map(str::to_owned)
}

pub(super) fn run(args: &RobotExportArgs) -> Result<Outcome, Failure> {
    let fit = args.fit.as_deref().map(read_fit).transpose()?;
    let mut choice = args.model.model().choice()?;
    if let Some(fit) = &fit {
        // Where the fit was made of a model, its robot is known.
        let is_open = choice.robot.is_none() && choice.model.is_none();
        if is_open && let Some((name, hash)) = &fit.robot {
            choice.robot = Some(shipped_of_hash(hash).ok_or_else(|| {
                ArgumentError::new(
                    "--fit",
                    format!("the fit is of the robot {name}, which is not a shipped one"),
                    "name its file as ROBOT",
                )
            })?);
        }
        choice.mechanism = choice.mechanism.or_else(|| fit.mechanism.clone());
    }
    let mut resolved = crate::analysis::resolve(&choice, None)?;
    let (mut fitted, mut warnings) = (Vec::new(), resolved.warnings.clone());
    if let Some(fit) = fit {
        resolved.robot.check_parameters(&fit.factors)?;
        resolved.factors_name = fit.factors_name;
        resolved.factors = fit.factors;
        fitted = fit.parameters;
        warnings.extend(fit.warnings);
    }
    let model = ExportModel::new(&resolved, fitted);
    let pose = args.pose.chosen(&resolved.robot)?;
    let pose = pose.as_ref();
    let table = model.table(pose)?;
    let (text, notes) = match args.format {
        ExportFormat::Mjcf => model.mjcf(pose)?,
        ExportFormat::Sdf => model.sdf(pose)?,
        ExportFormat::Urdf => model.urdf(pose)?,
        ExportFormat::Csv => (table.csv(), Vec::new()),
        ExportFormat::Json => (format!("{:#}\n", serde_json::json!(table)), Vec::new()),
    };
    warnings.extend(notes);
    warnings.extend(pose.map_or_else(Vec::new, |(_, pose)| limits_passed(&resolved.robot, pose)));
    warnings.extend(table.notes.iter().cloned());
    let inputs = Inputs::default().with_model(&resolved);
    let mut report = ModelExportReport {
        format: args.format,
        file: args.out.clone().filter(|file| !is_dash(file)),
        text: None,
        table,
    };
    let Some(file) = report.file.clone() else {
        // The file alone, so that it can be redirected.
        report.text = Some(text.clone());
        return Ok(Outcome::new("model-export", text, report)
            .with_inputs(inputs)
            .without_heading()
            .with_warnings(warnings));
    };
    write(&file, text.as_bytes())?;
    let said = format!("Written to {}\n", file.display());
    Ok(Outcome::new("model-export", said, report)
        .with_inputs(inputs)
        .with_warnings(warnings))
}
