//! What there is to do on the way to the next reading.

use crate::view::Purpose;
use stiffbench_gauges::Channel;

use super::surroundings::SurroundingsQuestion;

/// One thing on the way to the next reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Job {
    /// Ask the gauges who they are, and wait for a value of each.
    CheckInstruments,
    /// Ask whether everything is ready.
    Ready,
    /// Ask for something of the surroundings.
    Surroundings(SurroundingsQuestion),
    /// Ask for a pose and direction.
    SetUp(usize),
    /// Watch a push by hand.
    SignCheck(usize),
    /// Bring the force somewhere.
    Load { target_n: f64, purpose: Purpose },
    /// Set the zero of a gauge.
    Zero {
        channel: Channel,
        cell: usize,
        index: usize,
    },
    /// Ask which unit the display of a gauge shows that does not send it.
    UnitShown(Channel),
    /// Ask once more about a zero that moved, after an interruption.
    ZeroMoved,
    /// Compare what the gauges show without load with their zero.
    LookAtZero,
    /// Hold the readings of a cell that is complete against their repeats.
    CheckRepeats(usize),
    /// Take a reading.
    Read { cell: usize, index: usize },
    /// End: everything is done.
    Finish,
}

/// The load that is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Applied {
    pub(super) cell: usize,
    pub(super) repeat: u32,
    pub(super) step: u32,
}

/// A zero that is being set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ZeroDraft {
    /// What each gauge shows at its zero, N or m as sent.
    pub(super) offsets_si: [f64; Channel::COUNT],
    pub(super) by_gauge: [bool; Channel::COUNT],
    /// The force that was still on when the force gauge was zeroed, N.
    pub(super) left_on_n: Option<f64>,
    /// Since when samples count; `None` until the gauge has answered.
    pub(super) since_s: Option<f64>,
}
