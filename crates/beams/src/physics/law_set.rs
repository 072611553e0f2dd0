//! Effects, resolved against a mechanism, and the displacement of a run under them.

use super::joint_effect::{JointEffect, JointRotations};
use super::run_loads::{LoadPoint, RunLoads};
use crate::robot::{Mechanism, Robot};
use stiffbench_numeric::vector::{along6, dot6};
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::{Direction, DirectionName, PoseId};

use super::action::{GaugeError, LawAction, OfLoad, OfRepeat, Values, values_of};
use super::effect::{Effect, EffectError};
use super::mechanics::PoseMechanics;
use super::place::Place;

/// Effects ready to act on readings, by where they act in the composition.
#[derive(Debug, Clone, Default)]
pub struct LawSet {
    pub(super) joints: Vec<JointEffect>,
    /// Compliance of the base about x, y, z, rad/(N·m).
    base: [f64; 3],
    /// Angle by which a force along the first axis turns toward the second, rad.
    turn: [[f64; 3]; 3],
    /// Angle by which the gauge along the first axis leans toward the second, rad.
    lean: [[f64; 3]; 3],
    forces: Vec<Acting<OfLoad>>,
    growths: Vec<Acting<OfRepeat>>,
    added: Vec<Acting<OfLoad>>,
    pub(super) gauge_errors: Vec<Acting<&'static dyn GaugeError>>,
}

/// A function of a law with its values, and the readings that it acts on.
#[derive(Debug, Clone)]
pub(super) struct Acting<F> {
    function: F,
    values: Values,
    scope: EffectScope,
}

impl<F> Acting<F> {
    fn new(function: F, effect: &Effect) -> Self {
        Self {
            function,
            values: values_of(&effect.values),
            scope: EffectScope::of(&effect.place),
        }
    }
}

/// The readings that an effect acts on.
#[derive(Debug, Clone, PartialEq)]
enum EffectScope {
    /// All.
    All,
    /// Those along a direction: forces of loads, displacements of a gauge.
    Direction(Direction),
    /// Those of one of several gauges.
    Gauge(Direction),
    /// Those of one run, from one step on.
    Run {
        pose: PoseId,
        direction: DirectionName,
        repeat: u32,
        step: u32,
        gauge: Option<Direction>,
    },
}

impl EffectScope {
    fn of(place: &Place) -> Self {
        match place {
            Place::Direction(direction) | Place::Toward { direction, .. } => {
                Self::Direction(*direction)
            }
            Place::Run {
                pose,
                direction,
                repeat,
                step,
                gauge,
            } => Self::Run {
                pose: pose.clone(),
                direction: direction.clone(),
                repeat: *repeat,
                step: *step,
                gauge: *gauge,
            },
            Place::DisplacementGauge(Some(axis)) | Place::Clock(Some(axis)) => Self::Gauge(*axis),
            Place::Joint(_)
            | Place::Slide(_)
            | Place::AcrossJoint { .. }
            | Place::Tool(_)
            | Place::Axis(_)
            | Place::Element(_)
            | Place::ForceGauge
            | Place::DisplacementGauge(None)
            | Place::Structure
            | Place::Clock(None)
            | Place::Length { .. }
            | Place::JointAngle { .. }
            | Place::Group { .. }
            | Place::Mechanism(_) => Self::All,
        }
    }

    /// Whether it acts on a reading.
    fn covers(&self, run: &RunLoads<'_>, load: &LoadPoint) -> bool {
        match self {
            Self::All => true,
            Self::Direction(axis) => run.read == *axis,
            Self::Gauge(axis) => !run.read.is_rotation() && run.read.axis() == *axis,
            Self::Run {
                pose,
                direction,
                repeat,
                step,
                gauge,
            } => {
                load.step >= *step
                    && *repeat == run.repeat
                    && gauge.is_none_or(|axis| axis == run.read.axis())
                    && run.load.is_called(direction)
                    && pose == run.pose
            }
        }
    }

    /// Whether it acts on the force of a load.
    fn covers_force(&self, run: &RunLoads<'_>, load: &LoadPoint) -> bool {
        match self {
            Self::Direction(axis) => *run.load == *axis,
            _ => self.covers(run, load),
        }
    }
}

/// Loads along a direction and an axis along which a gauge reads, in a pose.
struct LoadsAndReading {
    /// The motion that the gauge reads.
    read: [f64; 6],
    /// Force and moment that act for 1 N along the direction of the load.
    wrench: [f64; 6],
    /// What gives along the reading without joints that turn, m/N.
    linear_m_per_n: f64,
    /// What is read without a load, as far as no joint turns, m.
    unloaded_m: f64,
}

impl LawSet {
    /// Resolves effects; loose members are not in it, they change the mechanism (see [`without_elements`]), nor are springs of the structure.
    ///
    /// # Errors
    /// [`EffectError::Unknown`] for a joint or element that the mechanism does not have.
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        effects: &[Effect],
    ) -> Result<Self, EffectError> {
        let mut set = Self::default();
        let joints = mechanism.joints(robot);
        for effect in effects {
            set.add(robot, mechanism, &joints, effect)?;
        }
        Ok(set)
    }

    fn add(
        &mut self,
        robot: &Robot,
        mechanism: &Mechanism,
        joints: &[usize],
        effect: &Effect,
    ) -> Result<(), EffectError> {
        let mut place = None;
        if let Some(name) = effect.place.joint() {
            let named = |joint: &usize| robot.joints[*joint].name == *name;
            place = joints.iter().position(named);
            let Some(there) = place else {
                return Err(EffectError::Unknown {
                    place: effect.place.clone(),
                    mechanism: mechanism.name.clone(),
                    kind: "joint",
                    known: joints
                        .iter()
                        .map(|&joint| robot.joints[joint].name.clone())
                        .collect(),
                });
            };
            let motion = robot.joints[joints[there]].motion;
            let moved = Place::of_joint(name, motion);
            if moved != effect.place {
                let units = effect.law.parameters_at(&moved).map(|spec| {
                    let (name, unit) = (spec.name, spec.unit());
                    format!("{name} in {unit}")
                });
                return Err(EffectError::Motion {
                    law: effect.law,
                    place: effect.place.clone(),
                    motion,
                    units: units.collect::<Vec<_>>().join(", "),
                });
            }
        }
        if effect.law.is_missing_element() {
            without_element(robot, mechanism, effect)?;
        } else if effect.spring_of_structure().is_none() && effect.law.changes_structure() {
            return Err(EffectError::OfTheFile {
                law: effect.law,
                place: effect.place.clone(),
            });
        }
        self.push(effect, place);
        Ok(())
    }

    /// Adds an effect; `joint` is the index of its joint among the levers, for the laws that sit in one.
    pub fn push(&mut self, effect: &Effect, joint: Option<usize>) {
        let values = values_of(&effect.values);
        match (effect.law.action, &effect.place) {
            (LawAction::Joint(law), _) => {
                if let Some(joint) = joint {
                    self.joints.push(JointEffect::new(joint, law, values));
                }
            }
            (LawAction::Base, Place::Axis(axis)) => self.base[axis.index()] += values[0],
            (LawAction::Turn, Place::Toward { direction, toward }) => {
                self.turn[direction.index()][toward.index()] += values[0];
            }
            (LawAction::Lean, Place::Toward { direction, toward }) => {
                self.lean[direction.index()][toward.index()] += values[0];
            }
            // Of other places there are no effects: an effect is checked when it is made.
            (LawAction::Base | LawAction::Turn | LawAction::Lean, _) => {}
            // A change of the structure, not of its loads.
            (LawAction::Missing | LawAction::Mechanism | LawAction::Structure, _) => {}
            // Of a part without poses: its answers are added to those of its line.
            (LawAction::History(_), _) => {}
            (LawAction::Force(function), _) => self.forces.push(Acting::new(function, effect)),
            (LawAction::Growth(function), _) => self.growths.push(Acting::new(function, effect)),
            (LawAction::Added(function), _) => self.added.push(Acting::new(function, effect)),
            (LawAction::Gauge(error), _) => self.gauge_errors.push(Acting::new(error, effect)),
        }
    }

    /// Displacements of a run, m.
    ///
    /// The order of composition: mechanics × (1 + growth) + what is added, then the error of the gauge, a function of that sum, or of
    /// where the gauge is known to have stood.
    ///
    /// # Arguments
    /// - `joint_rotations`: scratch memory.
    /// - `out`: one displacement a load, overwritten.
    pub fn displacements_m(
        &self,
        pose: &PoseMechanics,
        run: &RunLoads<'_>,
        joint_rotations: &mut JointRotations,
        out: &mut [f64],
    ) {
        joint_rotations.begin(self.joints.len());
        self.go_on_m(pose, run, joint_rotations, out);
    }

    /// Displacements of a run whose joints stand where the run before left them, m; as [`LawSet::displacements_m`] otherwise.
    ///
    /// # Arguments
    /// - `joint_rotations`: as the run before in the same pose left them; restarted if they are of another number of joints.
    pub fn go_on_m(
        &self,
        pose: &PoseMechanics,
        run: &RunLoads<'_>,
        joint_rotations: &mut JointRotations,
        out: &mut [f64],
    ) {
        if joint_rotations.now.len() != self.joints.len() {
            joint_rotations.begin(self.joints.len());
        }
        let reach = self.reach(pose, run);
        for (load, displacement) in run.loads.iter().zip(out.iter_mut()) {
            if let Some(release_n) = run.release_n.filter(|_| joint_rotations.loaded) {
                let acting_n = self.acting_n(run, &LoadPoint::release(release_n));
                self.mechanics_m(pose, &reach, acting_n, joint_rotations);
            }
            joint_rotations.loaded = true;
            let mechanics =
                self.mechanics_m(pose, &reach, self.acting_n(run, load), joint_rotations);
            let mut sum = mechanics * self.growth(run, load) + load.seated_m;
            for added in self
                .added
                .iter()
                .filter(|added| added.scope.covers(run, load))
            {
                sum += (added.function)(&added.values, &run.as_read(load));
            }
            let read = load.position_m.unwrap_or(sum);
            for error in &self.gauge_errors {
                if error.scope.covers(run, load) {
                    sum += error.function.error_m(&error.values, read);
                }
            }
            *displacement = sum;
        }
    }

    /// Factor by which the displacement of the mechanics has grown.
    pub(super) fn growth(&self, run: &RunLoads<'_>, load: &LoadPoint) -> f64 {
        let growths = self.growths.iter();
        1.0 + growths
            .filter(|growth| growth.scope.covers(run, load))
            .map(|growth| (growth.function)(&growth.values, load, run.repeat))
            .sum::<f64>()
    }

    /// The force that acts where one is measured, N.
    pub(super) fn acting_n(&self, run: &RunLoads<'_>, load: &LoadPoint) -> f64 {
        let here = self
            .forces
            .iter()
            .filter(|force| force.scope.covers_force(run, load));
        load.force_n
            + here
                .map(|force| (force.function)(&force.values, load))
                .sum::<f64>()
    }

    /// Force and moment that act for 1 N along the direction of the loads: the parts of the force along each axis as that is turned.
    pub(super) fn acting(&self, run: &RunLoads<'_>) -> [f64; 6] {
        if let Some(axis) = run.load.axis() {
            return along6(turned(&self.turn, axis.index()));
        }
        let mut acting = run.load.wrench();
        let meant = acting;
        acting[..3].fill(0.0);
        for (axis, share) in meant.into_iter().take(3).enumerate() {
            for (part, unit) in acting.iter_mut().zip(turned(&self.turn, axis)) {
                *part += share * unit;
            }
        }
        acting
    }

    /// The motion that a gauge reads: along an axis as it leans.
    pub(super) fn read_along(&self, read: &ReadAxis) -> [f64; 6] {
        match read.base_axis() {
            Some(axis) => along6(turned(&self.lean, axis.index())),
            None => read.unit(),
        }
    }

    /// What all loads of a run have in common.
    fn reach(&self, pose: &PoseMechanics, run: &RunLoads<'_>) -> LoadsAndReading {
        let (wrench, read) = (self.acting(run), self.read_along(&run.read));
        let moved = pose.influence.compliance.map(|row| dot6(row, wrench));
        let mut linear_m_per_n = dot6(read, moved);
        let mut unloaded_m = dot6(read, pose.unloaded.motion);
        let rocking = pose.base_levers.iter().zip(&self.base);
        for ((lever, &compliance), weight_nm) in rocking.zip(pose.unloaded.base_nm) {
            let turned = dot6(*lever, read) * compliance;
            linear_m_per_n += turned * dot6(*lever, wrench);
            unloaded_m += turned * weight_nm;
        }
        LoadsAndReading {
            read,
            wrench,
            linear_m_per_n,
            unloaded_m,
        }
    }

    /// Displacement of the end along the reading under the force that acts; moves the twists on.
    fn mechanics_m(
        &self,
        pose: &PoseMechanics,
        reach: &LoadsAndReading,
        acting_n: f64,
        joint_rotations: &mut JointRotations,
    ) -> f64 {
        let mut displacement = reach.unloaded_m + reach.linear_m_per_n * acting_n;
        if self.joints.is_empty() {
            return displacement;
        }
        self.turn_joints(
            pose,
            reach.wrench.map(|share| share * acting_n),
            joint_rotations,
        );
        for (one, &rotation) in self.joints.iter().zip(&joint_rotations.now) {
            displacement += dot6(pose.influence.levers[one.joint], reach.read) * rotation;
        }
        displacement
    }

    /// Joints with laws, by their levers, and what each sets against its twist under a force at the end, N·m/rad: the secant of its law
    /// from the unloaded state, infinite where it does not turn.
    ///
    /// Laws of one joint act in series. The laws of the bench (gauges, misalignment) have no part in it.
    #[must_use]
    pub fn secants_nm_per_rad(&self, pose: &PoseMechanics, force_n: [f64; 3]) -> Vec<(usize, f64)> {
        let influence = &pose.influence;
        let wrench = along6(force_n);
        let mut joint_rotations = JointRotations::default();
        joint_rotations.begin(self.joints.len());
        self.turn_joints(pose, wrench, &mut joint_rotations);
        let mut secants: Vec<(usize, f64)> = Vec::new();
        for (one, &rotation) in self.joints.iter().zip(&joint_rotations.now) {
            let joint = one.joint;
            let back: f64 = self
                .joints
                .iter()
                .zip(&joint_rotations.now)
                .map(|(other, rotation)| influence.stiffness(joint, other.joint) * rotation)
                .sum();
            let moment = dot6(influence.levers[joint], wrench) - back;
            let stiffness = one.secant_nm_per_rad(rotation, moment);
            match secants.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, known)) => *known = 1.0 / (1.0 / *known + 1.0 / stiffness),
                None => secants.push((joint, stiffness)),
            }
        }
        secants
    }

    /// Compliance of the base about x, y, z, rad/(N·m).
    #[must_use]
    pub fn base_rad_per_nm(&self) -> [f64; 3] {
        self.base
    }
}

/// The unit vector along an axis, turned by angles toward the others, rad.
fn turned(angles: &[[f64; 3]; 3], along: usize) -> [f64; 3] {
    let mut unit = [0.0; 3];
    unit[along] = 1.0;
    for (toward, &angle) in angles[along].iter().enumerate() {
        if angle != 0.0 {
            unit[toward] += angle.sin();
            unit[along] *= angle.cos();
        }
    }
    unit
}

/// A mechanism without the elements that effects call loose.
///
/// # Errors
/// [`EffectError::Unknown`]; whether the rest still carries a load shows when it is solved.
pub fn without_elements(
    robot: &Robot,
    mechanism: &Mechanism,
    effects: &[Effect],
) -> Result<Mechanism, EffectError> {
    let mut rest = mechanism.clone();
    for effect in effects
        .iter()
        .filter(|effect| effect.law.is_missing_element())
    {
        rest = without_element(robot, &rest, effect)?;
    }
    Ok(rest)
}

fn without_element(
    robot: &Robot,
    mechanism: &Mechanism,
    effect: &Effect,
) -> Result<Mechanism, EffectError> {
    let named = |member: &usize| matches!(&effect.place, Place::Element(name) if robot.members[*member].name == *name);
    if !mechanism.members.iter().any(named) {
        return Err(EffectError::Unknown {
            place: effect.place.clone(),
            mechanism: mechanism.name.clone(),
            kind: "element",
            known: mechanism
                .members
                .iter()
                .map(|&member| robot.members[member].name.clone())
                .collect(),
        });
    }
    let mut rest = mechanism.clone();
    rest.members.retain(|member| !named(member));
    Ok(rest)
}
