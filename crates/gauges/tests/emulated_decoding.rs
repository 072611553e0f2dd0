//! Decoding held against emulated gauges: the bytes of shipped ones are written by hand from the makers' manuals, and share no code with the
//! decoder. Gauges that are emulated from their description do the same here.

use std::sync::{Arc, Mutex};

use stiffbench_gauges::emulator::{EmulatedGauge, Panel, emulated_gauges};
use stiffbench_gauges::{
    Channel, Decoded, Decoder, Expect, InstrumentDescription, Meaning, Role, Sample,
};
use stiffbench_test_files::shipped_instruments;

use crate::support::shipped_instrument;

/// An emulated gauge and the decoder of its description.
struct Pair {
    name: &'static str,
    truth: Arc<Mutex<f64>>,
    /// Emulated from its description.
    is_described: bool,
    gauge: EmulatedGauge,
    description: InstrumentDescription,
    decoder: Decoder,
    now_s: f64,
}

impl Pair {
    fn new(name: &'static str, channel: Channel, is_described: bool) -> Self {
        let truth = Arc::new(Mutex::new(0.0));
        let shared = Arc::clone(&truth);
        let shown = Arc::new(move || *shared.lock().unwrap());
        let description = shipped_instrument(name);
        let gauge = if is_described {
            EmulatedGauge::described(&description, shown)
        } else {
            EmulatedGauge::new(name, shown).unwrap()
        };
        let unit = match channel {
            Channel::Force => "N",
            Channel::Displacement => "mm",
        };
        let decoder = Decoder::new(&description, Some(unit))
            .or_else(|_| Decoder::new(&description, None))
            .unwrap();
        Self {
            name,
            truth,
            is_described,
            gauge,
            description,
            decoder,
            now_s: 0.0,
        }
    }

    /// All shipped gauges, as their makers have them and as they are described.
    fn all() -> impl Iterator<Item = Self> {
        let pairs = |(name, channel)| [false, true].map(|is| Self::new(name, channel, is));
        emulated_gauges().flat_map(pairs)
    }

    fn set(&mut self, value_si: f64) {
        *self.truth.lock().unwrap() = value_si;
    }

    /// What the decoder makes of the answer to a command, or of what comes by itself.
    fn ask(&mut self, role: Role) -> Vec<Decoded> {
        let mut out = Vec::new();
        self.now_s += 1.0;
        let bytes = match self.description.command(role) {
            Some(command) => {
                self.decoder.asked(role);
                self.gauge.receive(&command.bytes.clone(), self.now_s)
            }
            None => self.gauge.tick(self.now_s),
        };
        self.decoder.push(&bytes, self.now_s, &mut out);
        self.decoder.idle(self.now_s + 1.0, &mut out);
        out
    }

    fn samples(&mut self) -> Vec<Sample> {
        let decoded = self.ask(Role::Read).into_iter();
        let samples = decoded.filter_map(|decoded| match decoded {
            Decoded::Sample(sample) => Some(sample),
            _ => None,
        });
        samples.collect()
    }
}

#[test]
fn every_shipped_gauge_is_emulated_and_no_other() {
    let mut shipped: Vec<&str> = shipped_instruments().iter().map(|s| s.name).collect();
    let mut emulated: Vec<&str> = emulated_gauges().map(|(name, _)| name).collect();
    shipped.sort_unstable();
    emulated.sort_unstable();
    assert_eq!(shipped, emulated);
}

#[test]
fn values_come_through_in_every_format() {
    for mut pair in Pair::all() {
        // A stream that begins has nothing to tell yet.
        pair.ask(Role::Read);
        let mut signs = Vec::new();
        for value_si in [0.0, 1.0, -1.0, -37.3, 70.0, 0.123] {
            let value_si = match pair.gauge.channel() {
                Channel::Force => value_si,
                Channel::Displacement => value_si * 1e-4,
            };
            pair.set(value_si);
            let samples = pair.samples();
            let sample = samples
                .last()
                .unwrap_or_else(|| panic!("{}: no sample of {value_si}", pair.name));
            let off = (sample.value_si.abs() - value_si.abs()).abs();
            // A float says nothing of the display behind it.
            let step_si = if pair.name == "hp-modbus" {
                0.1
            } else {
                sample.resolution_si
            };
            assert!(
                off <= 0.51 * step_si,
                "{}: {value_si} as {sample:?}",
                pair.name
            );
            if value_si.abs() > step_si {
                signs.push(sample.value_si * value_si > 0.0);
            }
        }
        assert!(
            signs.iter().all(|sign| *sign == signs[0]),
            "{}: {signs:?}",
            pair.name
        );
    }
}

#[test]
fn every_command_is_answered_as_its_description_says() {
    for mut pair in Pair::all() {
        for role in Role::ALL {
            let Some(expects) = pair
                .description
                .command(role)
                .map(|command| command.expects)
            else {
                continue;
            };
            let decoded = pair.ask(role);
            let as_expected = match expects {
                // An echo that not every gauge of the family has is no harm; a value or rubbish would be.
                Expect::Nothing => decoded.iter().all(|one| matches!(one, Decoded::Reply(_))),
                Expect::Value => matches!(decoded[..], [Decoded::Sample(_)]),
                Expect::Acknowledgement => matches!(
                    &decoded[..],
                    [Decoded::Reply(reply)] if reply.meaning == Meaning::Acknowledged
                ),
                Expect::Echo => matches!(
                    &decoded[..],
                    [Decoded::Reply(reply)] if !matches!(reply.meaning, Meaning::Refused(_))
                ),
                Expect::Text => matches!(
                    &decoded[..],
                    [Decoded::Reply(reply)] if !matches!(reply.meaning, Meaning::Acknowledged | Meaning::Refused(_))
                ),
            };
            assert!(as_expected, "{} {role}: {decoded:?}", pair.name);
        }
    }
}

#[test]
fn a_zero_command_zeroes() {
    for mut pair in Pair::all() {
        if pair.description.command(Role::Zero).is_none() {
            continue;
        }
        pair.set(1e-3);
        pair.ask(Role::Zero);
        assert_eq!(
            pair.samples().last().unwrap().value_si,
            0.0,
            "{}",
            pair.name
        );
    }
}

/// Gauges that say when they are overloaded, beyond their range, or have nothing to tell.
const SAYS_SO: [&str; 8] = [
    "imada-ds2",
    "mitutoyo-01a",
    "sylvac-opto-rs",
    "mahr-dk-u1",
    "heidenhain-nd28x",
    "magnescale-lt20a",
    "generic-ascii",
    "generic-ascii-displacement",
];

#[test]
fn an_overloaded_gauge_gives_no_value_or_one_beyond_all_loads() {
    for mut pair in Pair::all() {
        pair.set(1e-3);
        pair.ask(Role::Read);
        for panel in [Panel::ToolOff(true), Panel::Overload(true)] {
            pair.gauge.press(&panel, pair.now_s).unwrap();
        }
        let samples = pair.samples();
        if SAYS_SO.contains(&pair.name) || (pair.is_described && samples.is_empty()) {
            assert!(samples.is_empty(), "{}: {samples:?}", pair.name);
            continue;
        }
        let beyond_si = match pair.gauge.channel() {
            Channel::Force => 200.0,
            Channel::Displacement => 0.025,
        };
        let all_beyond = samples
            .iter()
            .all(|sample| sample.value_si.abs() > beyond_si);
        assert!(
            !samples.is_empty() && all_beyond,
            "{}: {samples:?}",
            pair.name
        );
    }
}
