//! Decoding compared with emulated gauges: all shipped ones from their descriptions, and those that are written by hand from the makers' manuals,
//! which share no code with the decoder.

use std::sync::{Arc, Mutex};

use stiffbench_gauges::description::{SignMeaning, UnitSource};
use stiffbench_gauges::emulator::{EmulatedGauge, PanelAction};
use stiffbench_gauges::{
    Channel, CommandRole, Decoded, Decoder, Expect, InstrumentDescription, Meaning, Sample,
};
use stiffbench_test_files::shipped_instruments;

use crate::oracles::{ORACLES, Oracle};
use crate::support::{samples, shipped_instrument};

/// Who sends the bytes.
enum Source {
    Described(Box<EmulatedGauge>),
    ByHand(Oracle),
}

/// An emulated gauge and the decoder of its description.
struct Pair {
    name: &'static str,
    truth: Arc<Mutex<f64>>,
    gauge: Source,
    description: InstrumentDescription,
    decoder: Decoder,
    now_s: f64,
}

impl Pair {
    fn described(name: &'static str) -> Self {
        let truth = Arc::new(Mutex::new(0.0));
        let shared = Arc::clone(&truth);
        let shown = Arc::new(move || *shared.lock().unwrap());
        let gauge = EmulatedGauge::described(&shipped_instrument(name), shown);
        Self::of(name, truth, Source::Described(Box::new(gauge)))
    }

    fn by_hand(name: &'static str, oracle: Oracle) -> Self {
        Self::of(name, Arc::clone(&oracle.truth), Source::ByHand(oracle))
    }

    fn of(name: &'static str, truth: Arc<Mutex<f64>>, gauge: Source) -> Self {
        let description = shipped_instrument(name);
        Self {
            name,
            truth,
            gauge,
            decoder: decoder(&description, first_unit(&description)),
            description,
            now_s: 0.0,
        }
    }

    /// All shipped gauges as they are described, and some as their makers have them.
    fn all() -> impl Iterator<Item = Self> {
        let shipped = shipped_instruments().iter();
        let by_hand = ORACLES.iter().map(|(name, new)| Self::by_hand(name, new()));
        shipped
            .map(|file| Self::described(file.name))
            .chain(by_hand)
    }

    /// A truth, N or tenths of a millimetre, in SI units.
    fn si(&self, value: f64) -> f64 {
        match self.description.channel {
            Channel::Force => value,
            _ => value * 1e-4,
        }
    }

    fn set(&self, value: f64) {
        *self.truth.lock().unwrap() = self.si(value);
    }

    /// Does something at a described gauge.
    fn press(&mut self, panel: &PanelAction) {
        if let Source::Described(gauge) = &mut self.gauge {
            gauge.press(panel).unwrap();
        }
    }

    /// Sets the unit at the panel, and a decoder that knows of it; `false` if the gauge does not have it.
    fn set_unit(&mut self, unit: &str) -> bool {
        let is_set = match &mut self.gauge {
            Source::Described(gauge) => gauge.press(&PanelAction::Unit(unit.into())).is_ok(),
            Source::ByHand(oracle) => oracle.meter.set_unit(unit),
        };
        if is_set {
            self.decoder = decoder(&self.description, unit);
            if self.description.unit_source() == UnitSource::Query {
                self.ask(CommandRole::QueryUnit);
            }
        }
        is_set
    }

    /// What the decoder makes of the answer to a command, or of what comes by itself.
    fn ask(&mut self, role: CommandRole) -> Vec<Decoded> {
        let mut out = Vec::new();
        self.now_s += 1.0;
        let bytes = match (self.description.command(role), &mut self.gauge) {
            (Some(command), gauge) => {
                self.decoder.asked(role);
                match gauge {
                    Source::Described(gauge) => gauge.receive(&command.bytes, self.now_s),
                    Source::ByHand(oracle) => oracle.receive(&command.bytes, self.now_s),
                }
            }
            (None, Source::Described(gauge)) => gauge.tick(self.now_s),
            (None, Source::ByHand(oracle)) => oracle.tick(self.now_s),
        };
        self.decoder.push(&bytes, self.now_s, &mut out);
        self.decoder.idle(self.now_s + 1.0, &mut out);
        out
    }

    fn samples(&mut self) -> Vec<Sample> {
        let decoded = self.ask(CommandRole::Read);
        samples(&decoded).into_iter().cloned().collect()
    }

    /// Every value comes as the gauge counts it from a zero, within half a step of its display.
    fn values_come_from(&mut self, zero: f64, doing: &str) {
        let sense = match (self.description.channel, self.description.sign.compression) {
            // An emulated gauge of which nobody says it has compression plus.
            (Channel::Force, SignMeaning::Positive | SignMeaning::Ask) => -1.0,
            _ => 1.0,
        };
        for value in [0.0, 1.0, -1.0, -37.3, 70.0, 0.123, zero] {
            self.set(value);
            let samples = self.samples();
            let told = format!("{}, {doing}: {value} as {samples:?}", self.name);
            let sample = samples.last().expect(&told);
            // A float carries no information of the display behind it.
            let step_si = match self.name {
                "hp-modbus" => 0.1,
                _ => sample.resolution_si,
            };
            let off_si = sample.value_si - sense * self.si(value - zero);
            assert!(off_si.abs() <= 0.501 * step_si, "{told}");
        }
    }
}

/// A decoder of a gauge that is set to a unit.
fn decoder(description: &InstrumentDescription, unit: &str) -> Decoder {
    Decoder::new(description, Some(unit))
        .or_else(|_| Decoder::new(description, None))
        .unwrap()
}

fn first_unit(description: &InstrumentDescription) -> &'static str {
    match description.channel {
        Channel::Force => "N",
        _ => "mm",
    }
}

#[test]
fn values_zeros_and_units_come_through_in_every_format() {
    for mut pair in Pair::all() {
        // A stream that begins has nothing to tell yet.
        pair.ask(CommandRole::Read);
        pair.values_come_from(0.0, "as it is switched on");
        let mut zero = 0.0;
        if pair.description.command(CommandRole::Zero).is_some() {
            zero = 12.0;
            pair.set(zero);
            pair.ask(CommandRole::Zero);
            pair.values_come_from(zero, "zeroed");
            assert_eq!(pair.samples().last().unwrap().value_si, 0.0);
        }
        let mut units = 0;
        for unit in ["mN", "kN", "gf", "kgf", "lbf", "ozf", "um", "in"] {
            if pair.set_unit(unit) {
                units += 1;
                pair.values_come_from(zero, unit);
            }
        }
        let is_fixed = pair.description.unit_source() == UnitSource::Fixed;
        let is_by_hand = matches!(pair.gauge, Source::ByHand(_));
        assert!(units > 0 || is_fixed || is_by_hand, "{}", pair.name);
        if pair.description.command(CommandRole::SetUnit).is_some() {
            pair.ask(CommandRole::SetUnit);
            pair.decoder = decoder(&pair.description, first_unit(&pair.description));
            pair.values_come_from(zero, "set back to its first unit");
        }
    }
}

#[test]
fn every_command_is_answered_as_described() {
    for mut pair in Pair::all() {
        for role in CommandRole::ALL {
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

/// Gauges whose description states what they send when they are overloaded, or what when their tool is off.
const SAYS_OVERLOAD: [&str; 3] = ["imada-ds2", "sylvac-opto-rs", "magnescale-lt20a"];
const SAYS_TOOL_OFF: [&str; 5] = [
    "aikoh-rx",
    "mitutoyo-01a",
    "sylvac-opto-rs",
    "heidenhain-nd28x",
    "magnescale-lt20a",
];

#[test]
fn an_overloaded_gauge_gives_no_value_or_one_beyond_all_loads() {
    for file in shipped_instruments() {
        let mut pair = Pair::described(file.name);
        pair.set(10.0);
        pair.ask(CommandRole::Read);
        pair.press(&PanelAction::Overload(true));
        let samples = pair.samples();
        if SAYS_OVERLOAD.contains(&pair.name) {
            assert!(samples.is_empty(), "{}: {samples:?}", pair.name);
        } else {
            let beyond = |sample: &Sample| sample.value_si.abs() > pair.si(500.0);
            assert!(
                !samples.is_empty() && samples.iter().all(beyond),
                "{}: {samples:?}",
                pair.name
            );
        }
        pair.press(&PanelAction::Overload(false));
        assert!(!pair.samples().is_empty(), "{}", pair.name);
    }
}

#[test]
fn a_gauge_without_its_probe_reports_it_or_keeps_sending() {
    for file in shipped_instruments() {
        let mut pair = Pair::described(file.name);
        pair.ask(CommandRole::Read);
        pair.press(&PanelAction::ToolOff(true));
        let says = SAYS_TOOL_OFF.contains(&pair.name);
        assert_eq!(pair.samples().is_empty(), says, "{}", pair.name);
    }
}

/// A peak or a held value is told where the description has a word for it: in the packet or in the answer to the question for the mode.
#[test]
fn peaks_and_holds_are_reported_where_the_protocol_can() {
    for (name, panel) in [
        ("mark10-series5", PanelAction::PeakMode(true)),
        ("aikoh-rx", PanelAction::PeakMode(true)),
        ("imada-ds2", PanelAction::PeakMode(true)),
        ("heidenhain-nd28x", PanelAction::PeakMode(true)),
        ("sylvac-opto-rs", PanelAction::PeakMode(true)),
        ("cdi-logic", PanelAction::Hold(true)),
        ("mark10-series5", PanelAction::LowBattery(true)),
    ] {
        let mut pair = Pair::described(name);
        pair.press(&panel);
        pair.ask(CommandRole::QueryMode);
        assert!(pair.samples().is_empty(), "{name}");
    }
}

/// Where the command for a value is said to be answered by the running one, peaks and holds do not come into it.
#[test]
fn a_running_value_runs_whatever_the_display_shows() {
    for (name, runs) in [("mark10-series5", true), ("sauter-fh", false)] {
        for panel in [PanelAction::PeakMode(true), PanelAction::Hold(true)] {
            let mut pair = Pair::described(name);
            pair.set(-60.0);
            pair.press(&panel);
            pair.samples();
            pair.set(-10.0);
            let shown = pair.samples().last().unwrap().value_si.abs();
            assert_eq!(shown, if runs { 10.0 } else { 60.0 }, "{name} {panel:?}");
        }
    }
}
