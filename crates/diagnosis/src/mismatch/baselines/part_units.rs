//! From SI units to those of a part's table, and back.

use stiffbench_beams::physics::{Dimension, ParameterSpec};
use stiffbench_measurement::specimen::{ColumnUnit, ResponseVariable, SpecimenTable};

/// The units of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct PartUnits {
    /// Which quantity answers.
    pub response: ResponseVariable,
    /// What was set.
    pub load: ColumnUnit,
    /// What answered.
    pub answer: ColumnUnit,
    /// Whether the order of the readings is used as time.
    pub order_is_clock: bool,
}

/// A unit of a quantity of a part.
#[derive(Debug, Clone, PartialEq)]
pub struct PartUnit {
    /// SI units in one of the table; 1 where the table has none.
    pub si_per_unit: f64,
    /// Name of the unit of the table.
    pub name: String,
    /// Name of the SI unit.
    pub si_name: String,
}

impl PartUnit {
    /// A number in SI in the unit of the table.
    #[must_use]
    pub fn in_table(&self, si: f64) -> f64 {
        si / self.si_per_unit
    }

    /// A number of the table in SI.
    #[must_use]
    pub fn in_si(&self, in_table: f64) -> f64 {
        in_table * self.si_per_unit
    }
}

impl PartUnits {
    /// Those of a table.
    #[must_use]
    pub fn new(table: &SpecimenTable) -> Self {
        let (force, displacement) = (&table.force_unit, &table.displacement_unit);
        let (load, answer) = match table.response {
            ResponseVariable::Displacement => (force, displacement),
            ResponseVariable::Force => (displacement, force),
        };
        Self {
            order_is_clock: table.readings.iter().all(|one| one.time_s.is_none()),
            response: table.response,
            load: load.clone(),
            answer: answer.clone(),
        }
    }

    /// Names of what was set and of what answered.
    #[must_use]
    pub fn names(&self) -> [&'static str; 2] {
        self.response.set_and_answer()
    }

    /// The unit of a parameter.
    #[must_use]
    pub fn of(&self, spec: &ParameterSpec) -> PartUnit {
        let Some([of_answer, of_load, of_time]) = spec.dimension.powers() else {
            return PartUnit {
                si_per_unit: 1.0,
                name: spec.unit().to_owned(),
                si_name: spec.unit().to_owned(),
            };
        };
        let name = |answer: &str, load: &str| match (of_answer, of_load, of_time) {
            (1, 0, 0) if spec.dimension == Dimension::LengthPerTemperature => per(answer, "K"),
            (1, 0, 0) => answer.to_owned(),
            (0, 1, 0) => load.to_owned(),
            (0, _, 0) => per("1", &power(load, -of_load)),
            (1, _, 0) => per(answer, &power(load, -of_load)),
            _ if self.order_is_clock => per(answer, "reading"),
            _ => per(answer, "s"),
        };
        self.of_powers([of_answer, of_load], name)
    }

    /// The unit of an answer.
    #[must_use]
    pub fn of_answer(&self) -> PartUnit {
        self.of_powers([1, 0], |answer, _| answer.to_owned())
    }

    /// The unit of what was set.
    #[must_use]
    pub fn of_load(&self) -> PartUnit {
        self.of_powers([0, 1], |_, load| load.to_owned())
    }

    /// The unit of a slope.
    #[must_use]
    pub fn of_slope(&self) -> PartUnit {
        PartUnit {
            si_per_unit: self.answer.si_per_unit / self.load.si_per_unit,
            ..self.of_powers([1, -1], per)
        }
    }

    /// The unit of a product of powers of answer and load.
    ///
    /// # Arguments
    /// - `name`: its name by those of the answer and the load.
    fn of_powers(
        &self,
        [of_answer, of_load]: [i8; 2],
        name: impl Fn(&str, &str) -> String,
    ) -> PartUnit {
        let product =
            |answer: f64, load: f64| answer.powi(of_answer.into()) * load.powi(of_load.into());
        PartUnit {
            si_per_unit: product(self.answer.si_per_unit, self.load.si_per_unit),
            name: name(&self.answer.name, &self.load.name),
            si_name: name(self.answer.si, self.load.si),
        }
    }
}

/// `a` per `b`; numbers without a unit have the unit 1.
fn per(a: &str, b: &str) -> String {
    match (a, b) {
        (a, "1") => a.to_owned(),
        (a, b) if b.contains(['/', '*', ' ', '-']) => format!("{a}/({b})"),
        (a, b) => format!("{a}/{b}"),
    }
}

/// A power of a unit.
fn power(unit: &str, exponent: i8) -> String {
    match (unit, exponent) {
        ("1", _) => "1".to_owned(),
        (unit, 1) => unit.to_owned(),
        (unit, n) if unit.chars().all(char::is_alphabetic) => format!("{unit}^{n}"),
        (unit, n) => format!("({unit})^{n}"),
    }
}
