//! `stiffbench demo`: the main job without hardware, from two emulated gauges to an assessed model with figures; then a session with
//! concealed play, which the diagnosis names, and its report.

mod concealed;
mod measure;

use std::path::{Path, PathBuf};

use clap::Args;
use indexmap::IndexSet;

use stiffbench_document::Document;

use crate::analysis::{Data, FitData, FitSettings, LoadedSession, ModelChoice, PaperFitSettings};
use crate::fit::PoseRules;
use crate::report::{
    DemoReport, DemoTableVi, Fitted, load_displacement_figure, robot_figure, stiffness_document,
};
use crate::robot::Predictor;
use crate::stiffness::{Branches, Method};
use crate::test_point::PoseId;

use super::export::check_free;
use super::figure_files::{write, write_figure};
use super::progress::progress;
use super::{CliError, Failure, Global, Outcome};

/// Arguments of `demo`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  stiffbench demo --out my-demo")]
pub(super) struct DemoArgs {
    /// Folder for the session, tables and figures
    #[arg(long, value_name = "FOLDER", default_value = "stiffbench-demo")]
    out: PathBuf,
}

/// Poses the demonstration fits; the others are held out, as in the paper.
const TRAIN: [&str; 2] = ["P1", "P3"];

/// Runs everything and writes it to a folder.
pub(super) fn run(args: &DemoArgs, global: &Global) -> Result<Outcome, Failure> {
    let out = free_folder(&args.out)?;
    let folder = out.join("session");
    measure::measure(&folder, global)?;
    let bar = progress(global, "analysing", 6);
    let session = LoadedSession::open(&folder, &global.open_settings())?;
    let readings = session.table.readings.len();
    let table = session.stiffness(Branches::LoadingOnly)?;
    let model = ModelChoice {
        robot: Some("hp-robot".to_owned()),
        ..ModelChoice::default()
    };
    let data = Data::Readings(vec![session]);
    let prepared = FitData::new(data, &model, Method::Regression)?;
    bar.inc(1);

    let robot = &prepared.model.robot;
    let settings = FitSettings {
        train: Some(TRAIN.map(str::to_owned).to_vec()),
        ..FitSettings::default()
    };
    let outcome = prepared.fit(&settings, &|| ())?;
    let fitted = Fitted::new(&prepared, &settings, outcome)?;
    let outcome = &fitted.outcome;
    bar.inc(1);
    let open = global.open_settings();
    let of_paper = Data::open(Path::new("paper-experiment"), &open)?;
    let of_paper = FitData::new(of_paper, &model, Method::Regression)?;
    let procedure = PaperFitSettings {
        train: settings.train.clone(),
        ..PaperFitSettings::default()
    };
    let procedure = of_paper.fit_as_paper(&procedure)?.outcome;
    let joint = of_paper.fit(&settings, &|| ())?;
    let table_vi = DemoTableVi::new(&procedure, &joint);
    bar.inc(1);

    let mut files: Vec<PathBuf> = Vec::new();
    let inputs = &prepared.inputs;
    let mut figure = |name: &str, figure: &crate::plot::Figure| -> Result<(), Failure> {
        files.extend(write_figure(
            &out.join("figures").join(name),
            figure,
            inputs,
        )?);
        Ok(())
    };
    figure(
        "load-displacement",
        &load_displacement_figure(&[("demo session", &table)]),
    )?;
    for (name, drawn) in &fitted.figures {
        figure(name, drawn)?;
    }
    bar.inc(1);
    bar.inc(1);
    let mut predictor = Predictor::new(robot, prepared.model.mechanism()?, &outcome.factors)?;
    predictor.place(robot.pose(&PoseId::new("P1"))?)?;
    figure(
        "robot",
        &robot_figure(&mut predictor, "P1", [0.0, -50.0, 0.0]),
    )?;

    let plan = prepared.plan(outcome, &PoseRules::default())?;
    let outcome = fitted.outcome;
    let mut fit = fitted.report;
    fit.plan_next(plan.planned);
    let mut document = Document::of(format!(
        "A session of {readings} readings by emulated gauges on a robot with the factors m_fsd ({}): stiffness of each pose and direction",
        folder.display(),
    ));
    document.append(stiffness_document(&table, false));
    document.paragraph("Factors of the beams fitted to P1 and P3, validated on P2 and P4");
    document.append(fit.document(&outcome));
    document.append(table_vi.document(&procedure, &joint));
    let with_inputs = format!("{}{}", inputs.text(), document.text());
    write(&out.join("tables.txt"), with_inputs.as_bytes())?;
    files.push(out.join("tables.txt"));
    files.extend(["session.toml", "readings.csv"].map(|name| folder.join(name)));
    bar.finish_and_clear();
    let second = concealed::run(&out, global)?;
    let story = concealed::story(&second.report, &out.join("diagnosis"));
    files.extend(second.files);
    document.append(story);
    document.paragraph("Written:");
    for line in folders(&files) {
        document.item(line);
    }
    document.next(format!(
        "fit {} --train P1,P3 --bootstrap 1000",
        folder.display()
    ));
    let data = DemoReport {
        stiffness: table,
        fit,
        paper_table_vi: table_vi,
        concealed: second.report,
        files,
    };
    Ok(Outcome::new("demo", document, data)
        .with_inputs(prepared.inputs)
        .with_warnings(prepared.warnings))
}

/// The folders of files, each with the number of files in it.
fn folders(files: &[PathBuf]) -> Vec<String> {
    let folders: IndexSet<&Path> = files.iter().filter_map(|file| file.parent()).collect();
    let line = |folder: &Path| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let count = entries.filter(|entry| entry.path().is_file()).count();
        let noun = if count == 1 { "file" } else { "files" };
        format!("{}: {count} {noun}", folder.display())
    };
    folders.into_iter().map(line).collect()
}

/// Makes the folder, or the first of `FOLDER-2`, `FOLDER-3` … that is not there or empty: nothing is ever written over.
fn free_folder(out: &Path) -> Result<PathBuf, CliError> {
    let numbered = (2..).map(|number| {
        let mut name = out.as_os_str().to_owned();
        name.push(format!("-{number}"));
        PathBuf::from(name)
    });
    let is_free = |folder: &PathBuf| check_free(folder).is_ok();
    let mut folders = std::iter::once(out.to_owned()).chain(numbered);
    let free = folders.find(is_free).unwrap_or_else(|| out.to_owned());
    std::fs::create_dir_all(&free).map_err(CliError::write(&free))?;
    Ok(free)
}
