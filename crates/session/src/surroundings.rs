//! What the operator enters of the surroundings, and when.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Surroundings {
    /// Temperature, °C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_deg_c: Option<f64>,
    /// Relative humidity, %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub humidity_percent: Option<f64>,
    /// Whether it was entered at the start or at the end; absent in journals of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occasion: Option<Occasion>,
}

/// When the surroundings are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Occasion {
    /// Before the first reading of a session, and again after it was resumed.
    Start,
    /// After the last reading.
    End,
}

impl fmt::Display for Occasion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::End => "end",
        })
    }
}

impl Surroundings {
    /// Whether nothing was entered.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.temperature_deg_c.is_none() && self.humidity_percent.is_none()
    }
}

impl fmt::Display for Surroundings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let temperature = self.temperature_deg_c.map(|value| format!("{value} degC"));
        let humidity = self
            .humidity_percent
            .map(|value| format!("{value} % relative humidity"));
        let values: Vec<String> = temperature.into_iter().chain(humidity).collect();
        f.write_str(&values.join(", "))?;
        match self.occasion {
            Some(occasion) => write!(f, " at the {occasion}"),
            None => Ok(()),
        }
    }
}
