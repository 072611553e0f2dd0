//! From the keys of a file to a description that can be used.

use indexmap::IndexMap;

use crate::framing::{Framing, FramingKind};
use crate::units::{Units, usual_codes};
use stiffbench_units_and_text::quantity::Kind;

use super::commands::{CommandRole, Commands, Expect, GaugeCommand};
use super::fields::{LONGEST_PACKET, value, within};
use super::file::{
    CommandEntry, CommandsEntry, DescriptionFile, FramingEntry, LineEntry, LineFraming,
    ModbusFraming, PhysicalEntry, TimingEntry, UnitEntry,
};
use super::packets::grammar;
use super::parse::{EntryPath, Misplaced, key_of};
use super::problem::DescriptionProblem;
use super::{
    InstrumentDescription, LineSettings, ModemLines, Physical, SignConvention, Timing, UnitSource,
};

/// The description that a file makes.
pub(super) fn compile(file: DescriptionFile) -> Result<InstrumentDescription, Misplaced> {
    let kind = crate::Channel::from(file.channel).kind();
    check_name(&file.name)?;
    check_line(&file.line)?;
    let units = units(&file.unit, kind)?;
    let mut framing = framing(&file.framing)?;
    let grammar = grammar(&file, &units, &mut framing)?;
    let physical = physical(&file.physical, kind)?;
    let packets = file.value.iter().map(|packet| packet.text.clone());
    Ok(InstrumentDescription {
        modem: ModemLines {
            dtr: file.line.dtr,
            rts: file.line.rts,
            settle_s: file.line.settle_s,
        },
        line: line_settings(file.line),
        sign: SignConvention {
            compression: file.sign.compression,
            removable: file.sign.removable,
        },
        timing: timing(&file.timing)?,
        commands: commands(&file.commands)?,
        packets: packets.collect(),
        name: file.name,
        text: file.text,
        channel: file.channel.into(),
        status: file.status,
        experimental: file.experimental,
        sources: file.sources,
        notes: file.notes,
        no_tty: file.no_tty.into_iter().collect(),
        physical,
        framing,
        units,
        grammar,
    })
}

fn line_settings(line: LineEntry) -> LineSettings {
    LineSettings {
        baud: line.baud,
        alternatives: line.alternatives,
        data_bits: line.data_bits,
        parity: line.parity,
        stop_bits: line.stop_bits,
        flow: line.flow,
    }
}

pub(super) fn path<const N: usize>(keys: [&str; N]) -> Vec<EntryPath> {
    keys.map(EntryPath::from).to_vec()
}

pub(super) fn missing(path: Vec<EntryPath>, key: &str, why: &str) -> Misplaced {
    let key = key_of(&within(&path, key));
    let problem = DescriptionProblem::Missing {
        key,
        why: why.to_owned(),
    };
    Misplaced { path, problem }
}

pub(super) fn conflict(path: Vec<EntryPath>, key: &str, other: &str, why: &str) -> Misplaced {
    let problem = DescriptionProblem::Conflict {
        key: key_of(&within(&path, key)),
        other: other.to_owned(),
        why: why.to_owned(),
    };
    Misplaced { path, problem }
}

fn check_name(name: &str) -> Result<(), Misplaced> {
    let fits = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'-';
    if !name.is_empty() && name.bytes().all(fits) {
        return Ok(());
    }
    let expected = "vendor-model in lower-case letters, digits and -";
    Err(value(path(["name"]), format!("{name:?}"), expected))
}

fn check_line(line: &LineEntry) -> Result<(), Misplaced> {
    let at = |key| path(["line", key]);
    let speeds = [line.baud]
        .into_iter()
        .chain(line.alternatives.iter().copied());
    if let Some(speed) = speeds
        .into_iter()
        .find(|speed| !(50..=4_000_000).contains(speed))
    {
        let key = if speed == line.baud {
            "baud"
        } else {
            "alternatives"
        };
        return Err(value(at(key), speed, "50 to 4000000 bits per second"));
    }
    if ![7, 8].contains(&line.data_bits) {
        return Err(value(at("data_bits"), line.data_bits, "7 or 8"));
    }
    if ![1, 2].contains(&line.stop_bits) {
        return Err(value(at("stop_bits"), line.stop_bits, "1 or 2"));
    }
    seconds(Some(line.settle_s), 0.0, at("settle_s")).map(|_| ())
}

/// A time from 0 to an hour, s.
fn seconds(given: Option<f64>, otherwise: f64, path: Vec<EntryPath>) -> Result<f64, Misplaced> {
    let time_s = given.unwrap_or(otherwise);
    if (0.0..=3600.0).contains(&time_s) {
        Ok(time_s)
    } else {
        Err(value(path, time_s, "0 to 3600 s"))
    }
}

/// A silence, which has to be longer than none, s.
fn silence(given: Option<f64>, otherwise: f64, path: Vec<EntryPath>) -> Result<f64, Misplaced> {
    let time_s = seconds(given, otherwise, path.clone())?;
    if time_s > 0.0 {
        Ok(time_s)
    } else {
        Err(value(path, time_s, "more than 0 s"))
    }
}

fn timing(entry: &TimingEntry) -> Result<Timing, Misplaced> {
    let at = |key| path(["timing", key]);
    let most_per_s = entry.most_per_s.unwrap_or(10.0);
    if !(most_per_s > 0.0 && most_per_s <= 1e5) {
        return Err(value(
            at("most_per_s"),
            most_per_s,
            "more than 0, at most 100000",
        ));
    }
    Ok(Timing {
        reply_deadline_s: silence(entry.reply_deadline_s, 0.5, at("reply_deadline_s"))?,
        drain_s: silence(entry.drain_s, 0.1, at("drain_s"))?,
        retries: entry.retries.unwrap_or(2),
        gap_s: seconds(entry.gap_s, 0.0, at("gap_s"))?,
        most_per_s,
        discard_after_open: entry.discard_after_open.unwrap_or(1),
        silent_after_s: silence(entry.silent_after_s, 3.0, at("silent_after_s"))?,
    })
}

fn commands(entry: &CommandsEntry) -> Result<Commands, Misplaced> {
    let entries = [
        (CommandRole::Read, &entry.read),
        (CommandRole::StreamStart, &entry.stream_start),
        (CommandRole::StreamStop, &entry.stream_stop),
        (CommandRole::Zero, &entry.zero),
        (CommandRole::Identify, &entry.identify),
        (CommandRole::QueryUnit, &entry.query_unit),
        (CommandRole::SetUnit, &entry.set_unit),
        (CommandRole::QueryMode, &entry.query_mode),
        (CommandRole::SetMode, &entry.set_mode),
        (CommandRole::KeepAwake, &entry.keep_awake),
        (CommandRole::Resynchronise, &entry.resynchronise),
    ];
    let mut commands = Commands::default();
    for (role, command_entry) in entries {
        if let Some(command_entry) = command_entry {
            commands.set(role, command(role, command_entry, &entry.terminator)?);
        }
    }
    Ok(commands)
}

fn command(
    role: CommandRole,
    entry: &CommandEntry,
    terminator: &str,
) -> Result<GaugeCommand, Misplaced> {
    let at = path(["commands", role.key()]);
    let bytes = match (&entry.send, &entry.bytes) {
        (Some(text), None) => {
            let end = entry.terminator.as_deref().unwrap_or(terminator);
            [text.as_bytes(), end.as_bytes()].concat()
        }
        (None, Some(bytes)) => bytes.clone(),
        (Some(_), Some(_)) => {
            return Err(conflict(at, "send", "bytes", "a command is sent once"));
        }
        (None, None) => return Err(missing(at, "send", "a command is text (send) or bytes")),
    };
    if bytes.is_empty() || bytes.len() > LONGEST_PACKET {
        let expected = format!("1 to {LONGEST_PACKET} bytes to send");
        return Err(value(at, format!("{} bytes", bytes.len()), &expected));
    }
    if role == CommandRole::Read && entry.expects != Expect::Value {
        let path = within(&at, "expects");
        return Err(value(
            path,
            format!("{:?}", entry.expects).to_lowercase(),
            "\"value\"",
        ));
    }
    Ok(GaugeCommand {
        bytes,
        expects: entry.expects,
        effect: entry.effect,
        running: entry.running,
        separator: entry.separator.clone(),
        refuse: entry.refuse.clone().into_iter().collect(),
    })
}

fn framing(entry: &FramingEntry) -> Result<Framing, Misplaced> {
    let (kind, given, otherwise, name) = match entry {
        FramingEntry::Line(line) => (line_framing(line)?, line.idle_s, 0.2, "line"),
        FramingEntry::Fixed(fixed) => {
            let length = length(fixed.length, path(["framing", "fixed", "length"]))?;
            (FramingKind::Fixed { length }, fixed.idle_s, 0.05, "fixed")
        }
        FramingEntry::Start(start) => {
            let length = length(start.length, path(["framing", "start", "length"]))?;
            if start.mark.is_empty() || start.mark.len() >= length {
                let expected = "at least one byte, and fewer than the packet has";
                return Err(value(
                    path(["framing", "start", "mark"]),
                    format!("{:?}", start.mark),
                    expected,
                ));
            }
            let mark = start.mark.clone();
            (
                FramingKind::Start { mark, length },
                start.idle_s,
                0.2,
                "start",
            )
        }
        FramingEntry::Idle(idle) => {
            let longest = length(
                idle.longest.unwrap_or(80),
                path(["framing", "idle", "longest"]),
            )?;
            (FramingKind::Idle { longest }, idle.idle_s, 0.05, "idle")
        }
        FramingEntry::Modbus(modbus) => (modbus_framing(modbus)?, modbus.idle_s, 0.05, "modbus"),
    };
    let idle_s = silence(given, otherwise, path(["framing", name, "idle_s"]))?;
    Ok(Framing { kind, idle_s })
}

fn length(bytes: usize, path: Vec<EntryPath>) -> Result<usize, Misplaced> {
    if (1..=LONGEST_PACKET).contains(&bytes) {
        Ok(bytes)
    } else {
        Err(value(path, bytes, &format!("1 to {LONGEST_PACKET} bytes")))
    }
}

fn line_framing(line: &LineFraming) -> Result<FramingKind, Misplaced> {
    let at = path(["framing", "line", "end"]);
    let ends: Vec<Vec<u8>> = line
        .end
        .iter()
        .map(|end| end.clone().into_bytes())
        .collect();
    if ends.is_empty() || ends.iter().any(Vec::is_empty) {
        let expected = "one end mark or more, for example [\"\\r\\n\"]";
        return Err(value(at, format!("{:?}", line.end), expected));
    }
    Ok(FramingKind::Line {
        ends,
        longest: length(
            line.longest.unwrap_or(80),
            path(["framing", "line", "longest"]),
        )?,
        bare: Vec::new(),
    })
}

fn modbus_framing(modbus: &ModbusFraming) -> Result<FramingKind, Misplaced> {
    let at = |key| path(["framing", "modbus", key]);
    let function = modbus.function.unwrap_or(3);
    if ![3, 4].contains(&function) {
        return Err(value(at("function"), function, "3 or 4"));
    }
    if !(1..=125).contains(&modbus.registers) {
        return Err(value(at("registers"), modbus.registers, "1 to 125"));
    }
    Ok(FramingKind::Modbus {
        slave: modbus.slave.unwrap_or(1),
        function,
        data_bytes: usize::from(modbus.registers) * 2,
    })
}

fn units(entry: &UnitEntry, kind: Kind) -> Result<Units, Misplaced> {
    for (code, unit) in &entry.codes {
        known_unit(unit, kind, path(["unit", "codes", code.as_str()]))?;
    }
    for (index, unit) in entry.choices.iter().enumerate() {
        known_unit(unit, kind, within(&path(["unit", "choices"]), index))?;
    }
    match (&entry.fixed, entry.from) {
        (Some(unit), UnitSource::Fixed) => {
            known_unit(unit, kind, path(["unit", "fixed"]))?;
        }
        (None, UnitSource::Fixed) => {
            return Err(missing(path(["unit"]), "fixed", "which unit is it"));
        }
        (Some(_), _) => {
            let why = "only from = \"fixed\" has it";
            return Err(conflict(path(["unit"]), "fixed", "unit.from", why));
        }
        (None, _) => {}
    }
    let mut codes: Vec<(String, String)> = entry.codes.clone().into_iter().collect();
    if codes.is_empty() {
        let usual = usual_codes(kind).iter();
        codes.extend(usual.map(|(code, unit)| ((*code).to_owned(), (*unit).to_owned())));
    }
    let mut choices = entry.choices.clone();
    if choices.is_empty() {
        choices = codes.iter().map(|(_, unit)| unit.clone()).collect();
        choices.sort();
        choices.dedup();
    }
    Ok(Units {
        source: entry.from,
        fixed: entry.fixed.clone(),
        codes,
        choices,
    })
}

/// SI units in a unit of the gauge's quantity.
fn known_unit(unit: &str, kind: Kind, path: Vec<EntryPath>) -> Result<f64, Misplaced> {
    let expected = || format!("a unit of {}: {}", word(kind), kind.units());
    kind.si_factor(unit)
        .ok_or_else(|| value(path, format!("{unit:?}"), &expected()))
}

/// What a gauge measures, in a word.
fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Force => "force",
        Kind::Displacement => "displacement",
        Kind::Time => "time",
        Kind::Temperature => "temperature",
        Kind::Torque => "torque",
        Kind::Angle => "angle",
        Kind::Stress => "stress",
        Kind::Strain => "strain",
    }
}

fn physical(entry: &PhysicalEntry, kind: Kind) -> Result<Physical, Misplaced> {
    for unit in entry.resolution.keys() {
        known_unit(unit, kind, path(["physical", "resolution", unit.as_str()]))?;
    }
    for unit in entry.decimals.keys() {
        known_unit(unit, kind, path(["physical", "decimals", unit.as_str()]))?;
    }
    Ok(Physical {
        capacity_si: largest(&entry.capacity, kind, "capacity")?,
        plausible_si: largest(&entry.plausible, kind, "plausible")?,
        resolution: entry.resolution.clone().into_iter().collect(),
        decimals: entry.decimals.clone().into_iter().collect(),
    })
}

/// The largest of sizes given in several units, SI.
fn largest(table: &IndexMap<String, f64>, kind: Kind, key: &str) -> Result<Option<f64>, Misplaced> {
    let mut largest_si: Option<f64> = None;
    for (unit, size) in table {
        let at = path(["physical", key, unit.as_str()]);
        let size_si = size * known_unit(unit, kind, at.clone())?;
        if !(size_si.is_finite() && size_si > 0.0) {
            return Err(value(at, size, "more than 0"));
        }
        largest_si = Some(largest_si.map_or(size_si, |before| before.max(size_si)));
    }
    Ok(largest_si)
}
