//! The joints of a URDF as rows of a robot file, one after the other from the base.

use std::collections::HashMap;

use crate::robot::format2::DEFAULT_LIMITS;
use crate::toml_text::quoted;
use crate::vector::norm;

use super::ImportError;
use super::draft::{Draft, DraftRow, number, three};
use super::urdf::{UrdfJoint, UrdfMotion};
use super::urdf_tree::{UrdfTree, list};

/// Largest angle of a joint that is taken for radians without a note: a whole turn, and what its rounding adds.
const WHOLE_TURN_RAD: f64 = std::f64::consts::TAU + 1e-3;

/// A direction whose length differs from one by more than this is noted.
const UNIT_TOLERANCE: f64 = 1e-3;

/// A turn and an origin in the axes of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkPlace {
    turn: [[f64; 3]; 3],
    origin_m: [f64; 3],
    /// Roll, pitch, yaw, rad.
    rpy_rad: [f64; 3],
}

impl LinkPlace {
    pub(super) fn of(xyz_m: [f64; 3], rpy_rad: [f64; 3]) -> Self {
        let [(sr, cr), (sp, cp), (sy, cy)] = rpy_rad.map(f64::sin_cos);
        Self {
            turn: [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ],
            origin_m: xyz_m,
            rpy_rad,
        }
    }

    fn is_identity(&self) -> bool {
        self.rpy_rad == [0.0; 3] && self.origin_m == [0.0; 3]
    }

    fn point(&self, at_m: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            self.origin_m[i] + (0..3).map(|k| self.turn[i][k] * at_m[k]).sum::<f64>()
        })
    }

    fn then(&self, next: &Self) -> Self {
        if self.is_identity() {
            return *next;
        }
        let turn: [[f64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| self.turn[i][k] * next.turn[k][j]).sum())
        });
        let yaw = if turn[0][0].hypot(turn[1][0]) < 1e-12 {
            0.0
        } else {
            turn[1][0].atan2(turn[0][0])
        };
        let pitch = (-turn[2][0]).atan2(turn[0][0].hypot(turn[1][0]));
        let (sin, cos) = yaw.sin_cos();
        let roll = (sin * turn[0][2] - cos * turn[1][2]).atan2(cos * turn[1][1] - sin * turn[0][1]);
        Self {
            turn,
            origin_m: self.point(next.origin_m),
            rpy_rad: [roll, pitch, yaw],
        }
    }
}

/// The file in the making, and where each link lies.
pub(super) struct ChainWriter<'t, 'a> {
    pub(super) tree: &'t UrdfTree<'a>,
    pub(super) draft: Draft,
    /// Body of each link, and where the link lies in its axes.
    pub(super) places: HashMap<usize, (String, LinkPlace)>,
    pub(super) notes: Vec<String>,
    /// What has another name in the robot file: both names.
    pub(super) renamed: Vec<(String, String)>,
    /// Angles beyond a whole turn, in words.
    pub(super) degrees: Vec<String>,
    /// Variables of the chain with their ranges.
    pub(super) ranges: Vec<(String, bool, [f64; 2])>,
}

impl ChainWriter<'_, '_> {
    pub(super) fn joint(&mut self, place: usize, in_chain: bool) -> Result<(), ImportError> {
        let joint = &self.tree.urdf.joints[place];
        let Some((on, parent)) = self.places.get(&joint.parent).cloned() else {
            return Ok(());
        };
        let here = parent.then(&LinkPlace::of(joint.xyz_m, joint.rpy_rad));
        let is_beyond = |angle: &f64| angle.abs() > WHOLE_TURN_RAD;
        if joint.rpy_rad.iter().any(is_beyond) {
            let [roll, pitch, yaw] = joint.rpy_rad;
            let words = format!("rpy=\"{roll} {pitch} {yaw}\" of `{}`", joint.name);
            self.degrees.push(words);
        }
        if let (UrdfMotion::Revolute, Some([low, high])) = (joint.motion, joint.limits)
            && [low, high].iter().any(is_beyond)
        {
            let words = format!("limits {low} and {high} of `{}`", joint.name);
            self.degrees.push(words);
        }
        let slides = match joint.motion {
            UrdfMotion::Fixed => {
                self.places.insert(joint.child, (on, here));
                return Ok(());
            }
            UrdfMotion::Other(kind) if in_chain => {
                let message = format!(
                    "joint `{}` is {kind}: it has more than one freedom",
                    joint.name
                );
                let help = "choose --base and --tip so that only revolute, continuous, prismatic and fixed joints lie between them";
                return Err(self.tree.error(joint.at, message, help));
            }
            UrdfMotion::Other(kind) => {
                self.note(
                    joint,
                    format!("is {kind}: it and what hangs on it were left out"),
                );
                return Ok(());
            }
            UrdfMotion::Revolute | UrdfMotion::Continuous => false,
            UrdfMotion::Prismatic => true,
        };
        let length = norm(joint.axis);
        if length.is_nan() || length <= 1e-9 {
            let message = format!("joint `{}`: its axis has no direction", joint.name);
            return Err(self
                .tree
                .error(joint.at, message, "give the axis a length of one"));
        }
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            self.note(
                joint,
                format!(
                    "has an axis of length {}; its direction was taken",
                    number(length)
                ),
            );
        }
        let name = self.tree.joint_name(&joint.name);
        let body = self.tree.body_name(joint.child);
        for (old, new) in [
            (&joint.name, &name),
            (&self.tree.urdf.links[joint.child].name, &body),
        ] {
            if old != new {
                self.renamed.push((old.clone(), new.clone()));
            }
        }
        let mut row = DraftRow::new(&name);
        if slides {
            row.set("kind", "\"sliding\"");
        }
        row.set("on", quoted(&on));
        row.set("body", quoted(&body));
        if here.origin_m != [0.0; 3] {
            row.set("at_mm", three(here.origin_m.map(|m| 1e3 * m)));
        }
        if here.rpy_rad != [0.0; 3] {
            row.set("turn_deg", three(here.rpy_rad.map(f64::to_degrees)));
        }
        row.set("axis", axis_text(joint.axis));
        self.motion(joint, slides, in_chain, &mut row)?;
        if in_chain {
            row.set("spring", "\"free\"");
            let sections = &self.tree.settings.sections;
            let own = sections.iter().find(|(of, _)| of.as_ref() == Some(&name));
            let section = own.or_else(|| sections.iter().find(|(of, _)| of.is_none()));
            if let Some((_, section)) = section {
                row.set("link", quoted(section));
            }
            self.draft.chain.push(row);
        } else {
            self.draft.branches.push(row);
        }
        let own = LinkPlace::of([0.0; 3], [0.0; 3]);
        self.places.insert(joint.child, (body, own));
        Ok(())
    }

    /// Limits of a joint, or the joint that it follows.
    fn motion(
        &mut self,
        joint: &UrdfJoint,
        slides: bool,
        in_chain: bool,
        row: &mut DraftRow,
    ) -> Result<(), ImportError> {
        let tree = self.tree;
        if joint.mimic.is_some() {
            match tree.leader(joint)? {
                Ok(leader) => {
                    row.set("angle", leader.angle(&tree.joint_name(leader.name), slides));
                    return Ok(());
                }
                Err(why) => self.note(joint, format!("{why}: it has a variable of its own")),
            }
        }
        let range = match (joint.limits, joint.motion) {
            (Some(limits), UrdfMotion::Revolute | UrdfMotion::Prismatic) => {
                limits.map(|limit| if slides { limit } else { limit.to_degrees() })
            }
            (None, UrdfMotion::Revolute | UrdfMotion::Prismatic) => {
                let bound = DEFAULT_LIMITS[usize::from(slides)];
                let words = if slides { "m" } else { "degrees" };
                let why = joint.no_limits.as_deref().unwrap_or("has no limits");
                self.note(
                    joint,
                    format!("{why}: -{bound} to {bound} {words} were taken"),
                );
                [-bound, bound]
            }
            _ => [-DEFAULT_LIMITS[0], DEFAULT_LIMITS[0]],
        };
        let written = range.map(|bound| if slides { 1e3 * bound } else { bound });
        let unit = if slides { "mm" } else { "deg" };
        row.set(format!("min_{unit}"), number(written[0]));
        row.set(format!("max_{unit}"), number(written[1]));
        if in_chain {
            self.ranges.push((row.name.clone(), slides, range));
        }
        Ok(())
    }

    /// Joints off the chain, in the order of the tree.
    pub(super) fn branches(&mut self) -> Result<(), ImportError> {
        let mut open = vec![self.tree.base];
        let mut seen = 0;
        while let Some(link) = open.pop() {
            seen += 1;
            if seen > self.tree.urdf.links.len() {
                break;
            }
            for &joint in self.tree.below.get(&link).into_iter().flatten() {
                if !self.tree.path.contains(&joint) {
                    self.joint(joint, false)?;
                }
            }
            let below = self.tree.below.get(&link).into_iter().flatten().rev();
            open.extend(below.map(|joint| self.tree.urdf.joints[*joint].child));
        }
        Ok(())
    }

    pub(super) fn tool(&mut self) {
        if let Some((body, place)) = self.places.get(&self.tree.tip) {
            self.draft.tool.push(("on", quoted(body)));
            self.draft
                .tool
                .push(("at_mm", three(place.origin_m.map(|m| 1e3 * m))));
            if place.rpy_rad != [0.0; 3] {
                let turn = place.rpy_rad.map(f64::to_degrees);
                self.draft.tool.push(("turn_deg", three(turn)));
            }
        }
    }

    /// Masses of links that move.
    pub(super) fn masses(&mut self) {
        let mut without = Vec::new();
        for (place, link) in self.tree.urdf.links.iter().enumerate() {
            let Some((body, at)) = self.places.get(&place).filter(|(body, _)| body != "base")
            else {
                continue;
            };
            match link.mass {
                Some((mass, centre)) => {
                    let mut row = DraftRow::new(&link.name);
                    // In full: that of a mere frame may be 1e-15 kg.
                    row.set("mass_kg", mass.to_string());
                    row.set("on", quoted(body));
                    row.set("at_mm", three(at.point(centre).map(|m| 1e3 * m)));
                    self.draft.masses.push(row);
                }
                // A link without geometry that is fixed to another is a mere frame.
                None if at.is_identity() => without.push(link.name.as_str()),
                None => {}
            }
        }
        if !without.is_empty() {
            let note = format!("no mass is stated for {}", list(without.into_iter()));
            self.notes.push(note);
        }
    }

    fn note(&mut self, joint: &UrdfJoint, what: impl AsRef<str>) {
        let (line, _) = self.tree.source.line_and_column(joint.at);
        self.notes.push(format!(
            "{}:{line}: joint `{}` {}",
            self.tree.source.name,
            joint.name,
            what.as_ref()
        ));
    }

    /// What is said once of all joints: other names, and angles that look like degrees.
    pub(super) fn notes_on_all(&mut self) {
        if !self.degrees.is_empty() {
            let note = format!(
                "angles beyond a whole turn (2 pi rad) look like degrees, but a URDF has radians, and they were taken as such: {}",
                list(self.degrees.iter().map(String::as_str))
            );
            self.notes.push(note);
        }
        if !self.renamed.is_empty() {
            let pairs = self.renamed.iter();
            let pairs: Vec<String> = pairs.map(|(old, new)| format!("{old} is {new}")).collect();
            let note = format!(
                "renamed, because these names mean something else in a robot file: {}",
                list(pairs.iter().map(String::as_str))
            );
            self.notes.push(note);
        }
    }
}

impl UrdfTree<'_> {
    /// The name of a joint in the robot file.
    fn joint_name(&self, name: &str) -> String {
        let reserved = ["base", "tool", "offset"].contains(&name);
        if !reserved && !crate::robot::format2::ends_in_unit(name) {
            return name.to_owned();
        }
        let joints = &self.urdf.joints;
        let is_taken = |name: &str| joints.iter().any(|joint| joint.name == name);
        unused(name, "_joint", is_taken)
    }

    /// The name of a link that moves in the robot file.
    fn body_name(&self, link: usize) -> String {
        let name = self.urdf.links[link].name.as_str();
        if name != "base" {
            return name.to_owned();
        }
        let links = &self.urdf.links;
        unused(name, "_link", |name| {
            links.iter().any(|link| link.name == name)
        })
    }
}

/// A name with an ending, so often that no other has it.
fn unused(name: &str, ending: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut longer = format!("{name}{ending}");
    while is_taken(&longer) {
        longer.push_str(ending);
    }
    longer
}

/// An axis of the joint as a word where it is one.
fn axis_text(axis: [f64; 3]) -> String {
    for (place, word) in ["x", "y", "z"].into_iter().enumerate() {
        let mut unit = [0.0; 3];
        unit[place] = 1.0;
        if axis == unit {
            return format!("\"{word}\"");
        }
        unit[place] = -1.0;
        if axis == unit {
            return format!("\"-{word}\"");
        }
    }
    // All digits: a rounded direction is another one.
    format!("[{}]", axis.map(|c| c.to_string()).join(", "))
}
