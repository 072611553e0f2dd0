//! How far joints with laws turn under a load, several of them together, and what one more would add.

use stiffbench_numeric::vector::dot6;

use super::action::{LawAction, values_of};
use super::effect::Effect;
use super::joint_effect::JointRotations;
use super::joint_path::{Before, JointPath, PathStep};
use super::law_set::LawSet;
use super::mechanics::PoseMechanics;
use super::run_loads::{LoadPoint, RunLoads};

/// Rounds in which the twists of several joints agree; each round is exact for one joint, and the energy they share is convex.
const ROUNDS: usize = 200;

/// Rounds that two joints are given with their slopes: two or three are enough unless a kink lies between.
const ROUNDS_OF_TWO: usize = 12;

/// Twists agree when a round changes none of them by more than this share.
const AGREED: f64 = 1e-12;

impl JointPath {
    /// What an effect at the joint adds to the displacements of all readings, m; nothing if it is of no joint.
    ///
    /// # Arguments
    /// - `out`: one displacement a load, in the order in which the runs were added, overwritten.
    pub fn added_m(&self, effect: &Effect, out: &mut [f64]) {
        match effect.law.action {
            LawAction::Joint(law) => law.added_m(&values_of(&effect.values), self, out),
            _ => out.fill(0.0),
        }
    }
}

impl LawSet {
    /// Adds a run to the path of a joint.
    ///
    /// # Arguments
    /// - `joint`: by its place among the levers.
    ///
    /// # Returns
    /// `false`, and nothing added, where what a law does there does not simply add: several laws turn joints already, or the gauge's
    /// period stands where the sum of all puts it.
    pub fn add_to_path(
        &self,
        pose: &PoseMechanics,
        run: &RunLoads<'_>,
        joint: usize,
        path: &mut JointPath,
    ) -> bool {
        let stands = || run.loads.iter().all(|load| load.position_m.is_some());
        let known = match self.joints[..] {
            [] => None,
            [other] => Some(other),
            _ => return false,
        };
        if !(self.gauge_errors.is_empty() || stands()) {
            return false;
        }
        let influence = &pose.influence;
        let lever = influence.levers[joint];
        let (turned, read) = (self.acting(run), self.read_along(&run.read));
        let moment_m = dot6(lever, turned);
        let mut other_twist = 0.0;
        let mut step = |load: &LoadPoint, growth: f64| {
            let acting_n = self.acting_n(run, load);
            let mut step = PathStep {
                driving_nm: pose.unloaded.moment_nm(joint) + moment_m * acting_n,
                stiffness_nm_per_rad: influence.stiffness(joint, joint),
                lever_m: dot6(lever, read),
            };
            if let Some(known) = known {
                let other = known.joint;
                let driving = pose.unloaded.moment_nm(other)
                    + dot6(influence.levers[other], turned) * acting_n;
                let own = influence.stiffness(other, other);
                let between = influence.stiffness(joint, other);
                let slope = known.slope_rad_per_nm(driving, own, other_twist);
                other_twist = known.rotation_rad(driving, own, other_twist);
                step.driving_nm -= between * other_twist;
                step.stiffness_nm_per_rad -= slope * between * between;
                step.lever_m -= dot6(influence.levers[other], read) * slope * between;
            }
            step.lever_m *= growth;
            step
        };
        for (place, load) in run.loads.iter().enumerate() {
            let before = match run.release_n {
                _ if place == 0 => Before::Nothing,
                Some(release_n) => Before::Release(step(&LoadPoint::release(release_n), 0.0)),
                None => Before::Load,
            };
            let growth = self.growth(run, load);
            path.push(before, step(load, growth));
        }
        true
    }

    /// Moves the twists to their values under a force and moment.
    pub(super) fn turn_joints(
        &self,
        pose: &PoseMechanics,
        wrench: [f64; 6],
        joint_rotations: &mut JointRotations,
    ) {
        let influence = &pose.influence;
        if let [one] = &self.joints[..] {
            let driving = pose.driving_nm(one.joint, wrench);
            let stiffness = influence.stiffness(one.joint, one.joint);
            joint_rotations.now[0] = one.rotation_rad(driving, stiffness, joint_rotations.now[0]);
            return;
        }
        if self.joints.is_empty() || self.turn_two(pose, wrench, joint_rotations) {
            return;
        }
        joint_rotations.before.clone_from(&joint_rotations.now);
        for _ in 0..ROUNDS {
            let mut change = 0.0_f64;
            let mut largest = 0.0_f64;
            for (place, one) in self.joints.iter().enumerate() {
                let joint = one.joint;
                let others: f64 = self
                    .joints
                    .iter()
                    .zip(&joint_rotations.now)
                    .enumerate()
                    .filter(|(other, _)| *other != place)
                    .map(|(_, (other, rotation))| {
                        influence.stiffness(joint, other.joint) * rotation
                    })
                    .sum();
                let driving = pose.driving_nm(joint, wrench) - others;
                let history = joint_rotations.before[place];
                let rotation =
                    one.rotation_rad(driving, influence.stiffness(joint, joint), history);
                change = change.max((rotation - joint_rotations.now[place]).abs());
                largest = largest.max(rotation.abs());
                joint_rotations.now[place] = rotation;
            }
            if change <= AGREED * largest {
                break;
            }
        }
    }

    /// The same for two joints, by Newton's way: the first is taken as linear about where it stands, the second is exact against that.
    ///
    /// # Returns
    /// `false`, with the twists as they were, if there are not two, or they do not agree soon.
    fn turn_two(
        &self,
        pose: &PoseMechanics,
        wrench: [f64; 6],
        joint_rotations: &mut JointRotations,
    ) -> bool {
        let [first_law, second_law] = &self.joints[..] else {
            return false;
        };
        let (first, second) = (first_law.joint, second_law.joint);
        let influence = &pose.influence;
        let [first_nm, second_nm] = [first, second].map(|joint| pose.driving_nm(joint, wrench));
        let own = |joint: usize| influence.stiffness(joint, joint);
        let (between, back) = (
            influence.stiffness(first, second),
            influence.stiffness(second, first),
        );
        let (before_a, before_b) = (joint_rotations.now[0], joint_rotations.now[1]);
        let mut b = before_b;
        for _ in 0..ROUNDS_OF_TWO {
            let driving = first_nm - between * b;
            let a = first_law.rotation_rad(driving, own(first), before_a);
            let gives = first_law.slope_rad_per_nm(driving, own(first), before_a) * between;
            // a + gives (b - b') for the twist b' that is searched for.
            let next = second_law.rotation_rad(
                second_nm - back * (a + gives * b),
                own(second) - back * gives,
                before_b,
            );
            let expected = a + gives * (b - next);
            let exact = first_law.rotation_rad(first_nm - between * next, own(first), before_a);
            b = next;
            if (exact - expected).abs() <= AGREED * exact.abs().max(next.abs()) {
                joint_rotations.now[0] = exact;
                joint_rotations.now[1] = next;
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Effect;
    use crate::structure::RotationInfluence;
    use proptest::prelude::*;
    use stiffbench_numeric::vector::along6;

    fn pose(k: [f64; 3]) -> PoseMechanics {
        let mut influence = RotationInfluence::of_one_joint(3e-7, 0.3);
        influence.levers = [[0.3, 0.2, 0.1], [0.1, -0.4, 0.2]].map(along6).to_vec();
        influence.stiffness_nm_per_rad = vec![k[0], k[1], k[1], k[2]];
        PoseMechanics {
            influence,
            ..PoseMechanics::default()
        }
    }

    const LAWS: [&str; 4] = [
        "joint-compliance@J:c=5urad/(N*m)",
        "joint-backlash@J:play=40urad,seat_moment=3N*m",
        "joint-friction@J:c=8urad/(N*m),friction_moment=4N*m",
        "joint-nonlinearity@J:c=4urad/(N*m),q=0.3urad/(N*m)^2",
    ];

    proptest! {
        /// Each twist is what its own law says beside the other, along a path with history.
        #[test]
        fn two_joints_agree(
            first in 0..4_usize, second in 0..4_usize, coupling in -0.95..0.95_f64,
            forces in proptest::collection::vec(-70.0..70.0_f64, 1..6),
        ) {
            let (a, b) = (2e5_f64, 9e4_f64);
            let pose = pose([a, coupling * (a * b).sqrt(), b]);
            let mut laws = LawSet::default();
            for (joint, law) in [first, second].into_iter().enumerate() {
                laws.push(&LAWS[law].parse::<Effect>().unwrap(), Some(joint));
            }
            let mut joint_rotations = JointRotations::default();
            joint_rotations.begin(2);
            for force in forces {
                let before = joint_rotations.now.clone();
                let wrench = along6([force, 0.5 * force, 0.0]);
                laws.turn_joints(&pose, wrench, &mut joint_rotations);
                for (place, law) in laws.joints.iter().enumerate() {
                    let (joint, other) = (law.joint, 1 - place);
                    let driving = dot6(pose.influence.levers[joint], wrench)
                        - pose.influence.stiffness(joint, other) * joint_rotations.now[other];
                    let own = law.rotation_rad(driving, pose.influence.stiffness(joint, joint), before[place]);
                    prop_assert!((own - joint_rotations.now[place]).abs() < 1e-12, "{own} {:?}", joint_rotations.now);
                }
            }
        }
    }
}
