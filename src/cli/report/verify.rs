//! `stiffbench report verify`.

use std::path::{Path, PathBuf};

use crate::analysis::{ArgumentError, read_text};
use crate::cli::args::ModelArgs;
use crate::cli::compare::compared;
use crate::cli::data_args::DataArgs;
use crate::cli::{Failure, Global, Outcome};
use crate::report::page::{
    PageFormat, PageSettings, PageSource, PageTemplate, ReadPage, ReportPage, comparison_page,
    read_page, session_page,
};

use super::args::VerifyArgs;
use super::{open_settings, template};

/// Exit code for a report that is not as it was rendered.
const DIFFERS: u8 = 30;
/// Exit code for a report that was not compared as a whole: another program or template rendered it.
const NOT_COMPARED: u8 = 11;

/// Verifies a report from itself and, if sessions are named, from them.
pub(super) fn run(args: &VerifyArgs, global: &Global) -> Result<Outcome, Failure> {
    let name = args.page.display().to_string();
    let page = read_page(&name, read_text(&args.page)?)?;
    let template = template(args.template.as_deref(), PageFormat::Html)?;
    let is_named = !args.sessions.is_empty();
    let again = is_named.then(|| again(&page, args, page.settings(), &template, global));
    let check = page.check(&template, again.transpose()?.as_ref())?;
    let exit = match (check.good, check.differing) {
        (true, _) => 0,
        (false, 0) => NOT_COMPARED,
        (false, _) => DIFFERS,
    };
    let good = check.good;
    Ok(Outcome::new("report-verify", check.document(), check)
        .with_overdue(page.overdue())
        .with_failed(!good)
        .with_exit(exit))
}

/// The report worked out again from its sessions.
fn again(
    page: &ReadPage,
    args: &VerifyArgs,
    settings: &PageSettings,
    template: &PageTemplate,
    global: &Global,
) -> Result<ReportPage, Failure> {
    let reading = DataArgs::of_words(&settings.calibration)?;
    let mut options = open_settings(&reading, global)?;
    options.trust_csv |= settings.trust_csv;
    let hash = template.sha256();
    if page.is_comparison() {
        let [a, b] = args.sessions.as_slice() else {
            return ArgumentError::refuse(
                "SESSION",
                "the report compares two sessions",
                "name both, in the order of the report",
            );
        };
        let source = PageSource::open(&[a.clone(), b.clone()], &options)?;
        let (comparison, _, robots) = compared(&source.sessions()[0], &source.sessions()[1])?;
        let two = robots.is_some();
        return Ok(comparison_page(&source, &comparison, two, settings, &hash));
    }
    let source = PageSource::open_joined(&args.sessions, &options)?;
    let model = recorded(&args.model, settings);
    session_page(&source, &model.choice()?, settings, &hash)
}

/// The options of the report; those that are given now go first.
fn recorded(given: &ModelArgs, settings: &PageSettings) -> ModelArgs {
    // A page from elsewhere may name anything: a pipe, a device.
    let is_safe = |name: &&String| !Path::new(name).exists() || Path::new(name).is_file();
    let model = settings.model.as_ref().filter(is_safe).map(PathBuf::from);
    let robot = settings.robot.as_ref().filter(is_safe);
    ModelArgs {
        robot: given.robot.clone().or_else(|| robot.cloned()),
        mechanism: given
            .mechanism
            .clone()
            .or_else(|| settings.mechanism.clone()),
        factors: given.factors.clone().or_else(|| settings.factors.clone()),
        model: given.model.clone().or(model),
        effects: if given.effects.is_empty() {
            settings.effects.clone()
        } else {
            given.effects.clone()
        },
        default_robot: settings.default_robot.clone(),
    }
}
