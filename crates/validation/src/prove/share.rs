//! Shares of trials.

use stiffbench_numeric::statistics::{binomial_interval_95, binomial_upper_95};

/// Hits among trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Trials that count.
    pub hits: usize,
    /// All trials.
    pub trials: usize,
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
#[derive(Debug, Clone, Copy, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct AcceptanceCriterion {
    /// In words.
    pub what: &'static str,
    /// What its share must be; `None` where it is only counted.
    pub target: Option<Target>,
    /// The trials.
    pub share: Share,
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
