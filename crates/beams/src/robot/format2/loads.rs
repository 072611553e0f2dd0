//! Masses and balancers.

use stiffbench_units_and_text::toml_text::DocumentStep::{Index, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::loads::{Balancer, BalancerForce, BodyPoint, MassPlace, PointMass};

use super::builder::RobotBuilder;
use super::parts::BalancerRow;

impl RobotBuilder<'_> {
    pub(super) fn masses(&self) -> Result<Vec<PointMass>, RobotError> {
        let mut masses = Vec::new();
        for (name, row) in &self.file.masses {
            let at = |key| [Key("masses"), Key(name.as_str()), Key(key)];
            let body = self.body(&row.on, &at("on"))?;
            let at_m = self.three(row.at.as_ref(), &at("at"))?;
            masses.push(PointMass {
                name: name.clone(),
                mass_kg: self.positive(&row.mass, &at("mass"), format!("the mass {name}"))?,
                place: MassPlace::Point(BodyPoint {
                    body,
                    at_m: self.frames[body].point(at_m),
                }),
            });
        }
        Ok(masses)
    }

    pub(super) fn balancers(&self) -> Result<Vec<Balancer>, RobotError> {
        let mut balancers = Vec::new();
        for (name, row) in &self.file.balancers {
            let pivot = |place: usize| {
                let row = &row.pivots[place];
                let at = |key| {
                    [
                        Key("balancers"),
                        Key(name.as_str()),
                        Key("pivots"),
                        Index(place),
                        Key(key),
                    ]
                };
                let body = self.body(&row.on, &at("on"))?;
                let at_m = self.three(row.at.as_ref(), &at("at"))?;
                Ok::<_, RobotError>(BodyPoint {
                    body,
                    at_m: self.frames[body].point(at_m),
                })
            };
            balancers.push(Balancer {
                name: name.clone(),
                pivots: [pivot(0)?, pivot(1)?],
                force: self.balancer_force(name, row)?,
            });
        }
        Ok(balancers)
    }

    fn balancer_force(&self, name: &str, row: &BalancerRow) -> Result<BalancerForce, RobotError> {
        let at = |key| [Key("balancers"), Key(name), Key(key)];
        let length_m = self.value(&row.length, &at("length"))?;
        let length_m = self.positive_value(length_m, &at("length"), "the length of a balancer")?;
        let preload_n = row.preload.number();
        if preload_n.is_nan() || preload_n.abs() > 1e9 {
            let problem = RobotProblem::Impossible {
                what: "the preload of a balancer".to_owned(),
                value: preload_n,
                must: "it must be finite",
            };
            return Err(self.error(&at("preload"), problem));
        }
        match (&row.stiffness, &row.gas_column) {
            (Some(stiffness), None) if row.exponent.is_none() => Ok(BalancerForce::Spring {
                stiffness_n_per_m: self.positive(stiffness, &at("stiffness"), "the stiffness")?,
                preload_n,
                length_m,
            }),
            (None, Some(column)) => {
                let column = self.value(column, &at("gas_column"))?;
                Ok(BalancerForce::Gas {
                    preload_n,
                    length_m,
                    gas_column_m: self.positive_value(
                        column,
                        &at("gas_column"),
                        "the gas column",
                    )?,
                    exponent: self.positive_value(
                        row.exponent.unwrap_or(1.0),
                        &at("exponent"),
                        "the exponent",
                    )?,
                })
            }
            _ => {
                let message = "a balancer has either `stiffness`, or `gas_column` with an `exponent` if it is not 1";
                let path = [Key("balancers"), Key(name)];
                Err(self.error(&path, RobotProblem::Shape(message)))
            }
        }
    }
}
