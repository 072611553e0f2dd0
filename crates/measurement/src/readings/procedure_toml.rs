//! Procedures as TOML: a file of its own, or the table frozen in a session's header.

use toml::Table;

use super::joint_values::{joint_values_table, read_joint_values};
use super::session_file::{ProcedureRecord, ReadingLimits, SettleRecord};
use super::toml_values::{
    decimal, one_of, put, put_list, put_number, quantities, quantity, rate, seed, word, words,
};
use stiffbench_units_and_text::load_direction::{LoadDirection, meant_direction};
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::{self, Read, TomlDocument, TomlValue, UnknownKey};

/// The schema of procedures that is written, and the newest that is read.
pub const PROCEDURE_SCHEMA: &str = "stiffbench/procedure/1";

impl ProcedureRecord {
    /// Reads a procedure file; also gives the keys that mean nothing here, in the order of the file.
    ///
    /// Every key but `schema` may be absent. Quantities may have any unit of their kind behind the last underscore of the key.
    ///
    /// # Errors
    /// With the place in the file: not TOML, no or another or a newer schema, a value or a unit of the wrong kind.
    pub(crate) fn from_toml(source: &SourceText) -> Read<(Self, Vec<UnknownKey>)> {
        let document = TomlDocument::parse(source)?;
        let mut unknown = Vec::new();
        let record = read_procedure(&document.root(), true, &mut unknown)?;
        unknown.sort_by_key(|unknown| unknown.line);
        Ok((record, unknown))
    }

    /// The record as the table of a file, `schema` first; quantities in the units of files.
    #[must_use]
    pub(crate) fn to_table(&self) -> Table {
        procedure_table(self)
    }
}

/// The procedure of a table: that of a session's header, or a procedure file itself.
pub(super) fn read_procedure(
    table: &toml_text::TomlTable<'_>,
    must_say_what_it_is: bool,
    unknown: &mut Vec<UnknownKey>,
) -> Read<ProcedureRecord> {
    table.check_schema(PROCEDURE_SCHEMA, must_say_what_it_is)?;
    let procedure = ProcedureRecord {
        name: table.read("name", TomlValue::text_or_digits)?,
        text: table.read("text", TomlValue::text_or_digits)?,
        poses: table.read_all("poses", |name| name.text().map(PoseId::new))?,
        specimens: table.read_all("specimens", |name| name.text().map(str::to_owned))?,
        joint_values: read_joint_values(table)?,
        directions: read_directions(table, unknown)?,
        displacement_axes: table.read_all("displacement_axes", one_of)?,
        loads_n: quantities(table, "loads", Kind::Force)?,
        branches: table.read_all("branches", one_of)?,
        repeats: table.read("repeats", TomlValue::count)?,
        repeat_order: table.read("repeat_order", one_of)?,
        load_order: table.read("load_order", one_of)?,
        seed: table.read("seed", TomlValue::count)?,
        zero: table.read("zero", one_of)?,
        preload_n: quantity(table, "preload", Kind::Force)?,
        holds_s: quantities(table, "holds", Kind::Time)?,
        settle: read_settle(table, unknown)?,
        limits: read_limits(table, unknown)?,
        answer_within_s: read_answer_within(table)?,
    };
    unknown.extend(table.unknown());
    Ok(procedure)
}

/// What an entry of `directions` may be.
const DIRECTIONS: &str = "\"x\", \"y\", \"z\", \"-x\", \"-y\", \"-z\", a name of [load_directions], or a unit vector like [0, 0.6, 0.8]";

/// The directions of the loads: words for axes, names of `[load_directions]`, unit vectors.
fn read_directions(
    table: &toml_text::TomlTable<'_>,
    unknown: &mut Vec<UnknownKey>,
) -> Read<Vec<LoadDirection>> {
    let mut named: Vec<(String, LoadDirection)> = Vec::new();
    if let Some(names) = table.read("load_directions", TomlValue::table)? {
        for (name, _, value) in names.entries() {
            // What reads as a direction by itself cannot mean another one.
            let is_odd = name.trim().is_empty() || name.chars().any(char::is_control);
            if is_odd || name.parse::<LoadDirection>().is_ok() {
                return Err(value.wrong("a name other than x, y, z, -x, -y, -z"));
            }
            let direction = vector(&value)?.named(name);
            named.push((name.to_owned(), direction));
        }
        let mut used = Vec::new();
        for item in table
            .get("directions")
            .map_or(Ok(Vec::new()), |list| list.items())?
        {
            used.extend(item.text().ok().map(str::to_owned));
        }
        for (name, span, _) in names.entries() {
            if !used.iter().any(|word| word == name) {
                let (line, column) = names.source().line_and_column(span.start);
                unknown.push(UnknownKey {
                    key: format!("load_directions.{name}"),
                    line,
                    column,
                    meant: None,
                });
            }
        }
    }
    table.read_all("directions", |value| {
        let Ok(text) = value.text() else {
            return vector(value);
        };
        let known = named.iter().find(|(name, _)| name == text);
        let known = known.map(|(_, direction)| direction.clone());
        known.or_else(|| text.parse().ok()).ok_or_else(|| {
            let names = named.iter().map(|(name, _)| name.as_str());
            let meant = nearest(text, names).or_else(|| meant_direction(text));
            let Some(meant) = meant else {
                return value.wrong(DIRECTIONS);
            };
            value.refused(format!("`{text}`: did you mean `{meant}`?"), DIRECTIONS)
        })
    })
}

/// A unit vector of three numbers.
fn vector(value: &TomlValue<'_>) -> Read<LoadDirection> {
    const EXPECTED: &str = "a unit vector of three numbers like [0, 0.6, 0.8]";
    let parts = value.items().map_err(|_| value.wrong(EXPECTED))?;
    let parts: Vec<f64> = parts.iter().map(TomlValue::number).collect::<Read<_>>()?;
    let parts: [f64; 3] = parts.try_into().map_err(|_| value.wrong(EXPECTED))?;
    LoadDirection::from_vector(parts).map_err(|error| value.refused(error.to_string(), EXPECTED))
}

fn read_settle(
    table: &toml_text::TomlTable<'_>,
    unknown: &mut Vec<UnknownKey>,
) -> Read<SettleRecord> {
    let mut settle = SettleRecord::default();
    if let Some(table) = table.read("settle", TomlValue::table)? {
        settle = SettleRecord {
            force_tolerance_n: quantity(&table, "force_tolerance", Kind::Force)?,
            dwell_s: quantity(&table, "dwell", Kind::Time)?,
            spread_m: quantity(&table, "spread", Kind::Displacement)?,
            slope_m_per_s: rate(&table, "slope", "_per_s", Kind::Displacement)?,
        };
        unknown.extend(table.unknown());
    }
    // Short headers have the tolerance without the table around it.
    if settle.force_tolerance_n.is_none() {
        settle.force_tolerance_n = quantity(table, "force_tolerance", Kind::Force)?;
    }
    Ok(settle)
}

fn read_limits(
    table: &toml_text::TomlTable<'_>,
    unknown: &mut Vec<UnknownKey>,
) -> Read<ReadingLimits> {
    let Some(table) = table.read("limits", TomlValue::table)? else {
        return Ok(ReadingLimits::default());
    };
    let limits = ReadingLimits {
        force_warn_n: quantity(&table, "force_warn", Kind::Force)?,
        force_hard_n: quantity(&table, "force_hard", Kind::Force)?,
        displacement_warn_m: quantity(&table, "displacement_warn", Kind::Displacement)?,
        displacement_hard_m: quantity(&table, "displacement_hard", Kind::Displacement)?,
    };
    unknown.extend(table.unknown());
    Ok(limits)
}

/// `[answer_within]`: a time for each question, as in `setup_s`.
fn read_answer_within(table: &toml_text::TomlTable<'_>) -> Read<Vec<(String, f64)>> {
    let Some(table) = table.read("answer_within", TomlValue::table)? else {
        return Ok(Vec::new());
    };
    let mut times = Vec::new();
    for (key, _, value) in table.entries() {
        let Some((question, _)) = key.rsplit_once('_') else {
            return Err(value.wrong("a question with a unit of time behind it, as in setup_s"));
        };
        if let Some(time_s) = quantity(&table, question, Kind::Time)? {
            times.push((question.to_owned(), time_s));
        }
    }
    Ok(times)
}

/// The procedure as a table, with everything that is known.
pub(super) fn procedure_table(procedure: &ProcedureRecord) -> Table {
    let mut table = Table::new();
    put(&mut table, "schema", Some(PROCEDURE_SCHEMA));
    put(&mut table, "name", procedure.name.as_deref());
    put(&mut table, "text", procedure.text.as_deref());
    let names = procedure.poses.iter().map(PoseId::as_str);
    put_list(&mut table, "poses", names);
    if !procedure.specimens.is_empty() {
        let names = procedure.specimens.iter().map(String::as_str);
        put_list(&mut table, "specimens", names);
    }
    put_list(
        &mut table,
        "directions",
        procedure.directions.iter().map(direction_value),
    );
    if !procedure.displacement_axes.is_empty() {
        put_list(
            &mut table,
            "displacement_axes",
            words(&procedure.displacement_axes),
        );
    }
    put_list(
        &mut table,
        "loads_N",
        procedure.loads_n.iter().map(|n| decimal(*n, 0)),
    );
    put_list(&mut table, "branches", words(&procedure.branches));
    put(&mut table, "repeats", procedure.repeats);
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
        put(&mut table, "settle", Some(inner));
    }
    let limits = &procedure.limits;
    if *limits != ReadingLimits::default() {
        put(&mut table, "limits", Some(limits_table(limits)));
    }
    if !procedure.answer_within_s.is_empty() {
        let mut inner = Table::new();
        for (question, time_s) in &procedure.answer_within_s {
            put_number(&mut inner, &format!("{question}_s"), Some(*time_s), 0);
        }
        put(&mut table, "answer_within", Some(inner));
    }
    put(
        &mut table,
        "joint_values",
        joint_values_table(&procedure.joint_values),
    );
    let mut names = Table::new();
    for direction in &procedure.directions {
        if let Some(name) = direction.name() {
            put(&mut names, name, Some(vector_value(direction)));
        }
    }
    if !names.is_empty() {
        put(&mut table, "load_directions", Some(names));
    }
    table
}

fn limits_table(limits: &ReadingLimits) -> Table {
    let mut table = Table::new();
    for (key, value, shift) in [
        ("force_warn_N", limits.force_warn_n, 0),
        ("force_hard_N", limits.force_hard_n, 0),
        ("displacement_warn_um", limits.displacement_warn_m, 6),
        ("displacement_hard_um", limits.displacement_hard_m, 6),
    ] {
        put_number(&mut table, key, value, shift);
    }
    table
}

/// A direction in the list of directions.
fn direction_value(direction: &LoadDirection) -> toml::Value {
    let word = direction.to_string();
    if direction.name().is_some() || word.parse::<LoadDirection>().as_ref() == Ok(direction) {
        toml::Value::from(word)
    } else {
        vector_value(direction)
    }
}

fn vector_value(direction: &LoadDirection) -> toml::Value {
    let parts = direction.unit_vector().map(toml::Value::from);
    toml::Value::Array(parts.to_vec())
}
