//! The text of a report but for its answer: what stands beside it, results, model, conditions, statements and provenance.

use stiffbench_document::{Document, NoteKind, Table, TableCell};

use super::results::cells_document;
use super::session::PageSession;
use super::{PageFigure, PageSettings, ReportPage};

impl ReportPage {
    /// The sections in their order.
    pub(super) fn body(&self) -> Document {
        let (fit, diagnosis) = (self.fit.as_ref(), self.diagnosis.as_ref());
        let figures = &self.figures;
        let of = |text: Option<&Document>| text.cloned().unwrap_or_default();
        let mut body = self.beside_answer();
        body.section("Results", self.results());
        body.section(
            "Comparison",
            of(self.comparison.as_ref().map(|one| &one.text)),
        );
        let readings = with_figures(Document::new(), &figures.readings);
        body.section("Load and displacement", readings);
        let mut of_fit = Document::new();
        of_fit.paragraphs(self.about_fit());
        of_fit.append(of(fit.map(|one| &one.text)));
        body.section("Fit and validation", with_figures(of_fit, &figures.fit));
        let map = with_figures(self.map.clone(), &figures.map);
        body.section("Stiffness over the workspace", map);
        let found = of(diagnosis.map(|one| &one.text));
        let found = with_figures(found, &figures.diagnosis);
        body.section("What the model leaves out", found);
        let left_out = list(&self.left_out);
        body.section("Parts that this report does not have", left_out);
        let budgets = self.each_session(|session| session.budget.clone());
        body.section("Uncertainty budget", budgets);
        let conditions = self.each_session(PageSession::conditions_document);
        body.section("Conditions and instruments", conditions);
        body.section("Deviations and remarks", self.remarks());
        body.section(
            "Statements after ISO/IEC 17025:2017, 7.8.2.1",
            self.statements(),
        );
        body.section("Provenance", self.provenance());
        body
    }

    /// A part of each session, under its name where there are several.
    fn each_session(&self, part: impl Fn(&PageSession) -> Document) -> Document {
        let mut all = Document::new();
        for session in &self.sessions {
            match self.sessions.len() {
                1 => all.append(part(session)),
                _ => all.section(&session.name, part(session)),
            }
        }
        all
    }

    fn results(&self) -> Document {
        let several = self.sessions.len() > 1;
        let mut results = self.each_session(|session| {
            let mut part = Document::new();
            if several {
                let days = session.performed.iter().map(|days| format!(", {days}"));
                let about = format!("{}{}.", session.about, days.collect::<String>());
                part.note(NoteKind::Remark, about);
            }
            if session.results.is_empty() {
                part.note(NoteKind::Remark, "The stiffness is in the fit.");
            } else {
                part.append(cells_document(&session.results));
            }
            part.append(session.further.clone());
            part
        });
        if let Some(conformity) = &self.conformity {
            results.section("Conformity", conformity.document());
        }
        results
    }

    fn remarks(&self) -> Document {
        let mut remarks = self.each_session(|session| {
            if session.deviations.is_empty() {
                return Document::of("None recorded.");
            }
            list(&session.deviations)
        });
        if let Some(words) = &self.settings.details.remarks {
            remarks.paragraph(words);
        }
        remarks
    }

    fn statements(&self) -> Document {
        let table = Table::of(&self.items)
            .words("clause", |item| item.clause)
            .words("item", |item| item.name)
            .words("stated", |item| match &item.value {
                Some(value) => TableCell::from(value),
                None => TableCell::marked("missing"),
            });
        let mut statements = Document::new();
        statements.table(table);
        statements.paragraph("The results relate only to the items tested. This report shall not be reproduced except in full without approval of the laboratory.");
        statements
    }

    fn provenance(&self) -> Document {
        let mut provenance = Document::new();
        if let Some(model) = &self.model {
            let hashed = |name: &str, hash: &str| format!("{name}, SHA-256 {hash}");
            provenance.pair("robot", hashed(&model.robot, &model.robot_sha256));
            provenance.pair("mechanism", &model.mechanism);
            let factors = hashed(&model.factors, &model.factors_sha256);
            provenance.pair("factors at the start", factors);
        }
        provenance.pair("options", self.settings.words());
        for session in &self.sessions {
            let mut part = Document::new();
            if let Some(origin) = &session.origin {
                part.note(NoteKind::Warning, format!("Not measured: {origin}"));
            }
            part.paragraph(if session.protected {
                "The readings agree with the journal of the session."
            } else {
                "No journal protects the readings, or they differ from it."
            });
            for (name, hash) in &session.files {
                part.pair(format!("SHA-256 of {name}"), hash);
            }
            provenance.section(&session.name, part);
        }
        provenance
    }
}

fn list(lines: &[String]) -> Document {
    let mut list = Document::new();
    list.items(lines);
    list
}

fn with_figures(mut text: Document, figures: &[PageFigure]) -> Document {
    for PageFigure {
        name, title, tall, ..
    } in figures
    {
        text.figure(name, title, *tall);
    }
    text
}

impl PageSettings {
    /// The options as they are typed.
    fn words(&self) -> String {
        let named = [
            ("--robot", &self.robot),
            ("--mechanism", &self.mechanism),
            ("--factors", &self.factors),
            ("--model", &self.model),
        ];
        let named = named.into_iter();
        let mut words: Vec<String> = named
            .filter_map(|(name, value)| Some(format!("{name} {}", value.as_ref()?)))
            .collect();
        words.extend(
            self.effects
                .iter()
                .map(|effect| format!("--effect {effect}")),
        );
        words.extend(
            self.train
                .iter()
                .map(|poses| format!("--train {}", poses.join(","))),
        );
        words.push(format!("--seed {}", self.seed));
        for (is_set, name) in [
            (self.no_diagnosis, "--no-diagnosis"),
            (self.trust_csv, "--trust-csv"),
        ] {
            words.extend(is_set.then(|| name.to_owned()));
        }
        words.extend(self.calibration.iter().cloned());
        words.join(" ")
    }
}
