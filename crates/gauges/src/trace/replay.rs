//! A recorded bench in place of a live one.

use std::collections::VecDeque;
use std::thread;
use std::time::Duration;

use crate::Channel;
use crate::{Ask, GaugeEvent, Gauges};
use stiffbench_units_and_text::clock::Clock;

/// How fast a trace is replayed.
#[derive(Debug, Clone, Copy)]
pub enum ReplayPace {
    /// By this clock: what was recorded at its start comes at once. A clock of speed 1 replays as it was, of speed N N times as fast.
    By(Clock),
    /// As fast as it is taken.
    Fastest,
}

/// Recorded traces as gauges.
#[derive(Debug)]
pub struct Replay {
    events: VecDeque<(f64, GaugeEvent)>,
    pace: ReplayPace,
    /// Added to times of the trace, s.
    shift_s: f64,
    ended: bool,
}

impl Replay {
    /// A bench from the events of its traces, one for each gauge ([`super::events_of`]).
    ///
    /// Times stay those of the trace at the fastest pace; by a clock, the first event is now.
    #[must_use]
    pub fn new(traces: Vec<Vec<(f64, GaugeEvent)>>, pace: ReplayPace) -> Self {
        let mut events: Vec<(f64, GaugeEvent)> = traces.into_iter().flatten().collect();
        // Events of one line keep their order.
        events.sort_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s));
        let first_s = events.first().map_or(0.0, |(at_s, _)| *at_s);
        let shift_s = match pace {
            ReplayPace::By(clock) => clock.now_s() - first_s,
            ReplayPace::Fastest => 0.0,
        };
        Self {
            events: events.into(),
            pace,
            shift_s,
            ended: false,
        }
    }

    fn pop(&mut self) -> Option<GaugeEvent> {
        let (_, mut event) = self.events.pop_front()?;
        match &mut event {
            GaugeEvent::Sample { sample, .. } => sample.at_s += self.shift_s,
            GaugeEvent::Rejected { rejected, .. } => rejected.at_s += self.shift_s,
            GaugeEvent::Link { at_s, .. } | GaugeEvent::Note { at_s, .. } => *at_s += self.shift_s,
            GaugeEvent::Answered { .. } | GaugeEvent::Ended => {}
        }
        Some(event)
    }
}

impl Gauges for Replay {
    fn next(&mut self, wait: Duration) -> Option<GaugeEvent> {
        let Some((at_s, _)) = self.events.front() else {
            if self.ended {
                thread::sleep(wait);
                return None;
            }
            self.ended = true;
            return Some(GaugeEvent::Ended);
        };
        if let ReplayPace::By(clock) = self.pace {
            let until = clock.real(at_s + self.shift_s - clock.now_s());
            thread::sleep(until.min(wait));
            if until > wait {
                return None;
            }
        }
        self.pop()
    }

    /// What was recorded cannot be asked; an answer that stands in the trace comes at its time.
    fn ask(&mut self, channel: Channel, ask: Ask) {
        let is_answer = |(_, event): &(f64, GaugeEvent)| matches!(event, GaugeEvent::Answered { channel: of, ask: what, .. } if (*of, *what) == (channel, ask));
        if self.events.iter().any(is_answer) {
            return;
        }
        let at_s = f64::MIN;
        let answer = Err("this is a recorded trace, and no answer to that was recorded".into());
        self.events.push_front((
            at_s,
            GaugeEvent::Answered {
                channel,
                ask,
                answer,
            },
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(channel: Channel, text: &str, at_s: f64) -> (f64, GaugeEvent) {
        (
            at_s,
            GaugeEvent::Note {
                channel,
                text: text.into(),
                at_s,
            },
        )
    }

    fn texts(replay: &mut Replay) -> Vec<(String, f64)> {
        std::iter::from_fn(|| match replay.next(Duration::ZERO) {
            Some(GaugeEvent::Note { text, at_s, .. }) => Some((text.to_string(), at_s)),
            _ => None,
        })
        .collect()
    }

    fn traces() -> Vec<Vec<(f64, GaugeEvent)>> {
        vec![
            vec![
                note(Channel::Force, "a", 5.0),
                note(Channel::Force, "b", 7.0),
            ],
            vec![
                note(Channel::Displacement, "c", 6.0),
                note(Channel::Displacement, "d", 7.0),
            ],
        ]
    }

    #[test]
    fn two_traces_come_in_the_order_of_their_times_and_end_once() {
        let mut replay = Replay::new(traces(), ReplayPace::Fastest);
        let expected = [("a", 5.0), ("c", 6.0), ("b", 7.0), ("d", 7.0)];
        assert_eq!(
            texts(&mut replay),
            expected.map(|(text, at_s)| (text.to_owned(), at_s))
        );
        assert!(replay.ended);
        assert_eq!(replay.next(Duration::ZERO), None);
    }

    #[test]
    fn a_clocked_replay_waits_for_later_entries() {
        let clock = Clock::starting_at(100.0, 0.001);
        let mut replay = Replay::new(traces(), ReplayPace::By(clock));
        let first = texts(&mut replay);
        assert_eq!(first.len(), 1);
        assert!((first[0].1 - 100.0).abs() < 1e-3);
        // A thousand times as fast all is there within some milliseconds.
        let clock = Clock::starting_at(100.0, 1000.0);
        let mut replay = Replay::new(traces(), ReplayPace::By(clock));
        let mut seen = 0;
        while replay.next(Duration::from_millis(50)) != Some(GaugeEvent::Ended) {
            seen += 1;
        }
        assert_eq!(seen, 4);
    }

    #[test]
    fn a_trace_is_not_asked_but_gives_the_answers_it_holds() {
        let mut replay = Replay::new(Vec::new(), ReplayPace::Fastest);
        replay.ask(Channel::Force, Ask::Zero);
        let told = replay.next(Duration::ZERO);
        assert!(
            matches!(told, Some(GaugeEvent::Answered { answer: Err(_), .. })),
            "{told:?}"
        );
        let answer = GaugeEvent::Answered {
            channel: Channel::Force,
            ask: Ask::Zero,
            answer: Ok("".into()),
        };
        let mut replay = Replay::new(vec![vec![(1.0, answer.clone())]], ReplayPace::Fastest);
        replay.ask(Channel::Force, Ask::Zero);
        assert_eq!(replay.next(Duration::ZERO), Some(answer));
        assert_eq!(replay.next(Duration::ZERO), Some(GaugeEvent::Ended));
    }
}
