//! `stiffbench simulate --load-cases`.

use crate::bench::{LoadCasePlan, NoiseModel, simulate_load_cases};
use crate::load_cases::write_load_cases;
use crate::readings::SessionHeader;
use crate::report::SimulationReport;
use crate::robot::FittingFactors;

use super::args::SimulateArgs;
use super::failure::Failure;
use super::figure_files::write;
use super::outcome::Outcome;
use super::procedure::load_case_settings;
use super::simulate::{create_new, noise, origin};
use crate::analysis::{ArgumentError, Inputs, ResolvedModel, sha256, start_of};

/// A session folder with load cases.
pub(super) fn run(
    args: &SimulateArgs,
    count: usize,
    mut resolved: ResolvedModel,
    truth: FittingFactors,
) -> Result<Outcome, Failure> {
    if args.keep_history {
        return Err(ArgumentError::new(
            "--keep-history",
            "a load case has no history",
            "leave it out, or leave out --load-cases",
        )
        .into());
    }
    resolved.factors = truth;
    let truth = start_of(&resolved)?;
    let (poses, largest_force_n, repeats) = load_case_settings(&args.procedure)?;
    let plan = LoadCasePlan {
        count,
        largest_force_n,
        repeats,
        poses,
    };
    let noise = noise(args);
    let mechanism = resolved.mechanism()?;
    let mut table =
        simulate_load_cases(&resolved.robot, mechanism, &truth, &plan, &noise, args.seed)?;
    table.origin = Some(origin(args, &resolved));
    create_new(&args.out)?;
    let header = SessionHeader {
        id: Some(format!("simulated-{}", args.seed)),
        robot: Some("robot.toml".to_owned()),
        robot_sha256: Some(sha256(&resolved.source.text)),
        mechanism: Some(resolved.mechanism.clone()),
        origin: table.origin.clone(),
        operator: Some("simulation".to_owned()),
        software: Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned()),
        ..SessionHeader::default()
    };
    for (name, text) in [
        ("robot.toml", resolved.source.text.clone()),
        ("readings.csv", write_load_cases(&table)),
        ("session.toml", header.to_load_case_toml()),
        ("simulation.toml", record(args, &truth, &noise)),
    ] {
        write(&args.out.join(name), text.as_bytes())?;
    }
    let folder = args.out.display();
    let poses = table.poses().len();
    let text = format!(
        "{folder}: {} load cases of mechanism {} in {poses} poses, up to {largest_force_n} N, seed {}\n\
         session.toml, readings.csv, robot.toml and simulation.toml (true factors and noise) written.\nNext: stiffbench fit {folder}\n",
        table.cases.len(),
        resolved.mechanism,
        args.seed,
    );
    let report = SimulationReport {
        folder: args.out.clone(),
        readings: table.component_count(),
        seed: args.seed,
        procedure: "load cases".to_owned(),
        minutes: 0.0,
        mechanism: resolved.mechanism.clone(),
        factors: truth,
        physics: resolved.physics.effects.clone(),
        noise,
    };
    Ok(Outcome::new("simulate", text, report)
        .with_inputs(Inputs::default().with_model(&resolved))
        .with_warnings(resolved.warnings.clone()))
}

/// What an analysis must not see: the truth.
fn record(args: &SimulateArgs, truth: &FittingFactors, noise: &NoiseModel) -> String {
    let um = |metres: f64| metres / crate::quantity::METRES_PER_MICROMETRE;
    format!(
        "# The truth behind readings.csv; no analysis reads this file.\nschema = \"stiffbench/simulation/1\"\nseed = {}\n[factors]\n{}\n[noise]\n\
         reading_sd_um = {:?}\nzero_sd_um = {:?}\nrun_slope_sd = {:?}\ndisplacement_step_um = {:?}\nforce_step_N = {:?}\n",
        args.seed,
        truth.to_toml(),
        um(noise.reading_sd_m),
        um(noise.zero_sd_m),
        noise.run_slope_sd,
        um(noise.displacement_step_m),
        noise.force_step_n
    )
}
