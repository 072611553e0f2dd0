//! Shares of trials.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::statistics::{binomial_interval_95, binomial_upper_95};

/// Hits among trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(into = "ShareObject")]
pub struct Share {
    /// Trials that count.
    pub hits: usize,
    /// All trials.
    pub trials: usize,
}

/// A share as results write it.
#[derive(Serialize, JsonSchema)]
struct ShareObject {
    /// Trials that count.
    hits: usize,
    /// All trials.
    trials: usize,
    /// The share; `null` without trials.
    #[schemars(range(min = 0.0, max = 1.0))]
    share: Option<f64>,
    /// Its 95 % interval (Clopper and Pearson).
    ci95: Option<[f64; 2]>,
    /// Its one-sided upper 95 % bound.
    upper95: Option<f64>,
}

impl From<Share> for ShareObject {
    fn from(share: Share) -> Self {
        Self {
            hits: share.hits,
            trials: share.trials,
            share: share.value(),
            ci95: share.interval_95(),
            upper95: share.upper_95(),
        }
    }
}

impl Share {
    /// The share of items for which something holds.
    pub fn of<T>(items: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Self {
        let mut share = Self::default();
        for item in items {
            share.add(holds(&item));
        }
        share
    }

    /// One more trial.
    pub fn add(&mut self, hit: bool) {
        self.trials += 1;
        self.hits += usize::from(hit);
    }

    /// Trials of both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            trials: self.trials + other.trials,
        }
    }

    /// The share, 0 to 1; `None` without trials.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.trials > 0).then(|| self.hits as f64 / self.trials as f64)
    }

    /// 95 % interval of Clopper and Pearson.
    #[must_use]
    pub fn interval_95(&self) -> Option<[f64; 2]> {
        binomial_interval_95(self.hits, self.trials)
    }

    /// One-sided upper 95 % bound.
    #[must_use]
    pub fn upper_95(&self) -> Option<f64> {
        binomial_upper_95(self.hits, self.trials)
    }
}

/// What a share must be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// At least this.
    AtLeast(f64),
    /// At most this.
    AtMost(f64),
    /// Between these.
    Between(f64, f64),
}

impl Target {
    /// Whether a share keeps it; `None` without trials.
    #[must_use]
    pub fn is_met(&self, share: &Share) -> Option<bool> {
        let value = share.value()?;
        Some(match *self {
            Self::AtLeast(least) => value >= least,
            Self::AtMost(most) => value <= most,
            Self::Between(least, most) => (least..=most).contains(&value),
        })
    }
}

/// A promise and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(into = "CriterionObject")]
pub struct AcceptanceCriterion {
    /// In words.
    pub what: &'static str,
    /// What its share must be; `None` where it is only counted.
    pub target: Option<Target>,
    /// The trials.
    pub share: Share,
}

/// A criterion as results write it.
#[derive(Serialize, JsonSchema)]
struct CriterionObject {
    /// In words.
    what: &'static str,
    /// What its share must be; `null` where it is only counted.
    target: Option<Target>,
    /// The trials.
    share: Share,
    /// Whether it was; `null` without target or trials.
    kept: Option<bool>,
}

impl From<AcceptanceCriterion> for CriterionObject {
    fn from(
        AcceptanceCriterion {
            what,
            target,
            share,
        }: AcceptanceCriterion,
    ) -> Self {
        Self {
            what,
            target,
            share,
            kept: target.and_then(|target| target.is_met(&share)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_met_or_not() {
        let share = Share {
            hits: 19,
            trials: 20,
        };
        assert_eq!(Target::AtLeast(0.95).is_met(&share), Some(true));
        assert_eq!(Target::AtMost(0.94).is_met(&share), Some(false));
        assert_eq!(Target::Between(0.93, 0.97).is_met(&share), Some(true));
        assert_eq!(Target::AtLeast(0.0).is_met(&Share::default()), None);
        assert_eq!(
            Share::of([1, 2, 3], |n| *n > 1),
            Share { hits: 2, trials: 3 }
        );
    }
}
