//! What the structure does under the loads of a run.

use crate::test_point::{Branch, Direction, PoseId};

/// One load of a run, as the structure felt it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadPoint {
    /// Place in the load sequence from 0; readings of a hold share it.
    pub step: u32,
    /// Loading or unloading.
    pub branch: Branch,
    /// Signed force that acts, N.
    pub force_n: f64,
    /// Seconds under this load.
    pub hold_s: f64,
    /// Seconds since the session began.
    pub time_s: f64,
    /// Seconds since the gauge was zeroed.
    pub since_zero_s: f64,
    /// Temperature, °C.
    pub temperature_deg_c: f64,
    /// Temperature since the gauge was zeroed, K.
    pub warming_k: f64,
}

/// The loads of one run, in the order in which they were applied; its history begins virgin.
#[derive(Debug, Clone, PartialEq)]
pub struct RunLoads<'a> {
    /// The pose held.
    pub pose: &'a PoseId,
    /// The direction of load and reading.
    pub direction: Direction,
    /// The repeat, from 1.
    pub repeat: u32,
    /// Force to which each load is released before the next, N; `None` where the loads follow each other.
    pub release_n: Option<f64>,
    /// The loads.
    pub loads: Vec<LoadPoint>,
}

/// Displacements of the end along the load at each load of a run, relative to the unloaded state, m.
///
/// The linear beam structure: u = C F (paper eqs. (29) to (31)). It has no history, so that the loads are taken one by one.
///
/// # Arguments
/// - `compliance_m_per_n`: 3 × 3, row = direction of displacement, column = direction of force.
/// - `run`: everything a law with a history needs to know.
pub(super) fn mechanics(compliance_m_per_n: &[[f64; 3]; 3], run: &RunLoads<'_>) -> Vec<f64> {
    let i = run.direction.index();
    let along_m_per_n = compliance_m_per_n[i][i];
    run.loads
        .iter()
        .map(|load| load.force_n * along_m_per_n)
        .collect()
}
