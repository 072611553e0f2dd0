//! The files of a map.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::failure::Failure;
use crate::cli::figure_files::write;
use crate::cli::outcome::envelope;
use crate::report::{MapReport, mesh_of, points_csv};

/// Writes points, meshes, tables and numbers into a folder; returns what was written.
pub(super) fn write_all(
    folder: &Path,
    report: &MapReport<'_>,
    text: &str,
    data: &Value,
) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    // One after the other: the points of all mechanisms at once would need as much memory again as the maps.
    let mut put = |name: String, content: &[u8]| -> Result<(), Failure> {
        let path = folder.join(name);
        write(&path, content)?;
        written.push(path);
        Ok(())
    };
    let mut object = envelope("map", true);
    object["data"] = data.clone();
    put("map.txt".to_owned(), text.as_bytes())?;
    put("map.json".to_owned(), format!("{object:#}\n").as_bytes())?;
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
            let content = content.map_err(|error| crate::cli::failure::CliError::Write {
                path: folder.join(&file),
                source: std::io::Error::other(error),
            })?;
            put(file, &content)?;
        }
    }
    Ok(written)
}

/// The name of a mechanism as a part of a file's name.
fn file_part(name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    name.chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect()
}
