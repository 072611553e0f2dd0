//! The machine as a screen sees it.

use crate::gauge_stream::GaugeStream;
use crate::view::{
    Band, GaugeView, PlanPosition, Progress, Purpose, SessionView, SettleView, Task, ZeroView,
};
use stiffbench_gauges::Channel;

use super::{Job, Machine};

impl Machine {
    /// Where the session stands.
    #[must_use]
    pub fn view(&self) -> SessionView {
        let started = self.state.started.as_ref();
        SessionView {
            session: started.map_or_else(String::new, |started| started.session.clone()),
            procedure: self.plan.procedure.name.clone(),
            now_s: self.now_s,
            task: self.task(),
            place: self.place(),
            force: self.gauge_view(Channel::Force),
            displacements: self
                .displacements()
                .map(|channel| self.gauge_view(channel))
                .collect(),
            band: self.band(),
            settle: self.settle_shown(),
            cell: self.cell.clone(),
            zero: self.zero_view(),
            progress: Progress {
                accepted: self.state.taken.len(),
                skipped: self.state.skipped.len(),
                planned: self.plan.len(),
                left_s: self.plan.seconds_left(&self.state, &self.settings.pace),
            },
            prompt: self.pending.as_ref().map(|pending| pending.prompt.clone()),
            held_up: self.held_up(),
            messages: self.messages.iter().cloned().collect(),
            warnings: self.settings.warnings.clone(),
        }
    }

    /// Whether no planned reading is open.
    pub(super) fn is_measured(&self) -> bool {
        self.plan.next_open(&self.state, self.focus).is_none()
    }

    /// The sign of the loads of the plan.
    pub(crate) fn load_sense(&self) -> f64 {
        self.plan.procedure.load_sense()
    }

    /// What will be done once more when the session is resumed, in words.
    #[must_use]
    pub fn repeated_on_resume(&self) -> Vec<String> {
        self.plan
            .repeated_on_resume(&self.state, self.open_zero_question())
    }

    fn task(&self) -> Task {
        if self.over.is_some() {
            return Task::Done;
        }
        if self.paused.is_some() {
            return Task::Paused;
        }
        match self.job {
            Some(Job::SetUp(cell)) => {
                let planned = &self.plan.cells[cell];
                Task::SetUp {
                    pose: planned.pose.clone(),
                    direction: planned.direction.clone(),
                }
            }
            _ if self.pending.is_some() => Task::Answer,
            Some(Job::CheckInstruments) => Task::CheckInstruments,
            Some(Job::SignCheck(cell)) => {
                let stage = self.sign_stage(cell);
                Task::PushByHand {
                    direction: stage.along,
                    gauge: stage.gauge.filter(|_| !stage.with_force),
                    force_n: self.push_n(),
                    let_go: self.wants_no_hand(),
                }
            }
            Some(Job::Load { target_n, purpose }) => Task::Load { target_n, purpose },
            Some(Job::Read { cell, index }) => self.reading_task(cell, index),
            Some(
                Job::UnitShown(_)
                | Job::Ready
                | Job::ZeroMoved
                | Job::Surroundings(_)
                | Job::Zero { .. }
                | Job::LookAtZero
                | Job::CheckRepeats(_)
                | Job::Finish,
            )
            | None => Task::Wait,
        }
    }

    fn reading_task(&self, cell: usize, index: usize) -> Task {
        let planned = &self.plan.cells[cell].readings[index];
        let target_n = planned.target_n;
        let reached_s = self.load.as_ref().and_then(|load| load.reached_s);
        match (planned.extra_hold_s, reached_s) {
            (Some(hold_s), Some(reached_s)) => Task::Hold {
                target_n,
                left_s: (hold_s - (self.now_s - reached_s)).max(0.0),
            },
            _ => Task::Load {
                target_n,
                purpose: Purpose::Reading,
            },
        }
    }

    fn place(&self) -> Option<PlanPosition> {
        let open = match self.job {
            Some(Job::Read { cell, index }) => Some((cell, index)),
            _ => self.plan.next_open(&self.state, self.focus),
        };
        let (cell, index) = open?;
        let planned = &self.plan.cells[cell];
        let reading = &planned.readings[index];
        let steps = planned.readings.iter().map(|reading| reading.step).max();
        Some(PlanPosition {
            pose: planned.pose.clone(),
            direction: planned.direction.clone(),
            branch: reading.branch,
            step: reading.step,
            steps: steps.map_or(0, |last| last + 1),
            target_n: reading.target_n,
            repeat: reading.repeat,
            repeats: self.plan.procedure.repeats,
            attempt: self.state.attempts(cell, index) + 1,
            extra_hold_s: reading.extra_hold_s,
            cell,
            cells: self.plan.cells.len(),
        })
    }

    fn gauge_view(&self, channel: Channel) -> GaugeView {
        let stream = self.stream(channel);
        let last = stream.last.as_ref();
        let seen = self.state.instruments[channel.index()].as_ref();
        let name = &self.settings.names[channel.index()];
        let identity = seen.map_or("", |seen| seen.identity.as_str());
        let extremes = stream.extremes().map(|ends| {
            let [a, b] = ends.map(|value| self.along(channel, value));
            [a.min(b), a.max(b)]
        });
        GaugeView {
            channel,
            name: format!("{name} {identity}").trim_end().to_owned(),
            value_si: self.value(channel),
            raw: last.map_or_else(String::new, |last| last.raw.to_string()),
            unit: last.map_or_else(String::new, |last| last.unit.to_string()),
            resolution_si: last.map(|last| last.resolution_si),
            age_s: stream.age_s(self.now_s),
            stale: stream.is_stale(self.now_s),
            rate_hz: stream.period_s().filter(|s| *s > 0.0).map(|s| 1.0 / s),
            extremes_si: extremes,
            link: link(stream, &self.links[channel.index()]),
            sign_known: self.state.signs[channel.index()].is_some(),
        }
    }

    fn band(&self) -> Option<Band> {
        self.job
            .filter(|job| matches!(job, Job::Load { .. } | Job::Read { .. }))?;
        let load = self.load.as_ref()?;
        Some(Band {
            target_n: load.target_n,
            tolerance_n: load.tolerance_n,
            from_n: load.from_n.unwrap_or(0.0),
            largest_n: self.plan.largest_n(),
            inside: load.is_in_band(),
            overshoot_n: load.overshoot_n,
        })
    }

    fn settle_shown(&self) -> Option<SettleView> {
        self.band().and_then(|_| self.settle())
    }

    fn zero_view(&self) -> Option<ZeroView> {
        let zero = self.state.zero.as_ref()?;
        Some(ZeroView {
            label: zero.set.label.clone(),
            at_s: zero.at_s,
            drift_m: zero.drift_m,
            drift_limit_m: self.settings.drift_limit_m,
        })
    }

    fn held_up(&self) -> Vec<String> {
        let paused = self.paused.iter().map(|reason| format!("paused {reason}"));
        let troubles = self
            .feeds
            .iter()
            .filter_map(|stream| stream.trouble(self.now_s));
        let blocked = troubles.map(str::to_owned);
        let stale = self
            .feeds
            .iter()
            .filter(|stream| stream.blocked.is_none() && stream.is_stale(self.now_s));
        let stale = stale.map(|stream| format!("nothing comes from the {} gauge", stream.channel));
        let unsteady = self
            .load
            .as_ref()
            .filter(|load| load.is_unsteady() && self.job.is_some());
        let unsteady = unsteady.map(|load| {
            format!(
                "the force goes in and out of its band of {} +- {} N: set it nearer to {} N; load not steady, or a gauge whose digits jump?",
                load.target_n, load.tolerance_n, load.target_n
            )
        });
        paused.chain(blocked).chain(stale).chain(unsteady).collect()
    }
}

/// How a line stands, in words; empty while all is well.
fn link(stream: &GaugeStream, text: &str) -> String {
    match &stream.blocked {
        Some(_) if !text.is_empty() => text.to_owned(),
        Some(reason) => reason.clone(),
        None => String::new(),
    }
}
