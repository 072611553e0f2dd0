//! What is asked of a gauge, one thing at a time.

use crate::Ask;
use crate::Sample;
use crate::{CommandEffect, CommandRole, InstrumentDescription};

/// A command to be sent, and for whom.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PendingCommand {
    pub(super) role: CommandRole,
    /// Who asked; `None` for what belongs to opening and reading.
    pub(super) ask: Option<Ask>,
    /// Another command belongs to the same question.
    pub(super) more: bool,
    /// How often it was sent.
    pub(super) tries: u32,
}

impl PendingCommand {
    pub(super) fn own(role: CommandRole) -> Self {
        Self {
            role,
            ask: None,
            more: false,
            tries: 0,
        }
    }

    /// The commands that answer a question, in order; none if the gauge has no such command.
    pub(super) fn of_ask(description: &InstrumentDescription, ask: Ask) -> Vec<Self> {
        let roles: &[CommandRole] = match ask {
            Ask::Zero => &[CommandRole::Zero],
            Ask::Identity => &[CommandRole::Identify],
            Ask::State => &[CommandRole::QueryUnit, CommandRole::QueryMode],
        };
        let known = roles
            .iter()
            .filter(|role| description.command(**role).is_some());
        let mut jobs: Vec<Self> = known
            .map(|role| Self {
                role: *role,
                ask: Some(ask),
                more: true,
                tries: 0,
            })
            .collect();
        if let Some(last) = jobs.last_mut() {
            last.more = false;
        }
        jobs
    }

    /// What is sent after opening, before the first value: stop what a former session left on, stay awake, report identity, unit and
    /// mode.
    ///
    /// Only commands that set or read: a command that toggles would start what it should stop.
    pub(super) fn of_opening(description: &InstrumentDescription, keep_awake: bool) -> Vec<Self> {
        let order = [
            (CommandRole::Resynchronise, true),
            (CommandRole::StreamStop, true),
            (CommandRole::KeepAwake, keep_awake),
            (CommandRole::Identify, false),
            (CommandRole::QueryUnit, false),
            (CommandRole::QueryMode, false),
        ];
        let safe = order.into_iter().filter(|(role, may_set)| {
            description.command(*role).is_some_and(|command| {
                command.effect == CommandEffect::Reads
                    || *may_set && command.effect == CommandEffect::Sets
            })
        });
        safe.map(|(role, _)| Self::own(role)).collect()
    }
}

/// What the driver is in the middle of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Phase {
    /// Nothing is under way.
    Resting,
    /// Reading away what may still come, until the line is quiet; then `again`.
    Draining {
        since_s: f64,
        dropped: usize,
        reason: &'static str,
        again: Option<PendingCommand>,
    },
    /// A command was sent and its answer is awaited.
    Waiting { job: PendingCommand, sent_s: f64 },
    /// The first value after a trouble: it counts if no second one follows, which would mean that this one was late.
    Confirming {
        held: Sample,
        until_s: f64,
        job: PendingCommand,
    },
}

/// How far the gauge is known to be there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GaugePresence {
    /// Opened, and nothing has come yet that only this gauge would send.
    Unproven,
    /// It answers.
    Up,
    /// It answered, or was expected to, and does not.
    Silent,
}

/// Why a command got no answer, and what the operator can do instead.
pub(super) fn unanswered(ask: Ask) -> &'static str {
    match ask {
        Ask::Zero => "the gauge does not confirm its zero; set it to zero at the gauge",
        Ask::Identity => "the gauge did not identify itself; compare its serial number by eye",
        Ask::State => "the gauge did not report its unit and mode; compare them at its display",
    }
}

/// The text where the gauge has no command for a question.
pub(super) fn no_command(ask: Ask) -> &'static str {
    match ask {
        Ask::Zero => "this gauge cannot be set to zero over its line; press its zero key",
        Ask::Identity => "this gauge has no identification command",
        Ask::State => {
            "this gauge has no command for its unit and mode; compare them at its display"
        }
    }
}
