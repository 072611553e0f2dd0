//! The poses of a study, each known by its number alone.
//!
//! A number names a point of the box that the variables' own limits span, and depends on nothing but sampling, seed and number; the
//! poses are the points that also lie within the coupled limits. So any share of a study can be computed anywhere, and all shares
//! together are the study.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use stiffbench_beams::robot::{Pose, Robot, RobotError};
use stiffbench_numeric::statistics::golden_ratio;

/// Poses drawn for each one wanted before the limits are taken to exclude (almost) everything.
///
/// The shipped robot accepts six in ten. A robot that accepts one in a thousand can still be sampled, in a minute instead of a blink.
const DRAWS_PER_POSE: u64 = 10_000;

/// Shifts of the low-discrepancy points: points of one shift are evenly spread, shifts are independent. Their scatter states how well a mean
/// is known (Cranley and Patterson, SIAM Journal on Numerical Analysis 13 (1976) 904), with one less degree of freedom.
pub(super) const SHIFTS: u64 = 16;

/// How points of the box are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// At random, evenly.
    MonteCarlo,
    /// The middles of equal cells, so that every pose counts alike in a mean.
    Grid,
    /// A Kronecker sequence with the generalised golden ratio (Roberts, The unreasonable effectiveness of quasirandom sequences, 2018):
    /// as even as Sobol's, without its end at 2^16 or 2^32 points, and any point at once.
    LowDiscrepancy,
}

/// Which of the poses: those whose place among all leaves `index` when divided by `count`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From zero.
    pub index: usize,
    /// Number of shares.
    pub count: usize,
}

impl Shard {
    /// All poses.
    pub const WHOLE: Self = Self { index: 0, count: 1 };
}

/// What to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PosePlan {
    /// How.
    pub sampling: Sampling,
    /// Poses wanted within the limits; a grid has the fewest that are at least as many.
    pub poses: usize,
    /// Seed; a grid has none and ignores it.
    pub seed: u64,
    /// Variables that stay at their nominal value.
    pub held: Vec<String>,
}

/// Why a workspace cannot be sampled.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum WorkspaceError {
    /// The robot cannot be built or placed, for a reason that is no pose's own.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// Hardly a pose of the box lies within the coupled limits.
    #[error(
        "{drawn} random poses gave {accepted} within the limits, but {wanted} are needed: the limits exclude nearly everything"
    )]
    #[diagnostic(
        code(stiffbench::distribution::limits),
        help(
            "check the limits of the robot file and the nominal values of the variables that are held"
        )
    )]
    LimitsExcludeNearlyAll {
        /// Poses drawn.
        drawn: usize,
        /// Of these within the limits.
        accepted: usize,
        /// Poses wanted.
        wanted: usize,
    },
}

/// Poses within the limits, in the order of their numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSample {
    /// Number of each pose.
    pub ids: Vec<u64>,
    /// Indices of the robot's variables that vary.
    pub free: Vec<usize>,
    /// Poses of the whole study, of which these may be a share.
    pub whole: usize,
    /// Points of the box that were checked to find them.
    pub drawn: u64,
    nominal: Pose,
    /// Values of the free variables, pose after pose, degrees.
    angles_deg: Vec<f64>,
}

impl PoseSample {
    /// Draws the poses of a share.
    ///
    /// # Errors
    /// [`WorkspaceError::Robot`] for a held variable that does not exist; [`WorkspaceError::LimitsExcludeNearlyAll`].
    pub fn draw(robot: &Robot, plan: &PosePlan, shard: Shard) -> Result<Self, WorkspaceError> {
        let free = free_variables(robot, &plan.held)?;
        let mut set = Self {
            ids: Vec::new(),
            nominal: robot.nominal_pose(),
            whole: 0,
            drawn: 0,
            angles_deg: Vec::new(),
            free,
        };
        match plan.sampling {
            Sampling::Grid => set.draw_grid(robot, plan, shard)?,
            Sampling::MonteCarlo | Sampling::LowDiscrepancy => {
                let mut points = Points::new(plan, set.free.len());
                let most = (plan.poses as u64).saturating_mul(DRAWS_PER_POSE);
                while set.whole < plan.poses {
                    if set.drawn == most {
                        return Err(set.too_few(plan));
                    }
                    set.take(robot, shard, |shares| points.next(shares));
                }
            }
        }
        Ok(set)
    }

    /// The coarsest grid with enough poses within the limits.
    fn draw_grid(
        &mut self,
        robot: &Robot,
        plan: &PosePlan,
        shard: Shard,
    ) -> Result<(), WorkspaceError> {
        let axes = self.free.len() as u32;
        let most = (plan.poses as u64).saturating_mul(DRAWS_PER_POSE);
        let mut wanted = plan.poses as f64;
        let mut cells = 0_u64;
        loop {
            // From the share that the limits left of the grid before, and at least one finer.
            let guess = (wanted.powf(1.0 / f64::from(axes.max(1))) - 1e-9).ceil() as u64;
            cells = guess.max(cells + 1);
            let total = if axes == 0 {
                1
            } else {
                cells.saturating_pow(axes)
            };
            (self.whole, self.drawn) = (0, 0);
            self.ids.clear();
            self.angles_deg.clear();
            if total > most {
                return Err(self.too_few(plan));
            }
            while self.drawn < total {
                let mut rest = self.drawn;
                self.take(robot, shard, |shares| {
                    // The last variable runs fastest.
                    for share in shares.iter_mut().rev() {
                        *share = ((rest % cells) as f64 + 0.5) / cells as f64;
                        rest /= cells;
                    }
                });
            }
            if self.whole >= plan.poses || axes == 0 {
                return Ok(());
            }
            if self.whole > 0 {
                // A little less than the share says: the next finer one follows if it is too few.
                wanted = 0.99 * plan.poses as f64 * total as f64 / self.whole as f64;
            }
        }
    }

    /// Looks at the next point of the box, and keeps it if it is within the limits and in the share.
    fn take(&mut self, robot: &Robot, shard: Shard, point: impl FnOnce(&mut [f64])) {
        let id = self.drawn;
        self.drawn += 1;
        let start = self.angles_deg.len();
        self.angles_deg.resize(start + self.free.len(), 0.0);
        let angles = &mut self.angles_deg[start..];
        point(angles);
        for (angle, &variable) in angles.iter_mut().zip(&self.free) {
            let limits = &robot.variables[variable];
            *angle = limits.min_deg + (limits.max_deg - limits.min_deg) * *angle;
        }
        for (angle, &variable) in angles.iter().zip(&self.free) {
            self.nominal.angles_deg[variable] = *angle;
        }
        let within = robot.is_within_limits(&self.nominal);
        let kept = within && self.whole % shard.count == shard.index;
        self.whole += usize::from(within);
        if kept {
            self.ids.push(id);
        } else {
            self.angles_deg.truncate(start);
        }
    }

    fn too_few(&self, plan: &PosePlan) -> WorkspaceError {
        WorkspaceError::LimitsExcludeNearlyAll {
            drawn: self.drawn as usize,
            accepted: self.whole,
            wanted: plan.poses,
        }
    }

    /// Number of poses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Values of the free variables in a pose, degrees.
    #[must_use]
    pub fn free_angles_deg(&self, place: usize) -> &[f64] {
        &self.angles_deg[place * self.free.len()..][..self.free.len()]
    }

    /// Writes a pose over another; allocates nothing.
    pub fn fill(&self, place: usize, pose: &mut Pose) {
        for (&variable, &angle) in self.free.iter().zip(self.free_angles_deg(place)) {
            pose.angles_deg[variable] = angle;
        }
    }

    /// A pose.
    #[must_use]
    pub fn pose(&self, place: usize) -> Pose {
        // Its free variables stand where the last point left them.
        let mut pose = self.nominal.clone();
        self.fill(place, &mut pose);
        pose
    }
}

/// Points of the unit box, one after another.
enum Points {
    Random(Box<ChaCha8Rng>),
    Even {
        /// Step of each variable and its start in each shift, in units of 2^-64: what runs over is what is left out.
        steps: Vec<u64>,
        starts: Vec<u64>,
        drawn: u64,
    },
}

impl Points {
    fn new(plan: &PosePlan, axes: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
        if plan.sampling == Sampling::MonteCarlo {
            return Self::Random(Box::new(random));
        }
        let ratio = golden_ratio(axes);
        let turn = 2.0_f64.powi(64);
        let steps = (1..=axes).map(|axis| (ratio.powi(-(axis as i32)) * turn) as u64);
        Self::Even {
            steps: steps.collect(),
            starts: (0..SHIFTS as usize * axes)
                .map(|_| random.next_u64())
                .collect(),
            drawn: 0,
        }
    }

    fn next(&mut self, shares: &mut [f64]) {
        match self {
            Self::Random(random) => {
                for share in shares {
                    *share = unit_interval(random.next_u64());
                }
            }
            Self::Even {
                steps,
                starts,
                drawn,
            } => {
                let (shift, place) = ((*drawn % SHIFTS) as usize, *drawn / SHIFTS);
                let starts = &starts[shift * steps.len()..];
                for ((share, &step), &start) in shares.iter_mut().zip(steps.iter()).zip(starts) {
                    *share = unit_interval(start.wrapping_add(place.wrapping_mul(step)));
                }
                *drawn += 1;
            }
        }
    }
}

/// A number evenly distributed over [0, 1): the upper 53 bits of a random word, so that a seed means the same in every version of `rand`.
fn unit_interval(word: u64) -> f64 {
    (word >> 11) as f64 / (1_u64 << 53) as f64
}

/// Indices of the variables that are drawn.
pub(super) fn free_variables(robot: &Robot, held: &[String]) -> Result<Vec<usize>, RobotError> {
    let held: Vec<usize> = held
        .iter()
        .map(|name| robot.variable(name))
        .collect::<Result<_, _>>()?;
    let all = 0..robot.variables.len();
    Ok(all.filter(|variable| !held.contains(variable)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::hp_robot;
    use stiffbench_test_files::shipped_robot;
    use stiffbench_units_and_text::source_text::SourceText;

    fn draw(robot: &Robot, poses: usize, seed: u64) -> Result<PoseSample, WorkspaceError> {
        let plan = PosePlan {
            sampling: Sampling::MonteCarlo,
            poses,
            seed,
            held: Vec::new(),
        };
        PoseSample::draw(robot, &plan, Shard::WHOLE)
    }

    #[test]
    fn acceptance_is_the_share_of_the_box() {
        // theta2 - theta3 < 52.17 cuts a triangle off the box: 352.51 - 290 = 62.51, 352.51 - 341.97 = 10.54, so that the legs are
        // 52.17 - 10.54 = 41.63 degrees each, of 44.93 × 51.97.
        let share = 1.0 - 0.5 * 41.63_f64.powi(2) / (44.93 * 51.97);
        let sample = draw(&hp_robot(), 30_000, 1).unwrap();
        let rate = sample.len() as f64 / sample.drawn as f64;
        // Four standard deviations of a count.
        let bound = 4.0 * (share * (1.0 - share) / sample.drawn as f64).sqrt();
        assert!((rate - share).abs() < bound, "{rate} for {share} ± {bound}");
    }

    #[test]
    fn limits_that_exclude_everything_are_an_error() {
        let text = shipped_robot("hp-robot").unwrap().text;
        let text = text.replace("at_least = 52.17", "at_least = 200.0");
        let robot = Robot::parse(&SourceText::new("tight.toml", text)).unwrap();
        let error = draw(&robot, 3, 0).unwrap_err();
        let WorkspaceError::LimitsExcludeNearlyAll {
            drawn,
            accepted,
            wanted,
        } = error
        else {
            panic!("{error:?}")
        };
        assert_eq!((drawn, accepted, wanted), (30_000, 0, 3));
    }
}
