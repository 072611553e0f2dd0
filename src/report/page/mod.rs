//! A report: one document of sessions and of what follows from them, with its data. A template is the frame of the document in HTML, Markdown
//! or Typst.
//!
//! What a reader sees is a function of the embedded data and the template, of nothing else. So a page can be verified from itself:
//! its data are rendered again and the bytes compared.

mod body;
mod build;
mod conformity;
mod details;
mod error;
mod figures;
mod first_page;
mod headline;
mod map;
mod model;
mod packed;
mod procedure;
mod results;
mod session;
mod source;
mod template;
mod verify;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::Document;

use crate::analysis::sha256;

pub use build::{comparison_page, session_page};
pub use conformity::{
    ConformityDecision, ConformityStatement, DecisionRule, JudgedRequirement, Requirement, decide,
};
pub use details::{
    CustomerDetails, DETAILS_TEMPLATE, ItemDetails, LaboratoryDetails, MethodDetails, PageDetails,
    PageItem,
};
pub use error::ReportError;
pub use model::{PageComparison, PageDiagnosis, PageFit, PageModel};
pub use results::PageCell;
pub use session::{PageGauge, PageSession};
pub use source::PageSource;
pub use template::{PageFormat, PageTemplate, RenderedPage};
pub use verify::{PageCheck, PageDifference, ReadPage, read_page};

/// What a report was made with: every option that changes it. A report is worked out again from its sessions with the same.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PageSettings {
    /// `--robot`.
    pub robot: Option<String>,
    /// Robot of the configuration, and where it stands.
    pub default_robot: Option<Vec<String>>,
    /// `--mechanism`.
    pub mechanism: Option<String>,
    /// `--factors`.
    pub factors: Option<String>,
    /// `--model`.
    pub model: Option<String>,
    /// `--effect`.
    pub effects: Vec<String>,
    /// `--train`.
    pub train: Option<Vec<String>>,
    /// `--seed`.
    pub seed: u64,
    /// `--no-diagnosis`.
    pub no_diagnosis: bool,
    /// `--trust-csv`.
    pub trust_csv: bool,
    /// Options on the calibration of the gauges: names and values in turn.
    pub calibration: Vec<String>,
    /// The day of issue, if one was given.
    pub issued: Option<String>,
    /// `--amends` with `--reason`.
    pub amends: Option<PageAmendment>,
    /// What `--details` state.
    pub details: PageDetails,
}

/// What stands of a figure around its drawing and its title, in the page and in the body, bytes.
const FIGURE_TAGS: usize = 250;

/// The report that one replaces.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PageAmendment {
    /// Its number.
    pub number: String,
    /// Why.
    pub reason: String,
}

/// The program that made a report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct PageProgram {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The commit it was built from, with `+changes` if the sources differed from it; empty if not known. The number of the report does
    /// not follow from it.
    pub commit: String,
    /// SHA-256 of the template.
    pub template_sha256: String,
}

/// A text that is printed as it is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PrintedText {
    /// The text.
    pub text: String,
}

/// A figure of a report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageFigure {
    /// Name, also of its file.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// Whether it is higher than wide, so that it needs most of a printed page.
    pub tall: bool,
    /// Its SVG; in JSON deflated (zlib) and in base64. A template gets the SVG itself.
    #[serde(serialize_with = "packed::pack")]
    pub svg: String,
}

impl PageFigure {
    /// What it adds to a page: its drawing, and itself among the data.
    fn bytes(&self) -> usize {
        let data = serde_json::to_string(self).unwrap_or_default();
        self.svg.len() + data.len() + self.title.len() + FIGURE_TAGS
    }
}

/// The figures of a report by the section that they stand in.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct PageFigures {
    /// Load against displacement.
    pub readings: Vec<PageFigure>,
    /// Of the fit.
    pub fit: Vec<PageFigure>,
    /// Of the stiffness over the workspace.
    pub map: Vec<PageFigure>,
    /// Of the diagnosis.
    pub diagnosis: Vec<PageFigure>,
}

impl PageFigures {
    /// All, in the order of the report.
    pub fn all(&self) -> impl Iterator<Item = &PageFigure> {
        let all = self.readings.iter().chain(&self.fit);
        all.chain(&self.map).chain(&self.diagnosis)
    }

    /// Leaves out what exceeds so many bytes of a page, the least important first; what was left out.
    fn shed(&mut self, bytes: usize) -> Vec<String> {
        let mut left = bytes;
        let mut titles = Vec::new();
        let by_importance = [
            &mut self.readings,
            &mut self.fit,
            &mut self.diagnosis,
            &mut self.map,
        ];
        for section in by_importance {
            section.retain(|figure| {
                let bytes = figure.bytes();
                let fits = bytes <= left;
                if fits {
                    left -= bytes;
                } else {
                    titles.push(figure.title.clone());
                }
                fits
            });
        }
        titles
    }
}

/// A report.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReportPage {
    /// The form of these data.
    pub schema: &'static str,
    /// Title.
    pub title: String,
    /// Number of the report, from its content.
    pub number: String,
    /// Day of issue.
    pub issued: Option<String>,
    /// The report that this one replaces.
    pub replaces: Option<PageAmendment>,
    /// Words across the page: what a reader must not overlook.
    pub marks: Vec<&'static str>,
    /// What each of them means, in a sentence.
    pub mark_sentences: Vec<String>,
    /// Who signs: the part that each had, and the name as far as it is stated.
    pub signatures: Vec<(String, String)>,
    /// Items of ISO/IEC 17025:2017, 7.8.2.1.
    pub items: Vec<PageItem>,
    /// The statement of conformity, if a rule and requirements are stated.
    pub conformity: Option<ConformityStatement>,
    /// The sessions.
    pub sessions: Vec<PageSession>,
    /// The difference of two sessions.
    pub comparison: Option<PageComparison>,
    /// Robot, mechanism and factors.
    pub model: Option<PageModel>,
    /// The fit.
    pub fit: Option<PageFit>,
    /// The stiffness of the fitted model over the workspace.
    #[serde(skip)]
    pub map: Document,
    /// The diagnosis.
    pub diagnosis: Option<PageDiagnosis>,
    /// Parts that are missing, with the reason.
    pub left_out: Vec<String>,
    /// The figures.
    pub figures: PageFigures,
    /// Every option.
    pub settings: PageSettings,
    /// The program.
    pub program: PageProgram,
    /// The answer: stiffness, verdict, what to do next.
    pub answer: Document,
    /// The other text of the report.
    pub body: Document,
}

impl ReportPage {
    /// Items that nothing states, in words.
    #[must_use]
    pub fn missing(&self) -> Vec<String> {
        let open = self.items.iter().filter(|item| item.value.is_none());
        open.map(|item| format!("{}) {} ({})", item.clause, item.name, item.key))
            .collect()
    }

    /// The same with its number, which follows from everything else but the commit of the program.
    #[must_use]
    pub(super) fn numbered(mut self) -> Self {
        self.leave_out_figures();
        let last = self.sessions.iter().filter_map(PageSession::last_day).max();
        let day = last.map_or_else(|| "undated".to_owned(), |day| day.replace('-', ""));
        let commit = std::mem::take(&mut self.program.commit);
        let json = serde_json::to_string(&self).unwrap_or_default();
        self.program.commit = commit;
        self.number = page_number(&day, &json);
        self
    }

    /// Leaves out the figures that would make the page larger than a mail takes, and states which.
    fn leave_out_figures(&mut self) {
        // 25 MB is common, and base64 takes a third more; a tenth leaves room for what goes with it.
        const LARGEST: usize = 2_500_000;
        // What states that a figure is missing, in the text and among the data.
        const SENTENCE: usize = 400;
        let figures = std::mem::take(&mut self.figures);
        let count = figures.all().count();
        self.body = self.body();
        let without = PageFormat::Html.template().render(self);
        let others = without.map_or(LARGEST, |page| page.text.len()) + count * SENTENCE;
        self.figures = figures;
        let titles = self.figures.shed(LARGEST.saturating_sub(others));
        self.left_out.extend(titles.into_iter().map(|title| {
            format!(
                "Figure: {title}. The page would exceed 2.5 MB; stiffbench fit, map and diagnose draw it."
            )
        }));
        self.body = self.body();
    }
}

/// The number of a report from the day of its last reading and its data without number.
fn page_number(day: &str, json: &str) -> String {
    let digits: String = sha256(json).chars().take(10).collect();
    format!("SB-{day}-{digits}")
}
