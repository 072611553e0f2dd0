//! Lines to records.

use csv::StringRecord;

use crate::readings::FieldDelimiter;

/// Lines that a quoted field may span; a quote that stays open longer is taken as a character.
const LONGEST_QUOTE: usize = 64;

/// Fields of a line, or of several where a quoted field holds line ends.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TextRecord {
    /// Line of the file, from 1; row of a sheet.
    pub(super) line: u32,
    /// Its fields, without blanks around them.
    pub(super) fields: StringRecord,
    /// The same split at two and more blanks, where single blanks delimit: names may have blanks inside.
    pub(super) wide: Option<StringRecord>,
    /// Whether a quote opens in it and never closes.
    pub(super) is_open: bool,
    /// Whether it starts with `#`.
    pub(super) is_comment: bool,
    /// Units that were taken off its fields, with the place of the field.
    pub(super) units: Vec<(usize, String)>,
}

impl TextRecord {
    pub(super) fn new(line: u32, fields: StringRecord) -> Self {
        Self {
            line,
            fields,
            wide: None,
            is_open: false,
            is_comment: false,
            units: Vec::new(),
        }
    }

    /// Number of fields up to the last that is not empty.
    pub(super) fn len(&self) -> usize {
        let fields = self.fields.iter();
        fields
            .enumerate()
            .filter(|(_, f)| !f.is_empty())
            .last()
            .map_or(0, |(i, _)| i + 1)
    }

    pub(super) fn is_blank(&self) -> bool {
        self.fields.iter().all(str::is_empty)
    }
}

/// The lines of a text; a carriage return alone ends a line where no line feed does.
pub(super) fn lines(text: &str) -> Vec<&str> {
    let lines: Vec<&str> = if text.contains('\n') {
        text.split('\n')
            .map(|line| line.strip_suffix('\r').unwrap_or(line))
            .collect()
    } else {
        text.split('\r').collect()
    };
    match lines.as_slice() {
        [rest @ .., ""] => rest.to_vec(),
        _ => lines,
    }
}

/// Splits lines into records, all or the first few.
pub(super) fn split(lines: &[&str], delimiter: FieldDelimiter, most: usize) -> Vec<TextRecord> {
    let mut records = Vec::new();
    let mut next = 0;
    while next < lines.len() && records.len() < most {
        let line = next as u32 + 1;
        let text = lines[next];
        next += 1;
        if text.starts_with('#') {
            let mut record = TextRecord::new(line, StringRecord::from(vec![text]));
            record.is_comment = true;
            records.push(record);
            continue;
        }
        let record = match delimiter.sign() {
            None => at_blanks(line, text),
            Some(sign) => match quoted(text, &lines[next..], sign) {
                Some((fields, further)) => {
                    next += further;
                    TextRecord::new(line, fields)
                }
                None => TextRecord {
                    is_open: true,
                    ..TextRecord::new(line, text.split(sign).map(str::trim).collect())
                },
            },
        };
        records.push(record);
    }
    records
}

fn at_blanks(line: u32, text: &str) -> TextRecord {
    let fields = text.split_whitespace().map(|field| field.trim_matches('"'));
    let mut record = TextRecord::new(line, fields.collect());
    if record.fields.len() > 1 {
        let parts = text.split(['\t']).flat_map(|part| part.split("  "));
        let wide = parts
            .map(|part| part.trim().trim_matches('"'))
            .filter(|part| !part.is_empty());
        record.wide = Some(wide.collect());
    }
    record
}

/// Fields of a line and of those after it as long as a quote is open, and how many these are; `None` if it never closes.
fn quoted(first: &str, further: &[&str], sign: char) -> Option<(StringRecord, usize)> {
    let mut fields = StringRecord::new();
    if !first.contains('"') {
        fields.extend(first.split(sign).map(str::trim));
        return Some((fields, 0));
    }
    let mut line = first;
    let mut taken = 0;
    let mut field = String::new();
    loop {
        // At the start of a field.
        let start = line.trim_start_matches(|c: char| c.is_whitespace() && c != sign);
        field.clear();
        if let Some(mut rest) = start.strip_prefix('"') {
            loop {
                if let Some(end) = rest.find('"') {
                    field.push_str(&rest[..end]);
                    rest = &rest[end + 1..];
                    match rest.strip_prefix('"') {
                        Some(after) => {
                            field.push('"');
                            rest = after;
                        }
                        None => break,
                    }
                } else {
                    field.push_str(rest);
                    field.push('\n');
                    rest = further.get(taken).filter(|_| taken < LONGEST_QUOTE)?;
                    taken += 1;
                }
            }
            line = rest;
        } else {
            line = start;
        }
        let end = line.find(sign);
        field.push_str(&line[..end.unwrap_or(line.len())]);
        fields.push_field(field.trim());
        match end {
            Some(end) => line = &line[end + sign.len_utf8()..],
            None => return Some((fields, taken)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(text: &str, delimiter: FieldDelimiter) -> Vec<(u32, Vec<String>)> {
        let records = split(&lines(text), delimiter, usize::MAX);
        let own = |record: &TextRecord| record.fields.iter().map(str::to_owned).collect();
        records
            .iter()
            .map(|record| (record.line, own(record)))
            .collect()
    }

    #[test]
    fn quotes_protect_delimiters_and_line_ends() {
        let found = fields(
            "a, \"b,\"\"c\"\"\" ,\r\n\"two\r\nlines\",d\r\ne",
            FieldDelimiter::Comma,
        );
        assert_eq!(
            found[0],
            (1, vec!["a".into(), "b,\"c\"".into(), String::new()])
        );
        assert_eq!(found[1], (2, vec!["two\nlines".into(), "d".into()]));
        assert_eq!(found[2].0, 4);
    }

    #[test]
    fn a_quote_that_stays_open_is_a_character() {
        let found = split(
            &lines("a,5\"\n\"b,1\n2,3\n"),
            FieldDelimiter::Comma,
            usize::MAX,
        );
        assert_eq!(&found[0].fields[1], "5\"");
        assert!(!found[0].is_open && found[1].is_open && !found[2].is_open);
        assert_eq!(found[2].line, 3);
    }

    #[test]
    fn old_line_ends_and_blanks() {
        assert_eq!(lines("a\rb\r"), ["a", "b"]);
        assert_eq!(lines(""), [] as [&str; 0]);
        let found = split(
            &lines("Axial Force   Time\n 1.5  2\n"),
            FieldDelimiter::Blanks,
            9,
        );
        let wide = found[0].wide.as_ref().unwrap();
        assert_eq!(wide.iter().collect::<Vec<_>>(), ["Axial Force", "Time"]);
        assert_eq!(found[1].fields.iter().collect::<Vec<_>>(), ["1.5", "2"]);
    }
}
