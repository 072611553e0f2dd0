//! `session.toml` to a header and back.

use toml::Table;

use super::procedure_toml::{procedure_table, read_procedure};
use super::session_file::{
    Environment, ImportRecord, InstrumentRecord, Instruments, LOAD_CASE_SESSION_SCHEMA,
    ReadSession, SESSION_SCHEMA, SessionFileError, SessionHeader,
};
use super::toml_values::{date, day, put, put_number, quantity};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{
    Read, TomlDocument, TomlTable as Section, TomlValue, UnknownKey,
};

type Unknown = Vec<UnknownKey>;

/// Keys of the gauges along the base axes.
const DISPLACEMENT_ALONG: [&str; 3] = ["displacement_x", "displacement_y", "displacement_z"];

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
        let source = SourceText::new(source, text);
        let document = TomlDocument::parse(&source)?;
        Ok(read_session(&document.root())?)
    }

    /// The header as `session.toml`, with everything that is known.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.with_schema(if self.is_of_vectors() {
            LOAD_CASE_SESSION_SCHEMA
        } else {
            SESSION_SCHEMA
        })
    }

    /// The same beside load cases.
    #[must_use]
    pub fn to_load_case_toml(&self) -> String {
        self.with_schema(LOAD_CASE_SESSION_SCHEMA)
    }

    fn with_schema(&self, schema: &str) -> String {
        let mut table = Table::new();
        put(&mut table, "schema", Some(schema));
        put(&mut table, "id", self.id.as_deref());
        put(&mut table, "robot", self.robot.as_deref());
        put(&mut table, "robot_sha256", self.robot_sha256.as_deref());
        put(&mut table, "mechanism", self.mechanism.as_deref());
        put(&mut table, "factors", self.factors.as_deref());
        put(&mut table, "origin", self.origin.as_deref());
        put(&mut table, "operator", self.operator.as_deref());
        put(&mut table, "specimen", self.specimen.as_deref());
        put(&mut table, "place", self.place.as_deref());
        put(&mut table, "software", self.software.as_deref());
        let environment = self.environment.as_ref().map(environment_table);
        put(&mut table, "environment", environment);
        let procedure = self.procedure.as_ref().map(procedure_table);
        put(&mut table, "procedure", procedure);
        let mut gauges = Table::new();
        let gauge = |record: &Option<InstrumentRecord>, unit: &str, shift: i32| {
            let record = record.as_ref()?;
            Some(instrument_table(record, unit, shift))
        };
        put(&mut gauges, "force", gauge(&self.instruments.force, "N", 0));
        let displacement = gauge(&self.instruments.displacement, "um", 6);
        put(&mut gauges, "displacement", displacement);
        for (key, record) in DISPLACEMENT_ALONG
            .into_iter()
            .zip(&self.instruments.displacement_along)
        {
            put(&mut gauges, key, gauge(record, "um", 6));
        }
        if !gauges.is_empty() {
            put(&mut table, "instruments", Some(gauges));
        }
        let import = self.import.as_ref().map(import_table);
        put(&mut table, "import", import);
        table.to_string()
    }
}

fn read_session(root: &Section<'_>) -> Read<ReadSession> {
    root.check_schema(LOAD_CASE_SESSION_SCHEMA, true)?;
    let mut unknown_keys = Vec::new();
    let header = read_header(root, &mut unknown_keys)?;
    unknown_keys.extend(root.unknown());
    unknown_keys.sort_by_key(|unknown| unknown.line);
    Ok(ReadSession {
        header,
        unknown_keys,
    })
}

fn read_header(root: &Section<'_>, unknown: &mut Unknown) -> Read<SessionHeader> {
    let text = |key| root.read(key, TomlValue::text_or_digits);
    let procedure = root.read("procedure", |value| {
        read_procedure(&value.table()?, false, unknown)
    })?;
    let instruments = root.read("instruments", |value| {
        read_instruments(&value.table()?, unknown)
    })?;
    Ok(SessionHeader {
        id: text("id")?,
        robot: text("robot")?,
        robot_sha256: text("robot_sha256")?,
        mechanism: text("mechanism")?,
        factors: text("factors")?,
        origin: text("origin")?,
        operator: text("operator")?,
        specimen: text("specimen")?,
        place: text("place")?,
        environment: root.read("environment", |value| read_environment(value, unknown))?,
        software: text("software")?,
        procedure,
        instruments: instruments.unwrap_or_default(),
        import: root.read("import", |value| read_import(&value.table()?, unknown))?,
    })
}

fn read_import(section: &Section<'_>, unknown: &mut Unknown) -> Read<ImportRecord> {
    let text = |key| section.read(key, TomlValue::text_or_digits);
    let record = ImportRecord {
        source: text("source")?,
        source_sha256: text("source_sha256")?,
        mapping_sha256: text("mapping_sha256")?,
    };
    unknown.extend(section.unknown());
    Ok(record)
}

fn import_table(record: &ImportRecord) -> Table {
    let mut table = Table::new();
    put(&mut table, "source", record.source.as_deref());
    put(&mut table, "source_sha256", record.source_sha256.as_deref());
    put(
        &mut table,
        "mapping_sha256",
        record.mapping_sha256.as_deref(),
    );
    table
}

/// A table, or a line of text.
fn read_environment(value: &TomlValue<'_>, unknown: &mut Unknown) -> Read<Environment> {
    if let Ok(text) = value.text() {
        return Ok(Environment {
            text: Some(text.to_owned()),
            ..Environment::default()
        });
    }
    let section = value.table()?;
    let environment = Environment {
        temperature_deg_c: quantity(&section, "temp", Kind::Temperature)?,
        humidity_percent: section.read("humidity_percent", TomlValue::number)?,
        text: section.read("text", TomlValue::text_or_digits)?,
    };
    unknown.extend(section.unknown());
    Ok(environment)
}

fn read_instruments(section: &Section<'_>, unknown: &mut Unknown) -> Read<Instruments> {
    let mut gauge = |key: &str, kind: Kind| {
        section.read(key, |value| read_instrument(&value.table()?, kind, unknown))
    };
    let instruments = Instruments {
        force: gauge("force", Kind::Force)?,
        displacement: gauge("displacement", Kind::Displacement)?,
        displacement_along: [
            gauge(DISPLACEMENT_ALONG[0], Kind::Displacement)?,
            gauge(DISPLACEMENT_ALONG[1], Kind::Displacement)?,
            gauge(DISPLACEMENT_ALONG[2], Kind::Displacement)?,
        ],
    };
    unknown.extend(section.unknown());
    Ok(instruments)
}

fn read_instrument(
    section: &Section<'_>,
    kind: Kind,
    unknown: &mut Unknown,
) -> Read<InstrumentRecord> {
    let record = InstrumentRecord {
        model: section.read("model", TomlValue::text_or_digits)?,
        description: section.read("description", TomlValue::text_or_digits)?,
        serial: section.read("serial", TomlValue::text_or_digits)?,
        range: at_least_zero(section, "range", kind)?,
        resolution: at_least_zero(section, "resolution", kind)?,
        expanded_uncertainty: at_least_zero(section, "U", kind)?,
        k: section.read("k", |value| match value.number()? {
            k if k > 0.0 => Ok(k),
            _ => Err(value.wrong("a number above zero")),
        })?,
        reversibility: at_least_zero(section, "reversibility", kind)?,
        certificate: section.read("certificate", TomlValue::text_or_digits)?,
        calibrated: section.read("calibrated", day)?,
        due: section.read("due", day)?,
    };
    unknown.extend(section.unknown());
    Ok(record)
}

fn at_least_zero(section: &Section<'_>, stem: &str, kind: Kind) -> Read<Option<f64>> {
    let value = quantity(section, stem, kind)?;
    let Some((_, _, written)) = section.find_with_unit(stem, "", kind) else {
        return Ok(value);
    };
    match value {
        Some(below) if below < 0.0 => Err(written.wrong("a number of at least zero")),
        _ => Ok(value),
    }
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
    put(&mut table, "text", environment.text.as_deref());
    table
}

fn instrument_table(record: &InstrumentRecord, unit: &str, shift: i32) -> Table {
    let mut table = Table::new();
    let key = |stem: &str| format!("{stem}_{unit}");
    put(&mut table, "model", record.model.as_deref());
    put(&mut table, "description", record.description.as_deref());
    put(&mut table, "serial", record.serial.as_deref());
    put_number(&mut table, &key("range"), record.range, shift);
    put_number(&mut table, &key("resolution"), record.resolution, shift);
    put_number(&mut table, &key("U"), record.expanded_uncertainty, shift);
    put_number(&mut table, "k", record.k, 0);
    let reversibility = key("reversibility");
    put_number(&mut table, &reversibility, record.reversibility, shift);
    put(&mut table, "certificate", record.certificate.as_deref());
    put(&mut table, "calibrated", record.calibrated.map(date));
    put(&mut table, "due", record.due.map(date));
    table
}
