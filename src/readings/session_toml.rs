//! `session.toml` to a header and back.

use jiff::civil::Date;
use toml::de::DeTable;
use toml::{Table, Value};

use super::number::write_decimal;
use super::session_file::{
    Environment, InstrumentRecord, Instruments, ProcedureRecord, ReadSession, SESSION_SCHEMA,
    SessionFileError, SessionHeader, SettleRecord, UnknownKey, Word,
};
use super::toml_section::{Section, Source};
use crate::quantity::Kind;
use crate::test_point::PoseId;

/// The schema of the procedure frozen in a session.
const PROCEDURE_SCHEMA: &str = "stiffbench/procedure/1";

type Unknown = Vec<UnknownKey>;

impl SessionHeader {
    /// Reads a `session.toml`.
    ///
    /// Every key but `schema` may be absent; keys that mean nothing here are listed. Quantities may have any unit of their kind behind
    /// the last underscore of the key.
    ///
    /// # Arguments
    /// - `source`: the name of the file, for messages.
    /// - `text`: its text.
    ///
    /// # Errors
    /// [`SessionFileError`] with the place in the file: not TOML, no or another or a newer schema, a value or a unit of the wrong kind.
    pub fn from_toml(source: &str, text: &str) -> Result<ReadSession, SessionFileError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::new(source, text);
        let document = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            SessionFileError::Syntax {
                line: source.line(span.start),
                message: error.message().to_owned(),
                file: source.file(),
                at: span.into(),
            }
        })?;
        let root = Section::root(&source, document.get_ref());
        root.check_schema(SESSION_SCHEMA, true)?;
        let mut unknown_keys = Vec::new();
        let header = read_header(&root, &mut unknown_keys)?;
        root.finish(&mut unknown_keys);
        unknown_keys.sort_by_key(|unknown| unknown.line);
        Ok(ReadSession {
            header,
            unknown_keys,
        })
    }

    /// The header as `session.toml`, with everything that is known.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut table = Table::new();
        put(&mut table, "schema", Some(Value::from(SESSION_SCHEMA)));
        put_text(&mut table, "id", self.id.as_ref());
        put_text(&mut table, "robot", self.robot.as_ref());
        put_text(&mut table, "robot_sha256", self.robot_sha256.as_ref());
        put_text(&mut table, "mechanism", self.mechanism.as_ref());
        put_text(&mut table, "factors", self.factors.as_ref());
        put_text(&mut table, "operator", self.operator.as_ref());
        put_text(&mut table, "place", self.place.as_ref());
        put_text(&mut table, "software", self.software.as_ref());
        let environment = self.environment.as_ref().map(environment_table);
        put(&mut table, "environment", environment.map(Value::Table));
        let procedure = self.procedure.as_ref().map(procedure_table);
        put(&mut table, "procedure", procedure.map(Value::Table));
        let mut gauges = Table::new();
        let gauge = |record: &Option<InstrumentRecord>, unit: &str, shift: i32| {
            let record = record.as_ref()?;
            Some(Value::Table(instrument_table(record, unit, shift)))
        };
        put(&mut gauges, "force", gauge(&self.instruments.force, "N", 0));
        let displacement = gauge(&self.instruments.displacement, "um", 6);
        put(&mut gauges, "displacement", displacement);
        if !gauges.is_empty() {
            put(&mut table, "instruments", Some(Value::Table(gauges)));
        }
        table.to_string()
    }
}

fn read_header(
    root: &Section<'_>,
    unknown: &mut Unknown,
) -> Result<SessionHeader, SessionFileError> {
    Ok(SessionHeader {
        id: root.text("id")?,
        robot: root.text("robot")?,
        robot_sha256: root.text("robot_sha256")?,
        mechanism: root.text("mechanism")?,
        factors: root.text("factors")?,
        operator: root.text("operator")?,
        place: root.text("place")?,
        environment: read_environment(root, unknown)?,
        software: root.text("software")?,
        procedure: match root.section("procedure")? {
            Some(section) => Some(read_procedure(section, unknown)?),
            None => None,
        },
        instruments: match root.section("instruments")? {
            Some(section) => read_instruments(section, unknown)?,
            None => Instruments::default(),
        },
    })
}

/// A table, or a line of text.
fn read_environment(
    root: &Section<'_>,
    unknown: &mut Unknown,
) -> Result<Option<Environment>, SessionFileError> {
    if root.is_text("environment") {
        let text = root.text("environment")?;
        return Ok(Some(Environment {
            text,
            ..Environment::default()
        }));
    }
    let Some(section) = root.section("environment")? else {
        return Ok(None);
    };
    let environment = Environment {
        temperature_deg_c: section.quantity("temp", Kind::Temperature)?,
        humidity_percent: section.number("humidity_percent")?,
        text: section.text("text")?,
    };
    section.finish(unknown);
    Ok(Some(environment))
}

fn read_procedure(
    section: Section<'_>,
    unknown: &mut Unknown,
) -> Result<ProcedureRecord, SessionFileError> {
    section.check_schema(PROCEDURE_SCHEMA, false)?;
    let poses = section.texts("poses")?;
    let mut settle = SettleRecord::default();
    if let Some(table) = section.section("settle")? {
        settle = SettleRecord {
            force_tolerance_n: table.quantity("force_tolerance", Kind::Force)?,
            dwell_s: table.quantity("dwell", Kind::Time)?,
            spread_m: table.quantity("spread", Kind::Displacement)?,
            slope_m_per_s: table.rate("slope", "_per_s", Kind::Displacement)?,
        };
        table.finish(unknown);
    }
    // Short headers have the tolerance without the table around it.
    if settle.force_tolerance_n.is_none() {
        settle.force_tolerance_n = section.quantity("force_tolerance", Kind::Force)?;
    }
    let procedure = ProcedureRecord {
        name: section.text("name")?,
        text: section.text("text")?,
        poses: poses.iter().map(|name| PoseId::new(name)).collect(),
        directions: section.words("directions")?,
        loads_n: section.quantities("loads", Kind::Force)?,
        branches: section.words("branches")?,
        repeats: section.count("repeats")?,
        repeat_order: section.word("repeat_order")?,
        load_order: section.word("load_order")?,
        seed: section.count("seed")?,
        zero: section.word("zero")?,
        preload_n: section.quantity("preload", Kind::Force)?,
        holds_s: section.quantities("holds", Kind::Time)?,
        settle,
    };
    section.finish(unknown);
    Ok(procedure)
}

fn read_instruments(
    section: Section<'_>,
    unknown: &mut Unknown,
) -> Result<Instruments, SessionFileError> {
    let mut gauge = |key: &str, kind: Kind| -> Result<_, SessionFileError> {
        match section.section(key)? {
            Some(table) => read_instrument(table, kind, unknown).map(Some),
            None => Ok(None),
        }
    };
    let instruments = Instruments {
        force: gauge("force", Kind::Force)?,
        displacement: gauge("displacement", Kind::Displacement)?,
    };
    section.finish(unknown);
    Ok(instruments)
}

fn read_instrument(
    section: Section<'_>,
    kind: Kind,
    unknown: &mut Unknown,
) -> Result<InstrumentRecord, SessionFileError> {
    let record = InstrumentRecord {
        model: section.text("model")?,
        serial: section.text("serial")?,
        range: section.quantity("range", kind)?,
        resolution: section.quantity("resolution", kind)?,
        expanded_uncertainty: section.quantity("U", kind)?,
        k: section.number("k")?,
        certificate: section.text("certificate")?,
        calibrated: section.date("calibrated")?,
        due: section.date("due")?,
    };
    section.finish(unknown);
    Ok(record)
}

fn environment_table(environment: &Environment) -> Table {
    let mut table = Table::new();
    put_number(&mut table, "temp_degC", environment.temperature_deg_c, 0);
    put_number(
        &mut table,
        "humidity_percent",
        environment.humidity_percent,
        0,
    );
    put_text(&mut table, "text", environment.text.as_ref());
    table
}

fn procedure_table(procedure: &ProcedureRecord) -> Table {
    let mut table = Table::new();
    put(&mut table, "schema", Some(Value::from(PROCEDURE_SCHEMA)));
    put_text(&mut table, "name", procedure.name.as_ref());
    put_text(&mut table, "text", procedure.text.as_ref());
    let names = procedure.poses.iter().map(PoseId::as_str);
    put_list(&mut table, "poses", names);
    put_list(&mut table, "directions", words(&procedure.directions));
    put_list(
        &mut table,
        "loads_N",
        procedure.loads_n.iter().map(|n| decimal(*n, 0)),
    );
    put_list(&mut table, "branches", words(&procedure.branches));
    put(&mut table, "repeats", procedure.repeats.map(Value::from));
    put(&mut table, "repeat_order", procedure.repeat_order.map(word));
    put(&mut table, "load_order", procedure.load_order.map(word));
    put(&mut table, "seed", procedure.seed.map(seed));
    put(&mut table, "zero", procedure.zero.map(word));
    put_number(&mut table, "preload_N", procedure.preload_n, 0);
    put_list(
        &mut table,
        "holds_s",
        procedure.holds_s.iter().map(|s| decimal(*s, 0)),
    );
    let settle = &procedure.settle;
    if *settle != SettleRecord::default() {
        let mut inner = Table::new();
        put_number(&mut inner, "force_tolerance_N", settle.force_tolerance_n, 0);
        put_number(&mut inner, "dwell_s", settle.dwell_s, 0);
        put_number(&mut inner, "spread_um", settle.spread_m, 6);
        put_number(&mut inner, "slope_um_per_s", settle.slope_m_per_s, 6);
        put(&mut table, "settle", Some(Value::Table(inner)));
    }
    table
}

fn instrument_table(record: &InstrumentRecord, unit: &str, shift: i32) -> Table {
    let mut table = Table::new();
    let key = |stem: &str| format!("{stem}_{unit}");
    put_text(&mut table, "model", record.model.as_ref());
    put_text(&mut table, "serial", record.serial.as_ref());
    put_number(&mut table, &key("range"), record.range, shift);
    put_number(&mut table, &key("resolution"), record.resolution, shift);
    put_number(&mut table, &key("U"), record.expanded_uncertainty, shift);
    put_number(&mut table, "k", record.k, 0);
    put_text(&mut table, "certificate", record.certificate.as_ref());
    put(&mut table, "calibrated", record.calibrated.map(date));
    put(&mut table, "due", record.due.map(date));
    table
}

fn put(table: &mut Table, key: &str, value: Option<Value>) {
    if let Some(value) = value {
        table.insert(key.to_owned(), value);
    }
}

fn put_text(table: &mut Table, key: &str, text: Option<&String>) {
    put(table, key, text.map(|text| Value::from(text.as_str())));
}

/// A number with its decimal point `shift` places further right.
fn put_number(table: &mut Table, key: &str, value: Option<f64>, shift: i32) {
    put(table, key, value.map(|value| decimal(value, shift).into()));
}

/// TOML has no whole number beyond that of 63 bits; a seed from there is written as text.
fn seed(seed: u64) -> Value {
    i64::try_from(seed).map_or_else(|_| Value::from(seed.to_string()), Value::from)
}

fn put_list<T: Into<Value>>(table: &mut Table, key: &str, items: impl Iterator<Item = T>) {
    put(
        table,
        key,
        Some(Value::Array(items.map(Into::into).collect())),
    );
}

fn words<W: Word>(members: &[W]) -> impl Iterator<Item = Value> {
    members.iter().map(|member| word(*member))
}

fn word<W: Word>(member: W) -> Value {
    Value::from(member.word())
}

/// The number nearest to the decimal digits of `value`, their point moved; see [`write_decimal`].
fn decimal(value: f64, shift: i32) -> f64 {
    let mut text = String::new();
    write_decimal(value, shift, &mut text);
    // What is not finite has no digits to move and is not accepted back either.
    text.parse().unwrap_or(value)
}

fn date(date: Date) -> Value {
    let text = date.to_string();
    text.parse()
        .map_or_else(|_| Value::from(text), Value::Datetime)
}
