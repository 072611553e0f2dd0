//! Tables as text, and commands on them. Commands run in this process and print nothing.

use std::ffi::OsString;
use std::ops::Range;

use serde_json::Value;
use stiffbench::cli::json_of;
use tempfile::TempDir;

/// The JSON of a command that succeeds.
///
/// # Arguments
/// - `command`: words with blanks between them.
/// - `further`: words that may contain blanks.
pub(crate) fn json(command: &str, further: &[&str]) -> Value {
    run(command, further).unwrap_or_else(|error| panic!("{command}: {error}"))
}

fn run(command: &str, further: &[&str]) -> Result<Value, Value> {
    let words = command.split_whitespace().chain(further.iter().copied());
    json_of(words.map(OsString::from).collect::<Vec<_>>())
}

/// A table: names of columns, and rows of texts.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads CSV.
    pub(crate) fn parse(text: &str) -> Self {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let records = reader.records().map(Result::unwrap);
        let mut rows: Vec<Vec<String>> = records
            .map(|record| record.iter().map(str::to_owned).collect())
            .collect();
        Self {
            names: rows.remove(0),
            rows,
        }
    }

    /// The readings of `simulate`.
    ///
    /// # Arguments
    /// - `options`: words with blanks between them.
    /// - `effects`: what acts beside the beams, as `--effect` takes it.
    pub(crate) fn simulated(options: &str, effects: &[&str]) -> Self {
        Self::simulated_with_truth(options, effects).0
    }

    /// The same with the `data` of the command, which hold the truth.
    pub(crate) fn simulated_with_truth(options: &str, effects: &[&str]) -> (Self, Value) {
        let desk = TempDir::new().unwrap();
        let folder = desk.path().join("session");
        let effects: Vec<&str> = effects.iter().flat_map(|one| ["--effect", one]).collect();
        let command = format!("simulate {} {options}", folder.display());
        let truth = json(&command, &effects)["data"].take();
        let text = std::fs::read_to_string(folder.join("readings.csv")).unwrap();
        (Self::parse(&text), truth)
    }

    /// The table as CSV.
    pub(crate) fn text(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.names).unwrap();
        for row in &self.rows {
            writer.write_record(row).unwrap();
        }
        String::from_utf8(writer.into_inner().unwrap()).unwrap()
    }

    fn run(&self, command: &str, options: &str) -> Result<Value, Value> {
        let desk = TempDir::new().unwrap();
        let file = desk.path().join("readings.csv");
        std::fs::write(&file, self.text()).unwrap();
        run(&format!("{command} {} {options}", file.display()), &[])
    }

    /// The JSON of a command on the table, which lies in a folder of its own.
    pub(crate) fn json(&self, command: &str, options: &str) -> Value {
        let json = self.run(command, options);
        json.unwrap_or_else(|error| panic!("{command} {options}: {error}"))
    }

    /// The error of a command that refuses the table.
    pub(crate) fn refusal(&self, command: &str, options: &str) -> Value {
        self.run(command, options).unwrap_err()
    }

    /// The `data` of a command on the table.
    pub(crate) fn data(&self, command: &str, options: &str) -> Value {
        self.json(command, options)["data"].take()
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    fn column(&self, name: &str) -> usize {
        let place = self.names.iter().position(|one| one == name);
        place.unwrap_or_else(|| panic!("there is no column {name}"))
    }

    /// A cell of the table.
    pub(crate) fn word(&self, row: usize, column: &str) -> &str {
        &self.rows[row][self.column(column)]
    }

    /// A cell of the table as a number.
    pub(crate) fn number(&self, row: usize, column: &str) -> f64 {
        self.word(row, column).parse().unwrap()
    }

    /// Writes a cell.
    pub(crate) fn set(&mut self, row: usize, column: &str, value: &impl ToString) {
        let column = self.column(column);
        self.rows[row][column] = value.to_string();
    }

    /// Changes a number.
    pub(crate) fn change(&mut self, row: usize, column: &str, change: impl Fn(f64) -> f64) {
        self.set(row, column, &change(self.number(row, column)));
    }

    /// Some of the rows.
    pub(crate) fn filtered(&self, keep: impl Fn(&Self, usize) -> bool) -> Self {
        let rows = (0..self.len()).filter(|row| keep(self, *row));
        Self {
            names: self.names.clone(),
            rows: rows.map(|row| self.rows[row].clone()).collect(),
        }
    }

    /// The first repeats alone.
    pub(crate) fn repeats(&self, count: u32) -> Self {
        self.filtered(|table, row| table.number(row, "repeat") <= f64::from(count))
    }

    /// Rows that follow each other with the same texts in some columns.
    fn groups(&self, columns: &[&str]) -> Vec<Range<usize>> {
        let key = |row: usize| columns.iter().map(move |column| self.word(row, column));
        let starts = (0..self.len()).filter(|row| *row == 0 || !key(*row).eq(key(*row - 1)));
        let starts: Vec<usize> = starts.collect();
        let ends = starts.iter().skip(1).copied().chain([self.len()]);
        starts.iter().zip(ends).map(|(a, b)| *a..b).collect()
    }

    /// The rows of each run, in the order of the table.
    pub(crate) fn runs(&self) -> Vec<Range<usize>> {
        self.groups(&["pose", "direction", "repeat"])
    }

    /// The rows of each pose and direction, in the order of the table.
    pub(crate) fn cells(&self) -> Vec<Range<usize>> {
        self.groups(&["pose", "direction"])
    }

    /// Lines of rows in the file.
    pub(crate) fn lines(rows: Range<usize>) -> Vec<usize> {
        rows.map(|row| row + 2).collect()
    }
}
