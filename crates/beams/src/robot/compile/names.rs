//! Names of a robot file to places, with the nearest name as help for one that does not exist.

use std::collections::HashMap;
use std::ops::Range;

use crate::robot::error::{RobotError, RobotProblem};
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use super::Compiler;

impl<'a> Compiler<'a> {
    /// Places of the entries of an array of tables by their `id`.
    pub(super) fn index(
        &self,
        array: &str,
        kind: &'static str,
        ids: impl Iterator<Item = &'a str>,
    ) -> Result<HashMap<&'a str, usize>, RobotError> {
        let mut places = HashMap::new();
        for (place, id) in ids.enumerate() {
            if places.insert(id, place).is_some() {
                let problem = RobotProblem::Duplicate {
                    kind,
                    name: id.to_owned(),
                };
                return Err(self.error(&[Key(array), Index(place), Key("id")], problem));
            }
        }
        Ok(places)
    }

    /// Turns a found place into itself and a missing one into an error at `path`, with the nearest name as help.
    pub(super) fn found<'k>(
        &self,
        place: Option<usize>,
        path: &[DocumentStep<'_>],
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        self.found_at(place, || self.source.toml_span(path), kind, name, known)
    }

    /// The same with the bytes to point at.
    fn found_at<'k>(
        &self,
        place: Option<usize>,
        span: impl FnOnce() -> Range<usize>,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        place.ok_or_else(|| RobotError::unknown_name(self.source, span(), (kind, name), known))
    }

    /// Places of a list of names.
    pub(super) fn names(
        &self,
        names: &[String],
        path: &[DocumentStep<'_>],
        find: impl Fn(&Self, &str, &[DocumentStep<'_>]) -> Result<usize, RobotError>,
    ) -> Result<Vec<usize>, RobotError> {
        names
            .iter()
            .enumerate()
            .map(|(place, name)| find(self, name, &[path, &[Index(place)]].concat()))
            .collect()
    }

    pub(super) fn node(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let nodes = &self.file.nodes;
        self.found(
            nodes.get_index_of(name),
            path,
            "node",
            name,
            nodes.keys().map(String::as_str),
        )
    }

    pub(super) fn body(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let known = self.file.bodies.iter().map(|b| b.id.as_str());
        self.found(self.bodies.get(name).copied(), path, "body", name, known)
    }

    pub(super) fn joint(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let known = self.file.joints.iter().map(|j| j.id.as_str());
        self.found(self.joints.get(name).copied(), path, "joint", name, known)
    }

    pub(super) fn plane(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<usize, RobotError> {
        let planes = &self.file.planes;
        self.found(
            planes.get_index_of(name),
            path,
            "plane",
            name,
            planes.keys().map(String::as_str),
        )
    }

    /// Place of a variable that a file names as the last key of `path`.
    pub(super) fn variable(
        &self,
        name: &str,
        path: &[DocumentStep<'_>],
    ) -> Result<usize, RobotError> {
        let variables = &self.file.variables;
        let known = variables.keys().map(String::as_str);
        let span = || self.source.toml_key_span(path);
        self.found_at(variables.get_index_of(name), span, "variable", name, known)
    }
}
