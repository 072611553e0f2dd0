//! Named factor sets and named poses.

use indexmap::IndexMap;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file::{self, PoseValue};
use crate::robot::model::{FittingFactors, NamedPose, Pose};
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::Step::{Index, Key};

use super::Compiler;

impl Compiler<'_> {
    pub(super) fn factors(&self) -> Result<IndexMap<String, FittingFactors>, RobotError> {
        let mut sets = IndexMap::new();
        for (name, entry) in &self.file.factors {
            let class = |class: &str, factors: file::FactorEntry| -> Result<[f64; 4], RobotError> {
                let factor = |value, key| {
                    let path = [Key("factors"), Key(name), Key(class), Key(key)];
                    self.positive(value, &path, format!("factor {key} of {class} in {name}"))
                };
                Ok([
                    factor(factors.area, "A")?,
                    factor(factors.iy, "Iy")?,
                    factor(factors.iz, "Iz")?,
                    factor(factors.j, "J")?,
                ])
            };
            let set = FittingFactors {
                beam: class("beam", entry.beam)?,
                link: class("link", entry.link)?,
            };
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
