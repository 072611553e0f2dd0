//! `stiffbench robot map merge`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::analysis::{ArgumentError, ReadError};
use crate::cli::{Failure, Outcome};
use crate::distribution::{PoseSample, Shard, StiffnessMap, row_width};

use super::args::MergeArgs;
use super::finish;
use super::job::{MapJob, MapStudy};
use super::shard::{ShardError, ShardFile, read};

/// Joins shards to the whole study.
pub(super) fn run(args: &MergeArgs) -> Result<Outcome, Failure> {
    let mut shards: Vec<ShardFile> = Vec::new();
    for path in &args.shards {
        for file in files_of(path)? {
            shards.push(read(&file)?);
        }
    }
    let Some((first, others)) = shards.split_first() else {
        return ArgumentError::refuse(
            "SHARD",
            "the folder holds no shard file (*.map-shard)",
            "shard files are written by stiffbench robot map --shard K/N --out FOLDER",
        );
    };
    for other in others {
        let differs = differences(&first.job, &other.job);
        if !differs.is_empty() {
            return Err(ShardError::Foreign {
                path: other.path.clone(),
                first: first.path.clone(),
                differs: differs.join(", "),
            }
            .into());
        }
    }
    let study = MapStudy::new(first.job.clone())?;
    let poses = study.pose_set(Shard::WHOLE)?;
    let maps = (0..study.job.mechanisms.len())
        .map(|mechanism| join(&study.job, &poses, &shards, mechanism))
        .collect::<Result<_, ShardError>>()?;
    let files = (args.out.as_deref(), &args.wanted_figures());
    finish(&study, poses, maps, files, Vec::new())
}

/// A shard file, or those in a folder in the order of their names.
fn files_of(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = fs::read_dir(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries.map_err(ReadError::of(path))?;
    let files = entries.iter().map(fs::DirEntry::path);
    let mut files: Vec<PathBuf> = files
        .filter(|file| file.extension().is_some_and(|ending| ending == "map-shard"))
        .collect();
    files.sort();
    Ok(files)
}

/// What two studies do not have in common, in words.
fn differences(one: &MapJob, other: &MapJob) -> Vec<&'static str> {
    let pairs = [
        ("the versions of the program", one.version == other.version),
        ("the robots", one.robot_text == other.robot_text),
        (
            "the factors",
            one.factors == other.factors && one.factors_name == other.factors_name,
        ),
        (
            "the uncertainties of the fit",
            one.covariance == other.covariance,
        ),
        ("the loads of the laws", one.at_load_n == other.at_load_n),
        (
            "the mechanisms or their effects",
            one.mechanisms == other.mechanisms,
        ),
        ("the samplings", one.sampling == other.sampling),
        ("the numbers of poses", one.poses == other.poses),
        ("the seeds", one.seed == other.seed),
        ("the variables that vary", one.held == other.held),
        ("the directions", one.columns == other.columns),
        ("the planes", one.plane == other.plane),
        ("the matrices", one.matrix == other.matrix),
    ];
    pairs
        .into_iter()
        .filter(|(_, same)| !same)
        .map(|(what, _)| what)
        .collect()
}

/// The map of one mechanism from all shards, pose by pose in the order of the whole.
fn join(
    job: &MapJob,
    poses: &PoseSample,
    shards: &[ShardFile],
    mechanism: usize,
) -> Result<StiffnessMap, ShardError> {
    let width = row_width(&job.columns, job.matrix);
    let found = find_poses(poses, shards, mechanism)?;
    let mut map = StiffnessMap {
        mechanism: job.mechanisms[mechanism].name.clone(),
        columns: job.columns.clone(),
        matrix: job.matrix,
        places: Vec::with_capacity(poses.len()),
        failed: Vec::new(),
        values: Vec::with_capacity(poses.len() * width),
    };
    let missing = found.iter().filter(|found| found.is_none()).count();
    for (place, found) in found.into_iter().enumerate() {
        match found {
            Some((index, Ok(row))) => {
                map.places.push(place as u32);
                let values = &shards[index].maps[mechanism].values;
                map.values
                    .extend_from_slice(&values[row * width..][..width]);
            }
            Some((_, Err(reason))) => map.failed.push((place as u32, reason.to_owned())),
            None => {
                return Err(ShardError::Incomplete {
                    missing,
                    whole: poses.len(),
                    first: poses.ids[place],
                });
            }
        }
    }
    Ok(map)
}

/// Where a pose is: in which shard, and there its row or why it has none.
type MergedPose<'a> = (usize, Result<usize, &'a str>);

/// Finds every pose of the whole among the shards.
fn find_poses<'a>(
    poses: &PoseSample,
    shards: &'a [ShardFile],
    mechanism: usize,
) -> Result<Vec<Option<MergedPose<'a>>>, ShardError> {
    let mut found: Vec<Option<MergedPose<'a>>> = vec![None; poses.len()];
    for (index, shard) in shards.iter().enumerate() {
        let map = &shard.maps[mechanism];
        let rows = map.ids.iter().enumerate().map(|(row, &id)| (id, Ok(row)));
        let failed = map.failed.iter();
        let failed = failed.map(|(id, reason)| (*id, Err(reason.as_str())));
        for (id, what) in rows.chain(failed) {
            let Ok(place) = poses.ids.binary_search(&id) else {
                return Err(ShardError::Damaged {
                    path: shard.path.clone(),
                    problem: format!("its study has no pose {id}"),
                });
            };
            if let Some((other, _)) = found[place] {
                return Err(ShardError::Overlap {
                    path: shards[other].path.clone(),
                    other: shard.path.clone(),
                    id,
                });
            }
            found[place] = Some((index, what));
        }
    }
    Ok(found)
}
