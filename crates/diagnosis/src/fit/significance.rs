//! Which factor matters in which direction: the paper's Table III, and the exact shares of which it is a coarse picture.
//!
//! The paper multiplies one section constant by 100 and looks at what is left of the displacement. That is 1 - s + s/100 where the
//! share s of the factor is small and stays so, but in a statically indeterminate structure the load finds other ways as one part
//! stiffens. The exact share, the part of the strain energy stored through that section constant, needs one solution and adds up
//! to one. Both are given.

use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot};
use stiffbench_beams::structure::Property;
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use super::cell_model::CellModel;
use super::error::FitError;
use super::fixed_physics::FixedPhysics;
use super::shares::Shares;

/// Factor by which the paper multiplies one section constant (Section III-D).
pub const PAPER_FACTOR: f64 = 100.0;

/// Which elements a section constant is changed in.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// All elements (S-FSD, the paper's step 3).
    All,
    /// Beams only (M-FSD, step 6).
    Beams,
}

/// Significance of the four section constants for the displacement in the three directions of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionSignificance {
    /// The pose.
    pub pose: PoseId,
    /// Elements in which the constants were changed.
    pub scope: Scope,
    /// The factors around which they were changed.
    pub factors: FittingFactors,
    /// Displacement under the load along each direction before the change, per newton, m/N.
    pub compliance_m_per_n: [f64; 3],
    /// What remains of the displacement when one constant is multiplied by 100: 4 × 3, row = A, Iy, Iz, J, column = x, y, z, of one.
    pub remaining: [[f64; 3]; 4],
    /// Exact share of each constant in the compliance, 4 × 3 as above.
    pub shares: [[f64; 3]; 4],
    /// Share of the elements outside the scope (links, when only beams are changed) and of physics beside the beams, by direction; with
    /// the rest it adds up to one.
    pub share_of_others: [f64; 3],
    /// Single sections and springs that were asked for, or that the factors name.
    pub further: Vec<ParameterSignificance>,
}

/// What one parameter beyond the four section constants does to the displacement in one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSignificance {
    /// The parameter.
    pub parameter: ModelParameter,
    /// Its value.
    pub value: f64,
    /// Its share of the compliance along x, y, z.
    pub shares: [f64; 3],
    /// What remains of the displacement along x, y, z when it is made a hundred times as stiff.
    pub remaining: [f64; 3],
    /// Compliance of a spring that adds a hundredth to the displacement along x, y, z, rad/(N·m); `None` where no load acts on it, and for
    /// factors.
    pub adds_a_hundredth: [Option<f64>; 3],
}

/// The order in which factors are fitted, each with the direction it is fitted to.
#[derive(
    Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct SequenceStep {
    /// The section constant.
    pub property: Property,
    /// The direction it is fitted to; `None` if every direction is taken by a factor that matters more there.
    pub direction: Option<Direction>,
}

/// Works out the significance of the section constants in one pose (the paper's steps 3 and 6).
///
/// With physics beside the beams the displacement is that of the paper's loads, and the share of the physics is in `share_of_others`.
///
/// # Arguments
/// - `further`: sections and springs to be checked beside the section constants; springs of `factors` are added.
///
/// # Errors
/// Those of [`CellModel::new`] and [`CellModel::evaluate`].
pub fn significance(
    robot: &Robot,
    mechanism: &Mechanism,
    pose: &PoseId,
    factors: &FittingFactors,
    scope: Scope,
    physics: Option<&FixedPhysics>,
    further: &[ModelParameter],
) -> Result<SectionSignificance, FitError> {
    let cells: Vec<Cell> = Direction::ALL
        .into_iter()
        .map(|direction| Cell::new(pose.clone(), direction))
        .collect();
    let mut parameters = ModelParameter::CLASSES.to_vec();
    for parameter in further.iter().cloned().chain(factors.springs()) {
        if !parameters.contains(&parameter) {
            parameters.push(parameter);
        }
    }
    let acting = (robot, mechanism, physics);
    let mut model = CellModel::with_across(acting, &parameters, &cells, &[])?;
    let mut stiffness = [0.0; 3];
    let mut shares = [const { Shares::new() }; 3];
    model.evaluate(factors, &mut stiffness, Some(&mut shares))?;
    let mut remains = |changed: &FittingFactors| -> Result<[f64; 3], FitError> {
        let mut stiffer = [0.0; 3];
        model.evaluate(changed, &mut stiffer, None)?;
        Ok([0, 1, 2].map(|i| stiffness[i] / stiffer[i]))
    };
    let mut remaining = [[0.0; 3]; 4];
    for property in Property::ALL {
        let mut changed = factors.clone();
        changed.beam[property.index()] *= PAPER_FACTOR;
        if scope == Scope::All {
            changed.link[property.index()] *= PAPER_FACTOR;
        }
        remaining[property.index()] = remains(&changed)?;
    }
    let mut of_further = Vec::new();
    let beyond = ModelParameter::CLASSES.len();
    for (place, parameter) in parameters.iter().enumerate().skip(beyond) {
        let (value, slopes) = (factors.get(parameter), [0, 1, 2].map(|i| shares[i][place]));
        let mut changed = factors.clone();
        let is_factor = parameter.is_factor();
        let stiff = if is_factor {
            value * PAPER_FACTOR
        } else {
            value / PAPER_FACTOR
        };
        changed.set(parameter, stiff);
        let hundredth = |slope: f64| (!is_factor && slope < 0.0).then(|| -0.01 / slope);
        of_further.push(ParameterSignificance {
            parameter: parameter.clone(),
            value,
            shares: slopes.map(|slope| if is_factor { slope } else { -slope * value }),
            remaining: remains(&changed)?,
            adds_a_hundredth: slopes.map(hundredth),
        });
    }
    let in_scope = |p: usize, i: usize| match scope {
        Scope::All => shares[i][p] + shares[i][4 + p],
        Scope::Beams => shares[i][p],
    };
    let shares_in_scope: [[f64; 3]; 4] =
        std::array::from_fn(|p| std::array::from_fn(|i| in_scope(p, i)));
    Ok(SectionSignificance {
        pose: pose.clone(),
        scope,
        factors: factors.clone(),
        compliance_m_per_n: stiffness.map(|k| 1.0 / k),
        remaining,
        shares: shares_in_scope,
        share_of_others: std::array::from_fn(|i| {
            1.0 - shares_in_scope.iter().map(|row| row[i]).sum::<f64>()
        }),
        further: of_further,
    })
}

impl SectionSignificance {
    /// The fitting sequence: constants by what their hundredfold leaves of the displacement, the smallest remainder first.
    ///
    /// Each takes the direction in which it matters most among those not taken yet; with three directions the fourth constant has
    /// none and stays where it is. On the paper's Table III this gives Iy (vertical), Iz (lateral), A (radial) and J without a
    /// direction: the sequence the paper states.
    #[must_use]
    pub fn sequence(&self) -> Vec<SequenceStep> {
        let mut pairs: Vec<(Property, Direction)> = Property::ALL
            .into_iter()
            .flat_map(|property| {
                Direction::ALL
                    .into_iter()
                    .map(move |direction| (property, direction))
            })
            .collect();
        let remains = |(p, d): &(Property, Direction)| self.remaining[p.index()][d.index()];
        pairs.sort_by(|a, b| remains(a).total_cmp(&remains(b)));
        let mut steps: Vec<SequenceStep> = Vec::new();
        for (property, direction) in pairs {
            let taken = steps
                .iter()
                .any(|s| s.property == property || s.direction == Some(direction));
            if !taken {
                steps.push(SequenceStep {
                    property,
                    direction: Some(direction),
                });
            }
        }
        for property in Property::ALL {
            if !steps.iter().any(|step| step.property == property) {
                steps.push(SequenceStep {
                    property,
                    direction: None,
                });
            }
        }
        steps
    }
}
