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

use crate::distribution::{PoseSample, Shard, StiffnessMap, StudyPoses};
use crate::physics::ActingPhysics;
use crate::robot::Robot;

use super::args::Global;
use super::failure::Failure;
use super::outcome::Outcome;
use super::progress::progress;
use crate::report::ShardReport;

pub(super) use args::MapArgs;
pub(super) use fit_file::{FitFile, read_fit};

use args::MapCommand;
use files::{WantedFigures, draw, write_all};
use job::MapJob;
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
    match (args.shard, &args.out) {
        _ if args.asked.is_any() => {
            let files = (args.out.as_deref(), args.wanted_figures());
            questions::run(&job, &args.asked, files, warnings)
        }
        (Some(share), Some(folder)) => {
            Ok(one_shard(&job, share, folder, global)?.with_warnings(warnings))
        }
        _ => {
            let files = (args.out.as_deref(), &args.wanted_figures());
            whole(&job, files, warnings, global)
        }
    }
}

/// The whole study.
fn whole(
    job: &MapJob,
    files: (Option<&Path>, &WantedFigures),
    warnings: Vec<String>,
    global: &Global,
) -> Result<Outcome, Failure> {
    let robot = job.robot()?;
    let physics = job.physics(&robot)?;
    let poses = job.pose_set(&robot, Shard::WHOLE)?;
    let maps = maps_of(job, &robot, (&physics, &poses), global)?;
    finish(job, (&robot, poses), maps, files, warnings)
}

/// The maps of all mechanisms, with progress.
fn maps_of(
    job: &MapJob,
    robot: &Robot,
    (physics, poses): (&[ActingPhysics], &PoseSample),
    global: &Global,
) -> Result<Vec<StiffnessMap>, Failure> {
    let bar = progress(global, "maps of mechanisms", physics.len() as u64);
    let maps = job.maps(robot, physics, poses, &|| bar.inc(1));
    bar.finish_and_clear();
    maps
}

/// All that is said and written of maps, however they came about.
fn finish(
    job: &MapJob,
    (robot, poses): (&Robot, PoseSample),
    maps: Vec<StiffnessMap>,
    (out, figures): (Option<&Path>, &WantedFigures),
    warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let physics = job.physics(robot)?;
    let poses = StudyPoses::new(poses, job.sampling, job.plane(robot));
    let mut report = job.report(robot, &physics, &poses, maps)?;
    report.cell = figures.cell;
    let outcome = Outcome::new("map", report.document(), report.summary())
        .with_inputs(job.inputs(robot))
        .with_warnings(warnings);
    let mut written = draw(&report, figures, &outcome.inputs)?;
    if let Some(folder) = out {
        written.extend(write_all(folder, &report, &outcome)?);
    }
    Ok(outcome.with_written(&written))
}

/// A share, to a file.
fn one_shard(
    job: &MapJob,
    share: Shard,
    folder: &Path,
    global: &Global,
) -> Result<Outcome, Failure> {
    let robot = job.robot()?;
    let physics = job.physics(&robot)?;
    let poses = job.pose_set(&robot, share)?;
    let maps = maps_of(job, &robot, (&physics, &poses), global)?;
    let path = folder.join(format!("{}-of-{}.map-shard", share.index + 1, share.count));
    shard::write(&path, job, &poses, &maps)?;
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
    Ok(Outcome::new("map-shard", document, report).with_inputs(job.inputs(&robot)))
}
