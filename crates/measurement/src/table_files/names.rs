//! Names of columns, and the units in them.

use stiffbench_units_and_text::quantity::Kind;

use crate::readings::Conversion;

/// Whether a text is a unit of any kind that the program knows, capitals forgiven where they change nothing.
///
/// A `t` that does not stand in brackets is a time, as in `delta_t`, and no ton.
pub(super) fn is_unit(text: &str) -> bool {
    text != "t"
        && Kind::ALL
            .iter()
            .any(|kind| Conversion::from_unit(*kind, text).is_some())
}

/// Whether a text can only be a unit: one that is known, one in brackets, or one of the other words that machines write there.
pub(super) fn is_unit_cell(text: &str) -> bool {
    const OTHERS: [&str; 16] = [
        "-", "--", "1", "V", "mV", "mV/V", "A", "mA", "Hz", "mm/s", "mm/min", "cycles", "cycle",
        "segments", "count", "counts",
    ];
    in_brackets(text).is_some()
        || is_unit(text)
        || OTHERS.iter().any(|unit| unit.eq_ignore_ascii_case(text))
}

/// The text in brackets around it; `None` without brackets.
pub(super) fn in_brackets(text: &str) -> Option<&str> {
    let of = |open, close| Some(text.strip_prefix(open)?.strip_suffix(close)?.trim());
    let mut pairs = BRACKETS.into_iter();
    pairs
        .find_map(|(open, close)| of(open, close))
        .filter(|inner| {
            !inner.contains(|c| {
                BRACKETS
                    .iter()
                    .any(|(open, close)| c == *open || c == *close)
            })
        })
}

/// Brackets around a unit, those of full width among them.
const BRACKETS: [(char, char); 4] = [('[', ']'), ('(', ')'), ('（', '）'), ('［', '］')];

/// A header into the name and the unit in it: `Load (kN)`, `Kraft [N]`, `Weg in mm`, `F / N`, `force_N`, `Force N`.
pub(super) fn name_and_unit(header: &str) -> (&str, Option<&str>) {
    split(header).map_or((header, None), |(name, unit)| (name, Some(unit)))
}

fn split(header: &str) -> Option<(&str, &str)> {
    // Longer than any unit: a remark.
    const LONGEST_UNIT: usize = 8;
    // `Force (N) Run #1`: what stands behind the unit is of the name, and the whole names the column.
    for (open, close) in BRACKETS {
        let inner = header
            .split_once(open)
            .and_then(|(name, rest)| Some((name, rest.split_once(close)?)));
        if let Some((name, (unit, behind))) = inner
            && !name.trim().is_empty()
            && !behind.trim().is_empty()
            && is_unit(unit.trim())
        {
            return Some((header, unit.trim()));
        }
    }
    for (open, close) in BRACKETS {
        let Some(rest) = header.strip_suffix(close) else {
            continue;
        };
        let (name, unit) = rest.rsplit_once(open)?;
        let (name, unit) = (name.trim().trim_end_matches('_'), unit.trim());
        let short = unit.chars().count() <= LONGEST_UNIT && !unit.contains(char::is_whitespace);
        return (!name.is_empty() && !unit.is_empty() && (short || is_unit(unit)))
            .then_some((name, unit));
    }
    // What MATLAB makes of brackets: `Force_N_`.
    let header = header.trim_end_matches('_');
    // `strain_um_m` and `d_per_m` are in no unit that stands at their end.
    let is_ratio = |name: &str| {
        let last = name.rsplit(['_', ' ', '/']).next().unwrap_or(name);
        last == "per" || (last != name && is_unit(last))
    };
    [" in ", "/", ",", ":", "_", " "]
        .into_iter()
        .find_map(|mark| {
            // The longest unit that ends the name.
            header.match_indices(mark).find_map(|(place, mark)| {
                let name = header[..place].trim().trim_end_matches('_');
                let unit = header[place + mark.len()..].trim();
                (!name.is_empty() && is_unit(unit) && !is_ratio(name)).then_some((name, unit))
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_names() {
        for (header, name, unit) in [
            ("Load (kN)", "Load", Some("kN")),
            ("Kraft [N]", "Kraft", Some("N")),
            ("Weg in mm", "Weg", Some("mm")),
            ("Standardkraft / N", "Standardkraft", Some("N")),
            ("F/N", "F", Some("N")),
            ("Weg, mm", "Weg", Some("mm")),
            ("force_N", "force", Some("N")),
            ("Axial Force N", "Axial Force", Some("N")),
            ("Force (N) Run #1", "Force (N) Run #1", Some("N")),
            ("Load (Channel 1 of 2)", "Load (Channel 1 of 2)", None),
            ("Load (tonf)", "Load", Some("tonf")),
            ("Last [t]", "Last", Some("t")),
            ("Force_N_", "Force", Some("N")),
            ("Temperature__C_", "Temperature", Some("C")),
            ("力（N）", "力", Some("N")),
            ("変位［mm］", "変位", Some("mm")),
            ("Travel Microns", "Travel", Some("Microns")),
            ("run_", "run_", None),
            ("delta_t", "delta_t", None),
            ("strain_um_m", "strain_um_m", None),
            ("d_per_m", "d_per_m", None),
            ("strain [µm/m]", "strain", Some("µm/m")),
            ("Strain um/m", "Strain", Some("um/m")),
            ("stress_N/mm2", "stress", Some("N/mm2")),
            ("d", "d", None),
            ("N", "N", None),
            ("(N)", "(N)", None),
            ("run_no", "run_no", None),
            ("", "", None),
        ] {
            assert_eq!(name_and_unit(header), (name, unit), "{header}");
        }
    }

    #[test]
    fn cells_of_a_row_of_units() {
        for cell in ["(N)", "[mm]", "mm", "Sec", "kN", "-", "N-m", "°C", "%"] {
            assert!(is_unit_cell(cell), "{cell}");
        }
        for cell in ["Load", "1.5", "(a) and (b)", "run"] {
            assert!(!is_unit_cell(cell), "{cell}");
        }
    }
}
