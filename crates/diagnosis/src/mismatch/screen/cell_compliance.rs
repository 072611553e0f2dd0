//! Compliances of cells: those that the readings show, beside those of the baseline with one more spring, or of another structure. Along their loads
//! they are compared by their logarithms; across them a compliance has either sign, and is compared as it is.

use super::misread::{NamedValue, ValueFit, ValueModel, ValueScale};
use crate::mismatch::baselines::{Baseline, PoseSolver, start};
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::ObservedCell;
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

/// Compliances of cells with the baseline as a model of them.
pub(crate) struct CellCompliances<'a> {
    baseline: &'a dyn Baseline,
    solver: Box<dyn PoseSolver + 'a>,
    cells: Vec<&'a ObservedCell>,
    scale: ValueScale,
    suspects: Vec<SuspectOfCells>,
}

impl<'a> CellCompliances<'a> {
    /// # Arguments
    /// - `scale`: of the values; across loads it is [`ValueScale::Linear`].
    ///
    /// # Errors
    /// [`MismatchError`] if the structure cannot be solved at the start of the fit.
    pub(crate) fn new(
        baseline: &'a dyn Baseline,
        cells: Vec<&'a ObservedCell>,
        scale: ValueScale,
    ) -> Result<Self, MismatchError> {
        let mut solver = baseline.solver(0)?;
        if scale == ValueScale::Linear {
            solver.differentiate_whole()?;
        }
        solver.solve(&start(baseline))?;
        let pose = |cell: &ObservedCell| solver.pose(cell.pose);
        let mut springs: Vec<Vec<[f64; 2]>> = Vec::new();
        for joint in 0..baseline.joints().len() {
            let of_cell = |cell: &&ObservedCell| {
                let influence = &pose(cell).influence;
                let lever = influence.levers[joint];
                [cell.lever_product(lever), influence.stiffness(joint, joint)]
            };
            springs.push(cells.iter().map(of_cell).collect());
        }
        for axis in 0..3 {
            let of_cell =
                |cell: &&ObservedCell| [cell.lever_product(pose(cell).base_levers[axis]), 0.0];
            springs.push(cells.iter().map(of_cell).collect());
        }
        for direction in 0..3 {
            let is_here =
                |cell: &ObservedCell| cell.is_along_load() && cell.axis().index() == direction;
            let of_cell = |cell: &&ObservedCell| [f64::from(u8::from(is_here(cell))), 0.0];
            springs.push(cells.iter().map(of_cell).collect());
        }
        let own: Vec<f64> = cells
            .iter()
            .map(|cell| cell.compliance(pose(cell)))
            .collect();
        let springs = springs.into_iter().filter_map(|adds| {
            let felt = adds
                .iter()
                .zip(&own)
                .filter(|([lever, _], _)| *lever != 0.0);
            let units = felt.map(|([lever, _], own)| (own / lever).abs().ln());
            let mut units: Vec<f64> = units.filter(|log| log.is_finite()).collect();
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
            scale,
            suspects,
        })
    }
}

impl ValueModel for CellCompliances<'_> {
    fn free(&self) -> usize {
        self.baseline.parameters().len()
    }

    fn alternatives(&self) -> usize {
        self.suspects.len()
    }

    fn may_be_drawn(&self, _read: &[NamedValue], _as_recorded: &ValueFit) -> bool {
        true
    }

    fn fit(
        &mut self,
        values: &[NamedValue],
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
        let weights: Vec<f64> = values
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
                scale: self.scale,
                values,
                weights: &weights,
                spring,
                predicted: vec![0.0; values.len()],
            };
            let fit = minimise(&mut problem, &set, &settings).ok()?;
            // The compliances of the end: the last evaluation may have been a step that was not taken.
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
    cells: &'a [&'a ObservedCell],
    scale: ValueScale,
    values: &'a [NamedValue],
    weights: &'a [f64],
    spring: Option<&'a Spring>,
    /// By the last evaluation.
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
            let pose = self.solver.pose(cell.pose);
            let mut compliance = cell.compliance(pose);
            let mut by_spring = 0.0;
            if let (Some(spring), [log]) = (self.spring, of_spring) {
                // A twist c τ, with τ = m F - k c τ: what a spring adds in a closed loop is bounded.
                let [product, stiffness] = spring.adds[place];
                let c = (spring.log_unit + log).exp();
                let eased = 1.0 + stiffness * c;
                compliance += product * c / eased;
                by_spring = product * c / (eased * eased);
            }
            let (value, slope) = match self.scale {
                ValueScale::Linear => (compliance, 1.0),
                ValueScale::Logarithmic if compliance > 0.0 => {
                    (compliance.ln(), compliance.recip())
                }
                ValueScale::Logarithmic => return Err(EvaluationFailure::of_model(NotPositive)),
            };
            let weight = self.weights[place];
            self.predicted[place] = value;
            residuals[place] = weight * (value - self.values[place].value);
            if let Some(jacobian) = jacobian.as_deref_mut() {
                for parameter in 0..known.len() {
                    let gradient = pose.gradient(parameter, &cell.read, &cell.load);
                    jacobian.set(place, parameter, weight * slope * gradient);
                }
                jacobian.set(place, known.len(), weight * slope * by_spring);
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
