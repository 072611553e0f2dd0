//! A bench whose readings are functions of the test point, and an operator who does what the view says, in simulated time.

use std::collections::{BTreeMap, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Write};

use jiff::{SignedDuration, Timestamp};
use stiffbench_gauges::{Ask, Channel, GaugeEvent, LinkState, Rejected, Sample};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_session::{
    Action, Answer, AnswerForm, Bell, Contradiction, Event, Input, JOURNAL_SCHEMA, Journal,
    Machine, OperatorEvent, Prompt, PromptKind, Purpose, QUESTIONS, Record, Resumed, SessionEnd,
    SessionPlan, SessionState, SessionView, Settings, Started, Store, Task, ZeroOccasion,
    read_journal, table,
};
use stiffbench_test_files::shipped_procedure;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// Session time between two samples of a gauge, s.
const TICK_S: f64 = 0.1;

/// How fast the jack moves at most, N a tick.
const JACK_N: f64 = 8.0;

/// Most ticks of a session, so that one that hangs fails.
const MOST_TICKS: usize = 2_000_000;

/// A journal in memory whose disk may be full: bytes beyond `room` are not taken.
#[derive(Debug, Clone)]
pub(crate) struct Disk {
    pub(crate) bytes: Vec<u8>,
    pub(crate) room: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.room.saturating_sub(self.bytes.len()));
        if taken == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        self.bytes.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Store for Disk {
    fn sync(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A question is one of the list, which takes what the question takes.
fn assert_listed(prompt: &Prompt) {
    let listed = QUESTIONS.iter().find(|known| known.id == prompt.id);
    let form = listed.map(|question| question.form);
    let agrees = match (&prompt.kind, form) {
        (PromptKind::Text, Some(AnswerForm::Text))
        | (PromptKind::Number { .. }, Some(AnswerForm::Number { .. }))
        | (PromptKind::Confirm | PromptKind::Checklist(_), Some(AnswerForm::Yes)) => true,
        (PromptKind::Choice(choices), Some(AnswerForm::Words(words))) => {
            choices.iter().all(|choice| words.contains(&choice.word))
        }
        _ => false,
    };
    assert!(agrees, "{prompt:?} is listed as {form:?}");
}

/// The gauges, the robot and the jack.
#[derive(Debug, Clone)]
pub(crate) struct MockBench {
    pub(crate) now_s: f64,
    /// Force along the axis, N.
    pub(crate) force_n: f64,
    aim_n: f64,
    /// Whether a load of the plan is on, or on its way.
    pub(crate) loaded: bool,
    direction: LoadDirection,
    /// How far a hand beside the force gauge moves the end, m.
    pushed_m: [f64; 3],
    /// What the gauges take off themselves, in the sign as sent.
    zero_si: [f64; Channel::COUNT],
    /// Whether a gauge has a zero command.
    pub(crate) has_zero: [bool; Channel::COUNT],
    /// Sign of each gauge along the axis.
    pub(crate) signs: [f64; Channel::COUNT],
    /// Displacement that does not come from the force, m.
    pub(crate) drift_m: f64,
    /// What the gauges send instead of what they should.
    pub(crate) fault: Option<Fault>,
    /// What a display shows while it is held, in the sign as sent.
    pub(crate) held_si: [Option<f64>; Channel::COUNT],
    /// What a gauge still shows when it was set to zero, in the sign as sent.
    pub(crate) leaves_si: [f64; Channel::COUNT],
    /// What the displacement gauge shows of what it should.
    pub(crate) sensitivity: f64,
    /// Step of the displacement behind its unchanged decimals, m.
    pub(crate) step_m: f64,
    /// Whether the operator brings the force where the program shows the target; else where it truly is.
    pub(crate) by_display: bool,
    /// Decimals of a millimetre that the displacement gauge sends.
    pub(crate) decimals: usize,
    /// Standard deviation of the noise of force and displacement gauges, N and m.
    pub(crate) noise_si: [f64; 2],
    /// Standard deviation from load to load, m.
    pub(crate) scatter_m: f64,
    /// By how much a preload differs from its target at most, N.
    pub(crate) preload_off_n: f64,
    /// What a run of a cell does otherwise.
    pub(crate) runs: BTreeMap<(usize, u32), RunDeviation>,
    /// The run that is measured, and its step.
    pub(crate) at: ((usize, u32), u32),
    /// Of the noise.
    pub(crate) seed: u64,
    /// What the displays of force and displacement gauges make of their values, in the sign as sent.
    pub(crate) displays: [Option<Display>; 2],
    /// Readings that were taken, and when the last was, s.
    pub(crate) taken: (usize, f64),
    /// The force at the last ticks, N, the newest last.
    pub(crate) past_n: VecDeque<f64>,
    /// Force that stays on where the gauge should hang free, N.
    pub(crate) left_on_n: f64,
    /// How long a hand beside the force gauge pushes at once when it is asked to let go first, s, and until when it does along each axis.
    pub(crate) eager_s: f64,
    pub(crate) eager_until_s: [Option<f64>; 3],
}

pub(crate) type Display = fn(&MockBench, f64) -> f64;

/// How a run differs from the others of its cell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RunDeviation {
    /// Relative.
    pub(crate) slope: f64,
    /// In all its loads, m.
    pub(crate) offset_m: f64,
    /// A step and how far it is off, m.
    pub(crate) load: Option<(u32, f64)>,
}

/// A number from 0 to 1 that belongs to some others.
pub(crate) fn uniform(key: impl Hash) -> f64 {
    let mut hasher = DefaultHasher::new();
    key.hash(&mut hasher);
    (hasher.finish() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A number of the standard normal distribution that belongs to some others.
pub(crate) fn normal(key: impl Hash + Copy) -> f64 {
    let size = (-2.0 * (1.0 - uniform((key, 1))).ln()).sqrt();
    size * (std::f64::consts::TAU * uniform((key, 2))).cos()
}

/// Something wrong with a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    /// It sends nothing.
    Silent(Channel),
    /// It sends the same text for ever.
    Frozen,
    /// It sends another unit.
    Unit,
}

impl Default for MockBench {
    fn default() -> Self {
        Self {
            now_s: 0.0,
            force_n: 0.0,
            aim_n: 0.0,
            loaded: false,
            direction: LoadDirection::Axis(Direction::X),
            pushed_m: [0.0; 3],
            zero_si: [0.0; Channel::COUNT],
            has_zero: [false, true, true, false, true],
            // A force gauge that counts compression up, and pushes go against the axis.
            signs: [-1.0, 1.0, 1.0, 1.0, 1.0],
            drift_m: 0.0,
            fault: None,
            held_si: [None; Channel::COUNT],
            leaves_si: [0.0; Channel::COUNT],
            sensitivity: 1.0,
            step_m: 1e-6,
            by_display: false,
            decimals: 3,
            noise_si: [0.0; 2],
            scatter_m: 0.0,
            preload_off_n: 0.0,
            runs: BTreeMap::new(),
            at: ((0, 1), 0),
            seed: 0,
            displays: [None; 2],
            taken: (0, 0.0),
            past_n: VecDeque::new(),
            left_on_n: 0.0,
            eager_s: 0.0,
            eager_until_s: [None; 3],
        }
    }
}

impl MockBench {
    /// Displacement of the end along the base axes per force along the load, m/N.
    fn compliance(&self) -> [f64; 3] {
        compliance(&self.direction)
    }

    fn shown_si(&self, channel: Channel) -> f64 {
        let truth = match channel {
            Channel::Force => self.force_n,
            Channel::Displacement => {
                let along = self.direction.unit_vector();
                let compliance: f64 = (0..3).map(|i| along[i] * self.compliance()[i]).sum();
                let (run, step) = self.at;
                let run = self.runs.get(&run).copied().unwrap_or_default();
                let load = run.load.filter(|(at, _)| *at == step);
                let off_m = if self.loaded {
                    let scatter_m = self.scatter_m * normal((self.seed, self.at));
                    run.offset_m + load.map_or(0.0, |of| of.1) + scatter_m
                } else {
                    0.0
                };
                let moved_m = (1.0 + run.slope) * compliance * self.force_n;
                self.sensitivity * (moved_m + self.drift_m + off_m)
            }
            Channel::DisplacementX | Channel::DisplacementY | Channel::DisplacementZ => {
                let axis = channel.index() - Channel::DisplacementX.index();
                let moved_m = self.compliance()[axis] * self.force_n + self.pushed_m[axis];
                self.sensitivity * (moved_m + self.drift_m)
            }
        };
        self.signs[channel.index()] * truth
    }

    /// Somebody presses the zero key of a gauge.
    pub(crate) fn tare(&mut self, channel: Channel) {
        self.zero_si[channel.index()] = self.shown_si(channel);
    }

    /// The stand of a gauge is moved, m as sent.
    pub(crate) fn shift(&mut self, channel: Channel, by_m: f64) {
        self.zero_si[channel.index()] -= by_m;
    }

    /// Somebody presses the hold key of a gauge.
    pub(crate) fn hold(&mut self, channel: Channel) {
        let at = channel.index();
        self.held_si[at] = Some(self.shown_si(channel) - self.zero_si[at]);
    }

    /// Does what the view says.
    pub(crate) fn follow(&mut self, view: &SessionView) {
        self.pushed_m = [0.0; 3];
        match &view.task {
            Task::SetUp { direction, .. } => {
                self.direction.clone_from(direction);
                self.aim_n = 0.0;
            }
            Task::PushByHand {
                gauge: Some(beside),
                force_n,
                ..
            } if self.is_eager(*beside).is_some() => {
                let axis = beside.axis().expect("it stands along an axis");
                if self.is_eager(*beside) == Some(true) {
                    self.pushed_m[axis.index()] = 150e-6_f64.copysign(*force_n);
                }
                self.aim_n = 0.0;
            }
            Task::PushByHand { let_go: true, .. } => self.aim_n = 0.0,
            Task::PushByHand { force_n, gauge, .. } => match gauge.and_then(Channel::axis) {
                Some(axis) => self.pushed_m[axis.index()] = 150e-6_f64.copysign(*force_n),
                None => self.aim_n = 1.5 * force_n,
            },
            Task::Load { target_n, purpose } => {
                let (target_n, purpose) = (*target_n, *purpose);
                self.aim_n = target_n;
                self.loaded = purpose == Purpose::Reading;
                if let Some(place) = &view.place {
                    self.at = ((place.cell, place.repeat), place.step);
                }
                if purpose == Purpose::Free {
                    self.aim_n = self.left_on_n;
                }
                if purpose != Purpose::Reading && target_n != 0.0 {
                    let key = (self.seed, self.at.0, purpose == Purpose::Preload);
                    self.aim_n += self.preload_off_n * (2.0 * uniform(key) - 1.0);
                }
                if let (Purpose::Reading, Some(place)) = (purpose, &view.place)
                    && target_n != 0.0
                {
                    // The operator stops a little off, always alike at one test point.
                    let key = place.step * 7 + place.repeat * 3 + place.cell as u32 * 5;
                    self.aim_n += f64::from(key % 5) * 0.1 - 0.2;
                }
                let shown_n = view.force.value_si.filter(|_| self.by_display);
                if let (Some(shown_n), true) = (shown_n, purpose != Purpose::Free) {
                    self.aim_n += self.force_n - shown_n;
                }
            }
            _ => {}
        }
    }

    /// Whether a hand pushes along an axis before it is time to; for as long behind that it rests, and then does what it is told.
    fn is_eager(&mut self, gauge: Channel) -> Option<bool> {
        let axis = gauge.axis().map_or(0, Direction::index);
        let until_s = self.now_s + self.eager_s;
        let until_s = *self.eager_until_s[axis].get_or_insert(until_s);
        (self.now_s < until_s + self.eager_s).then_some(self.now_s < until_s)
    }

    /// The jack moves for a tick.
    pub(crate) fn turn(&mut self) {
        let left_n = self.aim_n - self.force_n;
        // A hand does not turn evenly.
        let most_n = JACK_N * (0.6 + 0.4 * (7.3 * self.now_s).sin());
        self.force_n += left_n.clamp(-most_n, most_n);
        self.past_n.push_back(self.force_n);
        if self.past_n.len() > 100 {
            self.past_n.pop_front();
        }
    }

    pub(crate) fn sample(&self, channel: Channel) -> Option<GaugeEvent> {
        if self.fault == Some(Fault::Silent(channel)) {
            return None;
        }
        let mut value_si = self.shown_si(channel) - self.zero_si[channel.index()];
        // Of three displacement gauges the one along y has the fault.
        let displacement = matches!(channel, Channel::Displacement | Channel::DisplacementY);
        let frozen = displacement && self.fault == Some(Fault::Frozen);
        if frozen {
            value_si = 12e-6;
        }
        let noise_si = self.noise_si[usize::from(channel != Channel::Force)];
        if noise_si > 0.0 {
            value_si += noise_si * normal((self.seed, channel.index(), self.now_s.to_bits()));
        }
        value_si = self.held_si[channel.index()].unwrap_or(value_si);
        if let Some(display) = self.displays[usize::from(channel != Channel::Force)] {
            value_si = display(self, value_si);
        }
        if value_si.is_nan() {
            return None;
        }
        let (step, unit, factor) = match channel {
            Channel::Force => (0.1, "N", 1.0),
            _ => (self.step_m, "mm", 1e3),
        };
        let value_si = (value_si / step).round() * step;
        let (digit, decimals) = match channel {
            Channel::Force => (step, 3),
            _ => (10_f64.powi(-3 - self.decimals as i32), self.decimals),
        };
        let unit = match self.fault {
            Some(Fault::Unit) if displacement => "in",
            _ => unit,
        };
        Some(GaugeEvent::Sample {
            channel,
            sample: Sample {
                kind: channel.kind(),
                value_si,
                resolution_si: digit,
                value: value_si * factor,
                unit: unit.into(),
                raw: format!("{:.decimals$} {unit}", value_si * factor).into(),
                at_s: self.now_s,
                bytes: [0; 2],
                marks: Vec::new(),
            },
        })
    }

    pub(crate) fn asked(&mut self, channel: Channel, ask: Ask) -> GaugeEvent {
        let answer = match ask {
            Ask::Zero if self.has_zero[channel.index()] => {
                let at = channel.index();
                self.zero_si[at] = self.shown_si(channel) - self.leaves_si[at];
                Ok("".into())
            }
            Ask::Zero => Err("it has no zero command".into()),
            Ask::Identity => Ok(format!("mock {channel}").into()),
            Ask::State => Ok("".into()),
        };
        GaugeEvent::Answered {
            channel,
            ask,
            answer,
        }
    }
}

/// A session on a mock bench, its journal in memory.
pub(crate) struct Rig {
    pub(crate) bench: MockBench,
    pub(crate) machine: Machine,
    pub(crate) journal: Journal<Disk>,
    /// What is answered where another answer than the usual is wanted.
    pub(crate) answers: Vec<(&'static str, Answer)>,
    /// What the gauges sent, with the time of each, s.
    pub(crate) sent: Vec<(f64, GaugeEvent)>,
    /// The question that is left open.
    pub(crate) leaves_open: &'static str,
    /// Prompts as they came.
    pub(crate) asked: Vec<Prompt>,
    pub(crate) said: Vec<String>,
    /// How often the operator was rung for.
    pub(crate) rings: usize,
    /// The bench as it stood at each event.
    pub(crate) snapshots: Vec<MockBench>,
    pub(crate) failed: bool,
    /// The gauges of the plan.
    channels: Vec<Channel>,
    /// The answer to which way the push by hand went.
    way: &'static str,
    /// Force and displacement from the zero as they were at each reading, N and m, and where the end stood at the zero, m.
    pub(crate) truth: Vec<[f64; 2]>,
    zero_m: f64,
    /// Number of a reading, and by how much it is taken wrongly, m.
    pub(crate) spike: Option<(u32, f64)>,
}

/// Readings that lie farther from the mean of their repeats than this, m.
const FAR_M: f64 = 40e-6;

/// Readings of a cell that are far from the others of their step.
fn far_from_others(state: &SessionState, cell: usize) -> Vec<Contradiction> {
    let all = || {
        let all = state.readings.iter().map(|kept| (kept, &kept.taken));
        all.filter(|(kept, taken)| kept.superseded.is_none() && taken.cell == cell)
    };
    let far = all().filter(|(_, one)| {
        let others = all().filter(|(_, other)| {
            (other.step, other.branch) == (one.step, one.branch) && other.number != one.number
        });
        let others: Vec<f64> = others.map(|(_, other)| other.displacement_m).collect();
        let mean_m = others.iter().sum::<f64>() / others.len() as f64;
        others.len() > 1 && (one.displacement_m - mean_m).abs() > FAR_M
    });
    far.map(|(_, taken)| Contradiction {
        numbers: vec![taken.number],
        text: format!("reading {} is far off", taken.number),
    })
    .collect()
}

/// Displacement of the end along the base axes per force along a load, m/N: a symmetric compliance matrix.
pub(crate) fn compliance(direction: &LoadDirection) -> [f64; 3] {
    let matrix = [
        [5e-6, 1.37e-6, 2.23e-6],
        [1.37e-6, 3e-6, 7.1e-7],
        [2.23e-6, 7.1e-7, 8e-6],
    ];
    let along = direction.unit_vector();
    matrix.map(|row: [f64; 3]| (0..3).map(|i| row[i] * along[i]).sum())
}

pub(crate) fn plan(procedure: &Procedure) -> SessionPlan {
    SessionPlan::new(procedure, &[PoseId::new("P1"), PoseId::new("P2")])
}

pub(crate) fn shipped(name: &str) -> Procedure {
    let source = shipped_procedure(name).expect("it is shipped");
    Procedure::parse(&source).expect("it can be followed").0
}

/// A procedure of few readings: sweeps of three loads with settling that is quick in ticks.
pub(crate) fn short(unloading: bool) -> Procedure {
    let mut procedure = Procedure {
        loads_n: vec![0.0, -10.0, -20.0],
        directions: vec![Direction::X.into()],
        poses: Some(vec![PoseId::new("P1")]),
        repeats: 2,
        unloading,
        ..Procedure::default()
    };
    procedure.settle.dwell_s = 0.3;
    procedure
}

/// How a session begins.
pub(crate) fn started(procedure: &Procedure) -> Event {
    Event::Started(Started {
        schema: Some(JOURNAL_SCHEMA.to_owned()),
        session: "test".to_owned(),
        procedure: procedure.name.clone(),
        procedure_sha256: String::new(),
        robot_sha256: None,
        header_sha256: None,
        instruments_sha256: None,
        mechanism: None,
        origin: None,
        software: "test".to_owned(),
        pid: 1,
        host: "test".to_owned(),
        displacement_axes: procedure.displacement_axes.clone(),
    })
}

/// How a session is taken up again.
pub(crate) fn resumed() -> Event {
    Event::Resumed(Resumed {
        software: "test".to_owned(),
        pid: 2,
        host: "test".to_owned(),
        cut_bytes: 0,
    })
}

impl Rig {
    /// A new session.
    pub(crate) fn start(procedure: &Procedure) -> Self {
        let disk = Disk {
            bytes: Vec::new(),
            room: usize::MAX,
        };
        let mut rig = Self::on(
            procedure,
            SessionState::default(),
            MockBench::default(),
            Journal::behind(disk, 0),
        );
        rig.record(started(procedure));
        rig
    }

    /// A session of few readings, up to that of this number.
    pub(crate) fn up_to(readings: usize) -> Self {
        let mut rig = Self::start(&short(false));
        rig.until(20_000, |rig| rig.machine.state().readings.len() == readings);
        rig
    }

    /// The bench scatters so much from load to load, m, and says so.
    pub(crate) fn scatters(mut self, procedure: &Procedure, scatter_m: f64) -> Self {
        self.bench.scatter_m = scatter_m;
        let settings = Settings {
            checks_repeats: true,
            scatter_m: Some(scatter_m),
            ..Settings::default()
        };
        self.machine = Machine::new(plan(procedure), settings, self.machine.state().clone());
        self
    }

    /// A new session with other settings.
    pub(crate) fn with_settings(procedure: &Procedure, settings: Settings) -> Self {
        let mut rig = Self::start(procedure);
        rig.machine = Machine::new(plan(procedure), settings, rig.machine.state().clone());
        rig
    }

    fn on(
        procedure: &Procedure,
        state: SessionState,
        bench: MockBench,
        journal: Journal<Disk>,
    ) -> Self {
        let plan = plan(procedure);
        Self {
            channels: plan.channels(),
            spike: None,
            truth: Vec::new(),
            zero_m: 0.0,
            way: if plan.procedure.load_sense() < 0.0 {
                "minus"
            } else {
                "plus"
            },
            machine: Machine::new(
                plan,
                Settings {
                    checks_repeats: true,
                    scatter_m: Some(bench.scatter_m).filter(|scatter_m| *scatter_m > 0.0),
                    ..Settings::default()
                },
                state,
            ),
            bench,
            journal,
            answers: Vec::new(),
            leaves_open: "",
            sent: Vec::new(),
            asked: Vec::new(),
            said: Vec::new(),
            rings: 0,
            snapshots: Vec::new(),
            failed: false,
        }
    }

    /// The session taken up again from these bytes of its journal, a record that was cut taken off.
    pub(crate) fn resume(procedure: &Procedure, bytes: &[u8], bench: MockBench) -> Self {
        let read = read_journal(bytes);
        let disk = Disk {
            bytes: bytes[..read.good_bytes].to_vec(),
            room: usize::MAX,
        };
        let journal = Journal::behind(disk, read.records.len() as u64);
        let state = SessionState::fold(&read.records);
        let began = state.started.is_some();
        let mut rig = Self::on(procedure, state, bench, journal);
        if began {
            rig.record(resumed());
        }
        rig
    }

    pub(crate) fn record(&mut self, event: Event) -> bool {
        let utc = Timestamp::UNIX_EPOCH + SignedDuration::from_secs_f64(self.bench.now_s);
        // The question is answered before the bench is looked at again; gauges along the axes see where the load goes.
        if let (Event::PoseSet(set), true) = (&event, self.channels.len() > 2) {
            self.bench.direction.clone_from(&set.direction);
        }
        let along = self.bench.direction.unit_vector();
        let compliance: f64 = (0..3).map(|i| along[i] * self.bench.compliance()[i]).sum();
        let end_m = compliance * self.bench.force_n;
        match &event {
            Event::Reading(taken) => {
                self.truth.push([self.bench.force_n, end_m - self.zero_m]);
                self.bench.taken = (taken.number as usize, self.bench.now_s);
            }
            Event::Zero(zeroed) if zeroed.moment == ZeroOccasion::Before => self.zero_m = end_m,
            _ => {}
        }
        let Ok(record) = self.journal.append(event, utc, self.bench.now_s) else {
            self.failed = true;
            return false;
        };
        self.machine.recorded(&record);
        self.snapshots.push(self.bench.clone());
        true
    }

    fn usual(&self, prompt: &Prompt) -> Answer {
        if let Some((_, answer)) = self.answers.iter().find(|(id, _)| *id == prompt.id) {
            return answer.clone();
        }
        match prompt.id.as_str() {
            "humidity" | "bench-note" | "temperature-end" | "humidity-end" | "bench-note-end"
            | "redo-cause" => Answer::Text(String::new()),
            "temperature" => Answer::Number(20.0),
            "sign-check" => Answer::Text(self.way.to_owned()),
            "skip-reason" | "note" => Answer::Text("a reason".to_owned()),
            "force-offset" => Answer::Text("zero".to_owned()),
            "drift" | "bad-reading" => Answer::Text("keep".to_owned()),
            "not-settled" => Answer::Text("wait".to_owned()),
            "frozen" | "implausible" | "displacement-sign" | "zero-not-shown" | "changed"
            | "force-steps" | "displacement-steps" | "limit" => Answer::Text("again".to_owned()),
            _ => Answer::Yes(true),
        }
    }

    pub(crate) fn input(&mut self, input: Input) {
        let mut next = Some(input);
        while let Some(input) = next.take() {
            let actions = self.machine.input(input, self.bench.now_s);
            let mut answers = Vec::new();
            let acted = !actions.is_empty();
            for action in actions {
                match action {
                    Action::Record(mut event) => {
                        if let (Event::Reading(taken), Some((number, by_m))) =
                            (&mut *event, self.spike)
                            && taken.number == number
                        {
                            taken.displacement_m += by_m;
                        }
                        if !self.record(*event) {
                            return;
                        }
                    }
                    Action::Ask(channel, ask) => {
                        let answered = self.bench.asked(channel, ask);
                        self.sent.push((self.bench.now_s, answered.clone()));
                        answers.push(Input::Gauge(answered));
                    }
                    Action::Prompt(prompt) => {
                        let (id, answer) = (prompt.id.clone(), self.usual(&prompt));
                        assert_listed(&prompt);
                        self.asked.push(prompt);
                        if id == self.leaves_open {
                            continue;
                        }
                        answers.push(Input::Operator(OperatorEvent::Answer { id, answer }));
                    }
                    Action::CheckRepeats(cell) => {
                        let found = far_from_others(self.machine.state(), cell);
                        let wanted = self.spike.map(|_| found).unwrap_or_default();
                        answers.push(Input::RepeatsChecked(wanted));
                    }
                    Action::Say(line) => self.said.push(line),
                    Action::Bell(bell) => self.rings += usize::from(bell == Bell::Attention),
                    Action::Finish(_) => {}
                }
            }
            for answer in answers {
                self.input(answer);
            }
            next = acted.then_some(Input::Tick);
        }
    }

    pub(crate) fn tick(&mut self) {
        self.bench.now_s += TICK_S;
        self.bench.follow(&self.machine.view());
        self.bench.turn();
        for channel in self.channels.clone() {
            if let Some(event) = self.bench.sample(channel) {
                self.sent.push((self.bench.now_s, event.clone()));
                self.input(Input::Gauge(event));
            }
        }
        self.input(Input::Tick);
    }

    /// Some ticks pass.
    pub(crate) fn wait(&mut self, ticks: usize) {
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// The operator does something.
    pub(crate) fn operator(&mut self, event: OperatorEvent) {
        self.input(Input::Operator(event));
    }

    /// From now on these questions are answered with these words.
    pub(crate) fn answer(&mut self, answers: &[(&'static str, &str)]) {
        let answers = answers.iter();
        let answers = answers.map(|(id, word)| (*id, Answer::Text((*word).to_owned())));
        self.answers.extend(answers);
    }

    /// Whether a question was put.
    pub(crate) fn was_asked(&self, id: &str) -> bool {
        self.asked.iter().any(|prompt| prompt.id == id)
    }

    /// The cable of a gauge is pulled.
    pub(crate) fn unplug(&mut self, channel: Channel) {
        let reason = "unplugged".into();
        self.link(channel, LinkState::Lost { reason });
    }

    /// It is put back, and has another name.
    pub(crate) fn plug_in(&mut self, channel: Channel) {
        let port = "/dev/ttyUSB3".into();
        self.link(channel, LinkState::Connected { port });
    }

    fn link(&mut self, channel: Channel, state: LinkState) {
        let at_s = self.bench.now_s;
        self.input(Input::Gauge(GaugeEvent::Link {
            channel,
            state,
            at_s,
        }));
    }

    /// What a gauge sends is no value.
    pub(crate) fn reject(&mut self, channel: Channel, raw: &str) {
        let rejected = Rejected {
            raw: raw.into(),
            reason: "it is not a value".into(),
            at_s: self.bench.now_s,
        };
        self.input(Input::Gauge(GaugeEvent::Rejected { channel, rejected }));
    }

    /// Runs to the end, or to where it can be written no more.
    pub(crate) fn run(&mut self) -> Option<SessionEnd> {
        for _ in 0..MOST_TICKS {
            if self.machine.outcome().is_some() || self.failed {
                return self.machine.outcome();
            }
            self.tick();
        }
        panic!(
            "the session hangs: {:?}, {:?}, asked {:?}",
            self.machine.view().task,
            self.machine.view().held_up,
            self.asked.last().map(|prompt| &prompt.text)
        );
    }

    /// Runs until something holds, at most so many ticks.
    pub(crate) fn until(&mut self, ticks: usize, holds: impl Fn(&Self) -> bool) {
        for _ in 0..ticks {
            if holds(self) {
                return;
            }
            self.tick();
        }
        panic!("it did not come to that: {:?}", self.machine.view().task);
    }

    pub(crate) fn journal_bytes(self) -> Vec<u8> {
        self.journal.into_store().bytes
    }
}

/// A session whose journal is cut at some places and taken up again: no reading that was kept is lost, none is taken twice.
pub(crate) fn assert_cuts_lose_nothing(procedure: &Procedure, step: usize) {
    let mut whole = Rig::start(procedure);
    assert_eq!(whole.run(), Some(SessionEnd::Complete));
    let expected = csv_without_times(whole.machine.state());
    let snapshots = std::mem::take(&mut whole.snapshots);
    let bytes = whole.journal_bytes();
    for cut in (0..bytes.len()).step_by(step) {
        let read = read_journal(&bytes[..cut]);
        let acknowledged = SessionState::fold(&read.records).readings;
        let Some(last) = read.records.len().checked_sub(1) else {
            assert!(acknowledged.is_empty());
            continue;
        };
        let mut rig = Rig::resume(procedure, &bytes[..cut], snapshots[last].clone());
        assert_eq!(rig.run(), Some(SessionEnd::Complete), "cut at {cut}");
        let state = rig.machine.state();
        for (now, before) in state.readings.iter().zip(&acknowledged) {
            assert_eq!(now.taken, before.taken, "cut at {cut}");
        }
        assert_eq!(csv_without_times(state), expected, "cut at {cut}");
    }
}

/// While a gauge has a fault nothing is taken and it is said why; without it the session is completed.
pub(crate) fn assert_held_up(mut rig: Rig, fault: Fault, said: &str) -> Rig {
    let before = rig.machine.state().readings.len();
    rig.bench.fault = Some(fault);
    rig.wait(400);
    assert_eq!(rig.machine.state().readings.len(), before, "{fault:?}");
    let held_up = rig.machine.view().held_up;
    let is_said = held_up.iter().any(|line| line.contains(said));
    assert!(is_said, "{fault:?}: {held_up:?}");
    rig.bench.fault = None;
    assert_eq!(rig.run(), Some(SessionEnd::Complete), "{fault:?}");
    rig
}

/// The records of a journal that has no fault.
pub(crate) fn records(bytes: &[u8]) -> Vec<Record> {
    let read = read_journal(bytes);
    assert_eq!(read.end, stiffbench_session::JournalEnd::Clean);
    read.records
}

/// `readings.csv` without its times.
pub(crate) fn csv_without_times(state: &SessionState) -> String {
    let mut text = Vec::new();
    table(state, &mut text).expect("every number is finite");
    let text = String::from_utf8(text).expect("it is text");
    let names: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
    let times = ["utc", "t_s", "hold_s"].map(|name| names.iter().position(|n| *n == name));
    text.lines()
        .map(|line| {
            let fields = line.split(',').enumerate();
            let kept: Vec<&str> = fields
                .filter(|(place, _)| !times.contains(&Some(*place)))
                .map(|(_, field)| field)
                .collect();
            kept.join(",") + "\n"
        })
        .collect()
}
