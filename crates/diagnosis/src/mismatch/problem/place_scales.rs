//! What the loads make of every place, by which the values of laws there are bounded.

use stiffbench_beams::physics::{Effect, Law, Place, PlaceKind, PlaceScale, TestObject};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::test_point::Direction;

use super::linearised::LinearisedModel;
use crate::mismatch::baselines::StructureColumn;
use crate::mismatch::observed::{Observations, ObservedRun, ReadingClock};
use crate::parameters::bears_no_load;
use crate::search::constants::{AFTER_A_JUMP, OPEN_LOOP};

/// Plausible bounds of the parameters of a law, as a fit moves them, around values.
pub(crate) fn plausible_bounds(law: Law, scale: &PlaceScale, values: &[f64]) -> Vec<[f64; 2]> {
    let parameters = law.parameters.iter();
    parameters
        .map(|parameter| (parameter.plausible.bounds)(scale, values))
        .collect()
}

/// Scales of all places of a session, by which every fit is bounded.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlaceScales {
    pub(crate) session: PlaceScale,
    places: Vec<(Place, PlaceScale)>,
}

impl PlaceScales {
    /// That of the session alone.
    pub(crate) fn of_session(observations: &Observations) -> Self {
        Self {
            session: session_scale(observations),
            places: Vec::new(),
        }
    }

    /// # Arguments
    /// - `linearised`: the structure, solved.
    pub(crate) fn new(observations: &Observations, linearised: &LinearisedModel) -> Self {
        let mut out = Self::of_session(observations);
        for kind in KINDS.into_iter().filter(|kind| *kind != PlaceKind::Run) {
            out.places
                .extend(out.of_kind(kind, observations, linearised));
        }
        out
    }

    /// The scale of a place; that of the session where it has none of its own.
    pub(crate) fn at(&self, place: &Place) -> &PlaceScale {
        let own = self.places.iter().find(|(other, _)| other == place);
        own.map_or(&self.session, |(_, scale)| scale)
    }

    /// Bounds of the values of an effect, as a fit moves them.
    pub(crate) fn bounds(&self, effect: &Effect) -> Vec<[f64; 2]> {
        plausible_bounds(effect.law, self.at(&effect.place), &effect.values)
    }

    /// The places of a kind that these loads act on, with their scales.
    pub(crate) fn of_kind(
        &self,
        kind: PlaceKind,
        observations: &Observations,
        linearised: &LinearisedModel,
    ) -> Vec<(Place, PlaceScale)> {
        let session = self.session;
        let with = |place: Place, scale: Option<PlaceScale>| Some((place, scale?));
        match kind {
            PlaceKind::Joint => {
                let joints = linearised.joints.iter().enumerate();
                loaded(joints.filter_map(|(joint, place)| {
                    let scale = joint_scale(&session, observations, linearised, joint);
                    with(place.clone(), scale)
                }))
            }
            PlaceKind::AcrossJoint | PlaceKind::ToolAbout | PlaceKind::ToolAlong => {
                let columns = linearised.columns.iter();
                let here = columns.filter(|column| column.place.kind() == kind);
                loaded(here.filter_map(|column| {
                    let scale = spring_scale(&session, observations, linearised, column);
                    with(column.place.clone(), scale)
                }))
            }
            PlaceKind::Axis => {
                let axes = linearised.rocking_axes.iter().copied();
                let of_axis = axes.filter_map(|axis| {
                    let scale = axis_scale(&session, observations, linearised, axis);
                    with(Place::Axis(axis), scale)
                });
                of_axis.collect()
            }
            PlaceKind::Direction => {
                let directions = Direction::ALL.into_iter();
                let of_direction = directions.filter_map(|direction| {
                    let scale = direction_scale(&session, observations, linearised, direction);
                    with(Place::Direction(direction), scale)
                });
                of_direction.collect()
            }
            PlaceKind::Toward => {
                let towards = observations.directions().flat_map(|direction| {
                    let others = Direction::ALL
                        .into_iter()
                        .filter(move |axis| *axis != direction);
                    others.map(move |toward| (Place::Toward { direction, toward }, session))
                });
                towards.collect()
            }
            PlaceKind::Run => runs(observations).map(|place| (place, session)).collect(),
            // A structure without an element, or of another mechanism, is solved, not seen as a shape.
            PlaceKind::Mechanism => Vec::new(),
            PlaceKind::Element | PlaceKind::Length | PlaceKind::JointAngle | PlaceKind::Group => {
                let columns = linearised.columns.iter();
                let here = columns.filter(|column| column.place.kind() == kind);
                here.map(|column| (column.place.clone(), session)).collect()
            }
            PlaceKind::DisplacementGauge | PlaceKind::Clock => {
                let place = match kind {
                    PlaceKind::Clock => Place::Clock,
                    _ => Place::DisplacementGauge,
                };
                let places = observations.of_gauges(place).into_iter();
                places.map(|place| (place, session)).collect()
            }
            PlaceKind::ForceGauge | PlaceKind::Structure => kind
                .only()
                .into_iter()
                .map(|place| (place, session))
                .collect(),
        }
    }
}

/// Kinds of places, in the order in which they are searched.
pub(crate) const KINDS: [PlaceKind; 16] = [
    PlaceKind::Joint,
    PlaceKind::AcrossJoint,
    PlaceKind::ToolAbout,
    PlaceKind::ToolAlong,
    PlaceKind::Axis,
    PlaceKind::Direction,
    PlaceKind::Toward,
    PlaceKind::ForceGauge,
    PlaceKind::Structure,
    PlaceKind::Clock,
    PlaceKind::Run,
    PlaceKind::DisplacementGauge,
    PlaceKind::Length,
    PlaceKind::JointAngle,
    PlaceKind::Element,
    PlaceKind::Group,
];

/// What the loads of a session have in common.
fn session_scale(observations: &Observations) -> PlaceScale {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let loads = || observations.loads.iter();
    let recorded = observations.recorded;
    let repeats = || observations.runs.iter().map(|run| run.repeat);
    let only_if = |recorded: bool, value: f64| if recorded { value } else { 0.0 };
    PlaceScale {
        force_n: largest(&mut loads().map(|load| load.force_n)),
        force_range_n: [f64::min, f64::max].map(|end| {
            let forces = loads().map(|load| load.force_n);
            forces.reduce(end).unwrap_or_default()
        }),
        displacement_m: largest(&mut observations.displacement_m.iter().copied()),
        time_s: only_if(
            recorded.time
                && !matches!(
                    observations.clock,
                    ReadingClock::Rows | ReadingClock::OneSweep
                ),
            largest(&mut loads().map(|load| load.since_zero_s)),
        ),
        warming_k: only_if(
            recorded.temperature,
            largest(&mut loads().map(|load| load.warming_k)),
        ),
        has_clock: recorded.time && observations.clock == ReadingClock::Times,
        has_holds: recorded.hold,
        has_repeats: repeats().max() != repeats().min(),
        ..PlaceScale::default()
    }
}

/// A joint as the loads of a session see it; `None` if they do not act on it.
fn joint_scale(
    session: &PlaceScale,
    observations: &Observations,
    poses: &LinearisedModel,
    joint: usize,
) -> Option<PlaceScale> {
    let mut best: Option<(f64, f64, f64, f64)> = None;
    let mut moment_nm = 0.0_f64;
    // Along the load, whichever way the gauge looks: across it a joint moves the end at most by the mean of what it moves along either.
    for cell in &observations.cells {
        let influence = &poses.poses[cell.pose].influence;
        let along = |vector: [f64; 6]| dot6(vector, cell.load.wrench());
        let lever = along(influence.levers[joint]);
        let compliance = along(influence.compliance.map(along));
        let by_weight = poses.poses[cell.pose].unloaded.moment_nm(joint).abs();
        moment_nm = moment_nm.max(lever.abs() * session.force_n + by_weight);
        let share = lever * lever / compliance;
        if best.is_none_or(|(most, ..)| share > most) {
            best = Some((share, lever, influence.stiffness(joint, joint), compliance));
        }
    }
    let (share, lever, stiffness, compliance) = best?;
    if share.is_nan() || share <= 0.0 {
        return None;
    }
    let is_open = lever * lever > OPEN_LOOP * compliance * stiffness.abs();
    let scale = PlaceScale {
        compliance: 1.0 / share,
        moment_nm,
        loop_nm_per_rad: if is_open { 0.0 } else { stiffness.abs() },
        ..*session
    };
    // A structure that is all but rigid there is no measure of what the joint may be.
    let as_measured = measured_compliance(observations, poses, joint);
    let [_, softest] = scale.plausible_compliance();
    let compliance = if is_open && as_measured > softest {
        as_measured
    } else {
        scale.compliance
    };
    (compliance > 0.0).then_some(PlaceScale {
        compliance,
        ..scale
    })
}

/// Compliance of a joint that would give all that was measured in the cell in which it shows best, rad/(N·m) or m/N; zero without readings under a
/// load.
fn measured_compliance(observations: &Observations, poses: &LinearisedModel, joint: usize) -> f64 {
    let shown = observations.cells.iter().map(|cell| {
        let lever = poses.poses[cell.pose].influence.levers[joint];
        (cell.lever_product(lever).abs(), cell)
    });
    let best = shown.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(0.0, |(product, cell)| {
        let readings = cell.readings.clone();
        let displacements = readings.clone().map(|one| observations.displacement_m[one]);
        let forces = span(readings.map(|one| observations.loads[one].force_n)) * product;
        if forces > 0.0 {
            span(displacements) / forces
        } else {
            0.0
        }
    })
}

/// From the least value to the largest, of one value from zero.
fn span(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let zero = (values.len() == 1).then_some(0.0);
    let all = values.chain(zero);
    all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
}

/// A spring of the structure as the loads of a session see it; `None` if they do not act on it.
fn spring_scale(
    session: &PlaceScale,
    observations: &Observations,
    poses: &LinearisedModel,
    column: &StructureColumn,
) -> Option<PlaceScale> {
    let shares = observations.cells.iter().map(|cell| {
        let load = cell.load.wrench();
        let along = |matrix: &[[f64; 6]; 6]| dot6(load, matrix.map(|row| dot6(row, load)));
        let whole = &poses.poses[cell.pose].influence.compliance;
        let share = along(&column.compliance[cell.pose]) / along(whole);
        (share, column.loop_stiffness[cell.pose])
    });
    let (share, stiffness) = shares.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (share > 0.0).then(|| PlaceScale {
        compliance: 1.0 / share,
        loop_nm_per_rad: stiffness,
        ..*session
    })
}

/// Places without those on which the loads hardly act beside the others.
fn loaded(places: impl Iterator<Item = (Place, PlaceScale)>) -> Vec<(Place, PlaceScale)> {
    let mut places: Vec<(Place, PlaceScale)> = places.collect();
    let compliances = places.iter().map(|(_, scale)| scale.compliance);
    let least = compliances.fold(f64::INFINITY, f64::min);
    places.retain(|(_, scale)| !bears_no_load(scale.compliance, least));
    places
}

/// A base that rocks about an axis; `None` if the loads do not rock it.
fn axis_scale(
    session: &PlaceScale,
    observations: &Observations,
    poses: &LinearisedModel,
    axis: Direction,
) -> Option<PlaceScale> {
    let shares = observations.cells.iter().map(|cell| {
        let pose = &poses.poses[cell.pose];
        let lever = dot6(pose.base_levers[axis.index()], cell.read.unit());
        lever * lever / pose.along(&cell.read)
    });
    let share = shares.fold(0.0, f64::max);
    (share > 0.0).then(|| PlaceScale {
        compliance: 1.0 / share,
        ..*session
    })
}

/// A direction, where the robot is stiffest in it; `None` if nothing was measured along it.
fn direction_scale(
    session: &PlaceScale,
    observations: &Observations,
    poses: &LinearisedModel,
    direction: Direction,
) -> Option<PlaceScale> {
    let axis = direction.index();
    let here = observations
        .cells
        .iter()
        .filter(|cell| cell.read == direction);
    let stiffest = here
        .map(|cell| poses.poses[cell.pose].influence.compliance[axis][axis])
        .fold(f64::INFINITY, f64::min);
    stiffest.is_finite().then_some(PlaceScale {
        compliance: stiffest,
        ..*session
    })
}

/// Runs, from each step on at which something may have happened: only where runs are repeated, of a part each, for in one recording a jump cannot
/// be told from the answer of the part, and in one run of each cell not from its zero and slope.
fn runs(observations: &Observations) -> impl Iterator<Item = Place> + '_ {
    let is_robot = observations.object == TestObject::Robot;
    let shows_jumps = is_robot && observations.has_repeats();
    let is_repeated =
        move |run: &&ObservedRun| shows_jumps || observations.cells[run.cell].runs.len() > 1;
    let runs = observations.runs.iter().filter(is_repeated);
    runs.flat_map(move |run| {
        let cell = &observations.cells[run.cell];
        let loads = &observations.loads[run.readings.clone()];
        let steps = 1..loads.len().saturating_sub(AFTER_A_JUMP);
        let begins = steps.filter(|&place| loads[place].step != loads[place - 1].step);
        begins.map(move |place| Place::Run {
            pose: observations.poses[cell.pose].clone(),
            direction: cell.load.called(),
            repeat: run.repeat,
            step: loads[place].step,
            gauge: (!observations.gauges.is_empty()).then_some(cell.axis()),
        })
    })
}
