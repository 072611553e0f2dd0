//! The files of a map.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;

use crate::analysis::{ArgumentError, Inputs};
use crate::cli::failure::{CliError, Failure};
use crate::cli::figure_files::{file_part, write_again, write_figure, write_result};
use crate::plot::{BinValue, Figure};
use crate::report::{MapReport, MapSummary, mesh_of, points_csv};

/// Figures that go with a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct WantedFigures {
    /// Of every mechanism and direction, and of all mechanisms together.
    pub(super) of_each: bool,
    /// Of what the second mechanism has more than the first.
    pub(super) difference: Option<[String; 2]>,
    /// What a square shows of its poses.
    pub(super) cell: Option<BinValue>,
}

/// Writes points, meshes, tables and numbers into a folder; returns what was written.
pub(super) fn write_all(
    folder: &Path,
    report: &MapReport<'_>,
    wanted: &WantedFigures,
    (text, data, inputs): (&str, &MapSummary, &Inputs),
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = write_text(folder, text, data, inputs)?;
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
        let mesh = mesh_of(robot, poses, study);
        put(format!("mesh-{name}.vtu"), mesh.as_bytes())?;
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
    let mut figures = if wanted.of_each {
        report.figures()
    } else {
        Vec::new()
    };
    if let Some([before, after]) = &wanted.difference {
        let of_two = report.differences(before, after).ok_or_else(|| {
            let known = report
                .mechanisms
                .iter()
                .map(|(_, study)| study.map.mechanism.as_str());
            ArgumentError::new(
                format!("--difference {before},{after}"),
                "one of them is not among the maps".to_owned(),
                format!("the maps are of {}", known.collect::<Vec<_>>().join(", ")),
            )
        })?;
        figures.extend(of_two);
    }
    written.extend(write_figures(folder, &figures, inputs)?);
    Ok(written)
}

/// Writes figures as SVG and PNG, on all cores.
pub(super) fn write_figures(
    folder: &Path,
    figures: &[(String, Figure)],
    inputs: &Inputs,
) -> Result<Vec<PathBuf>, Failure> {
    let folder = folder.join("figures");
    let written: Vec<Vec<PathBuf>> = figures
        .par_iter()
        .map(|(name, figure)| write_figure(&folder.join(name), figure, inputs))
        .collect::<Result<_, Failure>>()?;
    Ok(written.into_iter().flatten().collect())
}

/// Writes tables and numbers.
pub(super) fn write_text(
    folder: &Path,
    text: &str,
    data: &impl Serialize,
    inputs: &Inputs,
) -> Result<Vec<PathBuf>, CliError> {
    let (files, fields) = (["map.txt", "map.json"], [("data", json!(data))]);
    write_result(folder, "map", files, (text, inputs), fields)
}
