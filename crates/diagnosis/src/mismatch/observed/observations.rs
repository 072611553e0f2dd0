//! Readings laid out for the search: cells, runs and gauge zeros as ranges of plain arrays.

use std::collections::HashSet;
use std::ops::Range;

use crate::search::largest;
use stiffbench_beams::physics::{LoadPoint, Place, PoseMechanics, RunLoads, TestObject};
use stiffbench_beams::robot::TrackerFrames;
use stiffbench_measurement::readings::{
    InstrumentRecord, Reading, ReadingTable, SessionHeader, SinceZero,
};
use stiffbench_measurement::specimen::ResponseDoubt;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::{Branch, Cell, Direction, PoseId};

use super::beginnings::Beginnings;
use super::reading_noise::ReadingNoise;
use super::recorded_history::RecordedHistory;
use crate::search::constants::{ENOUGH_OF_A_LINE, FEWEST_LEFT};

/// A pose, a direction of loads and what one gauge read, with its readings.
///
/// The cells of several gauges that were read under the same loads follow each other: a series.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedCell {
    /// Index of the pose among the observed poses.
    pub pose: usize,
    /// The direction of the loads.
    pub load: LoadDirection,
    /// What was read.
    pub read: ReadAxis,
    /// Its runs.
    pub runs: Range<usize>,
    /// Its readings.
    pub readings: Range<usize>,
}

impl ObservedCell {
    /// Whether the displacement was read along the load.
    #[must_use]
    pub fn is_along_load(&self) -> bool {
        self.read.base_axis().is_some_and(|axis| self.load == axis)
    }

    /// Its compliance in a structure, m/N.
    pub(crate) fn compliance(&self, pose: &PoseMechanics) -> f64 {
        pose.compliance(&self.read, &self.load)
    }

    /// What a lever makes of a load in its displacement, m².
    pub(crate) fn lever_product(&self, lever: [f64; 6]) -> f64 {
        PoseMechanics::lever_product(lever, &self.read, &self.load)
    }

    /// The axis along which the displacement was read, among those that it is stated in.
    #[must_use]
    pub fn axis(&self) -> Direction {
        self.read.axis()
    }

    /// Whether it is of the same pose and load as the cell before it.
    fn goes_on(&self, before: &Self) -> bool {
        self.pose == before.pose
            && self.load == before.load
            && before.read.place() < self.read.place()
    }
}

/// Readings with one history: virgin, unless it goes on.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedRun {
    /// Index of its cell.
    pub cell: usize,
    /// Its repeat.
    pub repeat: u32,
    /// Its number in its session: the runs of several gauges under the same loads have it in common.
    pub session_run: u32,
    /// Its readings, in the order in which they were made.
    pub readings: Range<usize>,
    /// Whether joints begin it as the run before left them.
    pub goes_on: bool,
}

/// What the search needs to know of a reading, besides force and displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedReading {
    /// Index of its run.
    pub run: usize,
    /// Its number in its session: several gauges that were read at once have it in common.
    pub seq: u32,
    /// Number of its gauge zero.
    pub zero: u32,
    /// Branch.
    pub branch: Branch,
    /// Place among the readings of its run that share a step: 0, then 1, 2 … for holds.
    pub hold_number: u32,
    /// Seconds since the session began, if known.
    pub time_s: Option<f64>,
    /// Line in its file.
    pub line: u32,
    /// The load that was aimed at, N.
    pub target_n: f64,
    /// Whether a rule or a person flagged it.
    pub flagged: bool,
}

/// Steps of the gauges, as the instrument records state them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GaugeSteps {
    /// Display step of the force gauge, N.
    pub force_n: Option<f64>,
    /// Step of the displacement gauge, m.
    pub displacement_m: Option<f64>,
}

impl GaugeSteps {
    /// Those that a session states.
    #[must_use]
    pub fn of(header: Option<&SessionHeader>) -> Self {
        let instruments = header.map(|header| &header.instruments);
        let step = |record: Option<&InstrumentRecord>| record.and_then(|record| record.resolution);
        Self {
            force_n: step(instruments.and_then(|i| i.force.as_ref())),
            displacement_m: step(instruments.and_then(|i| {
                let mut along = i.displacement_along.iter().flatten();
                i.displacement.as_ref().or_else(|| along.next())
            })),
        }
    }
}

/// One of several sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedSession {
    /// What it is called: its poses are called `session/pose`.
    pub name: String,
    /// Its readings.
    pub readings: Range<usize>,
    /// Its runs.
    pub runs: Range<usize>,
    /// Steps of its gauges.
    pub steps: GaugeSteps,
    /// Force between its loads, if each load is released before the next.
    pub release_n: Option<f64>,
    /// Its noise by its own readings.
    pub noise: ReadingNoise,
}

/// The accepted readings of a session, sorted by cell and run.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    /// Poses, in the order of the session.
    pub poses: Vec<PoseId>,
    /// Cells.
    pub cells: Vec<ObservedCell>,
    /// Runs.
    pub runs: Vec<ObservedRun>,
    /// Readings.
    pub readings: Vec<ObservedReading>,
    /// Their loads.
    pub loads: Vec<LoadPoint>,
    /// Their displacements, m.
    pub displacement_m: Vec<f64>,
    /// Axes of the displacement gauges, where several were read at once; empty of one gauge, whichever axis it was read along.
    pub gauges: Vec<Direction>,
    /// Steps of the gauges.
    pub steps: GaugeSteps,
    /// Force between loads, if each load is released before the next.
    pub release_n: Option<f64>,
    /// Whether times, hold times and temperatures were recorded.
    pub recorded: Recorded,
    /// Whether a gauge zero may be anything: where a line is drawn through readings without a zeroed gauge.
    pub free_zeros: bool,
    /// The sessions, where they are several.
    pub sessions: Vec<ObservedSession>,
    /// Largest displacement of a cell without load, m, from which it counts, where the gauge was not zeroed there.
    pub unloaded_shift_m: Option<f64>,
    /// What they were taken of.
    pub object: TestObject,
    /// What the clock has against the response of a part.
    pub response_doubt: Option<ResponseDoubt>,
    /// What tells when a reading was taken.
    pub clock: ReadingClock,
    /// What parts without a robot file went through, each from its beginning on.
    pub histories: Vec<RecordedHistory>,
    /// How runs begin.
    pub beginnings: Beginnings,
    /// Of absolute positions where a tracker stands, and which point of the tool it sees: what was read is counted from the rigid robot there.
    pub tracker: Option<TrackerFrames>,
    /// What readings were before they were moved to the path of what was set.
    pub(crate) on_path: Option<OnPath>,
}

/// Readings of a part that were moved to the path of what was set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OnPath {
    /// Standard deviation of the errors by which what was set was read, in the unit of loads.
    pub(crate) error_n: f64,
    /// Smallest difference between two answers as they were read, m.
    pub(crate) resolution_m: f64,
}

/// What tells when a reading was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadingClock {
    /// Times.
    Times,
    /// A column with the order of measurement.
    Order,
    /// The order of the rows, which somebody may have sorted.
    Rows,
    /// The loads of a part, which went one way only, at one rate: times tell no more than they do.
    OneSweep,
}

/// Columns that some laws need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Recorded {
    /// Clock, or an order in its stead.
    pub time: bool,
    /// Time under load.
    pub hold: bool,
    /// Temperature.
    pub temperature: bool,
}

/// Share of the largest load of a cell below which one the other way is none (1). By judgement.
const NO_LOAD: f64 = 0.05;

impl Observations {
    /// Lays out the accepted readings of a table.
    #[must_use]
    pub fn new(table: &ReadingTable, header: Option<&SessionHeader>) -> Self {
        let poses = table.poses();
        let pose_of = |reading: &Reading| {
            poses
                .iter()
                .position(|pose| *pose == reading.pose)
                .expect("the table lists the poses of its readings")
        };
        let mut rows: Vec<(usize, &Reading, SinceZero)> = table
            .readings
            .iter()
            .zip(table.since_zero())
            .filter(|(reading, _)| reading.is_accepted())
            .map(|(reading, since)| (pose_of(reading), reading, since))
            .collect();
        // Stable: within a run the order of the session is kept.
        let place_of_load = |reading: &Reading| match reading.load.map(usize::from) {
            None => reading.direction.index(),
            Some(place) => match table.load_directions.get(place).map(LoadDirection::axis) {
                Some(Some(axis)) => axis.index(),
                _ => Direction::ALL.len() + place,
            },
        };
        rows.sort_by_key(|(pose, reading, _)| {
            let axis = reading.direction.index();
            (*pose, place_of_load(reading), axis, reading.run)
        });
        let any = |known: fn(&Reading) -> bool| table.accepted().any(known);
        let recorded = Recorded {
            time: any(|reading| reading.time_s.is_some()),
            hold: any(|reading| reading.hold_s.is_some()),
            temperature: any(|reading| reading.temperature_deg_c.is_some()),
        };
        let mut observations = Self {
            release_n: header.and_then(SessionHeader::release_n),
            ..Self::without_readings(GaugeSteps::of(header), recorded)
        };
        for (pose, reading, since) in rows {
            observations.push_recorded((pose, table.load_direction(reading)), reading, since);
        }
        observations.poses = poses;
        observations.gauges = observations.gauges_read_at_once();
        observations.unloaded_shift_m = observations.count_from_unloaded();
        observations
    }

    /// No reading yet, of a robot whose gauges are zeroed.
    pub(crate) fn without_readings(steps: GaugeSteps, recorded: Recorded) -> Self {
        Self {
            poses: Vec::new(),
            cells: Vec::new(),
            runs: Vec::new(),
            readings: Vec::new(),
            loads: Vec::new(),
            displacement_m: Vec::new(),
            gauges: Vec::new(),
            steps,
            release_n: None,
            recorded,
            free_zeros: false,
            sessions: Vec::new(),
            unloaded_shift_m: None,
            object: TestObject::Robot,
            response_doubt: None,
            clock: ReadingClock::Times,
            histories: Vec::new(),
            beginnings: Beginnings::default(),
            tracker: None,
            on_path: None,
        }
    }

    /// Number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether loads went one way only, at one rate: then times tell no more than loads do.
    #[must_use]
    pub fn is_one_sweep(&self) -> bool {
        self.clock == ReadingClock::OneSweep
    }

    /// Whether there is no reading.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// What displacements are of the order of, m: a millimetre at the end of a robot, the largest answer of a part.
    pub(crate) fn usual_displacement_m(&self) -> f64 {
        match self.object {
            TestObject::Robot => 1e-3,
            TestObject::ForceDriven | TestObject::DisplacementDriven => {
                // Answers that are all zero have no size.
                let largest = largest(&self.displacement_m);
                if largest > 0.0 { largest } else { 1.0 }
            }
        }
    }

    /// Largest displacement per force of a cell, m/N; zero where no force acted.
    ///
    /// # Arguments
    /// - `weight_n`: own weight of the robot, N, or of what is known to weigh something: it acts beside the load where positions are counted from the rigid robot.
    #[must_use]
    pub fn largest_m_per_n(&self, weight_n: f64) -> f64 {
        let weight_n = self.tracker.map_or(0.0, |_| weight_n);
        let of_cell = |cell: &ObservedCell| {
            let forces = self.loads[cell.readings.clone()].iter();
            let force_n = forces.fold(0.0, |most: f64, load| most.max(load.force_n.abs()));
            let force_n = force_n + weight_n;
            let displacement_m = largest(&self.displacement_m[cell.readings.clone()]);
            if force_n > 0.0 {
                displacement_m / force_n
            } else {
                0.0
            }
        };
        let displacements = self.cells.iter().filter(|cell| !cell.read.is_rotation());
        displacements.map(of_cell).fold(0.0, f64::max)
    }

    /// Size of the largest load, N; of a part in the unit of what was set.
    pub(crate) fn largest_load(&self) -> f64 {
        let sizes = self.loads.iter().map(|load| load.force_n.abs());
        sizes.fold(0.0, f64::max)
    }

    /// Whether some readings are loaded both ways: beyond what is left on, or read, where no load should be.
    pub(crate) fn is_loaded_both_ways(&self, readings: Range<usize>) -> bool {
        let forces = self.loads[readings].iter().map(|load| load.force_n);
        let ends = forces.fold([0.0_f64; 2], |[least, most], n| [least.min(n), most.max(n)]);
        let smaller = ends[1].min(-ends[0]);
        smaller > NO_LOAD * ends[1].max(-ends[0])
    }

    /// Whether any run has several loads, of which zero and slope of the run can be told apart.
    #[must_use]
    pub fn has_series(&self) -> bool {
        self.runs.iter().any(|run| run.readings.len() > 1)
    }

    /// Whether loads were repeated so often that their differences show the noise.
    pub(crate) fn has_repeats(&self) -> bool {
        let dof = self.cells.iter().map(|cell| {
            let loads = cell.readings.clone().map(|reading| self.load_key(reading));
            cell.readings.len() - loads.collect::<HashSet<_>>().len()
        });
        dof.sum::<usize>() >= FEWEST_LEFT
    }

    /// Whether every run is long enough to show the noise about a smooth curve.
    pub(crate) fn has_long_runs(&self) -> bool {
        let is_long = |run: &ObservedRun| run.readings.len() >= ENOUGH_OF_A_LINE;
        self.runs.iter().all(is_long)
    }

    /// The loads of run number `run`, for the laws.
    #[must_use]
    pub fn run_loads(&self, run: usize) -> RunLoads<'_> {
        let ObservedRun {
            cell,
            repeat,
            readings,
            ..
        } = &self.runs[run];
        let cell = &self.cells[*cell];
        RunLoads {
            pose: &self.poses[cell.pose],
            load: &cell.load,
            read: cell.read,
            repeat: *repeat,
            release_n: self.release_of(run),
            loads: &self.loads[readings.clone()],
        }
    }

    /// The cells of each pose and direction of loads.
    pub(crate) fn series(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut first = 0;
        let chunks = self.cells.chunk_by(|before, cell| cell.goes_on(before));
        chunks.map(move |cells| {
            let series = first..first + cells.len();
            first = series.end;
            series
        })
    }

    /// The places of what one of several gauges does by itself: one for each of them, or one for the only one.
    pub(crate) fn of_gauges(&self, place: impl Fn(Option<Direction>) -> Place) -> Vec<Place> {
        if self.gauges.is_empty() {
            return vec![place(None)];
        }
        self.gauges.iter().map(|axis| place(Some(*axis))).collect()
    }

    /// A cell by its name.
    #[must_use]
    pub fn named(&self, cell: &ObservedCell) -> Cell {
        Cell {
            pose: self.poses[cell.pose].clone(),
            direction: cell.axis(),
            load: (!cell.is_along_load() && !self.is_unloaded(cell)).then(|| cell.load.called()),
        }
    }

    /// Whether a tracker saw a cell without a load.
    fn is_unloaded(&self, cell: &ObservedCell) -> bool {
        let mut loads = self.loads[cell.readings.clone()].iter();
        self.tracker.is_some() && loads.all(|load| load.force_n == 0.0)
    }

    /// The cell of a reading.
    #[must_use]
    pub fn cell_of(&self, reading: usize) -> usize {
        self.runs[self.readings[reading].run].cell
    }

    /// Pose and direction of a cell.
    pub(crate) fn name_of(&self, cell: usize) -> (PoseId, Direction) {
        let cell = &self.cells[cell];
        (self.poses[cell.pose].clone(), cell.axis())
    }

    /// Step and hold of a reading: its repeats in other runs of the cell have the same.
    pub(crate) fn load_key(&self, reading: usize) -> (u32, u32) {
        (self.loads[reading].step, self.readings[reading].hold_number)
    }

    /// Whether a run with this place may be one of a cell.
    pub(crate) fn is_cell_of(&self, place: &Place, cell: &ObservedCell) -> bool {
        matches!(place, Place::Run { pose, direction, gauge, .. }
            if self.poses[cell.pose] == *pose
                && cell.load.is_called(direction)
                && gauge.is_none_or(|axis| axis == cell.axis()))
    }

    /// For each reading whether it is meant.
    pub(crate) fn mask(&self, is_meant: impl Fn(usize) -> bool) -> Vec<bool> {
        (0..self.len()).map(is_meant).collect()
    }

    /// Number of gauge zeros, those of readings left out among them.
    pub(crate) fn zero_count(&self) -> usize {
        let zeros = self
            .readings
            .iter()
            .map(|reading| reading.zero as usize + 1);
        zeros.max().unwrap_or(0)
    }

    /// Values minus their means over their gauge zeros, where these can be told from the readings.
    pub(crate) fn about_zeros(&self, values: Vec<f64>) -> Vec<f64> {
        if !self.has_series() {
            return values;
        }
        let zeros = self.readings.iter().map(|reading| reading.zero as usize);
        about_means(values, zeros, self.zero_count())
    }

    /// Directions along which displacements were measured.
    pub(crate) fn directions(&self) -> impl Iterator<Item = Direction> + '_ {
        let is_along = |cell: &ObservedCell, axis| !cell.read.is_rotation() && cell.axis() == axis;
        let measured = move |axis: &Direction| self.cells.iter().any(|cell| is_along(cell, *axis));
        Direction::ALL.into_iter().filter(measured)
    }

    /// The same readings with where the gauge stood at each.
    #[must_use]
    pub(crate) fn with_positions(&self, position_m: &[f64]) -> Self {
        let mut out = self.clone();
        for (load, position) in out.loads.iter_mut().zip(position_m) {
            load.position_m = Some(*position);
        }
        out
    }

    /// Some of the readings: runs and cells without any are left out, poses are not.
    ///
    /// # Arguments
    /// - `keep`: one a reading.
    #[must_use]
    pub fn filtered(&self, keep: &[bool]) -> Self {
        self.of_cells(0..self.cells.len(), keep)
    }

    /// Those of one cell.
    #[must_use]
    pub(crate) fn filtered_cell(&self, cell: usize, keep: &[bool]) -> Self {
        self.of_cells(cell..cell + 1, keep)
    }

    fn of_cells(&self, cells: Range<usize>, keep: &[bool]) -> Self {
        let cells = &self.cells[cells];
        let all = cells.first().map_or(0, |cell| cell.readings.start)
            ..cells.last().map_or(0, |cell| cell.readings.end);
        let mut out = Self {
            poses: self.poses.clone(),
            gauges: self.gauges.clone(),
            release_n: self.release_n,
            free_zeros: self.free_zeros,
            sessions: self.sessions.clone(),
            object: self.object,
            response_doubt: self.response_doubt,
            clock: self.clock,
            tracker: self.tracker,
            on_path: self.on_path,
            histories: RecordedHistory::filtered(&self.histories, &all, keep),
            beginnings: self.beginnings.clone(),
            ..Self::without_readings(self.steps, self.recorded)
        };
        for session in &mut out.sessions {
            let kept = |readings: Range<usize>| {
                let own = readings.start.max(all.start)..readings.end.min(all.end);
                let keep = keep.get(own).unwrap_or_default().iter();
                keep.filter(|keep| **keep).count()
            };
            let first = kept(0..session.readings.start);
            session.readings = first..first + kept(session.readings.clone());
        }
        for cell in cells {
            let is_kept = |reading: &usize| keep[*reading];
            if cell.readings.clone().any(|reading| keep[reading]) {
                out.begin_cell(cell.pose, cell.load.clone(), cell.read);
            }
            for run in &self.runs[cell.runs.clone()] {
                let mut kept = run.readings.clone().filter(is_kept).peekable();
                if kept.peek().is_some() {
                    out.begin_run(run.repeat, run.session_run);
                    if let Some(kept) = out.runs.last_mut() {
                        kept.goes_on = run.goes_on;
                    }
                }
                for reading in kept {
                    let load = self.loads[reading];
                    out.push(self.readings[reading], load, self.displacement_m[reading]);
                }
            }
        }
        for session in &mut out.sessions {
            let of_run = |run: &ObservedRun| session.readings.contains(&run.readings.start);
            let first = out.runs.iter().position(of_run).unwrap_or(out.runs.len());
            let count = out.runs.iter().filter(|run| of_run(run)).count();
            session.runs = first..first + count;
        }
        out
    }

    /// The same readings with other displacements, for simulated noise.
    #[must_use]
    pub fn with_displacements(&self, displacement_m: Vec<f64>) -> Self {
        Self {
            displacement_m,
            ..self.clone()
        }
    }
}

impl Observations {
    /// Axes of the gauges, if several were read at once.
    pub(crate) fn gauges_read_at_once(&self) -> Vec<Direction> {
        let at_once = self.cells.windows(2).any(|pair| {
            let seq = |cell: &ObservedCell| self.readings[cell.readings.start].seq;
            pair[1].goes_on(&pair[0]) && seq(&pair[0]) == seq(&pair[1])
        });
        self.directions().filter(|_| at_once).collect()
    }

    /// Begins a cell.
    pub(crate) fn begin_cell(&mut self, pose: usize, load: LoadDirection, read: ReadAxis) {
        let (runs, readings) = (self.runs.len(), self.readings.len());
        self.cells.push(ObservedCell {
            pose,
            load,
            read,
            runs: runs..runs,
            readings: readings..readings,
        });
    }

    /// Begins a run of the last cell.
    pub(crate) fn begin_run(&mut self, repeat: u32, session_run: u32) {
        let place = self.readings.len();
        self.runs.push(ObservedRun {
            cell: self.cells.len().saturating_sub(1),
            repeat,
            session_run,
            readings: place..place,
            goes_on: false,
        });
        if let Some(cell) = self.cells.last_mut() {
            cell.runs.end = self.runs.len();
        }
    }

    /// Adds a reading to the last run.
    pub(crate) fn push(&mut self, reading: ObservedReading, load: LoadPoint, displacement_m: f64) {
        let run = self.runs.len().saturating_sub(1);
        self.readings.push(ObservedReading { run, ..reading });
        self.loads.push(load);
        self.displacement_m.push(displacement_m);
        if let (Some(cell), Some(run)) = (self.cells.last_mut(), self.runs.last_mut()) {
            cell.readings.end = self.readings.len();
            run.readings.end = self.readings.len();
        }
    }

    /// Number of readings that the last run has under a load step so far, if that is its last.
    pub(crate) fn next_hold(&self, step: u32) -> u32 {
        match (self.readings.last(), self.loads.last()) {
            (Some(last), Some(load)) if last.run + 1 == self.runs.len() && load.step == step => {
                last.hold_number + 1
            }
            _ => 0,
        }
    }

    /// Adds a reading of a table whose readings come cell by cell and run by run.
    fn push_recorded(
        &mut self,
        (pose, load): (usize, LoadDirection),
        reading: &Reading,
        since: SinceZero,
    ) {
        let same_cell = self.cells.last().is_some_and(|cell| {
            cell.pose == pose && cell.read == reading.direction && cell.load == load
        });
        if !same_cell {
            self.begin_cell(pose, load, reading.direction.into());
        }
        let run = self.runs.last().map(|run| run.session_run);
        if !same_cell || run != Some(reading.run) {
            self.begin_run(reading.repeat, reading.run);
        }
        let observed = ObservedReading {
            run: 0,
            seq: reading.seq,
            zero: reading.zero,
            branch: reading.branch,
            hold_number: self.next_hold(reading.step),
            time_s: reading.time_s,
            line: reading.line,
            target_n: reading.target_n,
            flagged: reading
                .text
                .as_ref()
                .is_some_and(|text| !text.flag.is_empty()),
        };
        self.push(observed, load_point(reading, since), reading.displacement_m);
    }
}

/// The load of a reading, as laws have it.
pub(crate) fn load_point(reading: &Reading, since: SinceZero) -> LoadPoint {
    LoadPoint {
        force_n: reading.force_n,
        step: reading.step,
        hold_s: reading.hold_s.unwrap_or(0.0),
        since_zero_s: since.time_s.unwrap_or(0.0),
        warming_k: since.warming_k.unwrap_or(0.0),
        is_unloaded: reading.target_n == 0.0,
        ..LoadPoint::default()
    }
}

/// Values without the means of the groups that they are in.
///
/// # Arguments
/// - `groups`: the number of each value's group.
pub(crate) fn about_means(
    mut values: Vec<f64>,
    groups: impl Iterator<Item = usize> + Clone,
    count: usize,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); count];
    for (value, group) in values.iter().zip(groups.clone()) {
        sums[group].0 += value;
        sums[group].1 += 1.0;
    }
    for (value, group) in values.iter_mut().zip(groups) {
        *value -= sums[group].0 / sums[group].1;
    }
    values
}
