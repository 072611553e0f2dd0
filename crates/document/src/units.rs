//! Units and signs: documents hold those of the page, and a terminal without UTF-8 shows ASCII for them.

/// A unit, as programs write it in ASCII, with its signs: `N/um` is N/µm, `urad/(N*m)` µrad/(N·m).
#[must_use]
pub fn sign_of(unit: &str) -> String {
    let ends = |c: char| !c.is_alphanumeric();
    let signed = |word: &str| match word.trim_end_matches(ends) {
        "um" | "urad" => word.replacen('u', "µ", 1),
        _ => word.to_owned(),
    };
    let words: String = unit.split_inclusive(ends).map(signed).collect();
    words.replace('*', "·")
}

/// A text whose units are in ASCII, as programs read them; its other signs stay.
#[must_use]
pub fn ascii_units(text: &str) -> String {
    text.replace('µ', "u").replace('·', "*")
}

/// A text with plain ASCII for the signs of this program. Words of others stay as they are.
#[must_use]
pub fn in_ascii(text: &str) -> String {
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
    fn units_have_their_signs() {
        for (ascii, signed) in [
            ("um", "µm"),
            ("N/um", "N/µm"),
            ("urad/(N*m)^2", "µrad/(N·m)^2"),
            ("lum", "lum"),
            ("1", "1"),
        ] {
            assert_eq!(sign_of(ascii), signed);
        }
    }

    #[test]
    fn signs_become_ascii_and_names_stay() {
        assert_eq!(
            in_ascii("K = 0.01 ± 0.002 N/µm at 21 °C, Müller"),
            "K = 0.01 +- 0.002 N/um at 21 degC, Müller"
        );
    }
}
