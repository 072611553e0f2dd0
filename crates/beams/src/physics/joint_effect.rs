//! A law in a joint, and how far joints have turned.

use super::action::{Driven, RotationLaw, Values};

/// A law in a joint, by its place among the levers.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointEffect {
    pub(super) joint: usize,
    law: &'static dyn RotationLaw,
    values: Values,
}

impl JointEffect {
    pub(super) fn new(joint: usize, law: &'static dyn RotationLaw, values: Values) -> Self {
        Self { joint, law, values }
    }

    /// # Arguments
    /// - `moment_nm`, `stiffness_nm_per_rad`, `before_rad`: as of [`Driven`]; rounding may leave the stiffness below zero.
    pub(super) fn rotation_rad(
        &self,
        moment_nm: f64,
        stiffness_nm_per_rad: f64,
        before_rad: f64,
    ) -> f64 {
        let driven = driven(moment_nm, stiffness_nm_per_rad, before_rad);
        self.law.rotation_rad(&self.values, driven)
    }

    pub(super) fn slope_rad_per_nm(
        &self,
        moment_nm: f64,
        stiffness_nm_per_rad: f64,
        before_rad: f64,
    ) -> f64 {
        let driven = driven(moment_nm, stiffness_nm_per_rad, before_rad);
        self.law.slope_rad_per_nm(&self.values, driven)
    }

    /// Moment per twist in a state, N·m/rad; infinite where the joint does not turn, zero where it turns freely.
    ///
    /// # Arguments
    /// - `rotation_rad`, `moment_nm`: the state; without a moment the stiffness is that under the smallest one.
    pub(super) fn secant_nm_per_rad(&self, rotation_rad: f64, moment_nm: f64) -> f64 {
        if moment_nm == 0.0 {
            self.law.stiffness_at_rest_nm_per_rad(&self.values)
        } else if rotation_rad == 0.0 {
            f64::INFINITY
        } else {
            moment_nm / rotation_rad
        }
    }
}

fn driven(moment_nm: f64, stiffness_nm_per_rad: f64, before_rad: f64) -> Driven {
    Driven {
        moment_nm,
        stiffness_nm_per_rad: stiffness_nm_per_rad.max(0.0),
        before_rad,
    }
}

/// Twists of the joints with laws: the history of a run, and its scratch memory.
#[derive(Debug, Clone, Default)]
pub struct JointRotations {
    pub(super) now: Vec<f64>,
    /// At the load before; scratch memory.
    pub(super) before: Vec<f64>,
    /// Whether a load has acted.
    pub(super) loaded: bool,
}

impl JointRotations {
    /// No twist, no load before.
    pub(super) fn begin(&mut self, joints: usize) {
        self.now.clear();
        self.now.resize(joints, 0.0);
        self.loaded = false;
    }
}
