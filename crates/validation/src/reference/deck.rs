//! A structure of solids as text for CalculiX.
//!
//! Units are mm, N and MPa (N/mm²), in which CalculiX, having none, gives displacements in mm. One file holds mesh, materials and joints
//! of a pose, and each case of load is a short file that includes it: a case can be run, timed and repeated by itself.
//!
//! A joint is `*RIGID BODY` with two nodes of its own: the first carries the displacements of the body, the second its rotations as if
//! they were displacements.

use std::fmt::Write;

use super::model::{RigidNode, SolidModel};

const MM_PER_M: f64 = 1e3;
const PA_PER_MPA: f64 = 1e6;

/// Numbers on a line of a set or a long element: CalculiX reads at most sixteen.
const NUMBERS_A_LINE: usize = 12;

/// Name of the set that holds the end's node.
pub(super) const END_SET: &str = "ENDNODE";

impl SolidModel {
    /// Mesh, materials, joints and supports as a CalculiX file; the lines of `about` go on top as comments.
    #[must_use]
    pub fn deck(&self, about: &[String]) -> String {
        let mut text = String::new();
        for line in about {
            let _ = writeln!(text, "** {line}");
        }
        text.push_str("** Units: mm, N, MPa.\n");
        self.write_nodes(&mut text);
        self.write_members(&mut text);
        for joint in 0..self.joints.len() {
            self.write_joint(&mut text, joint);
        }
        let _ = writeln!(
            text,
            "*NSET, NSET={END_SET}\n{}",
            self.moving_node(self.end)
        );
        text
    }

    /// One case of load on the model of `deck_file`: a force at the end along a global axis.
    #[must_use]
    pub fn case(&self, deck_file: &str, axis: usize, force_n: f64, large: bool) -> String {
        let end = self.moving_node(self.end);
        let step = if large { "*STEP, NLGEOM" } else { "*STEP" };
        format!(
            "** {force_n} N at node {} along {}\n*INCLUDE, INPUT={deck_file}\n{step}\n*STATIC\n*CLOAD\n{end}, {}, {force_n}\n*NODE PRINT, NSET={END_SET}\nU\n*END STEP\n",
            self.joints[self.end].name,
            ["x", "y", "z"][axis],
            axis + 1,
        )
    }

    /// Number in the file of the node that carries the displacements of a joint; the next one carries its rotations.
    fn moving_node(&self, joint: usize) -> usize {
        self.nodes_m.len() + 1 + 2 * joint
    }

    fn write_nodes(&self, text: &mut String) {
        text.push_str("*NODE\n");
        let of_joints = self.joints.iter().flat_map(|joint| [joint.position_m; 2]);
        for (place, position_m) in self.nodes_m.iter().copied().chain(of_joints).enumerate() {
            // CalculiX reads twenty characters of a number; 1e-6 mm is beyond its single-precision output.
            let [x, y, z] = position_m.map(|c| MM_PER_M * c);
            let _ = writeln!(text, "{}, {x:.6}, {y:.6}, {z:.6}", place + 1);
        }
    }

    fn write_members(&self, text: &mut String) {
        let mut number = 0;
        for (place, (member, solid)) in self.members.iter().zip(&self.solids).enumerate() {
            let set = place + 1;
            let _ = writeln!(
                text,
                "** member {}\n*ELEMENT, TYPE=C3D20R, ELSET=M{set}",
                member.name
            );
            for element in &solid.elements {
                number += 1;
                let mut numbers = vec![number];
                numbers.extend(element.iter().map(|node| node + 1));
                write_numbers(text, &numbers, true);
            }
            let young = solid.youngs_modulus_pa / PA_PER_MPA;
            let poisson = solid.poisson;
            let _ = writeln!(
                text,
                "*MATERIAL, NAME=MAT{set}\n*ELASTIC\n{young:.10e}, {poisson:.10}\n*SOLID SECTION, ELSET=M{set}, MATERIAL=MAT{set}"
            );
        }
    }

    fn write_joint(&self, text: &mut String, joint: usize) {
        let RigidNode {
            name, fixed, faces, ..
        } = &self.joints[joint];
        let (set, moving) = (joint + 1, self.moving_node(joint));
        let turning = moving + 1;
        let _ = writeln!(text, "** node {name}\n*NSET, NSET=J{set}");
        let numbers: Vec<usize> = faces.iter().map(|node| node + 1).collect();
        write_numbers(text, &numbers, false);
        let _ = writeln!(
            text,
            "*RIGID BODY, NSET=J{set}, REF NODE={moving}, ROT NODE={turning}"
        );
        if *fixed {
            let _ = writeln!(text, "*BOUNDARY\n{moving}, 1, 3\n{turning}, 1, 3");
        }
    }
}

/// Numbers with commas between; a line that is continued ends in a comma if they are `one` entry.
fn write_numbers(text: &mut String, numbers: &[usize], one: bool) {
    let lines = numbers.chunks(NUMBERS_A_LINE);
    let last = lines.len();
    for (place, line) in lines.enumerate() {
        let words: Vec<String> = line.iter().map(ToString::to_string).collect();
        let end = if one && place + 1 < last { "," } else { "" };
        let _ = writeln!(text, "{}{end}", words.join(", "));
    }
}
