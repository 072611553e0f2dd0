//! A structure where it stands in several poses at once, and what its reduction gives.

use pulp::Simd;

use super::block::Block;
use stiffbench_numeric::simd::{Aligned, Lane};

/// Where a structure stands in as many poses as a lane holds.
#[derive(Debug, Clone)]
pub(crate) struct Placed<S: Simd> {
    /// Position of each node, m.
    pub(crate) nodes_m: Vec<Aligned<[Lane<S>; 3]>>,
    /// Unit normal of each plane.
    pub(crate) normals: Vec<Aligned<[Lane<S>; 3]>>,
    pub(crate) struts: Vec<PlacedStrut<S>>,
    /// Above zero in poses that could not be placed.
    pub(crate) faults: Lane<S>,
}

impl<S: Simd> Placed<S> {
    pub(crate) fn new(simd: S, node_count: usize, plane_count: usize) -> Self {
        let zero = Lane::zero(simd);
        Self {
            nodes_m: vec![Aligned([zero; 3]); node_count],
            normals: vec![Aligned([zero; 3]); plane_count],
            struts: Vec::new(),
            faults: Lane::one(simd),
        }
    }
}

/// What a solution leaves.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct Results<S: Simd> {
    /// Compliance of the end over ux uy uz rx ry rz, SI; symmetric.
    pub(crate) compliance: Block<S, 6>,
    /// Above zero in poses without a solution.
    pub(crate) faults: Lane<S>,
}

/// A strut as it is in as many poses as a lane holds.
#[derive(Debug, Clone)]
pub(crate) struct PlacedStrut<S: Simd> {
    /// Its two points, m.
    pub(crate) points_m: [[Lane<S>; 3]; 2],
    /// Its force, N; above zero it pulls its points together.
    pub(crate) force_n: Lane<S>,
    /// Derivative of the force to the distance of the points, N/m.
    pub(crate) stiffness_n_per_m: Lane<S>,
}

impl<S: Simd> PlacedStrut<S> {
    pub(crate) fn new(zero: Lane<S>) -> Self {
        Self {
            points_m: [[zero; 3]; 2],
            force_n: zero,
            stiffness_n_per_m: zero,
        }
    }
}
