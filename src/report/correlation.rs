//! Correlations of fitted parameters for people.

use crate::fit::FactorCorrelations;
use crate::least_squares::STRONG_CORRELATION;

use stiffbench_document::{Document, Table};

/// The lower half of the correlation matrix, and strongly correlated pairs in words; empty for less than two parameters.
pub(super) fn correlations(found: Option<&FactorCorrelations>) -> Document {
    let mut document = Document::new();
    let Some(found) = found.filter(|found| found.names.len() > 1) else {
        return document;
    };
    let count = found.names.len();
    let rows = || found.names.iter().zip(&found.matrix).enumerate();
    document.table(
        Table::of(rows())
            .words("correlation", |(i, (name, _))| format!("{} {name}", i + 1))
            .numbers_each(
                (1..count).map(|number| number.to_string()),
                |(i, (_, row))| {
                    let below = row.iter().take(*i).map(|rho| format!("{rho:+.2}"));
                    let blank = std::iter::repeat(String::new());
                    below.chain(blank).take(count - 1).collect::<Vec<_>>()
                },
            ),
    );
    let mut pairs: Vec<String> = Vec::new();
    for (i, (name, row)) in rows() {
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
    document.paragraphs(pairs);
    document
}
