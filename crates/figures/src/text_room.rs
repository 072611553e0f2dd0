//! Ranges of horizontal axes that leave room for texts beside marks.

use super::range::finite_ends;
/// A mark with texts beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    /// Where the mark stands, as the axis is spread: the logarithm on a logarithmic axis.
    pub(super) place: f64,
    /// What stands to its left, px.
    pub(super) left_px: f64,
    /// What stands to its right, px.
    pub(super) right_px: f64,
}

/// Least share of the axis that marks may spread over, however long the texts are.
const LEAST_SHARE: f64 = 0.25;

/// The narrowest range of an axis `width_px` long in which every mark and its texts lie; `None` without a finite place.
///
/// Texts longer than three quarters of the axis do not fit: they would squeeze the marks to nothing.
pub(super) fn range_with_texts(reaches: &[Reach], width_px: f64) -> Option<[f64; 2]> {
    let known: Vec<&Reach> = reaches.iter().filter(|r| r.place.is_finite()).collect();
    let [low, high] = finite_ends(known.iter().map(|r| r.place))?;
    // One mark only: it stands within as much as its own size on either side.
    let alone = width_px / (2.0 * high.abs().max(1.0));
    let mut px_per_unit = if high > low { f64::INFINITY } else { alone };
    for right in &known {
        for left in known.iter().filter(|left| left.place < right.place) {
            let room_px = (width_px - left.left_px - right.right_px).max(LEAST_SHARE * width_px);
            px_per_unit = px_per_unit.min(room_px / (right.place - left.place));
        }
    }
    let start = known
        .iter()
        .map(|r| r.place - r.left_px / px_per_unit)
        .fold(f64::MAX, f64::min);
    let end = (start + width_px / px_per_unit).max(high);
    (start.is_finite() && end.is_finite() && end > start).then_some([start, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(place: f64, left_px: f64, right_px: f64) -> Reach {
        Reach {
            place,
            left_px,
            right_px,
        }
    }

    #[test]
    fn every_text_lies_on_the_axis() {
        let reaches = [
            reach(0.0, 5.0, 120.0),
            reach(40.0, 5.0, 60.0),
            reach(38.0, 0.0, 90.0),
            reach(-3.0, 70.0, 10.0),
        ];
        let [low, high] = range_with_texts(&reaches, 400.0).unwrap();
        let px = |value: f64| (value - low) / (high - low) * 400.0;
        for r in reaches {
            assert!(px(r.place) - r.left_px > -1e-9);
            assert!(px(r.place) + r.right_px < 400.0 + 1e-9);
        }
        // The range is no wider than it must be: one text touches each end.
        assert!((px(-3.0) - 70.0).abs() < 1e-9);
        assert!((px(38.0) + 90.0 - 400.0).abs() < 1e-9);
    }

    #[test]
    fn long_texts_do_not_squeeze_the_marks_to_nothing() {
        let [low, high] =
            range_with_texts(&[reach(0.0, 0.0, 0.0), reach(1.0, 0.0, 1e4)], 100.0).unwrap();
        assert_eq!([low, high], [0.0, 4.0]);
    }

    #[test]
    fn odd_data_give_a_range_or_none() {
        assert_eq!(range_with_texts(&[], 100.0), None);
        assert_eq!(range_with_texts(&[reach(f64::NAN, 1.0, 1.0)], 100.0), None);
        let [low, high] = range_with_texts(&[reach(7.0, 10.0, 10.0)], 100.0).unwrap();
        assert!(low < 7.0 && 7.0 < high);
        let [low, high] = range_with_texts(&[reach(0.0, 0.0, 0.0)], 100.0).unwrap();
        assert!(low <= 0.0 && 0.0 < high);
    }
}
