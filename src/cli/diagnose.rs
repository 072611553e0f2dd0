//! `stiffbench diagnose`.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::mismatch::{
    Baseline, Diagnosis, EstimatedNoise, KnownNoise, Observations, RobotBaseline, SearchOptions,
    Verdict, diagnose_and_locate, given_noise, trace,
};
use crate::physics::{Law, ModelFile};
use crate::report::{
    DiagnosisReport, NoiseOrigin, diagnosis_appendix, diagnosis_figures, diagnosis_json,
    diagnosis_page,
};
use crate::robot::FittingFactors;

use super::args::{Global, LogArgs};
use super::data::{Session, load_session};
use super::design;
use super::diagnose_args::{DiagnoseArgs, NoiseSource};
use super::diagnose_earlier::earlier_noise;
use super::diagnose_specimen;
use super::failure::{CliError, Failure};
use super::figure_files::{write, write_figure};
use super::hash::sha256;
use super::inputs::Inputs;
use super::model::laws;
use super::outcome::{Outcome, envelope};
use super::progress::progress;
use super::resolve::{ResolvedModel, resolve};

/// The scatter of the readings may exceed what the records state by this much before it is said.
const RECORD_TOO_GOOD: f64 = 1.5;

/// Finds what the model leaves out.
pub(super) fn run(args: &DiagnoseArgs, global: &Global) -> Result<Outcome, Failure> {
    let without = laws(&args.without)?;
    if let Some(procedure) = &args.design {
        return design::run(args, procedure);
    }
    if let Some(options) = args.specimen.options() {
        if !args.parameters.is_default() {
            return Err(CliError::Argument {
                argument: "--free, --fix, --tie, --bounds".to_owned(),
                problem: "they name parameters of a robot, and a specimen has none".to_owned(),
                help: Some("leave them out".to_owned()),
            }
            .into());
        }
        return diagnose_specimen::run(args, &options, without);
    }
    let session = load_session(design::data(args)?, &LogArgs::default(), global)?;
    let warnings = session.warnings.clone();
    of_session(args, session, without, global).map_err(|failure| failure.with_warnings(&warnings))
}

fn of_session(
    args: &DiagnoseArgs,
    mut session: Session,
    without: Vec<Law>,
    global: &Global,
) -> Result<Outcome, Failure> {
    let bar = progress(global, "diagnosis: read, search, judge, draw", 4);
    let chosen = resolve(&args.model, Some(&mut session))?;
    refuse_known_physics(&chosen)?;
    let inputs = Inputs::default().with_session(&session).with_model(&chosen);
    let mechanism = chosen.robot.mechanism(Some(&chosen.mechanism))?;
    let observations = Observations::new(&session.table, session.header.as_ref());
    let baseline = design::baseline(&chosen, mechanism, &observations.poses, &args.parameters)?;
    bar.inc(1);
    let mut options = SearchOptions {
        noise: KnownNoise::Nothing,
        seed: args.seed,
        without,
    };
    let (noise, noise_origin) = noise(
        args,
        &baseline,
        &observations,
        (&options, &mut session),
        global,
    )?;
    options.noise = noise;
    let (diagnosis, limits, located) = diagnose_and_locate(&baseline, &observations, &options)?;
    bar.inc(1);
    let trace = trace(&baseline, &observations, &diagnosis)?;
    let (next, procedures) = design::proposals(
        &chosen,
        session.header.as_ref(),
        &observations,
        &diagnosis,
        &args.parameters,
    )?;
    let report = DiagnosisReport {
        data: &called(&session, design::data(args)?),
        robot: &chosen.robot.name,
        mechanism: &chosen.mechanism,
        factors: &chosen.factors_name,
        diagnosis: &diagnosis,
        limits: &limits,
        parameters: baseline.parameters(),
        observations: &observations,
        located: &located,
        trace: &trace,
        next: &next,
        without: &options.without,
        noise_origin: &noise_origin,
        seed: args.seed,
    };
    let mut text = diagnosis_page(&report);
    let whole = format!("{text}\n{}", diagnosis_appendix(&report));
    let with_inputs = format!("{}{whole}", inputs.text());
    let mut data = diagnosis_json(&report);
    bar.inc(1);
    if let Some(folder) = folder(args) {
        let factors = baseline.factors(&diagnosis.parameters);
        let result = model(&report, &chosen, factors, &folder).map_err(Failure::from);
        let written = result.and_then(|model| {
            let page = Page {
                text: &with_inputs,
                inputs: &inputs,
                data: &data,
                model: model.as_ref(),
                warnings: &session.warnings,
                procedures: &procedures,
            };
            write_all(args, &report, &folder, &page)
        });
        match written {
            Ok(written) => {
                let _ = writeln!(
                    text,
                    "\nThis page with all numbers behind it, the data and the figures: {}",
                    folder.display()
                );
                data["files"] = json!(written);
            }
            Err(failure) if args.out.is_some() => return Err(failure),
            // A verdict is not withheld because the session may only be read.
            Err(failure) => {
                text = whole;
                session.warnings.push(format!(
                    "page and figures were not written: {}; --out FOLDER puts them elsewhere",
                    failure.message()
                ));
            }
        }
    } else {
        text = whole;
    }
    bar.finish_and_clear();
    Ok(Outcome::new("diagnosis", text, data)
        .with_inputs(inputs)
        .with_warnings(session.warnings)
        .with_strict_exit(strict_exit(&diagnosis)))
}

/// The search begins with the beams alone; physics that is known already would be found again, or hidden.
fn refuse_known_physics(chosen: &ResolvedModel) -> Result<(), CliError> {
    if chosen.physics.effects.is_empty() {
        return Ok(());
    }
    Err(CliError::Argument {
        argument: "--model and --effect".to_owned(),
        problem: "diagnose searches from the beams alone, without physics that is known already"
            .to_owned(),
        help: Some(
            "leave them out: known physics is found again, and what is missing beside it too"
                .to_owned(),
        ),
    })
}

/// The model with what was found in it, for a file in `folder`; where the readings cannot decide there is none to give back.
fn model(
    report: &DiagnosisReport<'_>,
    chosen: &ResolvedModel,
    factors: FittingFactors,
    folder: &Path,
) -> Result<Option<ModelFile>, CliError> {
    if report.diagnosis.verdict == Verdict::InsufficientData {
        return Ok(None);
    }
    let mut model = report.diagnosis.model_file(Some(factors));
    model.robot = Some(robot_seen_from(chosen, folder)?);
    model.robot_sha256 = Some(sha256(&chosen.source.text));
    model.mechanism = Some(chosen.mechanism.clone());
    model.provenance.session = Some(report.data.to_owned());
    model.provenance.software = Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned());
    Ok(Some(model))
}

/// The robot as a file in `folder` names it: a shipped robot by its name, a file by its path from there.
fn robot_seen_from(chosen: &ResolvedModel, folder: &Path) -> Result<String, CliError> {
    let file = Path::new(&chosen.source.name);
    if !file.is_file() {
        return Ok(chosen.source.name.clone());
    }
    let whole = |path: &Path| {
        std::fs::create_dir_all(folder)
            .and_then(|()| path.canonicalize())
            .map_err(|source| CliError::Write {
                path: path.to_owned(),
                source,
            })
    };
    let (file, folder) = (whole(file)?, whole(folder)?);
    let common = file
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    let up = folder.components().skip(common).map(|_| "..".to_owned());
    let down = file
        .components()
        .skip(common)
        .map(|part| part.as_os_str().to_string_lossy().into_owned());
    Ok(up.chain(down).collect::<Vec<_>>().join("/"))
}

/// What the page calls the data: not by a path, so that a session says the same wherever it lies.
pub(super) fn called(session: &Session, path: &Path) -> String {
    let id = session.header.as_ref().and_then(|header| header.id.clone());
    id.or_else(|| {
        path.file_name()
            .map(|name| name.to_string_lossy().into_owned())
    })
    .unwrap_or_else(|| session.name.clone())
}

/// What is known of the noise beforehand, and where from.
fn noise(
    args: &DiagnoseArgs,
    baseline: &RobotBaseline<'_>,
    observations: &Observations,
    (search, session): (&SearchOptions, &mut Session),
    global: &Global,
) -> Result<(KnownNoise, NoiseOrigin), Failure> {
    if args.noise == NoiseSource::Records {
        if !args.earlier.is_empty() {
            return Err(CliError::Argument {
                argument: "--earlier".to_owned(),
                problem: "the records of the instruments give the scatter of readings already"
                    .to_owned(),
                help: Some("leave out --noise records, or --earlier".to_owned()),
            }
            .into());
        }
        let noise = recorded_noise(baseline, observations, session)?;
        return Ok((KnownNoise::Given(noise), NoiseOrigin::Records));
    }
    if args.earlier.is_empty() {
        return Ok((KnownNoise::Nothing, NoiseOrigin::Readings));
    }
    let (known, sessions) = earlier_noise(args, baseline, observations, (search, session), global)?;
    Ok((known, NoiseOrigin::EarlierSessions(sessions)))
}

/// The noise, its part of single readings from the records of the instruments.
fn recorded_noise(
    baseline: &RobotBaseline<'_>,
    observations: &Observations,
    session: &mut Session,
) -> Result<EstimatedNoise, Failure> {
    let Some(step_m) = observations.steps.displacement_m else {
        return Err(CliError::NoResolution {
            data: session.name.clone(),
        }
        .into());
    };
    let procedure = session
        .header
        .as_ref()
        .and_then(|header| header.procedure.as_ref());
    let spread_m = procedure.and_then(|procedure| procedure.settle.spread_m);
    // A step, and a spread within which readings count as settled, are widths: anything within is as likely.
    let sd_m = step_m.hypot(spread_m.unwrap_or(0.0)) / 12f64.sqrt();
    let given = given_noise(baseline, observations, sd_m)?;
    if given.seen_sd_m > RECORD_TOO_GOOD * sd_m {
        session.warnings.push(format!(
            "single readings scatter with {:.2} um, the records of the instruments allow {:.2} um: scatter that the records do not know of \
             is taken for missing physics; --noise estimated does not do that",
            given.seen_sd_m * 1e6,
            sd_m * 1e6
        ));
    }
    Ok(given.noise)
}

/// Where the results go: where the user says, else into the session folder.
fn folder(args: &DiagnoseArgs) -> Option<PathBuf> {
    args.out.clone().or_else(|| {
        let data = args.data.as_ref().filter(|data| data.is_dir())?;
        Some(data.join("diagnosis"))
    })
}

/// What is written besides figures.
struct Page<'a> {
    text: &'a str,
    inputs: &'a Inputs,
    data: &'a Value,
    model: Option<&'a ModelFile>,
    warnings: &'a [String],
    /// File names and texts of the procedures to measure next.
    procedures: &'a [(String, String)],
}

/// Writes the page, the data, the model and the figures.
fn write_all(
    args: &DiagnoseArgs,
    report: &DiagnosisReport<'_>,
    folder: &Path,
    page: &Page<'_>,
) -> Result<Vec<PathBuf>, Failure> {
    let mut object = envelope("diagnosis", true);
    object["inputs"] = json!(page.inputs);
    object["data"] = page.data.clone();
    object["warnings"] = json!(page.warnings);
    let mut files = vec![
        ("verdict.txt", page.text.to_owned()),
        ("diagnosis.json", format!("{object:#}\n")),
    ];
    if let Some(model) = page.model {
        files.push(("model.toml", model.to_toml()));
    }
    let procedures = page.procedures.iter();
    files.extend(procedures.map(|(name, text)| (name.as_str(), text.clone())));
    let mut written = Vec::new();
    for (name, text) in files {
        let path = folder.join(name);
        write(&path, text.as_bytes())?;
        written.push(path);
    }
    if !args.no_figures {
        for (name, figure) in diagnosis_figures(report) {
            written.extend(write_figure(&folder.join(name), &figure, page.inputs)?);
        }
    }
    Ok(written)
}

/// 1 for something that is missing, or a question that these readings cannot answer; 41 for a factor that they do not determine.
fn strict_exit(diagnosis: &Diagnosis) -> u8 {
    if diagnosis.verdict != Verdict::NothingMissing {
        1
    } else if diagnosis.factors.iter().any(|factor| !factor.identified) {
        41
    } else {
        0
    }
}
