//! Named poses.

use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::DocumentStep::{Index, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model::{NamedPose, Pose};

use super::builder::RobotBuilder;
use super::file::PoseAngles;

impl RobotBuilder<'_> {
    pub(super) fn poses(&self) -> Result<Vec<NamedPose>, RobotError> {
        let nominal = self.variables.values().map(|variable| variable.nominal_deg);
        let nominal: Vec<f64> = nominal.collect();
        let mut poses = Vec::new();
        for (name, row) in &self.file.poses {
            let path = [Key("poses"), Key(name.as_str())];
            let mut values = nominal.clone();
            match row {
                PoseAngles::Named(entries) => {
                    for (variable, value) in entries {
                        let path = [path[0], path[1], Key(variable)];
                        let place = self.variable(variable, &path)?;
                        values[place] = self.travel(value, self.slides(place), &path)?;
                    }
                }
                PoseAngles::Listed(entries) => {
                    if entries.len() != values.len() {
                        let names: Vec<&str> = self.variables.keys().map(String::as_str).collect();
                        let problem = RobotProblem::Syntax(format!(
                            "a pose has {} values, this one has {}",
                            values.len(),
                            entries.len()
                        ));
                        return Err(self.error_with(
                            &path,
                            problem,
                            format!("their order is {}", names.join(", ")),
                        ));
                    }
                    for (place, value) in entries.iter().enumerate() {
                        let path = [path[0], path[1], Index(place)];
                        values[place] = self.travel(value, self.slides(place), &path)?;
                    }
                }
            }
            poses.push(NamedPose {
                id: PoseId::new(name),
                pose: Pose { angles_deg: values },
                stated_zy_m: None,
            });
        }
        Ok(poses)
    }
}
