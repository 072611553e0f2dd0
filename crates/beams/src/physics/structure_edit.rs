//! What a robot file may say wrongly or leave out, and the structure without that mistake.

use crate::robot::{
    BodyPlace, ElementClass, FileLength, FittingFactors, Mechanism, ModelParameter, Pose, Robot,
};
use crate::structure::Property;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Key};

use super::effect::{Effect, EffectError};
use super::law::Law;
use super::laws::{FACTOR_GROUP, JOINT_OFFSET, LINK_LENGTH, SECTION_ERROR};
use super::place::Place;

/// Entries of a robot file that may be wrong and springs that it may lack, for one mechanism.
#[derive(Debug, Clone)]
pub struct FileSuspects {
    lengths: Vec<FileLength>,
    places: Vec<(Law, Place)>,
}

impl FileSuspects {
    /// Lengths, angles of joints, sections and factors that a mechanism rests on, and springs of its structure.
    ///
    /// # Arguments
    /// - `poses`: those in which one angle alone may be wrong.
    /// - `free`: parameters that a fit determines anyway.
    #[must_use]
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        poses: &[PoseId],
        free: &[ModelParameter],
    ) -> Self {
        let lengths = robot.lengths();
        let of_length = lengths.iter().map(|length| {
            let (body, entry) = (length.body.clone(), length.entry.clone());
            (LINK_LENGTH, Place::Length { body, entry })
        });
        let joints = mechanism.joints(robot).into_iter();
        let turned = joints.filter(|joint| turned_body(robot, *joint).is_some());
        let of_joint = turned.flat_map(|joint| {
            let joint = robot.joints[joint].name.clone();
            let poses = std::iter::once(None).chain(poses.iter().cloned().map(Some));
            poses.map(move |pose| {
                let joint = joint.clone();
                (JOINT_OFFSET, Place::JointAngle { joint, pose })
            })
        });
        let mut places: Vec<(Law, Place)> = of_length.chain(of_joint).collect();
        places.extend(sections(robot, mechanism, free));
        places.extend(groups(robot, mechanism));
        let all = ModelParameter::all(robot, mechanism).into_iter();
        let springs = all.filter(|spring| !spring.is_beside_structure() && !free.contains(spring));
        let springs = springs.filter_map(|spring| Effect::of_spring(&spring, 0.0));
        // That of a slide along its axis is a law in its joint.
        let springs = springs.filter(|effect| effect.spring_of_structure().is_some());
        places.extend(springs.map(|effect| (effect.law, effect.place)));
        Self { lengths, places }
    }

    /// Laws and places.
    #[must_use]
    pub fn places(&self) -> &[(Law, Place)] {
        &self.places
    }

    /// The length at a place.
    #[must_use]
    pub fn length(&self, place: &Place) -> Option<&FileLength> {
        let Place::Length { body, entry } = place else {
            return None;
        };
        let mut lengths = self.lengths.iter();
        lengths.find(|length| length.body == *body && length.entry == *entry)
    }
}

/// A line of a robot file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FileLine {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// What stands there.
    pub text: String,
}

impl FileLine {
    /// The line of a robot file that states what a mistake is of; `None` for effects that are no such mistake.
    ///
    /// # Arguments
    /// - `factors`: name of the factors that the model starts from.
    #[must_use]
    pub fn of(
        robot: &Robot,
        suspects: &FileSuspects,
        factors: &str,
        effect: &Effect,
    ) -> Option<Self> {
        let source = &robot.source;
        let begins = |path: &[DocumentStep<'_>]| source.toml_key_span(path).start;
        let variable = |joint: &str| {
            let joint = robot.joints.iter().position(|known| known.name == joint)?;
            match &robot.bodies[turned_body(robot, joint)?].place {
                BodyPlace::Turned { angle, .. } => angle.terms.first(),
                _ => None,
            }
        };
        let at = match &effect.place {
            place @ Place::Length { .. } => suspects.length(place)?.begins,
            Place::JointAngle { joint, pose } => {
                let name = &robot.variables[variable(joint)?.0].name;
                match pose {
                    Some(pose) => {
                        let path = [Key("poses"), Key(pose.as_str()), Key(name)];
                        // A pose that only a table of loads has is in no line of the file.
                        let is_there = source.toml_span(&path[..2]) != source.toml_span(&path[..1]);
                        is_there.then(|| begins(&path))?
                    }
                    None => begins(&[Key("variables"), Key(name)])
                        .max(begins(&[Key("joints"), Key(joint)])),
                }
            }
            Place::Element(element) if effect.law == SECTION_ERROR => {
                let member = robot
                    .members
                    .iter()
                    .find(|member| member.name == *element)?;
                let (section, _) = robot.sections.get_index(member.section)?;
                let quoted = || source.text.find(&format!("\"{section}\""));
                match begins(&[Key("sections"), Key(section)]) {
                    0 => quoted()?,
                    begins => begins,
                }
            }
            Place::Group { group, .. } => begins(&[Key("factors"), Key(factors), Key(group)]),
            _ => return None,
        };
        // Nothing of the kind stands in the file.
        if at == 0 {
            return None;
        }
        let (line, _) = source.line_and_column(at);
        Some(Self {
            file: source.name.clone(),
            line,
            text: source.text.lines().nth(line - 1)?.trim().to_owned(),
        })
    }
}

/// Sections that elements of a mechanism have, each at the first of them.
fn sections(robot: &Robot, mechanism: &Mechanism, free: &[ModelParameter]) -> Vec<(Law, Place)> {
    let mut known: Vec<usize> = Vec::new();
    let mut found = Vec::new();
    for member in mechanism
        .members
        .iter()
        .map(|&member| &robot.members[member])
    {
        let is_free = |property| {
            let name = robot
                .sections
                .get_index(member.section)
                .map(|(name, _)| name);
            name.is_some_and(|name| {
                free.contains(&ModelParameter::Section(name.as_str().into(), property))
            })
        };
        if !known.contains(&member.section) && !Property::ALL.into_iter().any(is_free) {
            known.push(member.section);
            found.push((SECTION_ERROR, Place::Element(member.name.clone())));
        }
    }
    found
}

/// Classes of elements, by all constants together and by each alone.
fn groups(robot: &Robot, mechanism: &Mechanism) -> impl Iterator<Item = (Law, Place)> {
    let members = || {
        mechanism
            .members
            .iter()
            .map(|&member| &robot.members[member])
    };
    let is_there = |class: ElementClass| members().any(|member| member.class == class);
    let classes = [(ElementClass::Beam, "beam"), (ElementClass::Link, "link")];
    let there: Vec<&str> = classes
        .into_iter()
        .filter_map(|(class, name)| is_there(class).then_some(name))
        .collect();
    there.into_iter().flat_map(|group| {
        let each = Property::ALL.into_iter().map(Some);
        std::iter::once(None).chain(each).map(move |property| {
            let group = group.to_owned();
            (FACTOR_GROUP, Place::Group { group, property })
        })
    })
}

/// The body that a joint turns, if its angle follows from the pose.
fn turned_body(robot: &Robot, joint: usize) -> Option<usize> {
    let joint = &robot.joints[joint];
    joint
        .bodies
        .into_iter()
        .find(|&body| match &robot.bodies[body].place {
            BodyPlace::Turned { origin, angle, .. } => {
                *origin == joint.node && !angle.terms.is_empty()
            }
            _ => false,
        })
}

/// Changes of a structure that effects ask for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StructureEdit {
    /// Lengths, and what is added to each, m.
    lengths: Vec<(FileLength, f64)>,
    /// Bodies whose angle is another, in all poses or in one, degrees.
    angles: Vec<(usize, Option<PoseId>, f64)>,
    /// Groups of elements whose section constants are multiplied.
    scales: Vec<(ScaledElements, f64)>,
    /// Springs, and what is added to the compliance of each.
    springs: Vec<(ModelParameter, f64)>,
}

/// Elements whose section constants are scaled together.
#[derive(Debug, Clone, PartialEq)]
enum ScaledElements {
    Section(String),
    Class(ElementClass, Option<Property>),
    Group(String, Option<Property>),
}

impl StructureEdit {
    /// The changes that effects ask for; effects that change no structure are passed over.
    ///
    /// # Errors
    /// [`EffectError::Unknown`] for a length, joint, element or group that is not there.
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        suspects: &FileSuspects,
        effects: &[Effect],
    ) -> Result<Self, EffectError> {
        let mut edit = Self::default();
        for effect in effects {
            let Some(&value) = effect.values.first() else {
                continue;
            };
            edit.springs.extend(effect.spring_of_structure());
            let unknown = |kind, known: Vec<String>| EffectError::Unknown {
                place: effect.place.clone(),
                mechanism: mechanism.name.clone(),
                kind,
                known,
            };
            match &effect.place {
                place @ Place::Length { .. } => {
                    let known = || {
                        suspects
                            .lengths
                            .iter()
                            .map(|known| format!("{}.{}", known.body, known.entry))
                    };
                    let length = suspects
                        .length(place)
                        .ok_or_else(|| unknown("length", known().collect()))?;
                    edit.lengths.push((length.clone(), value));
                }
                Place::JointAngle { joint, pose } => {
                    let joints = mechanism.joints(robot);
                    let named = |place: &&usize| robot.joints[**place].name == *joint;
                    let known = || joints.iter().map(|&joint| robot.joints[joint].name.clone());
                    let body = joints
                        .iter()
                        .find(named)
                        .and_then(|joint| turned_body(robot, *joint));
                    let body = body.ok_or_else(|| unknown("joint", known().collect()))?;
                    edit.angles.push((body, pose.clone(), value.to_degrees()));
                }
                Place::Element(element) if effect.law == SECTION_ERROR => {
                    let members = || {
                        mechanism
                            .members
                            .iter()
                            .map(|&member| &robot.members[member])
                    };
                    let member = members().find(|member| member.name == *element);
                    let known = || members().map(|member| member.name.clone()).collect();
                    let section =
                        member.and_then(|member| robot.sections.get_index(member.section));
                    let (name, _) = section.ok_or_else(|| unknown("element", known()))?;
                    edit.scales
                        .push((ScaledElements::Section(name.clone()), 1.0 + value));
                }
                Place::Group { group, property } => {
                    let elements = match group.as_str() {
                        "beam" => ScaledElements::Class(ElementClass::Beam, *property),
                        "link" => ScaledElements::Class(ElementClass::Link, *property),
                        _ => ScaledElements::Group(group.clone(), *property),
                    };
                    edit.scales.push((elements, 1.0 + value));
                }
                _ => {}
            }
        }
        Ok(edit)
    }

    /// Springs that are put into the structure.
    pub fn springs(&self) -> impl Iterator<Item = &ModelParameter> {
        self.springs.iter().map(|(spring, _)| spring)
    }

    /// Whether lengths or angles change, not factors alone.
    #[must_use]
    pub fn changes_geometry(&self) -> bool {
        !(self.lengths.is_empty() && self.angles.is_empty())
    }

    /// The robot with other lengths and angles.
    #[must_use]
    pub fn robot(&self, robot: &Robot) -> Robot {
        let mut changed = robot.clone();
        for (length, by_m) in &self.lengths {
            changed = length.changed(&changed, *by_m);
        }
        for (body, pose, by_deg) in &self.angles {
            if let BodyPlace::Turned { angle, .. } = &mut changed.bodies[*body].place
                && pose.is_none()
            {
                angle.offset_deg += by_deg;
            }
        }
        changed
    }

    /// A pose with the angles that are wrong in it alone.
    #[must_use]
    pub fn pose(&self, robot: &Robot, id: &PoseId, pose: &Pose) -> Pose {
        let mut changed = pose.clone();
        for (body, only, by_deg) in &self.angles {
            if let BodyPlace::Turned { angle, .. } = &robot.bodies[*body].place
                && only.as_ref() == Some(id)
                && let Some((variable, coefficient)) = angle.terms.first()
            {
                changed.angles_deg[*variable] += by_deg / coefficient;
            }
        }
        changed
    }

    /// Factors with the errors of sections and groups, and with springs.
    #[must_use]
    pub fn factors(&self, factors: &FittingFactors) -> FittingFactors {
        let mut changed = factors.clone();
        for (spring, compliance) in &self.springs {
            changed.set(spring, changed.get(spring) + compliance);
        }
        for (elements, times) in &self.scales {
            let (target, property) = match elements {
                ScaledElements::Section(name) => {
                    let target = changed.sections.entry(name.clone()).or_insert([1.0; 4]);
                    (target, None)
                }
                ScaledElements::Class(ElementClass::Beam, property) => {
                    (&mut changed.beam, *property)
                }
                ScaledElements::Class(ElementClass::Link, property) => {
                    (&mut changed.link, *property)
                }
                ScaledElements::Group(name, property) => {
                    let target = changed.groups.entry(name.clone()).or_insert([1.0; 4]);
                    (target, *property)
                }
            };
            for (place, factor) in target.iter_mut().enumerate() {
                if property.is_none_or(|property| property.index() == place) {
                    *factor *= times;
                }
            }
        }
        changed
    }
}
