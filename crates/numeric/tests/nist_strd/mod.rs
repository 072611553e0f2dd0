//! Least squares against NIST's certified problems: at least 8 correct digits in parameters and standard deviations.
//!
//! NIST gives eleven digits, two starts for each of the 27 nonlinear problems (one far, one near), and fifteen digits for the
//! linear ones. The number of correct digits is NIST's own measure, the log relative error −log10(|q − c|/|c|).

mod dat_file;
mod extended;
mod models;

use dat_file::Certified;
use extended::{GENERATING, Lanczos1InOffsets};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use models::{Model, PROBLEMS};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use stiffbench_numeric::least_squares::{
    Bound, CovarianceSettings, EvaluationFailure, JacobianView, LeastSquaresFit,
    LeastSquaresSettings, Parameter, ParameterCovariance, ParameterSet, ParameterStatus,
    ProfileSettings, ResidualFunction, SigmaMode, check_derivatives, covariance, minimise, profile,
    rise_at_95,
};

/// Correct digits asked for.
const DIGITS: f64 = 8.0;

/// Certified digits, beyond which nothing can be said.
const CERTIFIED_DIGITS: f64 = 11.0;

struct Nist {
    name: &'static str,
    model: Model,
    certified: Certified,
}

impl Nist {
    fn all() -> impl Iterator<Item = Self> {
        PROBLEMS
            .into_iter()
            .map(|(name, model)| Self::read(name, model))
    }

    fn named(name: &str) -> Self {
        Self::all().find(|problem| problem.name == name).unwrap()
    }

    fn read(name: &'static str, model: Model) -> Self {
        let certified = dat_file::read(name);
        Self {
            name,
            model,
            certified,
        }
    }

    /// A residual at a point, with its derivatives.
    fn residual(&self, i: usize, b: &[f64], derivatives: &mut [f64; 9]) -> f64 {
        let (y, x) = self.certified.observations[i];
        let response = if self.name == "Nelson" { y.ln() } else { y };
        (self.model)(x, b, derivatives) - response
    }

    fn solve(&mut self, start: usize) -> (LeastSquaresFit, ParameterCovariance) {
        let set = unbounded(&self.certified.starts[start]);
        solve(self, &set)
    }
}

impl ResidualFunction for Nist {
    fn residual_count(&self) -> usize {
        self.certified.observations.len()
    }

    fn evaluate(
        &mut self,
        b: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let mut derivatives = [0.0; 9];
        for (i, residual) in residuals.iter_mut().enumerate() {
            *residual = self.residual(i, b, &mut derivatives);
            if let Some(jacobian) = jacobian.as_deref_mut() {
                for (j, &derivative) in derivatives[..b.len()].iter().enumerate() {
                    jacobian.set(i, j, derivative);
                }
            }
        }
        Ok(())
    }
}

/// All parameters free and without bounds.
fn unbounded(start: &[f64]) -> ParameterSet {
    let parameters = start.iter().enumerate();
    let parameters =
        parameters.map(|(j, &value)| Parameter::unbounded(format!("b{}", j + 1), value));
    ParameterSet::new(parameters.collect()).unwrap()
}

fn solve(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
) -> (LeastSquaresFit, ParameterCovariance) {
    let fit = minimise(problem, set, &LeastSquaresSettings::default()).unwrap();
    let settings = CovarianceSettings::default();
    let covariance = covariance(set, &fit, SigmaMode::Estimated, &settings).unwrap();
    (fit, covariance)
}

fn digits(found: f64, certified: f64) -> f64 {
    let relative = ((found - certified) / certified).abs();
    // NaN has no correct digit and must not pass as the larger of two.
    if relative.is_nan() {
        0.0
    } else {
        (-relative.log10()).min(CERTIFIED_DIGITS)
    }
}

fn fewest_digits(found: impl IntoIterator<Item = f64>, certified: &[f64]) -> f64 {
    let pairs = found.into_iter().zip(certified);
    pairs
        .map(|(found, &certified)| digits(found, certified))
        .fold(CERTIFIED_DIGITS, f64::min)
}

fn standard_errors(covariance: &ParameterCovariance) -> Vec<f64> {
    let estimates = covariance.estimates.iter();
    estimates
        .map(|e| e.standard_error.unwrap_or(f64::NAN))
        .collect()
}

#[test]
fn all_27_nonlinear_problems_from_both_starts_to_8_digits() {
    println!("problem    start  parameters  standard deviations  sum of squares  evaluations  end");
    let mut short = Vec::new();
    for mut problem in Nist::all() {
        for start in [0, 1] {
            let (fit, covariance) = problem.solve(start);
            let certified = &problem.certified;
            let parameters = fewest_digits(fit.values.iter().copied(), &certified.parameters);
            let errors =
                fewest_digits(standard_errors(&covariance), &certified.standard_deviations);
            let squares = digits(fit.sum_of_squares(), certified.residual_sum_of_squares);
            println!(
                "{:10} {:5}  {parameters:10.1}  {errors:19.1}  {squares:14.1}  {:11}  {:?}",
                problem.name,
                start + 1,
                fit.evaluations,
                fit.termination
            );
            assert!(
                fit.termination.is_converged(),
                "{} {:?}",
                problem.name,
                fit.termination
            );
            // The residuals of Lanczos1 have three digits in `f64`: see the two tests below.
            let errors = if problem.name == "Lanczos1" {
                DIGITS
            } else {
                errors
            };
            if parameters < DIGITS || errors < DIGITS {
                short.push((problem.name, start + 1));
            }
        }
    }
    assert!(short.is_empty(), "fewer than {DIGITS} digits: {short:?}");
}

#[test]
fn lanczos1_has_its_covariance_right_up_to_the_common_factor_that_rounding_hides() {
    for start in [0, 1] {
        let mut problem = Nist::named("Lanczos1");
        let (_, covariance) = problem.solve(start);
        let certified = &problem.certified;
        let spread = covariance.reduced_chi_squared.unwrap().sqrt();
        let shapes = standard_errors(&covariance)
            .into_iter()
            .map(|error| error / spread);
        let deviations = certified.standard_deviations.iter();
        let expected: Vec<f64> = deviations
            .map(|sd| sd / certified.residual_standard_deviation)
            .collect();
        assert!(fewest_digits(shapes, &expected) >= DIGITS);
        // The factor itself has about as many digits as a residual of 1e-13 beside a rounding of 1e-16.
        assert!(digits(spread, certified.residual_standard_deviation) >= 2.0);
    }
}

#[test]
fn lanczos1_in_offsets_from_its_generating_values_has_8_digits_in_everything() {
    let certified = Nist::named("Lanczos1").certified;
    for start in &certified.starts {
        let mut problem = Lanczos1InOffsets::new(&certified.observations);
        let offsets = start.iter().zip(GENERATING).enumerate();
        let offsets = offsets.map(|(j, (b, g))| Parameter::unbounded(format!("b{}", j + 1), b - g));
        let (fit, covariance) = solve(&mut problem, &ParameterSet::new(offsets.collect()).unwrap());
        let values = fit
            .values
            .iter()
            .zip(GENERATING)
            .map(|(offset, g)| g + offset);
        assert!(fewest_digits(values, &certified.parameters) >= DIGITS);
        assert!(
            fewest_digits(standard_errors(&covariance), &certified.standard_deviations) >= DIGITS
        );
        assert!(digits(fit.sum_of_squares(), certified.residual_sum_of_squares) >= DIGITS);
    }
}

#[test]
fn the_derivatives_of_the_27_models_are_those_of_differences() {
    for mut problem in Nist::all() {
        let parameters = problem.certified.parameters.clone();
        let worst = check_derivatives(&mut problem, &parameters, 1.0)
            .unwrap()
            .unwrap();
        // Eckerle4's peak is narrower than the step in its place; everything else agrees to 1e-8.
        let limit = if problem.name == "Eckerle4" {
            1e-5
        } else {
            1e-8
        };
        assert!(
            worst.relative_difference < limit,
            "{}: {worst:?}",
            problem.name
        );
    }
}

/// Residuals A b − y.
struct Linear {
    rows: Vec<Vec<f64>>,
    y: Vec<f64>,
}

impl ResidualFunction for Linear {
    fn residual_count(&self) -> usize {
        self.y.len()
    }

    fn evaluate(
        &mut self,
        b: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        for (i, row) in self.rows.iter().enumerate() {
            residuals[i] = row.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() - self.y[i];
            if let Some(jacobian) = jacobian.as_deref_mut() {
                for (j, &a) in row.iter().enumerate() {
                    jacobian.set(i, j, a);
                }
            }
        }
        Ok(())
    }
}

/// The row of the matrix that belongs to the predictors of an observation.
type Row = fn(&[f64]) -> Vec<f64>;

const LINEAR: [(&str, Row); 3] = [
    ("Norris", |x| vec![1.0, x[0]]),
    ("Pontius", |x| vec![1.0, x[0], x[0] * x[0]]),
    ("Longley", |x| [&[1.0], x].concat()),
];

#[test]
fn the_linear_problems_to_8_digits() {
    for (name, row) in LINEAR {
        let (certified, data) = dat_file::read_linear(name);
        let y = data.iter().map(|line| line[0]).collect();
        let rows: Vec<Vec<f64>> = data.iter().map(|line| row(&line[1..])).collect();
        let parameters = (0..certified.len()).map(|j| Parameter::unbounded(format!("B{j}"), 0.0));
        let set = ParameterSet::new(parameters.collect()).unwrap();
        let (fit, covariance) = solve(&mut Linear { rows, y }, &set);
        let (estimates, deviations): (Vec<f64>, Vec<f64>) = certified.into_iter().unzip();
        let found = fewest_digits(fit.values, &estimates);
        let errors = fewest_digits(standard_errors(&covariance), &deviations);
        println!(
            "{name}: {found:.1} {errors:.1}, condition {:.1e}",
            covariance.condition_number
        );
        assert!(
            found >= DIGITS && errors >= DIGITS,
            "{name}: {found} {errors}"
        );
    }
}

#[test]
fn with_the_solution_beyond_a_bound_the_others_are_those_of_the_fixed_fit() {
    for mut problem in Nist::all() {
        for place in [0, problem.certified.parameters.len() - 1] {
            let best = problem.certified.parameters.clone();
            let limit = best[place] - problem.certified.standard_deviations[place];
            let start = limit - 1e-3 * limit.abs();
            let mut parameters = unbounded(&best).parameters().to_vec();

            parameters[place] = Parameter::free("bounded", start, f64::NEG_INFINITY, limit);
            let set = ParameterSet::new(parameters.clone()).unwrap();
            let (bounded, covariance) = solve(&mut problem, &set);
            let status = covariance.estimates[place].status;
            assert_eq!(
                status,
                ParameterStatus::AtBound(Bound::Upper),
                "{}",
                problem.name
            );

            parameters[place] = Parameter::fixed("bounded", limit);
            let set = ParameterSet::new(parameters).unwrap();
            let (fixed, fixed_covariance) = solve(&mut problem, &set);
            let values = fewest_digits(bounded.values, &fixed.values);
            assert!(values >= DIGITS, "{} {place}: {values}", problem.name);
            for (bounded, fixed) in covariance.estimates.iter().zip(&fixed_covariance.estimates) {
                match (bounded.standard_error, fixed.standard_error) {
                    // The spread of Lanczos1 is rounding, see above.
                    (Some(_), Some(_)) if problem.name == "Lanczos1" => {}
                    (Some(bounded), Some(fixed)) => {
                        let found = digits(bounded, fixed);
                        assert!(found >= DIGITS, "{} {place}: {found}", problem.name);
                    }
                    pair => assert_eq!(pair, (None, None), "{}", problem.name),
                }
            }
        }
    }
}

/// The same problems through the MINPACK port `levenberg-marquardt`.
struct Theirs {
    ours: Nist,
    point: DVector<f64>,
}

impl Theirs {
    fn evaluated(&self) -> (DVector<f64>, DMatrix<f64>) {
        let count = self.ours.residual_count();
        let mut residuals = DVector::zeros(count);
        let mut jacobian = DMatrix::zeros(count, self.point.len());
        let mut derivatives = [0.0; 9];
        for i in 0..count {
            residuals[i] = self
                .ours
                .residual(i, self.point.as_slice(), &mut derivatives);
            for j in 0..self.point.len() {
                jacobian[(i, j)] = derivatives[j];
            }
        }
        (residuals, jacobian)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Theirs {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, point: &DVector<f64>) {
        self.point.copy_from(point);
    }

    fn params(&self) -> DVector<f64> {
        self.point.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.evaluated().0)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.evaluated().1)
    }
}

#[test]
fn the_port_of_minpack_finds_the_same_minima() {
    let mut compared = 0;
    for mut ours in Nist::all() {
        let (fit, _) = ours.solve(1);
        let point = DVector::from_column_slice(&ours.certified.starts[1]);
        let solver = LevenbergMarquardt::new().with_patience(1000);
        let (theirs, report) = solver.minimize(Theirs { ours, point });
        let their_sum = 2.0 * report.objective_function;
        // Sums of squares of Lanczos1 differ by rounding alone.
        let tolerance = if theirs.ours.name == "Lanczos1" {
            0.1
        } else {
            1e-8
        };
        assert!(
            fit.sum_of_squares() <= their_sum * (1.0 + tolerance),
            "{}",
            theirs.ours.name
        );
        if report.termination.was_successful() {
            compared += 1;
            let agreement = fewest_digits(fit.values, theirs.point.as_slice());
            // Its tolerance on the objective, 30 epsilons, leaves about half the digits of the parameters.
            assert!(agreement >= 6.0, "{}: {agreement}", theirs.ours.name);
        }
    }
    assert!(compared >= 20, "{compared}");
}

#[test]
fn profile_intervals_are_those_of_lmfit() {
    let path = stiffbench_test_files::repository().join("fixtures/profile-lmfit/intervals.csv");
    let table = std::fs::read_to_string(path).unwrap();
    let mut checked = 0;
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let mut problem = Nist::named(cells[0]);
        let parameter = cells[1][1..].parse::<usize>().unwrap() - 1;
        let set = unbounded(&problem.certified.parameters);
        let (fit, covariance) = solve(&mut problem, &set);
        let settings = ProfileSettings::default();
        let rise = rise_at_95(&fit, &covariance).unwrap();
        let found = profile(&mut problem, &set, &fit, parameter, rise, &settings).unwrap();
        for (end, expected) in [(&found.lower, cells[2]), (&found.upper, cells[3])] {
            let expected: f64 = expected.parse().unwrap();
            let share = end.closed().map_or(f64::NAN, |end| {
                (end - expected) / (expected - found.estimate)
            });
            // lmfit stops within about 1e-4 of an end, and so do we.
            assert!(share.abs() < 5e-4, "{line}: {end:?} differs by {share:.1e}");
            checked += 1;
        }
    }
    assert_eq!(checked, 44);
}
