//! `report.toml`: what a report states and no session holds.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use crate::source_text::SourceText;
use crate::toml_text::read;

use super::conformity::{DecisionRule, Requirement};
use super::error::ReportError;

/// The schema of `report.toml`.
const SCHEMA: &str = "stiffbench/report-details/1";

/// A `report.toml` to be filled in.
pub const DETAILS_TEMPLATE: &str = include_str!("../../../data/report/report.toml");

/// What the user states for a report: the items of ISO/IEC 17025:2017, 7.8.2.1, that no session holds, and what is required.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct PageDetails {
    /// The schema of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// Title of the report.
    pub title: Option<String>,
    /// Who measures.
    pub laboratory: LaboratoryDetails,
    /// For whom.
    pub customer: CustomerDetails,
    /// What was measured.
    pub item: ItemDetails,
    /// How.
    pub method: MethodDetails,
    /// When it was measured, where the session has no times.
    #[serde(deserialize_with = "text_or_date")]
    #[schemars(with = "Option<String>")]
    pub performed: Option<String>,
    /// Who authorises the report.
    pub authorised_by: Option<String>,
    /// Results of other laboratories.
    pub external_providers: Option<String>,
    /// Remarks.
    pub remarks: Option<String>,
    /// How pass and fail are decided.
    pub decision_rule: Option<DecisionRule>,
    /// Limits of the stiffness of cells.
    #[serde(rename = "requirement", skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<Requirement>,
}

/// The laboratory.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct LaboratoryDetails {
    /// Its name.
    pub name: Option<String>,
    /// Its address.
    pub address: Option<String>,
    /// Where the work was done, if elsewhere.
    pub location: Option<String>,
}

/// The customer.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CustomerDetails {
    /// The name.
    pub name: Option<String>,
    /// How to reach the customer.
    pub contact: Option<String>,
}

/// The item under test.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ItemDetails {
    /// What it is.
    pub description: Option<String>,
    /// By what it can be told from others: serial number, inventory number.
    pub identification: Option<String>,
    /// Its condition.
    pub condition: Option<String>,
    /// Day of receipt.
    #[serde(deserialize_with = "text_or_date")]
    #[schemars(with = "Option<String>")]
    pub received: Option<String>,
}

/// The method.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct MethodDetails {
    /// The document that describes it; without it the procedure of the session is named.
    pub reference: Option<String>,
    /// Plan and method of sampling.
    pub sampling: Option<String>,
    /// Additions to, deviations and exclusions from the method.
    pub deviations: Option<String>,
}

/// A text, or a date of TOML.
fn text_or_date<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    let value = Option::<toml::Value>::deserialize(deserializer)?;
    match value {
        None => Ok(None),
        Some(toml::Value::String(text)) => Ok(Some(text)),
        Some(toml::Value::Datetime(date)) if date.date.is_some() => Ok(Some(date.to_string())),
        Some(_) => Err(serde::de::Error::custom("expected a date or a text")),
    }
}

impl PageDetails {
    /// Reads a `report.toml`.
    ///
    /// # Errors
    /// [`ReportError::Details`] with the place: for a text that is not TOML, unknown keys, and requirements without a limit.
    pub fn parse(source: &SourceText) -> Result<Self, ReportError> {
        let wrong = |place: String, problem: String| ReportError::Details { place, problem };
        let (details, unknown) = read::<Self>(source)
            .map_err(|error| wrong(error.0.place(), error.0.problem.to_string()))?;
        if let Some(key) = unknown.first() {
            let place = format!("{}:{}:{}", source.name, key.line, key.column);
            let problem = format!("key `{}` is not known{}", key.key, key.advice());
            return Err(wrong(place, problem));
        }
        let schema = details.schema.as_deref();
        if let Some(other) = schema.filter(|schema| *schema != SCHEMA) {
            let problem = format!("`schema` is `{other}`, expected `{SCHEMA}`");
            return Err(wrong(source.name.clone(), problem));
        }
        if let Some(key) = blank_key(&serde_json::to_value(&details).unwrap_or_default()) {
            let problem = format!(
                "`{key}` is empty; leave the key out, or write \"not applicable\" if that is true"
            );
            return Err(wrong(source.name.clone(), problem));
        }
        for requirement in &details.requirements {
            if let Some(problem) = requirement.problem() {
                return Err(wrong(source.name.clone(), problem));
            }
        }
        Ok(details)
    }

    /// These details with those of a later file, whose entries go first.
    #[must_use]
    pub fn with(self, later: Self) -> Self {
        let [mut merged, later_value] =
            [&self, &later].map(|one| serde_json::to_value(one).unwrap_or_default());
        overlay(&mut merged, later_value);
        let mut requirements = self.requirements;
        requirements.retain(|old| {
            let mut new = later.requirements.iter();
            !new.any(|new| new.pose == old.pose && new.direction == old.direction)
        });
        requirements.extend(later.requirements.iter().cloned());
        Self {
            schema: None,
            requirements,
            ..serde_json::from_value(merged).unwrap_or(later)
        }
    }
}

/// Puts the values of later tables over those of earlier ones.
fn overlay(earlier: &mut serde_json::Value, later: serde_json::Value) {
    use serde_json::Value::{Null, Object};
    match (earlier, later) {
        (Object(earlier), Object(later)) => {
            for (key, value) in later {
                overlay(earlier.entry(key).or_insert(Null), value);
            }
        }
        (_, Null) => {}
        (earlier, later) => *earlier = later,
    }
}

/// The first key, with its table, whose text holds nothing that can be seen.
fn blank_key(value: &serde_json::Value) -> Option<String> {
    let entries = value.as_object()?;
    entries.iter().find_map(|(key, value)| match value {
        serde_json::Value::String(text) => text.trim().is_empty().then(|| key.clone()),
        table => blank_key(table).map(|inner| format!("{key}.{inner}")),
    })
}

/// An item that ISO/IEC 17025:2017, 7.8.2.1, asks for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageItem {
    /// Letter of the clause.
    pub clause: &'static str,
    /// What it is.
    pub name: &'static str,
    /// What is stated; `null` if nothing is.
    pub value: Option<String>,
    /// The key of `report.toml`, or the option, that states it.
    pub key: &'static str,
}

/// What the session states of these items.
#[derive(Debug, Clone, Default)]
pub(super) struct KnownItems {
    /// Procedure.
    pub(super) method: Option<String>,
    /// Days of the measurement.
    pub(super) performed: Option<String>,
    /// Day of issue.
    pub(super) issued: Option<String>,
    /// Where the session says that it was measured.
    pub(super) place: Option<String>,
    /// Where what was not as planned is listed, if anything was.
    pub(super) deviations: Option<String>,
}

/// Where the number stands: it follows from all else that a report states.
const NUMBER_STANDS: &str = "under the title, at the foot of each printed page and at the end";

/// All items, in the order of the clause.
#[must_use]
pub(super) fn page_items(details: &PageDetails, known: &KnownItems) -> Vec<PageItem> {
    let item = |clause, name, value: Option<&String>, key| PageItem {
        clause,
        name,
        value: value.cloned(),
        key,
    };
    let (laboratory, customer) = (&details.laboratory, &details.customer);
    let location = laboratory.location.as_ref().or(known.place.as_ref());
    #[rustfmt::skip]
    let items = vec![
        item("b", "laboratory", laboratory.name.as_ref(), "laboratory.name"),
        item("b", "address of the laboratory", laboratory.address.as_ref(), "laboratory.address"),
        item("c", "location of the activity", location, "laboratory.location"),
        item("d", "report number", Some(&NUMBER_STANDS.to_owned()), ""),
        item("e", "customer", customer.name.as_ref(), "customer.name"),
        item("e", "contact of the customer", customer.contact.as_ref(), "customer.contact"),
        item("f", "method", details.method.reference.as_ref().or(known.method.as_ref()), "method.reference"),
        item("g", "item", details.item.description.as_ref(), "item.description"),
        item("g", "identification of the item", details.item.identification.as_ref(), "item.identification"),
        item("g", "condition of the item", details.item.condition.as_ref(), "item.condition"),
        item("h", "date of receipt", details.item.received.as_ref(), "item.received"),
        item("i", "date of performance", known.performed.as_ref().or(details.performed.as_ref()), "performed"),
        item("j", "date of issue", known.issued.as_ref(), "--issued DATE"),
        item("k", "sampling", details.method.sampling.as_ref(), "method.sampling"),
        item("n", "deviations from the method", details.method.deviations.as_ref().or(known.deviations.as_ref()), "method.deviations"),
        item("o", "authorised by", details.authorised_by.as_ref(), "authorised_by"),
        item("p", "results of external providers", details.external_providers.as_ref(), "external_providers"),
    ];
    items
}
