//! Limits of readings: a warning and a hard one, for force and displacement in size.

use crate::readings::ReadingLimits;

use super::plan::size;
use super::problem::ProcedureProblem;

/// How a reading stands to the limits of its procedure.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum LimitVerdict {
    /// Within all limits.
    Pass,
    /// Beyond a warning limit.
    Warn,
    /// Beyond a hard limit.
    Fail,
}

impl ReadingLimits {
    /// Whether there is any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// How a force and displacements stand to the limits, and the limit that is exceeded most severely, in words.
    #[must_use]
    pub fn verdict(
        &self,
        force_n: f64,
        displacements_m: impl IntoIterator<Item = f64>,
    ) -> (LimitVerdict, Option<String>) {
        let largest_m = displacements_m
            .into_iter()
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let force_n = force_n.abs();
        let force = |what: &str, limit_n: f64| {
            format!("the force of {force_n:.2} N is beyond the {what} limit of {limit_n} N")
        };
        let displacement = |what: &str, limit_m: f64| {
            format!(
                "the displacement of {:.1} um is beyond the {what} limit of {:.1} um",
                largest_m * 1e6,
                limit_m * 1e6
            )
        };
        for (verdict, what, force_limit, displacement_limit) in [
            (
                LimitVerdict::Fail,
                "hard",
                self.force_hard_n,
                self.displacement_hard_m,
            ),
            (
                LimitVerdict::Warn,
                "warning",
                self.force_warn_n,
                self.displacement_warn_m,
            ),
        ] {
            if let Some(limit_n) = force_limit.filter(|limit_n| force_n > *limit_n) {
                return (verdict, Some(force(what, limit_n)));
            }
            if let Some(limit_m) = displacement_limit.filter(|limit_m| largest_m > *limit_m) {
                return (verdict, Some(displacement(what, limit_m)));
            }
        }
        (LimitVerdict::Pass, None)
    }

    /// Checks that each is a size, and that no warning comes behind its hard limit.
    pub(super) fn check(&self) -> Result<(), ProcedureProblem> {
        let pairs = [
            ("limits.force_warn", self.force_warn_n, self.force_hard_n),
            ("limits.force_hard", self.force_hard_n, None),
            (
                "limits.displacement_warn",
                self.displacement_warn_m,
                self.displacement_hard_m,
            ),
            ("limits.displacement_hard", self.displacement_hard_m, None),
        ];
        for (key, value, hard) in pairs {
            let Some(value) = value else { continue };
            size(key, value)?;
            if hard.is_some_and(|hard| value > hard) {
                return Err(ProcedureProblem::new(
                    "stiffbench::procedure::warns_too_late",
                    key,
                    format!("`{key}` is beyond the hard limit"),
                    "a warning limit is at most the hard limit of the same quantity",
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_severe_limit_decides() {
        let limits = ReadingLimits {
            force_warn_n: Some(50.0),
            displacement_warn_m: Some(400e-6),
            displacement_hard_m: Some(800e-6),
            ..ReadingLimits::default()
        };
        assert_eq!(limits.verdict(-40.0, [300e-6]).0, LimitVerdict::Pass);
        let (verdict, why) = limits.verdict(-60.0, [300e-6, -500e-6]);
        assert_eq!(verdict, LimitVerdict::Warn);
        assert!(
            why.unwrap()
                .contains("60.00 N is beyond the warning limit of 50 N")
        );
        let (verdict, why) = limits.verdict(-60.0, [300e-6, -900e-6]);
        assert_eq!(verdict, LimitVerdict::Fail);
        assert!(
            why.unwrap()
                .contains("900.0 um is beyond the hard limit of 800.0 um")
        );
        assert_eq!(limits.check(), Ok(()));
        let late = ReadingLimits {
            force_hard_n: Some(40.0),
            ..limits
        };
        let problem = late.check().unwrap_err().to_string();
        assert_eq!(problem, "`limits.force_warn` is beyond the hard limit");
    }
}
