//! What `--map` calls the columns of a table of load cases.

use crate::load_cases::VectorQuantity;
use stiffbench_units_and_text::test_point::Direction;

/// What a column of a table of load cases holds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum VectorRole {
    /// `pose`, `repeat`, `axes`, `status` or `origin`.
    Text(&'static str),
    Joint(String),
    Component(VectorQuantity, Direction),
}

/// Columns of texts, under the names that tables of load cases have for them.
pub(super) const TEXTS: [&str; 5] = ["pose", "repeat", "axes", "status", "origin"];

impl VectorRole {
    /// By its name behind `--map`.
    pub(super) fn named(name: &str) -> Option<Self> {
        if let Some(joint) = name.strip_prefix("joint.") {
            return Some(Self::Joint(joint.to_owned()));
        }
        if let Some(text) = TEXTS.into_iter().find(|text| *text == name) {
            return Some(Self::Text(text));
        }
        let (quantity, axis) = name.rsplit_once('_')?;
        let quantity = VectorQuantity::ALL
            .into_iter()
            .find(|known| known.name() == quantity);
        Some(Self::Component(quantity?, axis.parse().ok()?))
    }

    pub(super) fn name(&self) -> String {
        match self {
            Self::Text(text) => (*text).to_owned(),
            Self::Joint(name) => format!("joint.{name}"),
            Self::Component(quantity, axis) => format!("{}_{axis}", quantity.name()),
        }
    }
}

/// Whether `--map` can name a component of a vector so.
pub(super) fn is_component(role: &str) -> bool {
    matches!(VectorRole::named(role), Some(VectorRole::Component(..)))
}
