//! The loads of one run, and what is read under them.

use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::PoseId;

/// One load of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadPoint {
    /// Signed force as measured, N.
    pub force_n: f64,
    /// Place in the load sequence.
    pub step: u32,
    /// Seconds under this load.
    pub hold_s: f64,
    /// Seconds since the gauge was zeroed.
    pub since_zero_s: f64,
    /// Temperature since the gauge was zeroed, K.
    pub warming_k: f64,
    /// Where the gauge stood, from its own reading, m; `None` if it is as predicted.
    pub position_m: Option<f64>,
    /// By how much the end moves beside what structure and effects say, m: joints and clamps that seat otherwise in each run.
    pub seated_m: f64,
    /// Whether no load was asked for: the force gauge hangs free.
    pub is_unloaded: bool,
}

impl LoadPoint {
    /// A release to a force that is not read.
    #[must_use]
    pub fn release(force_n: f64) -> Self {
        Self {
            force_n,
            ..Self::default()
        }
    }
}

/// The loads of one run, in the order in which they were applied, and what one gauge reads; its history begins virgin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunLoads<'a> {
    /// The pose held.
    pub pose: &'a PoseId,
    /// The direction of the loads.
    pub load: &'a LoadDirection,
    /// What is read.
    pub read: ReadAxis,
    /// The repeat.
    pub repeat: u32,
    /// Force to which each load is released before the next, N; `None` where the loads follow each other.
    pub release_n: Option<f64>,
    /// The loads.
    pub loads: &'a [LoadPoint],
}

impl RunLoads<'_> {
    /// A load as it acts along the axis of the reading: what stands there takes that part of it.
    #[must_use]
    pub fn as_read(&self, load: &LoadPoint) -> LoadPoint {
        match self.load {
            LoadDirection::Axis(axis) if self.read == *axis => *load,
            other => LoadPoint {
                force_n: load.force_n * dot6(other.wrench(), self.read.unit()),
                ..*load
            },
        }
    }
}
