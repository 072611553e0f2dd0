//! Where a mechanism is stiff, and where it is not.
//!
//! Decision: low, medium and high are the three equal parts of the range from the smallest to the largest stiffness of the map, as the
//! colours of a picture of it show them. Where the range spans a decade, or hardly a pose is in one of them, they would not divide the
//! workspace: low, medium and high are then thirds of the poses.

use super::statistics::{ColumnStatistics, quantile};
use super::stiffness_map::StiffnessMap;
use crate::distribution::extreme::Extreme;
use crate::distribution::pose_set::PoseSample;

/// A range whose largest stiffness is more than this times the smallest is divided by the poses.
const WIDE: f64 = 10.0;

/// Share of the poses below which a third of the range divides nothing.
const FEW_POSES: f64 = 0.01;

/// A third of the range or of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// The lowest third.
    Low,
    /// The middle third.
    Medium,
    /// The highest third.
    High,
}

/// Where the stiffness of a column is low, medium or high.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Which third of the range or of the poses.
    pub level: Level,
    /// Stiffness from and to, N/m or N·m/rad.
    pub between_n_per_m: [f64; 2],
    /// Share of the poses.
    pub share_of_poses: f64,
    /// Share of the area in the plane of the map; `None` where poses make no surface.
    pub share_of_area: Option<f64>,
    /// Mean of the two coordinates of the plane, m; `None` if no pose is in it.
    pub centre_m: Option<[f64; 2]>,
    /// Smallest and largest value of each coordinate, m.
    pub extent_m: Option<[[f64; 2]; 2]>,
    /// Smallest and largest value of each free variable, degrees, in the order of the free variables.
    pub angles_deg: Vec<[f64; 2]>,
    /// Outermost points of the map that lie in it.
    pub holds: Vec<Extreme>,
}

/// The regions of a column, from the lowest.
///
/// # Arguments
/// - `places`: where the end is in the plane in each row of the map, m.
#[must_use]
pub fn regions(
    map: &StiffnessMap,
    poses: &PoseSample,
    places: &[[f64; 2]],
    surface: Option<&[[u32; 3]]>,
    (statistics, column): (&ColumnStatistics, usize),
) -> [Region; 3] {
    let low = statistics.smallest.stiffness_n_per_m;
    let high = statistics.largest.stiffness_n_per_m;
    let values: Vec<f64> = map.column(column).collect();
    let [second, third] = borders(&values, [low, high]);
    let level_of =
        |stiffness: f64| usize::from(stiffness >= second) + usize::from(stiffness >= third);
    let mut regions = [
        (Level::Low, [low, second]),
        (Level::Medium, [second, third]),
        (Level::High, [third, high]),
    ]
    .map(|(level, between)| Gathered::new(level, between, poses.free.len()));
    let mut outermost: [Option<(f64, usize)>; 4] = [None; 4];
    for (row, (&stiffness, &at)) in values.iter().zip(places).enumerate() {
        let level = level_of(stiffness);
        let place = map.places[row] as usize;
        regions[level].add(at, poses.free_angles_deg(place));
        for (best, extreme) in outermost.iter_mut().zip(Extreme::ALL) {
            let value = extreme.of_reach_and_height(at);
            if best.is_none_or(|(known, _)| value > known) {
                *best = Some((value, level));
            }
        }
    }
    let differing = Extreme::of_points(places.iter().copied());
    for (best, extreme) in outermost.into_iter().zip(Extreme::ALL) {
        if let Some((_, level)) = best
            && differing.contains(&extreme)
        {
            regions[level].region.holds.push(extreme);
        }
    }
    let areas = surface.map(|triangles| areas(&values, places, triangles, level_of));
    let total: f64 = areas.iter().flatten().sum();
    let mut levels = 0..3;
    regions.map(|gathered| {
        let level = levels.next().unwrap_or_default();
        let area = areas
            .filter(|_| total > 0.0)
            .map(|areas| areas[level] / total);
        gathered.region(map.len(), area)
    })
}

/// Where the second and the third level begin.
fn borders(values: &[f64], [low, high]: [f64; 2]) -> [f64; 2] {
    let third = (high - low) / 3.0;
    let of_range = [low + third, high - third];
    let share = |level: usize| {
        let level_of = |value: f64| of_range.iter().filter(|border| value >= **border).count();
        let within = values.iter().filter(|value| level_of(**value) == level);
        within.count() as f64 / values.len() as f64
    };
    if high <= WIDE * low && (0..3).all(|level| share(level) >= FEW_POSES) {
        return of_range;
    }
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let mut sorted: Vec<f64> = finite.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    [1.0, 2.0].map(|thirds| quantile(&sorted, thirds / 3.0))
}

/// Area of the triangles whose mean stiffness is of each level, m².
fn areas(
    values: &[f64],
    places: &[[f64; 2]],
    triangles: &[[u32; 3]],
    level_of: impl Fn(f64) -> usize,
) -> [f64; 3] {
    let mut areas = [0.0; 3];
    for corners in triangles {
        let rows = corners.map(|corner| corner as usize);
        let [a, b, c] = rows.map(|row| places[row]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let mean = rows.iter().map(|&row| values[row]).sum::<f64>() / 3.0;
        areas[level_of(mean)] += 0.5 * twice.abs();
    }
    areas
}

/// A region on the way.
struct Gathered {
    region: Region,
    poses: usize,
    sums: [f64; 2],
}

impl Gathered {
    fn new(level: Level, between_n_per_m: [f64; 2], free: usize) -> Self {
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        Self {
            region: Region {
                level,
                between_n_per_m,
                share_of_poses: 0.0,
                share_of_area: None,
                centre_m: None,
                extent_m: Some([nothing; 2]),
                angles_deg: vec![nothing; free],
                holds: Vec::new(),
            },
            poses: 0,
            sums: [0.0; 2],
        }
    }

    fn add(&mut self, at: [f64; 2], angles_deg: &[f64]) {
        let widen = |[low, high]: &mut [f64; 2], value: f64| {
            (*low, *high) = (low.min(value), high.max(value));
        };
        self.poses += 1;
        for i in 0..2 {
            self.sums[i] += at[i];
        }
        if let Some(extent) = &mut self.region.extent_m {
            for (range, value) in extent.iter_mut().zip(at) {
                widen(range, value);
            }
        }
        for (range, &angle) in self.region.angles_deg.iter_mut().zip(angles_deg) {
            widen(range, angle);
        }
    }

    fn region(mut self, all: usize, share_of_area: Option<f64>) -> Region {
        self.region.share_of_area = share_of_area;
        self.region.share_of_poses = self.poses as f64 / all as f64;
        if self.poses == 0 {
            self.region.extent_m = None;
            self.region.angles_deg.clear();
        } else {
            self.region.centre_m = Some(self.sums.map(|sum| sum / self.poses as f64));
        }
        self.region
    }
}
