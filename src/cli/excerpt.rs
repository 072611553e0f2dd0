//! The line of a table that an error is about, with a mark under the value.

use std::fs;
use std::path::Path;

use crate::analysis::AnalysisError;
use crate::readings::ReadingsError;

/// Larger files are not read a second time, bytes.
const LARGEST: u64 = 64 << 20;

/// Characters of the line that are shown.
const WIDTH: usize = 100;

/// The line that an error is about, if its file still has it; with a caret under the value where only one place of the line has it.
pub(super) fn excerpt(report: &miette::Report) -> Option<String> {
    let error = match report.downcast_ref::<AnalysisError>() {
        Some(AnalysisError::Readings(error)) => error,
        _ => report.downcast_ref::<ReadingsError>()?,
    };
    let (file, value) = error.file_and_value()?;
    let number = error.line()?;
    let path = Path::new(file);
    let data = fs::metadata(path).ok()?;
    if !data.is_file() || data.len() > LARGEST {
        return None;
    }
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().nth(number as usize - 1)?;
    Some(marked(number, line, value))
}

/// A line with its number, and a caret under a value that it has once.
fn marked(number: u32, line: &str, value: Option<&str>) -> String {
    let line = line.replace('\t', " ");
    let at = value.and_then(|value| only_place(&line, value));
    // Of a long line the part around the value.
    let begin = at.map_or(0, |at| at.saturating_sub(WIDTH / 2));
    let shown: String = line.chars().skip(begin).take(WIDTH).collect();
    let head = format!("  {number} | ");
    let mut text = format!("{head}{shown}");
    if let (Some(at), Some(value)) = (at, value) {
        let margin = " ".repeat(head.len() - 2);
        let blanks = " ".repeat(at - begin);
        let carets = "^".repeat(value.chars().count().min(WIDTH / 2));
        text = format!("{text}\n{margin}| {blanks}{carets}");
    }
    text
}

/// The character at which a value stands, if it is a field of the line once.
fn only_place(line: &str, value: &str) -> Option<usize> {
    let joins = |c: char| c.is_alphanumeric() || "._+-".contains(c);
    let is_whole = |at: usize| {
        let before = line[..at].chars().next_back();
        let after = line[at + value.len()..].chars().next();
        !before.is_some_and(joins) && !after.is_some_and(joins)
    };
    if value.is_empty() {
        return None;
    }
    let mut places = line.match_indices(value).filter(|(at, _)| is_whole(*at));
    let (at, _) = places.next()?;
    places.next().is_none().then(|| line[..at].chars().count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_the_line_has_once_is_marked() {
        let line = "P1,x,1,abc,3.4";
        assert_eq!(
            marked(12, line, Some("abc")),
            "  12 | P1,x,1,abc,3.4\n     |        ^^^"
        );
        assert_eq!(marked(12, line, None), "  12 | P1,x,1,abc,3.4");
        // Twice, or only within a number: where it stands is not known.
        assert_eq!(marked(3, "1,1", Some("1")), "  3 | 1,1");
        assert_eq!(marked(3, "3.4", Some("4")), "  3 | 3.4");
    }

    #[test]
    fn of_a_long_line_the_part_around_the_value_is_shown() {
        let line = format!("{}µ,wrong,{}", "7".repeat(300), "8".repeat(300));
        let text = marked(1, &line, Some("wrong"));
        let (shown, mark) = text.split_once('\n').unwrap();
        assert!(shown.chars().count() < 2 * WIDTH);
        let at = shown.chars().position(|c| c == 'w');
        assert_eq!(mark.chars().position(|c| c == '^'), at);
    }
}
