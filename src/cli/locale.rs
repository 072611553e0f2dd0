//! What the locale can show.

use std::borrow::Cow;

use stiffbench_document::in_ascii;

/// The value of the locale's variables: `LC_ALL`, `LC_CTYPE`, `LANG`, the first that is set; `None` if none is.
pub(super) fn locale(variable: impl Fn(&str) -> Option<String>) -> Option<String> {
    let names = ["LC_ALL", "LC_CTYPE", "LANG"];
    let mut set = names.into_iter().filter_map(variable);
    set.find(|value| !value.is_empty())
}

/// Whether a locale has the characters of Unicode.
pub(super) fn is_utf8(locale: &str) -> bool {
    let locale = locale.to_ascii_lowercase();
    locale.contains("utf-8") || locale.contains("utf8")
}

/// A text with plain ASCII for the signs of this program, where the locale is one without UTF-8. Words of others stay as they are.
pub(super) fn in_locale(text: Cow<'_, str>) -> Cow<'_, str> {
    let locale = locale(|name| std::env::var(name).ok());
    if text.is_ascii() || locale.is_none_or(|locale| is_utf8(&locale)) {
        return text;
    }
    in_ascii(&text).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_variable_that_is_set_counts() {
        let of = |name: &str| match name {
            "LC_ALL" => Some(String::new()),
            "LC_CTYPE" => Some("de_DE.UTF-8".to_owned()),
            _ => Some("C".to_owned()),
        };
        assert!(is_utf8(&locale(of).unwrap()));
        assert_eq!(locale(|_| None), None);
    }
}
