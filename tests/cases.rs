//! Inputs with a known right answer: each row of `fixtures/cases/*.toml` is a command line, where to look, and what must stand there.
//!
//! A row begins in an empty folder with the files of its case and may go on with further commands there. A row that asks for a number says
//! within which distance. `CASES` is the folder of the tables in commands of the shell.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};
use stiffbench_test_files::desk::assert_follows_schema;
use stiffbench_test_files::repository;
use tempfile::TempDir;

/// A row of a table: its first command stands in the row itself.
#[derive(Debug)]
struct Row {
    /// What the row shows.
    name: String,
    /// Folder beside the table whose content is copied to where the commands run.
    files: Option<String>,
    commands: Vec<Step>,
}

/// A command and what must come of it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Step {
    /// Shell commands that prepare the input; `stiffbench` is the program.
    prepare: Option<String>,
    /// Files that are written then.
    #[serde(default)]
    write: BTreeMap<String, String>,
    /// Changes to files after that.
    #[serde(default)]
    edits: Vec<Edit>,
    /// Environment variables.
    #[serde(default)]
    env: BTreeMap<String, String>,
    /// What stands on standard input.
    #[serde(default)]
    input: String,
    /// Arguments of the program, divided as a shell does.
    run: String,
    /// File that what is printed on standard output is written to.
    out: Option<String>,
    /// Exit code.
    #[serde(default)]
    exit: i32,
    /// Code of the error: nothing but it is printed, on standard error, and as an object with `--json`.
    error: Option<String>,
    /// Files that must be afterwards what they were before the command.
    #[serde(default)]
    unchanged: Vec<String>,
    /// What must be found.
    #[serde(default)]
    check: Vec<Check>,
}

/// A text of a file in place of another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Edit {
    file: String,
    to: String,
    old: String,
    new: String,
    /// Only where it stands first.
    #[serde(default)]
    first: bool,
}

/// One place and what stands there.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Check {
    /// `stdout`, `stderr`, `error` (message and help), `file:NAME`, or a JSON pointer into standard output or behind `file:NAME#`. In a pointer
    /// `*` is every element, `?` is any, `key=value` is the first with that value and `*key=value` each. Without it both outputs are searched.
    at: Option<String>,
    /// Only the first line with this.
    line: Option<String>,
    /// Only the line of this number, counted from 0.
    nth: Option<usize>,
    /// The value itself.
    is: Option<Value>,
    isnt: Option<Value>,
    one_of: Option<Vec<Value>>,
    /// The values of all elements.
    each: Option<Vec<Value>>,
    /// A number, and how far from it is right.
    near: Option<[f64; 2]>,
    above: Option<f64>,
    below: Option<f64>,
    /// `N PLACE`: the number is divided by, or reduced by, what stood there after the N-th command.
    per: Option<String>,
    less: Option<String>,
    /// Number of elements.
    count: Option<usize>,
    over: Option<usize>,
    under: Option<usize>,
    lines: Option<usize>,
    /// Texts that are part of it, wherever a line ends.
    contains: Option<Texts>,
    /// Texts one of which at least is part of it.
    any: Option<Vec<String>>,
    /// How often.
    times: Option<usize>,
    /// Texts that are not part of it, without regard to case.
    lacks: Option<Texts>,
    starts: Option<String>,
    /// `number`, `string`, `array`, `object` or `boolean`.
    kind: Option<String>,
    /// Whether nothing, or null, stands there.
    absent: Option<bool>,
    /// `N PLACE`: what stood at a place after the N-th command, counted from 0.
    equals: Option<String>,
    differs: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Texts {
    One(String),
    Several(Vec<String>),
}

impl Texts {
    fn all(&self) -> &[String] {
        match self {
            Self::One(text) => std::slice::from_ref(text),
            Self::Several(texts) => texts,
        }
    }
}

/// What a command left behind.
struct Left {
    stdout: String,
    stderr: String,
    json: Option<Value>,
    /// Files that a check of this command or of a later one asks for.
    files: BTreeMap<String, Option<String>>,
}

/// What stands at a pointer whose segments may be patterns.
fn at_pointer<'a>(json: &'a Value, pointer: &str) -> Vec<&'a Value> {
    let mut found = vec![json];
    for segment in pointer.split('/').skip(1) {
        let elements = |value: &'a Value| value.as_array().map_or(&[][..], Vec::as_slice);
        let has = |element: &Value, key: &str, wanted: &str| shown(&element[key]) == wanted;
        found = found
            .into_iter()
            .flat_map(|value| -> Vec<&Value> {
                let all = elements(value).iter();
                match (segment, segment.split_once('=')) {
                    ("*" | "?", _) => all.collect(),
                    (_, Some((key, wanted))) => match key.strip_prefix('*') {
                        Some(key) => all.filter(|one| has(one, key, wanted)).collect(),
                        None => all.filter(|one| has(one, key, wanted)).take(1).collect(),
                    },
                    _ => value.pointer(&format!("/{segment}")).into_iter().collect(),
                }
            })
            .collect();
    }
    found
}

impl Left {
    /// What stands at a place; of a pointer with patterns, everything.
    fn at(&self, place: Option<&str>) -> Vec<Value> {
        let Some(place) = place else {
            return vec![format!("{}{}", self.stdout, self.stderr).into()];
        };
        let pointed = |json: Option<&Value>, pointer: &str| -> Vec<Value> {
            let found = json.map_or_else(Vec::new, |json| at_pointer(json, pointer));
            found.into_iter().cloned().collect()
        };
        if let Some(file) = place.strip_prefix("file:") {
            let (file, pointer) = file.split_once('#').unwrap_or((file, ""));
            let text = self.files[file].as_ref();
            if place.contains('#') {
                let json = text.map(|text| serde_json::from_str::<Value>(text).unwrap());
                return pointed(json.as_ref(), pointer);
            }
            return text.into_iter().map(|text| text.as_str().into()).collect();
        }
        match place {
            "stdout" => vec![self.stdout.as_str().into()],
            "stderr" => vec![self.stderr.as_str().into()],
            "error" => {
                let error = self.json.as_ref().map(|json| &json["error"]);
                let text = error.map(|error| format!("{} {}", error["message"], error["help"]));
                text.into_iter().map(Value::from).collect()
            }
            _ => pointed(self.json.as_ref(), place.trim_end_matches('/')),
        }
    }
}

/// A value as text.
fn shown(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Check {
    /// What is wrong, if anything.
    fn complaint(&self, left: &Left, earlier: &[Left]) -> Option<String> {
        let place = self.at.as_deref();
        let mut found = left.at(place);
        found.retain(|value| !value.is_null());
        if self.line.is_some() || self.nth.is_some() {
            for value in &mut found {
                let text = shown(value);
                let has_part =
                    |line: &&str| self.line.as_ref().is_none_or(|part| line.contains(part));
                let line = text.lines().filter(has_part).nth(self.nth.unwrap_or(0));
                *value = line.unwrap_or_default().into();
            }
        }
        let before = |place: &String| -> Vec<Value> {
            let (number, place) = place.split_once(' ').unwrap();
            let number: usize = number.parse().unwrap();
            earlier.get(number).unwrap_or(left).at(Some(place))
        };
        let number = |place| {
            before(place)
                .first()
                .and_then(Value::as_f64)
                .unwrap_or(f64::NAN)
        };
        let per = self.per.as_ref().map_or(1.0, number);
        let less = self.less.as_ref().map_or(0.0, number);
        if self.per.is_some() || self.less.is_some() {
            for value in &mut found {
                *value = json!(value.as_f64().map(|value| value / per - less));
            }
        }
        let mut right = vec![
            self.absent.map(|absent| absent == found.is_empty()),
            self.count.map(|count| self.number_of(&found) == count),
            self.over.map(|count| self.number_of(&found) > count),
            self.under.map(|count| self.number_of(&found) < count),
            self.each.as_ref().map(|values| &found == values),
            self.equals.as_ref().map(|place| found == before(place)),
            self.differs.as_ref().map(|place| found != before(place)),
        ];
        let any = place.is_some_and(|place| place.contains("/?"));
        let holds = |value: &Value| self.of_each(value).into_iter().flatten().all(|one| one);
        let asked = self.of_each(&Value::Null).iter().any(Option::is_some);
        let several = place.is_some_and(|place| place.contains("/*"));
        right.push(asked.then_some(if any {
            found.iter().any(holds)
        } else {
            (several || !found.is_empty()) && found.iter().all(holds)
        }));
        let text: String = found.iter().map(shown).collect::<Vec<_>>().join("\n");
        assert!(
            right.iter().any(Option::is_some),
            "a check of {place:?} asks for nothing"
        );
        let short = text.chars().take(1500).collect::<String>();
        let wrong = right.into_iter().flatten().any(|one| !one);
        wrong.then(|| format!("not {self:?}\n    found: {short}"))
    }

    /// The elements of an array, or all that a pattern found.
    fn number_of(&self, found: &[Value]) -> usize {
        match found {
            [Value::Array(elements)] if !self.at.as_deref().unwrap_or("").contains("/*") => {
                elements.len()
            }
            _ => found.len(),
        }
    }

    /// Whether a value is what each question asks for.
    fn of_each(&self, value: &Value) -> Vec<Option<bool>> {
        let text = shown(value);
        let one_line = in_one_line(&text);
        let number = value.as_f64().unwrap_or(f64::NAN);
        let has = |part: &String| one_line.contains(&in_one_line(part));
        let lower = text.to_lowercase();
        let lacks = |part: &String| !lower.contains(&part.to_lowercase());
        let times = |part: &String, times| text.matches(part.as_str()).count() == times;
        let contains = |texts: &Texts| match self.times {
            Some(n) => texts.all().iter().all(|part| times(part, n)),
            None => texts.all().iter().all(has),
        };
        vec![
            self.is.as_ref().map(|wanted| is_same(value, wanted)),
            self.isnt.as_ref().map(|other| !is_same(value, other)),
            self.one_of.as_ref().map(|values| values.contains(value)),
            self.near
                .map(|[wanted, within]| (number - wanted).abs() <= within),
            self.above.map(|least| number >= least),
            self.below.map(|most| number <= most),
            self.lines.map(|lines| text.lines().count() == lines),
            self.contains.as_ref().map(contains),
            self.any.as_ref().map(|texts| texts.iter().any(has)),
            self.lacks
                .as_ref()
                .map(|texts| texts.all().iter().all(lacks)),
            self.starts.as_ref().map(|start| text.starts_with(start)),
            self.kind.as_ref().map(|kind| kind == kind_of(value)),
        ]
    }
}

/// Whether two values are the same; a number is the same with and without decimals.
fn is_same(value: &Value, wanted: &Value) -> bool {
    value == wanted
        || value
            .as_f64()
            .is_some_and(|one| Some(one) == wanted.as_f64())
}

fn kind_of(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    }
}

impl Row {
    /// A row from its table.
    fn new(mut table: toml::Table) -> Self {
        let mut text = |key: &str| table.remove(key).map(|value| value.try_into().unwrap());
        let (name, files) = (text("name").expect("a row has a name"), text("files"));
        let then: Option<Vec<Step>> = table.remove("then").map(|steps| steps.try_into().unwrap());
        let first: Step = table
            .try_into()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let commands = std::iter::once(first).chain(then.unwrap_or_default());
        Self {
            name,
            files,
            commands: commands.collect(),
        }
    }

    /// Files that checks ask for.
    fn asked_files(&self) -> Vec<String> {
        let checks = self.commands.iter().flat_map(|step| &step.check);
        let places = checks.flat_map(|check| {
            let earlier = [&check.equals, &check.differs];
            let earlier = earlier.into_iter().flatten();
            let earlier = earlier.filter_map(|place| place.split_once(' '));
            check
                .at
                .as_deref()
                .into_iter()
                .chain(earlier.map(|one| one.1))
        });
        let files = places.filter_map(|place| place.strip_prefix("file:"));
        let names = files.map(|file| file.split('#').next().unwrap().to_owned());
        names.collect()
    }

    /// Runs the row in a folder of its own; what is wrong with it.
    fn complaints(&self, tables: &Path) -> Vec<String> {
        let folder = TempDir::new().unwrap();
        let desk = folder.path().canonicalize().unwrap();
        if let Some(files) = &self.files {
            let from = tables.join(files);
            let copied = run(
                &desk,
                tables,
                &format!("cp -r '{}/.' .", from.display()),
                None,
            );
            assert!(copied.2 == Some(0), "{}: {copied:?}", self.name);
        }
        let asked = self.asked_files();
        let mut earlier: Vec<Left> = Vec::new();
        let mut complaints = Vec::new();
        for step in &self.commands {
            let (left, wrong) = step.left(&desk, tables, &asked);
            let checks = step.check.iter();
            let wrong = wrong
                .into_iter()
                .chain(checks.filter_map(|check| check.complaint(&left, &earlier)));
            complaints.extend(
                wrong.map(|text| format!("{}\n    stiffbench {}\n    {text}", self.name, step.run)),
            );
            earlier.push(left);
        }
        complaints
    }
}

/// Runs a script where the program is found; outputs and exit code.
fn run(
    desk: &Path,
    tables: &Path,
    script: &str,
    step: Option<&Step>,
) -> (String, String, Option<i32>) {
    let program = Path::new(env!("CARGO_BIN_EXE_stiffbench"));
    let folder = program.parent().unwrap().display();
    let mut command = Command::new("sh");
    command.args(["-ec", script]).current_dir(desk);
    command.env(
        "PATH",
        format!("{folder}:{}", std::env::var("PATH").unwrap()),
    );
    command.env("CASES", tables);
    command.envs(step.into_iter().flat_map(|step| &step.env));
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let input = step.map_or("", |step| step.input.as_str()).to_owned();
    let mut stdin = child.stdin.take().unwrap();
    // A program that does not read it has closed it.
    let _ = stdin.write_all(input.as_bytes());
    drop(stdin);
    let ran = child.wait_with_output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&ran.stdout), text(&ran.stderr), ran.status.code())
}

impl Step {
    /// Runs it; what it left behind, and what is wrong with how it ended.
    fn left(&self, desk: &Path, tables: &Path, asked: &[String]) -> (Left, Vec<String>) {
        if let Some(script) = &self.prepare {
            let ran = run(desk, tables, script, None);
            assert!(ran.2 == Some(0), "{script}: {ran:?}");
        }
        for (name, text) in &self.write {
            let path = desk.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        for Edit {
            file,
            to,
            old,
            new,
            first,
        } in &self.edits
        {
            let text = fs::read_to_string(desk.join(file)).unwrap();
            assert!(text.contains(old), "{old} is not in {file}: {text}");
            let count = if *first { 1 } else { usize::MAX };
            fs::write(desk.join(to), text.replacen(old, new, count)).unwrap();
        }
        let contents = || -> Vec<_> {
            let files = self.unchanged.iter();
            files.map(|file| fs::read(desk.join(file)).ok()).collect()
        };
        let before = contents();
        let command = format!("stiffbench {}", self.run);
        let (stdout, stderr, code) = run(desk, tables, &command, Some(self));
        let mut wrong = Vec::new();
        if code != Some(self.exit) || stderr.contains("panicked") {
            wrong.push(format!("ends with {code:?}: {stdout}{stderr}"));
        }
        if contents() != before {
            wrong.push(format!("{:?} changed", self.unchanged));
        }
        let mut json: Option<Value> = serde_json::from_str(&stdout).ok();
        if let Some(error) = &self.error {
            let (printed, _, code_of_json) =
                run(desk, tables, &format!("{command} --json"), Some(self));
            let object: Value = serde_json::from_str(&printed).unwrap_or_default();
            let error_of = &object["error"];
            let one_line = error_of["message"]
                .as_str()
                .is_some_and(|text| !text.contains('\n'));
            if !stdout.is_empty()
                || stderr.is_empty()
                || code_of_json != Some(self.exit)
                || !one_line
                || error_of["code"] != **error
                || error_of["exit_code"] != self.exit
                || object["ok"] != false
            {
                wrong.push(format!(
                    "not refused with {error}: {stdout}{stderr}{printed}"
                ));
            }
            json = Some(object);
        }
        if let Some(object) = &json {
            assert_follows_schema(object);
        }
        if let Some(file) = &self.out {
            fs::write(desk.join(file), &stdout).unwrap();
        }
        let read = |name: &String| {
            // Of a folder it is only asked whether it is there.
            let path = desk.join(name);
            let bytes = fs::read(&path).ok().or(path.is_dir().then(Vec::new));
            (
                name.clone(),
                bytes.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()),
            )
        };
        let files = asked.iter().map(read).collect();
        (
            Left {
                stdout,
                stderr,
                json,
                files,
            },
            wrong,
        )
    }
}

#[test]
fn every_input_with_a_known_answer_gets_it() {
    let tables = repository().join("fixtures/cases");
    let files = fs::read_dir(&tables)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let rows: Vec<Row> = files
        .filter(|file| file.extension().is_some_and(|ending| ending == "toml"))
        .flat_map(|file| {
            let text = fs::read_to_string(&file).unwrap();
            let table: BTreeMap<String, Vec<toml::Table>> =
                toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            table.into_values().flatten().map(Row::new)
        })
        .collect();
    let only = std::env::var("STIFFBENCH_CASE").unwrap_or_default();
    let complaints: Vec<String> = rows
        .par_iter()
        .filter(|row| row.name.contains(&only))
        .flat_map_iter(|row| row.complaints(&tables))
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
