//! What a plan will be able to distinguish, and which measurement to make next.
//!
//! For two rivals i and j of which i is true with size a, the expected log-likelihood ratio of planned readings is
//!
//! ```text
//!   J = ½ a² ‖(I - P[factors, e_j]) e_i‖²,       e white under the noise of the planned readings
//! ```
//!
//! with every law solved in the structure itself, along the planned loads, holds and clock. Below J = 3 the pair cannot be distinguished,
//! from J = 5 on it will be. The rival may take any size and any course (breakaway load, friction, time constant) that physics allows it;
//! the smaller of the two directions counts.

mod advice;
mod bench;
mod next;
mod next_measurement;
mod plans;
mod report;
mod schedule;
mod separation;
#[cfg(test)]
mod tests;
mod unexplained;
mod views;

pub use crate::search::constants::{CAN_TELL, CANNOT_TELL};
pub use bench::{DesignBench, LawAtPlace, USUAL_NOISE, poses_at_hand};
pub use next::next_measurements;
pub use next_measurement::NextMeasurement;
pub use report::{DesignReport, LawDesign, Unseen, design_of_plan};
pub use views::NearRival;
