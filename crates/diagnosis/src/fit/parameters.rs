//! The list of parameters as coordinates of a least-squares fit.
//!
//! A factor is searched for by the logarithm of its ratio to the start: twice and half are equally far from one, and none can become
//! negative. A spring is searched for by its compliance, which may be zero, in units of the compliance that would add as much as the whole
//! robot gives.

use stiffbench_beams::physics::PlaceScale;
use stiffbench_beams::robot::{FittingFactors, ModelParameter};
use stiffbench_numeric::least_squares::{LeastSquaresError, Parameter, ParameterSet};
use stiffbench_units_and_text::test_point::Cell;

use crate::parameters::{FIRST_SPRING, FitRole, ParameterChoice, ScaleCell, SpringScales};

use super::error::FitError;
use super::outcome::{FactorEstimate, FactorStatus};
use super::problem::{FitProblem, poses_of_cells};
use super::shares::Shares;

/// A derivative of ln K below this shows on no bench: ten times the parameter changes the stiffness by two millionths.
const NO_EFFECT: f64 = 1e-6;

/// The parameters of one fit.
#[derive(Debug, Clone)]
pub(crate) struct FitParameters {
    start: FittingFactors,
    members: Vec<FitMember>,
    parameters: Vec<ModelParameter>,
}

#[derive(Debug, Clone)]
struct FitMember {
    name: String,
    role: Role,
    start: f64,
    /// Compliance of a spring at the coordinate one, rad/(N·m); `None` for a factor.
    scale_rad_per_nm: Option<f64>,
    /// Bounds of the coordinate.
    bounds: [f64; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    Free,
    Fixed,
    /// Free, but no cell depends on it: it keeps its start.
    NoEffect,
    /// At the same coordinate as another.
    Tied {
        to: usize,
    },
}

impl FitParameters {
    /// Puts the chosen parameters, and springs and sections that only the start names, in the coordinates of a fit.
    ///
    /// # Errors
    /// [`FitError::Robot`] for a pose or structure, [`FitError::Bounds`], [`FitError::Tie`].
    pub(super) fn new(
        problem: &FitProblem<'_>,
        choice: &ParameterChoice,
    ) -> Result<Self, FitError> {
        let free_springs = choice
            .members
            .iter()
            .any(|member| member.role == FitRole::Free && !member.parameter.is_factor());
        let scales = if free_springs {
            let mut parameters = choice.parameters();
            parameters.extend(problem.start.springs());
            Some(spring_scales(problem, &parameters)?)
        } else {
            None
        };
        let scale = |parameter: &ModelParameter| {
            let scales = scales.as_ref();
            scales.map_or_else(PlaceScale::default, |scales| scales.of(parameter))
        };
        let mut parameters = Self::with_scales(problem.start, choice, &scale)?;
        parameters.keep_what_has_no_effect(problem)?;
        Ok(parameters)
    }

    /// Keeps what no cell depends on at its start, where rounding would else push it to a bound. Derivatives of physics beside the beams are
    /// differences, which are too coarse to show that.
    fn keep_what_has_no_effect(&mut self, problem: &FitProblem<'_>) -> Result<(), FitError> {
        if problem.physics.is_some() {
            return Ok(());
        }
        let mut model = problem.measured_model(&self.parameters)?;
        let mut shares = vec![Shares::new(); problem.measured.values()];
        let mut values = vec![0.0; shares.len()];
        if model
            .evaluate(&self.start, &mut values, Some(&mut shares))
            .is_err()
        {
            // The search names what has no value.
            return Ok(());
        }
        // Compliances in units of the largest, as the logarithms are.
        let along = problem.measured.cells.len();
        let largest = values[along..].iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        for derivative in shares[along..].iter_mut().flatten() {
            *derivative /= largest;
        }
        let places = 0..self.members.len();
        let has_effect = |place: usize| {
            let together = places
                .clone()
                .filter(|&other| self.moved_by(other) == place);
            let together: Vec<usize> = together.collect();
            let of_cell = |shares: &Shares| -> f64 {
                let slopes = together
                    .iter()
                    .map(|&other| shares[other] * self.slope(other));
                slopes.sum()
            };
            shares
                .iter()
                .any(|shares| of_cell(shares).abs() > NO_EFFECT)
        };
        let idle = places
            .clone()
            .filter(|&place| self.members[place].role == Role::Free && !has_effect(place));
        for place in idle.collect::<Vec<_>>() {
            self.members[place].role = Role::NoEffect;
        }
        Ok(())
    }

    /// The parameter that moves another one, through chains of ties; itself if it is not tied.
    fn moved_by(&self, place: usize) -> usize {
        let mut root = place;
        for _ in 0..self.members.len() {
            let Role::Tied { to } = self.members[root].role else {
                break;
            };
            root = to;
        }
        root
    }

    /// Names of free parameters that no cell depends on.
    pub(super) fn without_effect(&self) -> impl Iterator<Item = &str> {
        let members = self.members.iter();
        let idle = members.filter(|member| member.role == Role::NoEffect);
        idle.map(|member| member.name.as_str())
    }

    /// The same with what the loads make of each spring.
    ///
    /// # Errors
    /// [`FitError::Bounds`], [`FitError::Tie`].
    pub(crate) fn with_scales(
        start: &FittingFactors,
        choice: &ParameterChoice,
        scale_of: &dyn Fn(&ModelParameter) -> PlaceScale,
    ) -> Result<Self, FitError> {
        let mut choice = choice.clone();
        for spring in start.springs() {
            if choice.members.iter().all(|m| m.parameter != spring) {
                choice.set(&spring, FitRole::Fixed);
            }
        }
        let parameters = choice.parameters();
        let mut members = Vec::with_capacity(parameters.len());
        for chosen in &choice.members {
            let (parameter, value) = (&chosen.parameter, start.get(&chosen.parameter));
            let name = parameter.to_string();
            let scale = if parameter.is_factor() {
                PlaceScale::default()
            } else {
                scale_of(parameter)
            };
            let unit = if scale.compliance > 0.0 {
                scale.compliance
            } else {
                1.0
            };
            let bounds = match (parameter.is_factor(), chosen.bounds) {
                (true, None) => choice.range.map(f64::ln),
                (true, Some(bounds)) => bounds.map(|bound| (bound / value).ln()),
                (false, None) => scale.plausible_compliance().map(|bound| bound / unit),
                (false, Some(bounds)) => bounds.map(|bound| bound / unit),
            };
            let [lower, upper] = bounds;
            let is_free = chosen.role == FitRole::Free;
            // Of a spring on which no load acts.
            let has_no_effect = is_free && chosen.bounds.is_none() && bounds == [0.0; 2];
            if is_free
                && !has_no_effect
                && !(lower < upper && bounds.iter().all(|bound| bound.is_finite()))
            {
                let bounds = chosen.bounds.unwrap_or([0.0; 2]);
                return Err(FitError::Bounds { name, bounds });
            }
            members.push(FitMember {
                name,
                role: match &chosen.role {
                    FitRole::Free if has_no_effect => Role::NoEffect,
                    FitRole::Free => Role::Free,
                    FitRole::Fixed => Role::Fixed,
                    FitRole::TiedTo(other) => {
                        let to = parameters.iter().position(|known| known == other);
                        let to = to.filter(|_| other.is_factor() == parameter.is_factor());
                        let to = to.ok_or_else(|| FitError::Tie {
                            one: parameter.to_string(),
                            other: other.to_string(),
                        })?;
                        Role::Tied { to }
                    }
                },
                start: value,
                scale_rad_per_nm: (!parameter.is_factor()).then_some(unit),
                bounds,
            });
        }
        // Tied springs take the scale that puts them at the coordinate of the other, through chains of ties.
        for place in (0..members.len()).cycle().take(members.len().pow(2)) {
            if let Role::Tied { to } = members[place].role
                && let Some(others) = members[to].scale_rad_per_nm
            {
                let both = members[place].start > 0.0 && members[to].start > 0.0;
                let kept = if both {
                    members[place].start / members[to].start
                } else {
                    1.0
                };
                members[place].scale_rad_per_nm = Some(kept * others);
            }
        }
        Ok(Self {
            start: start.clone(),
            members,
            parameters,
        })
    }

    /// The parameters, in the order of coordinates and results.
    pub(crate) fn parameters(&self) -> &[ModelParameter] {
        &self.parameters
    }

    /// The coordinates, beginning at the start.
    ///
    /// # Errors
    /// [`LeastSquaresError`] if ties go in a circle or no parameter is free.
    pub(crate) fn set(&self) -> Result<ParameterSet, LeastSquaresError> {
        ParameterSet::new(self.list())
    }

    /// The coordinates one by one.
    pub(crate) fn list(&self) -> Vec<Parameter> {
        let members = self.members.iter().enumerate();
        let parameter = |(place, member): (usize, &FitMember)| {
            let (name, start) = (&member.name, self.coordinate(place, member.start));
            let [lower, upper] = member.bounds;
            match member.role {
                Role::Free if member.scale_rad_per_nm.is_some() && start == 0.0 => {
                    Parameter::free(name, FIRST_SPRING.clamp(lower, upper), lower, upper)
                }
                Role::Free => Parameter::free(name, start.clamp(lower, upper), lower, upper),
                Role::Fixed | Role::NoEffect => Parameter::fixed(name, start),
                Role::Tied { to } => Parameter::tied(name, to, 1.0),
            }
        };
        members.map(parameter).collect()
    }

    /// Values at a point of the coordinates. A spring that the fit does not move and that had no value before has none.
    pub(crate) fn values(&self, point: &[f64]) -> FittingFactors {
        let mut values = self.start.clone();
        for (place, parameter) in self.parameters.iter().enumerate() {
            let is_known = parameter.is_factor() || self.start.spring(parameter).is_some();
            if is_known || self.moves(place) {
                values.set(parameter, self.value(place, point[place]));
            }
        }
        values
    }

    /// Whether a fit moves a parameter, by itself or with another.
    pub(crate) fn moves(&self, place: usize) -> bool {
        !matches!(self.members[place].role, Role::Fixed | Role::NoEffect)
    }

    /// What is known of a parameter before the fit.
    pub(crate) fn status(&self, place: usize) -> FactorStatus {
        match self.members[place].role {
            Role::Free => FactorStatus::Free,
            Role::Fixed => FactorStatus::Fixed,
            Role::NoEffect => FactorStatus::unloaded(&self.parameters[place]),
            Role::Tied { to } => FactorStatus::Tied {
                to: self.members[to].name.clone(),
            },
        }
    }

    /// Estimates without intervals: where each parameter began and ended.
    pub(crate) fn plain_estimates(&self, fitted: &FittingFactors) -> Vec<FactorEstimate> {
        let parameters = self.parameters.iter().enumerate();
        parameters
            .map(|(place, parameter)| FactorEstimate {
                name: parameter.to_string(),
                parameter: parameter.clone(),
                start: self.start.get(parameter),
                value: fitted.get(parameter),
                bounds: None,
                standard_uncertainty: None,
                interval_95: None,
                islands_95: Vec::new(),
                quadratic_interval_95: None,
                bootstrap_interval_95: None,
                status: self.status(place),
            })
            .collect()
    }

    /// Value of a parameter at a coordinate.
    pub(crate) fn value(&self, place: usize, coordinate: f64) -> f64 {
        let member = &self.members[place];
        match member.scale_rad_per_nm {
            None => member.start * coordinate.exp(),
            Some(scale) => scale * coordinate,
        }
    }

    /// Coordinate of a value of a parameter, not held within its bounds.
    pub(crate) fn coordinate(&self, place: usize, value: f64) -> f64 {
        let member = &self.members[place];
        match member.scale_rad_per_nm {
            None => (value / member.start).ln(),
            Some(scale) => value / scale,
        }
    }

    /// The coordinates where the fit begins, as the user has it: a free spring without a value is rigid.
    pub(crate) fn coordinates_of_start(&self) -> Vec<f64> {
        self.coordinates_by(|place| self.members[place].start)
    }

    /// The coordinates without what is fitted: springs rigid, factors one; what a fit does not move keeps its start.
    pub(crate) fn coordinates_of_rigid(&self) -> Vec<f64> {
        self.coordinates_by(|place| match &self.members[place] {
            member if !self.moves(place) => member.start,
            member if member.scale_rad_per_nm.is_none() => 1.0,
            _ => 0.0,
        })
    }

    /// The coordinates of values by place, not held within their bounds.
    fn coordinates_by(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let places = 0..self.members.len();
        places
            .map(|place| self.coordinate(place, value(place)))
            .collect()
    }

    /// How fast the derivative's own variable of a parameter grows with its coordinate: ln a of a factor, the compliance of a spring.
    pub(crate) fn slope(&self, place: usize) -> f64 {
        self.members[place].scale_rad_per_nm.unwrap_or(1.0)
    }

    /// Bounds of the coordinate of a parameter.
    pub(crate) fn bounds(&self, place: usize) -> [f64; 2] {
        self.members[place].bounds
    }

    /// Coordinates of values, held within bounds.
    pub(crate) fn coordinates(&self, values: &FittingFactors) -> Vec<f64> {
        let mut coordinates = self.coordinates_by(|place| values.get(&self.parameters[place]));
        for (coordinate, member) in coordinates.iter_mut().zip(&self.members) {
            let [lower, upper] = member.bounds;
            *coordinate = coordinate.clamp(lower, upper);
        }
        coordinates
    }
}

/// What springs would do in the cells of a fit.
fn spring_scales(
    problem: &FitProblem<'_>,
    parameters: &[ModelParameter],
) -> Result<SpringScales, FitError> {
    let along = problem.measured.cells.iter();
    let along = along.map(|one| (&one.cell, one.stiffness_n_per_m.recip()));
    let across = problem.measured.across.iter();
    let across = across.map(|one| (&one.cell, one.compliance_m_per_n));
    let all = along.chain(across);
    let (poses, places) = poses_of_cells(problem.robot, all.clone().map(|(cell, _)| cell))?;
    // Along an axis another load may move next to nothing: a spring is as soft as the largest displacement along it lets it be.
    let largest = |cell: &Cell| {
        let place = (&cell.pose, cell.direction);
        let here = all
            .clone()
            .filter(|(other, _)| (&other.pose, other.direction) == place);
        here.fold(0.0, |largest: f64, (_, moved)| largest.max(moved.abs()))
    };
    let cells = all.clone().zip(places);
    let cells = cells.map(|((cell, _), pose)| ScaleCell {
        pose,
        direction: cell.direction,
        measured_m_per_n: largest(cell),
    });
    let cells: Vec<ScaleCell> = cells.collect();
    let FitProblem {
        robot,
        mechanism,
        start,
        ..
    } = *problem;
    Ok(SpringScales::new(
        robot, mechanism, start, parameters, &poses, &cells,
    )?)
}
