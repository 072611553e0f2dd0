//! Packets of an emulated gauge and the pace of its stream.

/// What a gauge sends, packet by packet.
pub(super) type Packets = Vec<Vec<u8>>;

/// Values that a gauge sends by itself, so many a second.
#[derive(Debug, Default)]
pub(super) struct Stream {
    per_second: Option<f64>,
    from_s: f64,
    /// Values due since then.
    sent: u32,
}

/// Values that a stream makes up for when it was not served for a while; a gauge has no memory for more.
const MOST_AT_ONCE: usize = 64;

/// What a time may fall short of by rounding, s.
const ROUNDING_S: f64 = 1e-9;

impl Stream {
    pub(super) fn start(&mut self, per_second: f64, now_s: f64) {
        *self = Self {
            per_second: Some(per_second),
            from_s: now_s,
            sent: 0,
        };
    }

    pub(super) fn stop(&mut self) {
        self.per_second = None;
    }

    pub(super) fn is_on(&self) -> bool {
        self.per_second.is_some()
    }

    /// How many values are due now.
    pub(super) fn due(&mut self, now_s: f64) -> usize {
        let is_due = |at_s: f64| at_s <= now_s + ROUNDING_S;
        let mut due = 0;
        while due < MOST_AT_ONCE && self.next_due_s().is_some_and(is_due) {
            due += 1;
            self.sent += 1;
        }
        if let Some(per_second) = self.per_second.filter(|_| due == MOST_AT_ONCE) {
            self.start(per_second, now_s);
        }
        due
    }

    /// When the next value is due, s.
    pub(super) fn next_due_s(&self) -> Option<f64> {
        let per_second = self.per_second?;
        Some(self.from_s + (f64::from(self.sent) + 1.0) / per_second)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_keeps_its_rate_and_forgets_what_it_could_not_send() {
        let mut stream = Stream::default();
        stream.start(50.0, 0.0);
        let sent: usize = (1..=1000)
            .map(|ms| stream.due(f64::from(ms) / 1000.0))
            .sum();
        assert_eq!(sent, 50);
        assert_eq!(stream.due(1000.0), MOST_AT_ONCE);
        assert_eq!(stream.due(1000.0), 0);
        stream.stop();
        assert_eq!(stream.due(2000.0), 0);
    }
}
