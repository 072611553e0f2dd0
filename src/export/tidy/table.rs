//! A tidy table and its form as CSV.

use jiff::Timestamp;

use crate::readings::escape_formula;

/// A table in which each row is one observation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TidyTable {
    /// Its name, also that of its file or sheet.
    pub name: &'static str,
    /// What a row is.
    pub title: &'static str,
    /// The columns, in order.
    pub columns: Vec<TidyColumn>,
    /// The fields as they are written, with a decimal point; an empty one is missing.
    pub rows: Vec<Vec<String>>,
}

/// A column of a tidy table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TidyColumn {
    /// Name, with the unit at its end if there is one.
    pub name: String,
    /// What the fields are.
    pub kind: FieldKind,
    /// The unit; empty without one.
    pub unit: String,
    /// What it means, in words.
    pub meaning: String,
}

/// What the fields of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldKind {
    /// Text.
    Text,
    /// Whole numbers.
    Integer,
    /// Decimal numbers.
    Number,
    /// RFC 3339 times.
    DateTime,
}

impl FieldKind {
    /// Its name in Table Schema.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "string",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::DateTime => "datetime",
        }
    }

    fn holds(self, field: &str) -> bool {
        match self {
            Self::Text => true,
            Self::Integer => field.parse::<i64>().is_ok(),
            Self::Number => field.parse::<f64>().is_ok_and(f64::is_finite),
            Self::DateTime => field.parse::<Timestamp>().is_ok(),
        }
    }
}

impl TidyTable {
    /// A table. A column with a field that is not of its kind becomes text.
    #[must_use]
    pub fn new(
        name: &'static str,
        title: &'static str,
        mut columns: Vec<TidyColumn>,
        rows: Vec<Vec<String>>,
    ) -> Self {
        for (place, column) in columns.iter_mut().enumerate() {
            let mut fields = rows.iter().filter_map(|row| row.get(place));
            if !fields.all(|field| field.is_empty() || column.kind.holds(field)) {
                column.kind = FieldKind::Text;
            }
        }
        Self {
            name,
            title,
            columns,
            rows,
        }
    }

    /// The table with one more column of text, the same in every row.
    #[must_use]
    pub fn with_mark(mut self, name: &str, meaning: &str, text: &str) -> Self {
        self.columns.push(TidyColumn {
            name: name.to_owned(),
            kind: FieldKind::Text,
            unit: String::new(),
            meaning: meaning.to_owned(),
        });
        for row in &mut self.rows {
            row.push(text.to_owned());
        }
        self
    }

    /// The fields of a column; none if there is no such column.
    pub fn column(&self, name: &str) -> impl Iterator<Item = &str> {
        let place = self.columns.iter().position(|column| column.name == name);
        let rows = self.rows.iter();
        rows.filter_map(move |row| Some(row.get(place?)?.as_str()))
    }
}

/// The table as CSV: UTF-8, `,`, `.`, line feeds; a text that would be a formula stands behind `'`.
#[must_use]
pub fn csv(table: &TidyTable) -> Vec<u8> {
    let heads = table.columns.iter().map(|column| column.name.as_str());
    csv_of(heads, &table.rows).into_bytes()
}

/// Rows below their heads, each as long as them, as CSV of the same kind.
pub fn csv_of<'h>(heads: impl Iterator<Item = &'h str>, rows: &[Vec<String>]) -> String {
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    // Writing into memory cannot fail.
    let _ = writer.write_record(heads);
    for row in rows {
        let cells = row.iter().map(|text| escape_formula(text).into_owned());
        let _ = writer.write_record(cells);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str, kind: FieldKind) -> TidyColumn {
        TidyColumn {
            name: name.to_owned(),
            kind,
            unit: String::new(),
            meaning: "a column".to_owned(),
        }
    }

    #[test]
    fn a_column_with_another_field_becomes_text() {
        let columns = vec![
            column("count", FieldKind::Integer),
            column("force_N", FieldKind::Number),
            column("utc", FieldKind::DateTime),
        ];
        let row = |fields: [&str; 3]| fields.map(str::to_owned).to_vec();
        let good = row(["1", "-2.5", "2026-11-24T10:00:00.5Z"]);
        let table = TidyTable::new(
            "t",
            "a row",
            columns.clone(),
            vec![good.clone(), row([""; 3])],
        );
        assert_eq!(table.columns, columns);
        let bad = row(["1.5", "inf", "yesterday"]);
        let table = TidyTable::new("t", "a row", columns, vec![good, bad]);
        let kinds: Vec<FieldKind> = table.columns.iter().map(|column| column.kind).collect();
        assert_eq!(kinds, [FieldKind::Text; 3]);
        assert_eq!(table.column("force_N").collect::<Vec<_>>(), ["-2.5", "inf"]);
        assert_eq!(table.column("none").count(), 0);
    }

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        let rows = vec![vec!["a, \"b\"".to_owned()], vec![String::new()]];
        let table = TidyTable::new("t", "a row", vec![column("note", FieldKind::Text)], rows);
        let text = String::from_utf8(csv(&table)).unwrap();
        assert_eq!(text, "note\n\"a, \"\"b\"\"\"\n\"\"\n");
    }
}
