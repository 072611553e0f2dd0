//! The second session of the demonstration: play is concealed in a joint, the usual validation passes, and the diagnosis names it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::args::Global;
use crate::cli::failure::Failure;
use crate::cli::run_words;
use crate::report::{DemoConcealed, DemoFinding, Table};

/// What is concealed in the simulated bench; the analysis is not given it.
const CONCEALED: &str = "joint-backlash@A3:play=18urad,seat_moment=9N*m";

/// The size of the play, µrad.
const PLAY_URAD: f64 = 18.0;

/// Largest error in poses left out with which the usual validation passes, %: that which the paper reaches.
const LIMIT_PERCENT: f64 = 5.0;

/// What came of the second session.
pub(super) struct SecondSession {
    pub(super) report: DemoConcealed,
    pub(super) files: Vec<PathBuf>,
}

/// Simulates the session into a folder, fits, diagnoses, fits again with what was found, and writes the report.
pub(super) fn run(out: &Path, global: &Global) -> Result<SecondSession, Failure> {
    let folder = out.join("concealed-session");
    let diagnosis = out.join("diagnosis");
    let [session, pages] = [&folder, &diagnosis].map(|path| path.display().to_string());
    let simulate = [
        "simulate",
        &session,
        "--seed",
        "7",
        "--procedure",
        "load-unload",
    ];
    let concealed = ["--repeats", "5", "--effect", CONCEALED];
    run_words(&[simulate.as_slice(), &concealed].concat(), global)?;
    let fit = ["fit", &session, "--train", "P1,P3"];
    let without_law = run_words(&fit, global)?.into_data();
    let found = run_words(&["diagnose", &session, "--out", &pages], global)?.into_data();
    let model = diagnosis.join("model.toml").display().to_string();
    let with_law = run_words(&[fit.as_slice(), &["--model", &model]].concat(), global)?.into_data();
    let page = out.join("report.html");
    let file = page.display().to_string();
    run_words(
        &["report", &session, "--train", "P1,P3", "--out", &file],
        global,
    )?;
    let files = found["files"].as_array().into_iter().flatten();
    let files = files.filter_map(|file| Some(PathBuf::from(file.as_str()?)));
    let files = files.chain(["session.toml", "readings.csv"].map(|name| folder.join(name)));
    let files = files.chain([page.clone()]);
    Ok(SecondSession {
        files: files.collect(),
        report: DemoConcealed {
            session: folder,
            report: page,
            concealed: CONCEALED.to_owned(),
            limit_percent: LIMIT_PERCENT,
            left_out_error_percent: without_law["max_error_percent"].as_f64(),
            left_out_error_with_law_percent: with_law["max_error_percent"].as_f64(),
            verdict: text(&found["verdict"]),
            headline: text(&found["headline"]),
            findings: found["findings"]
                .as_array()
                .map_or_else(Vec::new, |findings| findings.iter().map(finding).collect()),
        },
    })
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

fn finding(found: &Value) -> DemoFinding {
    let play = &found["parameters"]["play"];
    DemoFinding {
        law: text(&found["physics"]),
        joint: found["place"]["joint"].as_str().map(str::to_owned),
        play_urad: play["value"].as_f64().map(|rad| rad * 1e6),
        true_play_urad: PLAY_URAD,
    }
}

/// The story of the session in a few lines.
pub(super) fn story(report: &DemoConcealed, diagnosis: &Path) -> String {
    let percent =
        |error: Option<f64>| error.map_or_else(|| "-".to_owned(), |e| format!("{e:.1} %"));
    let mut rows = Table::new(&["fit to P1 and P3, validated on P2 and P4", "largest error"]);
    let errors = [
        ("beams only", report.left_out_error_percent),
        (
            "beams and the law that was found",
            report.left_out_error_with_law_percent,
        ),
    ];
    for (model, error) in errors {
        rows.row([model.to_owned(), percent(error)]);
    }
    let passes = report
        .left_out_error_percent
        .is_some_and(|error| error <= report.limit_percent);
    let passes = if passes { "passes" } else { "does not pass" };
    let sizes = report.findings.iter().filter_map(|found| {
        let joint = found.joint.as_ref()?;
        let (size, truth) = (found.play_urad?, found.true_play_urad);
        Some(format!(
            "Play in joint {joint}: found {size:.1} urad, concealed {truth:.1} urad.\n"
        ))
    });
    let sizes: String = sizes.collect();
    format!(
        "A second session: the same robot, with play concealed in one joint (simulated: {session})\n\n\
         The usual validation {passes}: the largest error is {before}, the limit {limit:.0} %. The diagnosis names the play all the same:\n\n\
         \x20 {headline}\n\n{sizes}\n{table}\n\
         The page, its figures and the model with the law: {diagnosis}\n\
         The report to hand on, one file for any browser: {page}\n",
        session = report.session.display(),
        before = percent(report.left_out_error_percent),
        limit = report.limit_percent,
        headline = report.headline,
        table = rows.text(),
        diagnosis = diagnosis.display(),
        page = report.report.display(),
    )
}
