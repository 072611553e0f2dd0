//! Points and triangles with numbers on them as an unstructured grid of the Visualization Toolkit (`.vtu`), which ParaView opens.
//!
//! XML with the arrays in base64, each after its length in bytes as the format has it: exact, and half as long as text.
//!
//! # Source
//! VTK File Formats, Kitware (XML formats, serial UnstructuredGrid).

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Places of the points of a mesh, m.
pub type MeshPoints = [[f64; 3]];

/// Numbers at the points of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshField {
    /// Name, with the unit.
    pub name: String,
    /// Numbers a point: 1, or 3 for a vector.
    pub components: usize,
    /// Point after point.
    pub values: Vec<f64>,
}

/// Cell types of VTK.
const VERTEX: u8 = 1;
/// See [`VERTEX`].
const TRIANGLE: u8 = 5;

/// The mesh as a file; without triangles every point is a cell of its own, so that something is drawn.
#[must_use]
pub fn vtu(points: &MeshPoints, triangles: Option<&[[u32; 3]]>, fields: &[MeshField]) -> String {
    let (connectivity, offsets, types): (Vec<i64>, Vec<i64>, Vec<u8>) = match triangles {
        Some(triangles) => (
            triangles
                .iter()
                .flatten()
                .map(|&corner| i64::from(corner))
                .collect(),
            (1..=triangles.len() as i64).map(|cell| 3 * cell).collect(),
            vec![TRIANGLE; triangles.len()],
        ),
        None => (
            (0..points.len() as i64).collect(),
            (1..=points.len() as i64).collect(),
            vec![VERTEX; points.len()],
        ),
    };
    let mut text = "<?xml version=\"1.0\"?>\n\
        <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
        <UnstructuredGrid>\n"
        .to_owned();
    let _ = writeln!(
        text,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>",
        points.len(),
        types.len()
    );
    for field in fields {
        let bytes = field.values.iter().flat_map(|value| value.to_le_bytes());
        array(
            &mut text,
            "Float64",
            &field.name,
            field.components,
            bytes.collect(),
        );
    }
    text.push_str("</PointData>\n<Points>\n");
    let bytes = points
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes());
    array(&mut text, "Float64", "Points", 3, bytes.collect());
    text.push_str("</Points>\n<Cells>\n");
    for (name, numbers) in [("connectivity", connectivity), ("offsets", offsets)] {
        let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
        array(&mut text, "Int64", name, 1, bytes.collect());
    }
    array(&mut text, "UInt8", "types", 1, types);
    text.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
    text
}

/// One array: the length of its bytes, then the bytes, as one run of base64.
fn array(text: &mut String, kind: &str, name: &str, components: usize, values: Vec<u8>) {
    let name = name
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;");
    // As VTK writes it: scalars without a number of components, which meshio would take for columns.
    let shape = if components == 1 {
        String::new()
    } else {
        format!(" NumberOfComponents=\"{components}\"")
    };
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\"{shape} format=\"binary\">"
    );
    let mut bytes = (values.len() as u64).to_le_bytes().to_vec();
    bytes.extend(values);
    STANDARD.encode_string(&bytes, text);
    text.push_str("\n</DataArray>\n");
}
