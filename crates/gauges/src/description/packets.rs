//! From the packets of a file to the grammar of a gauge.

use crate::framing::{Framing, FramingKind};
use crate::grammar::{ErrorPacket, FieldPattern, Grammar, ReplyPacket, ValuePacket};
use crate::registers::{Registers, RequiredBits, SignBits};
use crate::units::Units;

use super::compile::{conflict, missing, path};
use super::entries::{FieldEntry, RegistersEntry};
use super::fields::{FieldContext, pattern, value, value_pattern, within};
use super::file::{DescriptionFile, ValueEntry};
use super::parse::{EntryPath, Misplaced};

/// All packets of a gauge; those without end mark are added to its framing.
pub(super) fn grammar(
    file: &DescriptionFile,
    units: &Units,
    framing: &mut Framing,
) -> Result<Grammar, Misplaced> {
    let context = FieldContext {
        channel: file.channel.into(),
        codes: &units.codes,
    };
    if file.value.is_empty() {
        let why = "a gauge sends at least one kind of value";
        return Err(missing(path(["value"]), "fields", why));
    }
    let mut grammar = Grammar::default();
    for (index, entry) in file.error.iter().enumerate() {
        let at = within(&path(["error"]), index);
        grammar.errors.push(ErrorPacket {
            pattern: configured_packet(&entry.fields, entry.bare, &at, &context, framing)?,
            meaning: entry.meaning,
            text: entry.text.clone(),
        });
    }
    for (index, entry) in file.reply.iter().enumerate() {
        let at = within(&path(["reply"]), index);
        grammar.replies.push(ReplyPacket {
            pattern: configured_packet(&entry.fields, entry.bare, &at, &context, framing)?,
            meaning: entry.meaning,
        });
    }
    for (index, entry) in file.value.iter().enumerate() {
        let at = within(&path(["value"]), index);
        let packet = value_packet(entry, &at, &context, framing)?;
        grammar.values.push(packet);
    }
    Ok(grammar)
}

/// The pattern of an error or a reply.
fn configured_packet(
    fields: &[FieldEntry],
    bare: bool,
    at: &[EntryPath],
    context: &FieldContext<'_>,
    framing: &mut Framing,
) -> Result<FieldPattern, Misplaced> {
    let pattern = pattern(fields, at, context)?;
    if bare {
        add_bare(&pattern, at, framing)?;
    }
    Ok(pattern)
}

/// A packet that comes without the end mark of lines is known by its bytes.
fn add_bare(
    pattern: &FieldPattern,
    at: &[EntryPath],
    framing: &mut Framing,
) -> Result<(), Misplaced> {
    let FramingKind::Line { bare, .. } = &mut framing.kind else {
        let why = "only lines have an end mark to leave out";
        return Err(conflict(at.to_vec(), "bare", "framing", why));
    };
    let expected = "literal or bytes only, for a packet without end mark";
    let bytes = pattern.fixed_bytes();
    bare.push(bytes.ok_or_else(|| value(within(at, "fields"), "of another kind too", expected))?);
    Ok(())
}

fn value_packet(
    entry: &ValueEntry,
    at: &[EntryPath],
    context: &FieldContext<'_>,
    framing: &Framing,
) -> Result<ValuePacket, Misplaced> {
    match (&entry.registers, &framing.kind) {
        (Some(_), _) if !entry.fields.is_empty() => {
            let why = "a packet has fields of text or registers";
            Err(conflict(at.to_vec(), "fields", "registers", why))
        }
        (Some(registers), FramingKind::Modbus { data_bytes, .. }) => {
            let at = within(at, "registers");
            register_map(registers, &at, data_bytes / 2).map(ValuePacket::Registers)
        }
        (Some(_), _) => {
            let why = "registers come by Modbus only";
            Err(conflict(at.to_vec(), "registers", "framing", why))
        }
        (None, FramingKind::Modbus { .. }) => {
            let why = "where is the value in the reply";
            Err(missing(at.to_vec(), "registers", why))
        }
        (None, _) => value_pattern(&entry.fields, at, context).map(ValuePacket::Text),
    }
}

fn register_map(
    entry: &RegistersEntry,
    at: &[EntryPath],
    count: usize,
) -> Result<Registers, Misplaced> {
    let scale = entry.scale.unwrap_or(1.0);
    if !scale.is_finite() || scale == 0.0 {
        let expected = "a finite number other than 0";
        return Err(value(within(at, "scale"), scale, expected));
    }
    if entry.decimals > 9 {
        return Err(value(within(at, "decimals"), entry.decimals, "at most 9"));
    }
    let sign = match &entry.sign {
        None => None,
        Some(sign) => Some(SignBits {
            register: register(sign.register, 1, count, within(at, "sign"))?,
            mask: sign.mask,
            plus: sign.plus,
            minus: sign.minus,
        }),
    };
    let mut require = Vec::new();
    for (index, check) in entry.require.iter().enumerate() {
        let path = within(&within(at, "require"), index);
        require.push(RequiredBits {
            register: register(check.register, 1, count, path)?,
            mask: check.mask,
            equals: check.equals,
            otherwise: check.otherwise.clone(),
        });
    }
    let width = entry.format.registers();
    Ok(Registers {
        first: register(entry.first, width, count, within(at, "first"))?,
        format: entry.format,
        low_word_first: entry.low_word_first,
        decimals: entry.decimals,
        scale,
        sign,
        require,
    })
}

/// A register, or the first of several, among those that are asked for.
fn register(
    first: u8,
    width: usize,
    count: usize,
    path: Vec<EntryPath>,
) -> Result<usize, Misplaced> {
    let first = usize::from(first);
    if first + width <= count {
        return Ok(first);
    }
    let expected = format!("a register within the {count} that are asked for");
    Err(value(path, first, &expected))
}
