//! The commands of the README, and of what it says of maps, run as they stand there.

use std::process::Command;

/// Starts of lines that are commands of this program, with what stands before its arguments.
const STARTS: [&str; 3] = [
    "stiffbench",
    "cargo run --release --",
    "cargo run --release --locked --",
];

/// Commands of the ```console blocks in order: the words after the program's name. A line that ends in a backslash goes on in the next.
fn commands(markdown: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut in_block = false;
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("```") {
            in_block = !in_block && line.trim() == "```console";
            continue;
        }
        let Some(command) = line.trim_start().strip_prefix("$ ").filter(|_| in_block) else {
            continue;
        };
        let mut command = command.to_owned();
        while let Some(begun) = command.strip_suffix('\\') {
            command = format!("{begun} {}", lines.next().unwrap_or("").trim());
        }
        found.extend(arguments(&command));
    }
    found
}

/// Words after the program's name, without a comment at the end; `None` for other programs.
fn arguments(command: &str) -> Option<Vec<String>> {
    let rest = STARTS
        .iter()
        .filter_map(|start| command.strip_prefix(start))
        .filter(|rest| rest.is_empty() || rest.starts_with(' '))
        .min_by_key(|rest| rest.len())?;
    let rest = rest.split(" #").next().unwrap_or(rest);
    // Parts with odd numbers stand between quotes: there a shell changes nothing, apart from what begins with a dollar.
    let unsupported = rest.split('"').enumerate().any(|(part, text)| {
        let special: &[char] = if part % 2 == 0 {
            &['|', '>', '<', '\'', '$', '*', '(']
        } else {
            &['$', ' ', '\\', '`']
        };
        text.contains(special)
    });
    assert!(
        !unsupported && rest.matches('"').count() % 2 == 0,
        "`{command}`: this test passes words on as they are, without a shell"
    );
    let words = rest.split_whitespace();
    Some(words.map(|word| word.replace('"', "")).collect())
}

#[test]
fn commands_of_the_readme_run() {
    commands_run("README.md");
}

#[test]
fn commands_for_maps_run() {
    commands_run("docs/stiffness-map.md");
}

/// Runs the commands of a file one after another in a new folder.
fn commands_run(file: &str) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let markdown = std::fs::read_to_string(path).unwrap();
    let commands = commands(&markdown);
    assert!(
        !commands.is_empty(),
        "{file} shows no command in a ```console block"
    );
    let folder = tempfile::tempdir().unwrap();
    for command in commands {
        let output = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
            .args(&command)
            .current_dir(&folder)
            .output()
            .unwrap();
        assert!(
            output.status.success(),
            "stiffbench {}: {}\n{}",
            command.join(" "),
            output.status,
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

#[test]
fn commands_are_found_in_console_blocks_only() {
    let markdown = "```console\n$ stiffbench fit a --train P1,P3  # judged elsewhere\nbeam.Iy 1\n$ cargo run --release -- demo\n$ cargo test\n\
                    $ stiffbench plot robot \\\n    --out r\n$ stiffbenchmark\n```\n```toml\n$ stiffbench no\n```\n$ stiffbench no\n";
    let words: Vec<String> = commands(markdown)
        .iter()
        .map(|command| command.join(" "))
        .collect();
    assert_eq!(words, ["fit a --train P1,P3", "demo", "plot robot --out r"]);
}
