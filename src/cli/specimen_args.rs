//! How a table without a robot is read: the options behind `--specimen`.

use clap::Args;

use crate::readings::DecimalSign;
use crate::specimen::{ResponseVariable, SpecimenOptions, TURN_SHARE};
use crate::table_files::TableFileOptions;

use super::option_values::{OptionValue, decimal_signs, one_of};

/// Options of a table of force against displacement that has no robot.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Table without a robot")]
pub(super) struct SpecimenArgs {
    /// DATA is a table of force against displacement, or of any two quantities, without a robot
    #[arg(long, requires = "displacement_column")]
    pub(super) specimen: bool,
    /// Column of the force [default: none, the load is the same throughout]
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) force_column: Option<String>,
    /// Column of the displacement
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) displacement_column: Option<String>,
    /// Column of the time
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) time_column: Option<String>,
    /// Column that identifies runs, each with one zero; several columns together identify a run
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) run_column: Vec<String>,
    /// Column that identifies specimens or configurations, each with its own line; several columns together identify one
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) configuration_column: Vec<String>,
    /// Column of the temperature
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) temperature_column: Option<String>,
    /// Column of the time under the load
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) hold_column: Option<String>,
    /// Column with the order of measurement
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) order_column: Option<String>,
    /// Column with loading and unloading [default: derived from the path of the load]
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) branch_column: Option<String>,
    /// Unit of the force, torque or stress: N, kN, kgf, lbf, N*m, lbf*in, MPa, psi, ..., or 1 to keep the numbers as they are [default: that of the file]
    #[arg(long, value_name = "UNIT", requires = "force_column")]
    pub(super) force_unit: Option<String>,
    /// Unit of the displacement, angle or strain: mm, um, in, mil, rad, deg, %, microstrain, ..., or 1 to keep the numbers as they are [default: that of the file]
    #[arg(long, value_name = "UNIT", requires = "specimen")]
    pub(super) displacement_unit: Option<String>,
    /// Unit of time and hold: s, ms, min, h, d [default: that of the file; dates and times of day need none]
    #[arg(long, value_name = "UNIT", requires = "specimen")]
    pub(super) time_unit: Option<String>,
    /// Unit of the temperature: degC, K, degF [default: that of the file, else degC]
    #[arg(long, value_name = "UNIT", requires = "temperature_column")]
    pub(super) temperature_unit: Option<String>,
    /// The measured quantity: force if the displacement or strain was set
    #[arg(long, value_parser = one_of(RESPONSES), default_value = "displacement", requires = "specimen")]
    pub(super) response: ResponseVariable,
    /// Share of a run's range by which the path must return before it counts as unloading
    #[arg(long, value_name = "SHARE", default_value_t = TURN_SHARE, requires = "specimen")]
    pub(super) turn_share: f64,
    /// Sheet of a spreadsheet [default: the only one with rows of numbers]
    #[arg(long, value_name = "NAME", requires = "specimen")]
    pub(super) sheet: Option<String>,
    /// Decimal sign of the numbers [default: detected from all of them]
    #[arg(long, value_parser = one_of(decimal_signs(DecimalSign::Point, DecimalSign::Comma)), requires = "specimen")]
    pub(super) decimal: Option<DecimalSign>,
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

impl SpecimenArgs {
    /// What the reader needs; `None` without `--specimen`.
    pub(super) fn options(&self) -> Option<SpecimenOptions> {
        if !self.specimen {
            return None;
        }
        Some(SpecimenOptions {
            force_column: self.force_column.clone(),
            displacement_column: self.displacement_column.clone()?,
            time_column: self.time_column.clone(),
            run_column: self.run_column.clone(),
            configuration_column: self.configuration_column.clone(),
            temperature_column: self.temperature_column.clone(),
            hold_column: self.hold_column.clone(),
            order_column: self.order_column.clone(),
            branch_column: self.branch_column.clone(),
            force_unit: self.force_unit.clone(),
            displacement_unit: self.displacement_unit.clone(),
            time_unit: self.time_unit.clone(),
            temperature_unit: self.temperature_unit.clone(),
            response: self.response,
            turn_share: Some(self.turn_share),
            file: TableFileOptions {
                sheet: self.sheet.clone(),
                decimal: self.decimal,
                ..TableFileOptions::default()
            },
            is_response_optional: false,
        })
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
        let options = args.options().unwrap();
        assert_eq!(options.force_column.as_deref(), Some("load"));
        assert_eq!(options.force_unit.as_deref(), Some("kN"));
        assert_eq!(options.displacement_column, "travel");
        assert_eq!(options.run_column, ["day", "sweep"]);
        assert_eq!(options.response, ResponseVariable::Force);
        assert_eq!(options.turn_share, Some(TURN_SHARE));
        assert_eq!(options.order_column, None);
    }

    #[test]
    fn without_specimen_there_are_no_options() {
        assert_eq!(parse("").unwrap().options(), None);
        // Flags of a table without a robot mean nothing for one with a robot.
        assert!(parse("--force-column load").is_err());
        assert!(parse("--specimen").is_err());
        assert!(parse("--specimen --displacement-column d --force-unit N").is_err());
    }
}
