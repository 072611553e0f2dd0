//! What may act beside the parameters of a fit: one column each, as long as the rows.

use stiffbench_beams::physics::{Effect, Law, Place, PlaceScale, TestObject, laws};
use stiffbench_beams::robot::ModelParameter;
use stiffbench_beams::structure::Compliance6;
use stiffbench_units_and_text::test_point::Direction;

use crate::elastostatics::compliances::{EndCompliance, motion_along};
use crate::elastostatics::outcome::LoadCaseFit;
use crate::elastostatics::posed::{PosedLoad, PosedLoadCases, ReadComponent};
use crate::elastostatics::prediction::along;
use crate::elastostatics::problem::{unit_length, unloaded_springs};
use crate::fit::FactorStatus;
use crate::search::constants::MOST_WRONG;
use crate::search::dot;

/// Candidates of one kind share a critical value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CandidateKind {
    /// A spring of a joint about or along its own axis.
    JointSpring,
    /// A spring of a joint about an axis across its own.
    AcrossJoint,
    /// A spring under the base.
    Base,
    /// A spring at the tool.
    Tool,
    /// A law of a joint that is not linear.
    JointLaw,
    /// A factor of sections.
    Factor,
    /// An error of gauges, their stand or their axes.
    SetUp,
}

impl CandidateKind {
    /// Whether it is a spring of the robot.
    #[must_use]
    pub fn is_spring(self) -> bool {
        matches!(
            self,
            Self::JointSpring | Self::AcrossJoint | Self::Base | Self::Tool
        )
    }
}

/// Largest over smallest moment in a joint from which on its laws may be told from a spring (1).
const SEVERAL_SIZES: f64 = 1.5;

/// One thing that may act.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MissingCandidate {
    /// Its name: of a spring that of the parameter, for example `joint.J3.z`; else law and place.
    pub(super) name: String,
    /// Name of the law.
    pub(super) law: &'static str,
    /// Where, in words.
    pub(super) place: String,
    pub(super) kind: CandidateKind,
    /// ASCII unit of its size.
    pub(super) unit: &'static str,
    /// Change of every row per unit of size.
    pub(super) column: Vec<f64>,
    /// Smallest and largest size.
    pub(super) bounds: [f64; 2],
    /// The parameter from which it takes under the largest load, and how much per unit of size: it may not take more than all of it.
    pub(super) takes_from: Option<(ModelParameter, f64)>,
}

/// The compliance of every pose with its derivatives to the parameters of a robot.
pub(super) struct SolvedPoses<'a> {
    /// The load cases.
    pub(super) posed: &'a PosedLoadCases,
    /// Compliance of the end by pose.
    pub(super) compliance: Vec<EndCompliance>,
    /// The parameters.
    pub(super) parameters: Vec<ModelParameter>,
    /// Derivative by pose and parameter.
    pub(super) derivatives: Vec<Vec<EndCompliance>>,
}

impl SolvedPoses<'_> {
    /// A column from what each row gives.
    fn column(&self, of: &dyn Fn(&PosedLoad, &ReadComponent) -> f64) -> Vec<f64> {
        self.posed
            .rows()
            .map(|(case, read)| of(case, read))
            .collect()
    }

    /// The column of a parameter.
    pub(super) fn of_parameter(&self, place: usize) -> Vec<f64> {
        self.column(&|case, read| {
            motion_along(&self.derivatives[case.pose][place], &read.unit, &case.load)
        })
    }

    /// Which parameters are springs that no load acts on: nothing can be missing there that a reading shows.
    pub(super) fn unloaded(&self) -> Vec<bool> {
        let places = 0..self.parameters.len();
        let columns = places.map(|place| self.of_parameter(place));
        let lengths: Vec<f64> = columns.map(|column| dot(&column, &column).sqrt()).collect();
        unloaded_springs(&self.parameters, &lengths, unit_length(self.posed))
    }

    /// All candidates beside the parameters that are free.
    pub(super) fn candidates(
        &self,
        is_free: &dyn Fn(&ModelParameter) -> bool,
    ) -> Vec<MissingCandidate> {
        let mut found = Vec::new();
        let loaded = self.unloaded().into_iter().map(|unloaded| !unloaded);
        let places = self.parameters.iter().enumerate().zip(loaded);
        for ((place, parameter), _) in places.filter(|(_, loaded)| *loaded) {
            if let ModelParameter::Joint(joint) = parameter {
                found.extend(self.joint_laws(place, joint));
            }
            if is_free(parameter) {
                continue;
            }
            let (kind, law, words) = describe(parameter);
            found.push(MissingCandidate {
                name: parameter.to_string(),
                law,
                place: words,
                kind,
                unit: parameter.unit(),
                column: self.of_parameter(place),
                takes_from: None,
                bounds: if parameter.is_factor() {
                    [-MOST_WRONG.ln(), MOST_WRONG.ln()]
                } else {
                    [0.0, f64::INFINITY]
                },
            });
        }
        found.extend(self.set_up());
        // What no row shows is no candidate.
        found.retain(|one| {
            one.column
                .iter()
                .any(|value| *value != 0.0 && value.is_finite())
        });
        found
    }

    /// Laws of a joint whose twist is not proportional to its moment, where its moments differ enough.
    fn joint_laws(&self, place: usize, joint: &str) -> Vec<MissingCandidate> {
        // s sᵀ w is the motion per moment times the moment s·w, whatever the sign of s.
        let moment = |case: &PosedLoad| {
            let matrix = &self.derivatives[case.pose][place];
            motion_along(matrix, &case.load, &case.load).max(0.0).sqrt()
        };
        let moments: Vec<f64> = self.posed.cases.iter().map(moment).collect();
        let largest = moments.iter().copied().fold(0.0, f64::max);
        let loaded = moments.iter().filter(|moment| **moment > 1e-3 * largest);
        let smallest = loaded.copied().fold(largest, f64::min);
        if largest < SEVERAL_SIZES * smallest {
            return Vec::new();
        }
        let with = |power: f64| {
            self.column(&|case, read| {
                let (own, moment) = (&self.derivatives[case.pose][place], moment(case));
                if moment <= 1e-3 * largest {
                    return 0.0;
                }
                motion_along(own, &read.unit, &case.load) * moment.powf(power)
            })
        };
        let candidate = |law: Law, unit, column, bounds| MissingCandidate {
            name: format!("{}@{joint}", law.name),
            law: law.name,
            place: format!("joint {joint}"),
            kind: CandidateKind::JointLaw,
            unit,
            column,
            bounds,
            takes_from: None,
        };
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        let positive = [0.0, f64::INFINITY];
        let step = with(-1.0);
        // The twist c M + k M |M| has the slope c + 2 k |M|.
        let slope = (self.parameters[place].clone(), -2.0 * largest);
        vec![
            MissingCandidate {
                takes_from: Some(slope),
                ..candidate(laws::JOINT_NONLINEARITY, "rad/(N*m)^2", with(1.0), free)
            },
            candidate(laws::JOINT_BACKLASH, "rad", step.clone(), positive),
            candidate(
                laws::JOINT_FRICTION,
                "rad",
                step.iter().map(|value| -value).collect(),
                positive,
            ),
        ]
    }

    /// Errors of gauges, their stand and their axes.
    fn set_up(&self) -> Vec<MissingCandidate> {
        let mut found = Vec::new();
        let own = |case: &PosedLoad| self.compliance[case.pose];
        let motion = |case: &PosedLoad| Compliance6(own(case)).times(case.load);
        for axis in Direction::ALL {
            let k = axis.index();
            let mut add =
                |name: &str, law: Law, place: String, bounds: Option<[f64; 2]>, column| {
                    let size = law.parameters[0];
                    found.push(MissingCandidate {
                        name: format!("{name}.{axis}"),
                        law: law.name,
                        place,
                        kind: CandidateKind::SetUp,
                        unit: size.unit(),
                        column,
                        bounds: bounds.unwrap_or_else(|| {
                            (size.plausible.bounds)(&PlaceScale::default(), &[])
                        }),
                        takes_from: None,
                    });
                };
            add(
                "gauge-stand",
                laws::GAUGE_STAND_COMPLIANCE,
                format!("the stand of the displacement gauge along {axis}"),
                Some([0.0, f64::INFINITY]),
                self.column(&|case, read| read.unit[k] * case.load[k]),
            );
            add(
                "displacement-axes",
                laws::GAUGE_MISALIGNMENT,
                format!("the axes of the displacements, turned about {axis}"),
                None,
                self.column(&|case, read| along(&read.unit, &turned(&motion(case), k))),
            );
            add(
                "force-axes",
                laws::LOAD_MISALIGNMENT,
                format!("the axes of the loads, turned about {axis}"),
                None,
                self.column(&|case, read| {
                    motion_along(&own(case), &read.unit, &turned(&case.load, k))
                }),
            );
            add(
                "displacement-scale",
                laws::DISPLACEMENT_GAUGE_SCALE,
                format!("the scale of the displacements along {axis}"),
                None,
                self.column(&|case, read| read.unit[k] * motion(case)[k]),
            );
            add(
                "force-scale",
                laws::FORCE_GAUGE_SCALE,
                format!("the scale of the forces along {axis}"),
                None,
                self.column(&|case, read| {
                    let mut part = [0.0; 6];
                    part[k] = case.load[k];
                    motion_along(&own(case), &read.unit, &part)
                }),
            );
        }
        found
    }
}

/// Names of the laws of the library of which there is neither a candidate nor a free parameter, in its order.
pub(super) fn not_tested(
    candidates: &[MissingCandidate],
    baseline: &LoadCaseFit,
) -> Vec<&'static str> {
    let free = baseline.estimates.iter();
    let free = free.filter(|one| one.status != FactorStatus::Fixed);
    let free = free.map(|one| describe(&one.parameter).1);
    let tested: Vec<&str> = candidates.iter().map(|one| one.law).chain(free).collect();
    let mut names: Vec<&'static str> = Vec::new();
    for law in Law::searched_on(TestObject::Robot) {
        if !tested.contains(&law.name) && !names.contains(&law.name) {
            names.push(law.name);
        }
    }
    names
}

/// Kind, law and place in words of a parameter that is not free.
fn describe(parameter: &ModelParameter) -> (CandidateKind, &'static str, String) {
    use CandidateKind::{AcrossJoint, Base, Factor, JointSpring, Tool};
    let kind = match parameter {
        ModelParameter::Joint(_) | ModelParameter::JointAlong(_) => JointSpring,
        ModelParameter::JointAbout(..) => AcrossJoint,
        ModelParameter::Base(_) => Base,
        ModelParameter::Tool(_) => Tool,
        ModelParameter::Class(..) | ModelParameter::Section(..) | ModelParameter::Group(..) => {
            Factor
        }
    };
    if let Some(effect) = Effect::of_spring(parameter, 0.0) {
        return (kind, effect.law.name, effect.place.to_string());
    }
    match parameter {
        ModelParameter::JointAlong(joint) => {
            let place = Place::Joint(joint.to_string());
            (kind, laws::JOINT_COMPLIANCE.name, place.to_string())
        }
        ModelParameter::Base(axis) => {
            let place = format!("the base, along {axis}");
            (kind, laws::BASE_COMPLIANCE.name, place)
        }
        other => (
            kind,
            laws::SECTION_ERROR.name,
            format!("the sections, {other}"),
        ),
    }
}

/// Force and moment, or displacement and rotation, turned about an axis by a small angle, per rad.
fn turned(vector: &[f64; 6], axis: usize) -> [f64; 6] {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = [0.0; 6];
    for first in [0, 3] {
        out[first + next] = -vector[first + last];
        out[first + last] = vector[first + next];
    }
    out
}
