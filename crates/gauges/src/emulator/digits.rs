//! Numbers as displays show them.

/// A value in whole steps of the last digit shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Digits {
    pub(super) negative: bool,
    pub(super) steps: u64,
    pub(super) decimals: usize,
}

impl Digits {
    /// The nearest step; a value that rounds to nothing has no sign.
    pub(super) fn of(value: f64, decimals: usize) -> Self {
        let steps = (value * 10_f64.powi(decimals as i32)).round();
        Self {
            negative: steps < 0.0,
            steps: steps.abs() as u64,
            decimals,
        }
    }

    /// Digits and point without a sign, as few as there are: `4.285`, `0.1`, `12`.
    pub(super) fn plain(self) -> String {
        let scale = 10_u64.pow(self.decimals as u32);
        if self.decimals == 0 {
            return self.steps.to_string();
        }
        let fraction = self.steps % scale;
        format!(
            "{}.{fraction:0width$}",
            self.steps / scale,
            width = self.decimals
        )
    }

    /// As [`Digits::plain`], zeros in front to a width.
    pub(super) fn zero_filled(self, width: usize) -> String {
        format!("{:0>width$}", self.plain())
    }

    /// As [`Digits::plain`], blanks in front to a width.
    pub(super) fn blank_filled(self, width: usize) -> String {
        format!("{:>width$}", self.plain())
    }

    /// `-`, or what stands for plus.
    pub(super) fn sign_or(self, plus: &'static str) -> &'static str {
        if self.negative { "-" } else { plus }
    }

    /// `+` or `-`.
    pub(super) fn sign(self) -> &'static str {
        self.sign_or("+")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_have_no_negative_zero_and_keep_their_places() {
        let shown = |value, decimals| {
            let digits = Digits::of(value, decimals);
            format!("{}{}", digits.sign_or(""), digits.plain())
        };
        assert_eq!(shown(-0.04, 1), "0.0");
        assert_eq!(shown(-0.05, 1), "-0.1");
        assert_eq!(shown(4.285, 3), "4.285");
        assert_eq!(shown(-12.0, 0), "-12");
        assert_eq!(Digits::of(21.15, 2).zero_filled(6), "021.15");
        assert_eq!(Digits::of(0.415, 3).blank_filled(8), "   0.415");
    }
}
