//! Shard files: a share of a study, exact to the last bit.
//!
//! One line of JSON states what the study is and what follows: for each mechanism the numbers of the poses and their rows, eight bytes
//! each, little-endian. The last four bytes are the checksum (CRC-32C) of all before. A file appears under its name only when it is
//! whole.

use crate::analysis::{AnalysisError, ReadError};
use crate::session::checksum;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::cli::failure::{CliError, Failure};
use crate::cli::figure_files::write_again;
use crate::distribution::{PoseSample, StiffnessMap, row_width};

use super::job::{MapJob, SCHEMA};

/// What the first line says.
#[derive(Debug, Serialize, Deserialize)]
struct ShardHead {
    job: MapJob,
    /// One entry a mechanism.
    maps: Vec<MapHead>,
}

#[derive(Debug, Serialize, Deserialize)]
struct MapHead {
    rows: usize,
    /// Numbers of the poses that have no row, with the reason.
    failed: Vec<(u64, String)>,
}

/// A shard file, read.
#[derive(Debug)]
pub(super) struct ShardFile {
    pub(super) path: PathBuf,
    pub(super) job: MapJob,
    pub(super) maps: Vec<ShardMap>,
}

/// The part of one mechanism.
#[derive(Debug)]
pub(super) struct ShardMap {
    pub(super) ids: Vec<u64>,
    pub(super) values: Vec<f64>,
    pub(super) failed: Vec<(u64, String)>,
}

/// Why shards cannot be joined.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum ShardError {
    /// Not a whole shard file.
    #[error("{path} is not a complete shard file: {problem}")]
    #[diagnostic(
        code(stiffbench::input::shard),
        help("work that share out again: stiffbench robot map ... --shard K/N --out FOLDER")
    )]
    Damaged { path: PathBuf, problem: String },
    /// Of another study.
    #[error("{path} is of another study than {first}: {differs} differ")]
    #[diagnostic(
        code(stiffbench::input::foreign_shard),
        help(
            "join shards of one study only: the same options and the same version of the program, but for --shard"
        )
    )]
    Foreign {
        path: PathBuf,
        first: PathBuf,
        differs: String,
    },
    /// Two shards with one pose.
    #[error("{path} and {other} overlap: both have pose {id}")]
    #[diagnostic(
        code(stiffbench::input::overlapping_shards),
        help("leave one of them out")
    )]
    Overlap {
        path: PathBuf,
        other: PathBuf,
        id: u64,
    },
    /// Poses without a shard.
    #[error(
        "the shards are not complete: {missing} of {whole} poses are missing, the first is pose {first}"
    )]
    #[diagnostic(
        code(stiffbench::input::incomplete_shards),
        help("name all shards of the study; work out again those that are not there")
    )]
    Incomplete {
        missing: usize,
        whole: usize,
        first: u64,
    },
}

/// Writes a shard beside its name, and gives it the name when it is whole and on the disk.
pub(super) fn write(
    path: &Path,
    job: &MapJob,
    poses: &PoseSample,
    maps: &[StiffnessMap],
) -> Result<(), Failure> {
    let bytes = bytes(job, poses, maps)?;
    Ok(write_again(path, &bytes)?)
}

fn bytes(job: &MapJob, poses: &PoseSample, maps: &[StiffnessMap]) -> Result<Vec<u8>, Failure> {
    let head = ShardHead {
        job: job.clone(),
        maps: maps
            .iter()
            .map(|map| MapHead {
                rows: map.len(),
                failed: map
                    .failed
                    .iter()
                    .map(|(place, reason)| (poses.ids[*place as usize], reason.clone()))
                    .collect(),
            })
            .collect(),
    };
    let line = serde_json::to_vec(&head).map_err(|error| CliError::Write {
        path: "the head of the shard".into(),
        source: error.into(),
    })?;
    let mut bytes = line;
    bytes.push(b'\n');
    for map in maps {
        for &place in &map.places {
            bytes.extend(poses.ids[place as usize].to_le_bytes());
        }
        for value in &map.values {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    Ok(bytes)
}

/// Reads a shard file.
///
/// # Errors
/// [`ShardError::Damaged`] for anything but a whole one.
pub(super) fn read(path: &Path) -> Result<ShardFile, Failure> {
    let bytes = fs::read(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => Failure::from(AnalysisError::NotFound {
            path: path.to_owned(),
            help: "shard files are written by stiffbench robot map --shard K/N --out FOLDER"
                .to_owned(),
        }),
        _ => ReadError::of(path)(source).into(),
    })?;
    let damaged = |problem: &str| ShardError::Damaged {
        path: path.to_owned(),
        problem: problem.to_owned(),
    };
    let (content, stored) = bytes
        .split_last_chunk::<4>()
        .ok_or_else(|| damaged("it is empty or nearly so"))?;
    if !content.starts_with(b"{") {
        return Err(damaged("it does not begin as one").into());
    }
    if checksum(content) != u32::from_le_bytes(*stored) {
        return Err(damaged("its checksum is not that of its content").into());
    }
    let end = content.iter().position(|&byte| byte == b'\n');
    let (line, rest) = content.split_at(end.ok_or_else(|| damaged("it has no head"))?);
    let head: ShardHead = serde_json::from_slice(line)
        .map_err(|error| damaged(&format!("its head is not that of this version: {error}")))?;
    if head.job.schema != SCHEMA {
        return Err(damaged(&format!("its schema is {}", head.job.schema)).into());
    }
    let maps = maps(&head, &rest[1..]).ok_or_else(|| damaged("rows are missing"))?;
    Ok(ShardFile {
        path: path.to_owned(),
        job: head.job,
        maps,
    })
}

/// The rows behind the head; `None` if there are more or fewer than it says.
fn maps(head: &ShardHead, mut rest: &[u8]) -> Option<Vec<ShardMap>> {
    let width = row_width(&head.job.columns, head.job.matrix);
    let mut take = |count: usize| -> Option<Vec<[u8; 8]>> {
        let (taken, left) = rest.split_at_checked(count.checked_mul(8)?)?;
        rest = left;
        let (words, _) = taken.as_chunks::<8>();
        Some(words.to_vec())
    };
    let mut maps = Vec::new();
    for map in &head.maps {
        let ids = take(map.rows)?;
        let values = take(map.rows.checked_mul(width)?)?;
        maps.push(ShardMap {
            ids: ids.into_iter().map(u64::from_le_bytes).collect(),
            values: values.into_iter().map(f64::from_le_bytes).collect(),
            failed: map.failed.clone(),
        });
    }
    (rest.is_empty() && maps.len() == head.job.mechanisms.len()).then_some(maps)
}
