//! Compliances of cells: those that the readings show, beside those of the baseline with one more spring, or of another structure.

use super::misread::{MisreadValues, NamedValue, ValueFit, ValueName, ValueScale};
use crate::mismatch::baselines::{Baseline, PoseSolver, start};
use crate::mismatch::error::MismatchError;
use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresSettings, Parameter, ParameterSet,
    ResidualFunction, minimise,
};

/// What a single mistake of the model may be.
enum SuspectOfCells {
    Spring(Spring),
    /// Another structure, by its number.
    Structure(usize),
}

/// A spring somewhere: in a joint, under the base, in the stand of the gauge.
struct Spring {
    /// For each cell what a unit of it adds, and the stiffness against its turning.
    adds: Vec<[f64; 2]>,
    /// Logarithm of the compliance at which it adds as much as the structure has, in the middle of the cells.
    log_unit: f64,
}

/// Standard deviation of the logarithm of the compliance of a spring beforehand (1): a factor of ten. Any wide one does: it keeps a fit from
/// wandering where nothing depends on it.
const LOG_SPRING_SD: f64 = std::f64::consts::LN_10;

/// Starts of a spring, in its unit.
const SPRING_STARTS: [f64; 2] = [0.1, 2.0];

/// Widest range of a spring, as a factor of its unit.
const WIDEST: f64 = 1e4;

/// How far beyond its bounds a factor may go, in its logarithm: a hundred times.
const BEYOND_BOUNDS: f64 = 4.6;

/// Compliances of cells, their logarithms in m/N, with the baseline as a model of them.
pub(crate) struct CellCompliances<'a> {
    baseline: &'a dyn Baseline,
    solver: Box<dyn PoseSolver + 'a>,
    /// Poses among those of the baseline; components are directions of loads.
    cells: Vec<ValueName>,
    logs: Vec<NamedValue>,
    suspects: Vec<SuspectOfCells>,
}

impl<'a> CellCompliances<'a> {
    /// # Errors
    /// [`MismatchError`] if the structure cannot be solved at the start of the fit.
    pub(crate) fn new(
        baseline: &'a dyn Baseline,
        cells: Vec<ValueName>,
        logs: Vec<NamedValue>,
    ) -> Result<Self, MismatchError> {
        let mut solver = baseline.solver(0)?;
        solver.solve(&start(baseline))?;
        let pose = |cell: &ValueName| solver.pose(cell.pose);
        let mut springs: Vec<Vec<[f64; 2]>> = Vec::new();
        for joint in 0..baseline.joints().len() {
            let of_cell = |cell: &ValueName| {
                let influence = &pose(cell).influence;
                let lever_m = influence.levers[joint][cell.component];
                [lever_m * lever_m, influence.stiffness(joint, joint)]
            };
            springs.push(cells.iter().map(of_cell).collect());
        }
        for axis in 0..3 {
            let of_cell = |cell: &ValueName| {
                let lever_m = pose(cell).base_levers[axis][cell.component];
                [lever_m * lever_m, 0.0]
            };
            springs.push(cells.iter().map(of_cell).collect());
        }
        for direction in 0..3 {
            let is_here =
                |cell: &ValueName| [f64::from(u8::from(cell.component == direction)), 0.0];
            springs.push(cells.iter().map(is_here).collect());
        }
        let own = |cell: &ValueName| {
            let axis = cell.component;
            pose(cell).influence.compliance[axis][axis]
        };
        let own: Vec<f64> = cells.iter().map(own).collect();
        let springs = springs.into_iter().filter_map(|adds| {
            let felt = adds.iter().zip(&own).filter(|([lever, _], _)| *lever > 0.0);
            let mut units: Vec<f64> = felt.map(|([lever, _], own)| (own / lever).ln()).collect();
            let log_unit = stiffbench_numeric::statistics::median(&mut units)?;
            Some(SuspectOfCells::Spring(Spring { adds, log_unit }))
        });
        let mut suspects: Vec<SuspectOfCells> = springs.collect();
        let others = baseline.other_structures();
        let variants = others
            .iter()
            .filter_map(|effect| baseline.variant(std::slice::from_ref(effect)));
        suspects.extend(variants.map(SuspectOfCells::Structure));
        Ok(Self {
            baseline,
            solver,
            cells,
            logs,
            suspects,
        })
    }
}

impl MisreadValues for CellCompliances<'_> {
    fn names(&self) -> &[ValueName] {
        &self.cells
    }

    fn values(&self) -> &[NamedValue] {
        &self.logs
    }

    fn scale(&self) -> ValueScale {
        ValueScale::Logarithmic
    }

    fn fewest(&self) -> usize {
        1
    }

    fn free(&self) -> usize {
        self.baseline.parameters().len()
    }

    fn alternatives(&self) -> usize {
        self.suspects.len()
    }

    fn least_variance(&self) -> f64 {
        1.0
    }

    fn fit(
        &mut self,
        logs: &[NamedValue],
        keep: &dyn Fn(usize) -> bool,
        suspect: Option<usize>,
        start: Option<&ValueFit>,
    ) -> Option<ValueFit> {
        let mut other;
        let mut spring = None;
        let solver: &mut dyn PoseSolver = match suspect.map(|one| &self.suspects[one]) {
            Some(SuspectOfCells::Structure(variant)) => {
                other = self.baseline.solver(*variant).ok()?;
                &mut *other
            }
            Some(SuspectOfCells::Spring(one)) => {
                spring = Some(one);
                &mut *self.solver
            }
            None => &mut *self.solver,
        };
        let own = self.baseline.parameters();
        let weights: Vec<f64> = logs
            .iter()
            .enumerate()
            .map(|(place, one)| if keep(place) { one.u.recip() } else { 0.0 })
            .collect();
        let begin = own.iter().enumerate().map(|(place, parameter)| {
            let value = start.map_or(parameter.start, |start| start.parameters[place]);
            // The factor that a fit starts from, and its bounds with it, may be what is wrong.
            let beyond = if parameter.spring_rad_per_nm.is_some() {
                0.0
            } else {
                BEYOND_BOUNDS
            };
            let (lower, upper) = (parameter.lower - beyond, parameter.upper + beyond);
            Parameter::free(&parameter.name, value.clamp(lower, upper), lower, upper)
        });
        let begin: Vec<Parameter> = begin.collect();
        let starts = if spring.is_some() {
            &SPRING_STARTS[..]
        } else {
            &[1.0]
        };
        let settings = LeastSquaresSettings {
            max_evaluations: 60,
            ..LeastSquaresSettings::for_refits()
        };
        let fits = starts.iter().filter_map(|times| {
            let mut parameters = begin.clone();
            parameters.extend(spring.map(|_| {
                let widest = WIDEST.ln();
                Parameter::free("spring", times.ln(), -widest, widest)
            }));
            let set = ParameterSet::new(parameters).ok()?;
            let mut problem = CompliancesOfCells {
                baseline: self.baseline,
                solver: &mut *solver,
                cells: &self.cells,
                logs,
                weights: &weights,
                spring,
                predicted: vec![0.0; logs.len()],
            };
            let fit = minimise(&mut problem, &set, &settings).ok()?;
            // The logarithms of the end: the last evaluation may have been a step that was not taken.
            let mut residuals = vec![0.0; problem.residual_count()];
            problem.evaluate(&fit.values, &mut residuals, None).ok()?;
            let columns = (0..set.free_indices().len()).filter_map(|one| fit.jacobian_column(one));
            Some(ValueFit {
                squares: fit.sum_of_squares(),
                columns: columns.map(<[f64]>::to_vec).collect(),
                predicted: problem.predicted,
                parameters: fit.values,
            })
        });
        fits.min_by(|a, b| a.squares.total_cmp(&b.squares))
    }
}

struct CompliancesOfCells<'a> {
    baseline: &'a dyn Baseline,
    solver: &'a mut dyn PoseSolver,
    cells: &'a [ValueName],
    logs: &'a [NamedValue],
    weights: &'a [f64],
    spring: Option<&'a Spring>,
    /// Logarithms of the last evaluation.
    predicted: Vec<f64>,
}

/// A structure yields against its load.
#[derive(Debug, thiserror::Error)]
#[error("a compliance is not positive")]
struct NotPositive;

impl ResidualFunction for CompliancesOfCells<'_> {
    fn residual_count(&self) -> usize {
        self.cells.len() + self.baseline.parameters().len() + usize::from(self.spring.is_some())
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        mut jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let known = self.baseline.parameters();
        let (own, of_spring) = parameters.split_at(known.len());
        self.solver
            .solve_for(own, &[])
            .map_err(EvaluationFailure::of_model)?;
        for (place, cell) in self.cells.iter().enumerate() {
            let axis = cell.component;
            let pose = self.solver.pose(cell.pose);
            let mut compliance = pose.influence.compliance[axis][axis];
            let mut by_spring = 0.0;
            if let (Some(spring), [log]) = (self.spring, of_spring) {
                // A twist c τ, with τ = m F - k c τ: what a spring adds in a closed loop is bounded.
                let [square, stiffness] = spring.adds[place];
                let c = (spring.log_unit + log).exp();
                let eased = 1.0 + stiffness * c;
                compliance += square * c / eased;
                by_spring = square * c / (eased * eased);
            }
            if compliance.is_nan() || compliance <= 0.0 {
                return Err(EvaluationFailure::of_model(NotPositive));
            }
            let weight = self.weights[place];
            self.predicted[place] = compliance.ln();
            residuals[place] = weight * (self.predicted[place] - self.logs[place].value);
            if let Some(jacobian) = jacobian.as_deref_mut() {
                for (parameter, gradient) in pose.gradient.iter().enumerate() {
                    jacobian.set(place, parameter, weight * gradient[axis][axis] / compliance);
                }
                jacobian.set(place, known.len(), weight * by_spring / compliance);
            }
        }
        let n = self.cells.len();
        for (place, (parameter, value)) in known.iter().zip(own).enumerate() {
            residuals[n + place] = (value - parameter.start) / parameter.prior_sd;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                jacobian.set(n + place, place, parameter.prior_sd.recip());
            }
        }
        if let [log] = of_spring {
            residuals[n + known.len()] = log / LOG_SPRING_SD;
            if let Some(jacobian) = jacobian {
                jacobian.set(n + known.len(), known.len(), LOG_SPRING_SD.recip());
            }
        }
        Ok(())
    }
}
