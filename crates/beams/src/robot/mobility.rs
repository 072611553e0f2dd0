//! Mobility: the paper's count, eqs. (1) to (5), and an independent check by the rank of the closure conditions.

use faer::Mat;

use stiffbench_numeric::vector::{cross, scale, subtract};

use super::Robot;
use super::error::RobotError;
use super::kinematics::{Item, Order, Placement};
use super::model::{Mechanism, Pose};

/// A singular value below this share of the largest counts as zero: closure conditions of a linkage in general position are far
/// above, rounding is at 1e-15.
const RANK_TOLERANCE: f64 = 1e-9;

/// The paper's count for one chain (a row of Table I).
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct ChainMobility {
    /// The chain.
    pub chain: String,
    /// Whether it is the host, which stands on the ground; the others stand on it or on one another.
    pub host: bool,
    /// Components n.
    pub components: usize,
    /// Joints g, one freedom each.
    pub joints: usize,
    /// General constraints λ: 6 less the rank of the chain's joint screws.
    pub general_constraints: usize,
    /// Redundant constraints ν. Zero throughout: what the plane makes redundant is in λ already.
    pub redundant_constraints: usize,
    /// Overconstraints μ, eq. (3) or (5).
    pub overconstraints: i64,
    /// Degrees of freedom F, eq. (2) or (4).
    pub freedoms: i64,
}

/// Mobility of a mechanism from the rank of its closure conditions.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
pub struct Mobility {
    /// Joints.
    pub joints: usize,
    /// Independent loops: joints less moving bodies.
    pub loops: usize,
    /// Rank of the 6 × loops closure conditions.
    pub rank: usize,
    /// Degrees of freedom: joints less rank.
    pub freedoms: usize,
}

/// Eqs. (2) to (5) for each chain of a robot, in the order of its joints; the first chain is the host. Empty if no body of the robot
/// names its chain: then there are no components to count.
///
/// # Errors
/// [`RobotError::Unreachable`] if the pose, needed for λ, cannot be reached.
pub fn chain_mobility(robot: &Robot, pose: &Pose) -> Result<Vec<ChainMobility>, RobotError> {
    let all: Vec<usize> = (0..robot.joints.len()).collect();
    let screws = joint_screws(robot, &all, pose)?;
    if robot.bodies.iter().all(|body| body.chain.is_none()) {
        return Ok(Vec::new());
    }
    let mut chains: Vec<&str> = Vec::new();
    for chain in robot
        .joints
        .iter()
        .filter_map(|joint| joint.chain.as_deref())
    {
        if !chains.contains(&chain) {
            chains.push(chain);
        }
    }
    let count = |chain: &str, host: bool| {
        let components = robot
            .bodies
            .iter()
            .filter(|body| body.chain.as_deref() == Some(chain))
            .count();
        let joints: Vec<usize> = all
            .iter()
            .copied()
            .filter(|&joint| robot.joints[joint].chain.as_deref() == Some(chain))
            .collect();
        let columns: Vec<[f64; 6]> = joints.iter().map(|&joint| screws[joint]).collect();
        let general_constraints = 6 - rank(&Mat::from_fn(6, columns.len(), |i, j| columns[j][i]));
        // n - g - 1 for the host; a parasitic chain counts what it stands on as one more component (eqs. (4) and (5)).
        let surplus = components as i64 - joints.len() as i64 - i64::from(host);
        let redundant_constraints = 0;
        let overconstraints = redundant_constraints as i64 - general_constraints as i64 * surplus;
        ChainMobility {
            chain: chain.to_owned(),
            host,
            components,
            joints: joints.len(),
            general_constraints,
            redundant_constraints,
            overconstraints,
            freedoms: 6 * surplus + joints.len() as i64 + overconstraints,
        }
    };
    Ok(chains
        .iter()
        .enumerate()
        .map(|(place, chain)| count(chain, place == 0))
        .collect())
}

/// Mobility of a mechanism in a pose from its loops, without any formula of counting.
///
/// The twists of the joints around each independent loop add up to zero; each loop gives six equations in the joint rates. What
/// the equations leave free is the mobility, redundant constraints included. Counted are the joints of the mechanism's chains and
/// those of no chain, locked or not: a joint that only a single further element brings in (the end link of the host robot) is taken
/// as held.
///
/// # Errors
/// [`RobotError::Unreachable`] if the pose cannot be reached.
pub fn mobility(robot: &Robot, mechanism: &Mechanism, pose: &Pose) -> Result<Mobility, RobotError> {
    let in_mechanism = |joint: &usize| {
        robot.joints[*joint]
            .chain
            .as_ref()
            .is_none_or(|chain| mechanism.chains.contains(chain))
    };
    let joints: Vec<usize> = (0..robot.joints.len()).filter(in_mechanism).collect();
    let screws = joint_screws(robot, &joints, pose)?;
    let loops = closed_loops(robot, &joints);
    let mut conditions = Mat::<f64>::zeros((6 * loops.len()).max(1), joints.len().max(1));
    for (row, closed_loop) in loops.iter().enumerate() {
        for &(joint, sign) in closed_loop {
            for component in 0..6 {
                conditions[(6 * row + component, joint)] += sign * screws[joint][component];
            }
        }
    }
    let rank = rank(&conditions);
    Ok(Mobility {
        joints: joints.len(),
        loops: loops.len(),
        rank,
        freedoms: joints.len() - rank,
    })
}

/// Screw of each joint: its axis, and the velocity it gives the origin, in units of the robot's size.
fn joint_screws(robot: &Robot, joints: &[usize], pose: &Pose) -> Result<Vec<[f64; 6]>, RobotError> {
    let wanted = joints.iter().flat_map(|&joint| {
        let joint = &robot.joints[joint];
        [
            Item::Node(joint.node),
            Item::Body(robot.planes[joint.plane].body),
        ]
    });
    let order = Order::of(robot, wanted).expect("a checked robot has no circular dependency");
    let mut placement = Placement::new(robot, 0.0);
    order.place(robot, pose, &mut placement)?;
    let first = joints.first().map_or([0.0; 3], |&joint| {
        placement.node_m(robot.joints[joint].node)
    });
    let arms: Vec<[f64; 3]> = joints
        .iter()
        .map(|&joint| subtract(placement.node_m(robot.joints[joint].node), first))
        .collect();
    let size = arms
        .iter()
        .flatten()
        .fold(f64::MIN_POSITIVE, |size, c| size.max(c.abs()));
    let screw = |(place, &joint): (usize, &usize)| {
        let axis = placement.plane_normal(robot, robot.joints[joint].plane);
        let moment = cross(scale(arms[place], 1.0 / size), axis);
        [axis[0], axis[1], axis[2], moment[0], moment[1], moment[2]]
    };
    Ok(joints.iter().enumerate().map(screw).collect())
}

/// Independent loops of the graph of bodies: each a list of joints (by place in `joints`) with the sense they are passed in.
fn closed_loops(robot: &Robot, joints: &[usize]) -> Vec<Vec<(usize, f64)>> {
    // For each body reached so far, the joints from the root of its tree to it.
    let mut paths: Vec<Option<Vec<(usize, f64)>>> = vec![None; robot.bodies.len()];
    let mut open: Vec<usize> = (0..joints.len()).collect();
    let mut loops = Vec::new();
    while !open.is_empty() {
        let before = open.len();
        open.retain(|&place| {
            let [a, b] = robot.joints[joints[place]].bodies;
            let extended = |path: &[(usize, f64)], sense: f64| {
                Some(
                    path.iter()
                        .copied()
                        .chain(std::iter::once((place, sense)))
                        .collect::<Vec<_>>(),
                )
            };
            match (&paths[a], &paths[b]) {
                (None, None) => return true,
                (Some(path), None) => paths[b] = extended(path, 1.0),
                (None, Some(path)) => paths[a] = extended(path, -1.0),
                (Some(to_a), Some(to_b)) => {
                    let back = to_b.iter().map(|&(joint, sense)| (joint, -sense));
                    loops.push(
                        to_a.iter()
                            .copied()
                            .chain(std::iter::once((place, 1.0)))
                            .chain(back)
                            .collect(),
                    );
                }
            }
            false
        });
        if open.len() == before {
            // Nothing open touches what was reached: start another tree.
            paths[robot.joints[joints[open[0]]].bodies[0]] = Some(Vec::new());
        }
    }
    loops
}

/// Rank by singular values.
fn rank(matrix: &Mat<f64>) -> usize {
    let Ok(values) = matrix.singular_values() else {
        return 0;
    };
    let largest = values.iter().copied().fold(0.0_f64, f64::max);
    values
        .iter()
        .filter(|value| **value > RANK_TOLERANCE * largest)
        .count()
}
