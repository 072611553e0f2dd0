//! The library: one file a law.
//!
//! To add a law, write its file and add its name to the list below: every field of [`LawDefinition`](super::law::LawDefinition) has to be
//! filled in, and nothing elsewhere names a law.

use super::law::Law;

/// Declares the files, the list of laws in their order, and a name for each.
macro_rules! library {
    ($($file:ident $law:ident,)*) => {
        $(mod $file;)*

        /// Every law, in the order of the library.
        pub(super) const LAWS: &[Law] = &[$($law),*];

        $(
            #[doc = concat!("The law of `laws/", stringify!($file), ".rs`.")]
            pub const $law: Law = Law(&$file::LAW);
        )*
    };
}

library! {
    joint_compliance JOINT_COMPLIANCE,
    joint_backlash JOINT_BACKLASH,
    joint_friction JOINT_FRICTION,
    joint_nonlinearity JOINT_NONLINEARITY,
    base_compliance BASE_COMPLIANCE,
    gauge_stand_compliance GAUGE_STAND_COMPLIANCE,
    load_misalignment LOAD_MISALIGNMENT,
    loose_member LOOSE_MEMBER,
    force_gauge_nonlinearity FORCE_GAUGE_NONLINEARITY,
    creep CREEP,
    drift_per_second DRIFT_PER_SECOND,
    drift_per_kelvin DRIFT_PER_KELVIN,
    setting_in SETTING_IN,
    slip SLIP,
    gauge_periodic GAUGE_PERIODIC,
    constant_force CONSTANT_FORCE,
    gauge_misalignment GAUGE_MISALIGNMENT,
    force_gauge_scale FORCE_GAUGE_SCALE,
    displacement_gauge_scale DISPLACEMENT_GAUGE_SCALE,
    link_length LINK_LENGTH,
    joint_offset JOINT_OFFSET,
    section_error SECTION_ERROR,
    factor_group FACTOR_GROUP,
    wrong_mechanism WRONG_MECHANISM,
}

pub use gauge_periodic::{NOMINAL_PERIODS_M, SHORTEST_PERIOD_M};

#[cfg(test)]
pub(super) mod tests;
