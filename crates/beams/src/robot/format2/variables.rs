//! The coordinates of a pose, and their limits.

use indexmap::IndexMap;

use stiffbench_units_and_text::toml_text::DocumentStep::Key;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model::Variable;
use crate::robot::spring_axis::JointMotion;

use super::builder::RobotBuilder;
use super::file::{JointKind, VariableRow};

/// Limits of a variable for which a file gives none: degrees, m.
pub const DEFAULT_LIMITS: [f64; 2] = [180.0, 1.0];

/// Limits and nominal value, as far as they are given.
#[derive(Default)]
struct GivenBounds {
    slides: bool,
    bounds: [Option<f64>; 3],
}

impl RobotBuilder<'_> {
    /// The variables, in the order in which joints name them.
    pub(super) fn place_variables(&mut self) -> Result<(), RobotError> {
        let mut given: IndexMap<String, GivenBounds> = IndexMap::new();
        let file = self.file;
        let slides_of = |name: &str| {
            file.joints
                .get(name)
                .map(|row| row.kind == JointKind::Sliding)
        };
        for (name, row) in file.joints.iter().filter(|(_, row)| row.point.is_none()) {
            let at = |key| [Key("joints"), Key(name.as_str()), Key(key)];
            let slides = row.kind == JointKind::Sliding;
            let own = match &row.angle {
                None => vec![name],
                Some(terms) => {
                    let terms = terms.keys().filter(|term| *term != "offset");
                    terms.collect()
                }
            };
            for variable in &own {
                let slides = slides_of(variable).unwrap_or(slides);
                let entry = given.entry((*variable).clone()).or_default();
                entry.slides = slides;
            }
            let bounds = [&row.min, &row.max, &row.nominal];
            if bounds.iter().all(|bound| bound.is_none()) {
                continue;
            }
            if !own.contains(&name) {
                let message = "limits of a joint with an `angle` of other variables stand in [variables.NAME]";
                return Err(self.error(&at("angle"), RobotProblem::Shape(message)));
            }
            for (place, key) in ["min", "max", "nominal"].into_iter().enumerate() {
                if let Some(bound) = bounds[place] {
                    let value = self.travel(bound, slides, &at(key))?;
                    given[name.as_str()].bounds[place] = Some(value);
                }
            }
        }
        for (name, row) in &file.variables {
            let known = given.keys().map(String::as_str);
            let path = [Key("variables"), Key(name)];
            let place = self.found(
                given.get_index_of(name),
                &path,
                "joint that uses the variable",
                name,
                known,
            )?;
            let VariableRow { min, max, nominal } = row;
            for (bound, (value, key)) in [(min, "min"), (max, "max"), (nominal, "nominal")]
                .into_iter()
                .enumerate()
            {
                if let Some(value) = value {
                    let slides = given[place].slides;
                    let value = self.travel(value, slides, &[path[0], path[1], Key(key)])?;
                    given[place].bounds[bound] = Some(value);
                }
            }
        }
        for (name, given) in given {
            let variable = self.finished_variable(name, &given)?;
            self.variables.insert(variable.name.clone(), variable);
        }
        Ok(())
    }

    fn finished_variable(
        &mut self,
        name: String,
        given: &GivenBounds,
    ) -> Result<Variable, RobotError> {
        let table = if self.file.joints.contains_key(&name) {
            "joints"
        } else {
            "variables"
        };
        let path = [Key(table), Key(&name)];
        let [min, max, nominal] = given.bounds;
        let default = DEFAULT_LIMITS[usize::from(given.slides)];
        if min.is_none() || max.is_none() {
            let (unit, line) = (if given.slides { "m" } else { "degrees" }, self.line(&path));
            self.warnings.push(format!(
                "line {line}: `{name}` has no limits, {} to {} {unit} are taken: add `min` and `max`",
                min.unwrap_or(-default),
                max.unwrap_or(default)
            ));
        }
        let (min_deg, max_deg) = (min.unwrap_or(-default), max.unwrap_or(default));
        if min_deg > max_deg {
            let problem = RobotProblem::Impossible {
                what: format!("the smallest value of {name}"),
                value: min_deg,
                must: "it must not be above the largest",
            };
            return Err(self.error(&[path[0], path[1], Key("min")], problem));
        }
        Ok(Variable {
            motion: if given.slides {
                JointMotion::Slides
            } else {
                JointMotion::Turns
            },
            min_deg,
            max_deg,
            nominal_deg: nominal.unwrap_or_else(|| 0.0_f64.clamp(min_deg, max_deg)),
            name,
        })
    }
}
