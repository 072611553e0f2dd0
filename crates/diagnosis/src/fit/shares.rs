//! What parameters own of the stiffness of a cell.

/// Derivatives of the logarithm of one cell's stiffness to the parameters: to ln a of a factor, to the compliance of a spring, N·m/rad.
///
/// That of a factor is also its share of the compliance, u ᵀ a_i K_i u / C: stiffness at the end is a homogeneous function of the factors,
/// and without springs those of all classes add up to one.
pub type Shares = Vec<f64>;
