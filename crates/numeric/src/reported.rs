//! Numbers as they go to JSON.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::statistics::Estimate;

/// A number as it goes to JSON: value, unit, and what is known of its uncertainty.
///
/// A value that is not finite becomes `null` with the reason beside it, so that JSON never holds NaN or infinity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Reported {
    /// The value in `unit`; `null` if there is none.
    pub value: Option<f64>,
    /// ASCII unit, for example `N/um` or `rad/(N*m)`.
    pub unit: Cow<'static, str>,
    /// Standard uncertainty u, in `unit`.
    #[serde(rename = "u", skip_serializing_if = "Option::is_none")]
    pub standard_uncertainty: Option<f64>,
    /// Expanded uncertainty U = k u for 95 %, in `unit`.
    #[serde(rename = "U", skip_serializing_if = "Option::is_none")]
    pub expanded_uncertainty: Option<f64>,
    /// Coverage factor k for 95 %, from Student's t with `dof`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// Effective degrees of freedom; absent when infinite or when no uncertainty is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dof: Option<f64>,
    /// 95 % interval in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// Why `value` or its uncertainty is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Reported {
    /// A value without uncertainty.
    #[must_use]
    pub fn exact(value: f64, unit: &'static str) -> Self {
        let finite = value.is_finite();
        Self {
            value: finite.then_some(value),
            unit: unit.into(),
            standard_uncertainty: None,
            expanded_uncertainty: None,
            k: None,
            dof: None,
            ci95: None,
            reason: (!finite).then(|| "the value is not finite".to_owned()),
        }
    }

    /// No value, and why.
    #[must_use]
    pub fn missing(unit: &'static str, reason: impl Into<String>) -> Self {
        Self {
            value: None,
            reason: Some(reason.into()),
            ..Self::exact(0.0, unit)
        }
    }

    /// A value with a 95 % interval, both already in `unit`; an end that is not finite leaves the interval out.
    #[must_use]
    pub fn with_interval(value: f64, interval: [f64; 2], unit: &'static str) -> Self {
        let finite = interval.iter().all(|end| end.is_finite());
        Self {
            ci95: finite.then_some(interval),
            ..Self::exact(value, unit)
        }
    }

    /// An estimate in SI, printed in `unit`, of which one is `si_per_unit` SI units.
    #[must_use]
    pub fn from_estimate(estimate: &Estimate, si_per_unit: f64, unit: &'static str) -> Self {
        let mut reported = Self::exact(estimate.value / si_per_unit, unit);
        match estimate.expanded_95() {
            Some(expanded) => {
                reported.standard_uncertainty = Some(estimate.standard_uncertainty / si_per_unit);
                reported.expanded_uncertainty = Some(expanded / si_per_unit);
                reported.k = estimate.coverage_factor_95();
                reported.dof = estimate.dof.is_finite().then_some(estimate.dof);
            }
            None => {
                reported.reason.get_or_insert_with(|| {
                    "no uncertainty: fewer than one degree of freedom".to_owned()
                });
            }
        }
        reported
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_never_holds_infinity() {
        let text = serde_json::to_string(&Reported::exact(f64::INFINITY, "N/um")).unwrap();
        assert_eq!(
            text,
            r#"{"value":null,"unit":"N/um","reason":"the value is not finite"}"#
        );
    }

    #[test]
    fn estimates_are_printed_in_their_unit() {
        let estimate = Estimate {
            value: 10e6,
            standard_uncertainty: 0.5e6,
            dof: 4.0,
        };
        let reported = Reported::from_estimate(&estimate, 1e6, "N/um");
        assert_eq!(reported.value, Some(10.0));
        assert_eq!(reported.standard_uncertainty, Some(0.5));
        // k = 2.776 for 4 degrees of freedom, GUM table G.2.
        assert!((reported.expanded_uncertainty.unwrap() - 1.388).abs() < 1e-3);
        assert!((reported.k.unwrap() - 2.776).abs() < 1e-3);
        assert_eq!(reported.dof, Some(4.0));
        let bare = Reported::from_estimate(&Estimate::without_uncertainty(10e6), 1e6, "N/um");
        assert_eq!((bare.value, bare.k), (Some(10.0), None));
        assert!(bare.reason.unwrap().contains("degree of freedom"));
    }

    #[test]
    fn what_is_missing_has_a_reason_and_intervals_have_finite_ends() {
        let missing = Reported::missing("N", "no reading");
        assert_eq!(
            (missing.value, missing.reason.as_deref()),
            (None, Some("no reading"))
        );
        let interval = |ends| Reported::with_interval(1.0, ends, "N").ci95;
        assert_eq!(interval([0.5, 1.5]), Some([0.5, 1.5]));
        assert_eq!(interval([0.5, f64::INFINITY]), None);
    }
}
