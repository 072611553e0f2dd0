//! The files of a recording as one table: joined, rows chosen, columns added.

use std::collections::HashMap;

use csv::{ReaderBuilder, StringRecord, Writer};
use serde::Deserialize;

use super::error::ProveError;
use super::recordings::Recording;

/// Rows that belong to a recording: those with one of these texts in a column.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChosenRows {
    /// The column.
    pub column: String,
    /// Its texts.
    pub values: Vec<String>,
}

/// A column that is computed from two others.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComputedColumn {
    /// Its name.
    pub column: String,
    /// Names of dividend and divisor.
    pub quotient: [String; 2],
}

impl Recording {
    /// The texts of its files as one table, with the columns that it adds and without the rows that do not belong to it.
    ///
    /// # Errors
    /// [`ProveError::Form`] if a file is no table with commas, its columns differ from those of the first file, or a column is missing.
    pub fn table(&self, texts: &[String]) -> Result<String, ProveError> {
        let form = |problem: String| ProveError::Form {
            file: self.name.clone(),
            problem,
        };
        let mut out = Writer::from_writer(Vec::new());
        let mut first: Option<StringRecord> = None;
        for (number, text) in (1_usize..).zip(texts) {
            let mut reader = ReaderBuilder::new().from_reader(text.as_bytes());
            let header = reader.headers().map_err(|e| form(e.to_string()))?.clone();
            match &first {
                Some(first) if *first != header => {
                    return Err(form(format!(
                        "file {number} has other columns than the first"
                    )));
                }
                Some(_) => {}
                None => {
                    let added = self.computed.iter().map(|c| c.column.as_str());
                    let added = added.chain(self.file_column.as_deref());
                    out.write_record(header.iter().chain(added))
                        .map_err(|e| form(e.to_string()))?;
                    first = Some(header.clone());
                }
            }
            let places: HashMap<&str, usize> = header.iter().zip(0..).collect();
            let place = |name: &str| {
                let missing = || form(format!("file {number} has no column {name}"));
                places.get(name).copied().ok_or_else(missing)
            };
            let chosen = match &self.rows {
                Some(rows) => Some((place(&rows.column)?, &rows.values)),
                None => None,
            };
            let quotient = match &self.computed {
                Some(computed) => {
                    let [dividend, divisor] = &computed.quotient;
                    Some([place(dividend)?, place(divisor)?])
                }
                None => None,
            };
            for row in reader.records() {
                let row = row.map_err(|e| form(e.to_string()))?;
                if chosen.is_some_and(|(at, values)| !values.iter().any(|v| *v == row[at])) {
                    continue;
                }
                let mut added = Vec::new();
                if let Some(places) = quotient {
                    let [dividend, divisor] = places.map(|at| row[at].trim().parse::<f64>());
                    match (dividend, divisor) {
                        (Ok(dividend), Ok(divisor)) => added.push((dividend / divisor).to_string()),
                        _ => return Err(form(format!("a quotient of {row:?} needs numbers"))),
                    }
                }
                added.extend(self.file_column.as_ref().map(|_| number.to_string()));
                out.write_record(row.iter().chain(added.iter().map(String::as_str)))
                    .map_err(|e| form(e.to_string()))?;
            }
        }
        let bytes = out.into_inner().map_err(|e| form(e.to_string()))?;
        String::from_utf8(bytes).map_err(|e| form(e.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prove::recordings::Recordings;

    fn recording(keys: &str) -> Recording {
        let known = format!(
            "schema = \"stiffbench/recordings/1\"\n[[recording]]\nname = \"r\"\nfiles = []\nsource = \"\"\nlicence = \"\"\n\
             verdict = \"unknown\"\nalso-right = []\nphysics = []\nnot = []\nwhy = \"\"\n{keys}\n[recording.figures]\n"
        );
        let mut list = Recordings::parse("r.toml", &known).unwrap();
        list.recording.remove(0)
    }

    #[test]
    fn files_are_joined_rows_chosen_and_columns_added() {
        let keys = "file-column = \"file\"\nrows = { column = \"h\", values = [\"1.5\"] }\n\
                    computed = { column = \"s\", quotient = [\"a\", \"b\"] }";
        let texts = ["h,a,b\n1.5,1,2\n2,1,1\n", "h,a,b\n1.5,3,4\n"].map(str::to_owned);
        let table = recording(keys).table(&texts).unwrap();
        assert_eq!(table, "h,a,b,s,file\n1.5,1,2,0.5,1\n1.5,3,4,0.75,2\n");
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let texts = ["a,b\n1,2\n", "a,c\n1,2\n"].map(str::to_owned);
        let problem =
            |keys: &str, texts: &[String]| recording(keys).table(texts).unwrap_err().to_string();
        assert!(problem("", &texts).contains("file 2 has other columns"));
        let no_column = "rows = { column = \"h\", values = [] }";
        assert!(problem(no_column, &texts[..1]).contains("no column h"));
        let of_texts = "computed = { column = \"s\", quotient = [\"a\", \"b\"] }";
        let texts = ["a,b\n1,x\n".to_owned()];
        assert!(problem(of_texts, &texts).contains("needs numbers"));
    }
}
