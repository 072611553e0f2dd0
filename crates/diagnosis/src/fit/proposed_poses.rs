//! Which poses may be proposed for a measurement: inside the limits, above a floor, not at the base.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::robot::{
    BodyPlace, JointMotion, Mechanism, PlacedRobot, Pose, Robot, Variable,
};
use stiffbench_numeric::statistics::{even_share, golden_ratio};
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::test_point::PoseId;

use super::error::FitError;

/// Distance to every limit of a joint, percent of the range between its limits.
const USUAL_MARGIN_PERCENT: f64 = 5.0;

/// Distance of the tool from the vertical through the base, as a share of the largest in the known poses.
const NEAR_BASE: f64 = 0.1;

/// Places that are looked at for each that is wanted; rules may refuse the others.
const LOOKED_AT: usize = 20;

/// Values of a variable that differ by less are the same, degrees or m.
const SAME_VALUE: f64 = 1e-6;

/// Lengths below this are rounding, m.
const ROUNDING_M: f64 = 1e-9;

/// What is stated of the poses that may be proposed, beside what the robot file states; the rest follows from the known poses of the robot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseRules {
    /// Height below which no joint and no tool may be, m.
    pub floor_m: Option<f64>,
    /// Least distance of the tool from the vertical through the base, m.
    pub base_radius_m: Option<f64>,
    /// Least distance to a limit, percent of the range between the limits.
    pub limit_margin_percent: Option<f64>,
    /// Poses that are not proposed.
    pub forbidden: Vec<PoseId>,
}

impl PoseRules {
    /// Those of the poses that were measured or have a name which may be proposed: what is not stated does not count against them, for they
    /// were or can be taken.
    ///
    /// # Arguments
    /// - `measured`: those of them that were measured; the others keep the limits.
    #[must_use]
    pub fn of_known(
        &self,
        (robot, mechanism): (&Robot, &Mechanism),
        known: &[PoseId],
        measured: &[PoseId],
    ) -> (Vec<PoseId>, ProposedWithin) {
        let within = ProposedWithin::of_known(robot, self);
        let may_be = |name: &&PoseId| {
            let pose = robot.pose(name).ok();
            pose.is_some_and(|pose| {
                (measured.contains(name) || robot.is_within_limits(pose))
                    && within.keeps((robot, mechanism), name, pose).is_some()
            })
        };
        let may_be = known.iter().filter(may_be).cloned();
        (may_be.collect(), within)
    }
}

/// The rules that proposed poses keep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProposedWithin {
    /// Height below which no joint and no tool is, m.
    pub floor_m: f64,
    /// Least distance of the tool from the vertical through the base, m.
    pub base_radius_m: f64,
    /// Least distance of a joint from its limits, percent of the range between them. Named and measured poses keep what was stated alone.
    pub limit_margin_percent: f64,
    /// Poses that are not proposed.
    pub forbidden: Vec<PoseId>,
}

/// A pose that may be proposed.
#[derive(Debug, Clone)]
pub(super) struct ProposedPose {
    pub(super) name: PoseId,
    pub(super) pose: Pose,
    /// The tool centre, m.
    pub(super) tool_m: [f64; 3],
}

/// Where a robot is in a pose.
#[expect(clippy::struct_field_names, reason = "all are lengths in m")]
struct Extent {
    tool_m: [f64; 3],
    /// Height of its lowest joint that moves or of the tool, m.
    lowest_m: f64,
    /// Distance of the tool from the vertical through the base, m.
    radius_m: f64,
}

impl Extent {
    /// `None` for a pose that cannot be reached.
    fn of(robot: &Robot, mechanism: &Mechanism, pose: &Pose) -> Option<Self> {
        let placed = PlacedRobot::new(robot, mechanism, pose).ok()?;
        let height = |point| dot(robot.vertical, point);
        let tool_m = placed.node_m(robot.end);
        // A joint on the ground does not move.
        let is_ground = |body: &usize| matches!(robot.bodies[*body].place, BodyPlace::Ground);
        let joints = placed.joints().iter().map(|&joint| &robot.joints[joint]);
        let joints = joints.filter(|joint| !joint.bodies.iter().any(is_ground));
        let joints = joints.map(|joint| height(placed.node_m(joint.node)));
        let along = height(tool_m);
        Some(Self {
            tool_m,
            lowest_m: joints.fold(along, f64::min),
            radius_m: (dot(tool_m, tool_m) - along * along).max(0.0).sqrt(),
        })
    }
}

impl ProposedWithin {
    /// Poses that were measured, then the named ones of the robot, then as many as wanted that are spread evenly over the limits; those that
    /// cannot be reached or break a rule are passed over. With the rules.
    ///
    /// What is not stated holds for new poses alone: the floor is the base, or the lowest point of a robot that hangs below it in every known
    /// pose; the tool keeps a tenth of its largest distance from the vertical through the base in a known pose.
    ///
    /// # Errors
    /// [`FitError::NoPose`] if none is left.
    pub(super) fn poses(
        (robot, mechanism): (&Robot, &Mechanism),
        rules: &PoseRules,
        measured: Vec<(PoseId, Pose)>,
        spread: usize,
    ) -> Result<(Vec<ProposedPose>, Self), FitError> {
        let named = robot.poses.iter();
        let named = named.map(|named| (named.id.clone(), named.pose.clone()));
        let within = named.filter(|(_, pose)| robot.is_within_limits(pose));
        let mut known: Vec<(PoseId, Pose)> = Vec::new();
        for (name, pose) in measured.into_iter().chain(within) {
            if !known.iter().any(|(_, other)| is_same(other, &pose)) {
                known.push((name, pose));
            }
        }
        let nominal = robot.nominal_pose();
        let poses = known.iter().map(|(_, pose)| pose).chain([&nominal]);
        let extents = poses.filter_map(|pose| Extent::of(robot, mechanism, pose));
        let extents: Vec<Extent> = extents.collect();
        let most =
            |of: &dyn Fn(&Extent) -> f64| extents.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        // What hangs below its base in every pose has its floor there.
        let hangs = (f64::MIN..-ROUNDING_M).contains(&most(&|one| one.lowest_m));
        let lowest_m = -most(&|one| -one.lowest_m);
        let floor_m = if hangs { lowest_m } else { 0.0 };
        let usual = [floor_m, NEAR_BASE * most(&|one| one.radius_m).max(0.0)];
        let within = Self::stated(robot, rules, usual, USUAL_MARGIN_PERCENT);
        let ratio = golden_ratio(robot.variables.len());
        let new = (1..=(LOOKED_AT * spread) as u32).map(|k| {
            let variables = robot.variables.iter().enumerate();
            let angles = variables
                .map(|(place, variable)| within.value(variable, even_share(ratio, k, place)));
            let angles_deg = angles.collect();
            (PoseId::new(&format!("new{k}")), Pose { angles_deg })
        });
        let new = new.filter(|(_, pose)| robot.is_within_limits(pose));
        let of_known = Self::of_known(robot, rules);
        let robot = (robot, mechanism);
        let known = known.into_iter();
        let known = known.filter_map(|(name, pose)| of_known.proposed(robot, name, pose));
        let new = new.filter_map(|(name, pose)| within.proposed(robot, name, pose));
        let poses: Vec<ProposedPose> = known.chain(new.take(spread)).collect();
        if poses.is_empty() {
            let rules = within.words();
            return Err(FitError::NoPose { rules });
        }
        Ok((poses, within))
    }

    /// What is stated, by an option or else by the robot file, and what holds where nothing is.
    ///
    /// # Arguments
    /// - `usual`: floor and distance from the vertical through the base, m.
    fn stated(robot: &Robot, rules: &PoseRules, usual: [f64; 2], margin_percent: f64) -> Self {
        let [floor_m, base_radius_m] = usual;
        let radius_m = rules.base_radius_m.or(robot.base_radius_m);
        Self {
            floor_m: rules.floor_m.or(robot.floor_m).unwrap_or(floor_m),
            base_radius_m: radius_m.unwrap_or(base_radius_m),
            limit_margin_percent: rules.limit_margin_percent.unwrap_or(margin_percent),
            forbidden: rules.forbidden.clone(),
        }
    }

    /// The same for known poses, which keep what is stated alone.
    fn of_known(robot: &Robot, rules: &PoseRules) -> Self {
        Self::stated(robot, rules, [f64::NEG_INFINITY, 0.0], f64::NEG_INFINITY)
    }

    /// What the poses keep, to stand behind "keep"; empty if nothing is stated.
    #[must_use]
    pub fn words(&self) -> String {
        let mm = |length_m: f64| (1e3 * length_m).round() + 0.0;
        let mut parts = Vec::new();
        if self.limit_margin_percent.is_finite() {
            let percent = self.limit_margin_percent;
            parts.push(format!(
                "each joint {percent} % of its range away from its limits"
            ));
        }
        if self.floor_m.is_finite() {
            let floor_mm = mm(self.floor_m);
            parts.push(format!("joints and tool at least {floor_mm} mm high"));
        }
        if self.base_radius_m > 0.0 {
            let radius_mm = mm(self.base_radius_m);
            parts.push(format!(
                "the tool {radius_mm} mm or more from the vertical through the base"
            ));
        }
        match parts.pop() {
            Some(last) if !parts.is_empty() => format!("{}, and {last}", parts.join(", ")),
            last => last.unwrap_or_default(),
        }
    }

    /// A pose, if it can be reached and keeps the rules.
    fn proposed(
        &self,
        robot: (&Robot, &Mechanism),
        name: PoseId,
        pose: Pose,
    ) -> Option<ProposedPose> {
        let tool_m = self.keeps(robot, &name, &pose)?;
        Some(ProposedPose { name, pose, tool_m })
    }

    /// The tool centre in a pose, m, if it can be reached and keeps the rules.
    fn keeps(
        &self,
        (robot, mechanism): (&Robot, &Mechanism),
        name: &PoseId,
        pose: &Pose,
    ) -> Option<[f64; 3]> {
        let Extent {
            tool_m,
            lowest_m,
            radius_m,
        } = Extent::of(robot, mechanism, pose)?;
        let mut values = robot.variables.iter().zip(&pose.angles_deg);
        let keeps = lowest_m > self.floor_m - ROUNDING_M
            && radius_m > self.base_radius_m - ROUNDING_M
            && !self.forbidden.contains(name)
            && values.all(|(variable, value)| self.keeps_margin(variable, *value));
        keeps.then_some(tool_m)
    }

    /// Whether a value keeps its distance from the limits, but for its rounding.
    fn keeps_margin(&self, variable: &Variable, value: f64) -> bool {
        let [low, high] = [variable.min_deg, variable.max_deg];
        let rounding = 0.6 / steps_per_unit(variable);
        let margin = 0.01 * self.limit_margin_percent * (high - low) - rounding;
        !(value < low + margin || value > high - margin)
    }

    /// The value of a variable at a share of the range inside the margins, degrees or m; of an angle the one nearest to zero that is the same
    /// direction.
    fn value(&self, variable: &Variable, share: f64) -> f64 {
        let Variable {
            min_deg, max_deg, ..
        } = *variable;
        let margin = 0.01 * self.limit_margin_percent;
        let value = min_deg + (margin + share * (1.0 - 2.0 * margin)) * (max_deg - min_deg);
        let turned = value - 360.0 * (value / 360.0).round();
        let turns = variable.motion == JointMotion::Turns && self.keeps_margin(variable, turned);
        let value = if turns { turned } else { value };
        let steps = steps_per_unit(variable);
        (value * steps).round() / steps
    }
}

/// Proposed values are whole tenths of a degree, or millimetres.
fn steps_per_unit(variable: &Variable) -> f64 {
    match variable.motion {
        JointMotion::Turns => 10.0,
        JointMotion::Slides => 1e3,
    }
}

/// Whether all values are the same but for rounding.
fn is_same(a: &Pose, b: &Pose) -> bool {
    let mut pairs = a.angles_deg.iter().zip(&b.angles_deg);
    pairs.all(|(a, b)| (a - b).abs() < SAME_VALUE)
}
