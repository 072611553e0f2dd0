//! Displacements, element forces and reactions under any loads.

use stiffbench_numeric::vector::{cross, subtract};

use super::element::STRAINS;
use super::parts::{Structure, Support};
use super::rotation::LocalAxes;
use super::self_weight::LoadAt;
use super::solve::Solver;

/// What a load case does to a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Displacement of each node: ux, uy, uz (m), rx, ry, rz (rad), global.
    pub nodes: Vec<[f64; 6]>,
    /// Twist of each hinge, rad.
    pub hinges_rad: Vec<f64>,
    /// Forces on the two ends of each element.
    pub elements: Vec<EndForces>,
    /// Force and moment of each support on the structure: Fx, Fy, Fz (N), Mx, My, Mz (N·m), global; zero in freedoms that are not
    /// held.
    pub reactions: Vec<[f64; 6]>,
}

/// Forces that the nodes exert on the two ends of an element, in its local axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndForces {
    /// Fx, Fy, Fz (N), Mx, My, Mz (N·m) at the first end.
    pub first: [f64; 6],
    /// The same at the second end.
    pub second: [f64; 6],
}

impl Solver {
    /// Displacements, element forces and reactions under any loads (force and moment where they act).
    ///
    /// Call [`Solver::update`] first; `structure` is the one given there.
    #[must_use]
    pub fn respond(&mut self, structure: &Structure, loads: &[LoadAt]) -> Response {
        self.solve_loads(loads);
        let elements: Vec<EndForces> = (0..self.topology.elements.len())
            .map(|element| {
                let strains = self.strains(element, 0);
                let stiffness = &self.natural[element].stiffness;
                end_forces(
                    std::array::from_fn(|m| stiffness[m] * strains[m]),
                    self.lengths_m[element],
                )
            })
            .collect();
        Response {
            nodes: (0..self.topology.node_count)
                .map(|node| std::array::from_fn(|component| self.read(node, component, 0)))
                .collect(),
            hinges_rad: self
                .topology
                .hinge_equations
                .iter()
                .map(|&e| self.solution[e])
                .collect(),
            reactions: self.reactions(structure, loads, &elements),
            elements,
        }
    }

    /// What the supports must add to balance element ends and loads on all that moves with their nodes; of a rigid body with several
    /// supports the first has it all.
    fn reactions(
        &self,
        structure: &Structure,
        loads: &[LoadAt],
        forces: &[EndForces],
    ) -> Vec<[f64; 6]> {
        let clusters = &self.topology.clusters;
        let reaction = |support: &Support| {
            let mut sum = [0.0; 6];
            let support_m = structure.nodes[support.node].position_m;
            let mut add = |vertex: usize, wrench: [f64; 6], sign: f64| {
                if clusters.root(vertex) != support.node {
                    return;
                }
                let [fx, fy, fz, mx, my, mz] = wrench;
                let node = clusters.vertices[vertex].node;
                let arm = subtract(structure.nodes[node].position_m, support_m);
                let moment = cross(arm, [fx, fy, fz]);
                let whole = [fx, fy, fz, mx + moment[0], my + moment[1], mz + moment[2]];
                for (component, value) in sum.iter_mut().zip(whole) {
                    *component += sign * value;
                }
            };
            for (place, map) in self.topology.elements.iter().enumerate() {
                let ends = [forces[place].first, forces[place].second];
                for (vertex, local) in map.vertices.into_iter().zip(ends) {
                    let mut wrench = [0.0; 6];
                    add_global(&mut wrench, &self.axes[place], local);
                    add(vertex, wrench, 1.0);
                }
            }
            for (at, load) in loads {
                if let Some(vertex) = clusters.vertex(at) {
                    add(vertex, *load, -1.0);
                }
            }
            std::array::from_fn(|i| if support.held[i] { sum[i] } else { 0.0 })
        };
        structure.supports.iter().map(reaction).collect()
    }
}

/// End forces from the natural forces: the transpose of the strain definitions.
fn end_forces([n, t, my, qy, mz, qz]: [f64; STRAINS], length_m: f64) -> EndForces {
    let chord = 2.0 / length_m;
    EndForces {
        first: [-n, chord * qz, -chord * qy, -t, my + qy, mz + qz],
        second: [n, -chord * qz, chord * qy, t, qy - my, qz - mz],
    }
}

/// Adds local forces and moments, turned to global axes.
fn add_global(sum: &mut [f64; 6], axes: &LocalAxes, local: [f64; 6]) {
    for i in 0..3 {
        sum[i] += axes.x[i] * local[0] + axes.y[i] * local[1] + axes.z[i] * local[2];
        sum[3 + i] += axes.x[i] * local[3] + axes.y[i] * local[4] + axes.z[i] * local[5];
    }
}
