//! Tables for other programs as CSV: UTF-8, `,`, `.`, line feeds, and no cell that a spreadsheet would take for a formula.

use crate::readings::escape_formula;

/// The records as CSV, the heads first.
#[must_use]
pub(crate) fn csv_text<'a, R: IntoIterator<Item = &'a str>>(
    records: impl IntoIterator<Item = R>,
) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        // Writing into memory cannot fail, and every row is as long as the heads.
        for text in record {
            let _ = writer.write_field(escape_formula(text).as_bytes());
        }
        let _ = writer.write_record(None::<&[u8]>);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}
