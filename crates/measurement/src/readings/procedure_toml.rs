//! Procedures as TOML: a file of its own, or the table frozen in a session's header.

use toml::{Table, Value};

use super::session_file::{ProcedureRecord, SessionFileError, SettleRecord, UnknownKey};
use super::toml_section::{Section, Source, parse};
use super::toml_values::{decimal, put, put_list, put_number, put_text, seed, word, words};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::PoseId;

/// The schema of procedures that is written, and the newest that is read.
pub const PROCEDURE_SCHEMA: &str = "stiffbench/procedure/1";

impl ProcedureRecord {
    /// Reads a procedure file; also gives the keys that mean nothing here, in the order of the file.
    ///
    /// Every key but `schema` may be absent. Quantities may have any unit of their kind behind the last underscore of the key.
    ///
    /// # Arguments
    /// - `source`: the name of the file, for messages.
    /// - `text`: its text.
    ///
    /// # Errors
    /// [`SessionFileError`] with the place in the file: not TOML, no or another or a newer schema, a value or a unit of the wrong kind.
    pub fn from_toml(
        source: &str,
        text: &str,
    ) -> Result<(Self, Vec<UnknownKey>), SessionFileError> {
        let source = Source::new(source, text);
        let document = parse(&source, text)?;
        let mut unknown = Vec::new();
        let root = Section::root(&source, document.get_ref());
        let record = read_procedure(root, true, &mut unknown)?;
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
    section: Section<'_>,
    must_say_what_it_is: bool,
    unknown: &mut Vec<UnknownKey>,
) -> Result<ProcedureRecord, SessionFileError> {
    section.check_schema(PROCEDURE_SCHEMA, must_say_what_it_is)?;
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

/// The procedure as a table, with everything that is known.
pub(super) fn procedure_table(procedure: &ProcedureRecord) -> Table {
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
