//! The smallest value of a function of one size.

/// Where a function of one size is smallest: a grid (of equal ratios where sizes are positive), then golden sections.
pub(super) fn smallest(at: &dyn Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    const STEPS: usize = 60;
    let points: Vec<f64> = (0..=STEPS)
        .map(|step| {
            let share = step as f64 / STEPS as f64;
            if low < 0.0 {
                low + (high - low) * share
            } else if step == 0 {
                0.0
            } else {
                high * 1e-5_f64.powf(1.0 - share)
            }
        })
        .collect();
    let best = (0..points.len())
        .min_by(|a, b| at(points[*a]).total_cmp(&at(points[*b])))
        .unwrap_or(0);
    let (mut a, mut b) = (
        points[best.saturating_sub(1)],
        points[(best + 1).min(STEPS)],
    );
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if at(c) < at(d) {
            b = d;
        } else {
            a = c;
        }
    }
    let middle = 0.5 * (a + b);
    if at(middle) <= at(points[best]) {
        middle
    } else {
        points[best]
    }
}
