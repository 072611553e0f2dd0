//! Which part of the structure carries a misfit: how much of it each joint, element or support explains alone.

use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{Observations, ObservedCell};
use crate::mismatch::problem::{DiagnosisProblem, State};
use crate::search::constants::SOFTEST;
use crate::search::{dot, norm, push_orthonormal};
use stiffbench_beams::physics::{Place, PoseMechanics};
use stiffbench_beams::structure::Property;
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::test_point::{Branch, Direction};

use super::contrasts::ErrorTerm;
use super::decomposition::{Decomposition, FitContrast, squares};
use super::levels::{indicators, levels};
use super::results::{Contrast, ExplainedShare, SuspectComponent};
use super::tails::tail;

/// Parts with a larger cosine between their effects cannot be distinguished (1). By judgement (f10797f).
const INSEPARABLE_PARTS: f64 = 0.98;

/// Compliance of a joint times the stiffness of its loop beyond which even a pin does not explain it (1); above 1 for poses in which the loop is
/// stiffer. By judgement (8de8e53).
const A_PIN: f64 = 1.5;

/// Factor by which no property of an element is wrong (1): the bounds of the factors. Stated.
const MOST_WRONG: f64 = 10.0;

/// A part of whose effect the factors leave less than this share is not seen (1). Numerics.
const HIDDEN_PART: f64 = 1e-3;

/// Parts of a structure with what they do in each cell.
#[derive(Debug, Default)]
pub(super) struct SuspectComponents(Vec<ComponentResponse>);

#[derive(Debug)]
struct ComponentResponse {
    component: SuspectComponent,
    /// Compliance along each cell's direction for a unit of compliance in the part, m/N.
    compliance: Vec<f64>,
    /// Stiffness of the structure against a twist in a joint, N·m/rad: the smallest of all poses; zero for other parts.
    stiffness: f64,
    /// Displacement of each cell's end per twist in the part, m/rad, for parts in which play, friction or a curve may sit.
    lever: Option<Vec<f64>>,
}

/// The parts of the baseline in a state.
pub(super) fn parts(
    problem: &DiagnosisProblem<'_>,
    state: &State,
) -> Result<SuspectComponents, MismatchError> {
    let parameters = &state.fitted.model.parameters;
    let linearised = problem.predictor().linearised(parameters, &[])?;
    let cells = &problem.observations.cells;
    let mut parts: Vec<ComponentResponse> = Vec::new();
    let of_levers = |place: Place, lever: &dyn Fn(&ObservedCell) -> [f64; 6]| {
        let compliance = cells.iter().map(|cell| cell.lever_product(lever(cell)));
        let along = |cell: &ObservedCell| dot6(lever(cell), cell.read.unit()).abs();
        let levers = cells.iter().map(along).collect();
        ComponentResponse::new(place, compliance.collect(), Some(levers))
    };
    for (joint, place) in linearised.joints.iter().enumerate() {
        let lever = |cell: &ObservedCell| linearised.poses[cell.pose].influence.levers[joint];
        let stiffness = |pose: &PoseMechanics| pose.influence.stiffness(joint, joint);
        parts.push(ComponentResponse {
            stiffness: linearised
                .poses
                .iter()
                .map(stiffness)
                .fold(f64::INFINITY, f64::min),
            ..of_levers(place.clone(), &lever)
        });
    }
    for &axis in &linearised.rocking_axes {
        let lever = |cell: &ObservedCell| linearised.poses[cell.pose].base_levers[axis.index()];
        parts.push(of_levers(Place::Axis(axis), &lever));
    }
    for direction in Direction::ALL {
        let own = cells
            .iter()
            .map(|cell| f64::from(u8::from(cell.read == direction)) * cell.load.along(direction));
        let own: Vec<f64> = own.collect();
        parts.push(ComponentResponse::new(
            Place::Direction(direction),
            own.clone(),
            Some(own),
        ));
    }
    for element in problem.baseline.elements(parameters)? {
        for property in Property::ALL {
            // A larger property is stiffer: a relative compliance is minus its logarithm.
            let compliance = cells.iter().map(|cell| {
                let gradient = element.gradient_m_per_n[cell.pose][property.index()];
                // What an element does across the load is not worked out.
                if cell.is_along_load() {
                    -gradient[cell.axis().index()]
                } else {
                    0.0
                }
            });
            let place = Place::Element(element.element.clone());
            let part = ComponentResponse::new(place, compliance.collect(), None);
            parts.push(part.of_property(property.name()));
        }
    }
    parts.retain(|part| part.compliance.iter().any(|value| *value != 0.0));
    Ok(SuspectComponents(parts))
}

impl Decomposition<'_> {
    /// Parts by how much of the misfit of the cells' slopes each explains alone.
    pub(super) fn slope_components(
        &self,
        parts: &SuspectComponents,
        white: &[f64],
    ) -> Vec<ExplainedShare> {
        let contrast = |c: &&FitContrast| c.plan.contrast == Contrast::CellSlope;
        let Some(comparison) = self.comparisons.iter().find(contrast) else {
            return Vec::new();
        };
        let (pattern, d1) = self.pattern(comparison, white);
        let error = self.error(ErrorTerm::RunSlope, white);
        let misfit = Misfit {
            squares: squares(&pattern),
            d1,
            error,
        };
        let seen = parts.0.iter().filter_map(|part| {
            let column = self.per_cell(&part.compliance, |force_n| force_n);
            let white = self.white(&column);
            let seen = self.seen(comparison, &column);
            (norm(&seen) > HIDDEN_PART * norm(&white)).then_some((part, seen))
        });
        let ranked = seen.map(|(part, seen)| {
            let along = dot(&seen, &pattern) / squares(&seen);
            let explained = along * along * squares(&seen);
            (
                misfit.explained_share(part, explained, 1.0, Some(along)),
                seen,
            )
        });
        grouped(ranked.collect())
    }

    /// Joints and supports by how much of the curves, steps and loops over the load a law in each explains alone.
    ///
    /// The course over the load is left free; what is tested is its size from cell to cell, which follows the lever.
    pub(super) fn shape_components(
        &self,
        parts: &SuspectComponents,
        white: &[f64],
    ) -> Vec<ExplainedShare> {
        let (pattern, d1) = self.shape(white);
        let error = self.error(ErrorTerm::Pure, white);
        let misfit = Misfit {
            squares: squares(&pattern),
            d1,
            error,
        };
        let nodes = nodes(self.observations);
        let ranked = parts.0.iter().filter_map(|part| {
            let lever = part.lever.as_ref()?;
            // A curve stands for all courses when parts are compared.
            let curve = self.per_cell(lever, |force_n| force_n * force_n.abs());
            let representative = self.shape(&self.white(&curve)).0;
            let sizes = self.per_cell(lever, |_| 1.0);
            let mut units: Vec<Vec<f64>> = Vec::new();
            for node in &nodes {
                let column: Vec<f64> = node.iter().zip(&sizes).map(|(n, s)| n * s).collect();
                let white = self.white(&column);
                let seen = self.shape(&white).0;
                push_orthonormal(&mut units, seen, 0.0, 10.0 * HIDDEN_PART * norm(&white));
            }
            let explained = units.iter().map(|unit| dot(unit, &pattern).powi(2)).sum();
            let dof = units.len() as f64;
            let share_of = misfit.explained_share(part, explained, dof, None);
            (dof > 0.0).then_some((share_of, representative))
        });
        grouped(ranked.collect())
    }

    /// A column with a value for each cell times a function of the force.
    fn per_cell(&self, values: &[f64], of_force: impl Fn(f64) -> f64) -> Vec<f64> {
        let observations = self.observations;
        (0..observations.len())
            .map(|reading| {
                values[observations.cell_of(reading)]
                    * of_force(observations.loads[reading].force_n)
            })
            .collect()
    }
}

/// What is to be explained, and what it is compared with.
struct Misfit {
    squares: f64,
    d1: f64,
    /// Squares and degrees of freedom.
    error: (f64, f64),
}

impl Misfit {
    fn explained_share(
        &self,
        part: &ComponentResponse,
        explained: f64,
        dof: f64,
        size: Option<f64>,
    ) -> ExplainedShare {
        let (error, d2) = self.error;
        let scale = (error / d2).max(f64::MIN_POSITIVE);
        let left = self.d1 - dof;
        ExplainedShare {
            component: part.component.clone(),
            alike: Vec::new(),
            share: (explained / self.squares).clamp(0.0, 1.0),
            p: if dof > 0.0 {
                tail(explained / dof / scale, dof, d2)
            } else {
                1.0
            },
            p_left: if left > 0.0 {
                tail((self.squares - explained).max(0.0) / left / scale, left, d2)
            } else {
                1.0
            },
            size: size.and_then(|size| part.size(size)),
            possible: size.is_none_or(|size| part.possible(size)),
        }
    }
}

impl ComponentResponse {
    fn new(place: Place, compliance: Vec<f64>, lever: Option<Vec<f64>>) -> Self {
        Self {
            component: SuspectComponent {
                place,
                property: None,
            },
            compliance,
            stiffness: 0.0,
            lever,
        }
    }

    fn of_property(mut self, property: &'static str) -> Self {
        self.component.property = Some(property.into());
        self
    }

    /// Size of a part of which the end sees a compliance: in a closed loop c/(1 + c k).
    fn size(&self, seen: f64) -> Option<f64> {
        let left = 1.0 - seen * self.stiffness.max(0.0);
        (left > 0.0).then(|| seen / left)
    }

    fn possible(&self, seen: f64) -> bool {
        if self.component.property.is_some() {
            seen > 1.0 / MOST_WRONG - 1.0 && seen < MOST_WRONG - 1.0
        } else {
            seen > 0.0 && seen * self.stiffness < A_PIN && seen < SOFTEST
        }
    }
}

/// Those that are possible first, of these the most first; parts that cannot be distinguished from an earlier one stand with it.
fn grouped(mut ranked: Vec<(ExplainedShare, Vec<f64>)>) -> Vec<ExplainedShare> {
    ranked.sort_by(|(a, _), (b, _)| {
        let possible = b.possible.cmp(&a.possible);
        possible.then(b.share.total_cmp(&a.share))
    });
    let mut out: Vec<(ExplainedShare, Vec<f64>)> = Vec::new();
    for (share_of, seen) in ranked {
        let same = out.iter_mut().find(|(first, other)| {
            first.possible == share_of.possible
                && dot(other, &seen).abs() > INSEPARABLE_PARTS * norm(other) * norm(&seen)
        });
        match same {
            Some((first, _)) => first.alike.push(share_of.component),
            None => out.push((share_of, seen)),
        }
    }
    out.into_iter().map(|(share_of, _)| share_of).collect()
}

fn nodes(observations: &Observations) -> Vec<Vec<f64>> {
    let cells = 0..observations.cells.len();
    let levels = cells.flat_map(|cell| levels(observations, cell));
    let nodes = levels.zip(&observations.readings);
    let keys = nodes.map(|(level, one)| Some((level, one.branch == Branch::Unloading)));
    let columns = indicators(0, keys).into_iter();
    columns
        .map(|column| column.whole(observations.len()))
        .collect()
}
