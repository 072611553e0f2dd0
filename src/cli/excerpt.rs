//! The line of a file that an error is about, with a mark under the value.
//!
//! Errors in tables and configuration begin with their place: `a.csv, line 3` or `a.toml:3:14`. What stands in backquotes is what was found
//! there, the name of a column or a known name. Errors that bring their own excerpt are left alone.

use std::fs;
use std::path::Path;

/// Larger files are not read a second time, bytes.
const LARGEST: u64 = 64 << 20;

/// Characters of the line that are shown.
const WIDTH: usize = 100;

/// Where an error is.
#[derive(Debug, PartialEq, Eq)]
struct ErrorPlace<'a> {
    file: &'a str,
    line: usize,
    /// Character of the line, from 1.
    column: Option<usize>,
    rest: &'a str,
}

/// The line that an error is about, if its file still has it; with a caret under the value where its place is known.
pub(super) fn excerpt(report: &miette::Report) -> Option<String> {
    if report.source_code().is_some() {
        return None;
    }
    let message = report.to_string();
    let place = place(&message)?;
    let path = Path::new(place.file);
    let data = fs::metadata(path).ok()?;
    if !data.is_file() || data.len() > LARGEST {
        return None;
    }
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().nth(place.line.checked_sub(1)?)?;
    let line = line.replace('\t', " ");
    let mut found = place.rest.split('`').skip(1).step_by(2);
    let caret = match place.column {
        Some(column) => Some((column - 1, 1)),
        None => found.find_map(|value| Some((only_place(&line, value)?, value.chars().count()))),
    };
    Some(marked(place.line, &line, caret))
}

/// The place with which a message begins.
fn place(message: &str) -> Option<ErrorPlace<'_>> {
    let number = |text: &str| {
        let digits = text
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(text.len());
        let value: usize = text[..digits].parse().ok()?;
        Some((value, digits))
    };
    if let Some((file, rest)) = message.split_once(", line ") {
        let (line, digits) = number(rest)?;
        let (column, rest) = (None, &rest[digits..]);
        return Some(ErrorPlace {
            file,
            line,
            column,
            rest,
        });
    }
    // A path may have colons too.
    let places = message.match_indices(':').filter_map(|(at, _)| {
        let (line, digits) = number(&message[at + 1..])?;
        let behind = message[at + 1 + digits..].strip_prefix(':')?;
        let (column, digits) = number(behind)?;
        Some(ErrorPlace {
            file: &message[..at],
            line,
            column: Some(column.max(1)),
            rest: &behind[digits..],
        })
    });
    places.into_iter().next()
}

/// A line with its number, and carets under some of its characters: where they begin, from 0, and how many they are.
fn marked(number: usize, line: &str, caret: Option<(usize, usize)>) -> String {
    // Of a long line the part around the value.
    let begin = caret.map_or(0, |(at, _)| at.saturating_sub(WIDTH / 2));
    let shown: String = line.chars().skip(begin).take(WIDTH).collect();
    let head = format!("  {number} | ");
    let text = format!("{head}{shown}");
    let Some((at, length)) = caret else {
        return text;
    };
    let margin = " ".repeat(head.len() - 2);
    let blanks = " ".repeat(at - begin);
    let carets = "^".repeat(length.clamp(1, WIDTH / 2));
    format!("{text}\n{margin}| {blanks}{carets}")
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
    fn messages_begin_with_their_place() {
        let of_table =
            place("a, b.csv, line 3, column `force_N`: `abc`, expected a number").unwrap();
        assert_eq!(
            (of_table.file, of_table.line, of_table.column),
            ("a, b.csv", 3, None)
        );
        let of_toml = place("c:/x.toml:2:9: key `titel` is not known").unwrap();
        assert_eq!(
            (of_toml.file, of_toml.line, of_toml.column),
            ("c:/x.toml", 2, Some(9))
        );
        for without in [
            "",
            "a.csv: the file is empty",
            "at 12:30 it broke",
            "a, line x",
            ":1:",
            "x:1:0",
        ] {
            let found = place(without);
            assert!(
                found.is_none_or(|place| place.column == Some(1)),
                "{without}"
            );
        }
    }

    #[test]
    fn a_value_that_the_line_has_once_is_marked() {
        let line = "P1,x,1,abc,3.4";
        assert_eq!(only_place(line, "abc"), Some(7));
        assert_eq!(
            marked(12, line, Some((7, 3))),
            "  12 | P1,x,1,abc,3.4\n     |        ^^^"
        );
        assert_eq!(marked(12, line, None), "  12 | P1,x,1,abc,3.4");
        // Twice, or only within a number: where it stands is not known.
        assert_eq!(only_place("1,1", "1"), None);
        assert_eq!(only_place("3.4", "4"), None);
    }

    #[test]
    fn of_a_long_line_the_part_around_the_value_is_shown() {
        let line = format!("{}µ,wrong,{}", "7".repeat(300), "8".repeat(300));
        let text = marked(1, &line, Some((only_place(&line, "wrong").unwrap(), 5)));
        let (shown, mark) = text.split_once('\n').unwrap();
        assert!(shown.chars().count() < 2 * WIDTH);
        let at = shown.chars().position(|c| c == 'w');
        assert_eq!(mark.chars().position(|c| c == '^'), at);
    }
}
