//! `stiffbench-validate reference export`.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use serde_json::json;

use super::args::ExportArgs;
use crate::reference::{PoseModel, ReferenceLoad, ReferenceModel, SolidModel};
use crate::report::ReferenceExport;
use stiffbench::analysis::{
    ArgumentError, Inputs, ModelChoice, ReadError, ResolvedModel, resolve, sha256,
};
use stiffbench::cli::failure::Failure;
use stiffbench::cli::figure_files::write_again;
use stiffbench::cli::outcome::Outcome;
use stiffbench::report::{Table, significant};
use stiffbench::robot::{JointModel, MechanismModel, Theory};
use stiffbench::test_point::{Direction, PoseId};

use super::MODEL_FILE;

/// Writes the robot in its poses as solids, with the cases of load.
pub(crate) fn export(args: &ExportArgs) -> Result<Outcome, Failure> {
    check_export(args)?;
    let choice = ModelChoice {
        robot: Some(args.robot.clone()),
        mechanism: args.mechanism.clone(),
        factors: Some(args.factors.clone()),
        ..ModelChoice::default()
    };
    let resolved = resolve(&choice, None)?;
    let poses = match (args.pose.as_slice(), resolved.robot.poses.first()) {
        ([], Some(first)) => vec![first.id.clone()],
        ([], None) => {
            return Err(ArgumentError::new(
                "--pose",
                format!("{} has no named pose", resolved.source.name),
                "add [poses.NAME] to the robot file",
            )
            .into());
        }
        (names, _) => names.iter().map(|name| PoseId::new(name)).collect(),
    };
    let mut model = empty_model(&resolved, args)?;
    for pose in &poses {
        let solids = solids_in(&resolved, pose, args.size_mm)?;
        model
            .poses
            .push(write_pose(args, &resolved, pose, &solids)?);
        if model.members.is_empty() {
            model.beams = solids.members.len();
            model.members = solids.members;
        }
    }
    let text = export_text(&model, &args.out);
    write_again(
        &args.out.join(MODEL_FILE),
        format!("{:#}\n", json!(model)).as_bytes(),
    )?;
    let data = ReferenceExport {
        folder: args.out.clone(),
        model,
    };
    Ok(Outcome::new("reference-export", text, data)
        .with_inputs(Inputs::default().with_model(&resolved))
        .with_warnings(resolved.warnings))
}

/// Refuses loads that move nothing, poses named twice, and a folder in use.
fn check_export(args: &ExportArgs) -> Result<(), ArgumentError> {
    let wrong = |argument: String, problem: &str, help: &str| {
        Err(ArgumentError::new(argument, problem, help))
    };
    for (place, load) in args.loads.iter().enumerate() {
        if !(load.is_finite() && *load != 0.0) {
            return wrong(
                format!("--load {load}"),
                "a load moves the end only if it is not zero",
                "--load=-50,-100,-300,-500",
            );
        }
        if args.loads[..place].contains(load) {
            return wrong(
                format!("--load {load}"),
                "it is named twice",
                "name each load once",
            );
        }
    }
    for (place, pose) in args.pose.iter().enumerate() {
        if args.pose[..place].contains(pose) {
            return wrong(
                format!("--pose {pose}"),
                "it is named twice",
                "name each pose once",
            );
        }
    }
    let in_use = fs::read_dir(&args.out).is_ok_and(|mut entries| entries.next().is_some());
    if in_use || args.out.is_file() {
        return wrong(
            format!("--out {}", args.out.display()),
            "it is there already and not an empty folder",
            "choose another name, or empty the folder",
        );
    }
    Ok(())
}

fn empty_model(resolved: &ResolvedModel, args: &ExportArgs) -> Result<ReferenceModel, Failure> {
    let path = Path::new(&resolved.source.name);
    // Read again from wherever the program is run.
    let robot = if path.is_file() {
        path.canonicalize().map_err(ReadError::of(path))?
    } else {
        path.to_owned()
    };
    Ok(ReferenceModel {
        schema: ReferenceModel::schema(),
        software: env!("CARGO_PKG_VERSION").to_owned(),
        robot: robot.display().to_string(),
        robot_sha256: sha256(&resolved.source.text),
        mechanism: resolved.mechanism.clone(),
        factors: resolved.factors_name.clone(),
        factor_values: [resolved.factors.beam, resolved.factors.link],
        beams: 0,
        element: "C3D20R".to_owned(),
        size_mm: args.size_mm,
        large_displacements: args.large_displacements,
        poses: Vec::new(),
        members: Vec::new(),
    })
}

fn solids_in(resolved: &ResolvedModel, pose: &PoseId, size_mm: f64) -> Result<SolidModel, Failure> {
    let robot = &resolved.robot;
    let mechanism = robot.mechanism(Some(&resolved.mechanism))?;
    let mut beams = MechanismModel::new(
        robot,
        mechanism,
        &JointModel::Rigid,
        Theory::EulerBernoulli,
        &resolved.factors,
    )?;
    beams.place(robot.pose(pose)?)?;
    let names: Vec<&str> = beams.members().map(|member| member.name.as_str()).collect();
    Ok(SolidModel::new(beams.structure(), &names, 1e-3 * size_mm)?)
}

/// Writes mesh and cases of one pose.
fn write_pose(
    args: &ExportArgs,
    resolved: &ResolvedModel,
    pose: &PoseId,
    solids: &SolidModel,
) -> Result<PoseModel, Failure> {
    let stem: String = pose
        .as_str()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    let file = format!("{stem}.inp");
    let about = [
        format!(
            "stiffbench {}: reference of solids",
            env!("CARGO_PKG_VERSION")
        ),
        format!(
            "{}, mechanism {}, pose {pose}, factors {}",
            resolved.robot.name, resolved.mechanism, resolved.factors_name
        ),
    ];
    write_again(&args.out.join(&file), solids.deck(&about).as_bytes())?;
    let mut cases = Vec::new();
    for direction in Direction::ALL {
        for &force_n in &args.loads {
            let job = format!("{stem}_{direction}{force_n:+}N");
            let text = solids.case(&file, direction.index(), force_n, args.large_displacements);
            write_again(&args.out.join(format!("{job}.inp")), text.as_bytes())?;
            cases.push(ReferenceLoad {
                direction: direction.to_string(),
                force_n,
                job,
            });
        }
    }
    Ok(PoseModel {
        pose: pose.to_string(),
        file,
        elements: solids.elements(),
        nodes: solids.nodes(),
        cases,
    })
}

fn export_text(model: &ReferenceModel, folder: &Path) -> String {
    let mm = |metres: f64| significant(1e3 * metres, 4);
    let table = Table::of(&model.members)
        .words("member", |one| &one.name)
        .numbers("length, mm", |one| mm(one.length_m))
        .numbers("along y, mm", |one| mm(one.prism.side_y_m))
        .numbers("along z, mm", |one| mm(one.prism.side_z_m))
        .numbers("wall, mm", |one| {
            one.prism.wall_m.map_or_else(|| "solid".to_owned(), mm)
        })
        .numbers("moduli times", |one| {
            significant(one.prism.modulus_scale, 3)
        })
        .numbers("J acting / J of the file", |one| {
            significant(one.acting_j_m4 / one.wanted_j_m4, 3)
        })
        .numbers("elements", |one| one.elements);
    let mut text = format!(
        "{}\nA, Iy and Iz of every member are those of the robot file: by its shape where a rectangle or a tube has them, else by a rectangle\n\
         whose moduli are multiplied by what the area is too large or too small. The file gives no shape, so J and shear are those of the prism.\n\n",
        table.text()
    );
    for pose in &model.poses {
        let _ = writeln!(
            text,
            "{}: {} elements, {} nodes, {} cases of load",
            pose.pose,
            pose.elements,
            pose.nodes,
            pose.cases.len()
        );
    }
    let _ = writeln!(
        text,
        "Units of the files: mm, N, MPa. Next: stiffbench-validate reference run {}",
        folder.display()
    );
    text
}
