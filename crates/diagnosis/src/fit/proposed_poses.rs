//! Which poses may be proposed for a measurement: inside the limits, above a floor, not at the base.

use schemars::JsonSchema;
use serde::Serialize;

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

/// What is stated of the poses that may be proposed; the rest follows from the known poses of the robot.
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

/// The rules that proposed poses keep.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
        let within = Self {
            floor_m: rules.floor_m.unwrap_or(floor_m),
            base_radius_m: rules
                .base_radius_m
                .unwrap_or(NEAR_BASE * most(&|one| one.radius_m).max(0.0)),
            limit_margin_percent: rules.limit_margin_percent.unwrap_or(USUAL_MARGIN_PERCENT),
            forbidden: rules.forbidden.clone(),
        };
        let ratio = golden_ratio(robot.variables.len());
        let new = (1..=(LOOKED_AT * spread) as u32).map(|k| {
            let variables = robot.variables.iter().enumerate();
            let angles = variables
                .map(|(place, variable)| within.value(variable, even_share(ratio, k, place)));
            let angles_deg = angles.collect();
            (PoseId::new(&format!("new{k}")), Pose { angles_deg })
        });
        let new = new.filter(|(_, pose)| robot.is_within_limits(pose));
        // A known pose was or can be taken: what is not stated does not count against it.
        let of_known = Self {
            floor_m: rules.floor_m.unwrap_or(f64::NEG_INFINITY),
            base_radius_m: rules.base_radius_m.unwrap_or(0.0),
            ..within.clone()
        };
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

    /// What the poses keep, to stand behind "keep".
    #[must_use]
    pub fn words(&self) -> String {
        let mm = |length_m: f64| (1e3 * length_m).round() + 0.0;
        format!(
            "{} % of its range between each joint and its limits, joints and tool at least {} mm high, and the tool {} mm or more from the vertical through the base",
            self.limit_margin_percent,
            mm(self.floor_m),
            mm(self.base_radius_m)
        )
    }

    /// A pose, if it can be reached and keeps the rules.
    fn proposed(
        &self,
        (robot, mechanism): (&Robot, &Mechanism),
        name: PoseId,
        pose: Pose,
    ) -> Option<ProposedPose> {
        let Extent {
            tool_m,
            lowest_m,
            radius_m,
        } = Extent::of(robot, mechanism, &pose)?;
        let keeps = lowest_m > self.floor_m - ROUNDING_M
            && radius_m > self.base_radius_m - ROUNDING_M
            && !self.forbidden.contains(&name);
        keeps.then_some(ProposedPose { name, pose, tool_m })
    }

    /// The value of a variable at a share of the range inside the margins, degrees or m; of an angle the one nearest to zero that is the same
    /// direction.
    fn value(&self, variable: &Variable, share: f64) -> f64 {
        let Variable {
            min_deg, max_deg, ..
        } = *variable;
        let margin = 0.01 * self.limit_margin_percent;
        let value = min_deg + (margin + share * (1.0 - 2.0 * margin)) * (max_deg - min_deg);
        if variable.motion == JointMotion::Slides {
            return (value * 1e3).round() / 1e3;
        }
        let turned = value - 360.0 * (value / 360.0).round();
        let value = if (min_deg..=max_deg).contains(&turned) {
            turned
        } else {
            value
        };
        (value * 10.0).round() / 10.0
    }
}

/// Whether all values are the same but for rounding.
fn is_same(a: &Pose, b: &Pose) -> bool {
    let mut pairs = a.angles_deg.iter().zip(&b.angles_deg);
    pairs.all(|(a, b)| (a - b).abs() < SAME_VALUE)
}
