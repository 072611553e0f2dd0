//! `stiffbench simulate`.

use std::fs;
use std::path::Path;

use serde_json::json;

use crate::bench::{BenchPlan, Jack, NoiseModel, VirtualBench};
use crate::fit::{factor_index, factor_vector, factors_from_vector};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{
    InstrumentRecord, Instruments, LoadOrder, ProcedureRecord, RepeatOrder, SessionHeader,
    SettleRecord, ZeroScope, write_readings,
};
use crate::report::factors_toml;
use crate::robot::FittingFactors;
use crate::test_point::{Branch, PoseId};

use super::args::{Plan, SimulateArgs};
use super::data::{Chosen, choose, sha256};
use super::failure::{CliError, Failure};
use super::figure_files::write;
use super::outcome::Outcome;

/// A session folder from a virtual bench.
pub(super) fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    let chosen = choose(&args.model, None)?;
    let truth = true_factors(args, &chosen.factors)?;
    let plan = bench_plan(args, &chosen);
    let (noise, jack) = noise(args);
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let id = format!("simulated-{}", args.seed);
    let table = VirtualBench::new(&chosen.robot, mechanism, &truth, noise, jack)?
        .run(&plan, &id, args.seed)?;

    create_new(&args.out)?;
    let mut readings = Vec::new();
    write_readings(&table, &mut readings)?;
    write(&args.out.join("robot.toml"), chosen.source.text.as_bytes())?;
    write(&args.out.join("readings.csv"), &readings)?;
    write(
        &args.out.join("session.toml"),
        header(args, &chosen, &plan, &id).to_toml().as_bytes(),
    )?;
    write(
        &args.out.join("simulation.toml"),
        simulation_record(args, &truth, &noise, &jack).as_bytes(),
    )?;
    let text = format!(
        "{}: {} readings of mechanism {} in {} poses and {} directions, seed {}\nsession.toml, readings.csv, robot.toml and simulation.toml \
         (true factors and noise) written.\nNext: stiffbench fit {}\n",
        args.out.display(),
        table.readings.len(),
        chosen.mechanism,
        plan.poses.len(),
        plan.directions.len(),
        args.seed,
        args.out.display()
    );
    let data = json!({
        "folder": args.out,
        "readings": table.readings.len(),
        "seed": args.seed,
        "mechanism": chosen.mechanism,
        "factors": truth,
        "noise": noise,
    });
    Ok(Outcome::new("simulate", text, data).with_warnings(chosen.robot.warnings.clone()))
}

/// Makes the session folder; one that exists is never touched.
fn create_new(folder: &Path) -> Result<(), CliError> {
    if let Some(parent) = folder
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty())
    {
        fs::create_dir_all(parent).map_err(|source| CliError::Write {
            path: parent.to_owned(),
            source,
        })?;
    }
    fs::create_dir(folder).map_err(|source| match source.kind() {
        std::io::ErrorKind::AlreadyExists => CliError::Exists {
            path: folder.to_owned(),
        },
        _ => CliError::Write {
            path: folder.to_owned(),
            source,
        },
    })
}

fn true_factors(args: &SimulateArgs, start: &FittingFactors) -> Result<FittingFactors, Failure> {
    let mut vector = factor_vector(start);
    for setting in &args.true_factor {
        let wrong = |problem: &str| CliError::Argument {
            argument: format!("--true-factor {setting}"),
            problem: problem.to_owned(),
            help: Some("--true-factor beam.Iy=0.006".to_owned()),
        };
        let (name, value) = setting
            .split_once('=')
            .ok_or_else(|| wrong("a factor, an equals sign and a number are needed"))?;
        let value: f64 = value
            .parse()
            .map_err(|_| wrong("the value is not a number"))?;
        if !(value.is_finite() && value > 0.0) {
            return Err(wrong("the value must be above zero").into());
        }
        vector[factor_index(name)?] = value;
    }
    Ok(factors_from_vector(&vector))
}

fn bench_plan(args: &SimulateArgs, chosen: &Chosen) -> BenchPlan {
    let all = || {
        chosen
            .robot
            .poses
            .iter()
            .map(|named| named.id.clone())
            .collect()
    };
    let poses = args.poses.as_ref().map_or_else(all, |names| {
        names.iter().map(|name| PoseId::new(name)).collect()
    });
    let paper = args.plan == Plan::Paper;
    BenchPlan {
        poses,
        directions: args.directions.clone(),
        loads_n: args.loads_n.clone(),
        unloading: args.plan == Plan::LoadUnload,
        repeats: args.repeats,
        repeat_order: if paper {
            RepeatOrder::AtLoad
        } else {
            RepeatOrder::Sweep
        },
        zero: if paper {
            ZeroScope::Cell
        } else {
            ZeroScope::Run
        },
    }
}

fn noise(args: &SimulateArgs) -> (NoiseModel, Jack) {
    let jack = Jack {
        force_tolerance_n: args.force_tolerance_n,
        ..Jack::default()
    };
    if args.noise_free {
        return (NoiseModel::NONE, jack);
    }
    let noise = NoiseModel {
        reading_sd_m: args.reading_sd_um * METRES_PER_MICROMETRE,
        zero_sd_m: args.zero_sd_um * METRES_PER_MICROMETRE,
        run_slope_sd: args.run_slope_sd,
        displacement_step_m: args.displacement_step_um * METRES_PER_MICROMETRE,
        force_step_n: args.force_step_n,
    };
    (noise, jack)
}

fn header(args: &SimulateArgs, chosen: &Chosen, plan: &BenchPlan, id: &str) -> SessionHeader {
    let step = |step: f64| (!args.noise_free && step > 0.0).then_some(step);
    let gauge = |model: &str, resolution| InstrumentRecord {
        model: Some(model.to_owned()),
        resolution,
        ..InstrumentRecord::default()
    };
    let branches = if plan.unloading {
        vec![Branch::Loading, Branch::Unloading]
    } else {
        vec![Branch::Loading]
    };
    let name = match args.plan {
        Plan::Paper => "paper",
        Plan::Sweeps => "sweeps",
        Plan::LoadUnload => "load-unload",
    };
    SessionHeader {
        id: Some(id.to_owned()),
        robot: Some("robot.toml".to_owned()),
        robot_sha256: Some(sha256(&chosen.source.text)),
        mechanism: Some(chosen.mechanism.clone()),
        factors: chosen
            .robot
            .factors
            .contains_key(&chosen.factors_name)
            .then(|| chosen.factors_name.clone()),
        operator: Some("simulation".to_owned()),
        software: Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned()),
        procedure: Some(ProcedureRecord {
            name: Some(name.to_owned()),
            poses: plan.poses.clone(),
            directions: plan.directions.clone(),
            loads_n: plan.loads_n.clone(),
            branches,
            repeats: Some(plan.repeats),
            repeat_order: Some(plan.repeat_order),
            load_order: Some(LoadOrder::Ascending),
            seed: Some(args.seed),
            zero: Some(plan.zero),
            settle: SettleRecord {
                force_tolerance_n: Some(args.force_tolerance_n),
                ..SettleRecord::default()
            },
            ..ProcedureRecord::default()
        }),
        instruments: Instruments {
            force: Some(gauge("virtual force gauge", step(args.force_step_n))),
            displacement: Some(gauge(
                "virtual dial gauge",
                step(args.displacement_step_um * METRES_PER_MICROMETRE),
            )),
        },
        ..SessionHeader::default()
    }
}

/// What an analysis must not see: the truth.
fn simulation_record(
    args: &SimulateArgs,
    truth: &FittingFactors,
    noise: &NoiseModel,
    jack: &Jack,
) -> String {
    format!(
        "# The truth behind readings.csv; no analysis reads this file.\nschema = \"stiffbench/simulation/1\"\nseed = {}\n\n[factors]\n{}\n[noise]\n\
         reading_sd_um = {:?}\nzero_sd_um = {:?}\nrun_slope_sd = {:?}\ndisplacement_step_um = {:?}\nforce_step_N = {:?}\nforce_tolerance_N = {:?}\n",
        args.seed,
        factors_toml(truth),
        noise.reading_sd_m / METRES_PER_MICROMETRE,
        noise.zero_sd_m / METRES_PER_MICROMETRE,
        noise.run_slope_sd,
        noise.displacement_step_m / METRES_PER_MICROMETRE,
        noise.force_step_n,
        jack.force_tolerance_n
    )
}
