//! `session.toml` to a header and back.

use toml::{Table, Value};

use super::procedure_toml::{procedure_table, read_procedure};
use super::session_file::{
    Environment, InstrumentRecord, Instruments, ReadSession, SESSION_SCHEMA, SessionFileError,
    SessionHeader, UnknownKey,
};
use super::toml_section::{Section, Source, parse};
use super::toml_values::{date, put, put_number, put_text};
use stiffbench_units_and_text::quantity::Kind;

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
        let document = parse(&source, text)?;
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
        put_text(&mut table, "origin", self.origin.as_ref());
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
        origin: root.text("origin")?,
        operator: root.text("operator")?,
        place: root.text("place")?,
        environment: read_environment(root, unknown)?,
        software: root.text("software")?,
        procedure: match root.section("procedure")? {
            Some(section) => Some(read_procedure(section, false, unknown)?),
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
