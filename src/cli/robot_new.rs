//! `stiffbench robot new`.

use std::path::Path;

use crate::analysis::{
    ArgumentError, Controller, DhSettings, NewRobot, StatedPosition, UrdfSettings, check_positions,
    is_dash, read_text, robot_from_dh, robot_from_urdf, template,
};
use crate::report::NewRobotReport;
use crate::robot::format2::file::DhConvention;
use crate::robot::{Robot, RobotError};
use crate::source_text::SourceText;

use super::failure::{CliError, Failure};
use super::figure_files::{check_new, write_new};
use super::outcome::Outcome;
use super::robot_args::NewArgs;

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
