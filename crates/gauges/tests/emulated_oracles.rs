//! Gauges emulated from descriptions compared with those written by hand from what the makers print: the same bytes, or a difference that is listed
//! here with its reason.

use std::sync::Arc;

use stiffbench_gauges::emulator::{EmulatedGauge, PanelAction};
use stiffbench_gauges::{Channel, CommandRole, InstrumentDescription};

use crate::oracles::{ORACLES, Oracle, Trouble, oracle};
use crate::support::shipped_instrument;

/// An answer in which the two differ: gauge, question, what the hand-written one sends, what the described one sends.
type Difference = (&'static str, &'static [u8], &'static str, &'static str);

/// All differences in answers to commands.
#[rustfmt::skip]
const ANSWERS: [Difference; 7] = [
    // A description states which words mean trouble, not what else there is to tell: of identity and mode it gives no example.
    ("mark10-series5", b"RS\r", "3791204\r\n", "emulated mark10-series5\r\n"),
    ("mark10-series5", b"LIST\r", "V1.00;N;CUR;FLTC8;FLTP1;AOUT00;AOFF5;FULL;MIT;POL;B0\r\n", "RUN\r\n"),
    ("mitutoyo-01a", b"V\r", "1USB-ITN 1.00\r", "1emulated mitutoyo-01a\r"),
    ("mahr-dk-u1", b"ID?\r", "T 4337661 S 12345678\r", "emulated mahr-dk-u1\r"),
    // Either spelling is a code of the unit; the one of values stands first in the description.
    ("mahr-dk-u1", b"UN?\r", "MM\r", "mm\r"),
    // The makers have more commands than the description needs.
    ("mark10-series5", b"?\r", "0.0 N\r\n", "*10\r\n"),
    // Public programs never saw what an unknown command does; by the description it is a format error.
    ("mitutoyo-01a", b"Z\r", "", "902\r"),
];

/// All differences of gauges in trouble: gauge, trouble, how the answer of the hand-written one begins, and that of the described one.
#[rustfmt::skip]
const TROUBLES: [(&str, Trouble, &str, &str); 3] = [
    // The maker carries no information of overrange; `ERR3` is a choice, and no overload to the description.
    ("mahr-dk-u1", Trouble::Overload, "ERR3\r", "+57.500 mm\r"),
    // The description has no capacity: 50 mm is usual, the range of this one ends where its register does.
    ("shahe-modbus", Trouble::Overload, "\x01\x03\x04\x00\x00\u{ff}\u{ff}", "\x01\x03\x04\x00\x00\u{e0}\u{9c}"),
    // The middle digit is the channel, and open in the description.
    ("mitutoyo-01a", Trouble::ToolOff, "911\r", "901\r"),
];

/// The same gauge twice on one truth.
struct Twins {
    name: &'static str,
    oracle: Oracle,
    described: EmulatedGauge,
    description: InstrumentDescription,
    now_s: f64,
}

impl Twins {
    fn of(name: &'static str) -> Self {
        let oracle = oracle(name);
        let truth = Arc::clone(&oracle.truth);
        let description = shipped_instrument(name);
        let shown = Arc::new(move || *truth.lock().unwrap());
        Self {
            name,
            described: EmulatedGauge::described(&description, shown),
            oracle,
            description,
            now_s: 0.0,
        }
    }

    fn all() -> impl Iterator<Item = Self> {
        ORACLES.iter().map(|(name, _)| Self::of(name))
    }

    /// Sets the truth, N or tenths of a millimetre.
    fn set(&self, value: f64) {
        *self.oracle.truth.lock().unwrap() = match self.oracle.channel {
            Channel::Force => value,
            _ => 1e-4 * value,
        };
    }

    fn both(&mut self, bytes: &[u8]) -> [Vec<u8>; 2] {
        self.now_s += 1.0;
        [
            self.oracle.receive(bytes, self.now_s),
            self.described.receive(bytes, self.now_s),
        ]
    }

    /// What both answer to a command of the description.
    fn same(&mut self, role: CommandRole) -> Vec<u8> {
        let bytes = self.description.command(role).unwrap().bytes.clone();
        let sent = self.both(&bytes);
        self.assert_same(sent)
    }

    fn assert_same(&self, sent: [Vec<u8>; 2]) -> Vec<u8> {
        let [by_hand, described] = sent;
        // Seven characters of a Mahr, of which the description takes any from five to nine: the described one sends as few as there are.
        let by_hand = match self.name {
            "mahr-dk-u1" => without_noughts(&by_hand),
            _ => by_hand,
        };
        let [a, b] = [&by_hand, &described].map(|bytes| bytes.escape_ascii().to_string());
        assert_eq!(a, b, "{}", self.name);
        by_hand
    }

    fn read_in_turn(&mut self) {
        for value in [0.0, 1.0, -1.0, -37.3, 70.0, 0.123, -0.04, 299.96] {
            self.set(value);
            assert!(!self.same(CommandRole::Read).is_empty(), "{}", self.name);
        }
    }
}

/// Numbers without the noughts before them, but for the last before a point.
fn without_noughts(bytes: &[u8]) -> Vec<u8> {
    let mut kept: Vec<u8> = Vec::new();
    for (place, byte) in bytes.iter().enumerate() {
        let begins = kept.last().is_none_or(|last| b"+-\r".contains(last));
        let goes_on = bytes.get(place + 1).is_some_and(u8::is_ascii_digit);
        if !(begins && goes_on && *byte == b'0') {
            kept.push(*byte);
        }
    }
    kept
}

#[test]
fn values_zeros_and_units_are_the_same_bytes() {
    for mut twins in Twins::all() {
        twins.read_in_turn();
        if twins.description.command(CommandRole::Zero).is_some() {
            twins.set(12.3);
            twins.same(CommandRole::Zero);
            twins.same(CommandRole::Read);
            twins.read_in_turn();
        }
        for unit in ["kN", "kgF", "lbF", "ozF", "in", "inch", "mm"] {
            if !twins.oracle.meter.set_unit(unit) {
                continue;
            }
            let pressed = twins.described.press(&PanelAction::Unit(unit.into()));
            assert!(pressed.is_ok(), "{}: {unit}", twins.name);
            twins.read_in_turn();
        }
        if twins.description.command(CommandRole::SetUnit).is_some() {
            twins.same(CommandRole::SetUnit);
            twins.read_in_turn();
        }
    }
}

#[test]
fn streams_are_the_same_bytes() {
    for name in ["mark10-series5", "mahr-dk-u1"] {
        let mut twins = Twins::of(name);
        twins.set(-37.3);
        twins.same(CommandRole::StreamStart);
        let mut packets = 0;
        for ms in 1..=2000 {
            let at_s = twins.now_s + f64::from(ms) / 1000.0;
            let sent = [twins.oracle.tick(at_s), twins.described.tick(at_s)];
            packets += usize::from(!twins.assert_same(sent).is_empty());
        }
        assert_eq!(packets, 20, "{name}");
        twins.now_s += 2.0;
        twins.same(CommandRole::StreamStop);
        let later_s = twins.now_s + 2.0;
        let sent = [twins.oracle.tick(later_s), twins.described.tick(later_s)];
        assert_eq!(twins.assert_same(sent), b"");
    }
}

#[test]
fn commands_are_answered_and_refused_with_the_same_bytes_but_for_those_listed() {
    for mut twins in Twins::all() {
        let commands = CommandRole::ALL.into_iter().filter_map(|role| {
            let command = twins.description.command(role)?;
            Some(command.bytes.clone())
        });
        let mut asked: Vec<Vec<u8>> = commands.collect();
        asked.extend(match twins.name {
            "hp-modbus" | "shahe-modbus" => vec![
                // Other registers, another slave, a wrong check sum.
                vec![0x01, 0x03, 0x00, 0x40, 0x00, 0x02, 0xc5, 0xdf],
                vec![0x02, 0x03, 0x00, 0x00, 0x00, 0x02, 0xc4, 0x38],
                vec![0x01, 0x03, 0x00, 0x00, 0x00, 0x02, 0xc4, 0x00],
            ],
            "mitutoyo-01a" => vec![b"Z\r".to_vec()],
            "mark10-series5" => vec![b"FOO\r".to_vec(), b"?\r".to_vec(), b"\n".to_vec()],
            _ => vec![b"HELLO\r".to_vec(), b"\n".to_vec()],
        });
        for bytes in asked {
            let [by_hand, described] = twins.both(&bytes);
            let mut listed = ANSWERS.iter();
            match listed.find(|(name, asked, ..)| *name == twins.name && *asked == bytes) {
                Some((_, _, a, b)) => assert_eq!(
                    [by_hand.as_slice(), &described],
                    [a.as_bytes(), b.as_bytes()],
                    "{}",
                    twins.name
                ),
                None => _ = twins.assert_same([by_hand, described]),
            }
        }
    }
}

#[test]
fn half_a_request_is_forgotten_after_a_silence() {
    for name in ["hp-modbus", "shahe-modbus"] {
        let mut twins = Twins::of(name);
        assert_eq!(
            twins.both(&[0x01, 0x03, 0x00, 0x00]),
            [Vec::<u8>::new(), Vec::new()]
        );
        assert!(!twins.same(CommandRole::Read).is_empty(), "{name}");
    }
}

#[test]
fn trouble_is_reported_with_equal_bytes_but_for_listed_differences() {
    for mut twins in Twins::all() {
        for trouble in [Trouble::Overload, Trouble::ToolOff, Trouble::LowBattery] {
            let panel = |on| match trouble {
                Trouble::Overload => PanelAction::Overload(on),
                Trouble::ToolOff => PanelAction::ToolOff(on),
                Trouble::LowBattery => PanelAction::LowBattery(on),
            };
            twins.set(5.0);
            twins.oracle.meter.trouble = Some(trouble);
            twins.described.press(&panel(true)).unwrap();
            let read = twins.description.command(CommandRole::Read).unwrap();
            let sent = twins.both(&read.bytes.clone());
            let mut listed = TROUBLES.iter();
            match listed.find(|(name, what, ..)| (*name, *what) == (twins.name, trouble)) {
                Some((_, _, a, b)) => {
                    let begins = |sent: &[u8], with: &str| {
                        let with: Vec<u8> = with.chars().map(|c| c as u8).collect();
                        assert!(sent.starts_with(&with), "{}: {sent:x?}", twins.name);
                    };
                    begins(&sent[0], a);
                    begins(&sent[1], b);
                }
                None => _ = twins.assert_same(sent),
            }
            twins.described.press(&panel(false)).unwrap();
        }
    }
    // The word that means a low battery is the same in the settings of a Mark-10.
    let mut twins = Twins::of("mark10-series5");
    twins.oracle.meter.trouble = Some(Trouble::LowBattery);
    twins
        .described
        .press(&PanelAction::LowBattery(true))
        .unwrap();
    let [by_hand, described] = twins.both(b"LIST\r");
    assert!(by_hand.ends_with(b";B3\r\n") && described == b"B3\r\n");
}

#[test]
fn a_press_of_the_data_key_sends_the_same_bytes() {
    for mut twins in Twins::all() {
        // Neither Modbus gauge has such a key.
        if twins.name.ends_with("modbus") {
            continue;
        }
        twins.set(-37.3);
        let pressed = twins.described.press(&PanelAction::DataKey).unwrap();
        let sent = [twins.oracle.data_key(), pressed.concat()];
        assert!(!twins.assert_same(sent).is_empty());
    }
}
