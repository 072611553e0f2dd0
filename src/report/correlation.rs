//! Correlations of fitted parameters for people.

use crate::fit::FactorCorrelations;
use crate::least_squares::STRONG_CORRELATION;

use stiffbench_document::{Document, Table, numbers, words};

/// The lower half of the correlation matrix, and strongly correlated pairs in words; empty for less than two parameters.
pub(super) fn correlations(found: Option<&FactorCorrelations>) -> Document {
    let mut document = Document::new();
    let Some(found) = found.filter(|found| found.names.len() > 1) else {
        return document;
    };
    let count = found.names.len();
    let columns = (1..count).map(|number| numbers(number.to_string()));
    let mut rows = Table::new(std::iter::once(words("correlation")).chain(columns));
    let mut pairs: Vec<String> = Vec::new();
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
                pairs.push(format!(
                    "{other} and {name} can hardly be distinguished: correlation {rho:+.3}; {change} fits nearly as well."
                ));
            }
        }
    }
    if pairs.is_empty() {
        pairs.push(format!(
            "No pair has a correlation beyond {STRONG_CORRELATION}."
        ));
    }
    document.table(rows);
    for pair in pairs {
        document.paragraph(pair);
    }
    document
}
