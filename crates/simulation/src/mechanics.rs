//! What the structure does under the loads of a cell.

use stiffbench_beams::physics::{JointRotations, LawSet, LoadPoint, PoseMechanics, RunLoads};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// A load as it acted, with what clock and thermometer showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ActingLoad {
    /// What the laws need to know; the force is the one that acts, not the one that is read.
    pub(super) point: LoadPoint,
    /// By how much more its run yields than the others, relative (1).
    pub(super) run_slope: f64,
    /// The repeat, from 1.
    pub(super) repeat: u32,
    /// Loading or unloading.
    pub(super) branch: Branch,
    /// Seconds since the session began.
    pub(super) time_s: f64,
    /// Temperature, °C.
    pub(super) temperature_deg_c: f64,
}

impl ActingLoad {
    /// The same moment without force.
    pub(super) fn unloaded(&self) -> Self {
        let point = LoadPoint {
            force_n: 0.0,
            is_unloaded: true,
            ..self.point
        };
        Self { point, ..*self }
    }
}

/// A cell with its structure and laws; one gauge along the load or several along the base axes may read it.
pub(super) struct CellMechanics<'a> {
    pub(super) laws: &'a LawSet,
    pub(super) structure: &'a PoseMechanics,
    pub(super) pose: &'a PoseId,
    pub(super) load: &'a LoadDirection,
    /// Force to which each load is released before the next, N; `None` where the loads follow each other.
    pub(super) release_n: Option<f64>,
    /// Whether joints stay as a run left them when the next one begins.
    pub(super) keep_history: bool,
    /// Whether the gauge is zeroed before each run: it counts from what the run before left.
    pub(super) zero_each_run: bool,
}

impl CellMechanics<'_> {
    /// Displacements along an axis at the loads of the cell, m, relative to the unloaded state, in the order of the loads.
    pub(super) fn displacements_m(&self, read: Direction, loads: &[ActingLoad]) -> Vec<f64> {
        let mut displacements_m = vec![0.0; loads.len()];
        let mut joint_rotations = JointRotations::default();
        let (mut of_repeat, mut at_zero_m) = (0, 0.0);
        let m_per_n = self.structure.compliance(&read.into(), self.load);
        for (repeat, places) in self.stretches(loads) {
            let seated = |&place: &usize| {
                let ActingLoad {
                    point, run_slope, ..
                } = loads[place];
                LoadPoint {
                    seated_m: run_slope * m_per_n * point.force_n,
                    ..point
                }
            };
            let points: Vec<LoadPoint> = places.iter().map(seated).collect();
            let run = RunLoads {
                pose: self.pose,
                load: self.load,
                read: read.into(),
                repeat,
                release_n: self.release_n,
                loads: &points,
            };
            let mut out = vec![0.0; places.len()];
            let act = if self.keep_history {
                LawSet::go_on_m
            } else {
                LawSet::displacements_m
            };
            if self.keep_history && self.zero_each_run && repeat != of_repeat {
                let unloaded = [LoadPoint::release(0.0)];
                let run = RunLoads {
                    loads: &unloaded,
                    ..run
                };
                let mut left = [0.0];
                self.laws
                    .go_on_m(self.structure, &run, &mut joint_rotations, &mut left);
                (of_repeat, at_zero_m) = (repeat, left[0]);
            }
            act(
                self.laws,
                self.structure,
                &run,
                &mut joint_rotations,
                &mut out,
            );
            for (place, displacement_m) in places.into_iter().zip(out) {
                displacements_m[place] = displacement_m - at_zero_m;
            }
        }
        displacements_m
    }

    /// The same along several axes, by axis; zero along the others.
    pub(super) fn along_m(&self, read: &[Direction], loads: &[ActingLoad]) -> Vec<[f64; 3]> {
        let mut along_m = vec![[0.0; 3]; loads.len()];
        for &axis in read {
            let displacements_m = self.displacements_m(axis, loads);
            for (along_m, displacement_m) in along_m.iter_mut().zip(displacements_m) {
                along_m[axis.index()] = displacement_m;
            }
        }
        along_m
    }

    /// Repeat and loads of each stretch that the laws take at once: a run, whose loads need not follow one another; where history goes on
    /// from run to run, as many loads of one repeat as do.
    fn stretches(&self, loads: &[ActingLoad]) -> Vec<(u32, Vec<usize>)> {
        let mut stretches: Vec<(u32, Vec<usize>)> = Vec::new();
        for (place, load) in loads.iter().enumerate() {
            let mut same = stretches.iter_mut().rev();
            let known = if self.keep_history {
                same.next().filter(|(repeat, _)| *repeat == load.repeat)
            } else {
                same.find(|(repeat, _)| *repeat == load.repeat)
            };
            match known {
                Some((_, places)) => places.push(place),
                None => stretches.push((load.repeat, vec![place])),
            }
        }
        stretches
    }
}
