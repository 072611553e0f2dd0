//! What the caller knows of a file.

use super::layout::TextEncoding;
use crate::readings::DecimalSign;
use crate::readings::FieldDelimiter;

/// What the caller knows of a file; the rest is found from the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TableFileOptions {
    /// What delimits fields.
    pub delimiter: Option<FieldDelimiter>,
    /// The decimal sign.
    pub decimal: Option<DecimalSign>,
    /// How the text is encoded.
    pub encoding: Option<TextEncoding>,
    /// The sheet, of a spreadsheet.
    pub sheet: Option<String>,
    /// Names of columns that the caller needs, as in the file or without their units.
    pub columns: Vec<String>,
    /// What is done about numbers such as `1.010`, where nothing in the file shows what the mark means.
    pub three_digits: ThreeDigits,
    /// Take cells such as `12.3 N`, and columns of units beside their numbers, as numbers with a unit: logs of gauges have them.
    pub units_in_cells: bool,
}

/// What is done about numbers with one mark and three digits behind it, where no other number shows the decimal sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ThreeDigits {
    /// A point is the decimal sign; a comma is refused.
    #[default]
    RefuseComma,
    /// Both are refused.
    Refuse,
    /// The mark is the decimal sign.
    Decimal,
}
