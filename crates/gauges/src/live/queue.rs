//! Events of the lines, until they are read.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use stiffbench_units_and_text::count::counted;

use crate::GaugeEvent;

/// Events that wait at most: more than three minutes of two fast gauges.
const LONGEST: usize = 65_536;

/// A queue of bounded length between the lines and the session.
///
/// If they are not read for minutes, the oldest values are dropped; the next event that is read states how many.
#[derive(Debug, Default)]
pub(super) struct Queue {
    state: Mutex<QueueState>,
    filled: Condvar,
}

#[derive(Debug, Default)]
struct QueueState {
    events: VecDeque<GaugeEvent>,
    lost: usize,
}

impl Queue {
    pub(super) fn push(&self, event: GaugeEvent) {
        let mut state = self.lock();
        if state.events.len() >= LONGEST {
            let is_value = |event: &GaugeEvent| matches!(event, GaugeEvent::Sample { .. });
            let oldest = state.events.iter().position(is_value).unwrap_or(0);
            state.events.remove(oldest);
            state.lost += 1;
        }
        state.events.push_back(event);
        drop(state);
        self.filled.notify_one();
    }

    /// The oldest event; waits for one at most `wait` of real time.
    pub(super) fn pop(&self, wait: Duration) -> Option<GaugeEvent> {
        let waited = self
            .filled
            .wait_timeout_while(self.lock(), wait, |state| state.events.is_empty());
        let (mut state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let lost = std::mem::take(&mut state.lost);
        if lost > 0
            && let Some(GaugeEvent::Sample { channel, sample }) = state.events.front()
        {
            return Some(GaugeEvent::Note {
                channel: *channel,
                text: format!(
                    "{} not processed in time: lost for the session, kept in the trace",
                    counted(lost, "value")
                )
                .into(),
                at_s: sample.at_s,
            });
        }
        state.lost = lost;
        state.events.pop_front()
    }

    fn lock(&self) -> MutexGuard<'_, QueueState> {
        // A line that panicked leaves the events as they are.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use crate::gauges::{Ask, LinkState};
    use crate::sample::{Channel, Sample};
    use stiffbench_units_and_text::quantity::Kind;

    use super::*;

    fn sample(at_s: f64) -> GaugeEvent {
        let sample = Sample {
            kind: Kind::Force,
            value_si: 1.0,
            resolution_si: 0.1,
            value: 1.0,
            unit: "N".into(),
            raw: "1.0 N".into(),
            at_s,
            bytes: [0; 2],
            marks: Vec::new(),
        };
        GaugeEvent::Sample {
            channel: Channel::Force,
            sample,
        }
    }

    #[test]
    fn a_full_queue_keeps_other_events_and_counts_lost_values() {
        let queue = Queue::default();
        let answered = GaugeEvent::Answered {
            channel: Channel::Force,
            ask: Ask::Zero,
            answer: Ok("".into()),
        };
        let silent = GaugeEvent::Link {
            channel: Channel::Force,
            state: LinkState::Silent,
            at_s: 0.0,
        };
        queue.push(answered.clone());
        queue.push(silent.clone());
        for i in 0..LONGEST + 3 {
            queue.push(sample(i as f64));
        }
        let next = || queue.pop(Duration::ZERO).unwrap();
        assert_eq!([next(), next()], [answered, silent]);
        let GaugeEvent::Note { text, .. } = next() else {
            panic!("the loss is not told")
        };
        assert!(text.starts_with("5 values"), "{text}");
        assert_eq!(next(), sample(5.0));
        assert_eq!(next(), sample(6.0));
    }

    #[test]
    fn an_empty_queue_gives_nothing() {
        assert_eq!(Queue::default().pop(Duration::from_millis(1)), None);
    }
}
