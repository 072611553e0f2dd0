//! The joints between two links of a URDF, with what hangs on them, as a robot file.

use std::collections::HashMap;

use crate::source_text::SourceText;

use super::draft::{Draft, made_from, poses_within};
use super::urdf::{Urdf, read};
use super::urdf_chain::{ChainWriter, LinkPlace};
use super::urdf_meshes::missing_meshes;
use super::{ImportError, ImportProblem, NewRobot};

/// What to take from a URDF.
#[derive(Debug, Clone, Default)]
pub struct UrdfSettings {
    /// Link that is held; the root if absent.
    pub base: Option<String>,
    /// Link that carries the tool; the only leaf if absent.
    pub tip: Option<String>,
    /// Sections of the links, by joint; `None` for all others.
    pub sections: Vec<(Option<String>, String)>,
}

/// A robot file from the text of a URDF: joints become springs, inertias masses, meshes are passed over.
///
/// # Errors
/// [`ImportError`] at the line of the element that cannot be used.
pub fn robot_from_urdf(
    source: &SourceText,
    settings: &UrdfSettings,
) -> Result<NewRobot, ImportError> {
    let urdf = read(source)?;
    let mut made = UrdfTree::new(source, &urdf, settings)?.robot()?;
    made.notes.extend(missing_meshes(source, &urdf));
    Ok(made)
}

pub(super) struct UrdfTree<'a> {
    pub(super) source: &'a SourceText,
    pub(super) urdf: &'a Urdf,
    pub(super) settings: &'a UrdfSettings,
    /// Joint above each link.
    pub(super) above: HashMap<usize, usize>,
    /// Joints below each link.
    pub(super) below: HashMap<usize, Vec<usize>>,
    pub(super) base: usize,
    /// Joints from the base to the tip.
    pub(super) path: Vec<usize>,
    pub(super) tip: usize,
}

impl<'a> UrdfTree<'a> {
    fn new(
        source: &'a SourceText,
        urdf: &'a Urdf,
        settings: &'a UrdfSettings,
    ) -> Result<Self, ImportError> {
        let mut tree = Self {
            source,
            urdf,
            settings,
            above: HashMap::new(),
            below: HashMap::new(),
            base: 0,
            path: Vec::new(),
            tip: 0,
        };
        for (place, joint) in urdf.joints.iter().enumerate() {
            if let Some(first) = tree.above.insert(joint.child, place) {
                let message = format!(
                    "joint `{}`: link `{}` hangs on joint `{}` already: the robot has a loop",
                    joint.name, urdf.links[joint.child].name, urdf.joints[first].name
                );
                let help = "a URDF is a tree: take the joint that closes the loop out, or describe the linkage in a robot file (docs/robot-file.md)";
                return Err(tree.error(joint.at, message, help));
            }
            tree.below.entry(joint.parent).or_default().push(place);
        }
        tree.base = tree.find_base()?;
        tree.tip = tree.find_tip()?;
        tree.path = tree.find_path()?;
        Ok(tree)
    }

    pub(super) fn error(&self, at: usize, message: impl Into<String>, help: &str) -> ImportError {
        ImportError::new(self.source, at..at, ImportProblem::new(message, help))
    }

    fn link_named(&self, option: &str, name: &str) -> Result<usize, ImportError> {
        let names = || self.urdf.links.iter().map(|link| link.name.as_str());
        names().position(|known| known == name).ok_or_else(|| {
            let help = match crate::nearest::nearest(name, names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the links are {}", list(names())),
            };
            self.error(
                0,
                format!("--{option} {name}: there is no link of that name"),
                &help,
            )
        })
    }

    fn find_base(&self) -> Result<usize, ImportError> {
        if let Some(name) = &self.settings.base {
            return self.link_named("base", name);
        }
        let roots: Vec<usize> = (0..self.urdf.links.len())
            .filter(|link| !self.above.contains_key(link))
            .collect();
        match roots[..] {
            [root] => Ok(root),
            [] => {
                let message = "every link hangs on another: the joints go round in a circle";
                Err(self.error(self.urdf.links[0].at, message, "take one of the joints out"))
            }
            _ => {
                let names = roots
                    .iter()
                    .map(|root| self.urdf.links[*root].name.as_str());
                let message = format!("{} links hang on no joint: {}", roots.len(), list(names));
                Err(self.error(
                    self.urdf.links[roots[1]].at,
                    message,
                    "name the one that is held with --base",
                ))
            }
        }
    }

    /// The last link: the one that is named, or the only one without a joint below it.
    fn find_tip(&self) -> Result<usize, ImportError> {
        if let Some(name) = &self.settings.tip {
            return self.link_named("tip", name);
        }
        let mut leaves = Vec::new();
        let mut open = vec![self.base];
        while let Some(link) = open.pop() {
            match self.below.get(&link) {
                Some(joints) => open.extend(
                    joints
                        .iter()
                        .rev()
                        .map(|joint| self.urdf.joints[*joint].child),
                ),
                None => leaves.push(link),
            }
            if leaves.len() + open.len() > 2 * self.urdf.links.len() {
                break;
            }
        }
        if let [leaf] = leaves[..] {
            Ok(leaf)
        } else {
            let names = leaves
                .iter()
                .map(|leaf| self.urdf.links[*leaf].name.as_str());
            let message = format!("the robot has {} ends: {}", leaves.len(), list(names));
            let first = leaves.first().map(|leaf| &self.urdf.links[*leaf]);
            let help = "name the link that carries the tool with --tip";
            let help = first.map_or_else(
                || help.to_owned(),
                |first| format!("{help}, for example --tip {}", first.name),
            );
            Err(self.error(first.map_or(0, |first| first.at), message, &help))
        }
    }

    fn find_path(&self) -> Result<Vec<usize>, ImportError> {
        let mut path = Vec::new();
        let mut link = self.tip;
        while link != self.base {
            let Some(&joint) = self.above.get(&link) else {
                let [tip, base] =
                    [self.tip, self.base].map(|link| self.urdf.links[link].name.as_str());
                let message = format!(
                    "link `{tip}` does not hang on link `{base}`: above it the joints end at `{}`",
                    self.urdf.links[link].name
                );
                let help = "name another --base or --tip";
                return Err(self.error(self.urdf.links[self.tip].at, message, help));
            };
            if path.len() > self.urdf.joints.len() {
                let joint = &self.urdf.joints[joint];
                let message = format!("joint `{}`: the joints go round in a circle", joint.name);
                return Err(self.error(joint.at, message, "take one of the joints out"));
            }
            path.push(joint);
            link = self.urdf.joints[joint].parent;
        }
        path.reverse();
        Ok(path)
    }

    /// The file: the joints from base to tip first, then those of branches.
    fn robot(&self) -> Result<NewRobot, ImportError> {
        let mut writer = ChainWriter {
            tree: self,
            draft: Draft {
                name: self.urdf.name.clone(),
                source: made_from(self.source, "urdf"),
                ..Draft::default()
            },
            places: HashMap::new(),
            notes: Vec::new(),
            renamed: Vec::new(),
            degrees: Vec::new(),
            ranges: Vec::new(),
        };
        writer.places.insert(
            self.base,
            ("base".to_owned(), LinkPlace::of([0.0; 3], [0.0; 3])),
        );
        for &joint in &self.path {
            writer.joint(joint, true)?;
        }
        if writer.draft.chain.is_empty() && self.urdf.joints.is_empty() {
            let message = format!("the robot `{}` has no joints", self.urdf.name);
            let help = "name a URDF file that describes a robot";
            return Err(self.error(self.urdf.links[self.tip].at, message, help));
        }
        if writer.draft.chain.is_empty() {
            let message = format!(
                "no joint moves between `{}` and `{}`",
                self.urdf.links[self.base].name, self.urdf.links[self.tip].name
            );
            return Err(self.error(
                self.urdf.links[self.tip].at,
                message,
                "name another --base or --tip",
            ));
        }
        writer.branches()?;
        writer.tool();
        writer.masses();
        writer.notes_on_all();
        writer.draft.poses = poses_within(&writer.ranges);
        for (joint, _) in &self.settings.sections {
            if let Some(name) = joint
                && !writer.draft.chain.iter().any(|row| row.name == *name)
            {
                let names = writer.draft.chain.iter().map(|row| row.name.as_str());
                let help = format!("the joints are {}", list(names));
                return Err(self.error(
                    0,
                    format!("--section {name}=…: there is no such joint"),
                    &help,
                ));
            }
        }
        Ok(NewRobot {
            text: writer.draft.text(),
            notes: writer.notes,
        })
    }
}

/// The first names, and how many more.
pub(super) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let shown = names
        .iter()
        .take(12)
        .copied()
        .collect::<Vec<_>>()
        .join(", ");
    match names.len().saturating_sub(12) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
