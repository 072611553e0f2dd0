//! What the locale can show.

use std::borrow::Cow;

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

fn in_ascii(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        let sign = match c {
            '±' => "+-",
            'µ' | 'μ' => "u",
            '−' | '–' | '—' => "-",
            '…' => "...",
            '°' => "deg",
            '·' => "*",
            '×' => "x",
            '²' => "^2",
            '³' => "^3",
            '⁻' => "^-",
            '⁶' => "6",
            '¹' => "1",
            '√' => "sqrt",
            '∞' => "inf",
            '≤' => "<=",
            '≥' => ">=",
            '≈' => "~",
            '→' => "->",
            'α' => "alpha",
            'β' => "beta",
            'δ' => "delta",
            'ε' => "epsilon",
            'θ' => "theta",
            'ρ' => "rho",
            'σ' => "sigma",
            'φ' => "phi",
            'χ' => "chi",
            'Δ' => "Delta",
            'Σ' => "Sigma",
            'Ω' => "Ohm",
            '\u{a0}' => " ",
            _ => {
                plain.push(c);
                continue;
            }
        };
        plain.push_str(sign);
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_become_ascii_and_names_stay() {
        assert_eq!(
            in_ascii("K = 0.01 ± 0.002 N/µm at 21 °C, Müller"),
            "K = 0.01 +- 0.002 N/um at 21 degC, Müller"
        );
    }

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
