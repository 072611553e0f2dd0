//! The units and words of what a diagnosis is of: a robot in those of its bench, a part in those of its table.

use stiffbench_document::sign_of;

use crate::analysis::{DiagnosisReport, Subject};
use crate::mismatch::{EstimatedValue, PartUnit};
use crate::physics::{Dimension, ParameterSpec};
use crate::plot::{AxisQuantity, Quantities};
use crate::report::text::{micro, significant, unit_behind};

use super::FittedParameter;
use super::summary::{STEPPED, SiValue, TableValue};

impl Subject {
    /// What a reading shows, or is off by, with its unit: of a robot in µm.
    pub(super) fn reading(&self, si: f64) -> String {
        match self {
            Self::Robot(_) => um(si),
            Self::Part { units, .. } => in_unit(&units.of_answer(), si),
        }
    }

    /// A load with its unit: of a robot in N.
    pub(super) fn load(&self, si: f64) -> String {
        match self {
            Self::Robot(_) => significant(si, 3) + " N",
            Self::Part { units, .. } => in_unit(&units.of_load(), si),
        }
    }

    /// A reading, or what one is off by, in µm; `None` of readings that are no lengths.
    pub(super) fn micrometres(&self, si: f64) -> Option<f64> {
        match self {
            Self::Part { units, .. } if units.of_answer().si_name != "m" => None,
            _ => Some(micro(si)),
        }
    }

    /// The same in the unit of a part's table.
    pub(super) fn in_table(&self, si: f64) -> Option<TableValue> {
        let Self::Part { units, .. } = self else {
            return None;
        };
        let unit = units.of_answer();
        Some(TableValue {
            value: unit.in_table(si),
            unit: unit.name,
            si: SiValue {
                value: si,
                unit: unit.si_name,
                ci95: None,
            },
        })
    }

    /// SI units in one of the readings' unit, and its name.
    pub(super) fn reading_unit(&self) -> (f64, String) {
        match self {
            Self::Robot(_) => (1e-6, "um".to_owned()),
            Self::Part { units, .. } => {
                let unit = units.of_answer();
                (unit.si_per_unit, unit.name)
            }
        }
    }

    /// By what a value of a parameter is multiplied to be printed, and in which unit.
    ///
    /// # Arguments
    /// - `size`: the value, SI.
    pub(super) fn printed(&self, spec: &ParameterSpec, size: f64) -> (f64, String) {
        match self {
            Self::Part { units, .. }
                if spec.dimension.powers().is_some() || spec.dimension == Dimension::Share =>
            {
                let unit = units.of(spec);
                (unit.si_per_unit.recip(), sign_of(&unit.name))
            }
            _ => {
                let (factor, unit) = spec.dimension.printed(size);
                (factor, sign_of(unit))
            }
        }
    }

    /// A value of a parameter with its unit.
    pub(super) fn with_unit(&self, spec: &ParameterSpec, value: f64) -> String {
        let (factor, unit) = self.printed(spec, value);
        significant(factor * value, 3) + &unit_behind(&unit)
    }

    /// A value of a parameter as files have it: of a robot in SI.
    pub(in crate::report) fn fitted(
        &self,
        spec: &ParameterSpec,
        value: &EstimatedValue,
    ) -> FittedParameter {
        let Self::Part { units, .. } = self else {
            return FittedParameter::of_law(spec, value);
        };
        let unit = units.of(spec);
        let (own, interval) = (unit.in_table(value.value), value.interval_95());
        let scaled = interval.map(|ends| ends.map(|end| unit.in_table(end)));
        FittedParameter {
            si: Some(SiValue {
                value: value.value,
                unit: unit.si_name,
                ci95: interval,
            }),
            ..FittedParameter::new(own, unit.name, scaled, STEPPED).with_open_ends(value)
        }
    }

    /// SI units in the unit that files have of a parameter, and the unit: of a robot SI.
    pub(super) fn stored(&self, spec: &ParameterSpec) -> (f64, String) {
        match self {
            Self::Robot(_) => (1.0, spec.unit().to_owned()),
            Self::Part { units, .. } => {
                let unit = units.of(spec);
                (unit.si_per_unit, unit.name)
            }
        }
    }

    /// Words that a diagnosis of a robot has, or those of a part.
    pub(in crate::report) fn words(
        &self,
        of_robot: &'static str,
        of_part: &'static str,
    ) -> &'static str {
        match self {
            Self::Robot(_) => of_robot,
            Self::Part { .. } => of_part,
        }
    }

    /// What was fitted without any law.
    pub(super) fn model(&self) -> &'static str {
        self.words("model", "straight line")
    }

    /// What readings are of: poses, or configurations of a part.
    pub(super) fn pose(&self) -> &'static str {
        self.words("pose", "configuration")
    }

    /// What is fitted beside every law: factors, or the slopes of a part.
    pub(super) fn factor(&self) -> &'static str {
        self.words("factor", "slope")
    }

    /// What loads and readings are, for figures.
    pub(in crate::report) fn quantities(&self) -> Quantities {
        let Self::Part { units, .. } = self else {
            return Quantities::default();
        };
        let quantity = |name: &str, unit: PartUnit| AxisQuantity {
            name: name.to_owned(),
            unit: if unit.name == "1" {
                String::new()
            } else {
                unit.name
            },
            si: unit.si_per_unit,
        };
        let [load, reading] = units.names();
        Quantities {
            load: quantity(load, units.of_load()),
            reading: quantity(reading, units.of_answer()),
            has_directions: false,
        }
    }
}

impl DiagnosisReport {
    /// Whether it is of a part without a robot file.
    pub(in crate::report) fn is_of_part(&self) -> bool {
        matches!(self.subject, Subject::Part { .. })
    }
}

fn in_unit(unit: &PartUnit, si: f64) -> String {
    significant(unit.in_table(si), 3) + &unit_behind(&unit.name)
}

/// A length in µm with as many digits as help.
fn um(value_m: f64) -> String {
    um_shown(value_m * 1e6)
}

/// The same of a length in µm.
pub(super) fn um_shown(value: f64) -> String {
    if value.abs() >= 99.95 {
        format!("{value:.0} µm")
    } else {
        format!("{value:.1} µm")
    }
}
