//! Correlations of fitted parameters for people.

use std::fmt::Write;

use crate::fit::FactorCorrelations;
use crate::least_squares::STRONG_CORRELATION;

use super::text::AlignedTable;

/// The lower half of the correlation matrix, and strongly correlated pairs in words; empty for less than two parameters.
pub(super) fn correlation_text(found: Option<&FactorCorrelations>) -> String {
    let Some(found) = found.filter(|found| found.names.len() > 1) else {
        return String::new();
    };
    let count = found.names.len();
    let numbers: Vec<String> = (1..count).map(|number| number.to_string()).collect();
    let mut heads = vec!["correlation"];
    heads.extend(numbers.iter().map(String::as_str));
    let mut rows = AlignedTable::new(&heads);
    let mut pairs = String::new();
    for (i, (name, row)) in found.names.iter().zip(&found.matrix).enumerate() {
        let mut cells = vec![format!("{} {name}", i + 1)];
        cells.extend((0..count - 1).map(|j| {
            let rho = row.get(j).filter(|_| j < i);
            rho.map_or_else(String::new, |rho| format!("{rho:+.2}"))
        }));
        rows.row(cells);
        for (other, rho) in found.names[..i].iter().zip(row) {
            if rho.abs() > STRONG_CORRELATION {
                let change = if *rho > 0.0 {
                    "both larger, or both smaller,"
                } else {
                    "one larger and the other smaller"
                };
                let _ = writeln!(
                    pairs,
                    "{other} and {name} can hardly be distinguished: correlation {rho:+.3}; {change} fits nearly as well."
                );
            }
        }
    }
    if pairs.is_empty() {
        let _ = writeln!(
            pairs,
            "No pair has a correlation beyond {STRONG_CORRELATION}."
        );
    }
    format!("\n{}\n{pairs}", rows.text())
}
