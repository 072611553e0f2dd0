//! The line between a gauge and its host, and what can happen on it.

use std::collections::VecDeque;

use super::fault::LineFault;
use super::gauge::{EmulatedGauge, EmulatorError, PanelAction};

/// What a serial line hands on as garbage: bytes of no packet of any gauge, among them some with the top bit set.
const GARBAGE: [u8; 6] = [0xff, 0x00, 0x7e, 0x81, 0x23, 0xfe];

/// A gauge behind a line that can fail: pure, as the gauge is. Without faults it hands on what the gauge sends.
#[derive(Debug)]
pub struct EmulatedLine {
    gauge: EmulatedGauge,
    faults: Vec<Ongoing>,
    /// Bytes on their way to the host, with the time at which they arrive, s.
    on_the_way: VecDeque<(f64, Vec<u8>)>,
    /// Packets kept back to be merged.
    kept: Vec<Vec<u8>>,
    packets_sent: u64,
}

/// A fault at work.
#[derive(Debug)]
struct Ongoing {
    fault: LineFault,
    until: Until,
}

/// How long a fault goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// So many packets.
    Packets(u64),
    /// A time of the line, s.
    Time(f64),
    /// Until [`EmulatedLine::mend`].
    Mended,
}

impl EmulatedLine {
    /// A line without faults.
    #[must_use]
    pub fn new(gauge: EmulatedGauge) -> Self {
        Self {
            gauge,
            faults: Vec::new(),
            on_the_way: VecDeque::new(),
            kept: Vec::new(),
            packets_sent: 0,
        }
    }

    /// The gauge at its end.
    #[must_use]
    pub fn gauge(&self) -> &EmulatedGauge {
        &self.gauge
    }

    /// How many packets the gauge has sent.
    #[must_use]
    pub fn packets_sent(&self) -> u64 {
        self.packets_sent
    }

    /// Starts a fault.
    pub fn fail(&mut self, fault: LineFault, until: Until) {
        self.faults.push(Ongoing { fault, until });
    }

    /// Ends a fault of this kind.
    pub fn mend(&mut self, fault: &LineFault) {
        self.faults.retain(|ongoing| ongoing.fault != *fault);
    }

    /// An operator action at the gauge.
    ///
    /// # Errors
    /// As [`EmulatedGauge::press`].
    pub fn press(&mut self, panel: &PanelAction, now_s: f64) -> Result<(), EmulatorError> {
        let packets = self.gauge.press(panel)?;
        self.send(packets, now_s);
        Ok(())
    }

    /// Bytes arrive from the host; what arrives there now.
    pub fn receive(&mut self, bytes: &[u8], now_s: f64) -> Vec<u8> {
        self.end_faults(now_s);
        if self.has(|fault| *fault == LineFault::Echo) {
            self.on_the_way.push_back((now_s, bytes.to_vec()));
        }
        if !self.has(|fault| *fault == LineFault::Silence) {
            let packets = self.gauge.receive_packets(bytes, now_s);
            self.send(packets, now_s);
        }
        self.arrived(now_s)
    }

    /// Time passes; what arrives at the host.
    pub fn tick(&mut self, now_s: f64) -> Vec<u8> {
        self.end_faults(now_s);
        let packets = self.gauge.tick_packets(now_s);
        self.send(packets, now_s);
        self.arrived(now_s)
    }

    /// When [`EmulatedLine::tick`] will have something to hand on, s.
    #[must_use]
    pub fn next_due_s(&self) -> Option<f64> {
        let on_the_way = self.on_the_way.front().map(|(at_s, _)| *at_s);
        match (on_the_way, self.gauge.next_due_s()) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// Forgets what is on its way: the line was cut.
    pub fn cut(&mut self) {
        self.on_the_way.clear();
        self.kept.clear();
    }

    fn has(&self, which: impl Fn(&LineFault) -> bool) -> bool {
        self.faults.iter().any(|ongoing| which(&ongoing.fault))
    }

    fn end_faults(&mut self, now_s: f64) {
        self.faults.retain(|ongoing| match ongoing.until {
            Until::Packets(left) => left > 0,
            Until::Time(until_s) => now_s < until_s,
            Until::Mended => true,
        });
        let merging = self.has(|fault| matches!(fault, LineFault::MergedPackets { .. }));
        if !merging && !self.kept.is_empty() {
            let kept = std::mem::take(&mut self.kept).concat();
            self.on_the_way.push_back((now_s, kept));
        }
    }

    /// Puts packets on their way, through all faults.
    fn send(&mut self, packets: Vec<Vec<u8>>, now_s: f64) {
        for packet in packets {
            self.packets_sent += 1;
            self.send_one(packet, now_s);
            for ongoing in &mut self.faults {
                if let Until::Packets(left) = &mut ongoing.until {
                    *left = left.saturating_sub(1);
                }
            }
            self.end_faults(now_s);
        }
    }

    fn send_one(&mut self, mut packet: Vec<u8>, now_s: f64) {
        let mut at_s = now_s;
        let mut rest_after_s = None;
        let mut merged = None;
        for ongoing in &self.faults {
            match &ongoing.fault {
                LineFault::Silence => return,
                LineFault::Garbage(bytes) => {
                    let garbage = bytes.as_deref().unwrap_or(&GARBAGE);
                    packet.splice(0..0, garbage.iter().copied());
                }
                LineFault::NulBefore => packet.insert(0, 0),
                LineFault::LateReply { by_s } => at_s += by_s,
                LineFault::PartialPacket { pause_s } => rest_after_s = Some(*pause_s),
                LineFault::CutPacket => packet.truncate(packet.len() / 2),
                LineFault::MergedPackets { packets } => merged = Some(*packets),
                LineFault::Echo => {}
            }
        }
        if let Some(packets) = merged {
            self.kept.push(packet);
            if self.kept.len() < packets {
                return;
            }
            packet = std::mem::take(&mut self.kept).concat();
        }
        if let Some(pause_s) = rest_after_s {
            let rest = packet.split_off(packet.len() / 2);
            self.put(at_s, packet);
            self.put(at_s + pause_s, rest);
        } else {
            self.put(at_s, packet);
        }
    }

    /// A line keeps the order: nothing overtakes.
    fn put(&mut self, at_s: f64, bytes: Vec<u8>) {
        let before_s = self.on_the_way.back().map_or(at_s, |(at_s, _)| *at_s);
        self.on_the_way.push_back((at_s.max(before_s), bytes));
    }

    fn arrived(&mut self, now_s: f64) -> Vec<u8> {
        let mut arrived = Vec::new();
        let due = self
            .on_the_way
            .iter()
            .take_while(|(at_s, _)| *at_s <= now_s);
        let due = due.count();
        for (_, bytes) in self.on_the_way.drain(..due) {
            arrived.extend(bytes);
        }
        arrived
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::shipped::shipped_instrument;

    /// A Mark-10 under 12.3 N of compression; it answers `12.3 N<CR><LF>`.
    fn line() -> EmulatedLine {
        let description = shipped_instrument("mark10-series5").unwrap();
        EmulatedLine::new(EmulatedGauge::described(&description, Arc::new(|| -12.3)))
    }

    const VALUE: &[u8] = b"12.3 N\r\n";

    fn once(fault: LineFault) -> EmulatedLine {
        let mut line = line();
        line.fail(fault, Until::Packets(1));
        line
    }

    #[test]
    fn without_faults_it_hands_on() {
        let mut line = line();
        assert_eq!(line.receive(b"?C\r", 0.0), VALUE);
        assert_eq!((line.packets_sent(), line.next_due_s()), (1, None));
    }

    #[test]
    fn a_partial_packet_comes_in_two_pieces() {
        let mut line = once(LineFault::PartialPacket { pause_s: 0.3 });
        assert_eq!(line.receive(b"?C\r", 0.0), b"12.3");
        assert_eq!(line.next_due_s(), Some(0.3));
        assert_eq!(line.tick(0.2), b"");
        assert_eq!(line.tick(0.3), b" N\r\n");
        assert_eq!(line.receive(b"?C\r", 1.0), VALUE);
    }

    #[test]
    fn a_cut_packet_never_ends() {
        let mut line = once(LineFault::CutPacket);
        assert_eq!(line.receive(b"?C\r", 0.0), b"12.3");
        assert_eq!(line.tick(100.0), b"");
    }

    #[test]
    fn merged_packets_come_at_once_and_none_is_kept_for_ever() {
        let mut line = line();
        line.fail(LineFault::MergedPackets { packets: 3 }, Until::Packets(5));
        assert_eq!(line.receive(b"?C\r?C\r", 0.0), b"");
        assert_eq!(line.receive(b"?C\r", 0.1), [VALUE; 3].concat());
        assert_eq!(line.receive(b"?C\r", 0.2), b"");
        assert_eq!(line.receive(b"?C\r", 0.3), [VALUE; 2].concat());
    }

    #[test]
    fn garbage_and_a_nul_stand_before_a_packet() {
        let mut line = once(LineFault::Garbage(Some(b"#!".to_vec())));
        assert_eq!(line.receive(b"?C\r", 0.0), b"#!12.3 N\r\n");
        let mut line = once(LineFault::NulBefore);
        assert_eq!(line.receive(b"?C\r", 0.0), b"\x0012.3 N\r\n");
    }

    #[test]
    fn an_echo_repeats_the_bytes_of_the_host() {
        let mut line = line();
        line.fail(LineFault::Echo, Until::Mended);
        assert_eq!(line.receive(b"?C\r", 0.0), b"?C\r12.3 N\r\n");
        line.mend(&LineFault::Echo);
        assert_eq!(line.receive(b"?C\r", 1.0), VALUE);
    }

    #[test]
    fn a_late_reply_comes_when_the_next_request_has_gone() {
        let mut line = once(LineFault::LateReply { by_s: 0.5 });
        assert_eq!(line.receive(b"?C\r", 0.0), b"");
        assert_eq!(line.receive(b"RS\r", 0.4), b"");
        assert_eq!(line.tick(0.5), b"12.3 N\r\nemulated mark10-series5\r\n");
    }

    #[test]
    fn silence_ends_with_its_time_and_commands_in_it_are_lost() {
        let mut line = line();
        line.fail(LineFault::Silence, Until::Time(2.0));
        assert_eq!(line.receive(b"?C\rZ\r", 0.0), b"");
        assert_eq!(line.tick(1.9), b"");
        assert_eq!(line.receive(b"?C\r", 2.0), VALUE);
    }
}
