//! What moves the stiffness over the workspace.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use stiffbench_document::{Document, Table};

use crate::distribution::DesignSensitivity;
use crate::quantity::{
    NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM, RAD_PER_MICRORADIAN,
};
use crate::report::text::significant;
use crate::reported::Reported;
use crate::structure::Property;

const AXES: [&str; 3] = ["x", "y", "z"];
/// Sections that move a stiffness by less than this share of it per share of all their constants are counted, not listed.
const WORTH_LISTING: f64 = 5e-4;
/// Joints that take less of a stiffness than so many per cent per µrad/(N·m) are counted, not listed.
const JOINT_WORTH_LISTING: f64 = 0.001;

/// Sensitivities of one mechanism along one axis, for people.
#[must_use]
pub fn sensitivity_document(mechanism: &str, found: &DesignSensitivity) -> Document {
    let mut document = Document::of(format!(
        "mechanism {mechanism}, stiffness along {}: least {} N/µm, mean {} N/µm",
        AXES[found.axis],
        significant(found.smallest_n_per_m / N_PER_UM, 4),
        significant(found.mean_n_per_m / N_PER_UM, 4),
    ));
    let heads = |of: &str| Property::ALL.map(|one| format!("{of} {}", one.name()));
    let printed = |values: [f64; 4]| values.map(|value| format!("{value:.3}"));
    let size = |values: &[f64; 4]| values.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let mut sections: Vec<_> = found.sections.iter().collect();
    sections.sort_by(|a, b| {
        (size(&b.smallest) + size(&b.mean)).total_cmp(&(size(&a.smallest) + size(&a.mean)))
    });
    let count = sections.len();
    sections.retain(|one| size(&one.smallest).max(size(&one.mean)) >= WORTH_LISTING);
    document.paragraph("Per cent of stiffness per per cent of a section constant:");
    let rest = count - sections.len();
    document.table(
        Table::of(sections)
            .words("section", |one| &one.section)
            .numbers_each(heads("least"), |one| printed(one.smallest))
            .numbers_each(heads("mean"), |one| printed(one.mean)),
    );
    if rest > 0 {
        document.paragraph(format!("{rest} sections move neither by 0.05 % of theirs."));
    }
    add_joints(&mut document, found);
    document
}

fn add_joints(document: &mut Document, found: &DesignSensitivity) {
    if found.joints.is_empty() {
        document.paragraph("Joints that yield already have no derivatives here.");
        return;
    }
    let mut joints: Vec<_> = found.joints.iter().collect();
    joints.sort_by(|a, b| (a.smallest + a.mean).total_cmp(&(b.smallest + b.mean)));
    let count = joints.len();
    let percent = |slope: f64| 100.0 * slope * RAD_PER_MICRORADIAN;
    let is_listed = |slope: f64| percent(slope).abs() >= JOINT_WORTH_LISTING;
    joints.retain(|joint| is_listed(joint.smallest) || is_listed(joint.mean));
    let rest = count - joints.len();
    document.paragraph("Per cent of stiffness per µrad/(N·m) of compliance in a joint that was rigid, to first order:");
    document.table(
        Table::of(joints)
            .words("joint", |joint| &joint.joint)
            .numbers("least", |joint| significant(percent(joint.smallest), 3))
            .numbers("mean", |joint| significant(percent(joint.mean), 3)),
    );
    if rest > 0 {
        document.paragraph(format!(
            "{rest} joints take less than {JOINT_WORTH_LISTING} % of either."
        ));
    }
}

/// What moves the stiffness of a mechanism along an axis.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SensitivityReport {
    /// Name of the mechanism.
    pub mechanism: String,
    /// The axis.
    pub direction: Cow<'static, str>,
    /// The least stiffness.
    pub smallest: Reported,
    /// The mean stiffness.
    pub mean: Reported,
    /// Poses of the mean.
    pub poses_of_mean: usize,
    /// Derivatives by the sections.
    pub sections: Vec<SectionDerivatives>,
    /// Derivatives by the compliances of the joints.
    pub joints: Vec<JointDerivatives>,
}

/// Logarithmic derivatives of the stiffness by the constants of a section.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SectionDerivatives {
    /// Name of the section.
    pub section: String,
    /// Of the least stiffness, by constant.
    pub dln_smallest_dln: IndexMap<Property, f64>,
    /// Of the mean stiffness, by constant.
    pub dln_mean_dln: IndexMap<Property, f64>,
}

/// Derivatives of the logarithm of the stiffness by the compliance of a joint.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct JointDerivatives {
    /// Name of the joint.
    pub joint: String,
    /// Of the least stiffness.
    pub dln_smallest_dc: Reported,
    /// Of the mean stiffness.
    pub dln_mean_dc: Reported,
}

impl SensitivityReport {
    /// The sensitivities of a mechanism.
    #[must_use]
    pub fn new(mechanism: &str, found: &DesignSensitivity) -> Self {
        let by_constant = |values: &[f64; 4]| {
            let constants = Property::ALL.into_iter();
            constants.zip(values.iter().copied()).collect()
        };
        let stiffness = |n_per_m: f64| Reported::exact(n_per_m / N_PER_UM, "N/um");
        let slope = |value: f64| Reported::exact(value, "N*m/rad");
        Self {
            mechanism: mechanism.to_owned(),
            direction: AXES[found.axis].into(),
            smallest: stiffness(found.smallest_n_per_m),
            mean: stiffness(found.mean_n_per_m),
            poses_of_mean: found.poses_of_mean,
            sections: found
                .sections
                .iter()
                .map(|section| SectionDerivatives {
                    section: section.section.clone(),
                    dln_smallest_dln: by_constant(&section.smallest),
                    dln_mean_dln: by_constant(&section.mean),
                })
                .collect(),
            joints: found
                .joints
                .iter()
                .map(|joint| JointDerivatives {
                    joint: joint.joint.clone(),
                    dln_smallest_dc: slope(joint.smallest),
                    dln_mean_dc: slope(joint.mean),
                })
                .collect(),
        }
    }
}
