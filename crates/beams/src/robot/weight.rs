//! What a mechanism weighs, and where its weight acts.
//!
//! Decision. Fitting factors change how a member yields, not what it weighs: the mass of a member is its section's mass per length, or
//! density times nominal area, times the distance of its nodes. The elastic structure is the one of every other load.

use super::carried_masses::MassPoint;
use crate::structure::{Attachment, LoadAt};
use stiffbench_numeric::vector::{cross, norm, scale, subtract};

use super::Robot;
use super::loads::{BodyPoint, MassPlace};
use super::members::MechanismModel;
use super::model::Mechanism;

/// Standard acceleration of free fall, m/s² (3rd General Conference on Weights and Measures, 1901).
pub const GRAVITY_M_PER_S2: f64 = 9.806_65;

/// What is known of the masses of a mechanism.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Masses {
    /// Names of sections of its members that have a mass.
    pub weighed: Vec<String>,
    /// Names of sections of its members that have none.
    pub unweighed: Vec<String>,
    /// Masses at its nodes, kg, with the node's name.
    pub at_nodes: Vec<(String, f64)>,
}

impl Masses {
    /// Of a mechanism, in the order of the file.
    #[must_use]
    pub fn of(robot: &Robot, mechanism: &Mechanism) -> Self {
        let mut found = Self::default();
        for (place, (name, section)) in robot.sections.iter().enumerate() {
            let mut members = mechanism.members.iter();
            if members.any(|&member| robot.members[member].section == place) {
                match section.mass_kg_per_m {
                    Some(_) => found.weighed.push(name.clone()),
                    None => found.unweighed.push(name.clone()),
                }
            }
        }
        let is_there = |node: usize| {
            let mut members = mechanism.members.iter();
            members.any(|&member| robot.members[member].nodes.contains(&node))
        };
        let there = robot.masses.iter().filter(|mass| match mass.place {
            MassPlace::Node(node) => is_there(node),
            MassPlace::Point(_) => true,
        });
        found.at_nodes = there
            .map(|mass| (mass.name.clone(), mass.mass_kg))
            .collect();
        found
    }

    /// Whether nothing of the mechanism has a mass.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.weighed.is_empty() && self.at_nodes.is_empty()
    }
}

impl MechanismModel<'_> {
    /// Length of an element where the model stands, m.
    fn length_m(&self, element: usize) -> f64 {
        let [first, second] = [0, 1].map(|end: usize| {
            let structure = self.structure();
            structure.nodes[structure.elements[element].ends[end].node].position_m
        });
        norm(subtract(second, first))
    }

    /// Mass per length of each element, kg/m; zero where none is known.
    fn masses_kg_per_m(&self) -> impl Iterator<Item = f64> + '_ {
        let sections = &self.robot().sections;
        self.members()
            .map(|member| sections[member.section].mass_kg_per_m.unwrap_or(0.0))
    }

    /// Each mass that is not that of a member: where it hangs on the structure, its body, kg, and where its centre is, m.
    pub fn point_masses(&self) -> impl Iterator<Item = (&Attachment, usize, f64, [f64; 3])> {
        let masses = self.carried_masses().iter();
        masses.map(|mass| {
            let centre_m = self.point_of(&mass.point);
            (&mass.at, mass.body, mass.mass_kg, centre_m)
        })
    }

    /// Mass of all that has one, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let elements = self.masses_kg_per_m().enumerate();
        let members: f64 = elements.map(|(i, mass)| mass * self.length_m(i)).sum();
        members
            + self
                .carried_masses()
                .iter()
                .map(|mass| mass.mass_kg)
                .sum::<f64>()
    }

    /// Loads of the weight of all that has a mass, and of the balancers, where the model stands.
    #[must_use]
    pub fn weight(&self) -> Vec<LoadAt> {
        let down = scale(self.robot().vertical, -GRAVITY_M_PER_S2);
        let mut loads = Vec::new();
        for (element, mass) in self.masses_kg_per_m().enumerate() {
            if mass > 0.0 {
                loads.extend(self.structure().spread_force(element, scale(down, mass)));
            }
        }
        for mass in self.carried_masses() {
            let force_n = scale(down, mass.mass_kg);
            loads.push(self.force_at(&mass.at, self.point_of(&mass.point), force_n));
        }
        for strut in &self.structure().struts {
            let [first, second] = strut.points_m;
            let span_m = subtract(second, first);
            let pull = scale(span_m, strut.force_n / norm(span_m));
            for (at, (point_m, sign)) in strut.ends.iter().zip([(first, 1.0), (second, -1.0)]) {
                if let Some(at) = at {
                    loads.push(self.force_at(at, point_m, scale(pull, sign)));
                }
            }
        }
        loads
    }

    /// A force at a point that moves with an attachment, as force and moment there.
    fn force_at(&self, at: &Attachment, point_m: [f64; 3], force_n: [f64; 3]) -> LoadAt {
        let node_m = self.structure().nodes[at.node].position_m;
        let [fx, fy, fz] = force_n;
        let [mx, my, mz] = cross(subtract(point_m, node_m), force_n);
        (at.clone(), [fx, fy, fz, mx, my, mz])
    }

    fn body_point_m(&self, point: &BodyPoint) -> [f64; 3] {
        self.placement().point_m(point.body, &point.at_m)
    }

    /// Where a mass is in the pose, m.
    fn point_of(&self, point: &MassPoint) -> [f64; 3] {
        match point {
            MassPoint::Node(node) => self.structure().nodes[*node].position_m,
            MassPoint::OfBody(point) => self.body_point_m(point),
            MassPoint::OfTool(at_m) => {
                let structure = self.structure();
                let end_m = structure.nodes[structure.end.node].position_m;
                let axes = self.tool_axes();
                std::array::from_fn(|i| {
                    end_m[i] + (0..3).map(|k| axes[k][i] * at_m[k]).sum::<f64>()
                })
            }
        }
    }
}
