//! docs/physics.md states what the program does.

use stiffbench_units_and_text::source_text::SourceText;

use super::{Effect, Law, LawKind, MistakePrior, ModelFile, PlaceKind};

fn document() -> &'static str {
    stiffbench_test_files::text("docs/physics.md")
}

/// The rows of the table of laws, as the program has them.
fn rows() -> Vec<String> {
    let parameters = |law: Law| -> String {
        let words: Vec<String> = law
            .parameters
            .iter()
            .map(|p| format!("`{}` ({}), {}", p.name, p.unit(), p.sign.in_words()))
            .collect();
        if words.is_empty() {
            "none".to_owned()
        } else {
            words.join("; ")
        }
    };
    Law::ALL
        .iter()
        .map(|&law| {
            let kind: PlaceKind = law.place_kind;
            format!(
                "| `{law}` | {}, `{}` | {} | {} |",
                kind.in_words(),
                kind.example(),
                parameters(law),
                law.equation.replace('|', "\\|")
            )
        })
        .collect()
}

/// The rows of the table of plausible ranges, as the program has them.
fn ranges() -> Vec<String> {
    let of_law = |law: &Law| {
        let law = *law;
        let parameters = law.parameters.iter();
        parameters.map(move |p| format!("| {} | `{}` | {} |", law.row, p.name, p.plausible.reason))
    };
    Law::ALL.iter().flat_map(of_law).collect()
}

/// The rows of the table of numbers made of parameters, as the program has them.
fn combinations() -> Vec<String> {
    let of_law = |law: &Law| {
        let spec = &law.combination.as_ref()?.spec;
        let (name, unit, word) = (spec.name, spec.unit(), spec.word);
        Some(format!("| {} | `{name}` | {unit} | {word} |", law.row))
    };
    Law::ALL.iter().filter_map(of_law).collect()
}

/// The rows of the table of mistakes, as the program has them.
fn mistakes() -> Vec<String> {
    let of_law = |law: &Law| {
        let size = law.parameters.first()?;
        let sd = match law.kind {
            LawKind::Setup(MistakePrior::Size(sd)) => format!("{sd} {}", size.unit()),
            LawKind::Setup(MistakePrior::Factor(sd)) => format!("{sd} of ln(1 + {})", size.name),
            LawKind::Setup(MistakePrior::Sizeless) | LawKind::Physics => return None,
        };
        let sd = sd.trim_end_matches(" 1");
        Some(format!("| {} | `{}` | {sd} |", law.row, size.name))
    };
    Law::ALL.iter().filter_map(of_law).collect()
}

/// Holds a table of the document against what the program says.
fn compare(head: &str, rows: &[String]) {
    let table = document().split_once(head).unwrap().1;
    let table = table.split_once("\n\n").unwrap().0;
    let rows = rows.join("\n");
    assert_eq!(
        table, rows,
        "the table of docs/physics.md is to be\n{rows}\n"
    );
}

#[test]
fn the_table_of_laws_is_the_programs() {
    let head = "| law | place | parameters | equation |\n| --- | --- | --- | --- |\n";
    compare(head, &rows());
}

#[test]
fn the_table_of_plausible_ranges_is_the_programs() {
    let head = "| law | parameter | plausible range and its reason |\n| --- | --- | --- |\n";
    compare(head, &ranges());
}

#[test]
fn the_table_of_numbers_made_of_parameters_is_the_programs() {
    let head = "| law | number | unit | meaning |\n| --- | --- | --- | --- |\n";
    compare(head, &combinations());
}

#[test]
fn the_table_of_mistakes_is_the_programs() {
    let head = "| law | parameter | scale |\n| --- | --- | --- |\n";
    compare(head, &mistakes());
}

#[test]
fn examples_of_the_command_line_are_effects() {
    let lines = document()
        .lines()
        .filter(|line| line.starts_with("| `") && !line.contains("refused"));
    let table = document().find("| example | meaning |").unwrap();
    let examples: Vec<&str> = lines
        .filter(|line| document().find(line).unwrap() > table)
        .flat_map(|line| line.split('|').nth(1).unwrap().split(", `"))
        .map(|cell| cell.trim().trim_matches('`'))
        .collect();
    assert!(examples.len() >= 11, "{examples:?}");
    for example in examples {
        example.parse::<Effect>().unwrap();
    }
    let refused = "gauge-periodic:amplitude=2um,period=0.15mm,phase=0";
    assert!(document().contains(refused) && refused.parse::<Effect>().is_err());
}

#[test]
fn the_example_of_a_model_is_one() {
    let text = stiffbench_test_files::example("docs/physics.md", "toml");
    let model = ModelFile::parse(&SourceText::new("docs/physics.md", text)).unwrap();
    assert_eq!((model.effects.len(), model.alternatives.len()), (2, 1));
}
