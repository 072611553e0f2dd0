//! From a packet that carries a value to a sample, or to why it must not be used.

use crate::description::{CommandRole, InstrumentDescription, UnitSource};
use crate::grammar::{FieldPattern, PacketField, ValuePacket};
use crate::registers::Registers;
use crate::sample::{Mark, Sample};
use stiffbench_units_and_text::quantity::Kind;

use super::packet_values::{PacketNumber, PacketUnit, PacketValues, packet_values};
use super::reply::raw_text;
use super::{Decoded, Decoder, DecoderError, rejected};

/// Whether a gauge can be used with this unit.
pub(super) fn check_unit(
    description: &InstrumentDescription,
    unit: Option<&str>,
) -> Result<(), DecoderError> {
    let instrument = || description.name.clone();
    let choices = || description.units.choices.join(", ");
    let source = description.units.source;
    let Some(unit) = unit else {
        return match source {
            UnitSource::Configuration => Err(DecoderError::UnitNeeded {
                instrument: instrument(),
                choices: choices(),
            }),
            _ => Ok(()),
        };
    };
    let kind = description.channel.kind();
    let pinned = matches!(source, UnitSource::Configuration | UnitSource::Query);
    let chosen = || {
        description
            .units
            .choices
            .iter()
            .any(|choice| choice == unit)
    };
    if kind.si_factor(unit).is_some() && (!pinned || chosen()) {
        return Ok(());
    }
    Err(DecoderError::UnitUnknown {
        instrument: instrument(),
        quantity: description.channel.to_string(),
        unit: unit.to_owned(),
        choices: if pinned {
            choices()
        } else {
            kind.units().to_owned()
        },
    })
}

/// A number before it is a sample.
struct NumberCandidate {
    kind: Kind,
    value: f64,
    step: f64,
    /// Digits behind the point, where digits were sent.
    decimals: Option<u8>,
    unit: String,
}

impl Decoder {
    /// The samples of a packet, or why it has none; `None` if it is no packet with a value.
    ///
    /// With `only_with_unit` a packet counts only if it carries its unit: an identity may be all digits.
    pub(super) fn values(
        &mut self,
        bytes: &[u8],
        at_s: f64,
        whole: bool,
        only_with_unit: bool,
    ) -> Option<Vec<Decoded>> {
        let candidates = self.candidates(bytes, whole, only_with_unit)?;
        let samples = candidates.and_then(|(candidates, marks)| {
            let samples = candidates.into_iter();
            samples
                .map(|candidate| self.sample(candidate, bytes, at_s, &marks))
                .collect::<Result<Vec<Sample>, String>>()
        });
        let requested = self.values_due > 0;
        self.values_due = self.values_due.saturating_sub(1);
        if self.waiting == Some(CommandRole::Read) {
            self.waiting = None;
        }
        Some(match samples {
            Err(reason) => vec![rejected(bytes, at_s, reason)],
            Ok(samples) => {
                let unrequested = !requested && !self.streaming;
                let marked = samples.into_iter().map(|mut sample| {
                    if unrequested {
                        sample.marks.push(Mark::Unrequested);
                    }
                    Decoded::Sample(sample)
                });
                marked.collect()
            }
        })
    }

    /// The numbers of a packet and their marks, or why there are none; `None` if no pattern covers it.
    #[expect(clippy::type_complexity, reason = "named nowhere else")]
    fn candidates(
        &self,
        bytes: &[u8],
        whole: bool,
        only_with_unit: bool,
    ) -> Option<Result<(Vec<NumberCandidate>, Vec<Mark>), String>> {
        self.description
            .grammar
            .values
            .iter()
            .find_map(|packet| match packet {
                ValuePacket::Registers(registers) => {
                    let candidate = self.register_value(registers, bytes);
                    Some(candidate.map(|candidate| (vec![candidate], Vec::new())))
                }
                ValuePacket::Text(pattern) => {
                    let counts = (whole || pattern.begins_with_mark())
                        && (!only_with_unit || has_unit(pattern));
                    let fields = counts.then(|| pattern.matches(bytes)).flatten()?;
                    Some(self.text_values(packet_values(&fields)))
                }
            })
    }

    fn register_value(
        &self,
        registers: &Registers,
        bytes: &[u8],
    ) -> Result<NumberCandidate, String> {
        let read = registers.read(bytes)?;
        let unit = self.unit_of(&PacketUnit::Absent)?;
        let mut resolution = self.description.physical.resolution.iter();
        let step = resolution
            .find(|(name, _)| *name == unit)
            .map_or(read.step, |(_, step)| *step);
        Ok(NumberCandidate {
            kind: self.description.channel.kind(),
            value: if read.value == 0.0 { 0.0 } else { read.value },
            step,
            decimals: None,
            unit,
        })
    }

    fn text_values(
        &self,
        values: PacketValues,
    ) -> Result<(Vec<NumberCandidate>, Vec<Mark>), String> {
        if !values.refusals.is_empty() {
            return Err(values.refusals.join("; "));
        }
        let numbers = values.numbers.iter();
        let candidates = numbers.map(|number| self.text_value(number, &values.unit));
        Ok((candidates.collect::<Result<_, _>>()?, values.marks))
    }

    fn text_value(
        &self,
        number: &PacketNumber,
        unit: &PacketUnit,
    ) -> Result<NumberCandidate, String> {
        let (channel, unit) = match &number.other {
            Some((channel, unit)) => (*channel, unit.clone()),
            None => (self.description.channel, self.unit_of(unit)?),
        };
        Ok(NumberCandidate {
            kind: channel.kind(),
            value: number.value,
            step: number.step,
            decimals: number.decimals,
            unit,
        })
    }

    /// The unit of a value.
    fn unit_of(&self, sent: &PacketUnit) -> Result<String, String> {
        let units = &self.description.units;
        let kind = self.description.channel;
        match sent {
            PacketUnit::Known(unit) => return Ok(unit.clone()),
            PacketUnit::Unknown(text) => {
                return Err(format!(
                    "wrong unit: `{text}` is not a unit of {kind} that this gauge sends; set the unit at the gauge"
                ));
            }
            PacketUnit::Place(place) => {
                if let Some(code) = self.unit_list.as_ref().and_then(|list| list.get(*place)) {
                    return self.listed_unit(code);
                }
            }
            PacketUnit::Absent => {}
        }
        let unit = match (units.source, &self.reported, &self.configured) {
            (UnitSource::Fixed, ..) => units.fixed.as_ref(),
            (UnitSource::Query, Some(reported), Some(configured)) if reported != configured => {
                return Err(format!(
                    "wrong unit: the gauge reports {reported}, but {configured} is configured; set the unit at the gauge"
                ));
            }
            (UnitSource::Query, Some(reported), _) => Some(reported),
            (_, _, configured) => configured.as_ref(),
        };
        unit.cloned().ok_or_else(|| {
            "the packet carries no unit, and none is configured: make the gauge send it, or configure the unit".to_owned()
        })
    }

    /// The unit that a code of the gauge's own list means.
    fn listed_unit(&self, code: &str) -> Result<String, String> {
        let units = &self.description.units;
        match (units.named_by(code), &self.configured) {
            (None, _) => Err(format!(
                "wrong unit: the gauge reports unit code {code}, expected one of {}; set the unit at the gauge",
                self.description.channel
            )),
            (Some(unit), Some(configured)) if unit != configured => Err(format!(
                "wrong unit: the gauge shows {unit}, and {configured} was configured; set the unit at the gauge"
            )),
            (Some(unit), _) => Ok(unit.to_owned()),
        }
    }

    /// A sample, or why the number must not be one.
    fn sample(
        &self,
        candidate: NumberCandidate,
        bytes: &[u8],
        at_s: f64,
        marks: &[Mark],
    ) -> Result<Sample, String> {
        let NumberCandidate {
            kind,
            value,
            step,
            decimals,
            unit,
        } = candidate;
        if let Some(objection) = &self.objection {
            return Err(objection.clone());
        }
        let factor = kind.si_factor(&unit).ok_or_else(|| {
            format!(
                "wrong unit: `{unit}` is not a unit of {}",
                self.description.channel
            )
        })?;
        let own = kind == self.description.channel.kind();
        if own {
            self.check_decimals(&unit, decimals)?;
            self.check_size(value * factor, value, &unit)?;
        }
        Ok(Sample {
            kind,
            value_si: value * factor,
            resolution_si: step * factor,
            value,
            unit: unit.into(),
            raw: raw_text(bytes),
            at_s,
            // The place of a packet is that of its fragment.
            bytes: [0; 2],
            marks: marks.to_vec(),
        })
    }

    /// A unit that was switched at the panel shows in the number of decimals where packets do not carry it.
    fn check_decimals(&self, unit: &str, decimals: Option<u8>) -> Result<(), String> {
        let mut known = self.description.physical.decimals.iter();
        match (known.find(|(name, _)| name == unit), decimals) {
            (Some((_, possible)), Some(sent)) if !possible.contains(&sent) => Err(format!(
                "{sent} decimals, and in {unit} this gauge sends {}: the unit was switched at the gauge, or bytes are missing",
                possible
                    .iter()
                    .map(ToString::to_string)
                    .collect::<Vec<_>>()
                    .join(" or ")
            )),
            _ => Ok(()),
        }
    }

    fn check_size(&self, value_si: f64, value: f64, unit: &str) -> Result<(), String> {
        match self.description.physical.plausible_si {
            Some(most_si) if value_si.abs() > most_si => {
                let kind = self.description.channel.kind();
                let si = if kind == Kind::Force { "N" } else { "m" };
                Err(format!(
                    "{value} {unit} is beyond anything that this gauge measures ({most_si} {si})"
                ))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a packet carries its unit.
fn has_unit(pattern: &FieldPattern) -> bool {
    pattern
        .fields
        .iter()
        .any(|field| matches!(field, PacketField::Unit { .. }))
}
