//! From the fields of a file to patterns.

use std::fmt::Display;

use crate::Channel;
use crate::check_sum::CheckSum;
use crate::grammar::{
    CharacterSet, ChoiceWord, Count, FieldPattern, PacketField, UnitWord, number_of,
};
use crate::integer::{IntegerCoding, IntegerShape};
use crate::number::{MOST_DIGITS, NumberShape};

use super::entries::{
    BlankPlace, ByteOrder, CheckSumField, ChoiceField, FieldEntry, HEXADECIMAL_DIGITS, HexField,
    IntegerField, NumberField, PointPlace, SignField, UnitField,
};
use super::parse::{EntryPath, Misplaced, key_of};
use super::problem::DescriptionProblem;

/// Most bytes of a packet.
pub(super) const LONGEST_PACKET: usize = 256;

/// Most fields of a packet.
const MOST_FIELDS: usize = 40;

/// What fields need to know of the gauge.
pub(super) struct FieldContext<'a> {
    pub(super) channel: Channel,
    /// Texts of units, the longest first.
    pub(super) codes: &'a [(String, String)],
}

/// A value that cannot be.
pub(super) fn value(path: Vec<EntryPath>, found: impl Display, expected: &str) -> Misplaced {
    let problem = DescriptionProblem::Value {
        key: key_of(&path),
        value: found.to_string(),
        expected: expected.to_owned(),
    };
    Misplaced { path, problem }
}

/// A path and one step more.
pub(super) fn within(path: &[EntryPath], step: impl Into<EntryPath>) -> Vec<EntryPath> {
    let mut longer = path.to_vec();
    longer.push(step.into());
    longer
}

/// The pattern of a packet.
pub(super) fn pattern(
    entries: &[FieldEntry],
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<FieldPattern, Misplaced> {
    let path = within(path, "fields");
    if entries.is_empty() || entries.len() > MOST_FIELDS {
        let expected = format!("1 to {MOST_FIELDS} fields that together cover the packet");
        return Err(value(path, format!("{} fields", entries.len()), &expected));
    }
    let mut fields = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        fields.push(field(entry, &within(&path, index), context)?);
    }
    Ok(FieldPattern { fields })
}

/// The pattern of a packet that carries a value: with one number.
pub(super) fn value_pattern(
    entries: &[FieldEntry],
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<FieldPattern, Misplaced> {
    let pattern = pattern(entries, path, context)?;
    let mut numbers = [0; 2];
    for field in &pattern.fields {
        match field {
            PacketField::Number(shape) => numbers[usize::from(shape.other.is_some())] += 1,
            PacketField::Integer(_) => numbers[0] += 1,
            _ => {}
        }
    }
    if numbers[0] != 1 || numbers[1] > 1 {
        let expected = "one number of the gauge's own quantity (and one of the other at most, with measures and unit); skip everything else in the packet by `any`";
        let found = format!("fields with {} numbers", numbers[0] + numbers[1]);
        return Err(value(within(path, "fields"), found, expected));
    }
    for (place, entry) in pattern.fields.iter().enumerate() {
        if let PacketField::Point { most } = entry {
            let at = within(&within(&within(path, "fields"), place), "point");
            points_at_digits(&pattern, (place, *most), at)?;
        }
    }
    Ok(pattern)
}

/// That a digit for the point has an effect: on a number of decimal digits that sends no point and has no decimals of its own.
fn points_at_digits(
    pattern: &FieldPattern,
    (place, most): (usize, u8),
    at: Vec<EntryPath>,
) -> Result<(), Misplaced> {
    let number = number_of(pattern.fields.iter(), place).map(|number| &pattern.fields[number]);
    match number {
        Some(PacketField::Number(shape)) if shape.least_points == 0 && shape.decimals == 0 => {
            Ok(())
        }
        _ => {
            let expected = "a `number` beside it that has neither `point = \"in-place\"` nor `decimals`: it has no effect on another one";
            Err(value(at, format!("{{ most = {most} }}"), expected))
        }
    }
}

fn field(
    entry: &FieldEntry,
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<PacketField, Misplaced> {
    match entry {
        FieldEntry::Literal(text) => literal(text.as_bytes(), within(path, "literal")),
        FieldEntry::Bytes(bytes) => literal(bytes, within(path, "bytes")),
        FieldEntry::Blanks(count_entry) => Ok(PacketField::Any {
            set: CharacterSet::of(" "),
            count: count(count_entry, within(path, "blanks"))?,
        }),
        FieldEntry::Any(any) => Ok(PacketField::Any {
            set: any
                .of
                .as_deref()
                .map_or_else(CharacterSet::printable, CharacterSet::of),
            count: count(&any.count, within(&within(path, "any"), "count"))?,
        }),
        FieldEntry::Sign(sign) => sign_field(sign, within(path, "sign")),
        FieldEntry::Point(point) if point.most <= 9 => Ok(PacketField::Point { most: point.most }),
        FieldEntry::Point(point) => {
            let path = within(&within(path, "point"), "most");
            Err(value(path, point.most, "a digit, 0 to 9"))
        }
        FieldEntry::Number(number) => number_field(number, &within(path, "number"), context),
        FieldEntry::Hex(hex) => hex_field(hex, &within(path, "hex")),
        FieldEntry::Integer(integer) => integer_field(integer, &within(path, "integer")),
        FieldEntry::Unit(unit) => unit_field(unit, &within(path, "unit"), context),
        FieldEntry::UnitPlace(place) if place.most <= 9 => {
            Ok(PacketField::UnitPlace { most: place.most })
        }
        FieldEntry::UnitPlace(place) => {
            let path = within(&within(path, "unit_place"), "most");
            Err(value(path, place.most, "a digit, 0 to 9"))
        }
        FieldEntry::Choice(choice) => choice_field(choice, within(path, "choice")),
        FieldEntry::CheckSum(sum) => check_sum_field(sum, &within(path, "check_sum")),
    }
}

fn literal(bytes: &[u8], path: Vec<EntryPath>) -> Result<PacketField, Misplaced> {
    if bytes.is_empty() {
        return Err(value(path, "empty", "at least one character"));
    }
    Ok(PacketField::Literal(bytes.to_vec()))
}

/// How many, or [least, most].
fn count(entry: &[usize], path: Vec<EntryPath>) -> Result<Count, Misplaced> {
    let (least, most) = match entry {
        [exactly] => (*exactly, *exactly),
        [least, most] => (*least, *most),
        _ => {
            return Err(value(
                path,
                format!("{entry:?}"),
                "[how many] or [least, most]",
            ));
        }
    };
    if least > most || most == 0 || most > LONGEST_PACKET {
        let expected = format!("least not above most, and most from 1 to {LONGEST_PACKET}");
        return Err(value(path, format!("{entry:?}"), &expected));
    }
    Ok(Count { least, most })
}

fn sign_field(sign: &SignField, path: Vec<EntryPath>) -> Result<PacketField, Misplaced> {
    let plus = sign.plus.iter().map(|text| (text, false));
    let minus = sign.minus.iter().map(|text| (text, true));
    let texts = plus
        .chain(minus)
        .map(|(text, negative)| (text.clone().into_bytes(), negative));
    let texts = longest_first(texts.collect());
    if sign.plus.is_empty() || sign.minus.is_empty() || is_twice(&texts) {
        let found = format!("plus {:?}, minus {:?}", sign.plus, sign.minus);
        return Err(value(
            path,
            found,
            "different texts for plus and for minus, for example plus = [\"+\"], minus = [\"-\"]",
        ));
    }
    Ok(PacketField::Sign(texts))
}

fn number_field(
    number: &NumberField,
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<PacketField, Misplaced> {
    let count = count(&number.count, within(path, "count"))?;
    if usize::from(number.decimals) > MOST_DIGITS {
        return Err(value(
            within(path, "decimals"),
            number.decimals,
            "at most 15",
        ));
    }
    if number.decimals > 0 && number.point == PointPlace::InPlace {
        let expected = "0 (leave it out) where the point is sent in place";
        return Err(value(within(path, "decimals"), number.decimals, expected));
    }
    let (least_points, most_points) = match number.point {
        PointPlace::InPlace => (1, 1),
        PointPlace::Optional => (0, 1),
        PointPlace::None => (0, 0),
    };
    if number.comma && number.point == PointPlace::None {
        let expected = "false (leave it out) where no point is sent";
        return Err(value(within(path, "comma"), number.comma, expected));
    }
    if number.reversed && number.blanks == BlankPlace::Leading {
        let expected = "none (leave it out) where the last digit is sent first; `blanks` are a field of their own";
        return Err(value(within(path, "blanks"), "leading", expected));
    }
    Ok(PacketField::Number(NumberShape {
        least: count.least,
        most: count.most,
        least_points,
        most_points,
        decimals: number.decimals,
        leading_blanks: number.blanks == BlankPlace::Leading,
        comma: number.comma,
        reversed: number.reversed,
        other: other_quantity(number, path, context)?,
    }))
}

/// Quantity and unit of a number that is not what the gauge measures.
fn other_quantity(
    number: &NumberField,
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<Option<(Channel, String)>, Misplaced> {
    match (number.measures.map(Channel::from), &number.unit) {
        (None, None) => Ok(None),
        (Some(channel), Some(unit))
            if channel != context.channel && channel.kind().si_factor(unit).is_some() =>
        {
            Ok(Some((channel, unit.clone())))
        }
        (measures, unit) => {
            let found = format!("measures {measures:?}, unit {unit:?}");
            let expected = "both `measures` (the other quantity) and its `unit`, or neither";
            Err(value(path.to_vec(), found, expected))
        }
    }
}

fn hex_field(hex: &HexField, path: &[EntryPath]) -> Result<PacketField, Misplaced> {
    integer(
        IntegerShape {
            coding: hexadecimal(&hex.digits, path)?,
            width: hex.count,
            signed: hex.signed,
            decimals: hex.decimals,
            scale: hex.scale.unwrap_or(1.0),
        },
        "count",
        path,
    )
}

/// Sixteen characters as digits.
fn hexadecimal(written: &str, path: &[EntryPath]) -> Result<IntegerCoding, Misplaced> {
    let digits = written.as_bytes();
    let alone = |(place, digit): (usize, &u8)| !digits[..place].contains(digit);
    let Ok(sixteen) = <[u8; 16]>::try_from(digits) else {
        let expected = "sixteen characters, those of the digits 0 to 15";
        return Err(value(within(path, "digits"), written, expected));
    };
    if !digits.iter().enumerate().all(alone) {
        let expected = "sixteen different characters";
        return Err(value(within(path, "digits"), written, expected));
    }
    Ok(IntegerCoding::Hexadecimal(sixteen))
}

fn check_sum_field(sum: &CheckSumField, path: &[EntryPath]) -> Result<PacketField, Misplaced> {
    let coding = match (sum.bytes, &sum.digits) {
        (Some(_), Some(digits)) => {
            let expected = "absent where the check sum is sent in bytes";
            return Err(value(within(path, "digits"), digits, expected));
        }
        (Some(ByteOrder::HighFirst), None) => IntegerCoding::HighByteFirst,
        (Some(ByteOrder::LowFirst), None) => IntegerCoding::LowByteFirst,
        (None, digits) => {
            let digits = digits.as_deref().unwrap_or(HEXADECIMAL_DIGITS);
            hexadecimal(digits, path)?
        }
    };
    if sum.from >= LONGEST_PACKET {
        let expected = format!("less than {LONGEST_PACKET}");
        return Err(value(within(path, "from"), sum.from, &expected));
    }
    Ok(PacketField::CheckSum(CheckSum {
        kind: sum.kind,
        from: sum.from,
        shape: IntegerShape {
            width: sum.kind.width() * 8 / coding.bits(),
            coding,
            signed: false,
            decimals: 0,
            scale: 1.0,
        },
    }))
}

fn integer_field(entry: &IntegerField, path: &[EntryPath]) -> Result<PacketField, Misplaced> {
    integer(
        IntegerShape {
            coding: match entry.order {
                ByteOrder::HighFirst => IntegerCoding::HighByteFirst,
                ByteOrder::LowFirst => IntegerCoding::LowByteFirst,
            },
            width: entry.bytes,
            signed: entry.signed,
            decimals: entry.decimals,
            scale: entry.scale.unwrap_or(1.0),
        },
        "bytes",
        path,
    )
}

fn integer(
    shape: IntegerShape,
    width_key: &str,
    path: &[EntryPath],
) -> Result<PacketField, Misplaced> {
    let widest = shape.coding.widest();
    if !(1..=widest).contains(&shape.width) {
        let expected = format!("1 to {widest}");
        return Err(value(within(path, width_key), shape.width, &expected));
    }
    if usize::from(shape.decimals) > MOST_DIGITS {
        let expected = "at most 15";
        return Err(value(within(path, "decimals"), shape.decimals, expected));
    }
    if !shape.scale.is_finite() || shape.scale == 0.0 {
        let expected = "a finite number other than 0";
        return Err(value(within(path, "scale"), shape.scale, expected));
    }
    Ok(PacketField::Integer(shape))
}

fn unit_field(
    unit: &UnitField,
    path: &[EntryPath],
    context: &FieldContext<'_>,
) -> Result<PacketField, Misplaced> {
    let known = context.codes.iter();
    let known = known.map(|(code, unit)| (code.clone().into_bytes(), UnitWord::Unit(unit.clone())));
    let refuse = unit.refuse.iter();
    let refuse =
        refuse.map(|(code, why)| (code.clone().into_bytes(), UnitWord::Refuse(why.clone())));
    let others = match unit.others.as_slice() {
        [] => None,
        others => {
            let mut codes = context.codes.iter();
            let digits = codes.all(|(code, _)| code.bytes().all(|byte| byte.is_ascii_digit()));
            let set = if digits {
                CharacterSet::of("0123456789")
            } else {
                CharacterSet::unit_letters()
            };
            Some((set, count(others, within(path, "others"))?))
        }
    };
    Ok(PacketField::Unit {
        codes: longest_first(known.chain(refuse).collect()),
        others,
    })
}

fn choice_field(choice: &ChoiceField, path: Vec<EntryPath>) -> Result<PacketField, Misplaced> {
    let good = choice.good.iter().map(|text| (text, ChoiceWord::Good));
    let refuse = choice
        .refuse
        .iter()
        .map(|(text, why)| (text, ChoiceWord::Refuse(why.clone())));
    let note = choice
        .note
        .iter()
        .map(|(text, mark)| (text, ChoiceWord::Note(*mark)));
    let texts = good.chain(refuse).chain(note);
    let texts: Vec<_> = texts
        .map(|(text, word)| (text.clone().into_bytes(), word))
        .collect();
    let texts = longest_first(texts);
    if texts.is_empty() || is_twice(&texts) {
        return Err(value(
            path,
            "this",
            "different texts under good, refuse and note, at least one",
        ));
    }
    Ok(PacketField::Choice(texts))
}

/// Alternatives with the longest text first, those of the same length as they stand in the file.
fn longest_first<T>(mut texts: Vec<(Vec<u8>, T)>) -> Vec<(Vec<u8>, T)> {
    texts.sort_by_key(|(text, _)| std::cmp::Reverse(text.len()));
    texts
}

/// Whether a text is there twice.
fn is_twice<T>(texts: &[(Vec<u8>, T)]) -> bool {
    let before = |place: usize| texts[..place].iter().map(|(text, _)| text);
    let mut texts = texts.iter().enumerate();
    texts.any(|(place, (text, _))| before(place).any(|other| other == text))
}
