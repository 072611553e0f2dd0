//! `stiffbench robot new`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::analysis::{
    ArgumentError, Controller, DhSettings, NewRobot, StatedPosition, UrdfSettings, check_positions,
    is_dash, read_text, robot_from_dh, robot_from_urdf, template,
};
use crate::report::NewRobotReport;
use crate::robot::format2::file::DhConvention;
use crate::robot::{Robot, RobotError};
use crate::source_text::SourceText;

use super::figure_files::{check_new, write_new};
use super::{CliError, Failure, Outcome};

/// Arguments of `robot new`.
#[derive(Debug, Args)]
#[command(
    group = clap::ArgGroup::new("from").required(true).args(["urdf", "dh", "template"]),
    after_help = "Examples:\n  stiffbench robot new my-robot.toml --urdf ur10.urdf --tip tool0\n  stiffbench robot new my-robot.toml --dh table.csv --convention modified --controller kuka --check-position 0,-90,90,0,0,0=1500,0,1850\n  stiffbench robot new my-robot.toml --template serial"
)]
pub(super) struct NewArgs {
    /// Robot file to write; must not exist
    #[arg(value_name = "FILE")]
    out: PathBuf,
    /// URDF to read; expand a xacro first
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// Link of the URDF that is fixed [default: its root]
    #[arg(long, value_name = "LINK", requires = "urdf")]
    base: Option<String>,
    /// Link of the URDF that carries the tool [default: its only end]
    #[arg(long, value_name = "LINK", requires = "urdf")]
    tip: Option<String>,
    /// Section of the links behind a joint, or of all links, which become beams; for example J2="tube 120x6 aluminium"
    #[arg(long, value_name = "[JOINT=]PROFILE", requires = "urdf")]
    section: Vec<String>,
    /// Denavit-Hartenberg table to read, TOML or CSV
    #[arg(long, value_name = "FILE")]
    dh: Option<PathBuf>,
    /// Convention of a table that does not state it
    #[arg(long, value_name = "CONVENTION", value_parser = ["standard", "modified"], requires = "dh")]
    convention: Option<String>,
    /// Manufacturer whose axis convention for six-axis arms the table follows
    #[arg(long, value_name = "MAKER", value_parser = ["kuka", "fanuc"], requires = "dh")]
    controller: Option<String>,
    /// Position of the tool centre, mm, that the controller shows for joint values; repeatable
    #[arg(
        long,
        value_name = "Q1,Q2,...=X,Y,Z",
        requires = "dh",
        allow_hyphen_values = true
    )]
    check_position: Vec<String>,
    /// Template to copy: serial, scara, four-bar, parallelogram or gantry
    #[arg(long, value_name = "NAME", value_parser = ["serial", "scara", "four-bar", "parallelogram", "gantry"])]
    template: Option<String>,
}

/// Writes a robot file that was not there before.
pub(super) fn new_robot(args: &NewArgs) -> Result<Outcome, Failure> {
    if is_dash(&args.out) {
        return Err(CliError::Dash.into());
    }
    check_new(&args.out)?;
    let path = args.urdf.as_ref().or(args.dh.as_ref());
    let input = path.map(|path| text_of(path)).transpose()?;
    let made = match &input {
        Some(input) if args.urdf.is_some() => robot_from_urdf(input, &urdf_settings(args))?,
        Some(input) => robot_from_dh(input, &dh_settings(args))?,
        None => NewRobot {
            text: args
                .template
                .as_deref()
                .and_then(template)
                .unwrap_or_default()
                .to_owned(),
            notes: Vec::new(),
        },
    };
    // What is written can be read: what the file cannot say is found here, before there is a file.
    let source = SourceText::new(args.out.display().to_string(), made.text.clone());
    let robot = match (Robot::parse(&source), &input) {
        (Err(RobotError::File(error)), Some(input)) => {
            return Err(made.error(input, &error).into());
        }
        (parsed, _) => parsed?,
    };
    let stated = args.check_position.iter().map(|text| {
        let parsed = text.parse::<StatedPosition>();
        parsed.map_err(|help| {
            ArgumentError::new(
                format!("--check-position {text}"),
                "it cannot be read",
                help,
            )
        })
    });
    let stated = stated.collect::<Result<Vec<_>, _>>()?;
    let positions = check_positions(&robot, &stated)?;
    write_new(&args.out, &made.text)?;
    let report = NewRobotReport::new(&robot, &args.out.display().to_string(), positions);
    let notes = made.notes.into_iter().chain(robot.warnings);
    Ok(Outcome::new("robot-new", report.document(), report).with_warnings(notes))
}

fn text_of(path: &Path) -> Result<SourceText, Failure> {
    Ok(SourceText::new(
        path.display().to_string(),
        read_text(path)?,
    ))
}

fn urdf_settings(args: &NewArgs) -> UrdfSettings {
    let section = |text: &String| match text.split_once('=') {
        Some((joint, section)) => (Some(joint.trim().to_owned()), section.trim().to_owned()),
        None => (None, text.trim().to_owned()),
    };
    UrdfSettings {
        base: args.base.clone(),
        tip: args.tip.clone(),
        sections: args.section.iter().map(section).collect(),
    }
}

fn dh_settings(args: &NewArgs) -> DhSettings {
    let convention = args.convention.as_deref().map(|name| match name {
        "standard" => DhConvention::Standard,
        _ => DhConvention::Modified,
    });
    let controller = args.controller.as_deref().map(|name| match name {
        "kuka" => Controller::Kuka,
        _ => Controller::Fanuc,
    });
    DhSettings {
        convention,
        controller,
    }
}
