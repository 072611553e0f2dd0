//! How long a lost gauge is searched for.

/// How long a lost gauge is searched for, and how often, in real seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetryPolicy {
    /// Pause before the first try, s; each further one is twice as long.
    pub first_s: f64,
    /// Longest pause, s.
    pub longest_s: f64,
    /// Tries before the gauge is given up until the operator asks for it.
    pub tries: u32,
}

impl Default for RetryPolicy {
    /// From a quarter of a second to five, for about ten minutes: time to fetch another cable.
    fn default() -> Self {
        Self {
            first_s: 0.25,
            longest_s: 5.0,
            tries: 125,
        }
    }
}

impl RetryPolicy {
    /// The pause before the n-th try (from 1), s; `None` when tries are used up.
    pub(super) fn pause_s(&self, attempt: u32) -> Option<f64> {
        let doublings = i32::try_from(attempt.saturating_sub(1)).unwrap_or(i32::MAX);
        (attempt <= self.tries)
            .then(|| (self.first_s * 2.0_f64.powi(doublings)).min(self.longest_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_a_bound_and_end() {
        let retry_policy = RetryPolicy {
            first_s: 0.5,
            longest_s: 3.0,
            tries: 5,
        };
        let pauses: Vec<Option<f64>> = (1..=6)
            .map(|attempt| retry_policy.pause_s(attempt))
            .collect();
        assert_eq!(
            pauses,
            [Some(0.5), Some(1.0), Some(2.0), Some(3.0), Some(3.0), None]
        );
        assert_eq!(
            RetryPolicy {
                tries: u32::MAX,
                ..retry_policy
            }
            .pause_s(u32::MAX),
            Some(3.0)
        );
    }
}
