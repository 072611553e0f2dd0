//! What an export is written from.

use crate::analysis::{Failure, ResolvedModel, UnknownSprings};
use crate::physics::{Effect, SimulatedRotation};
use crate::robot::{
    GRAVITY_M_PER_S2, JointModel, Masses, MechanismModel, ModelParameter, Pose, Predictor, Robot,
    RobotError, RoleInFit, Theory,
};
use crate::structure::Hinge;
use crate::vector::scale;

use super::inertia::{Inertia, PLACEHOLDER};
use super::kinematics::{KinematicTree, STIFFEST, SpringOfJoint};
use super::lumped::{LumpedModel, LumpedParts};
use super::mjcf::mjcf;
use super::sdf::sdf;
use super::table::{ExportTable, ParameterRow, PoseRow};
use super::urdf::urdf;
use super::xml::{number, rounded};

/// Name of the pose in which every variable has its nominal value.
const NOMINAL: &str = "nominal";

/// A robot with factors and physics, ready to be written for other programs.
#[derive(Debug)]
pub struct ExportModel<'a> {
    resolved: &'a ResolvedModel,
    /// What a fit found of the parameters, if the factors are those of a fit.
    fitted: Vec<ParameterRow>,
    effects: Vec<ParameterRow>,
}

impl<'a> ExportModel<'a> {
    /// # Arguments
    /// - `fitted`: the parameters of a fit, whose values are the factors of the model; empty for other factors.
    #[must_use]
    pub fn new(resolved: &'a ResolvedModel, fitted: Vec<ParameterRow>) -> Self {
        let rows = resolved.found.iter().flat_map(|found| {
            let effect = &found.effect;
            effect
                .parameters()
                .enumerate()
                .map(|(place, (parameter, value))| {
                    let known = found.uncertainties.get(place);
                    let name = format!(
                        "{}@{}:{}",
                        effect.law.name,
                        effect.place.compact(),
                        parameter.name
                    );
                    ParameterRow::new(
                        name,
                        Some(value),
                        parameter.unit(),
                        known.and_then(|known| known.ci95),
                    )
                })
        });
        let effects = rows.collect();
        Self {
            resolved,
            fitted,
            effects,
        }
    }

    fn robot(&self) -> &'a Robot {
        &self.resolved.robot
    }

    /// A pose with its name; without one every variable has its nominal value.
    fn pose(&self, chosen: Option<&(String, Pose)>) -> (String, Pose) {
        let nominal = || (NOMINAL.to_owned(), self.robot().nominal_pose());
        chosen.cloned().unwrap_or_else(nominal)
    }

    /// Parameters, and the compliance in one pose or, without one, in all that the robot names, else in the nominal one.
    ///
    /// # Errors
    /// For a pose that cannot be reached.
    pub fn table(&self, pose: Option<&(String, Pose)>) -> Result<ExportTable, Failure> {
        let chosen = pose.map(|pose| vec![pose.clone()]);
        let poses = chosen.unwrap_or_else(|| self.robot().poses_or_nominal());
        Ok(ExportTable {
            robot: self.robot().name.clone(),
            mechanism: self.resolved.mechanism.clone(),
            factors: self.resolved.factors_name.clone(),
            parameters: self.parameters(&poses[0].1)?,
            poses: poses
                .into_iter()
                .map(|pose| self.pose_row(pose))
                .collect::<Result<_, _>>()?,
            notes: self.notes(),
        })
    }

    fn pose_row(&self, (name, pose): (String, Pose)) -> Result<PoseRow, RobotError> {
        let (robot, physics) = (self.robot(), &self.resolved.physics);
        let factors = &physics.with_springs(&self.resolved.factors);
        let joints = physics.joints_under(robot, factors, &pose, [0.0; 3])?;
        let theory = Theory::EulerBernoulli;
        let mut predictor = Predictor::with(robot, &physics.mechanism, &joints, theory, factors)?;
        predictor.place(&pose)?;
        let compliance = physics.with_base(&predictor.compliance(), predictor.model());
        let structure = predictor.model().structure();
        let variables = robot.variables.iter().zip(&pose.angles_deg);
        Ok(PoseRow {
            pose: name,
            variables: variables
                .map(|(variable, value)| (variable.name.clone(), *value))
                .collect(),
            end_m: structure.nodes[structure.end.node].position_m.map(rounded),
            compliance: UnknownSprings::of(self.resolved)
                .known(compliance.0.map(|row| row.map(rounded)), &pose)?,
        })
    }
}

/// The text of a file, and what is to be said of masses that it does not have.
pub type NotedFile = (String, Vec<String>);

/// The structure of a mechanism in a pose with all that yields in it.
struct PlacedModel<'a> {
    model: MechanismModel<'a>,
    parts: LumpedParts,
}

impl PlacedModel<'_> {
    /// Its hinges and their parameters.
    fn hinges(&self) -> impl Iterator<Item = (&Hinge, &ModelParameter)> {
        let hinges = self.model.structure().hinges.iter();
        hinges.zip(self.model.hinge_parameters())
    }
}

impl<'a> ExportModel<'a> {
    /// The factors, springs and values of laws.
    fn parameters(&self, pose: &Pose) -> Result<Vec<ParameterRow>, RobotError> {
        let mut rows = self.fitted.clone();
        if rows.is_empty() {
            let factors = &self.resolved.factors;
            let all = ModelParameter::all(self.robot(), self.resolved.mechanism()?);
            // Of single sections and groups those that change something.
            let own = |p: &ModelParameter| {
                matches!(p, ModelParameter::Class(..)) || factors.get(p) != 1.0
            };
            for factor in all.iter().filter(|p| p.is_factor()).filter(|p| own(p)) {
                let value = factors.get(factor);
                rows.push(ParameterRow::of(factor, Some(value)));
            }
            for (hinge, spring) in self.placed(pose)?.hinges() {
                let compliance = 1.0 / hinge.stiffness_nm_per_rad;
                if compliance > STIFFEST && compliance.is_finite() {
                    rows.push(ParameterRow::of(spring, Some(compliance)));
                }
            }
            let unknown = UnknownSprings::of(self.resolved).springs;
            rows.extend(unknown.iter().map(|one| ParameterRow::of(one, None)));
        }
        rows.extend(self.effects.iter().cloned());
        Ok(rows)
    }

    /// What a file for simulators does not hold.
    fn notes(&self) -> Vec<String> {
        let physics = &self.resolved.physics;
        let bench = physics.of_the_bench();
        let mut notes: Vec<String> = bench
            .map(|effect| format!("{effect}: of the bench, not of the robot, and left out"))
            .collect();
        let approximate = physics.effects.iter().filter_map(|effect| {
            let note = effect.law.in_simulators(&effect.values)?.left_out?;
            Some(format!("{effect}: {note}"))
        });
        notes.extend(approximate);
        let balancers = self.robot().balancers.iter();
        notes.extend(balancers.map(|balancer| format!("balancer {}: left out", balancer.name)));
        let tied = self.robot().own_springs().filter_map(|(spring, default)| {
            let RoleInFit::Tied(other) = &default.in_fit else {
                return None;
            };
            Some(format!(
                "{spring}: tied to {other}; an independent value here"
            ))
        });
        notes.extend(tied);
        let unknown = UnknownSprings::of(self.resolved).words();
        notes.extend(unknown.map(|words| format!("{words}; rigid here")));
        notes
    }

    fn placed(&self, pose: &Pose) -> Result<PlacedModel<'a>, RobotError> {
        let (robot, physics) = (self.robot(), &self.resolved.physics);
        let joint = |effect: &Effect| {
            let name = effect.place.joint()?;
            let joint = robot.joints.iter().position(|joint| joint.name == name)?;
            Some((joint, effect.law.in_simulators(&effect.values)?))
        };
        let laws: Vec<(usize, SimulatedRotation)> =
            physics.effects.iter().filter_map(joint).collect();
        // A joint with a law is a hinge, rigid but for its own spring.
        let mut turning: Vec<usize> = laws.iter().map(|(joint, _)| *joint).collect();
        turning.sort_unstable();
        turning.dedup();
        let joints = turning.into_iter().map(|joint| (joint, f64::INFINITY));
        let joints = JointModel::Hinged(joints.collect());
        let mut model = MechanismModel::new(
            robot,
            &physics.mechanism,
            &joints,
            Theory::EulerBernoulli,
            &physics.with_springs(&self.resolved.factors),
        )?;
        model.place(pose)?;
        let hinge_of = |joint: usize| {
            let own = ModelParameter::Joint(robot.joints[joint].name.as_str().into());
            model.hinge_parameters().position(|spring| *spring == own)
        };
        let kg_per_m = model.members().map(|member| {
            let section = &robot.sections[member.section];
            section.mass_kg_per_m.unwrap_or(0.0)
        });
        let parts = LumpedParts {
            members: model.members().map(|member| member.name.clone()).collect(),
            kg_per_m: kg_per_m.collect(),
            hinges: model.hinge_parameters().map(ToString::to_string).collect(),
            laws: laws
                .iter()
                .filter_map(|(joint, law)| Some((hinge_of(*joint)?, *law)))
                .collect(),
            base_rad_per_nm: physics.laws.base_rad_per_nm(),
            masses: model
                .point_masses()
                .map(|(at, _, kg, position_m)| (at.clone(), kg, position_m))
                .collect(),
        };
        Ok(PlacedModel { model, parts })
    }

    /// A file for a simulator.
    ///
    /// # Arguments
    /// - `about`: comments on the format.
    /// - `bodies`: of the file.
    /// - `left_out`: what the format cannot hold.
    /// - `text`: the file with these comments at its beginning.
    fn file<'i>(
        &self,
        (name, pose): (&str, &Pose),
        about: [&str; 2],
        bodies: impl Iterator<Item = &'i Inertia>,
        mut left_out: Vec<String>,
        text: impl FnOnce(&[String]) -> String,
    ) -> Result<NotedFile, Failure> {
        let resolved = self.resolved;
        let count = bodies.filter(|body| body.mass_kg() == 0.0).count();
        if count > 0 {
            left_out.push(format!("bodies without a mass in the robot file: {count}; each has a placeholder of {PLACEHOLDER:e} kg here"));
        }
        let mechanism = &resolved.physics.mechanism;
        let unweighed = Masses::of(self.robot(), mechanism).unweighed;
        if !unweighed.is_empty() {
            left_out.push(format!(
                "sections without a mass in the robot file: {}; their beams weigh nothing here",
                unweighed.join(", ")
            ));
        }
        let mut comments = vec![format!(
            "{}: mechanism {}, factors {}, pose {name}. Written by stiffbench {}. SI units; axes of the robot file, {} is up.",
            self.robot().name,
            resolved.mechanism,
            resolved.factors_name,
            env!("CARGO_PKG_VERSION"),
            self.robot().vertical.map(number).join(" ")
        )];
        comments.extend(about.map(str::to_owned));
        comments.extend_from_slice(&left_out);
        comments.extend(self.parameters(pose)?.iter().map(ParameterRow::in_words));
        comments.extend(self.notes());
        Ok((text(&comments), left_out))
    }

    /// The robot in a pose for MuJoCo.
    ///
    /// # Errors
    /// For a pose that cannot be reached.
    pub fn mjcf(&self, pose: Option<&(String, Pose)>) -> Result<NotedFile, Failure> {
        let (name, pose) = self.pose(pose);
        let robot = self.robot();
        let PlacedModel { model, parts } = self.placed(&pose)?;
        let lumped = LumpedModel::new(model.structure(), &parts);
        let gravity = scale(robot.vertical, -GRAVITY_M_PER_S2);
        self.file(
            (&name, &pose),
            [
                "The robot is held in this pose: drives do not move. Each beam is two rigid halves with six springs in its middle, exact for loads at its ends. Springs are at rest in this pose without load.",
                "The site `end` is where loads act and displacements are read. Damping is chosen for the time step, not measured.",
            ],
            lumped.bodies.iter().map(|body| &body.inertia),
            Vec::new(),
            |comments| mjcf(&robot.name, gravity, &lumped, comments),
        )
    }

    /// The bodies and joints of the robot, at zero in a pose, with the springs and friction of its joints.
    fn tree(&self, pose: &Pose) -> Result<KinematicTree, RobotError> {
        let placed = self.placed(pose)?;
        let PlacedModel { parts, model } = &placed;
        let mut springs = Vec::new();
        for (number, (hinge, spring)) in placed.hinges().enumerate() {
            let own = matches!(
                spring,
                ModelParameter::Joint(_) | ModelParameter::JointAlong(_)
            );
            let Some(joint) = spring.joint().filter(|_| own) else {
                continue;
            };
            let of_hinge = |(of, law): &(usize, SimulatedRotation)| (*of == number).then_some(*law);
            let laws: Vec<SimulatedRotation> = parts.laws.iter().filter_map(of_hinge).collect();
            springs.push(SpringOfJoint {
                joint: joint.to_owned(),
                compliance: 1.0 / hinge.stiffness_nm_per_rad
                    + laws
                        .iter()
                        .map(|law| law.compliance_rad_per_nm)
                        .sum::<f64>(),
                friction: laws.iter().map(|law| law.friction_nm).sum(),
            });
        }
        let masses = model.point_masses();
        let masses: Vec<_> = masses.map(|(_, body, kg, at_m)| (body, kg, at_m)).collect();
        KinematicTree::new(
            self.robot(),
            &self.resolved.physics.mechanism,
            pose,
            &springs,
            &masses,
        )
    }

    /// The robot for Gazebo and others (SDF).
    ///
    /// # Errors
    /// For a pose that cannot be reached.
    pub fn sdf(&self, pose: Option<&(String, Pose)>) -> Result<NotedFile, Failure> {
        let (name, pose) = self.pose(pose);
        let (robot, tree) = (self.robot(), self.tree(&pose)?);
        self.file(
            (&name, &pose),
            [
                "Joints are at zero in this pose. Each has the stiffness of its spring, at rest at zero, and its friction. A joint without spring_stiffness does not yield: hold it with a controller.",
                "Links are rigid: the beams, the base and what else yields stand in these comments only.",
            ],
            tree.links.iter().map(|link| &link.inertia),
            tree.coupled().into_iter().collect(),
            |comments| sdf(&robot.name, robot.vertical, &tree, comments),
        )
    }

    /// The robot for ROS and others (URDF).
    ///
    /// # Errors
    /// For a pose that cannot be reached.
    pub fn urdf(&self, pose: Option<&(String, Pose)>) -> Result<NotedFile, Failure> {
        let (name, pose) = self.pose(pose);
        let (robot, tree) = (self.robot(), self.tree(&pose)?);
        let links = tree.links.iter().map(|link| &link.inertia);
        self.file(
            (&name, &pose),
            [
                "Joints are at zero in this pose. URDF has friction and damping of joints only: springs, beams and the base stand in these comments.",
                "Effort and velocity of limits are not known: 0 stands for them. A limit of 1 m either way stands where that of a sliding joint is not known.",
            ],
            // The link of the end has no mass.
            links.chain([&Inertia::default()]),
            tree.loops().chain(tree.coupled()).collect(),
            |comments| urdf(&robot.name, robot.vertical, &tree, comments),
        )
    }
}
