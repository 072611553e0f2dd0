//! The progress of a session: a fold of its journal, and of nothing else.

use std::collections::BTreeMap;

use jiff::Timestamp;

use stiffbench_gauges::Channel;
use stiffbench_measurement::readings::{
    PoseJoints, Reading, ReadingStatus, ReadingTable, ReadingText, RunNumbers,
};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::decision::{Flagged, Skipped, Undone, UndoneAction};
use super::event::{
    ClockJump, Ended, Event, InstrumentSeen, JointSet, Noted, Started, TakenReading, ZeroOccasion,
    Zeroed,
};
use super::journal::Record;
use super::run::JUMP_S;
use super::surroundings::Surroundings;

/// The flag of readings whose zero has not been checked since.
const ZERO_NOT_CONFIRMED: &str = "the zero was not looked at again";

/// A reading with what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptReading {
    /// As taken.
    pub taken: TakenReading,
    /// When, s since the session began.
    pub t_s: f64,
    /// When.
    pub utc: Timestamp,
    /// Why it no longer counts; `None` if it does.
    pub superseded: Option<String>,
    /// What was found out about it later.
    pub flags: Vec<String>,
    /// Whether the zero it stands on was checked again.
    pub zero_confirmed: bool,
}

/// The gauge zero in use.
#[derive(Debug, Clone, PartialEq)]
pub struct CurrentZero {
    /// As set.
    pub set: Zeroed,
    /// When, s.
    pub at_s: f64,
    /// Drift at the last look, m.
    pub drift_m: Option<f64>,
}

/// The progress of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SessionState {
    /// How it began; `None` before its first event.
    pub started: Option<Started>,
    /// Number of events.
    pub events: u64,
    /// Time of the last event, s.
    pub last_s: f64,
    /// UTC of the last event.
    pub last_utc: Option<Timestamp>,
    /// All readings, by number.
    pub readings: Vec<KeptReading>,
    /// Planned readings that are taken: cell and index to place in `readings`.
    pub taken: BTreeMap<(usize, usize), usize>,
    /// Planned readings that are left out, with the reason.
    pub skipped: BTreeMap<(usize, usize), Skipped>,
    /// Sign of each gauge along the axis.
    pub signs: [Option<f64>; Channel::COUNT],
    /// The gauges as they were last seen.
    pub instruments: [Option<InstrumentSeen>; Channel::COUNT],
    /// The joints of each pose that was set, where they are known.
    pub poses: BTreeMap<String, Vec<JointSet>>,
    /// The gauge zero in use.
    pub zero: Option<CurrentZero>,
    /// How many zeros each scope of each cell has had.
    pub zeros: BTreeMap<(usize, String), u32>,
    /// The force under which each zero was set, N; where it is known.
    pub zero_forces: BTreeMap<(usize, String), f64>,
    /// Last temperature entered, °C.
    pub temperature_deg_c: Option<f64>,
    /// The surroundings, as often as they were entered.
    pub surroundings: Vec<Surroundings>,
    /// Notes, with their times, s.
    pub notes: Vec<(f64, Noted)>,
    /// How it ended; `None` while it runs and after a crash.
    pub ended: Option<Ended>,
    /// How far the last zero had moved at its check, in words, while nothing shows what was decided about the readings on it.
    pub undecided: Option<String>,
    /// Whether the zero is to be checked again: resumed, or a gauge was away, and no zero set or confirmed since.
    pub unconfirmed: bool,
}

impl KeptReading {
    /// All checks that it fails; empty for most.
    #[must_use]
    pub fn flag(&self) -> String {
        let unconfirmed = !self.zero_confirmed && self.superseded.is_none();
        let superseded = self.superseded.as_ref();
        let exceeded = self.taken.limits.as_ref();
        let parts = [self.taken.flag.clone()]
            .into_iter()
            .chain(exceeded.map(|checked| checked.exceeded.clone()))
            .chain(self.flags.iter().cloned())
            .chain(unconfirmed.then(|| ZERO_NOT_CONFIRMED.to_owned()))
            .chain(superseded.map(|reason| format!("superseded: {reason}")));
        let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
        parts.join("; ")
    }
}

impl SessionState {
    /// Where the session stands after these events.
    pub fn fold<'a>(records: impl IntoIterator<Item = &'a Record>) -> Self {
        let mut state = Self::default();
        for record in records {
            state.apply(record);
        }
        state
    }

    /// Takes in the next event. Any sequence of events gives a state; one that names what is not there changes nothing.
    pub fn apply(&mut self, record: &Record) {
        self.events = record.seq;
        self.last_s = record.t_s;
        self.last_utc = Some(record.utc);
        if record.event.decides_on_zero() {
            self.undecided = None;
        }
        match &record.event {
            Event::Started(started) => self.started = Some(started.clone()),
            Event::Resumed(_) => {
                self.ended = None;
                self.unconfirmed = true;
            }
            Event::Instrument(seen) => self.instruments[seen.channel.index()] = Some(seen.clone()),
            Event::SignCheck(check) => self.signs[check.channel.index()] = Some(check.sign),
            Event::Zero(zeroed) => self.zero(zeroed, record.t_s),
            Event::Reading(taken) => self.reading(taken, record),
            Event::Superseded(superseded) => {
                self.supersede(superseded.number, &superseded.reason);
            }
            Event::Flagged(flagged) => self.flag(flagged),
            Event::Link(change) => self.unconfirmed |= change.lost,
            Event::Skipped(skipped) => {
                let at = (skipped.cell, skipped.index);
                self.skipped.insert(at, skipped.clone());
            }
            Event::Undone(undone) => self.undo(undone),
            Event::Note(noted) => self.notes.push((record.t_s, noted.clone())),
            Event::Environment(now) => {
                self.temperature_deg_c = now.temperature_deg_c.or(self.temperature_deg_c);
                self.surroundings.push(*now);
            }
            Event::Ended(ended) => self.ended = Some(ended.clone()),
            Event::PoseSet(set) => {
                self.poses.insert(set.pose.clone(), set.joints.clone());
            }
            Event::Gap(_)
            | Event::ClockJump(_)
            | Event::Paused(_)
            | Event::CalibrationWarning(_) => {}
        }
    }

    fn zero(&mut self, zeroed: &Zeroed, at_s: f64) {
        self.unconfirmed = false;
        let asked = zeroed.moment == ZeroOccasion::After && !zeroed.flag.is_empty();
        self.undecided = asked.then(|| zeroed.flag.clone());
        if zeroed.moment == ZeroOccasion::Before {
            *self
                .zeros
                .entry((zeroed.cell, zeroed.scope.clone()))
                .or_default() += 1;
            if let Some(preload_n) = zeroed.preload_n {
                let zero = (zeroed.cell, zeroed.label.clone());
                self.zero_forces.insert(zero, preload_n);
            }
            self.zero = Some(CurrentZero {
                set: zeroed.clone(),
                at_s,
                drift_m: None,
            });
        } else if let Some(zero) = &mut self.zero {
            let drifts = zeroed.gauges.iter().filter_map(|gauge| gauge.drift_m);
            let drifts = drifts.chain(zeroed.drift_m);
            // The largest, and the first of equal ones.
            zero.drift_m = drifts.min_by(|a, b| b.abs().total_cmp(&a.abs()));
            let on_it = self
                .readings
                .iter_mut()
                .filter(|kept| (kept.taken.cell, &kept.taken.zero) == (zeroed.cell, &zeroed.label));
            for kept in on_it.filter(|kept| !kept.zero_confirmed) {
                kept.zero_confirmed = true;
                if !zeroed.flag.is_empty() {
                    kept.flags.push(zeroed.flag.clone());
                }
            }
        }
    }

    fn flag(&mut self, flagged: &Flagged) {
        let named = |kept: &&mut KeptReading| flagged.numbers.contains(&kept.taken.number);
        for kept in self.readings.iter_mut().filter(named) {
            kept.flags.push(flagged.flag.clone());
        }
    }

    fn undo(&mut self, undone: &Undone) {
        match &undone.action {
            UndoneAction::Reading { number } => self.supersede(*number, "undone"),
            UndoneAction::Skip { cell, indices, .. } => {
                for index in indices {
                    self.skipped.remove(&(*cell, *index));
                }
            }
            UndoneAction::Flag { numbers, flag } => {
                let named = |kept: &&mut KeptReading| numbers.contains(&kept.taken.number);
                for kept in self.readings.iter_mut().filter(named) {
                    kept.flags.retain(|of| of != flag);
                }
            }
        }
    }

    /// The readings that count.
    #[must_use]
    pub fn accepted(&self) -> impl DoubleEndedIterator<Item = &KeptReading> {
        let readings = self.readings.iter();
        readings.filter(|kept| kept.superseded.is_none())
    }

    /// The readings that count and stand on the zero in use.
    pub fn on_zero(&self) -> impl Iterator<Item = &KeptReading> {
        let zero = self.zero.as_ref().map(|zero| &zero.set);
        let zero = zero.map(|set| (set.cell, &set.label));
        self.accepted()
            .filter(move |kept| zero == Some((kept.taken.cell, &kept.taken.zero)))
    }

    /// Whether the reading of a number counts.
    #[must_use]
    pub fn counts(&self, number: u32) -> bool {
        self.accepted().any(|kept| kept.taken.number == number)
    }

    /// Whether readings that count still have a flag.
    #[must_use]
    pub fn is_flagged(&self, flagged: &Flagged) -> bool {
        self.accepted().any(|kept| {
            flagged.numbers.contains(&kept.taken.number) && kept.flags.contains(&flagged.flag)
        })
    }

    fn reading(&mut self, taken: &TakenReading, record: &Record) {
        let at = (taken.cell, taken.index);
        self.skipped.remove(&at);
        // Two accepted readings of one test point cannot be: the later counts.
        if let Some(&earlier) = self.taken.get(&at) {
            self.readings[earlier].superseded = Some("taken again".to_owned());
        }
        self.taken.insert(at, self.readings.len());
        self.readings.push(KeptReading {
            taken: taken.clone(),
            t_s: record.t_s,
            utc: record.utc,
            superseded: None,
            flags: Vec::new(),
            zero_confirmed: false,
        });
    }

    fn supersede(&mut self, number: u32, reason: &str) {
        let found = self
            .readings
            .iter()
            .position(|kept| kept.taken.number == number);
        let Some(place) = found else {
            return;
        };
        let kept = &mut self.readings[place];
        kept.superseded = Some(reason.to_owned());
        let at = (kept.taken.cell, kept.taken.index);
        if self.taken.get(&at) == Some(&place) {
            self.taken.remove(&at);
        }
    }

    /// The jump of a clock that is behind the last event of an interrupted session.
    #[must_use]
    pub fn clock_gone_back(&self, now: Timestamp) -> Option<Event> {
        let seconds = now.duration_since(self.last_utc?).as_secs_f64();
        (seconds < -JUMP_S).then_some(Event::ClockJump(ClockJump { seconds }))
    }

    /// How often a planned reading was taken so far.
    #[must_use]
    pub fn attempts(&self, cell: usize, index: usize) -> u32 {
        let tries = self
            .readings
            .iter()
            .filter(|kept| (kept.taken.cell, kept.taken.index) == (cell, index));
        tries.count() as u32
    }

    /// The last reading that counts.
    #[must_use]
    pub fn last_accepted(&self) -> Option<&KeptReading> {
        self.accepted().next_back()
    }

    /// Sign and offset of a gauge: the value along the axis from the zero is the sign times what the gauge shows less the offset.
    #[must_use]
    pub fn axis(&self, channel: Channel) -> (f64, f64) {
        let sign = self.signs[channel.index()].unwrap_or(1.0);
        let offset = self.zero.as_ref().map_or(0.0, |zero| match channel {
            Channel::Force => zero.set.force_offset_n,
            Channel::Displacement => zero.set.displacement_offset_m,
            axis => {
                let mut gauges = zero.set.gauges.iter();
                let of_axis = gauges.find(|gauge| gauge.channel == axis);
                of_axis.map_or(0.0, |gauge| gauge.offset_m)
            }
        });
        (sign, offset)
    }

    /// Whether its displacement gauges stand along the base axes; a journal that lost its beginning shows it by its readings.
    #[must_use]
    pub fn is_of_vectors(&self) -> bool {
        let started = self.started.as_ref();
        started.is_some_and(|started| !started.displacement_axes.is_empty())
            || self
                .readings
                .iter()
                .any(|kept| !kept.taken.gauges.is_empty())
    }

    /// The readings as they go into `readings.csv`, of each displacement gauge one.
    #[must_use]
    pub fn table(&self) -> ReadingTable {
        let started = self.started.as_ref();
        let mut table = ReadingTable {
            session: started.map(|started| started.session.clone()),
            origin: started.and_then(|started| started.origin.clone()),
            pose_joints: self.pose_joints(),
            ..ReadingTable::default()
        };
        let of_vectors = self.is_of_vectors();
        let (mut runs, mut zeros) = (RunNumbers::default(), RunNumbers::default());
        for kept in &self.readings {
            let reading = reading(kept, &mut runs, &mut zeros);
            if !of_vectors {
                table.readings.push(reading);
                continue;
            }
            let load = &kept.taken.direction;
            for direction in Direction::ALL {
                let mut gauges = kept.taken.gauges.iter();
                let gauge = gauges.find(|of| of.channel.axis() == Some(direction));
                let Some(gauge) = gauge else { continue };
                let other = (*load != direction).then(|| table.place_of(load));
                let mut reading = Reading {
                    direction,
                    load: other,
                    displacement_m: gauge.displacement_m,
                    ..reading.clone()
                };
                if let Some(text) = &mut reading.text {
                    text.displacement_raw = gauge.raw.as_str().into();
                    text.zero_si = [text.zero_si[0], Some(gauge.zero_m)];
                }
                table.readings.push(reading);
            }
        }
        (table.runs, table.zeros) = (runs.into_keys(), zeros.into_keys());
        table
    }

    /// The readings of a cell with the displacement along its load, as if that were x; none where an axis of the load is not read.
    #[must_use]
    pub fn readings_along_load(&self, cell: usize) -> Vec<Reading> {
        let (mut runs, mut zeros) = (RunNumbers::default(), RunNumbers::default());
        let of_cell = self.readings.iter().filter(|kept| kept.taken.cell == cell);
        let along = of_cell.filter_map(|kept| Some((kept, kept.taken.along_load_m()?)));
        along
            .map(|(kept, displacement_m)| Reading {
                displacement_m,
                direction: Direction::X,
                ..reading(kept, &mut runs, &mut zeros)
            })
            .collect()
    }

    /// The values of the robot's variables in the poses that were set, as far as they are known.
    fn pose_joints(&self) -> Vec<PoseJoints> {
        let poses = self.poses.iter().map(|(pose, set)| PoseJoints {
            pose: PoseId::new(pose),
            values: set.iter().filter_map(JointSet::column).collect(),
        });
        poses.collect()
    }
}

/// A reading of the one displacement gauge, along the load.
fn reading(kept: &KeptReading, runs: &mut RunNumbers, zeros: &mut RunNumbers) -> Reading {
    let taken = &kept.taken;
    let pose = PoseId::new(&taken.pose);
    // With one displacement gauge every load is along an axis.
    let direction = taken.direction.axis().unwrap_or(Direction::X);
    let number = |numbers: &mut RunNumbers, label: &str| {
        numbers.number(&pose, direction, taken.repeat, Some(label))
    };
    Reading {
        line: 0,
        seq: taken.number,
        run: number(runs, &taken.repeat.to_string()),
        zero: number(zeros, &taken.zero),
        pose: pose.clone(),
        direction,
        load: None,
        branch: taken.branch,
        step: taken.step,
        repeat: taken.repeat,
        attempt: taken.attempt,
        status: match kept.superseded {
            Some(_) => ReadingStatus::Superseded,
            None => ReadingStatus::Accepted,
        },
        target_n: taken.target_n,
        force_n: taken.force_n,
        displacement_m: taken.displacement_m,
        time_s: Some(milliseconds(kept.t_s)),
        hold_s: Some(milliseconds(taken.hold_s)),
        temperature_deg_c: taken.temperature_deg_c,
        text: Some(Box::new(ReadingText {
            utc: kept.utc.to_string().into(),
            force_raw: taken.force_raw.as_str().into(),
            displacement_raw: taken.displacement_raw.as_str().into(),
            zero_si: taken.zero_si.map_or([None; 2], |zeros| zeros.map(Some)),
            flag: kept.flag().into(),
            note: Box::default(),
        })),
    }
}

/// A time to the millisecond; no reading is timed better.
fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1000.0).round() / 1000.0
}
