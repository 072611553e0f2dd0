//! What time it is: one clock for a session, real or fast-forward.
//!
//! Besides `cli` only this module asks the system for the time. A session's times (dwell, holds, ages) run on a [`Clock`]; deadlines of a
//! serial line (a reply that does not come) are real seconds, whatever the speed.

use std::time::{Duration, Instant, SystemTime};

use jiff::Timestamp;

/// Session time and UTC.
///
/// Session time is monotonic and counts what the system was suspended only where the system's own monotonic clock does; the difference to UTC
/// shows it.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    started: Instant,
    started_utc: Timestamp,
    offset_s: f64,
    speed: f64,
}

impl Clock {
    /// A clock that starts now at `offset_s` seconds of session time and runs `speed` times as fast as the real one.
    ///
    /// A speed that is not finite and positive counts as 1.
    #[must_use]
    pub fn starting_at(offset_s: f64, speed: f64) -> Self {
        Self {
            started: Instant::now(),
            started_utc: utc_now(),
            offset_s,
            speed: if speed.is_finite() && speed > 0.0 {
                speed
            } else {
                1.0
            },
        }
    }

    /// Session time, s.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.offset_s + self.started.elapsed().as_secs_f64() * self.speed
    }

    /// UTC as the system shows it; in fast-forward, where it would be by session time.
    #[must_use]
    pub fn utc(&self) -> Timestamp {
        if self.speed == 1.0 {
            return utc_now();
        }
        let ahead = Duration::from_secs_f64(self.started.elapsed().as_secs_f64() * self.speed);
        self.started_utc
            .checked_add(ahead)
            .unwrap_or_else(|_| utc_now())
    }

    /// How many seconds of session time pass in a real one.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The real time that `seconds` of session time take.
    #[must_use]
    pub fn real(&self, seconds: f64) -> Duration {
        Duration::try_from_secs_f64((seconds / self.speed).max(0.0)).unwrap_or(Duration::MAX)
    }
}

impl Default for Clock {
    /// A real clock from 0.
    fn default() -> Self {
        Self::starting_at(0.0, 1.0)
    }
}

fn utc_now() -> Timestamp {
    Timestamp::try_from(SystemTime::now()).unwrap_or(Timestamp::UNIX_EPOCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn session_time_starts_at_the_given_value_and_runs_faster() {
        let clock = Clock::starting_at(100.0, 1000.0);
        let first_s = clock.now_s();
        assert!(first_s >= 100.0);
        assert_eq!(clock.real(10.0), Duration::from_millis(10));
        while clock.now_s() == first_s {}
        assert!(clock.now_s() > first_s);
    }

    #[test]
    fn a_speed_that_is_none_counts_as_real_time() {
        for speed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Clock::starting_at(0.0, speed).speed(), 1.0);
        }
    }
}
