//! Named factor sets and named poses.

use indexmap::IndexMap;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file::PoseValue;
use crate::robot::model::{NamedPose, Pose};
use crate::robot::{FittingFactors, ModelParameter};
use crate::structure::Property;
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use super::Compiler;

impl Compiler<'_> {
    pub(super) fn factors(&self) -> Result<IndexMap<String, FittingFactors>, RobotError> {
        let mut sets = IndexMap::new();
        for (name, entry) in &self.file.factors {
            let factors = |path: &[DocumentStep<'_>], of: String, values: [f64; 4]| {
                for (value, property) in values.into_iter().zip(Property::ALL) {
                    let (key, what) = (
                        property.name(),
                        format!("factor {} of {of}", property.name()),
                    );
                    self.positive(value, &[path, &[Key(key)]].concat(), what)?;
                }
                Ok::<(), RobotError>(())
            };
            let set = entry.values().map_err(|error| {
                let path = [Key("factors"), Key(name), Key("springs")];
                self.error(&path, RobotProblem::Syntax(error.to_string()))
            })?;
            if let Some(group) = set.groups.keys().next() {
                let path = [Key("factors"), Key(name), Key("groups"), Key(group)];
                self.found(None, &path, "group", group, std::iter::empty())?;
            }
            factors(
                &[Key("factors"), Key(name), Key("beam")],
                format!("beam in {name}"),
                set.beam,
            )?;
            factors(
                &[Key("factors"), Key(name), Key("link")],
                format!("link in {name}"),
                set.link,
            )?;
            for (section, values) in &set.sections {
                let path = [Key("factors"), Key(name), Key("sections"), Key(section)];
                let known = self.file.sections.keys().map(String::as_str);
                let place = self.file.sections.get_index_of(section);
                self.found(place, &path, "section", section, known)?;
                factors(&path, format!("section {section} in {name}"), *values)?;
            }
            for (spring, &value) in &set.springs {
                let parameter = spring.to_string();
                let (table, key) = match spring {
                    _ if entry.springs.contains_key(&parameter) => ("springs", parameter.clone()),
                    ModelParameter::Joint(joint) => ("joints_rad_per_Nm", joint.to_string()),
                    _ => ("base_rad_per_Nm", parameter.replace("base.r", "")),
                };
                let path = [Key("factors"), Key(name), Key(table), Key(&key)];
                if let Some(joint) = spring.joint() {
                    let known = self.file.joints.iter().map(|entry| entry.id.as_str());
                    let place = known.clone().position(|id| id == joint);
                    self.found(place, &path, "joint", joint, known)?;
                }
                if !(value.is_finite() && value >= 0.0) {
                    let what = format!("compliance {parameter} in {name}");
                    let must = "it must be finite and not negative";
                    return Err(self.error(&path, RobotProblem::Impossible { what, value, must }));
                }
            }
            sets.insert(name.clone(), set);
        }
        Ok(sets)
    }

    pub(super) fn poses(&self) -> Result<Vec<NamedPose>, RobotError> {
        let nominal: Vec<f64> = self
            .variables()?
            .iter()
            .map(|variable| variable.nominal_deg)
            .collect();
        let mut poses = Vec::new();
        for (name, entry) in &self.file.poses {
            let mut pose = NamedPose {
                id: PoseId::new(name),
                pose: Pose {
                    angles_deg: nominal.clone(),
                },
                stated_zy_m: None,
            };
            for (key, value) in entry {
                let path = [Key("poses"), Key(name), Key(key)];
                match value {
                    PoseValue::Point(point) if key == "paper_z_y" => {
                        for (place, value) in point.iter().enumerate() {
                            self.number(*value, &[&path[..], &[Index(place)]].concat())?;
                        }
                        pose.stated_zy_m = Some(*point);
                    }
                    PoseValue::Angle(expression) => {
                        let variable = self.variable(key, &path)?;
                        pose.pose.angles_deg[variable] = self.value(expression, &path)?;
                    }
                    PoseValue::Point(_) => {
                        return Err(self.error(
                            &path,
                            RobotProblem::Shape("only `paper_z_y` may be a point"),
                        ));
                    }
                }
            }
            poses.push(pose);
        }
        Ok(poses)
    }
}
