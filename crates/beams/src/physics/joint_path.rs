//! The path of loads as one more joint meets it.

use stiffbench_numeric::simd::widest;

/// The path of loads as one more joint meets it: what every law at that joint has to do with the structure and the laws that are there.
///
/// A joint that turns already gives way a little more: it is taken as linear about where it stands, exact until it meets a kink.
#[derive(Debug, Clone, Default)]
pub struct JointPath {
    /// Moment of the joint at zero twist under each load that is read, N·m.
    driving_nm: Vec<f64>,
    /// Moment against a twist, N·m/rad.
    stiffness_nm_per_rad: Vec<f64>,
    /// Displacement per twist, m/rad.
    lever_m: Vec<f64>,
    /// What came before each load.
    before: Vec<Before>,
}

/// What a joint met before a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Before {
    /// Nothing: it is the first load of a run, the joint is virgin.
    Nothing,
    /// Another load.
    Load,
    /// Another load and a release, which is not read.
    Release(PathStep),
}

/// A load, or a release before one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PathStep {
    pub(super) driving_nm: f64,
    pub(super) stiffness_nm_per_rad: f64,
    pub(super) lever_m: f64,
}

impl JointPath {
    /// What a law without memory adds, m, all loads side by side.
    ///
    /// # Arguments
    /// - `rotation_rad`: the twist from the driving moment and the stiffness against it; always inlined, it is compiled for the widest
    ///   instructions.
    pub(super) fn side_by_side(&self, rotation_rad: impl Fn(f64, f64) -> f64, out: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                let joint = self.driving_nm.iter().zip(&self.stiffness_nm_per_rad);
                let loads = joint.zip(&self.lever_m);
                for (added, ((&driving, &k), lever_m)) in out.iter_mut().zip(loads) {
                    *added = lever_m * rotation_rad(driving, k.max(0.0));
                }
            },
        );
    }

    /// What a law with memory adds, m, load after load.
    ///
    /// # Arguments
    /// - `rotation_rad`: the twist from the driving moment, the stiffness against it and the twist before.
    pub(super) fn in_sequence(&self, rotation_rad: impl Fn(f64, f64, f64) -> f64, out: &mut [f64]) {
        let mut rotation = 0.0;
        let joint = self.driving_nm.iter().zip(&self.stiffness_nm_per_rad);
        let loads = joint.zip(&self.lever_m).zip(&self.before);
        for (added, (((&driving, &k), lever_m), before)) in out.iter_mut().zip(loads) {
            match before {
                Before::Nothing => rotation = 0.0,
                Before::Load => {}
                Before::Release(step) => {
                    let k = step.stiffness_nm_per_rad.max(0.0);
                    rotation = rotation_rad(step.driving_nm, k, rotation);
                }
            }
            rotation = rotation_rad(driving, k.max(0.0), rotation);
            *added = lever_m * rotation;
        }
    }

    pub(super) fn push(&mut self, before: Before, load: PathStep) {
        self.driving_nm.push(load.driving_nm);
        self.stiffness_nm_per_rad.push(load.stiffness_nm_per_rad);
        self.lever_m.push(load.lever_m);
        self.before.push(before);
    }
}
