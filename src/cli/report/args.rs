//! The arguments of `report`.

use std::path::PathBuf;

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand};

use crate::analysis::ArgumentError;
use crate::cli::args::ModelArgs;
use crate::cli::data_args::DataArgs;
use crate::report::page::PageFormat;

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "docs/report.md explains the report and every key of report.toml.\n\nExamples:\n  stiffbench report my-session\n  stiffbench report my-session --train P1,P3 --details report.toml --details laboratory.toml\n  stiffbench report readings.csv --robot my-robot.toml --out report.html\n  stiffbench report my-session --format markdown\n  stiffbench report my-session --out report.typ    then: typst compile report.typ\n  stiffbench report verify my-session/report.html my-session"
)]
pub(in crate::cli) struct ReportArgs {
    /// What is done with a report that exists.
    #[command(subcommand)]
    pub(super) command: Option<ReportCommand>,
    /// What a report is made of.
    #[command(flatten)]
    pub(super) make: MakeArgs,
}

/// What can be done with a report.
#[derive(Debug, Subcommand)]
pub(super) enum ReportCommand {
    /// Check every number in a report against the data in the page and against the session
    Verify(VerifyArgs),
}

/// Arguments that make a report.
#[derive(Debug, Args)]
pub(super) struct MakeArgs {
    /// Session folder or readings file; further sessions of the same robot are fitted and diagnosed together
    #[arg(required_unless_present_any = ["details_template", "print_template"], value_name = "DATA")]
    pub(super) data: Vec<PathBuf>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Poses to fit, comma-separated; the others are held out [default: all, validated by leaving each out in turn]
    #[arg(long, value_delimiter = ',')]
    pub(super) train: Option<Vec<String>>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Leave out the diagnosis
    #[arg(long)]
    pub(super) no_diagnosis: bool,
    /// File to write, never an existing one; - for standard output [default: report.html in the session folder, or beside the readings file]
    #[arg(long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
    /// Format of the file [default: markdown for a file that ends in .md, typst for .typ, else html]
    #[arg(long, value_enum)]
    pub(super) format: Option<PageFormat>,
    /// Also write the figures into this folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
    /// What reports share.
    #[command(flatten)]
    pub(super) page: PageArgs,
    /// How the data are read.
    #[command(flatten)]
    pub(super) reading: DataArgs,
    /// Print a report.toml to fill in
    #[arg(long)]
    pub(super) details_template: bool,
    /// Print the standard template of the format
    #[arg(long)]
    pub(super) print_template: bool,
}

/// Options of every report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Args)]
pub(in crate::cli) struct PageArgs {
    /// TOML file with statements on laboratory, customer, item and requirements; repeatable, later files take precedence
    #[arg(long, value_name = "FILE")]
    pub(super) details: Vec<PathBuf>,
    /// Day of issue, YYYY-MM-DD [default: SOURCE_DATE_EPOCH, else the last day of the session]
    #[arg(long, value_name = "DATE")]
    pub(super) issued: Option<jiff::civil::Date>,
    /// Number of the report that this report replaces
    #[arg(long, value_name = "NUMBER", requires = "reason", value_parser = NonEmptyStringValueParser::new())]
    pub(super) amends: Option<String>,
    /// Why the report is replaced
    #[arg(long, value_name = "TEXT", requires = "amends", value_parser = NonEmptyStringValueParser::new())]
    pub(super) reason: Option<String>,
    /// Your own template instead of the standard one
    #[arg(long, value_name = "FILE")]
    pub(super) template: Option<PathBuf>,
}

impl MakeArgs {
    /// The form of the file, from its name where no option states it.
    ///
    /// # Errors
    /// For a name that promises a form that is not written.
    pub(super) fn format(&self) -> Result<PageFormat, ArgumentError> {
        if let Some(format) = self.format {
            return Ok(format);
        }
        let ending = self.out.as_ref().and_then(|out| out.extension());
        let ending = ending.map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("md" | "markdown") => Ok(PageFormat::Markdown),
            Some("typ") => Ok(PageFormat::Typst),
            Some("pdf" | "docx" | "odt" | "tex") => Err(ArgumentError::new(
                "--out",
                "a report is an HTML page, Markdown or Typst",
                "for PDF print an .html file in a browser, or write a .typ file and compile it with Typst",
            )),
            _ => Ok(PageFormat::Html),
        }
    }
}

/// Arguments of `report verify`.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 verified, or consistent where no data are named; 30 something differs; 11 the file is not a report, or was not compared as a whole because another version, commit or template rendered it.\n\nExamples:\n  stiffbench report verify report.html\n  stiffbench report verify report.html my-session\n  stiffbench report verify report.html my-session --robot my-robot.toml"
)]
pub(super) struct VerifyArgs {
    /// HTML file that stiffbench report wrote
    pub(super) page: PathBuf,
    /// Data of the report, in the same order
    #[arg(value_name = "DATA")]
    pub(super) sessions: Vec<PathBuf>,
    /// Robot and model, where they lie elsewhere than when the report was made.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Template of the report, if it was not the standard one
    #[arg(long, value_name = "FILE")]
    pub(super) template: Option<PathBuf>,
}
