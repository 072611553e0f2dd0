//! Decodes the fields of a matched packet.

use crate::grammar::{ChoiceWord, Matched, PacketField, UnitWord, number_of};
use crate::sample::{Channel, Mark};

use super::reply::raw_text;

/// The decoded fields of a packet.
#[derive(Debug, Clone, Default)]
pub(super) struct PacketValues {
    /// The numbers, in order.
    pub(super) numbers: Vec<PacketNumber>,
    /// The unit of the gauge's own number.
    pub(super) unit: PacketUnit,
    /// Why the value must not be used.
    pub(super) refusals: Vec<String>,
    /// What comes with the value.
    pub(super) marks: Vec<Mark>,
}

/// The unit that a packet carries.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) enum PacketUnit {
    /// None.
    #[default]
    Absent,
    /// This one.
    Known(String),
    /// The unit at this place of the list that the gauge gives, from 0.
    Place(usize),
    /// A text that names none of the gauge's quantity.
    Unknown(String),
}

/// The number of a packet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PacketNumber {
    /// In the sign as sent; zero has none.
    pub(super) value: f64,
    /// Step of the last digit.
    pub(super) step: f64,
    /// Digits behind the point, where digits were sent.
    pub(super) decimals: Option<u8>,
    /// What it measures and in which unit, where that is not what the gauge does.
    pub(super) other: Option<(Channel, String)>,
}

impl PacketNumber {
    fn new(negative: bool, size: f64, step: f64, decimals: Option<u8>) -> Self {
        let value = if negative { -size } else { size };
        Self {
            value: if value == 0.0 { 0.0 } else { value },
            step,
            decimals,
            other: None,
        }
    }
}

/// The decoded fields of a packet.
pub(super) fn packet_values(fields: &[Matched<'_>]) -> PacketValues {
    let mut values = PacketValues::default();
    // What stands beside a number and belongs to it.
    let beside = |number: usize| {
        let (mut negative, mut point_digit) = (false, None);
        for (place, matched) in fields.iter().enumerate() {
            let belongs = || number_of(fields.iter().map(|one| one.field), place) == Some(number);
            match matched.field {
                PacketField::Sign(texts) if belongs() => {
                    let text = texts.get(matched.alternative);
                    negative = text.is_some_and(|(_, minus)| *minus);
                }
                PacketField::Point { .. } if belongs() => {
                    point_digit = matched.bytes.first().map(|digit| digit - b'0');
                }
                _ => {}
            }
        }
        (negative, point_digit)
    };
    for (place, matched) in fields.iter().enumerate() {
        match matched.field {
            PacketField::Literal(_)
            | PacketField::Any { .. }
            | PacketField::Sign(_)
            | PacketField::Point { .. }
            | PacketField::CheckSum(_) => {}
            PacketField::Number(shape) => {
                let (negative, point_digit) = beside(place);
                let digits = shape.read(matched.bytes, point_digit);
                let (size, decimals) = (digits.value(), Some(digits.decimals));
                values.numbers.push(PacketNumber {
                    other: shape.other.clone(),
                    ..PacketNumber::new(negative, size, digits.step(), decimals)
                });
            }
            PacketField::Integer(shape) => {
                let (negative, _) = beside(place);
                let size = shape.value(shape.counts(matched.bytes).unwrap_or_default());
                values
                    .numbers
                    .push(PacketNumber::new(negative, size, shape.step(), None));
            }
            PacketField::Unit { codes, .. } => match codes.get(matched.alternative) {
                Some((_, UnitWord::Unit(unit))) => values.unit = PacketUnit::Known(unit.clone()),
                Some((_, UnitWord::Refuse(why))) => values.refusals.push(why.clone()),
                None => values.unit = PacketUnit::Unknown(raw_text(matched.bytes).into()),
            },
            PacketField::UnitPlace { .. } => {
                let place = matched.bytes.first().map(|digit| usize::from(digit - b'0'));
                values.unit = place.map_or(PacketUnit::Absent, PacketUnit::Place);
            }
            PacketField::Choice(texts) => match texts.get(matched.alternative) {
                Some((_, ChoiceWord::Refuse(why))) => values.refusals.push(why.clone()),
                Some((_, ChoiceWord::Note(mark))) => values.marks.push(*mark),
                Some((_, ChoiceWord::Good)) | None => {}
            },
        }
    }
    values
}
