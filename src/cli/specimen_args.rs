//! How a table without a robot is read.

use std::collections::BTreeSet;

use clap::Args;

use crate::analysis::ArgumentError;
use crate::import::{ImportDraft, ImportMapping};
use crate::nearest::listed_names;
use crate::readings::DecimalSign;
use crate::specimen::{ResponseVariable, SpecimenOptions, TURN_SHARE};
use crate::table_files::{TableFileOptions, TextEncoding};

use super::failure::Failure;
use super::import::column_pairs;
use super::option_values::{ENCODINGS, OptionValue, decimal_signs, one_of};

/// Units and form of a table of force against displacement that has no robot.
#[derive(Debug, Clone, PartialEq, Args)]
#[command(next_help_heading = "Table without a robot")]
pub(super) struct PartTableArgs {
    /// Unit of the force, torque or stress: N, kN, kgf, lbf, N*m, lbf*in, MPa, psi, ..., or 1 to keep the numbers as they are [default: that of the file]
    #[arg(long, value_name = "UNIT")]
    force_unit: Option<String>,
    /// Unit of the displacement, angle or strain: mm, um, in, mil, rad, deg, %, microstrain, ..., or 1 to keep the numbers as they are [default: that of the file]
    #[arg(long, value_name = "UNIT")]
    displacement_unit: Option<String>,
    /// Unit of time and hold: s, ms, min, h, d [default: that of the file; dates and times of day need none]
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<String>,
    /// Unit of the temperature: degC, K, degF [default: that of the file, else degC]
    #[arg(long, value_name = "UNIT")]
    temperature_unit: Option<String>,
    /// The measured quantity: force if the displacement or strain was set [default: where one of the two is a ramp or a sine of time, the other; else the one that scatters more; else displacement]
    #[arg(long, value_parser = one_of(RESPONSES))]
    response: Option<ResponseVariable>,
    /// Share of a run's range by which the path must return before it counts as unloading
    #[arg(long, value_name = "SHARE", default_value_t = TURN_SHARE)]
    turn_share: f64,
    /// Encoding of the text [default: detected from its words]
    #[arg(long, value_parser = one_of(ENCODINGS))]
    encoding: Option<TextEncoding>,
    /// Sheet of a spreadsheet [default: all with rows of numbers under the same names]
    #[arg(long, value_name = "NAME")]
    sheet: Option<String>,
    /// Decimal sign of the numbers [default: detected from all of them]
    #[arg(long, value_parser = one_of(decimal_signs(DecimalSign::Point, DecimalSign::Comma)))]
    decimal: Option<DecimalSign>,
}

/// The same with an option for each column, as scripts call `diagnose`.
#[derive(Debug, Clone, Args)]
#[command(mut_args(|argument| {
    let is_of_parts = argument.get_help_heading() == Some("Table without a robot");
    if is_of_parts { argument.hide(true) } else { argument }
}))]
#[command(next_help_heading = "Table without a robot")]
pub(super) struct SpecimenArgs {
    /// DATA is a table without a robot
    #[arg(long, requires = "displacement_column")]
    specimen: bool,
    /// Column of the force
    #[arg(long, value_name = "NAME", requires = "specimen")]
    force_column: Option<String>,
    /// Column of the displacement
    #[arg(long, value_name = "NAME", requires = "specimen")]
    displacement_column: Option<String>,
    /// Column of the time
    #[arg(long, value_name = "NAME", requires = "specimen")]
    time_column: Option<String>,
    /// Column that identifies runs
    #[arg(long, value_name = "NAME", requires = "specimen")]
    run_column: Vec<String>,
    /// Column that identifies configurations
    #[arg(long, value_name = "NAME", requires = "specimen")]
    configuration_column: Vec<String>,
    /// Column of the temperature
    #[arg(long, value_name = "NAME", requires = "specimen")]
    temperature_column: Option<String>,
    /// Column of the time under the load
    #[arg(long, value_name = "NAME", requires = "specimen")]
    hold_column: Option<String>,
    /// Column with the order of measurement
    #[arg(long, value_name = "NAME", requires = "specimen")]
    order_column: Option<String>,
    /// Column with loading and unloading
    #[arg(long, value_name = "NAME", requires = "specimen")]
    branch_column: Option<String>,
    /// Units and form.
    #[command(flatten)]
    table: PartTableArgs,
}

/// Which quantity answers.
const RESPONSES: [OptionValue<ResponseVariable>; 2] = [
    (
        "displacement",
        "Loads were set, the displacement was measured",
        ResponseVariable::Displacement,
    ),
    (
        "force",
        "Displacements were set, the force was measured",
        ResponseVariable::Force,
    ),
];

impl PartTableArgs {
    /// What the reader needs, without the columns.
    fn options(&self) -> SpecimenOptions {
        SpecimenOptions {
            force_unit: self.force_unit.clone(),
            displacement_unit: self.displacement_unit.clone(),
            time_unit: self.time_unit.clone(),
            temperature_unit: self.temperature_unit.clone(),
            response: self.response,
            turn_share: Some(self.turn_share),
            file: TableFileOptions {
                encoding: self.encoding,
                sheet: self.sheet.clone(),
                decimal: self.decimal,
                ..TableFileOptions::default()
            },
            ..SpecimenOptions::default()
        }
    }

    /// What the reader needs, with columns as `ROLE=COLUMN`; without any those that their names tell, which are noted.
    ///
    /// # Arguments
    /// - `files`: names and bytes of the tables.
    pub(super) fn with_columns(
        &self,
        map: &[String],
        files: &[(&str, &[u8])],
    ) -> Result<(SpecimenOptions, Option<String>), Failure> {
        let mut options = self.options();
        let mut pairs = column_pairs(map)?;
        let is_guessed = pairs.is_empty();
        if is_guessed {
            pairs = self.guessed(files)?;
        }
        let note = is_guessed.then(|| {
            let columns = pairs
                .iter()
                .map(|(role, column)| format!("{role}={column}"));
            let columns: Vec<String> = columns.collect();
            format!("columns by their names: --map {}", columns.join(","))
        });
        let mut stated = BTreeSet::new();
        for (role, column) in pairs {
            let several = ["displacement", "run", "repeat", "configuration", "pose"];
            let may_be_several = several.contains(&&*role);
            if !may_be_several && !stated.insert(role.clone()) {
                return Err(wrong_map(&role, "a part has one such column").into());
            }
            match role.as_str() {
                "force" => options.force_column = Some(column),
                "displacement" if options.displacement_column.is_empty() => {
                    options.displacement_column = column;
                }
                "displacement" => options.repeat_columns.push(column),
                "date" => options.date_column = Some(column),
                "time" => options.time_column = Some(column),
                "run" | "repeat" => options.run_column.push(column),
                "configuration" | "pose" => options.configuration_column.push(column),
                "temperature" => options.temperature_column = Some(column),
                "hold" => options.hold_column = Some(column),
                "order" => options.order_column = Some(column),
                "branch" => options.branch_column = Some(column),
                _ => return Err(wrong_map(&role, "there is no such role of a column").into()),
            }
        }
        if options.displacement_column.is_empty() {
            return Err(wrong_map("", "the column of the displacement is missing").into());
        }
        Ok((options, note))
    }

    /// The columns of force and displacement, and others, as an import takes them.
    fn guessed(&self, files: &[(&str, &[u8])]) -> Result<Vec<(String, String)>, Failure> {
        let mapping = ImportMapping {
            encoding: self.encoding,
            sheet: self.sheet.clone(),
            is_of_a_part: true,
            ..ImportMapping::default()
        };
        let columns = ImportDraft::read(files, None, &mapping)?.columns();
        let names: Vec<String> = columns.iter().map(|one| one.name.clone()).collect();
        let known = columns.into_iter().filter_map(|one| {
            let role = one.role?;
            let known = [
                "force",
                "displacement",
                "date",
                "repeat",
                "configuration",
                "time",
                "temperature",
                "branch",
            ];
            known.contains(&role.as_str()).then_some((role, one.name))
        });
        let known: Vec<(String, String)> = known.collect();
        let has = |role: &str| known.iter().any(|(own, _)| own == role);
        if has("force") && has("displacement") {
            return Ok(known);
        }
        let names = listed_names(names.iter().map(String::as_str));
        let problem = format!("the names {names} do not tell which column is what");
        Err(wrong_map("", &problem).into())
    }
}

/// A `--map` that cannot be.
fn wrong_map(role: &str, problem: &str) -> ArgumentError {
    ArgumentError::new(
        format!("--map {role}").trim_end(),
        problem,
        "--map force=load,displacement=travel; other roles are time, date, run, configuration, temperature, hold, order and branch; further columns of the displacement are repeats",
    )
}

impl SpecimenArgs {
    /// What the reader needs; `None` without `--specimen`.
    pub(super) fn options(&self) -> Result<Option<SpecimenOptions>, ArgumentError> {
        let options = self.table.options();
        if !self.specimen {
            let unused = SpecimenOptions {
                turn_share: Some(TURN_SHARE),
                ..SpecimenOptions::default()
            };
            return if options == unused {
                Ok(None)
            } else {
                Err(ArgumentError::new(
                    "units and form of a table without a robot",
                    "the data are of a robot",
                    "leave them out, or use stiffbench part diagnose",
                ))
            };
        }
        Ok(Some(SpecimenOptions {
            force_column: self.force_column.clone(),
            displacement_column: self.displacement_column.clone().unwrap_or_default(),
            time_column: self.time_column.clone(),
            run_column: self.run_column.clone(),
            configuration_column: self.configuration_column.clone(),
            temperature_column: self.temperature_column.clone(),
            hold_column: self.hold_column.clone(),
            order_column: self.order_column.clone(),
            branch_column: self.branch_column.clone(),
            ..options
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, Parser};

    #[derive(Debug, Parser)]
    struct SpecimenLine {
        #[command(flatten)]
        specimen: SpecimenArgs,
    }

    fn parse(words: &str) -> Result<SpecimenArgs, clap::Error> {
        let words = std::iter::once("test").chain(words.split_whitespace());
        Ok(SpecimenLine::try_parse_from(words)?.specimen)
    }

    #[test]
    fn the_arguments_hold_together() {
        SpecimenLine::command().debug_assert();
    }

    #[test]
    fn flags_become_options() {
        let args = parse(
            "--specimen --force-column load --force-unit kN --displacement-column travel --displacement-unit mm --run-column day \
             --run-column sweep --response force",
        )
        .unwrap();
        let options = args.options().unwrap().unwrap();
        assert_eq!(options.force_column.as_deref(), Some("load"));
        assert_eq!(options.force_unit.as_deref(), Some("kN"));
        assert_eq!(options.displacement_column, "travel");
        assert_eq!(options.run_column, ["day", "sweep"]);
        assert_eq!(options.response, Some(ResponseVariable::Force));
        assert_eq!(options.turn_share, Some(TURN_SHARE));
        assert_eq!(options.order_column, None);
    }

    #[test]
    fn without_specimen_there_are_no_options() {
        assert_eq!(parse("").unwrap().options().unwrap(), None);
        // Flags of a table without a robot mean nothing for one with a robot.
        assert!(parse("--force-column load").is_err());
        assert!(parse("--specimen").is_err());
        assert!(parse("--force-unit kN").unwrap().options().is_err());
    }
}
