//! Help, manual pages and colour: every command shows examples, and they are commands of this program.

use clap::Command;
use stiffbench_test_files::desk::Ran;

use super::{assert_output_contains, desk, misuse};
use crate::support::{Contains, Json};

/// The commands that are shown and can be called without another one behind them.
fn leaves() -> Vec<(String, Command)> {
    let mut shown = super::names::shown();
    shown.retain(|(_, command)| !command.is_subcommand_required_set());
    assert!(shown.len() > 30, "only {} commands", shown.len());
    shown
}

/// The examples of a command, each in one line.
fn examples(command: &Command) -> Vec<String> {
    let help = command.get_after_help().map(ToString::to_string);
    let help = help.unwrap_or_default().replace("\\\n", " ");
    let (_, examples) = help.split_once("Examples:\n").unwrap_or_default();
    let examples = examples.split("\n\n").next().unwrap_or_default();
    examples
        .lines()
        .map(|line| line.trim().to_owned())
        .collect()
}

/// The words of the call of this program in an example, without redirections and what explains it.
fn words(example: &str) -> Vec<String> {
    let call = example.find("stiffbench").map_or("", |at| &example[at..]);
    let call = call.split(" > ").next().unwrap_or_default();
    let call = call.split(" | ").next().unwrap_or_default();
    // Two blanks or more stand before an explanation; a call that was broken off goes on after them.
    let explained = call.split("   ").next().unwrap_or_default();
    let call = if call.contains(" --displacement-instrument") {
        call
    } else {
        explained
    };
    let words = call.split_whitespace().map(|word| word.replace('\'', ""));
    words.collect()
}

#[test]
fn every_command_has_examples_and_each_can_be_typed() {
    for (name, command) in leaves() {
        let examples = examples(&command);
        assert!(!examples.is_empty(), "{name} has no example");
        let own = format!("stiffbench {name}");
        assert!(
            examples.iter().any(|example| example.contains(&own)),
            "{name}: {examples:?}"
        );
        for example in examples {
            let words = words(&example);
            let parsed = stiffbench::cli::command().try_get_matches_from(&words);
            assert!(parsed.is_ok(), "{name}: {example}: {}", parsed.unwrap_err());
        }
    }
}

#[test]
fn help_shows_examples_before_options_and_the_exit_codes_last() {
    let desk = desk();
    for command in ["fit", "session run", "config path", "man"] {
        let help = desk.run(&format!("{command} --help")).succeeds().stdout;
        let at = |part: &str| help.find(part).unwrap_or_else(|| panic!("{part}: {help}"));
        assert!(at("Usage:") < at("Examples:"), "{help}");
        assert!(at("Examples:") < at("--help"), "{help}");
        help.must_contain(&["--verbose", "--quiet"]);
    }
    let help = desk.run("--help").succeeds().stdout;
    let at = |part: &str| help.find(part).unwrap_or_else(|| panic!("{part}: {help}"));
    assert!(at("Examples:") < at("Commands:") && at("Commands:") < at("Exit codes: 0 done;"));
    let version = concat!("stiffbench ", env!("PROGRAM_VERSION"), "\n");
    assert_eq!(desk.run("--version").succeeds().stdout, version);
}

#[test]
fn every_command_argument_and_option_is_explained() {
    for (name, command) in super::names::shown() {
        let about = command.get_about().map(ToString::to_string);
        assert!(about.is_some_and(|about| !about.is_empty()), "{name}");
        for argument in command.get_arguments() {
            let help = argument.get_help().or(argument.get_long_help());
            let help = help.map(ToString::to_string).unwrap_or_default();
            assert!(
                argument.is_hide_set() || !help.is_empty(),
                "{name} {argument}"
            );
        }
    }
}

/// For the scripts of shells; ports are those of the computer.
#[test]
fn words_are_completed() {
    let desk = desk();
    let robots = desk.run("__complete robots").succeeds().stdout;
    assert!(robots.lines().any(|name| name == "hp-robot"), "{robots}");
    assert!(desk.data("__complete ports")["words"].is_array());
    let instruments = desk.data("__complete instruments");
    assert!(instruments["words"].list().len() > 10);
}

#[test]
fn every_command_has_a_manual_page() {
    let desk = desk();
    let data = desk.data("man --out pages");
    let files = data["files"].list();
    let names: Vec<String> = leaves()
        .iter()
        .map(|(name, _)| format!("pages/stiffbench-{}.1", name.replace(' ', "-")))
        .collect();
    for (name, file) in leaves().iter().map(|(name, _)| name).zip(&names) {
        assert!(files.contains(&file.as_str().into()), "{file}: {files:?}");
        let page = desk.read(file);
        assert!(page.contains(".SH EXAMPLES"), "{file}");
        assert!(page.contains(".SH \"EXIT STATUS\""), "{file}");
        assert!(page.contains(".SH SYNOPSIS"), "{file}");
        let last = name.rsplit(' ').next().unwrap();
        assert!(page.starts_with(".ie") && page.contains(last), "{file}");
    }
    assert!(desk.path("pages/stiffbench.1").exists());
    assert!(!desk.path("pages/stiffbench-prove.1").exists());
    let one = desk.run("man session run").succeeds().stdout;
    assert_eq!(one, desk.read("pages/stiffbench-session-run.1"));
    one.must_contain(&["stiffbench session run monday"]);
    let error = misuse(&desk, "man sesion");
    assert_output_contains(&error, &["did you mean session?"]);
}

#[test]
fn out_is_o_wherever_it_is() {
    for (name, command) in leaves() {
        for option in command.get_arguments() {
            let is_out = option.get_long() == Some("out");
            assert_eq!(is_out, option.get_short() == Some('o'), "{name} {option}");
        }
    }
    let desk = desk();
    desk.run("robot export --format csv -o arm.csv").succeeds();
    assert!(desk.path("arm.csv").exists());
}

/// Environment variables with their values.
type Variables = &'static [(&'static str, &'static str)];

/// Runs a command with variables, from those of colour only these.
fn coloured(arguments: &str, variables: &[(&str, &str)]) -> Ran {
    let desk = desk();
    let mut command = desk.command(arguments);
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    command.envs(variables.iter().copied());
    Ran::of(&mut command)
}

#[test]
fn colour_follows_the_option_then_the_variables_then_the_terminal() {
    let force: Variables = &[("CLICOLOR_FORCE", "1")];
    let both: Variables = &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")];
    let cases: [(&str, Variables, bool); 7] = [
        ("", &[], false),
        ("--color always", &[], true),
        ("--color=always", &[("NO_COLOR", "1")], true),
        ("--color auto", force, true),
        ("--color never", force, false),
        ("", both, false),
        ("", &[("CLICOLOR_FORCE", "0")], false),
    ];
    for (option, variables, wanted) in cases {
        let help = coloured(&format!("{option} fit --help"), variables);
        let case = format!("{option} {variables:?}");
        assert_eq!(help.stdout.contains('\u{1b}'), wanted, "help, {case}");
        let usage = coloured(&format!("{option} fit --nonsense"), variables);
        assert_eq!(usage.stderr.contains('\u{1b}'), wanted, "usage, {case}");
        let error = coloured(&format!("{option} fit nowhere"), variables).exits_with(11);
        assert_eq!(error.stderr.contains('\u{1b}'), wanted, "error, {case}");
        // What is for programs never has it.
        let json = coloured(&format!("{option} fit nowhere --json"), variables);
        assert!(!json.stdout.contains('\u{1b}'), "{}", json.stdout);
    }
    coloured("--color pink robot show", &[]).exits_with(2);
}
