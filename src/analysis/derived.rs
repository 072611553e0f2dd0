//! Quantities that follow from fitted parameters, with their propagated uncertainty.
//!
//! An expression is made of parameters, numbers, `+ - * /` and parentheses. It is evaluated together with its derivatives, and its variance
//! follows from the covariance of the parameters by the law of propagation of uncertainty (JCGM 100:2008, equation 13).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fit::{FactorCorrelations, FactorEstimate, FactorStatus};
use crate::nearest::nearest;
use crate::statistics::student_t_quantile;

use super::error::ArgumentError;

/// Deepest nesting of parentheses and signs.
const DEEPEST: usize = 50;

/// A quantity that follows from fitted parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DerivedQuantity {
    /// What the user calls it.
    pub name: String,
    /// How it follows from the parameters.
    pub expression: String,
    /// Its value, from parameters in their units.
    pub value: f64,
    /// Propagated standard uncertainty; `null` if the data do not determine a parameter in it.
    pub se: Option<f64>,
    /// 95 % interval of that uncertainty.
    pub ci95: Option<[f64; 2]>,
    /// What to know of it.
    pub words: Option<String>,
}

/// Derives quantities.
///
/// # Arguments
/// - `asked`: each as NAME=EXPRESSION.
///
/// # Errors
/// For what is no expression in the parameters of the fit, and for one without a finite value.
pub fn derive(
    asked: &[String],
    estimates: &[FactorEstimate],
    correlation: Option<&FactorCorrelations>,
) -> Result<Vec<DerivedQuantity>, ArgumentError> {
    let of = |text: &String| {
        let (name, expression) = text.split_once('=').unwrap_or((text, ""));
        let wrong = |(problem, help): (String, Option<String>)| ArgumentError {
            argument: format!("--derive {text}"),
            problem,
            help,
        };
        let (name, expression) = (name.trim(), expression.trim());
        if name.is_empty() || expression.is_empty() {
            let help = "for example ratio=beam.Iy/beam.Iz, or k=1/joint.J2".to_owned();
            return Err(wrong(("it is not NAME=EXPRESSION".to_owned(), Some(help))));
        }
        let found = ExpressionParser::new(expression, estimates)
            .whole()
            .map_err(wrong)?;
        let mut quantity = DerivedQuantity {
            name: name.to_owned(),
            expression: expression.to_owned(),
            value: found.value,
            se: None,
            ci95: None,
            words: None,
        };
        match found.standard_uncertainty(estimates, correlation) {
            Ok((se, at_bound)) => {
                let dof = correlation.and_then(|found| found.dof);
                let factor = student_t_quantile(0.975, dof.unwrap_or(f64::INFINITY));
                quantity.se = Some(se);
                quantity.ci95 = factor.map(|t| [found.value - t * se, found.value + t * se]);
                quantity.words =
                    at_bound.map(|name| format!("{name} is at its bound and taken as exact"));
            }
            Err(words) => quantity.words = Some(words),
        }
        Ok(quantity)
    };
    asked.iter().map(of).collect()
}

/// A value with its derivatives to the parameters.
#[derive(Debug, Clone)]
struct Differentiated {
    value: f64,
    gradient: Vec<f64>,
}

impl Differentiated {
    /// The same function of both values, by its derivatives to them.
    fn with(self, other: &Self, value: f64, [own, others]: [f64; 2]) -> Self {
        let pairs = self.gradient.iter().zip(&other.gradient);
        let gradient = pairs.map(|(a, b)| own * a + others * b).collect();
        Self { value, gradient }
    }

    /// Standard uncertainty, and a parameter on its bound that was taken as exact.
    ///
    /// # Errors
    /// Which parameter has no uncertainty.
    fn standard_uncertainty<'e>(
        &self,
        estimates: &'e [FactorEstimate],
        correlation: Option<&FactorCorrelations>,
    ) -> Result<(f64, Option<&'e str>), String> {
        let names = correlation.map_or(&[][..], |found| &found.names);
        let mut shares = vec![0.0; names.len()];
        let mut at_bound = None;
        for (estimate, derivative) in estimates.iter().zip(&self.gradient) {
            if *derivative == 0.0 {
                continue;
            }
            // A tied parameter keeps its ratio to the other.
            let source = match &estimate.status {
                FactorStatus::Fixed => continue,
                FactorStatus::Tied { to } => estimates.iter().find(|other| other.name == *to),
                _ => Some(estimate),
            };
            let source = source.unwrap_or(estimate);
            if matches!(source.status, FactorStatus::Fixed) {
                continue;
            }
            if matches!(source.status, FactorStatus::AtBound { .. }) {
                at_bound = Some(source.name.as_str());
                continue;
            }
            let place = names.iter().position(|name| *name == source.name);
            let is_open = matches!(source.status, FactorStatus::NotIdentified { .. });
            let Some(place) = place.filter(|_| !is_open) else {
                return Err(format!("the data give {} no uncertainty", source.name));
            };
            // The covariance is that of the logarithm of a factor and of the compliance of a spring.
            let slope = if source.parameter.is_factor() {
                estimate.value
            } else if source.value == 0.0 {
                1.0
            } else {
                estimate.value / source.value
            };
            shares[place] += derivative * slope;
        }
        let covariance = correlation.map_or(&[][..], |found| &found.covariance);
        let variance: f64 = covariance
            .iter()
            .zip(&shares)
            .map(|(row, a)| a * row.iter().zip(&shares).map(|(c, b)| c * b).sum::<f64>())
            .sum();
        Ok((variance.max(0.0).sqrt(), at_bound))
    }
}

/// What is wrong, and what would be right.
type Wrong = (String, Option<String>);

/// Evaluates an expression from left to right.
struct ExpressionParser<'a> {
    rest: &'a str,
    depth: usize,
    estimates: &'a [FactorEstimate],
}

impl<'a> ExpressionParser<'a> {
    fn new(text: &'a str, estimates: &'a [FactorEstimate]) -> Self {
        Self {
            rest: text.trim_start(),
            depth: 0,
            estimates,
        }
    }

    /// The whole text, which must have a finite value.
    fn whole(mut self) -> Result<Differentiated, Wrong> {
        let found = self.sum()?;
        if !self.rest.is_empty() {
            return Err((format!("`{}` was not expected", self.rest), None));
        }
        let numbers = std::iter::once(&found.value).chain(&found.gradient);
        if numbers.into_iter().all(|number| number.is_finite()) {
            Ok(found)
        } else {
            Err(("it has no finite value".to_owned(), None))
        }
    }

    /// Takes a sign if it comes next.
    fn takes(&mut self, sign: char) -> bool {
        let after = self.rest.strip_prefix(sign);
        if let Some(after) = after {
            self.rest = after.trim_start();
        }
        after.is_some()
    }

    fn sum(&mut self) -> Result<Differentiated, Wrong> {
        let mut left = self.product()?;
        loop {
            let sign = if self.takes('+') {
                1.0
            } else if self.takes('-') {
                -1.0
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            let value = left.value + sign * right.value;
            left = left.with(&right, value, [1.0, sign]);
        }
    }

    fn product(&mut self) -> Result<Differentiated, Wrong> {
        let mut left = self.operand()?;
        loop {
            let (a, is_product) = (left.value, self.takes('*'));
            if !is_product && !self.takes('/') {
                return Ok(left);
            }
            let right = self.operand()?;
            let b = right.value;
            left = if is_product {
                left.with(&right, a * b, [b, a])
            } else {
                left.with(&right, a / b, [1.0 / b, -a / (b * b)])
            };
        }
    }

    fn operand(&mut self) -> Result<Differentiated, Wrong> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(("it is nested too deep".to_owned(), None));
        }
        let found = if self.takes('-') {
            let mut operand = self.operand()?;
            operand.value = -operand.value;
            operand
                .gradient
                .iter_mut()
                .for_each(|entry| *entry = -*entry);
            operand
        } else if self.takes('(') {
            let inner = self.sum()?;
            if !self.takes(')') {
                return Err(("a parenthesis is not closed".to_owned(), None));
            }
            inner
        } else {
            self.word()?
        };
        self.depth -= 1;
        Ok(found)
    }

    /// A number or a parameter.
    fn word(&mut self) -> Result<Differentiated, Wrong> {
        let is_number = self
            .rest
            .starts_with(|c: char| c.is_ascii_digit() || c == '.');
        let mut before = ' ';
        let end = self.rest.find(|c: char| {
            // The exponent of a number has a sign.
            let exponent = is_number && matches!(before, 'e' | 'E') && matches!(c, '+' | '-');
            before = c;
            !(c.is_alphanumeric() || c == '.' || c == '_' || exponent)
        });
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.trim_start();
        let mut gradient = vec![0.0; self.estimates.len()];
        if is_number {
            let value = word.parse();
            let value = value.map_err(|_| (format!("`{word}` is not a number"), None))?;
            return Ok(Differentiated { value, gradient });
        }
        let names = || self.estimates.iter().map(|estimate| estimate.name.as_str());
        let Some(place) = names().position(|name| name == word) else {
            let help = match nearest(word, names()) {
                Some(near) => format!("did you mean {near}?"),
                None => format!(
                    "the parameters are {}",
                    names().collect::<Vec<_>>().join(", ")
                ),
            };
            return Err((
                format!("`{word}` is not a parameter of the fit"),
                Some(help),
            ));
        };
        gradient[place] = 1.0;
        let estimate = &self.estimates[place];
        let unloaded = || estimate.parameter.unloaded_words();
        let value = estimate.known_value();
        let value = value.ok_or_else(|| (format!("{word} has no value: {}", unloaded()), None))?;
        Ok(Differentiated { value, gradient })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::ModelParameter;

    fn estimate(name: &str, value: f64, status: FactorStatus) -> FactorEstimate {
        FactorEstimate {
            parameter: ModelParameter::try_from(name.to_owned()).unwrap(),
            name: name.to_owned(),
            start: 1.0,
            value,
            interval_95: None,
            islands_95: Vec::new(),
            bounds: None,
            standard_uncertainty: None,
            quadratic_interval_95: None,
            bootstrap_interval_95: None,
            status,
        }
    }

    fn fitted() -> (Vec<FactorEstimate>, FactorCorrelations) {
        let tied = FactorStatus::Tied {
            to: "beam.Iy".to_owned(),
        };
        let estimates = vec![
            estimate("beam.Iy", 0.5, FactorStatus::Free),
            estimate("beam.Iz", 2.0, FactorStatus::Free),
            estimate("beam.J", 3.0, FactorStatus::Fixed),
            estimate("link.Iy", 1.5, tied),
            estimate("joint.J2", 4e-6, FactorStatus::Free),
        ];
        let names = ["beam.Iy", "beam.Iz", "joint.J2"].map(str::to_owned);
        let u = [0.03, 0.05, 2e-7];
        let matrix = [[1.0, 0.6, -0.2], [0.6, 1.0, 0.1], [-0.2, 0.1, 1.0]];
        let row = |i: usize| (0..3).map(|j| matrix[i][j] * u[i] * u[j]).collect();
        let correlation = FactorCorrelations {
            names: names.to_vec(),
            matrix: matrix.map(|row| row.to_vec()).to_vec(),
            u_ln: u.to_vec(),
            covariance: (0..3).map(row).collect(),
            dof: Some(8.0),
        };
        (estimates, correlation)
    }

    fn of(expression: &str) -> Result<DerivedQuantity, ArgumentError> {
        let (estimates, correlation) = fitted();
        let asked = [format!("q={expression}")];
        derive(&asked, &estimates, Some(&correlation)).map(|mut found| found.remove(0))
    }

    #[test]
    fn uncertainties_are_those_of_the_closed_forms() {
        let near = |expression: &str, value: f64, se: f64| {
            let found = of(expression).unwrap();
            assert!(
                (found.value - value).abs() < 1e-12 * value.abs(),
                "{found:?}"
            );
            assert!(
                (found.se.unwrap() - se).abs() < 1e-12 * value.abs(),
                "{found:?}"
            );
            // Student's t with 8 degrees of freedom: 2.306004 (scipy.stats.t.ppf(0.975, 8)).
            let [low, high] = found.ci95.unwrap();
            assert!((high - low - 2.0 * 2.306_004_135 * se).abs() < 1e-8 * value.abs());
        };
        // var ln(a/b) = u_a^2 + u_b^2 - 2 rho u_a u_b.
        let (a, b, rho) = (0.03_f64, 0.05_f64, 0.6);
        let ratio = (a * a + b * b - 2.0 * rho * a * b).sqrt();
        near("beam.Iy/beam.Iz", 0.25, 0.25 * ratio);
        near("1 / joint.J2", 2.5e5, 2.5e5 * 0.05);
        // A fixed factor adds nothing, a tied one moves with the other: 0.5 + 1.5 + 3.
        near("beam.Iy + (link.Iy - -beam.J)", 5.0, 2.0 * a);
        near("2.5e-1*beam.Iz", 0.5, 0.5 * b);
        near(
            "beam.Iy - beam.Iz",
            -1.5,
            ((0.5 * a).powi(2) + (2.0 * b).powi(2) - 2.0 * rho * 0.5 * a * 2.0 * b).sqrt(),
        );
    }

    #[test]
    fn what_is_no_expression_is_refused() {
        for (expression, part) in [
            ("beam.Iv", "did you mean beam.I"),
            ("beam.Iy/0", "no finite value"),
            ("(beam.Iy", "not closed"),
            ("beam.Iy)", "`)` was not expected"),
            ("beam.Iy 2", "`2` was not expected"),
            ("1.2.3", "is not a number"),
            ("", "NAME=EXPRESSION"),
            ("1+", "is not a parameter"),
        ] {
            let error = of(expression).unwrap_err();
            let text = format!("{error} {}", error.help.as_deref().unwrap_or_default());
            assert!(text.contains(part), "{expression}: {text}");
        }
        assert!(of(&"(".repeat(100_000)).is_err());
        assert!(of(&"-".repeat(100_000)).is_err());
    }

    #[test]
    fn without_an_uncertainty_of_a_parameter_there_is_none() {
        let (mut estimates, correlation) = fitted();
        let derived = |estimates: &[FactorEstimate]| {
            let asked = ["q=beam.Iz*beam.J".to_owned()];
            derive(&asked, estimates, Some(&correlation))
                .unwrap()
                .remove(0)
        };
        let words = String::new();
        estimates[2].status = FactorStatus::NotIdentified {
            words: words.clone(),
        };
        let open = derived(&estimates);
        assert_eq!((open.se, open.ci95), (None, None));
        assert_eq!(
            open.words.as_deref(),
            Some("the data give beam.J no uncertainty")
        );
        estimates[2].status = FactorStatus::AtBound { upper: true, words };
        let bound = derived(&estimates);
        assert!((bound.se.unwrap() - 6.0 * 0.05).abs() < 1e-12);
        assert_eq!(
            bound.words.as_deref(),
            Some("beam.J is at its bound and taken as exact")
        );
    }
}
