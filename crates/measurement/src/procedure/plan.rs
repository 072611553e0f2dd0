//! The checked plan, its defaults, and its way to and from a session's header.

use crate::readings::{
    LoadOrder, PoseJoints, ProcedureRecord, ReadingLimits, RepeatOrder, SettleRecord, ZeroScope,
};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::problem::ProcedureProblem;

/// Most readings that a procedure may plan for one pose and direction; at a reading every ten seconds, eleven days.
pub(super) const MOST_READINGS_OF_A_CELL: u64 = 100_000;

/// A load plan with everything decided.
///
/// The fields may be changed; whatever follows a procedure checks it again with [`Procedure::check`].
#[derive(Debug, Clone, PartialEq)]
pub struct Procedure {
    /// Its name.
    pub name: String,
    /// What it does, in words.
    pub text: Option<String>,
    /// Poses, in the order of measurement; `None` stands for every named pose of the robot.
    pub poses: Option<Vec<PoseId>>,
    /// The specimens that may be measured; empty for any.
    pub specimens: Vec<String>,
    /// Joint values of poses: of those that the robot file does not have and, in sessions whose displacements are vectors, of all.
    pub joint_values: Vec<PoseJoints>,
    /// Directions of the loads, in the order of measurement.
    pub directions: Vec<LoadDirection>,
    /// Base axes along which displacement gauges stand, in the order x, y, z; empty for one gauge along the load.
    pub displacement_axes: Vec<Direction>,
    /// Target loads, N, signed, in the order of loading.
    pub loads_n: Vec<f64>,
    /// Whether the loads are taken off in the same steps.
    pub unloading: bool,
    /// Applications of the sequence, or of each load.
    pub repeats: u32,
    /// How repeats and loads are nested.
    pub repeat_order: RepeatOrder,
    /// Whether the loads come as listed or shuffled.
    pub load_order: LoadOrder,
    /// Seed of a shuffled order.
    pub seed: u64,
    /// How long a gauge zero lasts.
    pub zero: ZeroScope,
    /// Contact force before zeroing, N, signed.
    pub preload_n: f64,
    /// Times of extra readings at the largest load, s under that load, growing.
    pub holds_s: Vec<f64>,
    /// When a load counts as settled.
    pub settle: Settle,
    /// What a reading may be.
    pub limits: ReadingLimits,
    /// How long each question of a session may stay open, s, by its name; the others wait without limit.
    pub answer_within_s: Vec<(String, f64)>,
}

/// When a load counts as settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settle {
    /// Largest difference of force and target, N.
    pub force_tolerance_n: f64,
    /// How long the gauges are watched, s.
    pub dwell_s: f64,
    /// Largest spread of the displacement meanwhile, m.
    pub spread_m: f64,
    /// Largest slope of the displacement meanwhile, m/s.
    pub slope_m_per_s: f64,
}

impl Default for Settle {
    /// What a hand jack and a dial gauge that shows micrometres reach: 0.5 N, and for 2 s no more than 2 µm apart and 0.5 µm/s.
    fn default() -> Self {
        Self {
            force_tolerance_n: 0.5,
            dwell_s: 2.0,
            spread_m: 2e-6,
            slope_m_per_s: 0.5e-6,
        }
    }
}

impl Default for Procedure {
    /// The procedure of a file with the key `schema` only: five sweeps of 0, -10, … -70 N in x, y, z, zeroed before each run.
    fn default() -> Self {
        Self {
            name: "unnamed".to_owned(),
            text: None,
            poses: None,
            specimens: Vec::new(),
            joint_values: Vec::new(),
            directions: LoadDirection::axes(),
            displacement_axes: Vec::new(),
            // The paper's loads and repeats (IV-C, steps 4 and 5).
            loads_n: (0..8).map(|step| -10.0 * f64::from(step)).collect(),
            unloading: false,
            repeats: 5,
            repeat_order: RepeatOrder::Sweep,
            load_order: LoadOrder::Ascending,
            seed: 0,
            zero: ZeroScope::Run,
            preload_n: -1.0,
            holds_s: Vec::new(),
            settle: Settle::default(),
            limits: ReadingLimits::default(),
            answer_within_s: Vec::new(),
        }
    }
}

/// Longest time of a procedure, s: a week.
const LONGEST_S: f64 = 7.0 * 24.0 * 3600.0;

impl Procedure {
    /// The plan behind a record; missing keys take their defaults.
    ///
    /// Two defaults depend on other keys: the gauge zero lasts for the cell if each load is repeated before the next, else for the run, and
    /// the preload is 1 N in the sense of the first load.
    ///
    /// # Errors
    /// [`ProcedureProblem`] if the record cannot be followed.
    pub fn from_record(record: &ProcedureRecord) -> Result<Self, ProcedureProblem> {
        let default = Self::default();
        let loads_n = listed(&record.loads_n, default.loads_n);
        if !record.branches.is_empty() && !record.branches.contains(&Branch::Loading) {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::no_loading",
                "branches",
                "`branches` has no \"loading\"",
                "write branches = [\"loading\"] or [\"loading\", \"unloading\"]",
            ));
        }
        let repeat_order = record.repeat_order.unwrap_or(default.repeat_order);
        let procedure = Self {
            name: record.name.clone().unwrap_or(default.name),
            text: record.text.clone(),
            poses: (!record.poses.is_empty()).then(|| record.poses.clone()),
            specimens: record.specimens.clone(),
            joint_values: record.joint_values.clone(),
            directions: listed(&record.directions, default.directions),
            displacement_axes: {
                let mut axes = record.displacement_axes.clone();
                axes.sort_unstable();
                axes
            },
            unloading: record.branches.contains(&Branch::Unloading),
            repeats: record.repeats.unwrap_or(default.repeats),
            repeat_order,
            load_order: record.load_order.unwrap_or(default.load_order),
            seed: record.seed.unwrap_or(default.seed),
            zero: record.zero.unwrap_or(match repeat_order {
                RepeatOrder::AtLoad => ZeroScope::Cell,
                RepeatOrder::Sweep => ZeroScope::Run,
            }),
            preload_n: record
                .preload_n
                .unwrap_or_else(|| toward(&loads_n, default.preload_n)),
            holds_s: record.holds_s.clone(),
            settle: Settle::from_record(&record.settle),
            limits: record.limits,
            answer_within_s: record.answer_within_s.clone(),
            loads_n,
        };
        procedure.check()?;
        Ok(procedure)
    }

    /// The record that a session's header keeps; [`Procedure::from_record`] gives the same plan back.
    #[must_use]
    pub fn to_record(&self) -> ProcedureRecord {
        let mut branches = vec![Branch::Loading];
        if self.unloading {
            branches.push(Branch::Unloading);
        }
        ProcedureRecord {
            name: Some(self.name.clone()),
            text: self.text.clone(),
            poses: self.poses.clone().unwrap_or_default(),
            specimens: self.specimens.clone(),
            joint_values: self.joint_values.clone(),
            directions: self.directions.clone(),
            displacement_axes: self.displacement_axes.clone(),
            loads_n: self.loads_n.clone(),
            branches,
            repeats: Some(self.repeats),
            repeat_order: Some(self.repeat_order),
            load_order: Some(self.load_order),
            seed: Some(self.seed),
            zero: Some(self.zero),
            preload_n: Some(self.preload_n),
            holds_s: self.holds_s.clone(),
            settle: SettleRecord {
                force_tolerance_n: Some(self.settle.force_tolerance_n),
                dwell_s: Some(self.settle.dwell_s),
                spread_m: Some(self.settle.spread_m),
                slope_m_per_s: Some(self.settle.slope_m_per_s),
            },
            limits: self.limits,
            answer_within_s: self.answer_within_s.clone(),
        }
    }

    /// The same plan with other loads; the preload turns to press in their sense.
    #[must_use]
    pub fn with_loads(self, loads_n: Vec<f64>) -> Self {
        Self {
            preload_n: toward(&loads_n, self.preload_n),
            loads_n,
            ..self
        }
    }

    /// The force to which each load is released before the next, N; `None` where the loads follow each other.
    #[must_use]
    pub fn release_n(&self) -> Option<f64> {
        (self.repeat_order == RepeatOrder::AtLoad).then_some(self.preload_n)
    }

    /// The base axes along which displacements are read under a load: those of the gauges that stay, else the axis of the load.
    #[must_use]
    pub fn axes_read_under(&self, load: &LoadDirection) -> Vec<Direction> {
        if self.displacement_axes.is_empty() {
            load.axis().into_iter().collect()
        } else {
            self.displacement_axes.clone()
        }
    }

    /// Checks that one displacement gauge can stand along every load, where none stays along a base axis.
    ///
    /// # Errors
    /// [`ProcedureProblem`] for a load against or across the axes.
    pub fn check_directions(&self) -> Result<(), ProcedureProblem> {
        if self.displacement_axes.is_empty() {
            self.load_axes()?;
        }
        Ok(())
    }

    /// The base axes of the loads, for a bench with one displacement gauge that stands along the load.
    ///
    /// # Errors
    /// [`ProcedureProblem`] for a load against or across the axes, and for gauges that stay.
    pub fn load_axes(&self) -> Result<Vec<Direction>, ProcedureProblem> {
        if !self.displacement_axes.is_empty() {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::gauges_along_axes",
                "displacement_axes",
                "`displacement_axes` asks for displacement gauges along base axes, which only guided and simulated sessions have",
                "take a procedure without displacement_axes here",
            ));
        }
        let axis = |direction: &LoadDirection| {
            direction.axis().ok_or_else(|| {
                ProcedureProblem::new(
                    "stiffbench::procedure::oblique",
                    "directions",
                    format!(
                        "`directions` has {direction}, and with one displacement gauge loads go along x, y or z"
                    ),
                    "read displacements along base axes: displacement_axes = [\"x\", \"y\", \"z\"] in the procedure, or --displacement-axes x,y,z of `session run` and `simulate`",
                )
            })
        };
        self.directions.iter().map(axis).collect()
    }

    /// Checks that the plan can be followed.
    ///
    /// # Errors
    /// The first [`ProcedureProblem`] there is.
    pub fn check(&self) -> Result<(), ProcedureProblem> {
        self.check_lists()?;
        self.check_orders()?;
        self.check_numbers()?;
        let readings = self.readings_of_a_cell();
        if readings > MOST_READINGS_OF_A_CELL {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::too_long",
                "repeats",
                format!(
                    "{readings} readings in one pose and direction, more than {MOST_READINGS_OF_A_CELL}"
                ),
                "lower `repeats`, or list fewer loads or holds",
            ));
        }
        Ok(())
    }

    fn check_lists(&self) -> Result<(), ProcedureProblem> {
        let poses = self.poses.as_deref();
        for (key, empty) in [
            ("poses", poses.is_some_and(<[_]>::is_empty)),
            ("directions", self.directions.is_empty()),
            ("loads", self.loads_n.is_empty()),
        ] {
            if empty {
                return Err(ProcedureProblem::empty(key));
            }
        }
        once("poses", poses.unwrap_or_default(), PoseId::clone)?;
        once("directions", &self.directions, LoadDirection::unit_vector)?;
        once("specimens", &self.specimens, String::clone)?;
        once(
            "displacement_axes",
            &self.displacement_axes,
            Direction::clone,
        )?;
        // Readings of one name count as those of one pose and direction.
        once("directions", &self.directions, ToString::to_string)?;
        if self.repeats == 0 {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::no_repeat",
                "repeats",
                "`repeats` is 0",
                "give at least 1; from 2 on the scatter between runs can be estimated",
            ));
        }
        Ok(())
    }

    fn check_orders(&self) -> Result<(), ProcedureProblem> {
        let at_load = self.repeat_order == RepeatOrder::AtLoad;
        if at_load && self.zero == ZeroScope::Run {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::zero_at_load",
                "zero",
                "`zero` is \"run\", but with repeat_order \"at-load\" the runs take turns at every load",
                "take zero = \"cell\", or repeat_order = \"sweep\"",
            ));
        }
        if self.unloading && at_load {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::unloading_at_load",
                "branches",
                "`branches` has \"unloading\", but with repeat_order \"at-load\" each load is released before the next",
                "take repeat_order = \"sweep\", or leave \"unloading\" out",
            ));
        }
        if self.unloading && self.load_order == LoadOrder::Shuffled {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::unloading_shuffled",
                "branches",
                "`branches` has \"unloading\", but a shuffled order goes up and down anyway",
                "take load_order = \"ascending\", or leave \"unloading\" out",
            ));
        }
        Ok(())
    }

    fn check_numbers(&self) -> Result<(), ProcedureProblem> {
        let time = |key, value: f64| match value {
            value if value > LONGEST_S => Err(ProcedureProblem::new(
                "stiffbench::procedure::too_late",
                key,
                format!("`{key}` is {value} s, more than a week"),
                "a time is in seconds",
            )),
            value => finite(key, value),
        };
        for &load_n in &self.loads_n {
            finite("loads", load_n)?;
        }
        finite("preload", self.preload_n)?;
        if self.loads_n.iter().all(|&load_n| load_n == 0.0) {
            return Err(ProcedureProblem::new(
                "stiffbench::procedure::only_zero",
                "loads",
                "`loads` are all zero",
                "list at least one load other than 0, in N, for example -50",
            ));
        }
        let mut after_s = 0.0;
        for &hold_s in &self.holds_s {
            time("holds", hold_s)?;
            if hold_s <= after_s {
                return Err(ProcedureProblem::new(
                    "stiffbench::procedure::holds",
                    "holds",
                    format!("`holds` has {hold_s} s behind {after_s} s"),
                    "holds count from the time the load was reached: list increasing times above zero, for example [60, 120]",
                ));
            }
            after_s = hold_s;
        }
        for (_, time_s) in &self.answer_within_s {
            time("answer_within", *time_s)?;
            if *time_s <= 0.0 {
                return Err(ProcedureProblem::negative("answer_within", *time_s));
            }
        }
        self.limits.check()?;
        let settle = &self.settle;
        time("settle.dwell", settle.dwell_s)?;
        for (key, value) in [
            ("settle.force_tolerance", settle.force_tolerance_n),
            ("settle.dwell", settle.dwell_s),
            ("settle.spread", settle.spread_m),
            ("settle.slope", settle.slope_m_per_s),
        ] {
            size(key, value)?;
        }
        Ok(())
    }
}

impl Settle {
    /// What the record of a session leaves open is as usual.
    #[must_use]
    pub fn from_record(record: &SettleRecord) -> Self {
        let default = Self::default();
        Self {
            force_tolerance_n: record
                .force_tolerance_n
                .unwrap_or(default.force_tolerance_n),
            dwell_s: record.dwell_s.unwrap_or(default.dwell_s),
            spread_m: record.spread_m.unwrap_or(default.spread_m),
            slope_m_per_s: record.slope_m_per_s.unwrap_or(default.slope_m_per_s),
        }
    }
}

/// A preload of the same size in the sense of the first load that is not zero.
fn toward(loads_n: &[f64], preload_n: f64) -> f64 {
    let first = loads_n.iter().find(|&&load_n| load_n != 0.0);
    first.map_or(preload_n, |&load_n| preload_n.abs().copysign(load_n))
}

/// A list, or what stands for one that is empty.
fn listed<T: Clone>(list: &[T], default: Vec<T>) -> Vec<T> {
    if list.is_empty() {
        return default;
    }
    list.to_vec()
}

/// Refuses what is no finite number.
fn finite(key: &'static str, value: f64) -> Result<(), ProcedureProblem> {
    if value.is_finite() {
        return Ok(());
    }
    Err(ProcedureProblem::new(
        "stiffbench::procedure::not_finite",
        key,
        format!("`{key}` is {value}: a finite number is needed"),
        "loads are finite numbers of newtons, times of seconds",
    ))
}

/// Refuses what is no finite number of at least zero.
pub(super) fn size(key: &'static str, value: f64) -> Result<(), ProcedureProblem> {
    finite(key, value)?;
    if value < 0.0 {
        return Err(ProcedureProblem::negative(key, value));
    }
    Ok(())
}

/// Refuses a list with a member that is as another before it.
fn once<T: ToString, K: PartialEq>(
    key: &'static str,
    list: &[T],
    of: impl Fn(&T) -> K,
) -> Result<(), ProcedureProblem> {
    let keys: Vec<K> = list.iter().map(of).collect();
    match (0..keys.len()).find(|&place| keys[..place].contains(&keys[place])) {
        None => Ok(()),
        Some(place) => Err(ProcedureProblem::new(
            "stiffbench::procedure::twice",
            key,
            format!("`{key}` lists {} twice", list[place].to_string()),
            "take one of them out: the readings of both would be those of one pose and direction; for more readings raise `repeats`",
        )),
    }
}
