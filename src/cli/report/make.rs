//! A report is made and written.

use std::path::{Path, PathBuf};

use stiffbench_document::Document;

use crate::analysis::{AnalysisError, ArgumentError, is_dash};
use crate::cli::data_args::DataArgs;
use crate::cli::export::check_free;
use crate::cli::figure_files::{check_new, write};
use crate::cli::outcome::shell_word;
use crate::cli::{Failure, Global, Outcome};
use crate::report::page::{
    PageFormat, PageSession, PageSettings, PageSource, ReportPage, comparison_page, session_page,
};
use crate::stiffness::Comparison;

use super::args::{MakeArgs, PageArgs};
use super::{open_settings, template, write_new};

/// Makes a report as the options say.
pub(super) fn run(args: &MakeArgs, global: &Global) -> Result<Outcome, Failure> {
    let format = args.format()?;
    let settings = PageSettings {
        robot: args.model.robot.clone(),
        default_robot: args.model.default_robot.clone(),
        mechanism: args.model.mechanism.clone(),
        factors: args.model.factors.clone(),
        model: (args.model.model.as_ref()).map(|path| path.display().to_string()),
        effects: args.model.effects.clone(),
        train: args.train.clone(),
        seed: args.seed,
        no_diagnosis: args.no_diagnosis,
        trust_csv: global.trust_csv,
        calibration: args.reading.words(),
        ..PageSettings::default()
    };
    let out = args.out.clone();
    let out = out.unwrap_or_else(|| usual_file(&args.data, format));
    let template = template(args.page.template.as_deref(), format)?;
    let settings = args.page.clone().into_settings(settings)?;
    let open = open_settings(&args.reading, global)?;
    check_new(&out)?;
    if let Some(folder) = &args.figures {
        check_free(folder)?;
    }
    let source = PageSource::open_joined(&args.data, &open)?;
    refuse_overdue(&source, global)?;
    let choice = args.model.choice()?;
    let page = session_page(&source, &choice, &settings, &template.sha256())?;
    page.check_details()?;
    refuse_early_issue(&page, args.page.issued)?;
    let text = template.render(&page)?.text;
    let to_output = is_dash(&out);
    if !to_output {
        write_new(&out, &text)?;
    }
    if let Some(folder) = &args.figures {
        for figure in page.figures.all() {
            let svg = figure
                .svg
                .replacen("<svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"", 1);
            write(&folder.join(format!("{}.svg", figure.name)), svg.as_bytes())?;
        }
    }
    let file = to_output.then_some(text);
    Ok(outcome(&page, (&args.data, &out), format, &source).with_file(file))
}

/// A report of the difference of two sessions, as a file.
pub(in crate::cli) fn write_comparison(
    data: [&Path; 2],
    comparison: &Comparison,
    two_robots: bool,
    (args, reading): (&PageArgs, &DataArgs),
    (out, global): (&Path, &Global),
) -> Result<ReportPage, Failure> {
    check_new(out)?;
    let settings = PageSettings {
        trust_csv: global.trust_csv,
        calibration: reading.words(),
        ..PageSettings::default()
    };
    let settings = args.clone().into_settings(settings)?;
    let template = template(args.template.as_deref(), PageFormat::Html)?;
    let source = PageSource::open(&data.map(Path::to_owned), &open_settings(reading, global)?)?;
    let page = comparison_page(
        &source,
        comparison,
        two_robots,
        &settings,
        &template.sha256(),
    );
    page.check_details()?;
    refuse_early_issue(&page, args.issued)?;
    write_new(out, &template.render(&page)?.text)?;
    Ok(page)
}

/// Under `--strict` no report is made of readings of a gauge whose calibration had run out.
fn refuse_overdue(source: &PageSource, global: &Global) -> Result<(), Failure> {
    let overdue = source.overdue();
    if global.strict && !overdue.is_empty() {
        let instruments = overdue.join(", ");
        return Err(AnalysisError::CalibrationOverdue { instruments }.into());
    }
    Ok(())
}

/// No report is issued before its last reading.
fn refuse_early_issue(
    page: &ReportPage,
    issued: Option<jiff::civil::Date>,
) -> Result<(), ArgumentError> {
    let last = page.sessions.iter().filter_map(PageSession::last_day).max();
    match (issued, last) {
        (Some(issued), Some(last)) if issued.to_string().as_str() < last => {
            Err(ArgumentError::new(
                format!("--issued {issued}"),
                format!("the last reading was taken on {last}"),
                "name that day or a later one",
            ))
        }
        _ => Ok(()),
    }
}

/// `report.html` in a session folder, or beside a file.
fn usual_file(data: &[PathBuf], format: PageFormat) -> PathBuf {
    let ending = format.ending();
    let Some(last) = data.last() else {
        return PathBuf::from(format!("report.{ending}"));
    };
    if last.is_dir() {
        return last.join(format!("report.{ending}"));
    }
    if is_dash(last) {
        return PathBuf::from(format!("report.{ending}"));
    }
    let stem = last.file_stem().unwrap_or_default().to_string_lossy();
    last.with_file_name(format!("{stem}-report.{ending}"))
}

fn outcome(
    page: &ReportPage,
    (data, out): (&[PathBuf], &Path),
    format: PageFormat,
    source: &PageSource,
) -> Outcome {
    let mut document = Document::of(format!("Report {}: {}", page.number, page.title));
    document.append(page.answer.clone());
    if !page.marks.is_empty() {
        document.paragraph(format!("Watermark: {}", page.marks.join(", ")));
    }
    let missing = page.missing();
    if !missing.is_empty() {
        document.paragraph("Missing according to ISO/IEC 17025:2017, 7.8.2.1, and marked on the page (report.toml states them, see --details-template):");
        for item in &missing {
            document.item(item);
        }
    }
    for line in &page.left_out {
        document.paragraph(format!("Not in the report: {line}"));
    }
    let data: Vec<String> = data
        .iter()
        .map(|path| shell_word(&path.display().to_string()))
        .collect();
    document.lines(format!("Written: {}", out.display()));
    let out = shell_word(&out.display().to_string());
    match format {
        PageFormat::Html => document.next(format!("report verify {out} {}", data.join(" "))),
        PageFormat::Markdown => {}
        PageFormat::Typst => document.lines(format!("Next: typst compile {out}")),
    }
    let mut warnings = source.warnings();
    warnings.extend(page.without_decision());
    let overdue = source.overdue();
    if !overdue.is_empty() {
        warnings.push(format!("calibration overdue: {}", overdue.join(", ")));
    }
    let stated = page.conformity.as_ref();
    let is_failed = stated.is_some_and(|stated| !stated.all_pass());
    Outcome::new("report", document, page)
        .with_inputs(source.inputs())
        .with_warnings(warnings)
        .with_strict_exit(u8::from(!missing.is_empty() || is_failed))
}
