//! Load cases as series of one step: what a search takes.

use indexmap::IndexMap;
use stiffbench_beams::physics::LoadPoint;
use stiffbench_beams::robot::{Pose, TrackedPoses};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, PoseId};

use super::posed::{COMPONENTS, PosedLoad, PosedLoadCases, ReadComponent};
use super::scatter::SAME_LOAD;
use crate::mismatch::{GaugeSteps, Observations, ObservedReading, Recorded};

/// Loads whose directions differ by less are one load applied again, rad: what they do differs by less than a thousandth of the displacement.
const SAME_DIRECTION: f64 = 1e-3;

/// The load cases of a pose under loads of one direction.
struct LoadSeries<'p> {
    load: LoadDirection,
    /// Amounts of the loads that are different ones.
    steps: Vec<f64>,
    cases: Vec<StepCase<'p>>,
}

/// A load case with its place in a series.
struct StepCase<'p> {
    /// Its number among all load cases.
    number: usize,
    amount: f64,
    /// Number of its load among the different ones.
    step: usize,
    case: &'p PosedLoad,
}

impl PosedLoadCases {
    /// The load cases as series of one step: every load begins at the unloaded state, with a zero of its own; loads of one direction in a pose are
    /// repeats of each other.
    ///
    /// # Arguments
    /// - `tracker`: of absolute positions, which are counted from where it sees the rigid robot.
    #[must_use]
    pub fn as_series(&self, steps: GaugeSteps, tracker: Option<&TrackedPoses>) -> Observations {
        Observations {
            tracker: tracker.map(|tracker| tracker.frames),
            ..self.series_and_rows(steps, tracker).0
        }
    }

    /// The same with the place of each reading among [`PosedLoadCases::rows`].
    pub(in crate::fit) fn series_and_rows(
        &self,
        steps: GaugeSteps,
        tracker: Option<&TrackedPoses>,
    ) -> (Observations, Vec<usize>) {
        let mut observations = Observations::without_readings(steps, Recorded::default());
        let names = self.named_poses().into_iter().map(|(name, _)| name);
        observations.poses = names.collect();
        let first_rows = self.cases.iter().scan(0, |next, case| {
            let first = *next;
            *next += case.components.len();
            Some(first)
        });
        let first_rows: Vec<usize> = first_rows.collect();
        let mut rows = Vec::new();
        for (place, cases) in self.by_pose().values().enumerate() {
            for series in series_of(cases) {
                series.add_to(&mut observations, place, tracker, |number, component| {
                    rows.push(first_rows[number] + component);
                });
            }
        }
        observations.gauges = observations.gauges_read_at_once();
        (observations, rows)
    }

    /// The distinct poses, each with a name of its own: that of the table, with a number behind it if the table has it with several joint values.
    #[must_use]
    pub fn named_poses(&self) -> Vec<(PoseId, Pose)> {
        let mut names: Vec<PoseId> = Vec::new();
        let by_pose = self.by_pose();
        let named = by_pose.keys().map(|&(label, pose)| {
            let label = &self.labels[label];
            let mut name = label.clone();
            let mut number = 2;
            while names.contains(&name) {
                name = PoseId::new(&format!("{label}-{number}"));
                number += 1;
            }
            names.push(name.clone());
            (name, self.poses[pose].clone())
        });
        named.collect()
    }

    /// The cases of each name with each of its joint values, in the order of the table, each with its number.
    fn by_pose(&self) -> IndexMap<(usize, usize), Vec<(usize, &PosedLoad)>> {
        let mut by_pose: IndexMap<_, Vec<_>> = IndexMap::new();
        for (number, case) in self.cases.iter().enumerate() {
            let cases = by_pose.entry((case.label, case.pose)).or_default();
            cases.push((number, case));
        }
        by_pose
    }
}

/// The series of the load cases of a pose.
fn series_of<'p>(cases: &[(usize, &'p PosedLoad)]) -> Vec<LoadSeries<'p>> {
    let mut all: Vec<LoadSeries<'p>> = Vec::new();
    for &(number, case) in cases {
        let (load, amount) = case.load_along();
        // A position shows the robot without a load too.
        if amount == 0.0 && !case.components.iter().any(ReadComponent::is_position) {
            continue;
        }
        let known = all.iter().position(|series| is_along(&series.load, &load));
        let place = known.unwrap_or_else(|| {
            all.push(LoadSeries {
                load: load.clone(),
                steps: Vec::new(),
                cases: Vec::new(),
            });
            all.len() - 1
        });
        all[place].push(number, amount, &load, case);
    }
    all
}

/// Whether loads have one direction, either way along it.
fn is_along(one: &LoadDirection, other: &LoadDirection) -> bool {
    let (a, b) = (one.wrench(), other.wrench());
    let product = dot6(a, b);
    let squares = dot6(a, a) * dot6(b, b);
    let sine = (squares - product * product).max(0.0);
    sine <= SAME_DIRECTION * SAME_DIRECTION * squares
}

impl<'p> LoadSeries<'p> {
    fn push(&mut self, number: usize, amount: f64, load: &LoadDirection, case: &'p PosedLoad) {
        let amount = amount * dot6(self.load.wrench(), load.wrench()).signum();
        let is_same =
            |other: &f64| (amount - other).abs() <= SAME_LOAD * amount.abs().max(other.abs());
        let known = self.steps.iter().position(is_same);
        let step = known.unwrap_or_else(|| {
            self.steps.push(amount);
            self.steps.len() - 1
        });
        self.cases.push(StepCase {
            number,
            amount,
            step,
            case,
        });
    }

    /// # Arguments
    /// - `added`: is told the number of the case of each reading and the place among its components.
    fn add_to(
        &self,
        observations: &mut Observations,
        pose: usize,
        tracker: Option<&TrackedPoses>,
        mut added: impl FnMut(usize, usize),
    ) {
        for component in 0..COMPONENTS.len() {
            let read = |case: &'p PosedLoad| {
                let mut read = case.components.iter().enumerate();
                read.find(|(_, one)| one.component == component)
            };
            let first = self.cases.iter();
            let mut first = first.filter_map(|one| Some((one.case, read(one.case)?.1)));
            let Some((case, first)) = first.next() else {
                continue;
            };
            observations.begin_cell(pose, self.load.clone(), case.seen(first, tracker).0);
            for (repeat, case) in (1..).zip(&self.cases) {
                let Some((place, one)) = read(case.case) else {
                    continue;
                };
                added(case.number, place);
                let number = case.number as u32;
                observations.begin_run(repeat, number);
                let reading = ObservedReading {
                    run: 0,
                    seq: number + 1,
                    zero: observations.len() as u32,
                    branch: Branch::Loading,
                    hold_number: 0,
                    time_s: None,
                    line: case.case.line,
                    target_n: case.amount,
                    flagged: false,
                };
                let load = LoadPoint {
                    force_n: case.amount,
                    step: case.step as u32 + 1,
                    ..LoadPoint::default()
                };
                let (_, rigid_m) = case.case.seen(one, tracker);
                observations.push(reading, load, one.value - rigid_m);
            }
        }
    }
}
