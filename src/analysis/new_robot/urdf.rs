//! A URDF as links and joints; meshes and everything else that has no part in stiffness is passed over.
//!
//! Decision. `urdf-rs` is not used: its errors name no element, it refuses a limit without velocity and a file for an error in a mesh or a
//! colour, and deeply nested elements end the program.

use std::collections::HashMap;

use roxmltree::{Document, Node};

use crate::source_text::SourceText;

use super::{ImportError, ImportProblem};

/// Size from which a number means that there is none, rad, m or kg.
const UNLIMITED: f64 = 1e9;

/// The links and joints of a robot.
#[derive(Debug)]
pub(super) struct Urdf {
    pub(super) name: String,
    pub(super) links: Vec<UrdfLink>,
    pub(super) joints: Vec<UrdfJoint>,
}

/// A rigid body.
#[derive(Debug)]
pub(super) struct UrdfLink {
    pub(super) name: String,
    /// Mass, kg, and its centre, m.
    pub(super) mass: Option<(f64, [f64; 3])>,
    /// Files of its meshes, as they are written.
    pub(super) meshes: Vec<String>,
    /// Place in the text.
    pub(super) at: usize,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UrdfMotion {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// With more than one freedom.
    Other(&'static str),
}

/// A joint.
#[derive(Debug)]
pub(super) struct UrdfJoint {
    pub(super) name: String,
    pub(super) motion: UrdfMotion,
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) xyz_m: [f64; 3],
    pub(super) rpy_rad: [f64; 3],
    pub(super) axis: [f64; 3],
    /// Lower and upper limit, rad or m.
    pub(super) limits: Option<[f64; 2]>,
    /// Why there are no limits, where a <limit> is stated.
    pub(super) no_limits: Option<String>,
    /// Joint that it follows, multiplier, offset in rad or m.
    pub(super) mimic: Option<(String, f64, f64)>,
    pub(super) at: usize,
}

/// Reads a URDF.
pub(super) fn read(source: &SourceText) -> Result<Urdf, ImportError> {
    let error = |at: usize, message: String, help: &str| {
        ImportError::new(source, at..at, ImportProblem::new(message, help))
    };
    if source.text.trim_start_matches('\u{feff}').trim().is_empty() {
        let message = "the file is empty".to_owned();
        return Err(error(0, message, "name a URDF file that describes a robot"));
    }
    if source.text.contains('\0') {
        let message = "this is not UTF-8 text: it has zero bytes, as UTF-16 has".to_owned();
        let order = if source.text.starts_with('\0') {
            "BE"
        } else {
            "LE"
        };
        let help =
            format!("save it in UTF-8, for example: iconv -f UTF-16{order} -t UTF-8 FILE > NEW");
        return Err(error(0, message, &help));
    }
    let text = tolerated(&source.text);
    let document = Document::parse(&text).map_err(|problem| {
        error(
            byte_of(&text, problem.pos()),
            format!("no XML: {problem}"),
            "a URDF is an XML file whose root is <robot>",
        )
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let message = format!("the root is <{}>, expected <robot>", root.tag_name().name());
        return Err(error(root.range().start, message, "name a URDF file"));
    }
    let is_xacro = |node: &Node<'_, '_>| {
        let namespace = node.tag_name().namespace();
        namespace.is_some_and(|namespace| namespace.contains("xacro"))
            || node.tag_name().name().starts_with("xacro.")
    };
    if let Some(node) = root.descendants().find(is_xacro) {
        let name = node.tag_name().name().trim_start_matches("xacro.");
        let message = format!("<xacro:{name}>: this file is a xacro");
        let help = "expand it first: xacro FILE.xacro > FILE.urdf";
        return Err(error(node.range().start, message, help));
    }
    let children = |name: &'static str| root.children().filter(move |node| node.has_tag_name(name));
    let reader = UrdfReader { source };
    let mut links = Vec::new();
    let mut places = HashMap::new();
    for node in children("link") {
        let link = reader.link(node)?;
        if places.insert(link.name.clone(), links.len()).is_some() {
            let message = format!("link `{}` is there twice", link.name);
            return Err(error(link.at, message, "give each link its own name"));
        }
        links.push(link);
    }
    let mut joints: Vec<UrdfJoint> = Vec::new();
    for node in children("joint") {
        let joint = reader.joint(node, &places)?;
        if joints.iter().any(|known| known.name == joint.name) {
            let message = format!("joint `{}` is there twice", joint.name);
            return Err(error(joint.at, message, "give each joint its own name"));
        }
        joints.push(joint);
    }
    if links.is_empty() {
        let message = "the robot has no <link>".to_owned();
        return Err(error(
            root.range().start,
            message,
            "name a URDF file that describes a robot",
        ));
    }
    Ok(Urdf {
        name: root.attribute("name").unwrap_or("robot").to_owned(),
        links,
        joints,
    })
}

/// The text as the parser of ROS takes it, every byte in its place: an XML declaration may stand behind comments, and a prefix need not be
/// declared. Declarations become blanks, and the colon behind such a prefix a full stop.
fn tolerated(text: &str) -> String {
    let mut text = text.to_owned();
    while let Some(start) = text.find("<?xml") {
        let length = text[start..].find("?>").map_or(5, |length| length + 2);
        let blanks = text[start..start + length].bytes();
        let blanks: String = blanks
            .map(|b| if b == b'\n' { '\n' } else { ' ' })
            .collect();
        text.replace_range(start..start + length, &blanks);
    }
    while let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = Document::parse(&text) {
        let before = text.clone();
        for ahead in ["<", "</", " ", "\t", "\n"] {
            text = text.replace(&format!("{ahead}{prefix}:"), &format!("{ahead}{prefix}."));
        }
        if text == before {
            break;
        }
    }
    text
}

/// Byte offset of a row and column.
fn byte_of(text: &str, position: roxmltree::TextPos) -> usize {
    let [row, column] = [position.row, position.col].map(|one| (one as usize).saturating_sub(1));
    let before = text.split_inclusive('\n').take(row).map(str::len);
    let start = before.sum::<usize>().min(text.len());
    let mut places = text[start..].char_indices();
    places.nth(column).map_or(text.len(), |(at, _)| start + at)
}

/// What to do about a text that is no number.
fn expression_help<'h>(text: &str, otherwise: &'h str) -> &'h str {
    if text.contains("${") || text.contains("$(") {
        "this is a xacro expression; expand the file first: xacro FILE.xacro > FILE.urdf"
    } else {
        otherwise
    }
}

struct UrdfReader<'a> {
    source: &'a SourceText,
}

impl UrdfReader<'_> {
    fn error(&self, node: Node<'_, '_>, message: impl Into<String>, help: &str) -> ImportError {
        let problem = ImportProblem::new(message, help);
        let start = node.range().start;
        ImportError::new(self.source, start..start, problem)
    }

    /// Attribute that must be there; `of` names the element.
    fn attribute<'n>(
        &self,
        node: Node<'n, '_>,
        name: &str,
        of: &str,
    ) -> Result<&'n str, ImportError> {
        node.attribute(name).ok_or_else(|| {
            let message = format!("{of}: <{}> has no `{name}`", node.tag_name().name());
            self.error(node, message, "add the attribute")
        })
    }

    /// Name of a link or joint, which the robot file takes over.
    fn name(&self, node: Node<'_, '_>, of: &str) -> Result<String, ImportError> {
        let name = self.attribute(node, "name", of)?;
        if name.trim().is_empty() || name.contains(char::is_control) {
            let message = format!("{of}: its name is `{}`", name.escape_debug());
            return Err(self.error(node, message, "give it a name in one line"));
        }
        Ok(name.to_owned())
    }

    fn number(
        &self,
        node: Node<'_, '_>,
        name: &str,
        text: &str,
        of: &str,
    ) -> Result<f64, ImportError> {
        let number = text.trim().parse::<f64>().ok();
        number
            .filter(|number| number.abs() < UNLIMITED)
            .ok_or_else(|| {
                let message = format!("{of}: `{name}` is `{text}`");
                self.error(
                    node,
                    message,
                    expression_help(text, "write a finite number"),
                )
            })
    }

    fn three(
        &self,
        node: Node<'_, '_>,
        name: &str,
        of: &str,
    ) -> Result<Option<[f64; 3]>, ImportError> {
        let Some(text) = node.attribute(name) else {
            return Ok(None);
        };
        let numbers: Vec<&str> = text.split_whitespace().collect();
        let [x, y, z] = numbers[..] else {
            let message = format!("{of}: `{name}` is `{text}`");
            let help = expression_help(text, "write three numbers with spaces between them");
            return Err(self.error(node, message, help));
        };
        Ok(Some([
            self.number(node, name, x, of)?,
            self.number(node, name, y, of)?,
            self.number(node, name, z, of)?,
        ]))
    }

    fn link(&self, node: Node<'_, '_>) -> Result<UrdfLink, ImportError> {
        let name = self.name(node, "a link")?;
        let of = format!("link `{name}`");
        let inertial = node.children().find(|child| child.has_tag_name("inertial"));
        let mut mass = None;
        if let Some(inertial) = inertial {
            let child = |name: &'static str| {
                inertial
                    .children()
                    .find(move |child| child.has_tag_name(name))
            };
            if let Some(element) = child("mass") {
                let text = self.attribute(element, "value", &of)?;
                let value = self.number(element, "value", text, &of)?;
                if value < 0.0 {
                    return Err(self.error(
                        element,
                        format!("{of}: its mass is {value}"),
                        "a mass is not negative",
                    ));
                }
                let origin = child("origin");
                let origin = origin.map_or(Ok(None), |origin| self.three(origin, "xyz", &of))?;
                mass = (value > 0.0).then_some((value, origin.unwrap_or_default()));
            }
        }
        let meshes = node.descendants().filter(|node| node.has_tag_name("mesh"));
        let meshes = meshes.filter_map(|mesh| mesh.attribute("filename").map(str::to_owned));
        Ok(UrdfLink {
            name,
            mass,
            meshes: meshes.collect(),
            at: node.range().start,
        })
    }

    fn joint(
        &self,
        node: Node<'_, '_>,
        links: &HashMap<String, usize>,
    ) -> Result<UrdfJoint, ImportError> {
        let name = self.name(node, "a joint")?;
        let of = format!("joint `{name}`");
        let motion = match self.attribute(node, "type", &of)? {
            "fixed" => UrdfMotion::Fixed,
            "revolute" => UrdfMotion::Revolute,
            "continuous" => UrdfMotion::Continuous,
            "prismatic" => UrdfMotion::Prismatic,
            "floating" => UrdfMotion::Other("floating"),
            "planar" => UrdfMotion::Other("planar"),
            "spherical" => UrdfMotion::Other("spherical"),
            other => {
                let message = format!("{of}: there is no type `{other}`");
                let help = "a joint is fixed, revolute, continuous or prismatic";
                return Err(self.error(node, message, help));
            }
        };
        let child_of =
            |name: &'static str| node.children().find(move |child| child.has_tag_name(name));
        let link = |role: &'static str| {
            let Some(element) = child_of(role) else {
                return Err(self.error(node, format!("{of} has no <{role}>"), "name the link"));
            };
            let link = self.attribute(element, "link", &of)?;
            links.get(link).copied().ok_or_else(|| {
                let near = crate::nearest::nearest(link, links.keys().map(String::as_str));
                let help = near.map_or_else(
                    || "each <parent> and <child> names a <link> of the file".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                );
                self.error(element, format!("{of}: there is no link `{link}`"), &help)
            })
        };
        let (parent, child) = (link("parent")?, link("child")?);
        let mut xyz_rpy = [[0.0; 3]; 2];
        if let Some(origin) = child_of("origin") {
            for (value, name) in xyz_rpy.iter_mut().zip(["xyz", "rpy"]) {
                *value = self.three(origin, name, &of)?.unwrap_or_default();
            }
        }
        let axis = match child_of("axis") {
            Some(axis) => self.three(axis, "xyz", &of)?,
            None => None,
        };
        let (mut limits, mut no_limits) = (None, None);
        if let Some(limit) = child_of("limit") {
            // Files write 1e16 for "none": only what is no number is refused.
            let bound = |name: &str| {
                let text = limit.attribute(name).unwrap_or("0").trim();
                match text.parse::<f64>() {
                    Ok(number) if !number.is_nan() => Ok(number),
                    _ => self.number(limit, name, text, &of),
                }
            };
            let [lower, upper] = [bound("lower")?, bound("upper")?];
            if lower < upper && lower.abs().max(upper.abs()) < UNLIMITED {
                limits = Some([lower, upper]);
            } else if lower > upper {
                no_limits = Some(format!(
                    "has a lower limit of {lower} above its upper limit of {upper}"
                ));
            }
        }
        let mut mimic = None;
        if let Some(element) = child_of("mimic") {
            let value = |name: &str, default: &str| {
                let text = element.attribute(name).unwrap_or(default);
                self.number(element, name, text, &of)
            };
            let master = self.attribute(element, "joint", &of)?.to_owned();
            mimic = Some((master, value("multiplier", "1")?, value("offset", "0")?));
        }
        Ok(UrdfJoint {
            name,
            motion,
            parent,
            child,
            xyz_m: xyz_rpy[0],
            rpy_rad: xyz_rpy[1],
            axis: axis.unwrap_or([1.0, 0.0, 0.0]),
            limits,
            no_limits,
            mimic,
            at: node.range().start,
        })
    }
}
