//! Names of a file: which may be used, and what they refer to.

use std::ops::Range;

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::expression::ExpressionError;
use crate::robot::spring_axis::JointMotion;

use super::builder::{BASE, RobotBuilder, TOOL};
use super::measure::units;

/// Whether a name ends in an underscore and a unit, so that a key of it would be taken for one with a unit.
#[must_use]
pub fn ends_in_unit(name: &str) -> bool {
    let stem = |unit: &str| name.strip_suffix(unit).map(|stem| stem.ends_with('_'));
    units().into_iter().any(|unit| stem(unit) == Some(true))
}

impl RobotBuilder<'_> {
    /// Refuses names that could be taken for something else.
    pub(super) fn check_names(&self) -> Result<(), RobotError> {
        let file = self.file;
        let joints = file.joints.keys().map(|name| ("joints", name));
        let variables = file.variables.keys().map(|name| ("variables", name));
        let points = file.points.keys().map(|name| ("points", name));
        for (table, name) in joints.chain(variables).chain(points) {
            let path = [Key(table), Key(name)];
            if ends_in_unit(name) && table != "points" {
                let message = "a name must not end in an underscore and a unit: keys with its values would be taken for one with a unit";
                return Err(self.error(&path, RobotProblem::Shape(message)));
            }
            if name == "offset" || name == BASE || (name == TOOL && table != "variables") {
                let message = "`base`, `tool` and `offset` are reserved names";
                return Err(self.error(&path, RobotProblem::Shape(message)));
            }
        }
        let both = file
            .points
            .keys()
            .find(|name| file.joints.contains_key(*name));
        if let Some(name) = both {
            let (kind, name) = ("point", name.clone());
            let path = [Key("points"), Key(&name)];
            let problem = RobotProblem::Duplicate {
                kind,
                name: name.clone(),
            };
            return Err(self.error_with(&path, problem, "a joint is a point of its own name"));
        }
        Ok(())
    }

    /// Gives every body its index: the base, those of joints, those along points.
    pub(super) fn name_bodies(&mut self) -> Result<(), RobotError> {
        self.body_names.insert(BASE.to_owned(), 0);
        let file = self.file;
        let of_joints = file.joints.iter().filter(|(_, row)| row.point.is_none());
        let of_joints =
            of_joints.map(|(name, row)| ("joints", name, row.body.as_ref().unwrap_or(name)));
        let along = file.bodies.keys().map(|name| ("bodies", name, name));
        for (table, key, body) in of_joints.chain(along) {
            let index = self.body_names.len();
            if self.body_names.insert(body.clone(), index).is_some() {
                let (kind, name) = ("body", body.clone());
                let problem = RobotProblem::Duplicate { kind, name };
                return Err(self.error_with(
                    &[Key(table), Key(key)],
                    problem,
                    "each body is placed by one joint; the others that it has are given a `point`",
                ));
            }
        }
        Ok(())
    }

    /// The place of a name among known ones, or the error at `path` with the nearest of them.
    pub(super) fn found<'k>(
        &self,
        place: Option<usize>,
        path: &[DocumentStep<'_>],
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        self.found_at(place, self.span(path), kind, name, known)
    }

    /// The same with the bytes to point at.
    fn found_at<'k>(
        &self,
        place: Option<usize>,
        span: Range<usize>,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        place.ok_or_else(|| RobotError::unknown_name(self.source, span, (kind, name), known))
    }

    pub(super) fn body(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let known = self.body_names.keys().map(String::as_str);
        self.found(
            self.body_names.get(name).copied(),
            path,
            "body",
            name,
            known,
        )
    }

    /// A point by name, of those that are there yet.
    pub(super) fn point(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let known = self.nodes.keys().map(String::as_str);
        self.found(self.nodes.get_index_of(name), path, "point", name, known)
    }

    /// A variable whose name is the key at a path.
    pub(super) fn variable(
        &self,
        name: &str,
        path: &[DocumentStep<'_>],
    ) -> Result<usize, RobotError> {
        let known = self.variables.keys().map(String::as_str);
        let place = self.variables.get_index_of(name);
        self.found_at(place, self.key_span(path), "variable", name, known)
    }

    /// Whether a variable is a distance.
    pub(super) fn slides(&self, variable: usize) -> bool {
        let variable = self.variables.get_index(variable);
        variable.is_some_and(|(_, variable)| variable.motion == JointMotion::Slides)
    }

    /// Plane of a name, and its number among those of the model.
    pub(super) fn plane(
        &mut self,
        name: &str,
        path: &[DocumentStep<'_>],
    ) -> Result<usize, RobotError> {
        let known = self.file.planes.keys().map(String::as_str);
        self.found(
            self.file.planes.get_index_of(name),
            path,
            "plane",
            name,
            known,
        )?;
        let row = &self.file.planes[name];
        let at = |key| [Key("planes"), Key(name), Key(key)];
        let body = row
            .on
            .as_ref()
            .map_or(Ok(0), |on| self.body(on, &at("on")))?;
        let normal = self.axis(&row.normal, &at("normal"))?;
        let normal = self.frames[body].direction(normal);
        Ok(self.plane_of(name.to_owned(), body, normal))
    }

    /// The nearest parameter, for an expression that names none.
    pub(super) fn help_for_parameter(&self, problem: &ExpressionError) -> Option<String> {
        let ExpressionError::UnknownName { name } = problem else {
            return None;
        };
        let known = self.file.parameters.keys().map(String::as_str);
        nearest(name, known).map(|near| format!("did you mean `{near}`?"))
    }
}
