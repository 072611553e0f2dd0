//! What loads and readings are, and in which units they are drawn.

use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;

use super::figure::Axis;

/// What loads and readings are.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantities {
    /// The load.
    pub load: AxisQuantity,
    /// What is read under it.
    pub reading: AxisQuantity,
    /// Whether loads and readings have a direction; those of a part have none.
    pub has_directions: bool,
}

/// A quantity along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisQuantity {
    /// Its name.
    pub name: String,
    /// Its unit as it is printed; empty for a number.
    pub unit: String,
    /// SI units in one of these.
    pub si: f64,
}

/// Forces in N, and displacements in µm, along the axes of a robot.
impl Default for Quantities {
    fn default() -> Self {
        let quantity = |name: &str, unit: &str, si| AxisQuantity {
            name: name.to_owned(),
            unit: unit.to_owned(),
            si,
        };
        Self {
            load: quantity("load", "N", 1.0),
            reading: quantity("displacement", "µm", METRES_PER_MICROMETRE),
            has_directions: true,
        }
    }
}

impl AxisQuantity {
    /// An axis of it.
    pub(super) fn axis(&self) -> Axis {
        self.axis_of(&self.name)
    }

    /// An axis of something else in its unit.
    pub(super) fn axis_of(&self, name: &str) -> Axis {
        Axis::linear(name, &self.unit)
    }

    /// A value in SI, in its unit.
    pub(super) fn shown(&self, si: f64) -> f64 {
        si / self.si
    }

    /// A number with its unit behind it.
    pub(super) fn with_unit(&self, number: &str) -> String {
        if self.unit.is_empty() {
            return number.to_owned();
        }
        format!("{number}\u{a0}{}", self.unit)
    }
}
