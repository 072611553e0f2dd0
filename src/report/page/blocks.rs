//! What the terminal prints, in the characters of a page.

use stiffbench_document::Document;

/// A document whose units have the micro sign.
#[must_use]
pub(super) fn for_a_page(document: Document) -> Document {
    document.map_texts(with_micro_signs)
}

/// A text whose units `um` and `urad`, as a terminal prints them, have the micro sign.
#[must_use]
pub(super) fn with_micro_signs(text: &str) -> String {
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    // `um.csv` is the name of a file.
    let is_ending = |behind: &str| {
        let ending = behind.strip_prefix('.');
        ending.is_some_and(|ending| is_word(ending.chars().next()))
    };
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, found)) = rest.split_once('u') {
        out.push_str(before);
        let begins = !is_word(out.chars().next_back());
        let mut ends = ["rad", "m"]
            .iter()
            .filter_map(|unit| found.strip_prefix(unit));
        let is_unit =
            begins && ends.any(|behind| !is_word(behind.chars().next()) && !is_ending(behind));
        out.push(if is_unit { 'µ' } else { 'u' });
        rest = found;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_units_get_the_micro_sign() {
        for (plain, set) in [
            (
                "play 18.5 urad, up to 31.4 um at the end",
                "play 18.5 µrad, up to 31.4 µm at the end",
            ),
            (
                "K, N/um; maximum, spread_um, um_x, humus",
                "K, N/µm; maximum, spread_um, um_x, humus",
            ),
            ("line 3 of um.csv: 4 um.", "line 3 of um.csv: 4 µm."),
            ("um", "µm"),
            ("", ""),
        ] {
            assert_eq!(with_micro_signs(plain), set);
        }
    }
}
