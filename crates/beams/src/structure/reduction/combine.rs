//! The compliance of the end from those of the parts.

use pulp::Simd;

use super::block::{Block, add_whole};
use super::placed::{Placed, Results};
use super::solve::SubstructureState;
use super::substructure::Reduction;
use crate::structure::solve::LOST_PIVOT;
use stiffbench_numeric::simd::{Kernel, Lane, Number, cross, dot, subtract};

/// Carries the compliances of the parts to the end and adds them up.
pub(super) struct Combine<'a, S: Simd> {
    pub(super) reduction: &'a Reduction,
    pub(super) placed: &'a Placed<S>,
    pub(super) solutions: &'a [SubstructureState<S>],
    pub(super) results: &'a mut Results<S>,
}

impl<S: Simd> Kernel for Combine<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self {
            reduction, placed, ..
        } = self;
        let end = &placed.nodes_m[reduction.end].0;
        let zero = end[0].of(0.0);
        let mut sum = [[zero; 6]; 6];
        let mut faults = placed.faults;
        for (part, state) in reduction.parts.iter().zip(self.solutions) {
            let compliance = &state.solution.compliance;
            let seen = subtract(&placed.nodes_m[part.origin].0, end);
            if part.origin == reduction.end {
                add_whole(&mut sum, compliance);
            } else {
                add_whole(&mut sum, &carried_to(compliance, &seen));
            }
            faults += state
                .solution
                .worst
                .fault_unless_below(zero.of(1.0 / LOST_PIVOT));
        }
        for &element in &reduction.idle {
            let [first, second] = reduction.ends[element];
            let span = subtract(&placed.nodes_m[second].0, &placed.nodes_m[first].0);
            faults += (-dot(&span, &span)).fault_unless_below(zero);
        }
        // Rigid members may leave nothing that yields along an axis.
        let least = if reduction.has_rigid_members {
            f64::MIN_POSITIVE
        } else {
            0.0
        };
        for i in 0..6 {
            faults += (-sum[i][i]).fault_unless_below(zero.of(least));
            faults += sum[i][i].fault_unless_below(zero.of(f64::INFINITY));
        }
        self.results.compliance = sum;
        self.results.faults = faults;
    }
}

/// A compliance at another point; `seen` is the old one seen from there: a turn r moves it by `seen` × r more.
#[inline(always)]
fn carried_to<S: Simd>(compliance: &Block<S, 6>, seen: &[Lane<S>; 3]) -> Block<S, 6> {
    let mut carried = *compliance;
    // Columns of turns first: each gains m × its turns in its displacements.
    for j in 0..6 {
        let turns = [compliance[3][j], compliance[4][j], compliance[5][j]];
        let gained = cross(seen, &turns);
        for i in 0..3 {
            carried[i][j] = compliance[i][j] + gained[i];
        }
    }
    // Then the same for the rows.
    for i in 0..3 {
        let turns = [carried[i][3], carried[i][4], carried[i][5]];
        let gained = cross(seen, &turns);
        for j in 0..3 {
            carried[i][j] += gained[j];
        }
        for j in 3..6 {
            carried[j][i] = carried[i][j];
        }
    }
    carried
}
