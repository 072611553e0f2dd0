//! A preload that is overcome: beyond it the joint opens, and the part is softer. The mirror of a stop.
//!
//! A bolted joint carries through its clamped parts until its preload is overcome, then through the bolt alone: Shigley's Mechanical Engineering
//! Design, 10th edition, 2015, section 8-7.

use super::end_stop::{CHANGE, LAW as STOP, Stop, bent_at};
use super::joint_compliance::ACROSS_THE_JOINT;
use crate::physics::action::LawAction;
use crate::physics::law::{LawDefinition, LawWording};
use crate::physics::parameter::{ParameterSpec, PlausibleRange, Typical};
use crate::physics::part::LEVEL;
use crate::physics::search::{SearchSpec, SearchedOn};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "joint-separation",
    row: "joint-separation",
    equation: "displacement += c (|force| - preload) sign(force) beyond the preload",
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance gained beyond the preload",
            ..CHANGE
        },
        ParameterSpec {
            name: "preload",
            word: "preload",
            ..ONSET
        },
    ],
    action: LawAction::History(&Stop { side: 1.0 }),
    search: SearchSpec {
        shapes: |scale| bent_at(scale, &ONSETS),
        ..STOP.search
    },
    words: LawWording {
        phrase: |at, _| format!("a preload in {at} that is overcome"),
        heading: |place| format!("the preload of {place}"),
        explanation: "Up to its preload the part follows its straight line; beyond it a joint opens and the part is softer.",
    },
    check: Some(ACROSS_THE_JOINT),
    ..STOP
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "joint-separation (force read)",
    equation: "force -= k (|displacement| - opening) sign(displacement) beyond the opening",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness lost beyond the opening",
            ..CHANGE
        },
        ParameterSpec {
            name: "opening",
            word: "travel to the opening",
            ..ONSET
        },
    ],
    action: LawAction::History(&Stop { side: -1.0 }),
    search: SearchSpec {
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    ..LAW
};

/// Where the joint opens.
const ONSET: ParameterSpec = ParameterSpec {
    plausible: PlausibleRange {
        bounds: |scale, _| [0.5 * ONSETS[0], LAST_ONSET].map(|onset| onset * scale.force_n),
        reason: "within what was set: a joint that opens earlier shows its soft side alone, one that opens later its stiff side alone",
    },
    typical: Typical {
        value: |scale| 0.3 * scale.force_n,
        spread: 3.0,
    },
    ..LEVEL
};

/// Onsets that are searched, as shares of the largest that was set.
const ONSETS: [f64; 12] = [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

/// Onset beyond which too little shows of the soft side, as a share of the largest that was set.
const LAST_ONSET: f64 = 0.95;
