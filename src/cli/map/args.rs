//! The arguments of `robot map`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::cli::numbers::{MOST_POSES, count_up_to, number_that};
use crate::cli::option_values::{OptionValue, one_of};
use crate::distribution::{MapColumn, MatrixKind, PlaneAxis, Sampling, Shard};
use crate::plot::BinValue;

use super::files::WantedFigures;

/// Arguments of `robot map`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  stiffbench robot map                                     the paper's six mechanisms in 50 000 random poses\n  stiffbench robot map --mechanisms A,F --samples 200000 --out maps\n  stiffbench robot map --mechanisms F --directions x,y,z --directions 0,1,1 --json\n  stiffbench robot map --model my-session/diagnosis/model.toml --at-load 50\n  stiffbench robot map --figures maps/figures --difference A,F\n  stiffbench robot map my-arm.toml --plane x,z --directions x,y,z,rx,ry,rz --matrix --out maps\n  stiffbench robot map --load 0,-50,0 --limit 0.5           pose accuracy under 50 N downward, largest load for half a millimetre\n  stiffbench robot map --samples 1000000 --shard 3/8 --out shards\n  stiffbench robot map merge shards/*.map-shard --out maps"
)]
pub(in crate::cli) struct MapArgs {
    /// Joining shards instead.
    #[command(subcommand)]
    pub(super) what: Option<MapCommand>,
    /// The study.
    #[command(flatten)]
    pub(super) study: StudyArgs,
    /// Compute only shard K of N and write it into the folder of --out; robot map merge joins the shards
    #[arg(long, value_name = "K/N", value_parser = shard, requires = "out")]
    pub(super) shard: Option<Shard>,
    /// Folder for the points (CSV), tables and numbers
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: Option<PathBuf>,
    /// Write figures of every mechanism and direction, and of all mechanisms with one scale, into this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "shard")]
    pub(super) figures: Option<PathBuf>,
    /// Also figures of the second mechanism minus the first, and of their ratio
    #[arg(long, value_name = "A,F", value_parser = two_names, requires = "figures")]
    pub(super) difference: Option<[String; 2]>,
    /// Value shown in a square of a figure, taken over its poses [default: mean, or least if more than two variables vary]
    #[arg(long, value_parser = one_of(CELLS), requires = "figures")]
    pub(super) cell: Option<BinValue>,
    /// What is asked instead of the stiffness.
    #[command(flatten)]
    pub(super) asked: Asked,
}

impl MapArgs {
    /// The figures that are asked for.
    pub(super) fn wanted_figures(&self) -> WantedFigures {
        WantedFigures {
            folder: self.figures.clone(),
            difference: self.difference.clone(),
            cell: self.cell,
        }
    }
}

/// Questions other than that for the stiffness.
#[derive(Debug, Args)]
pub(super) struct Asked {
    /// Map displacement and rotation under this load at the end (N and N*m) instead of the stiffness
    #[arg(long, value_name = "FX,FY,FZ[,MX,MY,MZ]", value_parser = end_load, allow_hyphen_values = true, conflicts_with = "shard")]
    pub(super) load: Option<EndLoad>,
    /// With --load: also the largest load in its direction that moves the end by at most this, mm
    #[arg(long, value_name = "MM", value_parser = above_zero, requires = "load")]
    pub(super) limit: Option<f64>,
    /// Map the sag of the end under the robot's own weight instead of the stiffness; needs masses in the robot file
    #[arg(long, conflicts_with = "shard")]
    pub(super) sag: bool,
    /// Print the sensitivity of the smallest and the mean stiffness to sections and joints [mechanism: the last, unless named]
    #[arg(long, conflicts_with = "shard")]
    pub(super) sensitivity: bool,
}

impl Asked {
    /// Whether anything is asked.
    pub(super) fn is_any(&self) -> bool {
        self.load.is_some() || self.sag || self.sensitivity
    }
}

/// Force and moment at the end, N and N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EndLoad(pub(super) [f64; 6]);

/// Three numbers, or six.
fn end_load(text: &str) -> Result<EndLoad, String> {
    let wrong = "three forces in N, or three forces and three moments in N·m, are needed, for example 0,-50,0";
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let mut numbers = numbers.map_err(|_| wrong)?;
    if numbers.len() == 3 {
        numbers.extend([0.0; 3]);
    }
    let load = <[f64; 6]>::try_from(numbers).map_err(|_| wrong)?;
    if load.iter().all(|value| value.is_finite()) && load.iter().any(|value| *value != 0.0) {
        Ok(EndLoad(load))
    } else {
        Err("a load of finite numbers that are not all zero is needed".to_owned())
    }
}

/// A number above zero.
fn above_zero(text: &str) -> Result<f64, String> {
    number_that(text, |value| value > 0.0, "a number above zero is needed")
}

/// Two names with a comma between them.
fn two_names(text: &str) -> Result<[String; 2], String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    match <[String; 2]>::try_from(names) {
        Ok([a, b]) if !a.is_empty() && !b.is_empty() && a != b => Ok([a, b]),
        _ => Err("two different mechanisms are needed, for example A,F".to_owned()),
    }
}

/// Subcommands of `robot map`.
#[derive(Debug, Subcommand)]
pub(super) enum MapCommand {
    /// Merge shards; the result is byte-identical to that of the study in one piece
    Merge(MergeArgs),
}

/// Arguments of `robot map merge`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  stiffbench robot map merge shards/*.map-shard --out maps")]
pub(super) struct MergeArgs {
    /// Shard files, or folders of them
    #[arg(required = true)]
    pub(super) shards: Vec<PathBuf>,
    /// Folder for the points (CSV), tables and numbers
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: Option<PathBuf>,
    /// Write figures of every mechanism and direction, and of all mechanisms with one scale, into this folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
    /// Value shown in a square of a figure, taken over its poses [default: mean, or least if more than two variables vary]
    #[arg(long, value_parser = one_of(CELLS), requires = "figures")]
    pub(super) cell: Option<BinValue>,
}

impl MergeArgs {
    /// The figures that are asked for.
    pub(super) fn wanted_figures(&self) -> WantedFigures {
        WantedFigures {
            folder: self.figures.clone(),
            difference: None,
            cell: self.cell,
        }
    }
}

/// What a map is of.
#[derive(Debug, Clone, Args)]
pub(super) struct StudyArgs {
    /// Name of a shipped robot, or a robot file [default: the model's, else hp-robot]
    #[arg(value_name = "ROBOT")]
    pub(super) robot: Option<String>,
    /// Mechanisms, comma-separated, or all [default: the model's, else all]
    #[arg(long = "mechanisms", value_name = "NAME,...", value_delimiter = ',')]
    pub(super) mechanism: Vec<String>,
    /// Factor set of the robot, or a TOML file with tables beam and link [default: the fit's or the model's, else m_fsd, else unit]
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "fit")]
    pub(super) factors: Option<String>,
    /// Output of stiffbench fit --json: its factors, with their uncertainty propagated to the map
    #[arg(long, value_name = "FILE")]
    pub(super) fit: Option<PathBuf>,
    /// Model with found physics, as diagnose writes it
    #[arg(long, value_name = "FILE")]
    pub(super) model: Option<PathBuf>,
    /// Effect in addition to the beams, LAW@PLACE:NAME=VALUE,... (docs/physics.md); repeatable
    #[arg(long = "effect", value_name = "EFFECT")]
    pub(super) effects: Vec<String>,
    /// Load for the secant stiffness of nonlinear joints, N
    #[arg(long, value_name = "N", value_parser = load, allow_negative_numbers = true)]
    pub(super) at_load: Option<f64>,
    /// Number of poses within the limits; a grid has at least as many
    #[arg(long = "samples", value_name = "N", default_value_t = 50_000, value_parser = count_up_to(MOST_POSES))]
    pub(super) poses: usize,
    /// Sampling of the poses
    #[arg(long, value_parser = one_of(SAMPLINGS), default_value = "monte-carlo")]
    pub(super) sampling: Sampling,
    /// Seed of the poses
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Two coordinates of the end that span the map: x, y, z, or r for the distance from the vertical axis [default: r and the vertical]
    #[arg(long, value_name = "AXIS,AXIS", value_parser = plane)]
    pub(super) plane: Option<PlaneChoice>,
    /// Variables to vary, comma-separated [default: those that change a coordinate of the plane]
    #[arg(long, value_delimiter = ',', value_name = "VARIABLE,...")]
    pub(super) vary: Option<Vec<String>>,
    /// Directions: axes (x,y,z; rx,ry,rz for the rotational stiffness about them) or a vector (0,1,1); repeatable [default: x,y,z]
    #[arg(long = "directions", value_name = "AXES|X,Y,Z", value_parser = directions, allow_hyphen_values = true)]
    pub(super) directions: Vec<DirectionChoice>,
    /// Leave out the principal stiffnesses
    #[arg(long)]
    pub(super) no_principal: bool,
    /// Add the 6 x 6 Cartesian stiffness in each pose, SI, or its inverse, the compliance
    #[arg(long, value_parser = one_of(MATRICES), value_name = "KIND", num_args = 0..=1, require_equals = true, default_missing_value = "stiffness")]
    pub(super) matrix: Option<MatrixKind>,
}

/// Which matrix of the end.
const MATRICES: [OptionValue<MatrixKind>; 2] = [
    (
        "stiffness",
        "Force and moment per displacement and rotation",
        MatrixKind::Stiffness,
    ),
    (
        "compliance",
        "Displacement and rotation per force and moment",
        MatrixKind::Compliance,
    ),
];

/// What a square of a figure shows.
const CELLS: [OptionValue<BinValue>; 4] = [
    ("mean", "The mean of its poses", BinValue::Mean),
    ("median", "The median", BinValue::Median),
    ("least", "The least", BinValue::Least),
    ("greatest", "The greatest", BinValue::Greatest),
];

/// Two different coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaneChoice(pub(super) [PlaneAxis; 2]);

/// Two of x, y, z and r with a comma between them.
fn plane(text: &str) -> Result<PlaneChoice, String> {
    let wrong = || "two different ones of x, y, z and r are needed, for example x,z".to_owned();
    let axes: Result<Vec<PlaneAxis>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match axes.map(<[PlaneAxis; 2]>::try_from) {
        Ok(Ok([first, second])) if first != second => Ok(PlaneChoice([first, second])),
        _ => Err(wrong()),
    }
}

/// Sampling of the poses.
const SAMPLINGS: [OptionValue<Sampling>; 3] = [
    ("monte-carlo", "Uniformly at random", Sampling::MonteCarlo),
    ("grid", "Centres of equal cells", Sampling::Grid),
    (
        "low-discrepancy",
        "Low-discrepancy sequence: more even than random, any number of poses",
        Sampling::LowDiscrepancy,
    ),
];

/// What one `--directions` names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DirectionChoice(pub(super) Vec<MapColumn>);

/// Names of axes, or one vector.
fn directions(text: &str) -> Result<DirectionChoice, String> {
    let wrong = || {
        "axes like x,y,z or rx,ry,rz or three numbers with commas between them are needed, for example 0,1,1"
            .to_owned()
    };
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut axes = MapColumn::axes();
    axes.extend(MapColumn::axes_of_rotation());
    let named: Option<Vec<MapColumn>> = parts
        .iter()
        .map(|part| axes.iter().find(|axis| axis.name() == *part).cloned())
        .collect();
    if let Some(named) = named {
        return Ok(DirectionChoice(named));
    }
    let numbers: Result<Vec<f64>, _> = parts.iter().map(|part| part.parse()).collect();
    let vector = numbers
        .ok()
        .and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    let column = MapColumn::along(&parts.join(","), vector.ok_or_else(wrong)?);
    let no_direction = "a vector of finite numbers that are not all zero is needed";
    Ok(DirectionChoice(vec![
        column.ok_or_else(|| no_direction.to_owned())?,
    ]))
}

/// K/N with K from 1 to N.
fn shard(text: &str) -> Result<Shard, String> {
    let parsed = text.split_once('/').and_then(|(k, n)| {
        Some((
            k.trim().parse::<usize>().ok()?,
            n.trim().parse::<usize>().ok()?,
        ))
    });
    match parsed {
        Some((k, n)) if (1..=n).contains(&k) => Ok(Shard {
            index: k - 1,
            count: n,
        }),
        _ => Err("K/N with K from 1 to N is needed, for example 3/8".to_owned()),
    }
}

/// A load above zero.
fn load(text: &str) -> Result<f64, String> {
    let wrong = "a load other than zero is needed, in N";
    // Laws are the same for both signs.
    number_that(text, |load| load != 0.0, wrong).map(f64::abs)
}
