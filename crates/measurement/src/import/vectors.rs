//! Tables of loads and of what was read along three axes, under names of their own, as the table of load cases that analyses read.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::columns::{ColumnGuess, GuessedFrom};
use super::joint_unit::joint_unit_among;
use super::keywords::{is_of, joint_name};
use super::mapping::ImportMapping;
use super::vector_role::{TEXTS, VectorRole};
use crate::load_cases::{VectorQuantity, vector_columns};
use crate::readings::{Conversion, JointUnit, TableError, is_readings_header, is_vector_table};
use crate::table_files::keywords::{
    DISPLACEMENT, FORCE, MOMENT, POSE, POSITION, REPEAT, ROTATION, has, plain, words_of,
};
use crate::table_files::{FileColumn, MachineTable, read_table_files};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::Direction;

/// A table of load cases, as text under the names that its reader knows.
#[derive(Debug, Clone)]
pub struct VectorText {
    /// The text; each row is in the line in which it is in its file, if it is of one file.
    pub text: String,
    /// The columns of the file, and what they were taken for.
    pub columns: Vec<ColumnGuess>,
    /// What was decided.
    pub notes: Vec<String>,
    /// What the columns were taken for: gives the same text from the same file.
    pub mapping: ImportMapping,
}

impl VectorText {
    /// Reads a table; `None` where it has no vectors along at least two axes, or neither poses nor joint values.
    ///
    /// # Arguments
    /// - `files`: names, for messages, and bytes.
    ///
    /// # Errors
    /// For a table that cannot be read, a column that is stated and not there, and a value or a unit that cannot be.
    pub fn read(
        files: &[(&str, &[u8])],
        mapping: &ImportMapping,
    ) -> Result<Option<Self>, TableError> {
        let of_one = |known: fn(&[u8]) -> bool| files.iter().any(|(_, bytes)| known(bytes));
        if of_one(is_readings_header) || of_one(is_vector_table) {
            return Ok(None);
        }
        let table = match read_table_files(files, &mapping.of_file()) {
            Ok(table) => table,
            // Who reads the file otherwise states what is wrong with it.
            Err(_) if mapping.vectors.is_empty() => return Ok(None),
            Err(error) => return Err(error),
        };
        let is_series = is_vector_table(record(table.names()).as_bytes());
        let roles = if is_series {
            Roles::new()
        } else {
            roles(&table, mapping)?
        };
        let found = roles
            .keys()
            .filter(|role| matches!(role, VectorRole::Component(..)));
        let known = files.iter().map(|(_, bytes)| vector_columns(bytes)).max();
        let is_known = found.count() <= known.unwrap_or(0) && mapping.vectors.is_empty();
        if !is_series && (is_known || !is_of_vectors(&roles)) {
            return Ok(None);
        }
        let units = units(&table, &roles, mapping)?;
        let text = text(&table, &roles, &units)?;
        let mut stated = mapping.clone();
        for (role, (index, _)) in &roles {
            let column = table.name(*index).to_owned();
            match role {
                VectorRole::Joint(name) => stated.joints.entry(name.clone()).or_insert(column),
                role => stated.vectors.entry(role.name()).or_insert(column),
            };
        }
        let mut notes = vec![table.layout.to_string()];
        if !is_series {
            notes.push(taken(&table, &roles));
        }
        let columns = table.layout.columns.iter().enumerate();
        let unused: Vec<&str> = columns
            .filter(|(index, _)| !is_series && roles.values().all(|(place, _)| place != index))
            .map(|(_, column)| column.name.as_str())
            .filter(|name| !name.is_empty())
            .collect();
        if !unused.is_empty() {
            notes.push(format!("not used: {}", unused.join(", ")));
        }
        Ok(Some(Self {
            text,
            columns: guesses(&table, &roles, &units),
            notes,
            mapping: stated,
        }))
    }
}

type Roles = BTreeMap<VectorRole, (usize, GuessedFrom)>;

/// Vectors have two axes at least, and stand with the pose in which they were read.
fn is_of_vectors(roles: &Roles) -> bool {
    let axes = |quantity| {
        let of = |axis| roles.contains_key(&VectorRole::Component(quantity, axis));
        Direction::ALL.into_iter().filter(|axis| of(*axis)).count()
    };
    let has_pose = roles
        .keys()
        .any(|role| matches!(role, VectorRole::Joint(_) | VectorRole::Text("pose")));
    has_pose
        && VectorQuantity::ALL
            .into_iter()
            .any(|quantity| axes(quantity) > 1)
}

fn roles(table: &MachineTable, mapping: &ImportMapping) -> Result<Roles, TableError> {
    let mut roles = Roles::new();
    let joints = mapping.joints.iter();
    let joints = joints.map(|(name, column)| (format!("joint.{name}"), column));
    let texts = [
        ("pose", &mapping.columns.pose),
        ("repeat", &mapping.columns.repeat),
    ];
    let texts = texts
        .into_iter()
        .filter_map(|(name, column)| Some((name.to_owned(), column.as_ref()?)));
    let vectors = mapping
        .vectors
        .iter()
        .map(|(name, column)| (name.clone(), column));
    for (name, column) in joints.chain(texts).chain(vectors) {
        let Some(role) = VectorRole::named(&name) else {
            continue;
        };
        let index = table.column(column, &name)?;
        if let Some((first, _)) = roles.iter().find(|(_, (place, _))| *place == index) {
            return Err(table.same_column(column, &first.name(), &name));
        }
        roles.insert(role, (index, GuessedFrom::Stated));
    }
    let columns = &table.layout.columns;
    let has_displacements = columns.iter().any(|column| {
        let component = component(column, false);
        matches!(component, Some((VectorQuantity::Displacement, _)))
    });
    for (index, column) in columns.iter().enumerate() {
        if roles.values().any(|(place, _)| *place == index) {
            continue;
        }
        let Some(role) = role(column, !has_displacements) else {
            continue;
        };
        match roles.get(&role) {
            Some((_, GuessedFrom::Stated)) => {}
            Some((first, _))
                if matches!(role, VectorRole::Component(..) | VectorRole::Joint(_)) =>
            {
                let (first, name) = (*first, role.name());
                return Err(table.duplicate(&column.name, &name, [first, index]));
            }
            Some(_) => {}
            None => {
                roles.insert(role, (index, GuessedFrom::Name));
            }
        }
    }
    Ok(roles)
}

fn role(column: &FileColumn, may_be_positions: bool) -> Option<VectorRole> {
    let name = plain(&column.stem);
    if let Some(text) = TEXTS.into_iter().find(|text| *text == name) {
        return Some(VectorRole::Text(text));
    }
    if let Some((quantity, axis)) = component(column, may_be_positions) {
        return Some(VectorRole::Component(quantity, axis));
    }
    let unit = column.unit.as_deref();
    let is_angle = unit.is_some_and(|unit| is_of(Kind::Angle, unit));
    if column.is_numeric
        && let Some(joint) = joint_name(&name, &column.stem)
    {
        return Some(VectorRole::Joint(joint));
    }
    if column.is_numeric && is_angle {
        return Some(VectorRole::Joint(column.stem.clone()));
    }
    let is_one = |list| unit.is_none() && words_of(&name).any(|word| has(list, word));
    if is_one(POSE) {
        return Some(VectorRole::Text("pose"));
    }
    (is_one(REPEAT) && column.is_numeric).then_some(VectorRole::Text("repeat"))
}

/// The component that a column is by its name: `Kraft X`, `force_x`, `Fx`, `dy`, `Verschiebung z`, `Mx`, `rx`, and `X` of a tracker.
fn component(column: &FileColumn, may_be_position: bool) -> Option<(VectorQuantity, Direction)> {
    use VectorQuantity::{Displacement, Force, Moment, Position, Rotation};
    const BY_WORD: [(VectorQuantity, &str); 5] = [
        (Position, POSITION),
        (Moment, MOMENT),
        (Rotation, ROTATION),
        (Force, FORCE),
        (Displacement, DISPLACEMENT),
    ];
    const BY_LETTER: [(VectorQuantity, &str); 5] = [
        (Force, "f"),
        (Moment, "mt"),
        (Displacement, "duvw"),
        (Rotation, "r"),
        (Position, "p"),
    ];
    if !column.is_numeric {
        return None;
    }
    let fits = |quantity: VectorQuantity| {
        let unit = column.unit.as_deref();
        unit.is_none_or(|unit| is_of(quantity.kind(), unit))
            .then_some(quantity)
    };
    let name = plain(&column.stem).replace('_', " ");
    let words: Vec<&str> = words_of(&name).collect();
    if let [one] = words[..] {
        let axis: Direction = one.get(one.len().checked_sub(1)?..)?.parse().ok()?;
        let before = &one[..one.len() - 1];
        if before.is_empty() {
            let is_length = column
                .unit
                .as_deref()
                .is_some_and(|unit| is_of(Kind::Displacement, unit));
            return (may_be_position && is_length).then_some((Position, axis));
        }
        let mut known = BY_LETTER.into_iter();
        let quantity = known.find(|(_, letters)| before.len() == 1 && letters.contains(before));
        let mut worded = BY_WORD.into_iter();
        let quantity = quantity.or_else(|| worded.find(|(_, list)| has(list, before)));
        return Some((fits(quantity?.0)?, axis));
    }
    let mut axes = words
        .iter()
        .filter_map(|word| word.parse::<Direction>().ok());
    let (axis, None) = (axes.next()?, axes.next()) else {
        return None;
    };
    let of_word = |list| words.iter().any(|word| has(list, word));
    let mut known = BY_WORD.into_iter().filter(|(_, list)| of_word(list));
    let quantity = known.find_map(|(quantity, _)| fits(quantity))?;
    Some((quantity, axis))
}

/// The unit of each component and joint, by column.
fn units(
    table: &MachineTable,
    roles: &Roles,
    mapping: &ImportMapping,
) -> Result<BTreeMap<usize, String>, TableError> {
    let mut units = BTreeMap::new();
    for (role, (index, _)) in roles {
        let column = &table.layout.columns[*index];
        let (kind, accepted) = match role {
            VectorRole::Text(_) => continue,
            VectorRole::Joint(_) => (Kind::Angle, JointUnit::ACCEPTED),
            VectorRole::Component(quantity, _) => (quantity.kind(), quantity.kind().units()),
        };
        let unit = match role {
            VectorRole::Joint(_) => {
                let joints = roles.iter().filter_map(|(role, (index, _))| {
                    matches!(role, VectorRole::Joint(_)).then_some(*index)
                });
                joint_unit_among(table, mapping, *index, joints).map(|unit| unit.name)
            }
            _ => mapping.unit_of(column, kind),
        };
        let unit = unit.ok_or_else(|| {
            let (at, name, role) = (table.header(), &column.name, role.name());
            TableError::new(
                "stiffbench::import::no_unit",
                format!("{at}: column `{name}`, taken as {role}, has no unit of it"),
                format!(
                    "put the unit behind the name, for example `{name} [UNIT]`: known are {accepted}"
                ),
            )
        })?;
        units.insert(*index, unit);
    }
    Ok(units)
}

/// The table under the names that are known, its rows in their lines.
fn text(
    table: &MachineTable,
    roles: &Roles,
    units: &BTreeMap<usize, String>,
) -> Result<String, TableError> {
    let mut text = String::new();
    let mut line = 1;
    let mut put = |at: u32, record: &str| {
        while line < at {
            text.push('\n');
            line += 1;
        }
        let _ = writeln!(text, "{record}");
        line += 1;
    };
    let header = table.layout.header_line.unwrap_or(0);
    if roles.is_empty() {
        put(header, &record(table.names()));
    }
    let names = roles.iter().map(|(role, (index, _))| match role {
        VectorRole::Text(name) => (*name).to_owned(),
        VectorRole::Joint(name) => format!("joint_{name} [{}]", units[index]),
        VectorRole::Component(..) => format!("{} [{}]", role.name(), units[index]),
    });
    let names: Vec<String> = names.collect();
    if !roles.is_empty() {
        put(header, &record(names.iter().map(String::as_str)));
    }
    let is_one = table.is_of_one_file();
    for row in 0..table.rows.len() {
        let line = if is_one { table.rows[row].line } else { 0 };
        if roles.is_empty() {
            let cells = 0..table.layout.columns.len();
            put(line, &record(cells.map(|index| table.text(row, index))));
            continue;
        }
        if roles
            .values()
            .all(|(index, _)| table.present(row, *index).is_none())
        {
            continue;
        }
        let cells = roles.iter().map(|(role, (index, _))| {
            if matches!(role, VectorRole::Text(_)) {
                return Ok(table.present(row, *index).unwrap_or_default().to_owned());
            }
            table.number(row, *index, Conversion::NONE)?;
            Ok(table.plain_number(row, *index))
        });
        let cells: Vec<String> = cells.collect::<Result<_, TableError>>()?;
        put(line, &record(cells.iter().map(String::as_str)));
    }
    Ok(text)
}

/// Fields as a record of a text with commas, in one line.
fn record<'t>(fields: impl Iterator<Item = &'t str>) -> String {
    let quoted = |text: &str| {
        let text = text.replace('"', "\"\"").replace(['\n', '\r'], " ");
        if text.contains([',', '"', ';', '\t']) {
            format!("\"{text}\"")
        } else {
            text
        }
    };
    fields.map(quoted).collect::<Vec<_>>().join(",")
}

/// What was taken for what, in one sentence.
fn taken(table: &MachineTable, roles: &Roles) -> String {
    let taken: Vec<String> = roles
        .iter()
        .map(|(role, (index, _))| format!("`{}` as {}", table.name(*index), role.name()))
        .collect();
    format!(
        "columns were taken by their names: {} (--map force_x=COLUMN)",
        taken.join(", ")
    )
}

fn guesses(
    table: &MachineTable,
    roles: &Roles,
    units: &BTreeMap<usize, String>,
) -> Vec<ColumnGuess> {
    let columns = table.layout.columns.iter().enumerate();
    let guess = columns.map(|(index, column)| {
        let mut roles = roles.iter();
        let role = roles.find(|(_, (place, _))| *place == index);
        ColumnGuess {
            name: column.name.clone(),
            role: role.map(|(role, _)| role.name()),
            unit: units.get(&index).or(column.unit.as_ref()).cloned(),
            from: role.map(|(_, (_, from))| *from),
            first_values: table.first_values(index),
        }
    });
    guess.collect()
}
