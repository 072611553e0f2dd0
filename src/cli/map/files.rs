//! The files of a map.

use std::path::{Path, PathBuf};

use crate::analysis::{ArgumentError, Inputs};
#[cfg(feature = "parquet")]
use crate::cli::failure::CliError;
use crate::cli::failure::Failure;
use crate::cli::figure_files::{file_part, write_again, write_figures, write_result};
use crate::cli::outcome::Outcome;
use crate::plot::BinValue;
use crate::report::{MapReport, points_csv};

/// The text and the numbers of a map.
pub(super) const FILES: [&str; 2] = ["map.txt", "map.json"];

/// Figures that go with a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct WantedFigures {
    /// Where they go; `None` without figures.
    pub(super) folder: Option<PathBuf>,
    /// Also of what the second mechanism has more than the first.
    pub(super) difference: Option<[String; 2]>,
    /// What a square shows of its poses.
    pub(super) cell: Option<BinValue>,
}

/// Writes points, meshes, tables and numbers into a folder; returns what was written.
pub(super) fn write_all(
    folder: &Path,
    report: &MapReport<'_>,
    result: &Outcome,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = write_result(folder, FILES, result)?;
    // One after the other: the points of all mechanisms at once would need as much memory again as the maps.
    let mut put = |name: String, content: &[u8]| -> Result<(), Failure> {
        let path = folder.join(name);
        write_again(&path, content)?;
        written.push(path);
        Ok(())
    };
    let (robot, poses) = (report.robot, &report.poses.set);
    for (_, study) in &report.mechanisms {
        let name = file_part(&study.map.mechanism);
        let points = points_csv(robot, poses, &study.map);
        put(format!("points-{name}.csv"), points.as_bytes())?;
        #[cfg(feature = "parquet")]
        {
            let file = format!("points-{name}.parquet");
            let content = crate::report::points_parquet(robot, poses, &study.map);
            let content = content.map_err(|error| CliError::Write {
                path: folder.join(&file),
                source: std::io::Error::other(error),
            })?;
            put(file, &content)?;
        }
    }
    Ok(written)
}

/// Draws the figures that are wanted; returns what was written.
pub(super) fn draw(
    report: &MapReport<'_>,
    wanted: &WantedFigures,
    inputs: &Inputs,
) -> Result<Vec<PathBuf>, Failure> {
    let Some(folder) = &wanted.folder else {
        return Ok(Vec::new());
    };
    let mut figures = report.figures();
    if let Some([before, after]) = &wanted.difference {
        let of_two = report.differences(before, after).ok_or_else(|| {
            let known = report.mechanisms.iter();
            let known: Vec<&str> = known
                .map(|(_, study)| study.map.mechanism.as_str())
                .collect();
            ArgumentError::new(
                format!("--difference {before},{after}"),
                "one of them is not among the maps".to_owned(),
                format!("the maps are of {}", known.join(", ")),
            )
        })?;
        figures.extend(of_two);
    }
    write_figures(folder, figures, inputs)
}
