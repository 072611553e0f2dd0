//! A folder of its own to run a program in, and what a run left behind.

use std::path::PathBuf;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own to run a program in.
#[derive(Debug)]
pub struct Desk {
    /// The folder.
    pub folder: TempDir,
    program: &'static str,
}

/// What a run of the program left behind.
#[derive(Debug)]
pub struct Ran {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Desk {
    /// A new one for a program, by its path.
    #[must_use]
    pub fn new(program: &'static str) -> Self {
        Self {
            program,
            folder: TempDir::new().unwrap(),
        }
    }

    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The text of a file in it.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// Writes a file in it, with its folders.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// Copies the files of a folder of the repository here.
    pub fn copy(&self, folder: &str) {
        super::goldens::copy(&super::repository().join(folder), self.folder.path());
    }

    /// Copies a program here. Another process does so: while this one has it open for writing, one that another test starts has it open as well, and the system runs no program that somebody may be writing.
    pub fn install(&self, program: &str, name: &str) {
        let mut command = Command::new("install");
        command.current_dir(&self.folder);
        command.args(["-m", "755", program, name]).unwrap();
    }

    /// The program, ready to be run; arguments are separated by blanks.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(self.program);
        command.current_dir(&self.folder);
        // It is for the tests, not for the program.
        command.env_remove(super::schemas::MODE);
        command.args(arguments.split_whitespace());
        command
    }

    /// Runs the program; arguments are separated by blanks.
    pub fn run(&self, arguments: &str) -> Ran {
        Ran::of(&mut self.command(arguments))
    }

    /// The `data` of a run with `--json` that succeeds.
    pub fn data(&self, arguments: &str) -> Value {
        let mut object = self.run(&format!("{arguments} --json")).succeeds().json();
        object["data"].take()
    }

    /// Runs a command that fails, with text and with JSON; the error object.
    pub fn refusal(&self, arguments: &str, exit: i32, code: &str) -> Value {
        let text = self.run(arguments).exits_with(exit);
        assert_eq!(text.stdout, "", "{arguments}");
        assert!(!text.stderr.is_empty(), "{arguments}");
        let object = self
            .run(&format!("{arguments} --json"))
            .exits_with(exit)
            .json();
        assert_eq!(object["ok"], false);
        assert_eq!(object["kind"], "error");
        assert_eq!(object["schema"], "stiffbench/error/1");
        let error = object["error"].clone();
        assert_eq!(error["code"], code, "{arguments}: {error}");
        assert_eq!(error["exit_code"], exit);
        assert!(
            !error["message"].as_str().unwrap().contains('\n'),
            "{error}"
        );
        error
    }
}

impl Ran {
    /// Runs a command.
    pub fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        Self {
            code: output
                .status
                .code()
                .expect("it was not stopped by a signal"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// It must end with exit code 0.
    pub fn succeeds(self) -> Self {
        self.exits_with(0)
    }

    /// It must end with this exit code, and without a panic.
    pub fn exits_with(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{}{}", self.stdout, self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }

    /// Standard output as one JSON object, whose `data` follow the published schema of their kind.
    pub fn json(&self) -> Value {
        let object = serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error}: {}", self.stdout));
        assert_follows_schema(&object);
        object
    }
}

/// The `data` of a result, or the `error` of a failure, follow the published schema of their kind.
pub fn assert_follows_schema(object: &Value) {
    // What is no result, for example a printed JSON Schema, has no kind.
    let Some(kind) = object["kind"].as_str() else {
        return;
    };
    let schema = object["schema"].as_str().unwrap_or_default();
    assert!(
        schema.starts_with(&format!("stiffbench/{kind}/")),
        "{schema}"
    );
    // A verification that found a difference is no failure of the program: it has data.
    let (content, may_fail) = match kind {
        "error" => ("error", true),
        _ => ("data", kind == "report-verify"),
    };
    assert!(object["ok"] == true || may_fail, "{object}");
    let folders = ["docs/schemas", "docs/schemas/validate"];
    let files = folders.map(|folder| format!("{folder}/{kind}.json"));
    let file = files
        .iter()
        .find(|file| super::repository().join(file).is_file());
    let schema = super::text(file.unwrap_or_else(|| panic!("{kind} has no schema")));
    let validator = jsonschema::validator_for(&serde_json::from_str(schema).unwrap()).unwrap();
    let errors = validator.iter_errors(&object[content]);
    let errors: Vec<String> = errors
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{kind}: {}", errors.join("\n"));
}

/// An error object whose message and help contain all words.
pub fn assert_output_contains(error: &Value, words: &[&str]) {
    let text = format!("{} {}", error["message"], error["help"]);
    for word in words {
        assert!(text.contains(word), "`{word}` is not in {text}");
    }
}
