//! Springs of joints, base and tool.

use stiffbench_units_and_text::toml_text::DocumentStep::{self, Key};

use crate::robot::Robot;
use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model_parameter::ModelParameter;
use crate::robot::springs::{JointSprings, RoleInFit, SpringDefault, Yielding};

use super::builder::RobotBuilder;
use super::file::{JointKind, JointRow, SpringRow, SpringRows, SpringShape, SpringWord};
use super::measure::{InUnit, MeasuredKind};

/// Largest compliance, rad/(N·m) or m/N, that is taken for meant: a newton that moves a robot by a hundred metres.
const LARGEST_COMPLIANCE: f64 = 1e2;

impl RobotBuilder<'_> {
    /// Springs of a joint.
    pub(super) fn joint_springs(
        &self,
        name: &str,
        row: &JointRow,
    ) -> Result<JointSprings, RobotError> {
        let path = [Key("joints"), Key(name)];
        let slides = row.kind == JointKind::Sliding;
        let own = SpringShape::Table(SpringRow {
            spring: row.spring,
            stiffness: row.stiffness.clone(),
            compliance: row.compliance.clone(),
            tied_to: row.tied_to.clone(),
        });
        let mut own_spring = self.spring(Some(&own), !slides, &path)?;
        if row.point.is_some() && own_spring == SpringDefault::default() && row.spring.is_none() {
            own_spring.yielding = Yielding::Pinned;
        }
        let mut about = [const { None }; 3];
        if let Some(across) = &row.across {
            if across.x.is_some() && !slides {
                let message = "`x` is the joint's own axis: its spring is `stiffness` of the joint, `across` has `y` and `z`";
                return Err(self.error(
                    &[path[0], path[1], Key("across")],
                    RobotProblem::Shape(message),
                ));
            }
            about = [&across.x, &across.y, &across.z].map(Option::as_ref);
        }
        let spring = |axis: usize| {
            let path = [path[0], path[1], Key("across"), Key(["x", "y", "z"][axis])];
            self.spring(about[axis], true, &path)
        };
        Ok(JointSprings {
            own: own_spring,
            about: [spring(0)?, spring(1)?, spring(2)?],
        })
    }

    /// Springs along and about three axes.
    pub(super) fn six_springs(
        &self,
        rows: &SpringRows,
        path: &[DocumentStep<'_>],
    ) -> Result<[SpringDefault; 6], RobotError> {
        let all = [&rows.x, &rows.y, &rows.z, &rows.rx, &rows.ry, &rows.rz];
        let mut springs: [SpringDefault; 6] = Default::default();
        for (axis, row) in all.into_iter().enumerate() {
            let path = [path, &[Key(["x", "y", "z", "rx", "ry", "rz"][axis])]].concat();
            springs[axis] = self.spring(row.as_ref(), axis >= 3, &path)?;
        }
        Ok(springs)
    }

    pub(super) fn base_springs(&self) -> Result<[SpringDefault; 6], RobotError> {
        match &self.file.base {
            Some(base) => self.six_springs(&base.springs, &[Key("base"), Key("springs")]),
            None => Ok(Default::default()),
        }
    }

    /// A spring that turns, or one along an axis.
    fn spring(
        &self,
        row: Option<&SpringShape>,
        turns: bool,
        path: &[DocumentStep<'_>],
    ) -> Result<SpringDefault, RobotError> {
        let row = match row {
            None => return Ok(SpringDefault::default()),
            Some(SpringShape::Table(row)) => row,
            Some(SpringShape::Word(word)) => &SpringRow {
                spring: Some(*word),
                ..SpringRow::default()
            },
        };
        let at = |key| [path, &[Key(key)]].concat();
        let shape = |message| Err(self.error(path, RobotProblem::Shape(message)));
        let compliance = match (&row.stiffness, &row.compliance) {
            (Some(_), Some(_)) => {
                return shape("a spring has either `stiffness` or `compliance`, not both");
            }
            (Some(stiffness), None) => {
                let path = at("stiffness");
                self.check_turning(stiffness, turns, &path)?;
                Some(1.0 / self.positive(stiffness, &path, "the stiffness")?)
            }
            (None, Some(compliance)) => {
                let path = at("compliance");
                self.check_turning(compliance, turns, &path)?;
                Some(compliance.number())
            }
            (None, None) => None,
        };
        if let Some(value) = compliance
            && !(0.0..=LARGEST_COMPLIANCE).contains(&value)
        {
            let problem = RobotProblem::Impossible {
                what: "the compliance".to_owned(),
                value,
                must: "it must be zero or above, and small",
            };
            return Err(self.error(path, problem));
        }
        if row.tied_to.is_some() && row.spring != Some(SpringWord::Tied) {
            return shape("`tied_to` belongs to `spring = \"tied\"`");
        }
        let yielding = compliance.map_or(Yielding::Rigid, Yielding::Compliance);
        let with = |yielding, in_fit| Ok(SpringDefault { yielding, in_fit });
        match (row.spring, compliance) {
            (None | Some(SpringWord::Rigid), None) => Ok(SpringDefault::default()),
            (Some(SpringWord::Pinned), None) => with(Yielding::Pinned, RoleInFit::Fixed),
            (None | Some(SpringWord::Fixed), Some(_)) => with(yielding, RoleInFit::Fixed),
            // What only the data can tell starts rigid, and is a spring all the same.
            (Some(SpringWord::Free), _) => with(
                Yielding::Compliance(compliance.unwrap_or(0.0)),
                RoleInFit::Free,
            ),
            (Some(SpringWord::Tied), None) => {
                let Some(other) = &row.tied_to else {
                    return shape(
                        "a tied spring needs `tied_to`, for example `tied_to = \"joint.J2\"`",
                    );
                };
                let parameter = ModelParameter::try_from(other.clone()).map_err(|error| {
                    self.error(&at("tied_to"), RobotProblem::Syntax(error.to_string()))
                })?;
                with(Yielding::Compliance(0.0), RoleInFit::Tied(parameter))
            }
            (Some(SpringWord::Fixed), None) => {
                shape("a fixed spring needs `stiffness` or `compliance`")
            }
            (Some(SpringWord::Rigid | SpringWord::Pinned), Some(_)) => shape(
                "a rigid joint and a pin have no stiffness: leave it out, or write `spring = \"fixed\"`",
            ),
            (Some(SpringWord::Tied), Some(_)) => {
                shape("a tied spring has the stiffness of the other: leave its stiffness out")
            }
        }
    }

    /// Refuses N/m where a joint turns, and N·m/rad along an axis.
    fn check_turning<K>(
        &self,
        measured: &InUnit<K>,
        turns: bool,
        path: &[DocumentStep<'_>],
    ) -> Result<(), RobotError> {
        let is_turning = match measured.kind {
            Some(MeasuredKind::TurningStiffness | MeasuredKind::TurningCompliance) => true,
            Some(_) => false,
            None => return Ok(()),
        };
        if is_turning == turns {
            return Ok(());
        }
        let message = if turns {
            "this spring turns: its key may end in Nm_per_rad, kNm_per_rad, MNm_per_rad, rad_per_Nm, urad_per_Nm"
        } else {
            "this spring is along an axis: its key may end in N_per_m, N_per_mm, N_per_um, m_per_N, um_per_N"
        };
        Err(self.error(path, RobotProblem::Shape(message)))
    }

    /// Gives tied springs the value of the other, and refuses ties to what is not there.
    pub(super) fn tie(&self, robot: &mut Robot) -> Result<(), RobotError> {
        let mechanism = robot.mechanism(None)?.clone();
        let springs: Vec<(ModelParameter, SpringDefault)> = robot
            .own_springs()
            .map(|(parameter, spring)| (parameter, spring.clone()))
            .collect();
        for (parameter, spring) in &springs {
            let RoleInFit::Tied(other) = &spring.in_fit else {
                continue;
            };
            let joint = parameter.joint().map(str::to_owned);
            let refused = |message: String| {
                let path = match &joint {
                    Some(joint) => vec![Key("joints"), Key(joint)],
                    None if matches!(parameter, ModelParameter::Base(_)) => {
                        vec![Key("base"), Key("springs")]
                    }
                    None => vec![Key("tool"), Key("springs")],
                };
                self.error(&path, RobotProblem::Syntax(message))
            };
            let other = ModelParameter::find(robot, &mechanism, &other.to_string())
                .map_err(|error| refused(error.to_string()))?;
            let of_other = springs.iter().find(|(known, _)| *known == other);
            let Some((_, of_other)) =
                of_other.filter(|(_, spring)| !matches!(spring.in_fit, RoleInFit::Tied(_)))
            else {
                let message =
                    format!("{parameter} is tied to {other}, which is not an independent spring");
                return Err(refused(message));
            };
            let tied = SpringDefault {
                yielding: of_other.yielding,
                in_fit: RoleInFit::Tied(other),
            };
            if let Some(spring) = spring_of(robot, parameter) {
                *spring = tied;
            }
        }
        Ok(())
    }
}

/// The spring that a parameter is of.
fn spring_of<'r>(
    robot: &'r mut Robot,
    parameter: &ModelParameter,
) -> Option<&'r mut SpringDefault> {
    let name = parameter.joint().unwrap_or_default().to_owned();
    let mut joints = robot.joints.iter_mut();
    let joint = joints.find(|joint| joint.name == name);
    match parameter {
        ModelParameter::Joint(_) | ModelParameter::JointAlong(_) => {
            joint.map(|joint| &mut joint.springs.own)
        }
        ModelParameter::JointAbout(_, axis) => {
            joint.map(|joint| &mut joint.springs.about[axis.index()])
        }
        ModelParameter::Base(axis) => Some(&mut robot.base[axis.index()]),
        ModelParameter::Tool(axis) => Some(&mut robot.tool.springs[axis.index()]),
        _ => None,
    }
}
