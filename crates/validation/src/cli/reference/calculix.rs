//! `stiffbench-validate reference run`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use serde_json::json;

use super::args::ReferenceRunArgs;
use crate::cli::error::ValidationError;
use crate::reference::{
    PoseModel, ReferenceCell, ReferenceLoad, ReferenceModel, ReferenceRecord, RunBy,
    end_displacement_m,
};
use crate::report::ReferenceRun;
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::{CliError, Failure};
use stiffbench::cli::figure_files::write_again;
use stiffbench::cli::outcome::Outcome;
use stiffbench::cli::progress::progress;
use stiffbench::report::{Table, significant};
use stiffbench::session::write_whole;

use super::{LIST_FILE, MODEL_FILE, RECORD_FILE, read};

/// Runs every case of a model and keeps the displacements.
pub(crate) fn run_calculix(args: &ReferenceRunArgs, global: &Global) -> Result<Outcome, Failure> {
    let file = args.folder.join(MODEL_FILE);
    let model = ReferenceModel::parse(&file.display().to_string(), &read(&file)?)?;
    let mut record = ReferenceRecord {
        schema: ReferenceRecord::schema(),
        run: RunBy {
            program: version_of(&args.ccx)?,
            threads: args.threads,
            date: jiff::Timestamp::now().strftime("%Y-%m-%d").to_string(),
        },
        model,
        cells: Vec::new(),
    };
    let earlier = of_a_stopped_run(args, &record);
    let poses = record.model.poses.clone();
    let cases = poses
        .iter()
        .flat_map(|pose| pose.cases.iter().map(move |case| (pose, case)));
    let bar = progress(global, "CalculiX", cases.clone().count() as u64);
    for (pose, case) in cases {
        let cell = match earlier.iter().find(|cell| cell.is_of(pose, case)) {
            Some(cell) => cell.clone(),
            None => run_case(args, pose, case)?,
        };
        record.cells.push(cell);
        // After every case, so that a later failure loses nothing.
        let text = format!("{:#}\n", json!(record));
        let path = args.folder.join(RECORD_FILE);
        // The record is read, gains a case and is written back.
        write_whole(&path, text.as_bytes()).map_err(|source| CliError::Write { path, source })?;
        write_again(&args.folder.join(LIST_FILE), record.csv().as_bytes())?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let table = Table::of(&record.cells)
        .words("case", |cell| {
            format!("{} {} {} N", cell.pose, cell.direction, cell.force_n)
        })
        .numbers("displacement, um", |cell| {
            significant(cell.along_um().unwrap_or(f64::NAN), 6)
        })
        .numbers("time, s", |cell| format!("{:.2}", cell.seconds));
    let folder = args.folder.display();
    let kept = match earlier.len() {
        0 => String::new(),
        count => format!("\n{count} of them are of a run that was stopped.\n"),
    };
    let text = format!(
        "{}, {} thread(s)\n\n{}{kept}\nwrote {folder}/{RECORD_FILE} and {folder}/{LIST_FILE}, which fit takes as --reference.\n\
         Next: stiffbench-validate reference compare {folder}\n",
        record.run.program,
        record.run.threads,
        table.text()
    );
    let data = ReferenceRun {
        folder: args.folder.clone(),
        run: record.run,
        cells: record.cells,
    };
    Ok(Outcome::new("reference-run", text, data))
}

/// What a run of the same model by the same program computed before it was stopped; nothing if it came to its end.
fn of_a_stopped_run(args: &ReferenceRunArgs, now: &ReferenceRecord) -> Vec<ReferenceCell> {
    let file = args.folder.join(RECORD_FILE);
    let text = fs::read_to_string(&file).unwrap_or_default();
    let Ok(before) = ReferenceRecord::parse(&file.display().to_string(), &text) else {
        return Vec::new();
    };
    let by = |run: &RunBy| (run.program.clone(), run.threads);
    let same = before.model == now.model && by(&before.run) == by(&now.run);
    if same && !before.missing().is_empty() {
        before.cells
    } else {
        Vec::new()
    }
}

fn no_calculix(program: &Path) -> impl Fn(std::io::Error) -> ValidationError {
    move |source| ValidationError::NoCalculix {
        program: program.to_owned(),
        source,
    }
}

/// What `ccx -v` says.
fn version_of(program: &Path) -> Result<String, ValidationError> {
    let output = Command::new(program)
        .arg("-v")
        .stdin(Stdio::null())
        .output()
        .map_err(no_calculix(program))?;
    let words = String::from_utf8_lossy(&output.stdout);
    let version = words.lines().find_map(|line| line.split("Version ").nth(1));
    version.map_or_else(
        || {
            Err(ValidationError::NotCalculix {
                program: program.to_owned(),
            })
        },
        |version| Ok(format!("CalculiX ccx {}", version.trim())),
    )
}

/// Runs one case and reads the displacement of the end.
fn run_case(
    args: &ReferenceRunArgs,
    pose: &PoseModel,
    case: &ReferenceLoad,
) -> Result<ReferenceCell, Failure> {
    let of_job = |ending: &str| args.folder.join(format!("{}.{ending}", case.job));
    let dat = of_job("dat");
    // What an earlier run left must not pass for this one's.
    if dat.exists() {
        fs::remove_file(&dat).map_err(|source| CliError::Write {
            path: dat.clone(),
            source,
        })?;
    }
    let started = Instant::now();
    let Output { stdout, stderr, .. } = Command::new(&args.ccx)
        .arg(&case.job)
        .current_dir(&args.folder)
        .env("OMP_NUM_THREADS", args.threads.to_string())
        .stdin(Stdio::null())
        .output()
        .map_err(no_calculix(&args.ccx))?;
    let seconds = started.elapsed().as_secs_f64();
    write_again(&of_job("log"), &[stdout, stderr].concat())?;
    let text = fs::read_to_string(&dat).unwrap_or_default();
    let displacement_m = end_displacement_m(&dat.display().to_string(), &text)?;
    Ok(ReferenceCell {
        pose: pose.pose.clone(),
        direction: case.direction.clone(),
        force_n: case.force_n,
        displacement_um: displacement_m.map(|m| 1e6 * m),
        seconds,
    })
}
