//! The promises of this crate, tested from outside.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

mod balancers;
mod joint_springs;
mod model_parameters;
mod multi_pose;
mod own_weight;
mod part_laws;
mod physics_opensees;
mod pose_sweep;
mod rigid_loops;
mod robot_file_2;
mod robot_file_errors;
mod robot_kinematics;
mod robot_mobility;
mod robot_schema;
mod stiff_elements;
mod structure_edits;
mod structure_errors;
mod structure_opensees;
mod structure_properties;
mod structure_springs;
mod structure_textbook;
mod support;
