//! The second session of the demonstration: play is concealed in a joint, the usual validation passes, and the diagnosis names it.

use std::path::{Path, PathBuf};

use serde_json::Value;
use stiffbench_document::Document;

use crate::cli::args::Global;
use crate::cli::failure::Failure;
use crate::cli::run_words;
use crate::report::{DemoConcealed, DemoFinding};

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
pub(super) fn story(report: &DemoConcealed, diagnosis: &Path) -> Document {
    let percent =
        |error: Option<f64>| error.map_or_else(|| "-".to_owned(), |e| format!("{e:.1} %"));
    let (before, limit) = (report.left_out_error_percent, report.limit_percent);
    let passes = if before.is_some_and(|error| error <= limit) {
        "passes"
    } else {
        "does not pass"
    };
    let mut document = Document::of(format!(
        "A second session: the same robot, with play concealed in one joint (simulated: {})",
        report.session.display()
    ));
    document.paragraph(format!(
        "The usual validation {passes}: the largest error is {}, the limit {limit:.0} %. The diagnosis names the play all the same:",
        percent(before)
    ));
    document.item(&report.headline);
    for found in &report.findings {
        if let (Some(joint), Some(size)) = (&found.joint, found.play_urad) {
            document.paragraph(format!(
                "Play in joint {joint}: found {size:.1} µrad, concealed {:.1} µrad.",
                found.true_play_urad
            ));
        }
    }
    document.rows(
        [
            ("beams only", before),
            (
                "beams and the law that was found",
                report.left_out_error_with_law_percent,
            ),
        ],
        &[
            ("fit to P1 and P3, validated on P2 and P4", &|(model, _)| {
                (*model).to_owned()
            }),
            ("largest error", &|(_, error)| percent(*error)),
        ],
    );
    document.lines(format!(
        "The page, its figures and the model with the law: {}\nThe report to hand on, one file for any browser: {}",
        diagnosis.display(),
        report.report.display(),
    ));
    document
}
