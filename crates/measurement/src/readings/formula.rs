//! Texts that a spreadsheet would take for a formula: how they are written into a table for other programs, and read back.

use std::borrow::Cow;

/// Whether a spreadsheet would work a cell out, with or without signs of text before it. Numbers stay numbers.
fn is_formula(cell: &str) -> bool {
    let begins = cell.trim_start_matches(|c: char| c == '\'' || c.is_whitespace());
    begins.starts_with(['=', '+', '-', '@', '＝', '＋', '－', '＠'])
        && cell.trim().replace(',', ".").parse::<f64>().is_err()
}

/// A text as a cell that no spreadsheet works out: behind `'` if it would be a formula. [`unescape_formula`] gives the text back.
#[must_use]
pub fn escape_formula(text: &str) -> Cow<'_, str> {
    if is_formula(text) {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// The same for `readings.csv`, which holds texts as they are: only what reading would shorten is changed.
pub(super) fn keep_quote(text: &str) -> Cow<'_, str> {
    if text.starts_with('\'') {
        escape_formula(text)
    } else {
        Cow::Borrowed(text)
    }
}

/// The text of a cell of [`escape_formula`]; every other cell as it is.
#[must_use]
pub fn unescape_formula(cell: &str) -> &str {
    cell.strip_prefix('\'')
        .filter(|text| is_formula(text))
        .unwrap_or(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_is_read_back_and_none_begins_as_a_formula() {
        let formulas = [
            "=1+1", "+49 30", "-2.5 N", "@SUM(A1)", "'=1+1", "''-x", "'-2.5", " =1", "\t=1", "＝1",
            "-", "-1-1",
        ];
        let others = ["P1", "-2.5", "+1e3", "-2,5", "", "'", "'P1", "a=b"];
        for text in formulas.into_iter().chain(others) {
            let cell = escape_formula(text);
            assert_eq!(unescape_formula(&cell), text);
            assert_eq!(unescape_formula(&keep_quote(text)), text);
            assert_eq!(cell.len() > text.len(), formulas.contains(&text), "{cell}");
        }
    }
}
