//! Effects, resolved against a mechanism, and the displacement of a run under them.

use crate::robot::{Mechanism, Robot};
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::effect::{Effect, EffectError};
use super::joint_law::JointLaw;
use super::law::Law;
use super::mechanics::PoseMechanics;
use super::place::Place;
use super::turning::Twists;

/// One load of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadPoint {
    /// Signed force as measured, N.
    pub force_n: f64,
    /// Place in the load sequence.
    pub step: u32,
    /// Seconds under this load.
    pub hold_s: f64,
    /// Seconds since the gauge was zeroed.
    pub since_zero_s: f64,
    /// Temperature since the gauge was zeroed, K.
    pub warming_k: f64,
    /// Where the gauge stood, from its own reading, m; `None` where it stands where the prediction says.
    pub position_m: Option<f64>,
}

/// The loads of one run, in the order in which they were applied; its history begins virgin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunLoads<'a> {
    /// The pose held.
    pub pose: &'a PoseId,
    /// The direction of load and reading.
    pub direction: Direction,
    /// The repeat.
    pub repeat: u32,
    /// Force to which each load is released before the next, N; `None` where the loads follow each other.
    pub release_n: Option<f64>,
    /// The loads.
    pub loads: &'a [LoadPoint],
}

/// Effects ready to act on readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LawSet {
    pub(super) joints: Vec<(usize, JointLaw)>,
    /// Compliance of the base about x, y, z, rad/(N·m).
    base: [f64; 3],
    /// Compliance of the gauge's stand in x, y, z, m/N.
    stand: [f64; 3],
    /// Angle by which a force along the first axis turns toward the second, rad.
    turn: [[f64; 3]; 3],
    force_q: f64,
    creep: Vec<[f64; 2]>,
    per_second: f64,
    per_kelvin: f64,
    setting: Vec<[f64; 2]>,
    slips: Vec<(PoseId, Direction, u32, u32, f64)>,
    pub(super) periods: Vec<[f64; 3]>,
}

/// Loads along an axis of a pose.
struct Reach {
    along: usize,
    /// The force that acts for 1 N along the axis.
    force: [f64; 3],
    /// What gives along the axis without joints that turn, m/N.
    linear_m_per_n: f64,
}

impl LawSet {
    /// Resolves effects; loose members are not in it, they change the mechanism (see [`without_elements`]).
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
        if let Place::Joint(name) = &effect.place {
            let named = |joint: &usize| robot.joints[*joint].name == *name;
            place = joints.iter().position(named);
            if place.is_none() {
                return Err(EffectError::Unknown {
                    place: effect.place.clone(),
                    mechanism: mechanism.name.clone(),
                    kind: "joint",
                    known: joints
                        .iter()
                        .map(|&joint| robot.joints[joint].name.clone())
                        .collect(),
                });
            }
        }
        if effect.law == Law::LooseMember {
            without_element(robot, mechanism, effect)?;
        }
        self.push(effect, place);
        Ok(())
    }

    /// Adds an effect; `joint` is the index of its joint among the levers, for the laws that sit in one.
    pub fn push(&mut self, effect: &Effect, joint: Option<usize>) {
        let v = |index: usize| effect.values.get(index).copied().unwrap_or(0.0);
        match (&effect.place, effect.law) {
            (Place::Joint(_), _) => {
                if let Some(joint) = joint {
                    self.joints.push((joint, JointLaw::of(effect)));
                }
            }
            (Place::Axis(axis), _) => self.base[axis.index()] += v(0),
            (Place::Direction(direction), _) => self.stand[direction.index()] += v(0),
            (Place::Toward { direction, toward }, _) => {
                self.turn[direction.index()][toward.index()] += v(0);
            }
            // A loose member is a change of the mechanism, not of its loads.
            (Place::Element(_), _) => {}
            (Place::ForceGauge, _) => self.force_q += v(0),
            (Place::Structure, Law::Creep) => self.creep.push([v(0), v(1)]),
            (Place::Structure, _) => self.setting.push([v(0), v(1)]),
            (Place::Clock, Law::DriftPerKelvin) => self.per_kelvin += v(0),
            (Place::Clock, _) => self.per_second += v(0),
            (
                Place::Run {
                    pose,
                    direction,
                    repeat,
                    step,
                },
                _,
            ) => self
                .slips
                .push((pose.clone(), *direction, *repeat, *step, v(0))),
            (Place::DisplacementGauge, _) => self.periods.push([v(0), v(1), v(2)]),
        }
    }

    /// Displacements of a run, m.
    ///
    /// The order of composition: mechanics × (1 + creep + setting-in) + stand + drift + slip, then the gauge's period, a function of
    /// that sum, or of where the gauge is known to have stood.
    ///
    /// # Arguments
    /// - `twists`: scratch memory.
    /// - `out`: one displacement a load, overwritten.
    pub fn displacements_m(
        &self,
        pose: &PoseMechanics,
        run: &RunLoads<'_>,
        twists: &mut Twists,
        out: &mut [f64],
    ) {
        twists.begin(self.joints.len());
        self.go_on_m(pose, run, twists, out);
    }

    /// Displacements of a run whose joints stand where the run before left them, m; as [`LawSet::displacements_m`] otherwise.
    ///
    /// # Arguments
    /// - `twists`: as the run before in the same pose left them; begun anew if they are of another number of joints.
    pub fn go_on_m(
        &self,
        pose: &PoseMechanics,
        run: &RunLoads<'_>,
        twists: &mut Twists,
        out: &mut [f64],
    ) {
        if twists.now.len() != self.joints.len() {
            twists.begin(self.joints.len());
        }
        let along = run.direction.index();
        let reach = self.reach(pose, along);
        let slips = |step: u32| -> f64 {
            self.slips
                .iter()
                .filter(|(pose, direction, repeat, from, _)| {
                    step >= *from
                        && *repeat == run.repeat
                        && *direction == run.direction
                        && pose == run.pose
                })
                .map(|slip| slip.4)
                .sum()
        };
        for (load, displacement) in run.loads.iter().zip(out.iter_mut()) {
            if let Some(release_n) = run.release_n.filter(|_| twists.loaded) {
                self.mechanics_m(pose, &reach, release_n, twists);
            }
            twists.loaded = true;
            let mechanics = self.mechanics_m(pose, &reach, load.force_n, twists);
            let mut sum = mechanics * self.growth(load.hold_s, run.repeat)
                + self.stand[along] * load.force_n
                + self.per_second * load.since_zero_s
                + self.per_kelvin * load.warming_k;
            if !self.slips.is_empty() {
                sum += slips(load.step);
            }
            let read = load.position_m.unwrap_or(sum);
            for period in &self.periods {
                sum += period_m(*period, read);
            }
            *displacement = sum;
        }
    }

    /// Factor of creep and setting-in.
    pub(super) fn growth(&self, hold_s: f64, repeat: u32) -> f64 {
        let creep: f64 = self
            .creep
            .iter()
            .map(|[k, t0]| k * (1.0 + hold_s / t0).log10())
            .sum();
        let setting: f64 = self
            .setting
            .iter()
            .map(|[k, decay]| k * (-(f64::from(repeat) - 1.0) / decay).exp())
            .sum();
        1.0 + creep + setting
    }

    /// The force that acts where one is measured, N.
    pub(super) fn acting_n(&self, force_n: f64) -> f64 {
        force_n * (1.0 + self.force_q * force_n.abs())
    }

    /// A force along an axis as it is turned.
    pub(super) fn acting(&self, along: usize, acting_n: f64) -> [f64; 3] {
        let mut force = [0.0; 3];
        force[along] = acting_n;
        for (toward, &angle) in self.turn[along].iter().enumerate() {
            if angle != 0.0 {
                force[toward] += acting_n * angle.sin();
                force[along] *= angle.cos();
            }
        }
        force
    }

    /// What all loads along an axis have in common.
    fn reach(&self, pose: &PoseMechanics, along: usize) -> Reach {
        let force = self.acting(along, 1.0);
        let mut linear_m_per_n = dot(pose.influence.compliance_m_per_n[along], force);
        for (lever, &compliance) in pose.base_levers_m.iter().zip(&self.base) {
            linear_m_per_n += lever[along] * compliance * dot(*lever, force);
        }
        Reach {
            along,
            force,
            linear_m_per_n,
        }
    }

    /// Displacement of the end along an axis under a force; moves the twists on.
    fn mechanics_m(
        &self,
        pose: &PoseMechanics,
        reach: &Reach,
        force_n: f64,
        twists: &mut Twists,
    ) -> f64 {
        let acting_n = self.acting_n(force_n);
        let mut displacement = reach.linear_m_per_n * acting_n;
        if self.joints.is_empty() {
            return displacement;
        }
        self.turn_joints(pose, reach.force.map(|share| share * acting_n), twists);
        for (&(joint, _), &twist) in self.joints.iter().zip(&twists.now) {
            displacement += pose.influence.levers_m[joint][reach.along] * twist;
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
        let mut twists = Twists::default();
        twists.begin(self.joints.len());
        self.turn_joints(pose, force_n, &mut twists);
        let mut secants: Vec<(usize, f64)> = Vec::new();
        for (&(joint, law), &twist) in self.joints.iter().zip(&twists.now) {
            let back: f64 = self
                .joints
                .iter()
                .zip(&twists.now)
                .map(|(&(other, _), twist)| influence.stiffness(joint, other) * twist)
                .sum();
            let moment = dot(influence.levers_m[joint], force_n) - back;
            let stiffness = law.secant_nm_per_rad(twist, moment);
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

/// What a gauge with an error of some amplitude, period (m) and phase adds where it reads `read_m`, m.
#[must_use]
pub fn period_m([amplitude, period, phase]: [f64; 3], read_m: f64) -> f64 {
    amplitude * (std::f64::consts::TAU * read_m / period + phase).sin()
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
        .filter(|effect| effect.law == Law::LooseMember)
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
