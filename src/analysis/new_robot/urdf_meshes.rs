//! Meshes that a URDF names and that are not there. They have no part in stiffness, but a broken path often means a broken file.

use std::path::{Path, PathBuf};

use crate::analysis::files::is_there;
use crate::source_text::SourceText;

use super::urdf::Urdf;

/// One note on all meshes that are not there, with the first by name.
///
/// `package://NAME/…` is looked for in a folder NAME above the URDF, everything else beside it.
pub(super) fn missing_meshes(source: &SourceText, urdf: &Urdf) -> Option<String> {
    let folder = Path::new(&source.name).parent().unwrap_or(Path::new(""));
    let meshes = urdf
        .links
        .iter()
        .flat_map(|link| link.meshes.iter().map(move |mesh| (link, mesh)));
    let mut missing =
        meshes.filter(|(_, mesh)| !candidates(folder, mesh).any(|path| is_there(&path)));
    let (link, mesh) = missing.next()?;
    let more = match missing.count() {
        0 => String::new(),
        more => format!(", and {more} more are not"),
    };
    let (line, _) = source.line_and_column(link.at);
    Some(format!(
        "{}:{line}: link `{}`: its mesh {mesh} is not there{more}; meshes have no part in stiffness",
        source.name, link.name
    ))
}

/// Where a mesh may lie.
fn candidates(folder: &Path, mesh: &str) -> Box<dyn Iterator<Item = PathBuf>> {
    let packaged = ["package://", "model://"]
        .iter()
        .find_map(|scheme| mesh.strip_prefix(scheme));
    if let Some(inside) = packaged {
        let inside = inside.to_owned();
        let above: Vec<PathBuf> = folder.ancestors().map(Path::to_owned).collect();
        return Box::new(above.into_iter().map(move |folder| folder.join(&inside)));
    }
    let plain = mesh.strip_prefix("file://").unwrap_or(mesh);
    Box::new(std::iter::once(folder.join(plain)))
}
