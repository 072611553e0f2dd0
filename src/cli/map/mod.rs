//! `stiffbench robot map`.

mod args;
mod files;
mod fit_file;
mod job;
mod merge;
mod prepare;
mod questions;
mod shard;

use std::path::Path;

use stiffbench_document::Document;

use crate::distribution::{PoseSample, Shard, StiffnessMap};

use super::progress::progress;
use super::{Failure, Global, Outcome};
use crate::report::ShardReport;

pub(super) use args::MapArgs;
pub(super) use fit_file::read_fit;

use args::MapCommand;
use files::{WantedFigures, draw, write_all};
use job::MapStudy;
use prepare::prepare;

/// Stiffness over the workspace, whole or a share of it, or shares joined.
pub(super) fn run(args: &MapArgs, global: &Global) -> Result<Outcome, Failure> {
    if let Some(MapCommand::Merge(args)) = &args.what {
        return merge::run(args);
    }
    let (mut job, warnings) = prepare(&args.study)?;
    if args.asked.sensitivity && args.study.mechanism.is_empty() {
        // Six designs at once would bury the one that is wanted.
        let others = job.mechanisms.len().saturating_sub(1);
        job.mechanisms.drain(..others);
    }
    let study = MapStudy::new(job)?;
    let files = (args.out.as_deref(), &args.wanted_figures());
    let poses = study.pose_set(args.shard.unwrap_or(Shard::WHOLE))?;
    if args.asked.is_any() {
        return questions::run(&study, poses, &args.asked, files, warnings);
    }
    let bar = progress(global, "maps of mechanisms", study.physics.len() as u64);
    let maps = study.of_each(|model| {
        let (columns, matrix) = (&study.job.columns, study.job.matrix);
        let map = StiffnessMap::with_matrix(model, &poses, columns, matrix);
        bar.inc(1);
        map
    });
    bar.finish_and_clear();
    match (args.shard, &args.out) {
        (Some(share), Some(folder)) => {
            Ok(one_shard(&study, (share, &poses), &maps?, folder)?.with_warnings(warnings))
        }
        _ => finish(&study, poses, maps?, files, warnings),
    }
}

/// All that is said and written of maps, however they came about.
fn finish(
    study: &MapStudy,
    poses: PoseSample,
    maps: Vec<StiffnessMap>,
    (out, figures): (Option<&Path>, &WantedFigures),
    warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let poses = study.shown(poses);
    let mut report = study.report(&poses, maps)?;
    report.cell = figures.cell;
    let outcome = Outcome::new("map", report.document(), report.summary())
        .with_inputs(study.inputs())
        .with_warnings(warnings);
    let mut written = draw(&report, figures, &outcome.inputs)?;
    if let Some(folder) = out {
        written.extend(write_all(folder, &report, &outcome)?);
    }
    Ok(outcome.with_written(&written))
}

/// A share, to a file.
fn one_shard(
    study: &MapStudy,
    (share, poses): (Shard, &PoseSample),
    maps: &[StiffnessMap],
    folder: &Path,
) -> Result<Outcome, Failure> {
    let path = folder.join(format!("{}-of-{}.map-shard", share.index + 1, share.count));
    shard::write(&path, &study.job, poses, maps)?;
    let mut document = Document::new();
    document.lines(format!(
        "{}: {} of {} poses, {} mechanisms\nNext, when all shares are there: stiffbench robot map merge {}/*.map-shard --out FOLDER",
        path.display(),
        poses.len(),
        poses.whole,
        maps.len(),
        folder.display()
    ));
    let report = ShardReport {
        shard: format!("{}/{}", share.index + 1, share.count),
        file: path,
        poses: poses.len(),
        of: poses.whole,
    };
    Ok(Outcome::new("map-shard", document, report).with_inputs(study.inputs()))
}
