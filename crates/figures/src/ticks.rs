//! Where an axis is marked, and how numbers are written there.

use super::figure::AxisScale;

/// A labelled mark of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// Value on the axis.
    pub(super) value: f64,
    /// Its text; empty for a minor tick.
    pub(super) text: String,
}

/// Ticks of an axis that runs from `range[0]` to `range[1]` (values, not logarithms), about `wanted` of them labelled.
pub(super) fn ticks(scale: &AxisScale, range: [f64; 2], wanted: usize) -> Vec<Tick> {
    match scale {
        AxisScale::Linear => linear(range, wanted),
        AxisScale::Log10 => logarithmic(range, wanted),
        // A place without a name is not marked.
        AxisScale::Categories(names) => names
            .iter()
            .enumerate()
            .filter(|(_, name)| !name.is_empty())
            .map(|(place, name)| Tick {
                value: place as f64,
                text: name.clone(),
            })
            .collect(),
    }
}

/// The number 1, 2 or 5 times a power of ten nearest to `value` in the logarithm; 1 for a value that is not positive and finite.
#[must_use]
pub(super) fn nearest_nice(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let decade = value.log10().floor();
    [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * 10f64.powf(decade))
        .into_iter()
        .min_by(|a, b| (a / value).ln().abs().total_cmp(&(b / value).ln().abs()))
        .unwrap_or(1.0)
}

/// Smallest 1, 2 or 5 times a power of ten that gives at most `wanted` steps.
pub(super) fn step_of(span: f64, wanted: usize) -> f64 {
    let rough = span / wanted.max(1) as f64;
    let decade = 10f64.powf(rough.log10().floor());
    // The tolerance keeps a span of exactly 1, 2 or 5 steps from jumping to the next.
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|m| m * decade)
        .find(|step| *step >= rough * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

fn linear([low, high]: [f64; 2], wanted: usize) -> Vec<Tick> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) {
        return Vec::new();
    }
    let step = step_of(span, wanted);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    (first..=last)
        .map(|i| Tick {
            value: i as f64 * step,
            text: number(i as f64 * step, step),
        })
        .collect()
}

fn logarithmic([low, high]: [f64; 2], wanted: usize) -> Vec<Tick> {
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Vec::new();
    }
    let decades = (high / low).log10();
    // Within half a decade powers of ten leave an axis without labels.
    if decades < 0.5 {
        return linear([low, high], wanted);
    }
    let labelled: &[u8] = if decades <= 2.2 { &[1, 2, 5] } else { &[1] };
    let every = (decades / wanted.max(1) as f64).ceil().max(1.0) as i32;
    let mut found = Vec::new();
    for exponent in low.log10().floor() as i32..=high.log10().ceil() as i32 {
        for multiple in 1..=9_u8 {
            let value = f64::from(multiple) * 10f64.powi(exponent);
            if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                continue;
            }
            let text = if labelled.contains(&multiple) && exponent.rem_euclid(every) == 0 {
                number(value, value)
            } else {
                String::new()
            };
            if decades <= 6.0 || !text.is_empty() {
                found.push(Tick { value, text });
            }
        }
    }
    found
}

/// A number with the decimals that `step` asks for, a true minus sign, and a power of ten where digits would be many.
pub(super) fn number(value: f64, step: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        // Zero among powers of ten needs no decimals; among decimals it has as many as its neighbours.
        return signed(0.0, if step < 1e-4 { 0 } else { decimals(step) });
    }
    if size >= 1e6 || step < 1e-4 {
        let exponent = size.log10().floor() as i32;
        let mantissa = value / 10f64.powi(exponent);
        let digits = decimals(step / 10f64.powi(exponent));
        return format!("{}·10{}", signed(mantissa, digits), superscript(exponent));
    }
    signed(value, decimals(step))
}

/// Digits after the point that a step of 1, 2 or 5 times a power of ten needs.
fn decimals(step: f64) -> usize {
    if step.is_finite() && step > 0.0 {
        (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize
    } else {
        0
    }
}

/// Fixed decimals with a true minus sign, and no minus before a zero.
pub(super) fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.to_owned(),
        Some(size) => format!("−{size}"),
        None => text,
    }
}

fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent
        .to_string()
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(digit) => DIGITS[digit as usize],
            None => '⁻',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn steps_are_one_two_or_five_also_within_two_decades_of_a_logarithm() {
        let (linear, logarithmic) = (AxisScale::Linear, AxisScale::Log10);
        #[rustfmt::skip]
        let cases: [(&AxisScale, _, _, &[&str]); 6] = [
            (&linear, [-70.0, 0.0], 4, &["−60", "−40", "−20", "0"]),
            (&linear, [0.0, 1.0], 5, &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
            (&linear, [0.0, 3e-6], 3, &["0", "1·10⁻⁶", "2·10⁻⁶", "3·10⁻⁶"]),
            (&logarithmic, [0.01, 0.5], 6, &["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]),
            (&logarithmic, [1.0, 1e4], 5, &["1", "10", "100", "1000", "10000"]),
            (&logarithmic, [0.8, 1.2], 4, &["0.8", "0.9", "1.0", "1.1", "1.2"]),
        ];
        for (scale, range, wanted, expected) in cases {
            let found = ticks(scale, range, wanted);
            let texts = found.iter().map(|tick| tick.text.as_str());
            let texts: Vec<&str> = texts.filter(|text| !text.is_empty()).collect();
            assert_eq!(texts, expected, "{scale:?} {range:?}");
        }
    }

    #[test]
    fn impossible_ranges_have_no_ticks() {
        assert!(ticks(&AxisScale::Linear, [1.0, 1.0], 5).is_empty());
        assert!(ticks(&AxisScale::Linear, [f64::NAN, 1.0], 5).is_empty());
        assert!(ticks(&AxisScale::Log10, [-1.0, 1.0], 5).is_empty());
    }

    #[test]
    fn a_place_without_a_name_has_no_tick() {
        let names = ["", "P1 x", ""].map(str::to_owned).to_vec();
        let found = ticks(&AxisScale::Categories(names), [-0.5, 2.5], 3);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].value, 1.0);
    }

    #[test]
    fn zero_has_no_minus() {
        assert_eq!(signed(-0.001, 1), "0.0");
        assert_eq!(signed(-0.06, 1), "−0.1");
    }

    #[test]
    fn nice_numbers() {
        assert_eq!(nearest_nice(38.0), 50.0);
        assert_eq!(nearest_nice(0.0013), 0.001);
        assert_eq!(nearest_nice(880.0), 1000.0);
        assert_eq!(nearest_nice(f64::INFINITY), 1.0);
    }

    proptest! {
        #[test]
        fn linear_ticks_lie_in_the_range_and_are_few(low in -1e6..1e6_f64, span in 1e-6..1e6_f64, wanted in 1_usize..12) {
            let found = linear([low, low + span], wanted);
            prop_assert!(found.len() <= wanted + 1);
            let slack = span * 1e-6 + low.abs() * 1e-12;
            for tick in &found {
                prop_assert!(tick.value >= low - slack && tick.value <= low + span + slack);
            }
        }
    }
}
