//! What a session was: the header file `session.toml`, schemas `stiffbench/session/1` and `stiffbench/session/2`.

use std::fmt::{self, Display};

use jiff::civil::Date;
use miette::Diagnostic;
use thiserror::Error;

use super::joint_values::PoseJoints;
use super::toml_values::Word;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::source_text::PlacedError;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};
use stiffbench_units_and_text::toml_text::{TomlProblem, UnknownKey};

/// The schema of sessions with one displacement gauge, along the load.
pub const SESSION_SCHEMA: &str = "stiffbench/session/1";

/// The schema of sessions whose forces and displacements are vectors, and the newest that is read.
pub const LOAD_CASE_SESSION_SCHEMA: &str = "stiffbench/session/2";

/// Known properties of a session besides its readings. Everything may be absent: readers accept short files and list what is missing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SessionHeader {
    /// Session id.
    pub id: Option<String>,
    /// Robot file or shipped robot; a path is relative to the session folder.
    pub robot: Option<String>,
    /// SHA-256 of the robot file when the session was made, in hexadecimal.
    pub robot_sha256: Option<String>,
    /// Mechanism of the robot.
    pub mechanism: Option<String>,
    /// Set of fitting factors the analysis starts from.
    pub factors: Option<String>,
    /// How the readings came about if they were not measured: simulated or emulated, with what acted.
    pub origin: Option<String>,
    /// Who measured.
    pub operator: Option<String>,
    /// Which specimen was measured, where several are alike.
    pub specimen: Option<String>,
    /// Where.
    pub place: Option<String>,
    /// Under which conditions.
    pub environment: Option<Environment>,
    /// Program and version that made the session.
    pub software: Option<String>,
    /// The procedure that was followed.
    pub procedure: Option<ProcedureRecord>,
    /// The gauges.
    pub instruments: Instruments,
    /// The file that the readings were imported from, where they were not measured by a guided session.
    pub import: Option<ImportRecord>,
}

/// Where imported readings come from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ImportRecord {
    /// Name of the file, as it lies in the folder `raw` of the session.
    pub source: Option<String>,
    /// Its SHA-256, in hexadecimal.
    pub source_sha256: Option<String>,
    /// SHA-256 of the mapping of its columns, in hexadecimal.
    pub mapping_sha256: Option<String>,
}

impl SessionHeader {
    /// Whether its forces and displacements are vectors along the base axes.
    #[must_use]
    pub fn is_of_vectors(&self) -> bool {
        let procedure = self.procedure.as_ref();
        procedure.is_some_and(|procedure| !procedure.displacement_axes.is_empty())
    }

    /// The force to which each load was released before the next, N; `None` where the loads followed each other or nothing is known.
    #[must_use]
    pub fn release_n(&self) -> Option<f64> {
        let procedure = self.procedure.as_ref()?;
        let at_load = procedure.repeat_order == Some(RepeatOrder::AtLoad);
        at_load.then(|| procedure.preload_n.unwrap_or(0.0))
    }
}

/// The surroundings of a session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Environment {
    /// Temperature at the start, °C.
    pub temperature_deg_c: Option<f64>,
    /// Relative humidity, percent.
    pub humidity_percent: Option<f64>,
    /// Anything else.
    pub text: Option<String>,
}

/// The gauges of a bench.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instruments {
    /// The force gauge; its quantities are in N.
    pub force: Option<InstrumentRecord>,
    /// The dial gauge; its quantities are in m.
    pub displacement: Option<InstrumentRecord>,
    /// The dial gauges along the base axes x, y, z, where a bench has those; their quantities are in m.
    pub displacement_along: [Option<InstrumentRecord>; 3],
}

impl Instruments {
    /// Every record with what it is called, force first.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &InstrumentRecord)> {
        let [x, y, z] = &self.displacement_along;
        let all = [
            ("force gauge", &self.force),
            ("displacement gauge", &self.displacement),
            ("displacement gauge along x", x),
            ("displacement gauge along y", y),
            ("displacement gauge along z", z),
        ];
        all.into_iter()
            .filter_map(|(name, record)| Some((name, record.as_ref()?)))
    }

    /// The gauges whose calibration had run out on a day.
    #[must_use]
    pub fn overdue(&self, on: Date) -> Vec<OverdueGauge> {
        let overdue = self.named().filter_map(|(gauge, record)| {
            let due = record.due.filter(|due| on > *due)?;
            Some(OverdueGauge { gauge, due })
        });
        overdue.collect()
    }
}

/// A gauge whose calibration had run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OverdueGauge {
    /// What it is called: `force gauge`.
    pub gauge: &'static str,
    /// Last day on which its calibration counted.
    pub due: Date,
}

impl fmt::Display for OverdueGauge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (due {})", self.gauge, self.due)
    }
}

/// Known properties of a gauge. Quantities are in N for a force gauge and in m for a dial gauge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InstrumentRecord {
    /// The gauge, as the user names it; without that the name of its description.
    pub model: Option<String>,
    /// Name of its description, where a session read it.
    pub description: Option<String>,
    /// Serial number.
    pub serial: Option<String>,
    /// Largest reading, N or m.
    pub range: Option<f64>,
    /// Smallest step of its display, N or m.
    pub resolution: Option<f64>,
    /// Expanded uncertainty U of its certificate, common to all its readings, N or m.
    pub expanded_uncertainty: Option<f64>,
    /// Coverage factor k of that uncertainty.
    pub k: Option<f64>,
    /// Largest difference between its readings of one value while that grows and while it falls, N or m: the reversibility of ISO 376, the
    /// hysteresis of ISO 463.
    pub reversibility: Option<f64>,
    /// Number of the certificate.
    pub certificate: Option<String>,
    /// Day of the calibration.
    pub calibrated: Option<Date>,
    /// Last day on which the calibration counts.
    pub due: Option<Date>,
}

impl InstrumentRecord {
    /// The name of its description; sessions of before wrote it as the model.
    #[must_use]
    pub fn description_name(&self) -> Option<&str> {
        self.description.as_deref().or(self.model.as_deref())
    }

    /// Standard uncertainty u = U/k of the certificate, N or m; `None` if U or k is not known or k is not positive.
    #[must_use]
    pub fn standard_uncertainty(&self) -> Option<f64> {
        let k = self.k.filter(|k| *k > 0.0)?;
        Some(self.expanded_uncertainty? / k)
    }
}

/// The procedure a session followed, as frozen in its header.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProcedureRecord {
    /// Its name.
    pub name: Option<String>,
    /// What it does, in words.
    pub text: Option<String>,
    /// Poses, in the order of measurement.
    pub poses: Vec<PoseId>,
    /// The specimens that may be measured; empty for any.
    pub specimens: Vec<String>,
    /// Joint values of poses, of those that the robot file does not have and, in sessions whose displacements are vectors, of all.
    pub joint_values: Vec<PoseJoints>,
    /// Directions of the loads, in the order of measurement.
    pub directions: Vec<LoadDirection>,
    /// Base axes along which displacement gauges stand; empty for one gauge along the load.
    pub displacement_axes: Vec<Direction>,
    /// Target loads, N, signed.
    pub loads_n: Vec<f64>,
    /// Branches measured.
    pub branches: Vec<Branch>,
    /// Repeats of each load or of the sequence.
    pub repeats: Option<u32>,
    /// How repeats and loads are nested.
    pub repeat_order: Option<RepeatOrder>,
    /// In which order the loads come.
    pub load_order: Option<LoadOrder>,
    /// Seed of a shuffled order.
    pub seed: Option<u64>,
    /// When the gauge is zeroed.
    pub zero: Option<ZeroScope>,
    /// Contact force before zeroing, N, signed.
    pub preload_n: Option<f64>,
    /// Times of extra readings at the largest load, s.
    pub holds_s: Vec<f64>,
    /// When a load counts as settled.
    pub settle: SettleRecord,
    /// What a reading may be.
    pub limits: ReadingLimits,
    /// How long each question may stay open, s, by its name; the others wait without limit.
    pub answer_within_s: Vec<(String, f64)>,
}

/// What a reading may be in size; what is absent has no limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadingLimits {
    /// Force beyond which a reading is flagged, N.
    pub force_warn_n: Option<f64>,
    /// Force beyond which a reading is asked about, N.
    pub force_hard_n: Option<f64>,
    /// Displacement beyond which a reading is flagged, m.
    pub displacement_warn_m: Option<f64>,
    /// Displacement beyond which a reading is asked about, m.
    pub displacement_hard_m: Option<f64>,
}

/// When a load counts as settled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SettleRecord {
    /// Largest difference of force and target, N.
    pub force_tolerance_n: Option<f64>,
    /// How long the gauges are watched, s.
    pub dwell_s: Option<f64>,
    /// Largest spread of the displacement meanwhile, m.
    pub spread_m: Option<f64>,
    /// Largest slope of the displacement meanwhile, m/s.
    pub slope_m_per_s: Option<f64>,
}

/// How repeats and loads are nested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RepeatOrder {
    /// Each load is applied `repeats` times, released to the preload in between, then the next load (the paper, IV-C).
    AtLoad,
    /// The whole sequence is repeated.
    Sweep,
}

/// In which order the loads come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadOrder {
    /// As listed.
    Ascending,
    /// Shuffled with a seed.
    Shuffled,
}

/// When the gauge is zeroed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZeroScope {
    /// Once per pose and direction (the paper).
    Cell,
    /// Before each run.
    Run,
}

impl Word for RepeatOrder {
    const WORDS: &'static [(&'static str, Self)] =
        &[("at-load", Self::AtLoad), ("sweep", Self::Sweep)];
    const EXPECTED: &'static str = "\"at-load\" or \"sweep\"";
}

impl Word for LoadOrder {
    const WORDS: &'static [(&'static str, Self)] =
        &[("ascending", Self::Ascending), ("shuffled", Self::Shuffled)];
    const EXPECTED: &'static str = "\"ascending\" or \"shuffled\"";
}

impl Word for ZeroScope {
    const WORDS: &'static [(&'static str, Self)] = &[("cell", Self::Cell), ("run", Self::Run)];
    const EXPECTED: &'static str = "\"cell\" or \"run\"";
}

impl Word for Direction {
    const WORDS: &'static [(&'static str, Self)] =
        &[("x", Self::X), ("y", Self::Y), ("z", Self::Z)];
    const EXPECTED: &'static str = "\"x\", \"y\" or \"z\"";
}

impl Word for Branch {
    const WORDS: &'static [(&'static str, Self)] =
        &[("loading", Self::Loading), ("unloading", Self::Unloading)];
    const EXPECTED: &'static str = "\"loading\" or \"unloading\"";
}

/// A header as read, with the keys that were not understood.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadSession {
    /// The header.
    pub header: SessionHeader,
    /// Keys that were passed over, in the order of the file.
    pub unknown_keys: Vec<UnknownKey>,
}

/// Why a `session.toml` could not be read; shows the place in the file.
pub type SessionFileError = PlacedError<SessionFileProblem>;

/// What is wrong with a `session.toml`.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(transparent)]
pub struct SessionFileProblem(#[from] pub TomlProblem);

impl Diagnostic for SessionFileProblem {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        let word = self.0.word();
        Some(Box::new(format!("stiffbench::session_file::{word}")))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.0.help()
    }
}
