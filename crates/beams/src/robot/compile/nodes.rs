//! Nodes: where they are, and which of them hold the robot.

use std::sync::Arc;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file::{NodeEntry, Radius};
use crate::robot::model::{NodePlace, RadiusOf, RobotNode};
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use super::Compiler;

impl Compiler<'_> {
    pub(super) fn nodes(&self) -> Result<Vec<RobotNode>, RobotError> {
        let node = |(name, entry): (&String, &NodeEntry)| {
            Ok(RobotNode {
                name: Arc::from(name.as_str()),
                place: self.node_place(name, entry)?,
            })
        };
        self.file.nodes.iter().map(node).collect()
    }

    fn node_place(&self, name: &str, entry: &NodeEntry) -> Result<NodePlace, RobotError> {
        let at = |key| [Key("nodes"), Key(name), Key(key)];
        match entry {
            NodeEntry::Fixed {
                on,
                at: coordinates,
            } => {
                let mut at_m = [0.0; 3];
                for (place, (value, expression)) in at_m.iter_mut().zip(coordinates).enumerate() {
                    *value = self.value(expression, &[&at("at")[..], &[Index(place)]].concat())?;
                }
                Ok(NodePlace::Fixed {
                    body: self.body(on, &at("on"))?,
                    at_m,
                })
            }
            NodeEntry::Loop {
                circles,
                plane,
                branch,
            } => {
                if ![1, -1].contains(branch) {
                    let problem = RobotProblem::Impossible {
                        what: format!("the branch of {name}"),
                        value: *branch as f64,
                        must: "it must be 1 or -1",
                    };
                    return Err(self.error(&at("branch"), problem));
                }
                let circle = |place: usize| {
                    let path = |inner| {
                        [
                            Key("nodes"),
                            Key(name),
                            Key("loop"),
                            Index(place),
                            Index(inner),
                        ]
                    };
                    let (centre, radius) = &circles[place];
                    Ok::<_, RobotError>((
                        self.node(centre, &path(0))?,
                        self.radius(radius, &path(1))?,
                    ))
                };
                let [first, second] = [circle(0)?, circle(1)?];
                self.apart(
                    [first.0, second.0],
                    &at("loop"),
                    "a loop needs two different centres",
                )?;
                Ok(NodePlace::Loop {
                    centres: [first.0, second.0],
                    radii: [first.1, second.1],
                    plane: self.plane(plane, &at("plane"))?,
                    branch: *branch as f64,
                })
            }
        }
    }

    fn radius(&self, radius: &Radius, path: &[DocumentStep<'_>]) -> Result<RadiusOf, RobotError> {
        match radius {
            Radius::Distance { dist } => {
                let node = |place: usize| {
                    self.node(&dist[place], &[path, &[Key("dist"), Index(place)]].concat())
                };
                Ok(RadiusOf::Distance([node(0)?, node(1)?]))
            }
            Radius::Length(expression) => {
                let value = self.value(expression, path)?;
                self.positive(value, path, "the radius".to_owned())
                    .map(RadiusOf::Length)
            }
        }
    }

    pub(super) fn supports(&self) -> Result<Vec<usize>, RobotError> {
        let fixed = &self.file.support.fixed;
        let path = [Key("support"), Key("fixed")];
        let nodes = self.names(fixed, &path, Self::node)?;
        for (place, node) in nodes.iter().enumerate() {
            if nodes[..place].contains(node) {
                let problem = RobotProblem::Duplicate {
                    kind: "support",
                    name: fixed[place].clone(),
                };
                return Err(self.error(&[&path[..], &[Index(place)]].concat(), problem));
            }
        }
        Ok(nodes)
    }

    /// Refuses one node where two are needed.
    pub(super) fn apart(
        &self,
        [first, second]: [usize; 2],
        path: &[DocumentStep<'_>],
        message: &'static str,
    ) -> Result<(), RobotError> {
        if first == second {
            return Err(self.error(path, RobotProblem::Shape(message)));
        }
        Ok(())
    }
}
