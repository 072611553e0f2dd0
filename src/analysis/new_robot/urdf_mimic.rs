//! Joints of a URDF that follow others, in terms of the joint that leads.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::ImportError;
use super::draft::{key, number};
use super::urdf::{UrdfJoint, UrdfMotion};
use super::urdf_tree::UrdfTree;

/// The joint at the head of a row of followers: follower = multiplier · leader + offset, in rad and m.
pub(super) struct Leader<'u> {
    pub(super) name: &'u str,
    slides: bool,
    multiplier: f64,
    offset: f64,
}

impl Leader<'_> {
    /// The `angle` of the follower; `name` is that of the leader in the robot file.
    pub(super) fn angle(&self, name: &str, slides: bool) -> String {
        // Coefficients are degrees or m per degree or m.
        let per = match (slides, self.slides) {
            (false, true) => 180.0 / PI,
            (true, false) => PI / 180.0,
            _ => 1.0,
        };
        let mut angle = format!("{} = {}", key(name), number(self.multiplier * per));
        if self.offset != 0.0 {
            let (unit, scale) = if slides {
                ("mm", 1e3)
            } else {
                ("deg", 180.0 / PI)
            };
            let _ = write!(angle, ", offset_{unit} = {}", number(self.offset * scale));
        }
        format!("{{ {angle} }}")
    }
}

impl UrdfTree<'_> {
    /// The joint that a follower follows in the end, or why the robot file has none.
    ///
    /// # Errors
    /// For joints that follow each other.
    pub(super) fn leader<'j>(
        &'j self,
        follower: &'j UrdfJoint,
    ) -> Result<Result<Leader<'j>, String>, ImportError> {
        let (mut multiplier, mut offset) = (1.0, 0.0);
        let mut joint = follower;
        let mut steps = 0;
        while let Some((name, factor, shift)) = &joint.mimic {
            offset += multiplier * shift;
            multiplier *= factor;
            let mut joints = self.urdf.joints.iter();
            let Some(next) = joints.find(|joint| joint.name == *name) else {
                return Ok(Err(format!(
                    "follows joint `{name}`, which is not a joint of this file"
                )));
            };
            steps += 1;
            if steps > self.urdf.joints.len() {
                let message = format!(
                    "joint `{}` follows joint `{name}`, and both follow each other",
                    follower.name
                );
                let help = "take the <mimic> of one of them out";
                return Err(self.error(follower.at, message, help));
            }
            joint = next;
        }
        let slides = match joint.motion {
            UrdfMotion::Revolute | UrdfMotion::Continuous => false,
            UrdfMotion::Prismatic => true,
            UrdfMotion::Fixed | UrdfMotion::Other(_) => {
                return Ok(Err(format!(
                    "follows joint `{}`, which has no variable",
                    joint.name
                )));
            }
        };
        if !self.is_written(joint) {
            let base = &self.urdf.links[self.base].name;
            return Ok(Err(format!(
                "follows joint `{}`, which does not hang on `{base}`",
                joint.name
            )));
        }
        Ok(Ok(Leader {
            name: &joint.name,
            slides,
            multiplier,
            offset,
        }))
    }

    /// Whether a joint comes into the robot file: it hangs on the base by joints that do.
    fn is_written(&self, joint: &UrdfJoint) -> bool {
        let mut link = joint.parent;
        for _ in 0..=self.urdf.joints.len() {
            if link == self.base {
                return true;
            }
            match self.above.get(&link).map(|above| &self.urdf.joints[*above]) {
                Some(above) if !matches!(above.motion, UrdfMotion::Other(_)) => link = above.parent,
                _ => return false,
            }
        }
        false
    }
}
