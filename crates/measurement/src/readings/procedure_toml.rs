//! Procedures as TOML: a file of its own, or the table frozen in a session's header.

use toml::Table;

use super::session_file::{ProcedureRecord, SettleRecord};
use super::toml_values::{
    decimal, one_of, put, put_list, put_number, put_text, quantities, quantity, rate, seed, word,
    words,
};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::{self, Document, Read, TomlValue, UnknownKey};

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
        let document = Document::parse(source)?;
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
    table: &toml_text::Table<'_>,
    must_say_what_it_is: bool,
    unknown: &mut Vec<UnknownKey>,
) -> Read<ProcedureRecord> {
    table.check_schema(PROCEDURE_SCHEMA, must_say_what_it_is)?;
    let procedure = ProcedureRecord {
        name: table.read("name", TomlValue::text_or_digits)?,
        text: table.read("text", TomlValue::text_or_digits)?,
        poses: table.read_all("poses", |name| name.text().map(PoseId::new))?,
        directions: table.read_all("directions", one_of)?,
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
    };
    unknown.extend(table.unknown());
    Ok(procedure)
}

fn read_settle(table: &toml_text::Table<'_>, unknown: &mut Vec<UnknownKey>) -> Read<SettleRecord> {
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

/// The procedure as a table, with everything that is known.
pub(super) fn procedure_table(procedure: &ProcedureRecord) -> Table {
    let mut table = Table::new();
    put(
        &mut table,
        "schema",
        Some(toml::Value::from(PROCEDURE_SCHEMA)),
    );
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
    put(
        &mut table,
        "repeats",
        procedure.repeats.map(toml::Value::from),
    );
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
        put(&mut table, "settle", Some(toml::Value::Table(inner)));
    }
    table
}
