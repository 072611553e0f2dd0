//! Hatching of bars.

/// Between two hatching lines, px.
const HATCH_PX: f64 = 6.0;

/// Lines across a lying bar that slant by half a right angle on the sheet.
///
/// # Arguments
/// - `corners`: two opposite ones of the bar; across in units of the axis, down in rows.
/// - `row_px`: height of a row.
/// - `units_per_px`: of the axis.
pub(super) fn hatching(
    [first, last]: [&[f64; 2]; 2],
    row_px: f64,
    units_per_px: f64,
) -> Vec<[[f64; 2]; 2]> {
    let ([low, top], [high, bottom]) = (*first, *last);
    let rise = (bottom - top) * row_px * units_per_px;
    let step = HATCH_PX * units_per_px;
    let count = ((high - low + rise) / step).floor();
    if !(count.is_finite() && count >= 1.0) {
        return Vec::new();
    }
    (1..=count as usize)
        .filter_map(|i| {
            // The line starts below at this place and ends above one height farther right; both ends are cut at the bar's.
            let start = low - rise + step * i as f64;
            let from = start.max(low);
            let to = (start + rise).min(high);
            let height = |x: f64| bottom + (x - start) / rise * (top - bottom);
            (to > from).then(|| [[from, height(from)], [to, height(to)]])
        })
        .collect()
}
