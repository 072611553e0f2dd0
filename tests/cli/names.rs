//! One name for one meaning: the tree of commands and options.

use std::collections::BTreeMap;

use clap::{Arg, Command};

/// An option of several commands: its name, the forms of its value, and words of which one stands in every help text.
type Common = (
    &'static str,
    &'static [&'static str],
    &'static [&'static str],
);

/// Options that several commands have, each with one meaning.
#[rustfmt::skip]
const COMMON: &[Common] = &[
    ("allow-unverified", &[], &["unverified description"]),
    ("amends", &["NUMBER"], &["number of the report"]),
    ("answer-file", &["FILE"], &["answers to questions, given beforehand"]),
    ("answer", &["ID=VALUE"], &["answer to a question, given beforehand"]),
    ("branches", &["BRANCHES"], &["branches to use", "branches used"]),
    ("baud", &["BAUD"], &["baud rate"]),
    ("fit", &["FILE"], &["output of stiffbench fit --json"]),
    ("base-radius-mm", &["MM"], &["distance of the tool from the vertical through the base"]),
    ("floor-mm", &["MM"], &["lowest height of joints and tool"]),
    ("forbid-poses", &["POSES"], &["poses to exclude from the proposals"]),
    ("limit-margin-percent", &["PERCENT"], &["distance of a joint from its limits"]),
    ("bindings", &["FILE"], &["bindings file"]),
    ("capture", &["CAPTURE"], &["when a reading is taken"]),
    ("cell", &["CELL"], &["square of a figure"]),
    ("details", &["FILE"], &["statements on laboratory"]),
    ("decimal", &["DECIMAL"], &["decimal sign of the numbers"]),
    ("direction", &["DIRECTION"], &["direction of"]),
    ("directions", &["DIRECTIONS", "AXES|X,Y,Z"], &["directions"]),
    ("displacement", &["KEY=VALUE,..."], &["displacement gauge"]),
    ("displacement-axes", &["AXES"], &["base axes along which displacement gauges stand"]),
    ("displacement-calibration", &["TABLE"], &["displacement gauge"]),
    ("displacement-instrument", &["NAME|FILE"], &["description of the displacement gauge"]),
    ("displacement-u", &["U"], &["expanded uncertainty of the displacement gauge"]),
    ("displacement-unit", &["UNIT"], &["unit set at the displacement gauge", "unit of the displacement"]),
    ("effect", &["EFFECT"], &["effect in addition to the beams"]),
    ("emulated", &[], &["emulated bench"]),
    ("encoding", &["ENCODING"], &["encoding of the text"]),
    ("factors", &["NAME|FILE"], &["factor set of the robot"]),
    ("figures", &["FOLDER"], &["figure", "draw"]),
    ("format", &["FORMAT"], &["format"]),
    ("force", &["KEY=VALUE,..."], &["force gauge"]),
    ("force-calibration", &["TABLE"], &["force gauge"]),
    ("force-instrument", &["NAME|FILE"], &["description of the force gauge"]),
    ("force-tolerance-n", &["N"], &["tolerance of the operator"]),
    ("force-u", &["U"], &["expanded uncertainty of the force gauge"]),
    ("force-unit", &["UNIT"], &["unit set at the force gauge", "unit of the force"]),
    ("instrument-records", &["FILE"], &["records", "in the form of session.toml"]),
    ("instrument", &["NAME|FILE"], &["instrument"]),
    ("issued", &["DATE"], &["day of issue"]),
    ("line", &[], &["plain lines"]),
    ("load", &["FX,FY,FZ", "FX,FY,FZ[,MX,MY,MZ]"], &["load at the end"]),
    ("loads-n", &["N"], &["loads in n"]),
    ("map", &["WHAT=COLUMN"], &["columns"]),
    ("mechanism", &["NAME"], &["mechanism of the robot"]),
    ("model", &["FILE"], &["model with found physics"]),
    ("no-input", &[], &["never wait for an answer"]),
    ("no-figures", &[], &["no figures"]),
    ("noise-free", &[], &["without noise"]),
    ("out", &["FOLDER", "FILE"], &["folder", "file"]),
    ("port", &["PORT"], &["path of the"]),
    ("pose", &["POSE"], &["pose"]),
    ("parameter", &["NAME=free|fixed|tied:NAME|LOW..HIGH"], &["what a fit does with parameters"]),
    ("poses", &["POSES"], &["poses, comma-separated"]),
    ("procedure", &["NAME|FILE"], &["procedure file"]),
    ("protocols", &["FOLDER"], &["folder with your own descriptions"]),
    ("rated-load-n", &["N"], &["rated load"]),
    ("reason", &["TEXT"], &["why the report is replaced"]),
    ("repeats", &["REPEATS"], &["repeats"]),
    ("robot", &["NAME|FILE"], &["name of a shipped robot, or a robot file"]),
    ("samples", &["N"], &["number of"]),
    ("schema", &[], &["json schema"]),
    ("seconds", &["S"], &["how long to"]),
    ("seed", &["SEED"], &["seed of"]),
    ("set", &["VARIABLE=DEGREES"], &["value of a variable"]),
    ("sheet", &["NAME"], &["sheet of a spreadsheet"]),
    ("speed", &["SPEED"], &["relative to the real clock"]),
    ("stream", &[], &["stream its values"]),
    ("template", &["FILE", "NAME"], &["template"]),
    ("time-unit", &["UNIT"], &["unit of"]),
    ("train", &["TRAIN"], &["poses to fit"]),
    ("unit", &["UNIT"], &["unit that the gauge shows", "unit of the printed values"]),
    ("without", &["LAW"], &["laws to exclude"]),
    ("vary", &["VARIABLE,..."], &["variables to vary"]),
];

/// Names that would be a second one for a meaning that has one.
#[rustfmt::skip]
const SYNONYMS: &[(&str, &[&str])] = &[
    ("answer-file", &["answers"]),
    ("directions", &["axes"]),
    ("displacement-instrument", &["displacement-gauge"]),
    ("figures", &["plots", "figure", "with-figures"]),
    ("force-instrument", &["force-gauge"]),
    ("instrument", &["gauge", "device"]),
    ("instrument-records", &["instruments"]),
    // --format is that of a file for another program.
    ("json", &["output-format"]),
    ("load", &["end-load"]),
    ("mechanisms", &["mechanism-list"]),
    ("no-figures", &["without-figures"]),
    ("no-input", &["batch", "non-interactive", "yes"]),
    ("noise-distribution", &["noise-shape"]),
    ("out", &["output", "out-dir", "folder", "dir", "to"]),
    ("poses", &["pose-names"]),
    ("procedure", &["protocol", "plan"]),
    ("protocols", &["descriptions", "instrument-folder"]),
    ("quiet", &["silent"]),
    ("robot", &["robot-file"]),
    ("samples", &["number", "draws", "pose-count"]),
    ("seconds", &["duration"]),
    ("seed", &["random-seed"]),
    ("sensitivity", &["gradient"]),
    ("speed", &["pace"]),
    ("within", &["timeout"]),
];

/// The commands that are shown, with their names.
pub(super) fn shown() -> Vec<(String, Command)> {
    fn walk(command: &Command, name: &str, found: &mut Vec<(String, Command)>) {
        let below = command
            .get_subcommands()
            .filter(|below| !below.is_hide_set());
        for below in below {
            let name = format!("{name} {}", below.get_name());
            found.push((name.trim().to_owned(), below.clone()));
            walk(below, &name, found);
        }
    }
    let mut found = Vec::new();
    walk(&stiffbench::cli::command(), "", &mut found);
    assert!(found.len() > 30, "only {} commands", found.len());
    found
}

/// The options that are shown, by their long name, with the command that has them.
fn options() -> BTreeMap<String, Vec<(String, Arg)>> {
    let mut options = BTreeMap::<String, Vec<(String, Arg)>>::new();
    for (name, command) in shown() {
        for option in command
            .get_arguments()
            .filter(|option| !option.is_hide_set())
        {
            if let Some(long) = option.get_long() {
                let rows = options.entry(long.to_owned()).or_default();
                rows.push((name.clone(), option.clone()));
            }
        }
    }
    options
}

/// The form of an option's value; empty for a switch.
fn value(option: &Arg) -> String {
    if !option.get_action().takes_values() {
        return String::new();
    }
    let names = option.get_value_names().map(|names| {
        let names: Vec<&str> = names.iter().map(clap::builder::Str::as_str).collect();
        names.join(" ")
    });
    names.unwrap_or_else(|| option.get_id().as_str().to_uppercase())
}

#[test]
fn an_option_of_several_commands_has_one_meaning() {
    let mut complaints = Vec::new();
    for (long, rows) in options() {
        let row = COMMON.iter().find(|(name, ..)| *name == long);
        let Some((_, values, words)) = row else {
            if rows.len() > 1 {
                let commands: Vec<&str> = rows.iter().map(|(name, _)| name.as_str()).collect();
                complaints.push(format!(
                    "--{long} of {} stands in no table",
                    commands.join(", ")
                ));
            }
            continue;
        };
        for (command, option) in rows {
            let value = value(&option);
            let as_in_table = values.contains(&value.as_str()) || values.is_empty();
            if !as_in_table || (values.is_empty() && !value.is_empty()) {
                complaints.push(format!(
                    "{command} --{long} takes `{value}`, not {values:?}"
                ));
            }
            let help = option.get_help().map(ToString::to_string);
            let help = help.unwrap_or_default().to_lowercase();
            if !words.iter().any(|word| help.contains(word)) {
                complaints.push(format!(
                    "{command} --{long}: `{help}` has none of {words:?}"
                ));
            }
        }
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn a_meaning_has_one_name() {
    let options = options();
    let program = stiffbench::cli::command();
    let globals: Vec<&str> = program.get_arguments().filter_map(Arg::get_long).collect();
    for (settled, synonyms) in SYNONYMS {
        let is_there = options.contains_key(*settled) || globals.contains(settled);
        assert!(is_there, "--{settled} is no option");
        for synonym in *synonyms {
            if let Some(rows) = options.get(*synonym) {
                panic!(
                    "--{synonym} of {} is a second name for --{settled}",
                    rows[0].0
                );
            }
        }
    }
}

#[test]
fn the_page_of_commands_names_everything() {
    let page = include_str!("../../docs/commands.md");
    let has = |start: &str| page.lines().any(|line| line.starts_with(start));
    for (name, command) in shown() {
        let group = command.is_subcommand_required_set();
        assert!(group || has(&format!("| `{name}` |")), "{name}");
    }
    let (_, listed) = page.split_once("## Commands\n").unwrap();
    let listed = listed.split("\n## ").next().unwrap().lines();
    for name in listed.filter_map(|line| line.strip_prefix("| `")?.split('`').next()) {
        assert!(shown().iter().any(|(shown, _)| shown == name), "{name}");
    }
    for (long, values, _) in COMMON {
        // A bar in a cell of a table is written with a backslash.
        let values = values.join("` or `").replace('|', "\\|");
        let row = format!("| `--{long} {values}").trim_end().to_owned();
        assert!(has(&format!("{row}` |")), "{row}");
    }
}
