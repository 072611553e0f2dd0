//! `stiffbench explain`: what an error code, an exit code, a law or a verdict means, and what to do.

use clap::Args;

use crate::nearest::nearest;
use crate::physics::Law;
use crate::report::{ExplainResult, LawForm, TopicKind, TopicList, TopicReport};
use crate::shipped::{Explanation, error_explanations, verdict_explanations};

use super::failure::{EXIT_CODE_MEANINGS, exit_code_of};
use super::{CliError, Failure, Outcome};

/// Arguments of `explain`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench explain                               all names\n  stiffbench explain readings::wrong_unit          an error code, with or without stiffbench::\n  stiffbench explain joint-backlash                a law\n  stiffbench explain nothing-missing               a verdict\n  stiffbench explain 30                            an exit code"
)]
pub(super) struct ExplainArgs {
    /// Error code, exit code, law or verdict [default: the list of all]
    name: Option<String>,
}

/// What every error code begins with.
const PREFIX: &str = "stiffbench::";

/// Explains a name, or lists all.
pub(super) fn run(args: &ExplainArgs) -> Result<Outcome, Failure> {
    let Some(name) = &args.name else {
        let list = list();
        return Ok(Outcome::new(
            "explain",
            list.document(),
            ExplainResult::Topics(list),
        ));
    };
    let topic = topic(name)?;
    Ok(Outcome::new(
        "explain",
        topic.document(),
        ExplainResult::Topic(topic),
    ))
}

fn list() -> TopicList {
    let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    TopicList {
        errors: error_explanations().into_keys().collect(),
        laws: owned(Law::names()),
        verdicts: verdict_explanations().into_keys().collect(),
    }
}

fn topic(given: &str) -> Result<TopicReport, CliError> {
    let name = given.trim().trim_start_matches(PREFIX);
    if let Some(found) = error_explanations().swap_remove(name) {
        let exit = exit_code_of(&format!("{PREFIX}{name}"));
        return Ok(of_explanation(name, TopicKind::Error, Some(exit), found));
    }
    if let Some(found) = verdict_explanations().swap_remove(name) {
        return Ok(of_explanation(name, TopicKind::Verdict, None, found));
    }
    if let Some(topic) = of_exit_code(name) {
        return Ok(topic);
    }
    of_law(name).ok_or_else(|| unknown(given, name))
}

fn of_explanation(
    name: &str,
    kind: TopicKind,
    exit_code: Option<u8>,
    found: Explanation,
) -> TopicReport {
    TopicReport {
        name: name.to_owned(),
        kind,
        exit_code,
        cause: found.cause,
        remedy: found.remedy,
        example: found.example,
        forms: Vec::new(),
    }
}

/// An exit code, with the errors that end with it.
fn of_exit_code(name: &str) -> Option<TopicReport> {
    let code: u8 = name.parse().ok()?;
    let (_, means) = EXIT_CODE_MEANINGS
        .iter()
        .find(|(known, _)| *known == code)?;
    let errors = error_explanations();
    let errors: Vec<&str> = errors
        .keys()
        .map(String::as_str)
        .filter(|error| exit_code_of(&format!("{PREFIX}{error}")) == code)
        .collect();
    let remedy = match errors.as_slice() {
        [] => "See what the command printed.".to_owned(),
        errors => format!("Explain the code of the error: {}.", errors.join(", ")),
    };
    let found = Explanation {
        cause: format!("The command ended with {code}: {means}."),
        remedy,
        example: match errors.first() {
            Some(error) => format!("stiffbench explain {error}"),
            None => "stiffbench --help".to_owned(),
        },
    };
    Some(of_explanation(name, TopicKind::ExitCode, Some(code), found))
}

/// A law, from its definition.
fn of_law(name: &str) -> Option<TopicReport> {
    let laws: Vec<Law> = Law::named(name).collect();
    let first = *laws.first()?;
    let remedy = if first.is_setup() {
        "This is a mistake of the robot file or the set-up. Correct it there, then analyse the data again."
    } else {
        "Read on the page of diagnose how to check it by hand. Then use the model that diagnose wrote."
    };
    let found = Explanation {
        cause: first.words.explanation.to_owned(),
        remedy: remedy.to_owned(),
        example: format!("stiffbench diagnose my-session --without {name}"),
    };
    Some(TopicReport {
        forms: laws.into_iter().map(form).collect(),
        ..of_explanation(name, TopicKind::Law, None, found)
    })
}

fn form(law: Law) -> LawForm {
    let parameters = law.parameters.iter();
    let parameters = parameters.map(|parameter| {
        let (name, unit) = (parameter.name, parameter.unit());
        format!("{name} ({unit}), {}", parameter.sign.in_words())
    });
    LawForm {
        name: law.row.to_owned(),
        equation: law.equation.to_owned(),
        place: format!(
            "{}, {}",
            law.place_kind.in_words(),
            law.place_kind.example()
        ),
        parameters: parameters.collect(),
    }
}

/// The error with the nearest name; of a code also by its last part alone.
fn unknown(given: &str, name: &str) -> CliError {
    let all = list();
    let names = all.errors.iter().chain(&all.laws).chain(&all.verdicts);
    let names: Vec<&String> = names.collect();
    let last = |code: &str| code.rsplit("::").next().unwrap_or(code).to_owned();
    let same_end: Vec<&str> = names
        .iter()
        .filter(|known| last(known) == last(name) || known.split("::").next() == Some(name))
        .map(|known| known.as_str())
        .collect();
    let near = if same_end.is_empty() {
        nearest(name, names.iter().map(|known| known.as_str()))
            .into_iter()
            .collect()
    } else {
        same_end
    };
    let advice = if near.is_empty() {
        "stiffbench explain lists all names".to_owned()
    } else {
        format!(
            "is one of these meant: {}? stiffbench explain lists all names",
            near.join(", ")
        )
    };
    CliError::UnknownTopic {
        name: given.to_owned(),
        advice,
    }
}
