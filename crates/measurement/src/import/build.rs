//! Rows of a table to readings.

use indexmap::{IndexMap, IndexSet};

use super::columns::{ColumnRole, ImportedQuantity, MissingPart};
use super::draft::ImportDraft;
use super::joints::JointPoses;
use super::keywords::{OF_A_ROBOT, roles_of};
use super::mapping::ImportMapping;
use super::measured::measured;
use super::note::ImportNotes;
use super::pairs::are_all_equal;
use super::runs::{NEAR_ZERO, RunDoubt, doubt_of, runs_of, turns_more_than_once};
use super::values::{bad_value, branch, direction, meanings, texts};
use crate::readings::{
    FileCell, PoseJoints, ReadingTable, TableError, absent_columns, are_one_load, decimal,
    read_readings,
};
use crate::specimen::{TURN_SHARE, follow};
use crate::table_files::OWN_COLUMNS;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::nearest::listed_names;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Branch, Direction};

/// Readings that were made of a table.
#[derive(Debug)]
pub struct ImportedReadings {
    /// The readings.
    pub table: ReadingTable,
    /// Poses by their joint values, where the table has those.
    pub poses: Vec<PoseJoints>,
    /// What the columns were taken for: gives the same readings from the same file.
    pub mapping: ImportMapping,
    /// What was decided.
    pub notes: ImportNotes,
}

/// A row with its values in SI.
struct ImportedRow {
    pose: String,
    direction: Direction,
    repeat: u32,
    branch: Branch,
    force_n: f64,
    displacement_m: f64,
    raw: [String; 2],
    time_s: Option<f64>,
    temperature_deg_c: Option<f64>,
}

impl ImportDraft {
    /// The readings.
    ///
    /// # Errors
    /// [`TableError`] if something is missing; otherwise for the first cell that is not as it must be.
    pub fn finish(self, command: &str) -> Result<ImportedReadings, TableError> {
        let missing = self.missing();
        if !missing.is_empty() {
            let mut options: Vec<String> = missing.iter().map(MissingPart::option).collect();
            options.dedup();
            let missing: Vec<String> = missing.iter().map(ToString::to_string).collect();
            return Err(TableError::new(
                "stiffbench::import::missing",
                format!(
                    "{}: missing are {}; the columns are {}",
                    self.table.header(),
                    missing.join("; "),
                    listed_names(self.table.names())
                ),
                format!("{command} {}", options.join(" ")),
            ));
        }
        build(&self)
    }
}

pub(super) fn build(draft: &ImportDraft) -> Result<ImportedReadings, TableError> {
    let mut notes = ImportNotes::default();
    notes.note(draft.table.layout.to_string());
    let (rows, values) = measured(draft, &mut notes)?;
    let (places, joints) = poses(draft, &rows, &mut notes)?;
    let directions = directions(draft, &rows)?;
    notes.texts.extend(stated_over_columns(draft));
    for words in unused_words(draft, &rows) {
        notes.doubt(words);
    }
    notes.texts.extend(unused_columns(draft));
    if directions.iter().any(|(_, negative)| *negative) {
        notes.note("a direction with a minus sign: force and displacement of its rows were reversed to count along the positive axis");
    }
    let times = times(draft, &rows)?;
    let temperature = draft.found.place(&ColumnRole::Temperature);
    let mut imported = Vec::with_capacity(rows.len());
    for (place, row) in rows.iter().enumerate() {
        let (axis, negative) = directions[place];
        let sign = if negative { -1.0 } else { 1.0 };
        let [force_n, displacement_m] = values[place].map(|value| sign * value);
        let warmth = |column| {
            let conversion = draft.conversion(column, Kind::Temperature);
            draft.table.number(*row, column, conversion)
        };
        imported.push(ImportedRow {
            pose: places[place].clone(),
            direction: axis,
            repeat: 1,
            branch: Branch::Loading,
            force_n,
            displacement_m,
            raw: raw_texts(draft, *row),
            time_s: times[place],
            temperature_deg_c: temperature.map(warmth).transpose()?.flatten(),
        });
    }
    number_runs(draft, &rows, &mut imported, &mut notes)?;
    set_branches(draft, &rows, &mut imported, &mut notes)?;
    let mut mapping = complete(draft);
    if mapping.flip.is_empty() && is_against_force(&imported) {
        for row in &mut imported {
            row.displacement_m = -row.displacement_m;
        }
        mapping.flip.push(ImportedQuantity::Displacement);
        notes.doubt("the displacement goes against the force throughout: its sign was reversed");
    }
    let table = readings(draft, &imported)?;
    let absent = absent_columns(&table);
    let assumed = table.assumptions.iter();
    let assumed = assumed.filter(|one| !absent.contains(one));
    notes.texts.extend(assumed.cloned());
    Ok(ImportedReadings {
        table,
        poses: joints,
        mapping,
        notes,
    })
}

/// The pose of each row, and the joint values of the poses.
fn poses(
    draft: &ImportDraft,
    rows: &[usize],
    notes: &mut ImportNotes,
) -> Result<(Vec<String>, Vec<PoseJoints>), TableError> {
    let named = texts(draft, &ColumnRole::Pose, rows)?;
    if let Some((joints, of_rows)) = JointPoses::of_rows(draft, rows, named.as_deref())? {
        if joints.are_guessed_degrees {
            notes
                .note("joint values have no unit and exceed 2 pi: taken as degrees (--joint-unit)");
        }
        if named.is_none() {
            let poses = counted(joints.poses.len(), "pose");
            notes.note(format!("each set of joint values became a pose: {poses}"));
        }
        let names = of_rows.iter().map(ToString::to_string).collect();
        return Ok((names, joints.poses));
    }
    if let Some(named) = named.filter(|_| draft.mapping.pose.is_none()) {
        return Ok((named, Vec::new()));
    }
    let pose = draft.mapping.pose.clone().unwrap_or_else(|| {
        let pose = "P1".to_owned();
        notes.note(format!(
            "no column for the pose: all readings are of {pose} (--pose NAME)"
        ));
        pose
    });
    Ok((vec![pose; rows.len()], Vec::new()))
}

/// Columns of poses and directions that an option overrules.
fn stated_over_columns(draft: &ImportDraft) -> impl Iterator<Item = String> {
    let stated = [
        ("--pose", draft.mapping.pose.clone(), ColumnRole::Pose),
        (
            "--direction",
            draft.mapping.direction.clone(),
            ColumnRole::Direction,
        ),
    ];
    stated.into_iter().filter_map(|(option, value, role)| {
        let column = draft.name(draft.found.place(&role)?);
        let value = value?;
        Some(format!(
            "{option} {value} applies to all readings: column `{column}` is not read"
        ))
    })
}

/// Columns that could be used and are not, with why.
fn unused_columns(draft: &ImportDraft) -> Vec<String> {
    let found = &draft.found;
    let counters = found.counters.iter();
    let counters = counters.map(|(role, index, why)| {
        let column = draft.name(*index);
        format!(
            "column `{column}` is not used as the {role}: {why}; --map \"{role}={column}\" takes it"
        )
    });
    let alike = found.ambiguous.iter().map(|(role, places)| {
        let mut places = places.map(|place| place + 1);
        places.sort_unstable();
        let [first, second] = places;
        format!(
            "columns {first} and {second} are both called `{}` and are not used: --map {role}={first} takes the first",
            draft.name(first - 1)
        )
    });
    let roles = draft.columns().into_iter().enumerate();
    let others = roles.filter(|(index, column)| {
        let of_file = &draft.table.layout.columns[*index];
        let mut guesses = roles_of(of_file, &OF_A_ROBOT, None).into_iter();
        let is_displacement = guesses.any(|(role, _)| role == ColumnRole::Displacement);
        column.role.is_none() && is_displacement && draft.log.is_none()
    });
    let others = others.filter_map(|(_, column)| {
        let (name, unit) = (column.name, column.unit?);
        Some(format!(
            "column `{name}` is in {unit} too and is not used: --map displacement={name} takes it instead"
        ))
    });
    counters.chain(alike).chain(others).collect()
}

/// Columns that are not used, with a word in every row and a few words that recur.
fn unused_words(draft: &ImportDraft, rows: &[usize]) -> Vec<String> {
    const MOST: usize = 20;
    let columns = draft.table.layout.columns.iter().enumerate();
    let unused = columns.filter(|(index, column)| {
        let mut used = draft.found.places.values();
        !column.is_numeric && !used.any(|(place, _)| place == index)
    });
    let notes = unused.filter_map(|(index, column)| {
        let words = rows.iter().map(|row| draft.table.present(*row, index));
        let words: IndexSet<&str> = words.collect::<Option<_>>()?;
        let recur = words.len() > 1 && words.len() <= MOST && 2 * words.len() < rows.len();
        let name = &column.name;
        recur.then(|| {
            format!(
                "column `{name}` is not used and has the words {}: if it names poses or directions, readings of different poses or directions are mixed now; name it with --map pose={name}",
                words.into_iter().collect::<Vec<_>>().join(", ")
            )
        })
    });
    notes.collect()
}

/// The direction of each row, and whether it has a minus sign.
fn directions(draft: &ImportDraft, rows: &[usize]) -> Result<Vec<(Direction, bool)>, TableError> {
    let expected = "x, y or z";
    let Some(stated) = &draft.mapping.direction else {
        let role = &ColumnRole::Direction;
        return Ok(meanings(draft, role, rows, direction, expected)?.unwrap_or_default());
    };
    // Cells without a value are refused, whether they count or not.
    texts(draft, &ColumnRole::Direction, rows)?;
    let cell = || FileCell {
        file: draft.table.source.clone(),
        line: 1,
        column: "--direction".to_owned(),
        value: stated.clone(),
    };
    let one = direction(stated);
    let one = one.ok_or_else(|| bad_value(&cell(), expected))?;
    Ok(vec![one; rows.len()])
}

fn times(draft: &ImportDraft, rows: &[usize]) -> Result<Vec<Option<f64>>, TableError> {
    let Some(column) = draft.found.place(&ColumnRole::Time) else {
        return Ok(vec![None; rows.len()]);
    };
    if draft.table.is_time_stamp(column) {
        let seconds = draft.table.seconds(column)?;
        if are_all_equal(&seconds) {
            return Ok(vec![None; rows.len()]);
        }
        return Ok(rows.iter().map(|row| seconds[*row]).collect());
    }
    let conversion = draft.conversion(column, Kind::Time);
    let time = |row: &usize| draft.table.number(*row, column, conversion);
    rows.iter().map(time).collect()
}

/// Force and displacement as they stand in the file.
fn raw_texts(draft: &ImportDraft, row: usize) -> [String; 2] {
    [ColumnRole::Force, ColumnRole::Displacement].map(|role| {
        let column = draft.found.place(&role);
        let text = column.map(|column| draft.table.text(row, column));
        text.unwrap_or_default().to_owned()
    })
}

fn name_of_cell(row: &ImportedRow) -> String {
    format!("{} {}", row.pose, row.direction)
}

fn cell(row: &ImportedRow) -> (String, Direction) {
    (row.pose.clone(), row.direction)
}

/// Indices of the rows of each cell, or of each of its runs.
fn grouped<K: std::hash::Hash + Eq>(
    rows: &[ImportedRow],
    key: impl Fn(&ImportedRow) -> K,
) -> Vec<Vec<usize>> {
    let mut groups: IndexMap<K, Vec<usize>> = IndexMap::new();
    for (index, row) in rows.iter().enumerate() {
        groups.entry(key(row)).or_default().push(index);
    }
    groups.into_values().collect()
}

fn number_runs(
    draft: &ImportDraft,
    rows: &[usize],
    imported: &mut [ImportedRow],
    notes: &mut ImportNotes,
) -> Result<(), TableError> {
    let groups = grouped(imported, cell);
    if let Some(texts) = texts(draft, &ColumnRole::Repeat, rows)? {
        let number = |text: &String| text.parse::<u32>().ok().filter(|number| *number > 0);
        let numbers: Option<Vec<u32>> = texts.iter().map(number).collect();
        let column = draft.found.place(&ColumnRole::Repeat).unwrap_or(0);
        if numbers.is_none() {
            notes.note(format!(
                "the texts in column `{}` became repeats 1, 2, … in order of appearance",
                draft.name(column)
            ));
        }
        for group in &groups {
            let mut seen: IndexSet<&String> = IndexSet::new();
            for index in group {
                let numbered = seen.insert_full(&texts[*index]).0 as u32 + 1;
                imported[*index].repeat = numbers.as_ref().map_or(numbered, |n| n[*index]);
            }
        }
        let runs = grouped(imported, |row| (cell(row), row.repeat));
        let mut turning = runs.iter().filter(|run| {
            let loads: Vec<f64> = run.iter().map(|index| imported[*index].force_n).collect();
            turns_more_than_once(&loads)
        });
        if let Some(run) = turning.next() {
            let cell = name_of_cell(&imported[run[0]]);
            notes.doubt_runs(Some(draft.name(column)), &cell, RunDoubt::SeveralTurns);
        }
        return Ok(());
    }
    let (mut runs, mut doubt) = (0, None);
    for group in &groups {
        let loads: Vec<f64> = group.iter().map(|index| imported[*index].force_n).collect();
        let of_loads = runs_of(&loads);
        if doubt.is_none() {
            let first = &imported[group[0]];
            doubt = doubt_of(&loads, &of_loads).map(|why| (name_of_cell(first), why));
        }
        runs += of_loads.last().copied().unwrap_or(0) as usize;
        for (index, run) in group.iter().zip(of_loads) {
            imported[*index].repeat = run;
        }
    }
    notes.note(format!(
        "no column for the run number: {} found; a run begins where the load is lowest between two loadings, below {:.0} % of the largest",
        counted(runs, "run"),
        100.0 * NEAR_ZERO
    ));
    if let Some((cell, why)) = doubt {
        notes.doubt_runs(None, &cell, why);
    }
    Ok(())
}

fn set_branches(
    draft: &ImportDraft,
    rows: &[usize],
    imported: &mut [ImportedRow],
    notes: &mut ImportNotes,
) -> Result<(), TableError> {
    let (role, expected) = (&ColumnRole::Branch, "loading or unloading");
    if let Some(branches) = meanings(draft, role, rows, branch, expected)? {
        for (row, branch) in imported.iter_mut().zip(branches) {
            row.branch = branch;
        }
        return Ok(());
    }
    for run in grouped(imported, |row| (cell(row), row.repeat)) {
        let loads = run.iter().map(|index| imported[*index].force_n);
        if are_one_load(loads.clone()) {
            continue;
        }
        let loads = without_small_opposite(&loads.collect::<Vec<_>>());
        for (index, branch) in run.iter().zip(follow(&loads, 0.0, TURN_SHARE).branches) {
            imported[*index].branch = branch;
        }
    }
    let unloading = imported
        .iter()
        .filter(|row| row.branch == Branch::Unloading);
    let unloading = unloading.count();
    if unloading > 0 {
        let unloading = counted(unloading, "reading");
        notes.note(format!(
            "unloading: {unloading} after the largest load of a run"
        ));
    }
    Ok(())
}

/// Loads of which those near zero and of the other sign are zero: an unloaded gauge that shows a little less is not taken off.
fn without_small_opposite(loads: &[f64]) -> Vec<f64> {
    let largest = loads.iter().copied().fold(0.0_f64, |largest, load| {
        if load.abs() > largest.abs() {
            load
        } else {
            largest
        }
    });
    let is_small = |load: f64| load * largest < 0.0 && load.abs() <= NEAR_ZERO * largest.abs();
    let loads = loads.iter();
    loads
        .map(|load| if is_small(*load) { 0.0 } else { *load })
        .collect()
}

/// Whether the displacements go against the forces in every run: a gauge counts the other way, for no stiffness is negative.
fn is_against_force(imported: &[ImportedRow]) -> bool {
    let groups = grouped(imported, |row| (cell(row), row.repeat));
    groups.iter().all(|group| {
        let n = group.len() as f64;
        let mean = |of: fn(&ImportedRow) -> f64| {
            group.iter().map(|index| of(&imported[*index])).sum::<f64>() / n
        };
        let force = mean(|row| row.force_n);
        let displacement = mean(|row| row.displacement_m);
        let product = |index: &usize| {
            let row = &imported[*index];
            (row.force_n - force) * (row.displacement_m - displacement)
        };
        group.iter().map(product).sum::<f64>() < 0.0
    })
}

/// The rows as `readings.csv`, through the reader of that form.
fn readings(draft: &ImportDraft, rows: &[ImportedRow]) -> Result<ReadingTable, TableError> {
    let has_time = rows.iter().all(|row| row.time_s.is_some());
    let has_temperature = rows.iter().any(|row| row.temperature_deg_c.is_some());
    let mut names = vec![
        "pose",
        "direction",
        "branch",
        "repeat",
        "force_N",
        "force_raw",
        "displacement_um",
        "displacement_raw",
    ];
    names.extend(has_time.then_some("t_s"));
    names.extend(has_temperature.then_some("temp_degC"));
    let mut output = csv::Writer::from_writer(Vec::new());
    output
        .write_record(&names)
        .map_err(TableError::not_written)?;
    for row in rows {
        let [force_raw, displacement_raw] = row.raw.clone();
        let mut fields = vec![
            row.pose.clone(),
            row.direction.to_string(),
            row.branch.to_string(),
            row.repeat.to_string(),
            decimal(row.force_n, 0),
            force_raw,
            decimal(row.displacement_m, 6),
            displacement_raw,
        ];
        for (is_written, value) in [
            (has_time, row.time_s),
            (has_temperature, row.temperature_deg_c),
        ] {
            let text = || value.map_or_else(String::new, |value| decimal(value, 0));
            fields.extend(is_written.then(text));
        }
        output
            .write_record(&fields)
            .map_err(TableError::not_written)?;
    }
    let bytes = output
        .into_inner()
        .map_err(|error| TableError::not_written(error.into_error().into()))?;
    read_readings(&draft.table.source, bytes.as_slice())
}

/// The mapping with what was guessed.
fn complete(draft: &ImportDraft) -> ImportMapping {
    let mut mapping = draft.mapping.clone();
    mapping.columns.repeats.clone_from(&draft.repeats);
    for (role, (index, _)) in &draft.found.places {
        let column = draft.name(*index).to_owned();
        // Columns that are no part of a file are found again.
        if *role == ColumnRole::Repeat && OWN_COLUMNS.contains(&column.as_str()) {
            continue;
        }
        match role {
            ColumnRole::Joint(name) => {
                mapping.joints.entry(name.clone()).or_insert(column);
            }
            role => {
                if let Some(entry) = mapping.columns.entry(&role.to_string()) {
                    entry.get_or_insert(column);
                }
            }
        }
    }
    mapping
}
