//! What is particular of LabVIEW measurement files: tags above each segment, and X columns that are computed.
//!
//! # Source
//! National Instruments, Specification for the LabVIEW Measurement File (.lvm).

use super::columns::{FileColumn, StatedUnit};
use super::records::TextRecord;
use crate::readings::DecimalSign;
use crate::readings::FieldDelimiter;

/// What ends the tags above a file and above each segment.
const END: &str = "***End_of_Header***";

/// Whether a text is such a file.
pub(super) fn is_labview(lines: &[&str]) -> bool {
    lines
        .first()
        .is_some_and(|line| line.trim_start().starts_with("LabVIEW Measurement"))
}

/// Delimiter and decimal sign that such a file states.
pub(super) fn stated(lines: &[&str]) -> (Option<FieldDelimiter>, Option<DecimalSign>) {
    if !is_labview(lines) {
        return (None, None);
    }
    let tag = |name: &str| {
        let rest = lines
            .iter()
            .take(40)
            .find_map(|line| line.strip_prefix(name))?;
        // The tag itself is delimited by the sign that it names.
        rest.chars()
            .next()
            .filter(|sign| matches!(sign, '\t' | ',' | ';'))
            .map(|_| &rest[1..])
    };
    let delimiter = tag("Separator").and_then(|word| match word.trim_matches(['\t', ',', ' ']) {
        "Tab" => Some(FieldDelimiter::Tab),
        "Comma" => Some(FieldDelimiter::Comma),
        _ => None,
    });
    let decimal = tag("Decimal_Separator").and_then(|word| match word.chars().next()? {
        '.' => Some(DecimalSign::Point),
        ',' => Some(DecimalSign::Comma),
        _ => None,
    });
    (delimiter, decimal)
}

/// Whether a record is a tag above a segment.
pub(super) fn is_tag(record: &TextRecord) -> bool {
    const TAGS: [&str; 10] = [
        "Channels",
        "Samples",
        "Date",
        "Time",
        "X_Dimension",
        "X0",
        "Delta_X",
        "Y_Unit_Label",
        "Test_Name",
        END,
    ];
    record
        .fields
        .get(0)
        .is_some_and(|first| TAGS.contains(&first))
        && record.fields.get(1) != Some("Force")
}

/// Tags above a segment.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SegmentTags {
    /// First X of each channel.
    x0: Vec<f64>,
    /// Step of X of each channel.
    delta_x: Vec<f64>,
    /// Unit of each channel.
    units: Vec<String>,
    /// Whether X is a time.
    is_time: bool,
}

impl SegmentTags {
    /// The tags above a header, in their order.
    ///
    /// # Arguments
    /// - `number`: reads a number of this file.
    pub(super) fn above(
        records: &[TextRecord],
        header: usize,
        mut number: impl FnMut(&str) -> Option<f64>,
    ) -> Self {
        let mut tags = Self::default();
        // The nearest above the names win; those of the file stand above its own end of header.
        let from = records[..header.saturating_sub(1)]
            .iter()
            .rposition(|record| record.fields.get(0) == Some(END))
            .map_or(0, |end| end + 1);
        for record in &records[from..header] {
            let values = || {
                record
                    .fields
                    .iter()
                    .skip(1)
                    .filter(|value| !value.is_empty())
            };
            match record.fields.get(0) {
                Some("X0") => tags.x0 = values().filter_map(&mut number).collect(),
                Some("Delta_X") => tags.delta_x = values().filter_map(&mut number).collect(),
                Some("Y_Unit_Label") => tags.units = values().map(str::to_owned).collect(),
                Some("X_Dimension") => tags.is_time = values().next() == Some("Time"),
                _ => {}
            }
        }
        tags
    }

    /// X of a sample of the first channel, counted from 0; `None` if the tags do not state it.
    pub(super) fn x(&self, sample: usize) -> Option<f64> {
        let step = self.delta_x.first()?;
        Some(self.x0.first().copied().unwrap_or(0.0) + sample as f64 * step)
    }

    /// Gives columns the units of the tags, and X columns of several channels a name each.
    pub(super) fn name(&self, columns: &mut [FileColumn]) {
        let mut channels = self.units.iter();
        let mut times = 0;
        for column in columns {
            let unit = match column.name.as_str() {
                "X_Value" => {
                    times += 1;
                    if times > 1 {
                        column.name = format!("X_Value {times}");
                        column.stem.clone_from(&column.name);
                    }
                    self.is_time.then(|| "s".to_owned())
                }
                "Comment" => None,
                _ => channels.next().cloned(),
            };
            if column.unit.is_none() && unit.is_some() {
                column.unit = unit;
                column.unit_from = Some(StatedUnit::Header);
            }
        }
    }
}
