//! A structure of beams as a structure of solids.
//!
//! Every member becomes a prism from node to node. All faces that meet at a node, and the node, move as one rigid body: the joint is
//! bonded and has no eccentricity, as in the beam model. Prisms overlap in space near a joint and know nothing of each other there.

use stiffbench_beams::structure::{LocalAxes, Structure};

use super::error::ReferenceError;
use super::mesh::mesh;
use super::prism::Prism;

/// Poisson's ratios that an isotropic solid may have: below zero is no metal, near a half a displacement mesh locks.
const POISSON: std::ops::Range<f64> = 0.0..0.49;

/// Elements above which a model is refused: on an ordinary machine CalculiX's direct solver runs out of memory long before.
const MOST_ELEMENTS: f64 = 2.0e6;

/// A member as a prism.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidMember {
    /// Name in the robot file.
    pub name: String,
    /// Length, m.
    pub length_m: f64,
    /// The prism.
    pub prism: Prism,
    /// Torsion constant of the section in the robot file, m⁴.
    pub wanted_j_m4: f64,
    /// Torsion constant that acts, m⁴.
    pub acting_j_m4: f64,
    /// Elements of the mesh.
    pub elements: usize,
}

/// Nodes of the mesh that move with a node of the structure.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RigidNode {
    /// Name in the robot file.
    pub(super) name: String,
    /// Position, m.
    pub(super) position_m: [f64; 3],
    /// Held.
    pub(super) fixed: bool,
    /// Nodes of the mesh, from 0.
    pub(super) faces: Vec<usize>,
}

/// Elements of one member among all.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SolidElements {
    /// Young's modulus that acts, Pa.
    pub(super) youngs_modulus_pa: f64,
    /// Poisson's ratio.
    pub(super) poisson: f64,
    /// Nodes of each element, from 0.
    pub(super) elements: Vec<[usize; 20]>,
}

/// A structure of solids, meshed.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidModel {
    /// The members, in the order of the structure.
    pub members: Vec<SolidMember>,
    pub(super) solids: Vec<SolidElements>,
    pub(super) nodes_m: Vec<[f64; 3]>,
    pub(super) joints: Vec<RigidNode>,
    pub(super) end: usize,
}

impl SolidModel {
    /// Meshes a structure; `names` are those of its elements, `size_m` the longest side of a solid element.
    ///
    /// # Errors
    /// [`ReferenceError`] if a size, length or material cannot be meshed, or a joint turns: the solids are bonded.
    pub fn new(structure: &Structure, names: &[&str], size_m: f64) -> Result<Self, ReferenceError> {
        if !(size_m.is_finite() && size_m > 0.0) {
            return Err(ReferenceError::Size { size_m });
        }
        let turning = structure.hinges.first();
        if let Some(hinge) = turning {
            let joint = hinge.name.to_string();
            return Err(ReferenceError::Turns { joint });
        }
        let mut model = Self {
            members: Vec::new(),
            solids: Vec::new(),
            nodes_m: Vec::new(),
            joints: rigid_nodes(structure)?,
            end: structure.end.node,
        };
        for (place, name) in names.iter().enumerate() {
            model.add(structure, place, name, size_m)?;
        }
        Ok(model)
    }

    /// Adds one member.
    fn add(
        &mut self,
        structure: &Structure,
        place: usize,
        name: &str,
        size_m: f64,
    ) -> Result<(), ReferenceError> {
        let element = &structure.elements[place];
        let ends = [0, 1].map(|end| element.ends[end].node);
        let [start, stop] = ends.map(|node| structure.nodes[node].position_m);
        let span = [0, 1, 2].map(|i| stop[i] - start[i]);
        let (axes, length_m) =
            LocalAxes::along(span, element.toward_y).ok_or_else(|| ReferenceError::NoLength {
                member: name.to_owned(),
            })?;
        let material = element.material;
        let poisson = material.youngs_modulus_pa / (2.0 * material.shear_modulus_pa) - 1.0;
        if !POISSON.contains(&poisson) {
            let member = name.to_owned();
            return Err(ReferenceError::Poisson { member, poisson });
        }
        let prism = Prism::of(&element.section);
        let expected = length_m * prism.side_y_m * prism.side_z_m / size_m.powi(3);
        if expected > MOST_ELEMENTS {
            let member = name.to_owned();
            return Err(ReferenceError::TooFine { member, size_m });
        }
        let mesh = mesh(&prism, length_m, size_m);
        let first = self.nodes_m.len();
        let global = |local: &[f64; 3]| {
            [0, 1, 2].map(|i| {
                start[i] + local[0] * axes.x[i] + local[1] * axes.y[i] + local[2] * axes.z[i]
            })
        };
        self.nodes_m.extend(mesh.nodes_m.iter().map(global));
        for (node, face) in ends.into_iter().zip(mesh.faces) {
            let faces = &mut self.joints[node].faces;
            faces.extend(face.into_iter().map(|number| first + number));
        }
        self.members.push(SolidMember {
            name: name.to_owned(),
            length_m,
            prism,
            wanted_j_m4: element.section.j_m4,
            acting_j_m4: prism.section().j_m4,
            elements: mesh.elements.len(),
        });
        let shifted = |element: [usize; 20]| element.map(|number| first + number);
        self.solids.push(SolidElements {
            youngs_modulus_pa: material.youngs_modulus_pa * prism.modulus_scale,
            poisson,
            elements: mesh.elements.into_iter().map(shifted).collect(),
        });
        Ok(())
    }

    /// Solid elements.
    #[must_use]
    pub fn elements(&self) -> usize {
        self.solids.iter().map(|solid| solid.elements.len()).sum()
    }

    /// Nodes of the mesh, without those that joints move by.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.nodes_m.len()
    }
}

/// The nodes of a structure, held or free.
fn rigid_nodes(structure: &Structure) -> Result<Vec<RigidNode>, ReferenceError> {
    let mut joints: Vec<RigidNode> = structure
        .nodes
        .iter()
        .map(|node| RigidNode {
            name: node.name.to_string(),
            position_m: node.position_m,
            fixed: false,
            faces: Vec::new(),
        })
        .collect();
    for support in &structure.supports {
        let joint = &mut joints[support.node];
        if support.held != [true; 6] {
            let node = joint.name.clone();
            return Err(ReferenceError::PartlyHeld { node });
        }
        joint.fixed = true;
    }
    Ok(joints)
}

/// The same structure with the constants that the prisms have: beams that solids can be compared with.
///
/// With shear, and with the warping of narrow rectangles held at both ends, as the rigid faces hold it: both are in the solids.
#[must_use]
pub fn beams_of_the_prisms(structure: &Structure) -> Structure {
    let mut beams = structure.clone();
    for element in &mut beams.elements {
        let prism = Prism::of(&element.section);
        let [start, stop] = [0, 1].map(|end| structure.nodes[element.ends[end].node].position_m);
        let length_m = [0, 1, 2].map(|i| stop[i] - start[i]);
        let length_m = length_m.iter().map(|c| c * c).sum::<f64>().sqrt();
        let modulus_ratio = element.material.youngs_modulus_pa / element.material.shear_modulus_pa;
        element.section = prism.section();
        element.section.j_m4 *= prism.warping_stiffening(length_m, modulus_ratio);
        element.shear = Some(prism.shear());
    }
    beams
}
