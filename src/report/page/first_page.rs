//! What stands on the first page beside the answer: item, days, procedure, conditions, calibration, decision rule; what the symbols mean;
//! who signs; and that details and sessions agree.

use indexmap::IndexSet;
use jiff::civil::Date;
use stiffbench_document::{Document, NoteKind};

use crate::count::counted;
use crate::fit::StatusWord;
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::report::significant;
use crate::stiffness::Method;

use super::error::ReportError;
use super::session::{NamedValues, PageSession};
use super::{PageFit, ReportPage};

/// Two values of one quantity that differ by less, in percent, are the same as printed.
const SAME_PERCENT: f64 = 0.1;

impl ReportPage {
    /// What sessions state: once where all state the same, else each with its name.
    pub(super) fn of_sessions(
        &self,
        value: impl Fn(&PageSession) -> Option<String>,
    ) -> Option<String> {
        let stated = self.sessions.iter();
        let stated = stated.filter_map(|session| Some((&session.name, value(session)?)));
        let stated: Vec<_> = stated.collect();
        let different: IndexSet<&String> = stated.iter().map(|(_, value)| value).collect();
        match different.first() {
            None => None,
            Some(only) if different.len() == 1 && stated.len() == self.sessions.len() => {
                Some((*only).clone())
            }
            Some(_) => {
                let named = stated
                    .iter()
                    .map(|(name, value)| format!("{name}: {value}"));
                Some(named.collect::<Vec<_>>().join("; "))
            }
        }
    }

    /// What stands beside the answer.
    pub(super) fn beside_answer(&self) -> Document {
        let details = &self.settings.details;
        let item = [
            details.item.description.clone(),
            details.item.identification.clone(),
            self.of_sessions(|session| session.condition("specimen")),
        ];
        let item: Vec<String> = item.into_iter().flatten().collect();
        let mut measured = self
            .stated("date of performance")
            .unwrap_or_else(|| "day not recorded".to_owned());
        for (before, what) in [
            ("by", self.operators()),
            ("at", self.stated("location of the activity")),
        ] {
            if let Some(what) = what {
                measured = format!("{measured}, {before} {what}");
            }
        }
        let entries = [
            ("item", (!item.is_empty()).then(|| item.join(", "))),
            ("customer", details.customer.name.clone()),
            ("measured", Some(measured)),
            (
                "procedure",
                self.of_sessions(|session| session.procedure.clone()),
            ),
            ("readings", Some(self.readings())),
            (
                "conditions",
                Some(
                    self.of_sessions(surroundings)
                        .unwrap_or_else(|| "temperature not recorded".to_owned()),
                ),
            ),
            (
                "calibration",
                self.of_sessions(|session| Some(session.calibration())),
            ),
            ("decision rule", Some(self.rule())),
        ];
        let mut beside = Document::new();
        for (name, value) in entries {
            if let Some(value) = value {
                beside.pair(name, value);
            }
        }
        beside.note(NoteKind::Remark, self.definitions().join(" "));
        beside
    }

    /// How many readings each session has.
    fn readings(&self) -> String {
        let sessions = self.sessions.iter();
        let each = sessions.map(|session| match self.sessions.len() {
            1 => session.about.clone(),
            _ => format!("{}: {}", session.name, session.about),
        });
        each.collect::<Vec<_>>().join("; ")
    }

    /// What an item of the standard states.
    fn stated(&self, name: &str) -> Option<String> {
        let mut items = self.items.iter();
        items.find(|item| item.name == name)?.value.clone()
    }

    fn operators(&self) -> Option<String> {
        self.of_sessions(|session| session.condition("operator"))
    }

    /// The decision rule, or why there is no statement of conformity.
    fn rule(&self) -> String {
        if let Some(conformity) = &self.conformity {
            return conformity.rule.to_owned();
        }
        let reason = self
            .without_decision()
            .unwrap_or_else(|| "no requirement is stated".to_owned());
        format!("This report makes no statement of conformity: {reason}.")
    }

    /// Why there is no statement of conformity though requirements are stated.
    pub(crate) fn without_decision(&self) -> Option<String> {
        let details = &self.settings.details;
        if details.requirements.is_empty() || self.conformity.is_some() {
            return None;
        }
        let reason = match details.decision_rule {
            None => "requirements are stated, but no decision rule (decision_rule in report.toml)",
            Some(_) => "it is made of one session, and this report has several",
        };
        Some(reason.to_owned())
    }

    /// What the symbols mean.
    fn definitions(&self) -> Vec<String> {
        let mut all = Vec::new();
        let with_results = || self.sessions.iter().filter(|one| !one.results.is_empty());
        if with_results().next().is_some() {
            let how = if with_results().all(|one| one.vectors.is_some()) {
                "from the displacements along the base axes"
            } else {
                "by regression over the loading branch"
            };
            all.push(format!("K is the stiffness of the end: force over displacement along the direction of the load, {how}. ± U is the expanded uncertainty for 95 %, with the coverage factor k from Student's t and the effective degrees of freedom (dof). The table rounds dof down to whole numbers; k is of the exact ones."));
        }
        let fitted = self.fit.iter().flat_map(|fit| &fit.numbers.parameters);
        if fitted.into_iter().any(|one| one.unit != "1") {
            all.push("The stiffness of a spring is that of a joint or support of the model, fitted to the readings; its interval is for 95 %.".to_owned());
        } else if self.sessions.iter().any(|one| one.load_cases.is_some()) {
            all.push("The stiffness is that of the beams of the model, fitted to loads and displacements as vectors; intervals are for 95 %.".to_owned());
        }
        all.push("The results relate only to the items tested.".to_owned());
        all
    }

    /// Who signs.
    pub(super) fn signatures(&self) -> NamedValues {
        let authorised = self.settings.details.authorised_by.clone();
        [
            ("measured by", self.operators()),
            ("authorised by", authorised),
        ]
        .map(|(part, name)| (part.to_owned(), name.unwrap_or_default()))
        .to_vec()
    }

    /// Where the stiffness and the factors of the fit are not those of the results and of the diagnosis, and why.
    pub(super) fn about_fit(&self) -> Vec<String> {
        let Some(fit) = &self.fit else {
            return Vec::new();
        };
        let of_results = self.sessions.iter().filter_map(|session| {
            let several = self.sessions.len() > 1;
            let name = several.then_some(session.name.as_str());
            farthest(session, name, fit)
        });
        let of_results = of_results.max_by(|a, b| a.0.total_cmp(&b.0));
        let of_results = of_results.filter(|(percent, _)| *percent >= SAME_PERCENT);
        let of_results = of_results.map(|(percent, cell)| {
            format!(
                "K of the results is the slope of each pose and direction by itself. The fit estimates the measured stiffness from all readings with the scatter that they share (generalised least squares); the two differ by up to {} % ({cell}).",
                significant(percent, 2)
            )
        });
        of_results.into_iter().chain(self.two_fits(fit)).collect()
    }

    /// Why the diagnosis has a fit of its own, where it ends elsewhere.
    fn two_fits(&self, fit: &PageFit) -> Option<String> {
        let factors = self.diagnosis.as_ref()?.numbers.factors.iter();
        let differences = factors.filter_map(|factor| {
            let mut own = fit.numbers.parameters.iter();
            let own = own.find(|own| own.name == factor.name && own.status == StatusWord::Free)?;
            let percent = 100.0 * (factor.before.value / own.value? - 1.0).abs();
            Some((percent, factor.name.as_str()))
        });
        let (percent, name) = differences.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (percent >= SAME_PERCENT).then(|| {
            format!(
                "There are two fits. This one is to the stiffness of poses and directions, as it is validated and mapped. The diagnosis fits the single readings, because only they show shape, order and time; before anything is added to the model its factors differ from these by up to {} % ({name}).",
                significant(percent, 2)
            )
        })
    }

    /// That the details state nothing else than the sessions.
    ///
    /// # Errors
    /// [`ReportError::Contradiction`] for other days of performance, and for an item that was received after its measurement.
    pub fn check_details(&self) -> Result<(), ReportError> {
        let details = &self.settings.details;
        let each: Option<Vec<&str>> = self
            .sessions
            .iter()
            .map(|one| one.performed.as_deref())
            .collect();
        let measured = days_in(&each.unwrap_or_default().join(" "));
        let Some([first, last]) = measured else {
            return Ok(());
        };
        let known = if first == last {
            first.to_string()
        } else {
            format!("{first} to {last}")
        };
        let refuse = |key, stated: &String| {
            Err(ReportError::Contradiction {
                key,
                stated: stated.clone(),
                known: known.clone(),
            })
        };
        if let Some(stated) = &details.performed
            && days_in(stated) != measured
        {
            return refuse("performed", stated);
        }
        if let Some(stated) = &details.item.received
            && days_in(stated).is_some_and(|[received, _]| received > last)
        {
            return refuse("item.received", stated);
        }
        Ok(())
    }
}

/// First and last day that a text names as YYYY-MM-DD.
fn days_in(text: &str) -> Option<[Date; 2]> {
    let words = text.split(|c: char| !c.is_ascii_digit() && c != '-');
    let days = || words.clone().filter_map(|word| word.parse::<Date>().ok());
    Some([days().min()?, days().max()?])
}

/// By how many percent the stiffness that a fit takes as measured lies from K of the results, at most, and where.
fn farthest(session: &PageSession, name: Option<&str>, fit: &PageFit) -> Option<(f64, String)> {
    let rows = session.numbers.iter().flat_map(|table| &table.cells);
    let differences = rows.filter_map(|row| {
        let cell = &row.cell;
        let value = row.by(Method::Regression).ok()?.estimate.value / N_PER_UM;
        let mut fitted = fit.numbers.cells.iter();
        let fitted = fitted.find(|fitted| {
            let session = fitted.session.as_deref();
            fitted.pose == cell.pose && fitted.direction == cell.direction && session == name
        })?;
        let percent = 100.0 * (fitted.measured.value? / value - 1.0).abs();
        Some((percent, cell.to_string()))
    });
    differences.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Temperature, humidity and what else is known of the surroundings.
fn surroundings(session: &PageSession) -> Option<String> {
    let temperature = session.condition("temperature during the readings");
    let temperature = temperature.or_else(|| session.condition("temperature at the start"));
    let humidity = session.condition("relative humidity");
    let known = [
        temperature,
        humidity.map(|one| format!("relative humidity {one}")),
        session.condition("surroundings"),
    ];
    let known: Vec<String> = known.into_iter().flatten().collect();
    (!known.is_empty()).then(|| known.join(", "))
}

/// How many readings there are, and of how many that were planned.
pub(super) fn about([readings, load_cases]: [usize; 2], planned: Option<(u32, u32)>) -> String {
    let mut about = match (load_cases, readings) {
        (0, readings) => counted(readings, "reading"),
        (cases, 0) => counted(cases, "load case"),
        (cases, readings) => format!(
            "{} from {}",
            counted(cases, "load case"),
            counted(readings, "reading")
        ),
    };
    if let Some((taken, planned)) = planned {
        about = if taken == planned {
            format!("{about}, all that were planned")
        } else {
            format!("{about}; {taken} of {planned} that were planned")
        };
    }
    about
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_found_in_any_text() {
        let days = |text| days_in(text).map(|days| days.map(|day| day.to_string()));
        let both = |a: &str, b: &str| Some([a.to_owned(), b.to_owned()]);
        assert_eq!(days("2026-11-20"), both("2026-11-20", "2026-11-20"));
        assert_eq!(
            days("from 2026-11-21, till 2026-11-20T10:00"),
            both("2026-11-20", "2026-11-21")
        );
        assert_eq!(days("last week, 2026-13-01"), None);
    }
}
