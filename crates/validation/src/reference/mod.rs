//! The reference that nothing was fitted to: a structure of beams written as solids for CalculiX, and its answer read back.
//!
//! [`SolidModel`] meshes, writes the files and knows what differs from the beams; [`end_displacement_m`] reads the answer;
//! [`ReferenceModel`] and [`ReferenceRecord`] are what is kept of both. Runs no program and opens no file.
//!
//! Decision. Solid elements, because CalculiX's own beams are expanded to solids with rigid knots and were wrong by half on a frame like
//! these; hexahedra of twenty nodes, because a prism needs no mesher and few of them. Rigid faces at the joints restrain warping and the
//! contraction of the section, so that short members come out a little stiffer than beams with shear.

mod answer;
mod deck;
mod error;
mod mesh;
mod model;
mod prism;
mod record;

pub use answer::end_displacement_m;
pub use error::ReferenceError;
pub use model::{SolidMember, SolidModel, beams_of_the_prisms};
pub use prism::Prism;
pub use record::{PoseModel, ReferenceCell, ReferenceLoad, ReferenceModel, ReferenceRecord, RunBy};
