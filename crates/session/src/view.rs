//! Everything a screen needs, as a plain snapshot.

use stiffbench_gauges::Channel;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, PoseId};

use super::operator::Prompt;

/// The progress of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionView {
    /// Session id.
    pub session: String,
    /// Name of the procedure.
    pub procedure: String,
    /// Session time, s.
    pub now_s: f64,
    /// What the operator is to do.
    pub task: Task,
    /// Where in the plan; `None` before the first cell and after the last.
    pub place: Option<PlanPosition>,
    /// The force gauge.
    pub force: GaugeView,
    /// The displacement gauge along the load, or those along the base axes.
    pub displacements: Vec<GaugeView>,
    /// The band that the force is to be brought into.
    pub band: Option<Band>,
    /// How far the gauges have settled.
    pub settle: Option<SettleView>,
    /// What this cell has given so far.
    pub cell: CellView,
    /// The gauge zero.
    pub zero: Option<ZeroView>,
    /// How much is done.
    pub progress: Progress,
    /// The open question.
    pub prompt: Option<Prompt>,
    /// Why nothing is taken at the moment: paused, a line that is down, a gauge in a wrong mode.
    pub held_up: Vec<String>,
    /// The messages, latest last; at most a hundred lines.
    pub messages: Vec<Message>,
    /// What stays true for the whole session, such as an overdue calibration.
    pub warnings: Vec<String>,
}

/// What the operator is to do now.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// Nothing: the program is asking the gauges who they are.
    CheckInstruments,
    /// Answer [`SessionView::prompt`].
    Answer,
    /// Set the robot to a pose and mount jack and gauges along a direction; a prompt asks when it is done.
    SetUp {
        /// The pose.
        pose: PoseId,
        /// The direction of the load.
        direction: LoadDirection,
    },
    /// Push by hand, by some `force_n` or more, along the direction; the sign states which way.
    PushByHand {
        /// The direction.
        direction: LoadDirection,
        /// The displacement gauge along a base axis that is pushed at, beside the force gauge; `None` for a push on the force gauge.
        gauge: Option<Channel>,
        /// Signed force that is enough, N.
        force_n: f64,
        /// Whether everything is to be let go: what the gauges show without a push is not known yet, or the push was seen.
        let_go: bool,
    },
    /// Bring the force to a target and keep it there.
    Load {
        /// The target, N, signed; 0 means that the gauge hangs free.
        target_n: f64,
        /// What for.
        purpose: Purpose,
    },
    /// Keep the load on.
    Hold {
        /// The target, N.
        target_n: f64,
        /// How long it is still to stay on, s.
        left_s: f64,
    },
    /// Wait: a gauge is setting its zero.
    Wait,
    /// Nothing: the session is paused.
    Paused,
    /// Nothing: the session is over.
    Done,
}

/// What a load is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To take the gauge off, so that the force gauge can be zeroed.
    Free,
    /// The contact force under which the displacement gauge is zeroed.
    Preload,
    /// Back to the preload between two loads.
    Release,
    /// A load on the way to the open one after an interruption; it is not recorded.
    Again,
    /// A reading.
    Reading,
    /// Whether the zero still holds.
    ZeroCheck,
}

/// Where in the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanPosition {
    /// The pose held.
    pub pose: PoseId,
    /// The direction of the load.
    pub direction: LoadDirection,
    /// Loading or unloading.
    pub branch: Branch,
    /// Place in the load sequence, from 0.
    pub step: u32,
    /// Number of steps in the load sequence.
    pub steps: u32,
    /// Target, N.
    pub target_n: f64,
    /// n-th application, from 1.
    pub repeat: u32,
    /// Planned applications.
    pub repeats: u32,
    /// n-th try of this reading, from 1.
    pub attempt: u32,
    /// Seconds under the load at which an extra reading is made.
    pub extra_hold_s: Option<f64>,
    /// Which cell, from 0.
    pub cell: usize,
    /// Number of cells.
    pub cells: usize,
}

/// A gauge, live.
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeView {
    /// Which.
    pub channel: Channel,
    /// Its name and serial number, as far as known.
    pub name: String,
    /// The value along the positive axis from the zero, N or m; `None` before the first and when the last is stale.
    pub value_si: Option<f64>,
    /// The gauge's own text of it.
    pub raw: String,
    /// The unit the gauge is in.
    pub unit: String,
    /// Step of its last digit, N or m.
    pub resolution_si: Option<f64>,
    /// Time since the last value, s.
    pub age_s: Option<f64>,
    /// Whether that is more than three sample periods.
    pub stale: bool,
    /// Values a second.
    pub rate_hz: Option<f64>,
    /// Smallest and largest value since the task began, N or m.
    pub extremes_si: Option<[f64; 2]>,
    /// How its line stands, in words; empty while all is well.
    pub link: String,
    /// Whether the sign of the axis is known.
    pub sign_known: bool,
}

/// The band that the force is to be brought into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Target, N, signed.
    pub target_n: f64,
    /// Half its width, N.
    pub tolerance_n: f64,
    /// Where the bar begins: the force when this target was set, N.
    pub from_n: f64,
    /// Largest load of the plan in size, N: the scale of the bar.
    pub largest_n: f64,
    /// Whether the force is inside.
    pub inside: bool,
    /// By how much the force went past the target since it was set, N; 0 if it never did.
    pub overshoot_n: f64,
}

/// How far the gauges have settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettleView {
    /// How long the force has been in its band without a break, s.
    pub dwell_s: f64,
    /// How long it has to be, s.
    pub dwell_needed_s: f64,
    /// Spread of the force over the window, N.
    pub force_spread_n: Option<f64>,
    /// Limit of it, N.
    pub force_spread_limit_n: f64,
    /// Slope of the force over the window, N/s.
    pub force_slope_n_per_s: Option<f64>,
    /// Limit of it, N/s.
    pub force_slope_limit_n_per_s: f64,
    /// Spread of the displacement over the window, m.
    pub spread_m: Option<f64>,
    /// Limit of it, m.
    pub spread_limit_m: f64,
    /// Slope of the displacement over the window, m/s.
    pub slope_m_per_s: Option<f64>,
    /// Limit of it, m/s.
    pub slope_limit_m_per_s: f64,
    /// Whether all of it is as it must be.
    pub settled: bool,
}

/// What a cell has given so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CellView {
    /// Repeats by load.
    pub spreads: Vec<RepeatSpread>,
    /// Its stiffness so far.
    pub stiffness: Option<StiffnessSoFar>,
    /// Why there is none yet.
    pub no_stiffness: Option<String>,
    /// What looks wrong, in words; limits are those of all cells together.
    pub flags: Vec<String>,
}

/// How far the repeats of one load lie apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatSpread {
    /// Target, N.
    pub target_n: f64,
    /// Loading or unloading.
    pub branch: Branch,
    /// Number of readings.
    pub n: usize,
    /// Mean displacement, m.
    pub mean_m: f64,
    /// Largest minus smallest, m.
    pub range_m: f64,
}

/// Stiffness of a cell so far, 1/slope of displacement on force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessSoFar {
    /// Value, N/m.
    pub stiffness_n_per_m: f64,
    /// Expanded uncertainty for 95 %, N/m; `None` without a degree of freedom.
    pub expanded_n_per_m: Option<f64>,
    /// Coverage factor.
    pub k: Option<f64>,
    /// Effective degrees of freedom.
    pub dof: f64,
    /// Number of runs it rests on.
    pub runs: usize,
    /// Expanded uncertainty to be expected with one more repeat, N/m.
    pub with_one_more_n_per_m: Option<f64>,
}

/// The gauge zero in use.
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroView {
    /// Its name in the column `zero_id`.
    pub label: String,
    /// When it was set, s.
    pub at_s: f64,
    /// Drift at the last zero check, m.
    pub drift_m: Option<f64>,
    /// Drift beyond which is asked, m.
    pub drift_limit_m: f64,
}

/// How much is done.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Readings taken that count.
    pub accepted: usize,
    /// Readings skipped.
    pub skipped: usize,
    /// Readings planned.
    pub planned: usize,
    /// Time that the rest will take, s.
    pub left_s: f64,
}

/// A message line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// The line.
    pub text: String,
    /// Whether the operator is to act on it.
    pub urgent: bool,
}
