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
    let mut object = envelope("map", true);
    object["data"] = data.clone();
    let mut files = vec![
        ("map.txt".to_owned(), text.to_owned()),
        ("map.json".to_owned(), format!("{object:#}\n")),
    ];
    let poses = &report.poses.set;
    for (_, study) in &report.mechanisms {
        let name = &study.map.mechanism;
        files.push((
            format!("points-{name}.csv"),
            points_csv(report.robot, poses, &study.map),
        ));
        files.push((
            format!("mesh-{name}.vtu"),
            mesh_of(report.robot, poses, study),
        ));
    }
    let mut written = Vec::new();
    for (name, content) in files {
        let path = folder.join(name);
        write(&path, content.as_bytes())?;
        written.push(path);
    }
    Ok(written)
}
