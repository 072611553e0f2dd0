//! Readings laid out for the search: cells, runs and gauge zeros as ranges of plain arrays.

use std::ops::Range;

use stiffbench_beams::physics::{LoadPoint, RunLoads, TestObject};
use stiffbench_measurement::readings::{Reading, ReadingTable, SessionHeader, SinceZero};
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::joined_sessions::ObservedSession;
use super::recorded_history::RecordedHistory;

/// A pose and direction with its readings.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedCell {
    /// Index of the pose among the observed poses.
    pub pose: usize,
    /// The direction.
    pub direction: Direction,
    /// Its runs.
    pub runs: Range<usize>,
    /// Its readings.
    pub readings: Range<usize>,
}

/// Readings with one virgin history.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservedRun {
    /// Index of its cell.
    pub cell: usize,
    /// Its repeat.
    pub repeat: u32,
    /// Its readings, in the order in which they were made.
    pub readings: Range<usize>,
}

/// What the search needs to know of a reading, besides force and displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservedReading {
    /// Index of its run.
    pub run: usize,
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
    /// Step of the force gauge, N.
    pub force_n: Option<f64>,
    /// Step of the displacement gauge, m.
    pub displacement_m: Option<f64>,
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
    pub bench: TestObject,
    /// What tells when a reading was taken.
    pub clock: ReadingClock,
    /// What parts without a robot file went through, each from its virgin state on.
    pub histories: Vec<RecordedHistory>,
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
        rows.sort_by_key(|(pose, reading, _)| (*pose, reading.direction.index(), reading.run));
        let instruments = header.map(|header| &header.instruments);
        let mut layout = GrowingArrays::default();
        for (pose, reading, since) in rows {
            layout.push(pose, reading, since);
        }
        let any = |known: fn(&Reading) -> bool| table.accepted().any(known);
        let recorded = Recorded {
            time: any(|reading| reading.time_s.is_some()),
            hold: any(|reading| reading.hold_s.is_some()),
            temperature: any(|reading| reading.temperature_deg_c.is_some()),
        };
        let step = |record: Option<&stiffbench_measurement::readings::InstrumentRecord>| {
            record.and_then(|record| record.resolution)
        };
        let steps = GaugeSteps {
            force_n: step(instruments.and_then(|i| i.force.as_ref())),
            displacement_m: step(instruments.and_then(|i| i.displacement.as_ref())),
        };
        let mut observations = Self {
            poses,
            cells: layout.cells,
            runs: layout.runs,
            readings: layout.readings,
            loads: layout.loads,
            displacement_m: layout.displacement_m,
            release_n: header.and_then(SessionHeader::release_n),
            ..Self::without_readings(steps, recorded)
        };
        observations.unloaded_shift_m = observations.count_from_unloaded();
        observations
    }

    /// No reading yet, of a robot whose gauges are zeroed.
    pub(super) fn without_readings(steps: GaugeSteps, recorded: Recorded) -> Self {
        Self {
            poses: Vec::new(),
            cells: Vec::new(),
            runs: Vec::new(),
            readings: Vec::new(),
            loads: Vec::new(),
            displacement_m: Vec::new(),
            steps,
            release_n: None,
            recorded,
            free_zeros: false,
            sessions: Vec::new(),
            unloaded_shift_m: None,
            bench: TestObject::Robot,
            clock: ReadingClock::Times,
            histories: Vec::new(),
        }
    }

    /// Number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether there is no reading.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// The loads of run number `run`, for the laws.
    #[must_use]
    pub fn run_loads(&self, run: usize) -> RunLoads<'_> {
        let ObservedRun {
            cell,
            repeat,
            readings,
        } = &self.runs[run];
        let cell = &self.cells[*cell];
        RunLoads {
            pose: &self.poses[cell.pose],
            direction: cell.direction,
            repeat: *repeat,
            release_n: self.release_of(run),
            loads: &self.loads[readings.clone()],
        }
    }

    /// The cell of a reading.
    #[must_use]
    pub fn cell_of(&self, reading: usize) -> usize {
        self.runs[self.readings[reading].run].cell
    }

    /// The same readings with where the gauge stood at each.
    #[must_use]
    pub(super) fn with_positions(&self, position_m: &[f64]) -> Self {
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
    pub(super) fn filtered_cell(&self, cell: usize, keep: &[bool]) -> Self {
        self.of_cells(cell..cell + 1, keep)
    }

    fn of_cells(&self, cells: Range<usize>, keep: &[bool]) -> Self {
        let cells = &self.cells[cells];
        let all = cells.first().map_or(0, |cell| cell.readings.start)
            ..cells.last().map_or(0, |cell| cell.readings.end);
        let mut out = Self {
            poses: self.poses.clone(),
            release_n: self.release_n,
            free_zeros: self.free_zeros,
            sessions: self.sessions.clone(),
            bench: self.bench,
            clock: self.clock,
            histories: RecordedHistory::filtered(&self.histories, &all, keep),
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
            let (first_run, first) = (out.runs.len(), out.readings.len());
            for run in &self.runs[cell.runs.clone()] {
                let start = out.readings.len();
                for reading in run.readings.clone().filter(|&reading| keep[reading]) {
                    out.readings.push(ObservedReading {
                        run: out.runs.len(),
                        ..self.readings[reading]
                    });
                    out.loads.push(self.loads[reading]);
                    out.displacement_m.push(self.displacement_m[reading]);
                }
                if out.readings.len() > start {
                    out.runs.push(ObservedRun {
                        cell: out.cells.len(),
                        repeat: run.repeat,
                        readings: start..out.readings.len(),
                    });
                }
            }
            if out.readings.len() > first {
                out.cells.push(ObservedCell {
                    runs: first_run..out.runs.len(),
                    readings: first..out.readings.len(),
                    ..cell.clone()
                });
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

/// Arrays as they grow.
#[derive(Debug, Default)]
struct GrowingArrays {
    cells: Vec<ObservedCell>,
    runs: Vec<ObservedRun>,
    readings: Vec<ObservedReading>,
    loads: Vec<LoadPoint>,
    displacement_m: Vec<f64>,
    table_run: Option<u32>,
}

impl GrowingArrays {
    fn push(&mut self, pose: usize, reading: &Reading, since: SinceZero) {
        let place = self.readings.len();
        let same_cell = self
            .cells
            .last()
            .is_some_and(|cell| cell.pose == pose && cell.direction == reading.direction);
        if !same_cell {
            let runs = self.runs.len();
            self.cells.push(ObservedCell {
                pose,
                direction: reading.direction,
                runs: runs..runs,
                readings: place..place,
            });
            self.table_run = None;
        }
        if self.table_run != Some(reading.run) {
            self.table_run = Some(reading.run);
            self.runs.push(ObservedRun {
                cell: self.cells.len() - 1,
                repeat: reading.repeat,
                readings: place..place,
            });
        }
        let run = self.runs.len() - 1;
        let hold_number = match (self.readings.last(), self.loads.last()) {
            (Some(last), Some(load)) if last.run == run && load.step == reading.step => {
                last.hold_number + 1
            }
            _ => 0,
        };
        self.readings.push(ObservedReading {
            run,
            zero: reading.zero,
            branch: reading.branch,
            hold_number,
            time_s: reading.time_s,
            line: reading.line,
            target_n: reading.target_n,
            flagged: reading
                .text
                .as_ref()
                .is_some_and(|text| !text.flag.is_empty()),
        });
        self.loads.push(LoadPoint {
            force_n: reading.force_n,
            step: reading.step,
            hold_s: reading.hold_s.unwrap_or(0.0),
            since_zero_s: since.time_s.unwrap_or(0.0),
            warming_k: since.warming_k.unwrap_or(0.0),
            position_m: None,
            is_unloaded: reading.target_n == 0.0,
        });
        self.displacement_m.push(reading.displacement_m);
        self.runs[run].readings.end = place + 1;
        if let Some(cell) = self.cells.last_mut() {
            cell.runs.end = self.runs.len();
            cell.readings.end = place + 1;
        }
    }
}
