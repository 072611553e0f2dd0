//! What can be wrong with a procedure.

use miette::Diagnostic;
use thiserror::Error;

use stiffbench_units_and_text::source_text::PlacedError;
use stiffbench_units_and_text::toml_text::TomlProblem;

/// Why a procedure file cannot be followed; shows the place in the file.
pub type ProcedureError = PlacedError<ProcedureProblem>;

/// Why a plan cannot be followed.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
pub enum ProcedureProblem {
    /// Not TOML, not a procedure, or a value or unit of the wrong kind.
    #[error("{problem}")]
    #[diagnostic(code(stiffbench::procedure::file), help("{help}"))]
    File {
        /// What is wrong.
        problem: TomlProblem,
        /// What to do about it.
        help: String,
    },
    /// A list with nothing in it.
    #[error("`{key}` lists nothing")]
    #[diagnostic(
        code(stiffbench::procedure::empty_list),
        help(
            "list at least one, or leave the key out: that takes every pose of the robot, the directions x, y, z, loads to -70 N, loading"
        )
    )]
    Empty {
        /// The key, without its unit.
        key: &'static str,
    },
    /// A pose or direction that stands in its list twice.
    #[error("`{key}` lists {name} twice")]
    #[diagnostic(
        code(stiffbench::procedure::twice),
        help(
            "take one of them out: the readings of both would be those of one pose and direction; for more readings raise `repeats`"
        )
    )]
    Twice {
        /// The key.
        key: &'static str,
        /// The member.
        name: String,
    },
    /// A load that is not along a positive base axis, where one displacement gauge stands along the load.
    #[error(
        "`directions` has {direction}, and with one displacement gauge loads go along x, y or z"
    )]
    #[diagnostic(
        code(stiffbench::procedure::oblique),
        help(
            "read displacements along base axes: displacement_axes = [\"x\", \"y\", \"z\"] in the procedure, or --displacement-axes x,y,z of `session run` and `simulate`"
        )
    )]
    NotAlongAxes {
        /// The direction.
        direction: String,
    },
    /// Gauges that stay along base axes, where only one along the load is known.
    #[error(
        "`displacement_axes` asks for displacement gauges along base axes, which only guided and simulated sessions have"
    )]
    #[diagnostic(
        code(stiffbench::procedure::gauges_along_axes),
        help("take a procedure without displacement_axes here")
    )]
    GaugesAlongAxes,
    /// No repeat.
    #[error("`repeats` is 0")]
    #[diagnostic(
        code(stiffbench::procedure::no_repeat),
        help("give at least 1; from 2 on the scatter between runs can be estimated")
    )]
    NoRepeat,
    /// No loading branch.
    #[error("`branches` has no \"loading\"")]
    #[diagnostic(
        code(stiffbench::procedure::no_loading),
        help("write branches = [\"loading\"] or [\"loading\", \"unloading\"]")
    )]
    NoLoading,
    /// Loads that are all zero.
    #[error("`loads` are all zero")]
    #[diagnostic(
        code(stiffbench::procedure::only_zero),
        help("list at least one load other than 0, in N, for example -50")
    )]
    OnlyZero,
    /// A number that is not finite.
    #[error("`{key}` is {value}: a finite number is needed")]
    #[diagnostic(
        code(stiffbench::procedure::not_finite),
        help("loads are finite numbers of newtons, times of seconds")
    )]
    NotFinite {
        /// The key, without its unit.
        key: &'static str,
        /// The value, SI.
        value: f64,
    },
    /// A limit below zero.
    #[error("`{key}` is {value} (SI), below zero")]
    #[diagnostic(code(stiffbench::procedure::negative), help("give 0 or more"))]
    Negative {
        /// The key, without its unit.
        key: &'static str,
        /// The value, SI.
        value: f64,
    },
    /// A time that nobody waits for.
    #[error("`{key}` is {value} s, more than a week")]
    #[diagnostic(code(stiffbench::procedure::too_late), help("a time is in seconds"))]
    TooLate {
        /// The key, without its unit.
        key: &'static str,
        /// The value, s.
        value: f64,
    },
    /// A warning limit beyond the hard one.
    #[error("`{key}` is beyond the hard limit")]
    #[diagnostic(
        code(stiffbench::procedure::warns_too_late),
        help("a warning limit is at most the hard limit of the same quantity")
    )]
    WarnsTooLate {
        /// The key, without its unit.
        key: &'static str,
    },
    /// Holds that do not grow from zero.
    #[error("`holds` has {hold_s} s behind {after_s} s")]
    #[diagnostic(
        code(stiffbench::procedure::holds),
        help(
            "holds count from the time the load was reached: list increasing times above zero, for example [60, 120]"
        )
    )]
    Holds {
        /// The hold, s.
        hold_s: f64,
        /// What stands before it, s; 0 for the first.
        after_s: f64,
    },
    /// Unloading where each load is released before the next.
    #[error(
        "`branches` has \"unloading\", but with repeat_order \"at-load\" each load is released before the next"
    )]
    #[diagnostic(
        code(stiffbench::procedure::unloading_at_load),
        help("take repeat_order = \"sweep\", or leave \"unloading\" out")
    )]
    UnloadingAtLoad,
    /// Unloading in a shuffled order.
    #[error("`branches` has \"unloading\", but a shuffled order goes up and down anyway")]
    #[diagnostic(
        code(stiffbench::procedure::unloading_shuffled),
        help("take load_order = \"ascending\", or leave \"unloading\" out")
    )]
    UnloadingShuffled,
    /// A zero for each of several runs that take turns.
    #[error(
        "`zero` is \"run\", but with repeat_order \"at-load\" the runs take turns at every load"
    )]
    #[diagnostic(
        code(stiffbench::procedure::zero_at_load),
        help("take zero = \"cell\", or repeat_order = \"sweep\"")
    )]
    ZeroOfRunsAtLoad,
    /// More readings than anybody makes.
    #[error("{readings} readings in one pose and direction, more than {most}")]
    #[diagnostic(
        code(stiffbench::procedure::too_long),
        help("lower `repeats`, or list fewer loads or holds")
    )]
    TooLong {
        /// Readings planned.
        readings: u64,
        /// Most that are taken.
        most: u64,
    },
}

impl ProcedureProblem {
    /// The key to change, with its table and without its unit.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            Self::File { .. } => "schema",
            Self::Empty { key }
            | Self::Twice { key, .. }
            | Self::NotFinite { key, .. }
            | Self::Negative { key, .. }
            | Self::TooLate { key, .. }
            | Self::WarnsTooLate { key } => key,
            Self::NoRepeat | Self::TooLong { .. } => "repeats",
            Self::NoLoading | Self::UnloadingAtLoad | Self::UnloadingShuffled => "branches",
            Self::OnlyZero => "loads",
            Self::NotAlongAxes { .. } => "directions",
            Self::GaugesAlongAxes => "displacement_axes",
            Self::Holds { .. } => "holds",
            Self::ZeroOfRunsAtLoad => "zero",
        }
    }
}

impl From<TomlProblem> for ProcedureProblem {
    fn from(problem: TomlProblem) -> Self {
        let help = problem.help().map(|help| help.to_string());
        Self::File {
            help: help.unwrap_or_default(),
            problem,
        }
    }
}
