//! What a description leaves open, and where it would take one packet for another.

use crate::decode::{Decoded, Decoder};
use crate::grammar::{ChoiceWord, FieldPattern, PacketField, UnitWord, ValuePacket};
use crate::write::{PacketContent, WrittenState};

use super::{CommandRole, InstrumentDescription, Trouble, UnitSource};

/// Numbers that are tried, as shares of the capacity.
const TRIED: [f64; 5] = [0.0, 0.001, 0.12, -0.34, -0.56];

/// A capacity for trying where none is described, N and m.
const SOME_CAPACITY_SI: [f64; 2] = [100.0, 0.01];

impl InstrumentDescription {
    /// What a description leaves open, and where it would take one packet for another, each with what to do.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.gaps();
        for (place, packet) in self.grammar.values.iter().enumerate() {
            let ValuePacket::Text(pattern) = packet else {
                continue;
            };
            let name = format!("value[{place}]");
            let loose = pattern.fields.iter().enumerate();
            warnings.extend(loose.filter_map(|(field, entry)| {
                let passed_over = passed_over(pattern, field, entry)?;
                Some(format!(
                    "{name}.fields[{field}]: `any` skips {passed_over}; if these bytes carry a sign, a mode or an overload, describe them by a choice, or leave them out of `of`"
                ))
            }));
            if self.units.source == UnitSource::Packet && !has_unit(pattern) {
                warnings.push(format!(
                    "{name} carries no unit, and unit.from is \"packet\": a unit switched at the gauge is then not detected; make the gauge send it, or give the decimals of each unit (physical.decimals)"
                ));
            }
            warnings.extend(self.mistaken(&name, pattern));
        }
        warnings
    }

    /// What it leaves open.
    fn gaps(&self) -> Vec<String> {
        let mut gaps = Vec::new();
        let physical = &self.physical;
        if !self.reports_overload() && physical.plausible_si.is_none() {
            gaps.push(
                "what the gauge sends when it is overloaded is not described, and would be a value: overload it a little by hand, and add an [[error]] with meaning = \"overload\", or physical.plausible"
                    .to_owned(),
            );
        }
        if physical.capacity_si.is_none() {
            gaps.push("physical.capacity is missing: give the capacity of your gauge, for example capacity = { N = 500 }".to_owned());
        }
        if physical.resolution.is_empty() && physical.decimals.is_empty() {
            gaps.push(
                "physical.resolution is missing: give the step of the last digit in each unit"
                    .to_owned(),
            );
        }
        if self.units.source == UnitSource::Configuration && physical.decimals.is_empty() {
            gaps.push(
                "packets carry no unit: physical.decimals (digits behind the point in each unit) lets a unit be noticed that is switched at the gauge"
                    .to_owned(),
            );
        }
        gaps
    }

    fn reports_overload(&self) -> bool {
        let grammar = &self.grammar;
        let errors = grammar.errors.iter();
        let mut errors = errors.filter(|error| error.meaning == Trouble::Overload);
        errors.next().is_some()
            || grammar.values.iter().any(|packet| match packet {
                ValuePacket::Text(pattern) => pattern.fields.iter().any(reports_overload),
                ValuePacket::Registers(registers) => !registers.require.is_empty(),
            })
    }

    /// Packets of a pattern that are taken for something else.
    fn mistaken(&self, name: &str, pattern: &FieldPattern) -> Option<String> {
        let kind = self.channel.kind();
        let capacity_si = self.physical.capacity_si.unwrap_or(match self.channel {
            crate::Channel::Force => SOME_CAPACITY_SI[0],
            _ => SOME_CAPACITY_SI[1],
        });
        for (place, unit) in self.units.all().iter().enumerate() {
            let (Some(factor), Ok(place)) = (kind.si_factor(unit), u8::try_from(place)) else {
                continue;
            };
            let decimals = self.physical.decimals.iter();
            let mut decimals = decimals.filter(|(name, _)| name == unit);
            let decimals = decimals
                .next()
                .and_then(|(_, possible)| possible.first().copied());
            for share in TRIED {
                let said = PacketContent {
                    value: share * capacity_si / factor,
                    decimals: decimals.unwrap_or(2),
                    unit,
                    unit_place: place,
                    state: WrittenState::Running,
                    list: None,
                };
                let Some(packet) = pattern.write(&said) else {
                    continue;
                };
                if let Some(mistake) = self.mistake(name, unit, &said, &packet, pattern) {
                    return Some(mistake);
                }
            }
        }
        None
    }

    fn mistake(
        &self,
        name: &str,
        unit: &str,
        said: &PacketContent<'_>,
        packet: &[u8],
        pattern: &FieldPattern,
    ) -> Option<String> {
        let unit_is_sent = has_unit(pattern);
        let configured = (!unit_is_sent).then_some(unit);
        let mut decoder = Decoder::new(self, configured)
            .or_else(|_| Decoder::new(self, None))
            .ok()?;
        decoder.asked(CommandRole::Read);
        let mut decoded = Vec::new();
        decoder.push(&self.framing.ended(packet.to_vec()), 0.0, &mut decoded);
        decoder.idle(1.0, &mut decoded);
        let packet = packet.escape_ascii();
        match decoded.as_slice() {
            [Decoded::Sample(sample)] | [Decoded::Sample(sample), Decoded::Sample(_)] => {
                // What is shown has the digits that there was room for.
                let step = sample.resolution_si / sample.kind.si_factor(&sample.unit)?;
                let same =
                    (sample.value - said.value).abs() <= 0.51 * step && *sample.unit == *unit;
                (!same).then(|| {
                    format!(
                        "a packet of {name}, `{packet}`, means {:.3} {unit} and is read as {} {}: an earlier [[value]] covers it too",
                        said.value, sample.value, sample.unit
                    )
                })
            }
            [Decoded::Rejected(rejected), ..] => Some(format!(
                "a packet of {name}, `{packet}`, is refused: {}",
                rejected.reason
            )),
            [Decoded::Reply(_), ..] => Some(format!(
                "a packet of {name}, `{packet}`, is taken for the answer to a command: a [[reply]] covers it too"
            )),
            _ => Some(format!(
                "a packet of {name}, `{packet}`, is not a packet by [framing]"
            )),
        }
    }
}

fn has_unit(pattern: &FieldPattern) -> bool {
    let is_unit = |field: &PacketField| {
        matches!(
            field,
            PacketField::Unit { .. } | PacketField::UnitPlace { .. }
        )
    };
    pattern.fields.iter().any(is_unit)
}

fn reports_overload(field: &PacketField) -> bool {
    let tells = |why: &str| WrittenState::Overload.is_reported_by(why);
    match field {
        PacketField::Choice(texts) => texts
            .iter()
            .any(|(_, word)| matches!(word, ChoiceWord::Refuse(why) if tells(why))),
        PacketField::Unit { codes, .. } => codes
            .iter()
            .any(|(_, word)| matches!(word, UnitWord::Refuse(why) if tells(why))),
        _ => false,
    }
}

/// What a field without meaning passes over that could have one.
fn passed_over(pattern: &FieldPattern, place: usize, field: &PacketField) -> Option<&'static str> {
    let PacketField::Any { set, .. } = field else {
        return None;
    };
    let next = pattern.fields.get(place + 1);
    let before_number = matches!(
        next,
        Some(PacketField::Sign(_) | PacketField::Number(_) | PacketField::Integer(_))
    );
    if before_number && set.contains(b'-') {
        Some("what may be a sign")
    } else if (b'A'..=b'z').any(|byte| byte.is_ascii_alphabetic() && set.contains(byte)) {
        Some("letters")
    } else if before_number && (b'0'..=b'9').any(|byte| set.contains(byte)) {
        Some("digits in front of the number")
    } else {
        None
    }
}
