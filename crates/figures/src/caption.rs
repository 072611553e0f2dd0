//! Sentences that captions share.

use super::figure::{LegendEntry, LegendMark, Style};
use super::palette::{Colour, Marker};

/// What the bar of a point reaches over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bar {
    /// One standard deviation of the repeats on either side.
    StandardDeviation,
    /// One standard uncertainty of the mean on either side.
    StandardUncertainty,
    /// The 95 % interval.
    Interval95,
}

impl Bar {
    /// What the bars are and how many readings stand behind each point, as a sentence.
    pub(super) fn sentence(self, counts: impl IntoIterator<Item = usize>) -> String {
        let n = count_range(counts);
        match self {
            Self::StandardDeviation => {
                format!("Bars: ± one standard deviation of {n} repeats.")
            }
            Self::StandardUncertainty => {
                format!("Bars: ± one standard uncertainty of the mean of {n} readings.")
            }
            Self::Interval95 => format!("Bars: 95 % interval, from {n} repeats."),
        }
    }
}

/// `n = 5`, `n = 3 to 5`, or `n = 0` for no counts.
pub(super) fn count_range(counts: impl IntoIterator<Item = usize>) -> String {
    let span = counts.into_iter().fold(None, |span, n| {
        let (low, high) = span.unwrap_or((n, n));
        Some((low.min(n), high.max(n)))
    });
    // Non-breaking spaces keep the number with its sign.
    match span {
        None => "n\u{a0}=\u{a0}0".to_owned(),
        Some((low, high)) if low == high => format!("n\u{a0}=\u{a0}{low}"),
        Some((low, high)) => format!("n\u{a0}=\u{a0}{low}\u{a0}to\u{a0}{high}"),
    }
}

/// That hollow points are flagged, and how many there are, as a sentence; `None` for no such point.
pub(super) fn hollow_sentence(count: usize) -> Option<String> {
    match count {
        0 => None,
        1 => Some("The hollow point is flagged.".to_owned()),
        n => Some(format!("The {n} hollow points are flagged.")),
    }
}

/// That hollow points are of poses which the fit did not know, as a sentence; `None` for no such point.
pub(super) fn held_out_sentence(count: usize) -> Option<String> {
    if_any(
        count,
        format!("{count} hollow points: the fit did not know their pose."),
    )
}

/// A sentence about so many things, in the singular or the plural; `None` for none.
pub(super) fn counted_sentence(count: usize, subject: [&str; 2], rest: &str) -> Option<String> {
    let [one, many] = subject;
    if_any(count, format!("{} {rest}", counted(count, one, many)))
}

/// A count with what is counted: `1 point is`, `2 points are`.
pub(super) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A sentence about a count, if it is not zero.
pub(super) fn if_any(count: usize, sentence: impl Into<String>) -> Option<String> {
    (count > 0).then(|| sentence.into())
}

/// The sentences that apply, as one text.
pub(super) fn joined<const N: usize>(sentences: [Option<String>; N]) -> String {
    sentences
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(" ")
}

/// The legend entry that goes with hollow points; none if there are none.
pub(super) fn flagged_entry(count: usize) -> Vec<LegendEntry> {
    if count == 0 {
        return Vec::new();
    }
    vec![LegendEntry::new(
        "flagged",
        Style::new(Colour::INK, Marker::Circle),
        LegendMark::HollowPoint,
    )]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_caption_defines_the_bar_and_states_n() {
        assert_eq!(
            Bar::StandardDeviation
                .sentence([5, 5])
                .replace('\u{a0}', " "),
            "Bars: ± one standard deviation of n = 5 repeats."
        );
        assert_eq!(count_range([5, 3, 4]).replace('\u{a0}', " "), "n = 3 to 5");
        assert_eq!(count_range([]).replace('\u{a0}', " "), "n = 0");
        assert_eq!(hollow_sentence(0), None);
        assert_eq!(counted(1, "point is", "points are"), "1 point is");
        assert_eq!(counted(0, "point is", "points are"), "0 points are");
        assert_eq!(
            joined([Some("One.".to_owned()), None, if_any(2, "Two.")]),
            "One. Two."
        );
    }
}
