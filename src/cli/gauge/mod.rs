//! `stiffbench gauge`: descriptions of gauges, their ports, their bytes.

mod args;
pub(in crate::cli) mod descriptions;
#[cfg(unix)]
mod emulate;
pub(in crate::cli) mod lines;
pub(in crate::cli) mod open;
mod ports;
mod read;
pub(in crate::cli) mod trace;

use std::env::consts::OS;
use std::io::Read;
use std::path::Path;

use stiffbench_document::{Document, Table};

use crate::analysis::ReadError;
use crate::instrument::description::{GaugeCommand, SignMeaning, UnitSource, json_schema};
use crate::instrument::{
    CommandRole, Decoded, Decoder, InstrumentDescription, Mark, Meaning, Rejected, Reply, Sample,
    raw_text,
};
use crate::report::{DecodeReport, InstrumentList, InstrumentReport, InstrumentSummary};

use super::{CliError, Failure, Global, Outcome};
use crate::count::counted;

use args::{DecodeArgs, GaugeShowArgs, GaugeVerb};
use descriptions::{LocatedDescription, all_descriptions, find_description, read_description};

pub(in crate::cli) use args::GaugeArgs;
pub use descriptions::ProtocolsArgs;

/// Lists, shows and checks descriptions, finds gauges, and reads, decodes, records, replays and emulates them.
pub(in crate::cli) fn run(args: &GaugeArgs, global: &Global) -> Result<Outcome, Failure> {
    match &args.what {
        GaugeVerb::List { protocols } => list(protocols),
        GaugeVerb::Show(args) => show(args),
        GaugeVerb::Check { file } => Ok(check(read_description(file)?)),
        GaugeVerb::Ports(args) => ports::list(args),
        GaugeVerb::Probe(args) => ports::probe_ports(args, global),
        GaugeVerb::Bind(args) => ports::bind(args, global),
        GaugeVerb::Read(args) => read::run(args, global),
        GaugeVerb::Decode(args) => decode(args),
        #[cfg(unix)]
        GaugeVerb::Emulate(args) => emulate::run(args, global),
        GaugeVerb::Record(args) => trace::record(args, global),
        GaugeVerb::Replay(args) => trace::replay(args, global),
    }
}

fn list(protocols: &ProtocolsArgs) -> Result<Outcome, Failure> {
    let (found, mut warnings) = all_descriptions(protocols)?;
    let descriptions = || found.iter().map(|one| &one.description);
    let mut document = Document::new();
    document.table(
        Table::of(descriptions())
            .words("name", |one| &one.name)
            .words("measures", |one| &one.channel)
            .words("status", |one| status_text(one))
            .words("what it is", |one| &one.text),
    );
    document.paragraph("documented: from the manufacturer's manual; implemented: from working public code; recalled: from memory, needs --allow-unverified. Details: stiffbench gauge show NAME");
    warnings.extend(
        descriptions().filter_map(|one| Some(format!("{}: {}", one.name, one.no_tty(OS)?))),
    );
    let instruments = found.iter().map(summary).collect();
    let report = InstrumentList { instruments };
    Ok(Outcome::new("instrument-list", document, report).with_warnings(warnings))
}

fn status_text(description: &InstrumentDescription) -> String {
    if description.experimental {
        format!("{}, in part", description.status)
    } else {
        description.status.to_string()
    }
}

fn summary(found: &LocatedDescription) -> InstrumentSummary {
    InstrumentSummary::new(&found.description, found.path.as_deref())
}

fn show(args: &GaugeShowArgs) -> Result<Outcome, Failure> {
    let Some(name) = &args.name else {
        let schema = json_schema();
        let text = format!("{schema:#}\n");
        return Ok(Outcome::new("instrument-schema", text, schema));
    };
    if trace::is_trace(Path::new(name)) {
        return trace::show(Path::new(name));
    }
    let found = find_description(name, &args.protocols)?;
    let description = &found.description;
    let report = InstrumentReport::new(summary(&found), description, &found.toml);
    let text = if args.toml {
        found.toml.clone()
    } else {
        description_document(description).text()
    };
    Ok(Outcome::new("instrument", text, report).with_warnings(found.warnings))
}

fn commands(
    description: &InstrumentDescription,
) -> impl Iterator<Item = (CommandRole, &GaugeCommand)> {
    let roles = CommandRole::ALL.into_iter();
    roles.filter_map(|role| Some((role, description.command(role)?)))
}

fn description_document(description: &InstrumentDescription) -> Document {
    let mut document = Document::new();
    document.pair("name", &description.name);
    document.pair("what", &description.text);
    document.pair("measures", description.channel.to_string());
    document.pair("status", status_text(description));
    document.pair("line", description.line.to_string());
    document.pair("packets", description.framing_text());
    for packet in &description.packets {
        document.pair("", packet);
    }
    document.pair("unit", unit_text(description));
    document.pair("push", sign_text(description.sign.compression));
    let mut list = |name: &str, entries: Vec<String>| {
        for (place, entry) in entries.into_iter().enumerate() {
            document.pair(if place == 0 { name } else { "" }, entry);
        }
    };
    let commands = commands(description);
    let commands = commands.map(|(role, command)| format!("{role}: {}", raw_text(&command.bytes)));
    list("commands", commands.collect());
    for (system, note) in description.no_tty_notes() {
        list(system, vec![note.to_owned()]);
    }
    list("notes", description.notes.clone());
    list("sources", description.sources.clone());
    document
}

fn unit_text(description: &InstrumentDescription) -> String {
    let choices = description.unit_choices().join(", ");
    match description.unit_source() {
        UnitSource::Packet => format!("in every packet ({choices})"),
        UnitSource::Query => format!("the gauge is asked ({choices})"),
        UnitSource::Configuration => format!("not sent: state it ({choices})"),
        UnitSource::Fixed => "always the same".to_owned(),
    }
}

fn sign_text(meaning: SignMeaning) -> &'static str {
    match meaning {
        SignMeaning::Positive => "arrives as a positive value",
        SignMeaning::Negative => "arrives as a negative value",
        SignMeaning::Ask => "sign not known: determined by a push by hand",
    }
}

fn check(found: LocatedDescription) -> Outcome {
    let mut document = description_document(&found.description);
    document.paragraph("no errors");
    let summary = summary(&found);
    let mut warnings = found.warnings;
    warnings.extend(found.description.warnings());
    Outcome::new("instrument-check", document, summary)
        .with_strict_exit(u8::from(!warnings.is_empty()))
        .with_warnings(warnings)
}

fn decode(args: &DecodeArgs) -> Result<Outcome, Failure> {
    let how = (args.unit.as_deref(), &args.protocols);
    match &args.trace {
        Some(file) => return trace::decode(file, Some(&args.what), how),
        None if trace::is_trace(args.what.as_ref()) => {
            return trace::decode(args.what.as_ref(), None, how);
        }
        None => {}
    }
    let found = find_description(&args.what, &args.protocols)?;
    let description = &found.description;
    require_permission(description, args.allow_unverified)?;
    let mut decoder = Decoder::new(description, args.unit.as_deref())?;
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .read_to_end(&mut bytes)
        .map_err(ReadError::of("standard input".as_ref()))?;
    let mut decoded = Vec::new();
    decoder.push(&bytes, 0.0, &mut decoded);
    decoder.idle(0.0, &mut decoded);
    Ok(decoded_outcome(&decoded, description, args.unit.as_deref()).with_warnings(found.warnings))
}

/// A description from memory is used only on the operator's word.
pub(in crate::cli) fn require_permission(
    description: &InstrumentDescription,
    allowed: bool,
) -> Result<(), Failure> {
    if allowed || !description.is_unverified() {
        return Ok(());
    }
    Err(CliError::Unverified {
        instrument: description.name.clone(),
    }
    .into())
}

fn decoded_outcome(
    decoded: &[Decoded],
    description: &InstrumentDescription,
    unit: Option<&str>,
) -> Outcome {
    let (mut samples, mut rejected) = (Vec::new(), Vec::new());
    let mut document = Document::new();
    let mut no_value = |packet: Rejected| {
        let line = format!("rejected: {}: {}", packet.raw, packet.reason);
        rejected.push(packet);
        line
    };
    for one in decoded {
        document.lines(match one {
            Decoded::Sample(sample) => {
                let value = decoded_value(sample, description, unit);
                let line = format!("{:?} {}  <- {}", value.value, value.unit, sample.raw);
                samples.push(value);
                line
            }
            Decoded::Rejected(packet) => no_value(packet.clone()),
            Decoded::Reply(reply) => no_value(Rejected {
                raw: reply.raw.clone(),
                reason: reply_reason(reply).into(),
                at_s: reply.at_s,
            }),
        });
    }
    document.lines(format!(
        "{}, {} rejected",
        counted(samples.len(), "sample"),
        rejected.len()
    ));
    let report = DecodeReport {
        instrument: description.name.clone(),
        samples,
        rejected,
    };
    Outcome::new("instrument-decode", document, report)
}

/// A sample in the unit that was asked for. Nobody asks a file, so that a value was not requested carries no information here.
fn decoded_value(
    sample: &Sample,
    description: &InstrumentDescription,
    unit: Option<&str>,
) -> Sample {
    let own = sample.kind == description.channel.kind();
    let wanted = unit.filter(|_| own).unwrap_or(&sample.unit);
    let factor = |unit: &str| sample.kind.si_factor(unit).unwrap_or(1.0);
    let value = if wanted == &*sample.unit {
        sample.value
    } else {
        without_noise(sample.value * (factor(&sample.unit) / factor(wanted)))
    };
    let marks = sample.marks.iter().copied();
    Sample {
        value,
        unit: wanted.into(),
        marks: marks.filter(|mark| *mark != Mark::Unrequested).collect(),
        ..sample.clone()
    }
}

/// To 15 significant digits: what a conversion adds behind them is no information.
fn without_noise(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

pub(in crate::cli) fn reply_reason(reply: &Reply) -> String {
    match &reply.meaning {
        Meaning::Acknowledged => "an acknowledgement, not a value".to_owned(),
        Meaning::Refused(why) => why.clone(),
        Meaning::Identity(_) => "the identity of the gauge, not a value".to_owned(),
        Meaning::Unit(_) => "the gauge's unit, not a value".to_owned(),
        Meaning::State(_) => "the gauge's mode or settings, not a value".to_owned(),
        Meaning::Text(_) => "text, not a value".to_owned(),
    }
}
