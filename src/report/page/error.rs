//! What can be wrong with a report.

/// Errors of reports.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReportError {
    /// A `report.toml` that cannot be used.
    #[error("{place}: {problem}")]
    #[diagnostic(
        code(stiffbench::report::details),
        help(
            "stiffbench report --details-template prints a file with every key; docs/report.md explains them"
        )
    )]
    Details {
        /// File, and line and column where they are known.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// Details that state something else than a session.
    #[error("`{key}` states {stated}, but the readings were taken on {known}")]
    #[diagnostic(
        code(stiffbench::report::contradiction),
        help(
            "correct the day; leave `performed` out where the session has times: the report takes its days from them"
        )
    )]
    Contradiction {
        /// The key of the details.
        key: &'static str,
        /// What it states.
        stated: String,
        /// The days of the readings.
        known: String,
    },
    /// A template that cannot be rendered.
    #[error("{place}: {problem}")]
    #[diagnostic(
        code(stiffbench::report::template),
        help(
            "a template gets the data that stiffbench report --json prints; stiffbench report --print-template prints the usual one"
        )
    )]
    Template {
        /// Template, and the line where it is known.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// A template whose pages could not be verified.
    #[error("{template} does not print {part}, and its pages could not be verified")]
    #[diagnostic(
        code(stiffbench::report::template_lacks),
        help(
            "take over the element <script type=\"application/json\" id=\"stiffbench-data\"> and the line with data_sha256 from stiffbench report --print-template"
        )
    )]
    TemplateLacks {
        /// The template.
        template: String,
        /// What is missing.
        part: &'static str,
    },
    /// A file that is no report.
    #[error("{page} is not a report of this program: it holds no data")]
    #[diagnostic(
        code(stiffbench::report::not_a_report),
        help(
            "name an HTML file that stiffbench report wrote; Markdown and Typst cannot be verified"
        )
    )]
    NotAReport {
        /// The file.
        page: String,
    },
    /// A page of another template.
    #[error("{page} was rendered with another template (SHA-256 {sha256}), by version {version}")]
    #[diagnostic(
        code(stiffbench::report::other_template),
        help("name the template with --template FILE, or verify with that version")
    )]
    OtherTemplate {
        /// The file.
        page: String,
        /// The template's hash, as far as the page states it.
        sha256: String,
        /// Version of the program.
        version: String,
    },
}
