//! What happens next in a session: state and event to state and actions.
//!
//! Pure: no clock, no file, no port. What is to be kept goes out as [`Action::Record`] and counts once [`Machine::recorded`] hands it back,
//! so a live session and the fold of its journal cannot differ. What is still open is computed from that state before every step
//! ([`route`]), so redo, another cell, skips and resuming after a crash need no paths of their own.

mod answers;
mod capture;
mod ending;
mod hard_limits;
mod input;
mod instruments;
mod job;
mod jumps;
mod load;
mod operator_events;
mod plausibility;
mod repeat_check;
mod route;
mod set_up;
mod settings;
mod show;
mod signs;
mod surroundings;
mod zero_check;
mod zeroing;

use std::collections::VecDeque;

use stiffbench_gauges::Channel;

use super::event::{Event, SessionEnd};
use super::gauge_stream::GaugeStream;
use super::journal::Record;
use super::live::cell_view;
use super::operator::{Bell, Prompt};
use super::plan::SessionPlan;
use super::state::SessionState;
use super::surroundings::Surroundings;
use super::view::{CellView, Message, Purpose};

use answers::Why;
use job::{Applied, Job, ZeroDraft};
use load::LoadApproach;
use signs::SignWatch;

pub use input::{Action, Input};
pub use settings::{Settings, lag_s};

/// Time without a reading after which a session without an operator gives up, s, and so many dwells more.
const STUCK_S: f64 = 600.0;
const STUCK_DWELLS: f64 = 20.0;

/// Why a session is complete.
const EVERYTHING_DONE: &str = "every planned reading is taken or left out";

/// Lines that a view keeps.
const MESSAGES: usize = 100;

/// An open question.
#[derive(Debug, Clone, PartialEq)]
struct Pending {
    prompt: Prompt,
    why: Why,
}

/// A session on its way.
#[expect(
    clippy::struct_excessive_bools,
    reason = "what has been done at the bench is independent of each other"
)]
#[derive(Debug, Clone, Default)]
pub struct Machine {
    plan: SessionPlan,
    settings: Settings,
    state: SessionState,
    /// The gauges of the plan, force first.
    channels: Vec<Channel>,
    /// What each sends, in the same order.
    feeds: Vec<GaugeStream>,
    now_s: f64,
    queue: VecDeque<Job>,
    job: Option<Job>,
    /// How many jobs have begun.
    jobs: u64,
    load: Option<LoadApproach>,
    draft: Option<ZeroDraft>,
    watch: Option<SignWatch>,
    pending: Option<Pending>,
    /// The cell that goes before the order of the plan.
    focus: usize,
    identities: [Option<String>; Channel::COUNT],
    /// Who answers instead of the gauge of before, and may.
    other_accepted: [Option<String>; Channel::COUNT],
    checked: bool,
    /// What was entered of the surroundings and is not recorded yet.
    surroundings: Surroundings,
    /// Whether the surroundings at the end have been asked for.
    asked_at_end: bool,
    /// Whether the operator has confirmed that the bench is ready.
    begun: bool,
    /// Whether the unit of a gauge that does not send it is to be asked for.
    unit_unsure: [bool; Channel::COUNT],
    /// Whether each gauge has fallen silent.
    silent: [bool; Channel::COUNT],
    /// When a gauge whose values are refused was last asked for its unit and mode, s.
    asked_state_s: f64,
    /// Whether the zero has to be checked before the next reading.
    unsure: bool,
    /// How far one gauge may be behind the other, s: longer once a look at the zero has shown that a jump was none.
    lag_s: f64,
    /// Whether the zero is checked because a gauge jumped.
    jumped: bool,
    /// The gauge that is asked about because it stands still, and since when, s.
    stood_still: Option<(Channel, f64)>,
    /// Since when the force gauge hangs free to be checked, s.
    look_since_s: f64,
    /// Drift of each displacement zero, while the force zero is still to be checked, m; empty before.
    drifts_m: Vec<(Channel, f64)>,
    /// Whether the next load that is applied again is to be compared with its reading of before.
    compares: bool,
    /// What all readings from now on are flagged with; empty if nothing.
    standing_flag: String,
    /// How often the readings on a zero were taken once more because it moved: cell and scope.
    redone: Option<((usize, String), u32)>,
    /// Whether the operator has decided about the zero that moved last.
    zero_decided: bool,
    signs_checked: bool,
    /// The cell that was last compared with its repeats, with how many readings there were.
    repeats_checked: Option<(usize, usize)>,
    /// Cell of the push by hand and how far the end gave way, m/N.
    pushed: Option<(usize, f64)>,
    /// What the force gauge sent before the last push on it, N.
    unpushed_n: Option<f64>,
    /// How long each gauge was not at its zero after it confirmed it, the longest of all times, s.
    zero_takes_s: [f64; Channel::COUNT],
    mounted: Option<usize>,
    /// The step whose reading was taken under the load that is on.
    applied: Option<Applied>,
    /// Whether more than the preload may be on.
    loaded: bool,
    /// What each gauge sent at the last capture or zero, and when.
    before: Option<([f64; Channel::COUNT], f64)>,
    links: [String; Channel::COUNT],
    ports: [String; Channel::COUNT],
    paused: Option<String>,
    stopping: bool,
    over: Option<SessionEnd>,
    unrecorded: usize,
    cell: CellView,
    messages: VecDeque<Message>,
}

impl Machine {
    /// A session in the state of its journal.
    #[must_use]
    pub fn new(plan: SessionPlan, settings: Settings, state: SessionState) -> Self {
        let channels = plan.channels();
        let stream = |channel: &Channel| {
            let channel = *channel;
            let mut stream = GaugeStream::new(channel, settings.least_stale_s);
            if let Some(known) = &state.instruments[channel.index()] {
                stream.expect(&known.unit, known.resolution_si);
            }
            stream
        };
        Self {
            feeds: channels.iter().map(stream).collect(),
            now_s: state.last_s,
            signs_checked: channels
                .iter()
                .all(|channel| state.signs[channel.index()].is_some()),
            channels,
            unit_unsure: [true; Channel::COUNT],
            asked_state_s: f64::NEG_INFINITY,
            lag_s: settings.lag_s,
            compares: !state.readings.is_empty(),
            plan,
            settings,
            state,
            ..Self::default()
        }
    }

    /// The state of the session according to its journal.
    #[must_use]
    pub fn state(&self) -> &SessionState {
        &self.state
    }

    /// How the session ended; `None` while it runs.
    #[must_use]
    pub fn outcome(&self) -> Option<SessionEnd> {
        self.over
    }

    /// Takes in what happened at `now_s` of session time and returns the actions to perform.
    pub fn input(&mut self, input: Input, now_s: f64) -> Vec<Action> {
        let mut out = Vec::new();
        self.now_s = self.now_s.max(now_s);
        if self.over.is_some() {
            return out;
        }
        match input {
            Input::Gauge(event) => self.gauge(event, &mut out),
            Input::Operator(event) => self.operator(event, &mut out),
            Input::Gap => self.forget_windows(),
            Input::RepeatsChecked(found) => self.repeats_checked(found, &mut out),
            Input::Tick => {
                self.ring_for_silence(&mut out);
                self.ask_state_of_refused(&mut out);
            }
        }
        self.advance(&mut out);
        out
    }

    /// Ends the session as partial for a reason that is not the operator's.
    pub fn stop(&mut self, reason: &str, now_s: f64) -> Vec<Action> {
        let mut out = Vec::new();
        self.now_s = self.now_s.max(now_s);
        if self.over.is_none() {
            self.end(SessionEnd::Partial, reason, &mut out);
        }
        out
    }

    /// How long a session without an operator may go without a reading, s: far longer than any load, dwell and hold of its plan take.
    #[must_use]
    pub fn longest_wait_s(&self) -> f64 {
        let readings = self.plan.cells.iter().flat_map(|cell| &cell.readings);
        let hold_s = readings
            .filter_map(|reading| reading.extra_hold_s)
            .fold(0.0, f64::max);
        STUCK_S + STUCK_DWELLS * self.plan.procedure.settle.dwell_s + hold_s
    }

    /// The open question, with how long it may stay open, s; `None` for the time where it waits without limit.
    #[must_use]
    pub fn open_question(&self) -> Option<(&Prompt, Option<f64>)> {
        let prompt = &self.pending.as_ref()?.prompt;
        let mut times = self.plan.procedure.answer_within_s.iter();
        let within_s = times.find(|(id, _)| *id == prompt.id);
        Some((prompt, within_s.map(|(_, time_s)| *time_s)))
    }

    /// Whether the session waits for the operator to continue it.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused.is_some()
    }

    /// How many tasks the operator has been given: when it grows, there is another.
    #[must_use]
    pub fn tasks(&self) -> u64 {
        self.jobs
    }

    /// Takes back an event that is now in the journal.
    pub fn recorded(&mut self, record: &Record) {
        self.unrecorded = self.unrecorded.saturating_sub(1);
        self.state.apply(record);
        let changed = matches!(record.event, Event::Reading(_) | Event::Superseded(_));
        if changed || matches!(record.event, Event::PoseSet(_)) {
            self.inspect_cell();
        }
    }

    /// Works out what the cell has given so far.
    fn inspect_cell(&mut self) {
        if let Some(cell) = self.mounted
            && let Some(planned) = self.plan.cells.get(cell)
        {
            self.cell = cell_view(&self.state, (cell, planned), &self.settings.gauges);
        }
    }

    fn record(&mut self, event: Event, out: &mut Vec<Action>) {
        self.unrecorded += 1;
        out.push(Action::Record(Box::new(event)));
    }

    fn notify(&mut self, text: impl Into<String>, out: &mut Vec<Action>) {
        self.message(text.into(), false, out);
    }

    fn message(&mut self, text: String, urgent: bool, out: &mut Vec<Action>) {
        if self.messages.len() == MESSAGES {
            self.messages.pop_front();
        }
        self.messages.push_back(Message {
            text: text.clone(),
            urgent,
        });
        out.push(Action::Say(text));
    }

    fn ask(&mut self, prompt: Prompt, why: Why, out: &mut Vec<Action>) {
        out.push(Action::Bell(Bell::Attention));
        out.push(Action::Prompt(prompt.clone()));
        self.pending = Some(Pending { prompt, why });
    }

    fn stream(&self, channel: Channel) -> &GaugeStream {
        &self.feeds[self.place_of(channel)]
    }

    fn stream_mut(&mut self, channel: Channel) -> &mut GaugeStream {
        let place = self.place_of(channel);
        &mut self.feeds[place]
    }

    /// Place of a gauge among those of the plan. Events of gauges that are not in it are dropped before anything asks.
    fn place_of(&self, channel: Channel) -> usize {
        let place = self.channels.iter().position(|of| *of == channel);
        place.unwrap_or(0)
    }

    /// The displacement gauges of the plan.
    fn displacements(&self) -> impl Iterator<Item = Channel> + use<> {
        let channels = self.channels.clone().into_iter();
        channels.filter(|channel| channel.is_displacement())
    }

    /// What a value as sent is along the axis from the zero, N or m.
    fn along(&self, channel: Channel, value_si: f64) -> f64 {
        let (sign, mut offset) = self.state.axis(channel);
        if let Some(draft) = self.draft.filter(|_| channel == Channel::Force) {
            offset = draft.offsets_si[Channel::Force.index()];
        }
        // Without a minus in front of zero.
        sign * (value_si - offset) + 0.0
    }

    /// The last value along the axis, if it stands for now.
    fn value(&self, channel: Channel) -> Option<f64> {
        let stream = self.stream(channel);
        let good = stream.is_good(self.now_s);
        let last = stream.last.as_ref().filter(|_| good)?;
        Some(self.along(channel, last.value_si))
    }

    /// Earlier values do not apply to later ones.
    fn begin_histories(&mut self) {
        self.before = None;
        for stream in &mut self.feeds {
            stream.begin_history();
        }
    }

    fn forget_windows(&mut self) {
        for stream in &mut self.feeds {
            stream.forget();
        }
        if let Some(load) = &mut self.load {
            load.left_band();
        }
    }

    /// Goes on as far as possible.
    fn advance(&mut self, out: &mut Vec<Action>) {
        if self.over.is_some() || self.unrecorded > 0 {
            return;
        }
        if self.stopping && !self.in_the_middle_of_a_reading() {
            // Asked for what is at the end, everything is measured.
            if matches!(self.job, Some(Job::Surroundings(_))) && self.is_measured() {
                self.end(SessionEnd::Complete, EVERYTHING_DONE, out);
            } else {
                self.end_by_operator(SessionEnd::Partial, "the operator stopped it", out);
            }
            return;
        }
        self.withdraw_what_is_gone(out);
        if self.pending.is_some() || self.paused.is_some() {
            return;
        }
        if self.job.is_none() {
            if self.queue.is_empty() {
                self.queue = self.route().into();
            }
            self.job = self.queue.pop_front();
            if let Some(job) = self.job {
                self.begin(job, out);
            }
        } else if let Some(job) = self.job {
            self.work(job, out);
        }
    }

    fn begin(&mut self, job: Job, out: &mut Vec<Action>) {
        self.jobs += 1;
        match job {
            Job::CheckInstruments => {
                for channel in self.channels.clone() {
                    self.ask_who(channel, out);
                }
            }
            Job::UnitShown(channel) => self.ask_unit(channel, out),
            Job::LookAtZero => self.look_since_s = self.now_s,
            Job::Ready => self.ask_ready(out),
            Job::ZeroMoved => self.ask_again_about_zero(out),
            Job::Surroundings(of) => self.ask_surroundings(of, out),
            Job::SetUp(cell) => self.ask_set_up(cell, out),
            Job::CheckRepeats(cell) => self.check_repeats(cell, out),
            Job::SignCheck(cell) => self.begin_sign_check(cell, out),
            Job::Load { target_n, purpose } => self.begin_load(target_n, purpose, out),
            Job::Zero { channel, .. } => self.begin_zero(channel, out),
            Job::Read { cell, index } => {
                let target_n = self.plan.cells[cell].readings[index].target_n;
                self.begin_load(target_n, Purpose::Reading, out);
            }
            Job::Finish => self.end(SessionEnd::Complete, EVERYTHING_DONE, out),
        }
    }

    fn work(&mut self, job: Job, out: &mut Vec<Action>) {
        match job {
            Job::CheckInstruments => self.check_instruments(out),
            // These wait for an answer, which finishes them.
            Job::UnitShown(_)
            | Job::Ready
            | Job::ZeroMoved
            | Job::Surroundings(_)
            | Job::SetUp(_)
            | Job::CheckRepeats(_)
            | Job::Finish => {}
            Job::LookAtZero => self.work_zero_check(out),
            Job::SignCheck(cell) => self.work_sign_check(cell, out),
            Job::Load { purpose, .. } => self.work_load(purpose, out),
            Job::Zero {
                channel,
                cell,
                index,
            } => self.work_zero(channel, (cell, index), out),
            Job::Read { cell, index } => self.work_reading(cell, index, out),
        }
    }

    /// The job is done.
    fn done(&mut self) {
        self.job = None;
    }

    /// Everything on the way is dropped and computed again.
    fn reroute(&mut self) {
        self.queue.clear();
        self.job = None;
        self.load = None;
        self.draft = None;
        self.watch = None;
    }

    fn in_the_middle_of_a_reading(&self) -> bool {
        let reading = matches!(self.job, Some(Job::Read { .. }));
        let settling = self.load.as_ref().is_some_and(LoadApproach::is_in_band);
        reading && settling && self.pending.is_none() && self.paused.is_none()
    }
}
