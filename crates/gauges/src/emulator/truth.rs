//! What an emulated gauge measures.

use std::sync::Arc;

/// Where the true value comes from.
///
/// The gauge depends neither on robots nor on time beyond its own: it asks what acts on it now.
pub trait GaugeTruth: Send + Sync {
    /// What acts on the gauge now. Force, N: positive in tension, negative in compression. Displacement, m: positive as the gauge counts.
    fn value_si(&self) -> f64;
}

impl<F: Fn() -> f64 + Send + Sync> GaugeTruth for F {
    fn value_si(&self) -> f64 {
        self()
    }
}

/// A truth that a gauge keeps.
pub type SharedTruth = Arc<dyn GaugeTruth>;
