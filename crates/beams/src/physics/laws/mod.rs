//! The library: one file a law.
//!
//! To add a law, write its file and add its name to the list below: every field of [`LawDefinition`](super::law::LawDefinition) has to be
//! filled in, and nothing elsewhere names a law.

use super::law::Law;
use super::search::TestObject;

/// Declares the files, the list of laws in their order, and a name for each; a second name where a file holds the same law for another kind of place,
/// with one more parameter, or as a part without a robot file shows it.
macro_rules! library {
    ($($file:ident $law:ident $($other:ident)?,)*) => {
        $(mod $file;)*

        /// Every law, in the order of the library.
        const LAWS: &[Law] = &[$($law $(, $other)?),*];

        $(
            #[doc = concat!("The law of `laws/", stringify!($file), ".rs`.")]
            pub const $law: Law = Law(&$file::LAW);
            $(
                #[doc = concat!("The other law of `laws/", stringify!($file), ".rs`.")]
                pub const $other: Law = Law(&$file::DUAL);
            )?
        )*
    };
}

library! {
    joint_compliance JOINT_COMPLIANCE,
    joint_backlash JOINT_BACKLASH BACKLASH_DUAL,
    joint_friction JOINT_FRICTION,
    joint_nonlinearity JOINT_NONLINEARITY,
    joint_tilt_compliance JOINT_TILT_COMPLIANCE,
    tool_compliance TOOL_COMPLIANCE_ABOUT TOOL_COMPLIANCE_ALONG,
    base_compliance BASE_COMPLIANCE,
    gauge_stand_compliance GAUGE_STAND_COMPLIANCE,
    load_misalignment LOAD_MISALIGNMENT,
    loose_member LOOSE_MEMBER,
    force_gauge_nonlinearity FORCE_GAUGE_NONLINEARITY,
    creep CREEP,
    drift_per_second DRIFT_PER_SECOND DRIFT_SINCE_ZEROING,
    drift_per_kelvin DRIFT_PER_KELVIN,
    setting_in SETTING_IN PART_SETTING_IN,
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
    part_friction PART_FRICTION FRICTION_DUAL,
    maxwell_slip MAXWELL_SLIP MAXWELL_SLIP_DUAL,
    load_dependent_friction LOAD_DEPENDENT_FRICTION LOAD_DEPENDENT_FRICTION_DUAL,
    preloaded_backlash PRELOADED_BACKLASH PRELOADED_BACKLASH_DUAL,
    odd_polynomial ODD_POLYNOMIAL,
    hardening_behind_friction HARDENING_BEHIND_FRICTION,
    end_stop END_STOP END_STOP_DUAL,
    joint_separation JOINT_SEPARATION JOINT_SEPARATION_DUAL,
    contact CONTACT CONTACT_DUAL,
    relaxation RELAXATION RELAXATION_DUAL,
    logarithmic_creep PART_CREEP PART_CREEP_DUAL,
    softening SOFTENING SOFTENING_DUAL,
    warm_up WARM_UP,
}

pub use gauge_periodic::{NOMINAL_PERIODS_M, SHORTEST_PERIOD_M};

/// A place as one of its kind: "a joint A3", "a part".
fn one_of(at: &str) -> String {
    format!("a {}", at.strip_prefix("the ").unwrap_or(at))
}

impl Law {
    /// Every law, in the order of the library.
    pub const ALL: &'static [Self] = LAWS;

    /// The laws that are searched for in readings of an object.
    pub fn searched_on(object: TestObject) -> impl Iterator<Item = Self> {
        let laws = Self::ALL.iter().copied();
        laws.filter(move |law| law.search.on.contains(object))
    }

    /// Names of all laws, each once, in the order of the library.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        let mut names: Vec<&str> = Vec::new();
        for law in Self::ALL {
            if !names.contains(&law.name) {
                names.push(law.name);
            }
        }
        names
    }

    /// The laws of a name: one, or those distinguished by place, names or units of parameters.
    pub fn named(name: &str) -> impl Iterator<Item = Self> {
        Self::ALL
            .iter()
            .copied()
            .filter(move |law| law.name == name)
    }

    /// Place in the library, from 0.
    #[must_use]
    pub fn number(self) -> usize {
        let same = |law: &&Self| **law == self;
        Self::ALL.iter().take_while(|law| !same(law)).count()
    }
}

#[cfg(test)]
pub(super) mod tests;
