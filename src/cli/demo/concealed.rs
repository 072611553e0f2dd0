//! The second session of the demonstration: play is concealed in a joint, the usual validation passes, and the diagnosis names it.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use stiffbench_document::{Document, Table};

use crate::cli::run_words;
use crate::cli::{CliError, Failure, Global};
use crate::report::{DemoConcealed, DemoFinding, DiagnosisSummary, FindingReport, FitReport};

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
    let without_law: FitReport = result(&fit, global)?;
    let found: DiagnosisSummary = result(&["diagnose", &session, "--out", &pages], global)?;
    let model = diagnosis.join("model.toml").display().to_string();
    let with_law: FitReport = result(&[fit.as_slice(), &["--model", &model]].concat(), global)?;
    let page = out.join("report.html");
    let file = page.display().to_string();
    run_words(
        &["report", &session, "--train", "P1,P3", "--out", &file],
        global,
    )?;
    let files = found.files.unwrap_or_default().into_iter();
    let files = files.chain(["session.toml", "readings.csv"].map(|name| folder.join(name)));
    let files = files.chain([page.clone()]);
    Ok(SecondSession {
        files: files.collect(),
        report: DemoConcealed {
            session: folder,
            report: page,
            concealed: CONCEALED.to_owned(),
            limit_percent: LIMIT_PERCENT,
            left_out_error_percent: without_law.max_error_percent,
            left_out_error_with_law_percent: with_law.max_error_percent,
            verdict: found.verdict.to_string(),
            headline: found.headline,
            findings: found.findings.iter().map(finding).collect(),
        },
    })
}

/// The result of a command.
fn result<T: DeserializeOwned>(words: &[&str], global: &Global) -> Result<T, Failure> {
    let data = run_words(words, global)?.into_data();
    Ok(T::deserialize(data).map_err(|error| CliError::Internal {
        problem: error.to_string(),
    })?)
}

fn finding(found: &FindingReport) -> DemoFinding {
    DemoFinding {
        law: found.law.law.to_string(),
        joint: found.law.place.joint().map(str::to_owned),
        play_urad: found.parameters.get("play").map(|play| play.value * 1e6),
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
    document.table(
        Table::of([
            ("beams only", before),
            (
                "beams and the law that was found",
                report.left_out_error_with_law_percent,
            ),
        ])
        .words("fit to P1 and P3, validated on P2 and P4", |(model, _)| {
            *model
        })
        .numbers("largest error", |(_, error)| percent(*error)),
    );
    document.lines(format!(
        "The page, its figures and the model with the law: {}\nThe report to hand on, one file for any browser: {}",
        diagnosis.display(),
        report.report.display(),
    ));
    document
}
