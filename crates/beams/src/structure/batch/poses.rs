//! Poses in bundles, and which system solves each of them.

use pulp::Simd;

use super::ElementRole;
use super::bundle::{Bundle, Prepare, Results};
use super::plan::Plan;
use super::rigidity::{NominalElement, Rigidity};
use super::solve::{Differentiate, Factorise, System};
use crate::structure::compliance::Compliance6;
use crate::structure::parts::Structure;
use stiffbench_numeric::lanes::{Lane, run};

/// A batch whose number of lanes is not named.
pub(super) trait Lanes: std::fmt::Debug + Send {
    fn place(&mut self, pose: usize, structure: &Structure);
    fn differentiate_along(&mut self, pose: usize, units: &[[f64; 3]; 3]);
    fn solve(&mut self, multipliers: &[[f64; 4]], derivatives: bool);
    fn is_solved(&self, pose: usize) -> bool;
    fn compliance(&self, pose: usize) -> Compliance6;
    fn direct_compliance(&self, pose: usize, axis: usize) -> f64;
    fn derivatives(&self, pose: usize, axis: usize, group: usize) -> [f64; 4];
}

/// Poses in bundles as wide as a lane, which share the memory of the matrices.
#[derive(Debug)]
pub(super) struct Batch<S: Simd> {
    simd: S,
    nominal: Vec<NominalElement>,
    rigidities: Vec<Rigidity>,
    /// An element of the main plane.
    reference: usize,
    bundles: Vec<Bundle<S>>,
    /// For poses in which the elements of the main plane lie in it.
    in_plane: System<S>,
    /// For all others: every element couples everything.
    general: System<S>,
    /// Results of the general system in a bundle that needs both.
    general_results: Results<S>,
}

impl<S: Simd> Batch<S> {
    pub(super) fn new(
        simd: S,
        structure: &Structure,
        roles: &[ElementRole],
        pose_count: usize,
    ) -> Self {
        let groups = roles.iter().map(|role| role.group + 1).max().unwrap_or(0);
        let reference = main_plane(roles);
        let in_plane: Vec<bool> = roles
            .iter()
            .map(|role| role.plane == roles[reference].plane)
            .collect();
        Self {
            simd,
            nominal: structure
                .elements
                .iter()
                .zip(roles)
                .map(|(element, role)| NominalElement::of(element, role.group))
                .collect(),
            rigidities: Vec::with_capacity(roles.len()),
            reference,
            bundles: vec![
                Bundle::new(simd, structure, groups);
                pose_count.div_ceil(Lane::<S>::COUNT)
            ],
            in_plane: System::new(simd, Plan::of(structure, &in_plane)),
            general: System::new(simd, Plan::of(structure, &vec![false; roles.len()])),
            general_results: Results::new(simd, groups),
        }
    }

    /// Multiplies the section constants; tells whether all can be used.
    fn rate(&mut self, multipliers: &[[f64; 4]]) -> bool {
        self.rigidities.clear();
        self.rigidities.extend(
            self.nominal
                .iter()
                .map_while(|element| element.scaled(&multipliers[element.group])),
        );
        self.rigidities.len() == self.nominal.len()
    }

    fn solve_bundle(&mut self, index: usize, derivatives: bool) {
        let bundle = &mut self.bundles[index];
        if !bundle.prepared {
            run(
                self.simd,
                Prepare {
                    plan: &self.in_plane.plan,
                    reference: self.reference,
                    bundle,
                },
            );
        }
        let needs = |in_plane: bool| {
            (0..Lane::<S>::COUNT)
                .any(|lane| bundle.placed[lane] && bundle.is_in_plane(lane) == in_plane)
        };
        // Each pose is solved the way it would be alone, whatever stands beside it.
        let (needs_in_plane, needs_general) = (needs(true), needs(false));
        for (needed, system) in [
            (needs_general, &mut self.general),
            (needs_in_plane, &mut self.in_plane),
        ] {
            if !needed {
                continue;
            }
            bundle.clear();
            run(
                self.simd,
                Factorise {
                    system,
                    rigidities: &self.rigidities,
                    bundle,
                },
            );
            if derivatives {
                run(
                    self.simd,
                    Differentiate {
                        system,
                        rigidities: &self.rigidities,
                        bundle,
                    },
                );
            }
            if needs_in_plane && needs_general {
                std::mem::swap(&mut bundle.results, &mut self.general_results);
            }
        }
        if needs_in_plane && needs_general {
            // Two swaps: the bundle has the general results now, the spare ones are those in the plane.
            for lane in 0..Lane::<S>::COUNT {
                if bundle.is_in_plane(lane) {
                    bundle.results.copy_lane(&self.general_results, lane);
                }
            }
        }
    }
}

/// An element of the plane that most elements share; of several the first.
fn main_plane(roles: &[ElementRole]) -> usize {
    let count = |plane: usize| roles.iter().filter(|role| role.plane == plane).count();
    let mut main = 0;
    for (index, role) in roles.iter().enumerate() {
        if count(role.plane) > count(roles[main].plane) {
            main = index;
        }
    }
    main
}

impl<S: Simd> Lanes for Batch<S> {
    fn place(&mut self, pose: usize, structure: &Structure) {
        self.bundles[pose / Lane::<S>::COUNT].place(pose % Lane::<S>::COUNT, structure);
    }

    fn differentiate_along(&mut self, pose: usize, units: &[[f64; 3]; 3]) {
        let toward = &mut self.bundles[pose / Lane::<S>::COUNT].toward;
        for (toward, unit) in toward.iter_mut().flatten().zip(units.iter().flatten()) {
            toward.set(pose % Lane::<S>::COUNT, *unit);
        }
    }

    fn solve(&mut self, multipliers: &[[f64; 4]], derivatives: bool) {
        let rated = self.rate(multipliers);
        for index in 0..self.bundles.len() {
            if !self.bundles[index].placed.contains(&true) {
                continue;
            }
            if rated {
                self.solve_bundle(index, derivatives);
            } else {
                self.bundles[index].results.faults = Lane::one(self.simd);
            }
        }
    }

    fn is_solved(&self, pose: usize) -> bool {
        let bundle = &self.bundles[pose / Lane::<S>::COUNT];
        bundle.placed[pose % Lane::<S>::COUNT]
            && bundle.results.faults.get(pose % Lane::<S>::COUNT) == 0.0
    }

    fn compliance(&self, pose: usize) -> Compliance6 {
        let compliance = &self.bundles[pose / Lane::<S>::COUNT].results.compliance;
        Compliance6(compliance.map(|row| row.map(|entry| entry.get(pose % Lane::<S>::COUNT))))
    }

    fn direct_compliance(&self, pose: usize, axis: usize) -> f64 {
        self.bundles[pose / Lane::<S>::COUNT].results.compliance[axis][axis]
            .get(pose % Lane::<S>::COUNT)
    }

    fn derivatives(&self, pose: usize, axis: usize, group: usize) -> [f64; 4] {
        let derivatives = &self.bundles[pose / Lane::<S>::COUNT].results.derivatives;
        derivatives.get(group).map_or([0.0; 4], |of_group| {
            of_group[axis].map(|entry| entry.get(pose % Lane::<S>::COUNT))
        })
    }
}
