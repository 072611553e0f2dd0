//! Numbers as they are printed.

/// A number with so many significant digits, plain where that is short, in powers of ten where not.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-5..digits.max(6) as i32).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits() {
        assert_eq!(significant(0.004_857_3, 4), "0.004857");
        assert_eq!(significant(-1234.5, 3), "-1234");
        assert_eq!(significant(1.5e-9, 3), "1.50e-9");
        assert_eq!(significant(f64::NAN, 3), "-");
    }
}
