//! What a mechanism weighs, and where its weight acts.
//!
//! Decision. Fitting factors change how a member yields, not what it weighs: the mass of a member is its section's mass per length, or
//! density times nominal area, times the distance of its nodes. The elastic structure is the one of every other load.

use crate::structure::LoadAt;
use stiffbench_numeric::vector::{norm, scale, subtract};

use super::Robot;
use super::mechanism::Mechanism;
use super::members::MechanismModel;

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
        let there = robot.node_masses.iter().filter(|(node, _)| is_there(*node));
        found.at_nodes = there
            .map(|&(node, mass_kg)| (robot.nodes[node].name.to_string(), mass_kg))
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

    /// Mass of all that has one, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let elements = self.masses_kg_per_m().enumerate();
        let members: f64 = elements.map(|(i, mass)| mass * self.length_m(i)).sum();
        members + self.point_masses().map(|(_, mass)| mass).sum::<f64>()
    }

    /// Loads of the weight of all that has a mass, where the model stands.
    #[must_use]
    pub fn weight(&self) -> Vec<LoadAt> {
        let down = scale(self.robot().vertical, -GRAVITY_M_PER_S2);
        let mut loads = Vec::new();
        for (element, mass) in self.masses_kg_per_m().enumerate() {
            if mass > 0.0 {
                loads.extend(self.structure().spread_force(element, scale(down, mass)));
            }
        }
        for (node, mass) in self.point_masses() {
            let [fx, fy, fz] = scale(down, mass);
            loads.push((node.into(), [fx, fy, fz, 0.0, 0.0, 0.0]));
        }
        loads
    }

    /// Node of the structure and mass, kg, of each point mass that the mechanism carries.
    fn point_masses(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let place = |node: usize| self.nodes().iter().position(|known| *known == node);
        let masses = self.robot().node_masses.iter();
        masses.filter_map(move |&(node, mass_kg)| Some((place(node)?, mass_kg)))
    }
}
