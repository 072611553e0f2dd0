//! Three-dimensional beam finite elements: small structures of straight two-node members, solved exactly.
//!
//! Contains nodes, elements, supports, hinges and loads; does not depend on robots, poses or fitting factors. A [`Structure`] is
//! described once and may be moved and re-rated in place; a [`Solver`] holds all that depends on its topology alone
//! (numbering, sparsity, symbolic factorisation) and every buffer, so that solving the next pose allocates nothing. `reduction` gives
//! the compliance of the end and its derivatives, and nothing else, for several poses in SIMD registers, a hundred times faster.
//!
//! Decision. An element is not a 12 × 12 matrix here but its six natural strains (elongation, twist, and for each plane of
//! bending the antisymmetric and symmetric end rotation), each with one stiffness: the paper's eqs. (18), (29) and (30) become
//! one sum of dyads. Price: the matrix of the textbook appears only in a test. Gain: element forces, energies, reactions,
//! derivatives to every section constant, pins and compliant joints all come from the same twelve columns, and the printed
//! rotation errors of eqs. (22) and (27) have nowhere to enter.

mod closed_loops;
mod clusters;
mod compliance;
mod digits;
mod element;
mod gradient;
mod influence;
mod load_stiffness;
mod ordering;
mod parts;
mod reduction;
mod response;
mod rotation;
mod section;
mod self_weight;
mod solve;
mod struts;
mod topology;

pub use compliance::{Compliance6, ComplianceGradient};
pub use element::{Attachment, Element, NaturalStiffness, STRAINS};
pub(crate) use gradient::ParameterPlaces;
pub use influence::RotationInfluence;
pub use parts::{Freedom, Hinge, Node, RigidMember, Structure, StructureError, Strut, Support};
pub(crate) use reduction::{GroupGradient, Placed, PlacedStrut, Reducer, Reduction, WholeGradient};
pub use reduction::{PartMethod, SolutionPath};
pub use response::{EndForces, Response};
pub use rotation::LocalAxes;
pub use section::{Material, Property, Section, ShearCoefficients};
pub use self_weight::LoadAt;
pub use solve::Solver;
