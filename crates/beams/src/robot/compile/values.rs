//! Expressions and numbers of a robot file to values that can be used.

use std::collections::HashMap;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::expression::{Expression, ExpressionError, in_range};
use crate::robot::parameters::{self, ParameterProblem};
use stiffbench_numeric::vector::norm;
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Key};

use super::Compiler;

impl<'a> Compiler<'a> {
    /// Values of the parameters.
    pub(super) fn parameters(&self) -> Result<HashMap<&'a str, f64>, RobotError> {
        parameters::values(&self.file.parameters).map_err(|(name, problem)| {
            let path = [Key("parameters"), Key(name)];
            match problem {
                ParameterProblem::Expression(problem) => self.no_value(problem, &path),
                ParameterProblem::Circular(around) => self.error(
                    &path,
                    RobotProblem::Circular {
                        kind: "parameter",
                        name: name.to_owned(),
                        chain: around.join(" needs "),
                    },
                ),
            }
        })
    }

    /// Value of an expression, m or degrees.
    pub(super) fn value(
        &self,
        expression: &Expression,
        path: &[DocumentStep<'_>],
    ) -> Result<f64, RobotError> {
        expression
            .value(&|name| self.parameters.get(name).copied())
            .map_err(|problem| self.no_value(problem, path))
    }

    /// The error for an expression without value, with the nearest parameter as help.
    fn no_value(&self, problem: ExpressionError, path: &[DocumentStep<'_>]) -> RobotError {
        let help = match &problem {
            ExpressionError::UnknownName { name } => {
                let known = self.file.parameters.keys().map(String::as_str);
                nearest(name, known).map(|near| format!("did you mean `{near}`?"))
            }
            _ => None,
        };
        RobotError::at(
            self.source,
            self.source.toml_span(path),
            problem.into(),
            help,
        )
    }

    /// A coefficient or coordinate that is a plain number.
    pub(super) fn number(&self, value: f64, path: &[DocumentStep<'_>]) -> Result<f64, RobotError> {
        in_range(value).map_err(|problem| self.error(path, problem.into()))
    }

    /// A number that must be finite and above zero.
    pub(super) fn positive(
        &self,
        value: f64,
        path: &[DocumentStep<'_>],
        what: String,
    ) -> Result<f64, RobotError> {
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        let must = "it must be finite and above zero";
        Err(self.error(path, RobotProblem::Impossible { what, value, must }))
    }

    /// A direction, scaled to length one.
    pub(super) fn unit_vector(
        &self,
        vector: [f64; 3],
        path: &[DocumentStep<'_>],
    ) -> Result<[f64; 3], RobotError> {
        // Scaled by the largest component first: squares of very large or small numbers leave the range of an f64.
        let largest = vector.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let scaled = vector.map(|c| c / largest);
        let scaled_length = norm(scaled);
        if scaled_length.is_finite() {
            return Ok(scaled.map(|c| c / scaled_length));
        }
        let length = norm(vector);
        let what = "the length of this vector".to_owned();
        Err(self.error(
            path,
            RobotProblem::Impossible {
                what,
                value: length,
                must: "a direction needs a finite length above zero",
            },
        ))
    }
}
