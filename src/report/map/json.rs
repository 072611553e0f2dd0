//! Maps for programs.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::distribution::{
    ColumnStudy, FitUncertainty, MapColumn, MatrixKind, MechanismStudy, RefinedStiffness, Region,
};
use crate::reported::Reported;

use super::{MapReport, PaperCell, SensitivityReport, ShiftSummary, unit_of};

/// What `robot map` gives: the maps, or the answers to what it is asked instead.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum MapResult {
    /// The maps.
    Maps(Box<MapSummary>),
    /// The answers.
    Answers(Box<MapAnswers>),
}

/// Answers beside the stiffness; each is there if it was asked for.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MapAnswers {
    /// What a load at the end does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<ShiftSummary>,
    /// What the own weight does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sag: Option<ShiftSummary>,
    /// What moves the stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<Sensitivities>,
}

/// What moves the stiffness.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct Sensitivities {
    /// One entry a mechanism and axis.
    pub sensitivities: Vec<SensitivityReport>,
}

/// The stiffness of some mechanisms over the same poses.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MapSummary {
    /// Name of the robot.
    pub robot: String,
    /// Name of the factors.
    pub factors: String,
    /// How the poses were chosen: `monte-carlo`, `low-discrepancy` or `grid`.
    #[schemars(with = "String")]
    pub sampling: crate::distribution::Sampling,
    /// Seed of the poses.
    pub seed: u64,
    /// Number of poses.
    pub poses: usize,
    /// Number of points that were drawn for them.
    pub points: u64,
    /// Names of the variables that vary.
    pub varied: Vec<String>,
    /// Load at which laws that are not linear are taken, N.
    #[serde(rename = "at_load_N")]
    pub at_load_n: Option<f64>,
    /// The two coordinates of the plane; absent for reach and height of a robot whose y points up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane: Option<[Cow<'static, str>; 2]>,
    /// One entry a mechanism.
    pub mechanisms: Vec<MechanismMap>,
    /// The paper's tables beside the maps; empty for other robots.
    pub paper: Vec<PaperCell>,
}

/// The stiffness of a mechanism.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MechanismMap {
    /// Name of the mechanism.
    pub mechanism: String,
    /// Effects beside its beams, in words.
    pub physics: Vec<String>,
    /// How it was computed, in words.
    pub method: Vec<String>,
    /// Poses that could be solved.
    pub poses: usize,
    /// The others.
    pub failed: Vec<FailedPose>,
    /// One entry a direction in which something yields.
    pub stiffness: Vec<DirectionMap>,
    /// Directions in which nothing yields in any pose; absent if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<RigidDirection>,
}

/// A direction in which nothing yields in any pose.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RigidDirection {
    /// Name of the direction, as in `stiffness`.
    pub along: String,
    /// `null`, with the reason.
    pub value: Reported,
}

/// A pose that could not be solved.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FailedPose {
    /// Number of the point.
    pub id: u64,
    /// Why.
    pub reason: String,
}

/// The stiffness along one direction, or about one.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct DirectionMap {
    /// Name of the direction: `x`, or `rx` for the rotational stiffness about x, in N*m/rad.
    pub along: String,
    /// The direction, of length 1; `null` for a principal one.
    pub unit_vector: Option<[f64; 3]>,
    /// Place of a principal stiffness in its order; `null` for a direction.
    pub principal: Option<u8>,
    /// Where the stiffness is least.
    pub smallest: ExtremeStiffness,
    /// Where it is greatest.
    pub largest: ExtremeStiffness,
    /// Greatest less least of the samples.
    pub difference: Reported,
    /// Mean over the poses.
    pub mean: Reported,
    /// Standard deviation over the poses.
    pub standard_deviation: Option<Reported>,
    /// Poses in which nothing yields there: all numbers are of the others; absent if there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rigid_poses: Option<usize>,
    /// Quantiles over the poses.
    pub quantiles: Vec<StiffnessQuantile>,
    /// 95 % bound of the share of poses beyond the extremes of the samples.
    pub share_beyond_extremes_95: Option<f64>,
    /// What the uncertainty of fitted factors does; `null` without it.
    pub fit_uncertainty: Option<FittedStiffness>,
    /// Where the stiffness is low, middling and high.
    pub regions: Vec<StiffnessRegion>,
}

/// An extreme stiffness.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ExtremeStiffness {
    /// Among the samples.
    pub sampled: SampledStiffness,
    /// Found by a search from there.
    pub refined: RefinedExtremeJson,
}

/// The stiffness in a sampled pose.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct SampledStiffness {
    /// The stiffness.
    pub value: Reported,
    /// Number of the point.
    pub id: u64,
    /// Position of the end, m.
    pub end_m: [f64; 3],
    /// The pose, degrees by variable.
    pub angles_deg: IndexMap<String, f64>,
    /// The matrix of the end; absent if it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<EndMatrix>,
}

/// The Cartesian stiffness or compliance of the end, 6 × 6.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EndMatrix {
    /// `stiffness` or `compliance`.
    #[schemars(with = "String")]
    pub kind: MatrixKind,
    /// Row by row, SI, in the order x, y, z, about x, about y, about z; `null` where the end cannot move in some direction.
    pub values: Option<Vec<[f64; 6]>>,
}

/// The stiffness at the end of a search; only `value`, with the reason, where it failed.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RefinedExtremeJson {
    /// The stiffness.
    pub value: Reported,
    /// Where and how.
    #[serde(flatten)]
    pub found: Option<RefinedPose>,
}

/// Where a search ended.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RefinedPose {
    /// Position of the end, m.
    pub end_m: [f64; 3],
    /// The pose, degrees by variable.
    pub angles_deg: IndexMap<String, f64>,
    /// The limits that hold it.
    pub limits: Vec<String>,
    /// Slope of the stiffness along the limits, share per degree.
    pub slope_per_deg: f64,
}

/// A quantile of the stiffness.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct StiffnessQuantile {
    /// Share of the poses below it.
    pub share: f64,
    /// The stiffness.
    pub stiffness: Reported,
}

/// Stiffness with the uncertainty of fitted factors.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct FittedStiffness {
    /// The least.
    pub smallest: Reported,
    /// The greatest.
    pub largest: Reported,
    /// The mean.
    pub mean: Reported,
}

/// A region of the workspace by its stiffness.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct StiffnessRegion {
    /// `low`, `middle` or `high`.
    #[schemars(with = "String")]
    pub level: crate::distribution::Level,
    /// Stiffness between which it lies.
    pub between: [Reported; 2],
    /// Its share of the poses.
    pub share_of_poses: f64,
    /// Its share of the area in the plane.
    pub share_of_area: Option<f64>,
    /// Where it lies.
    #[serde(flatten)]
    pub place: RegionPlace,
    /// Least and greatest angle of each variable that varies, degrees.
    pub angles_deg: IndexMap<String, [f64; 2]>,
    /// The outermost points that lie in it.
    pub holds: Vec<String>,
}

/// Where a region lies in the plane.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, deny_unknown_fields)]
pub enum RegionPlace {
    /// In the plane of reach z and height y.
    ReachAndHeight {
        /// Its centre (z, y), m.
        centre_zy_m: Option<[f64; 2]>,
        /// Its least and greatest reach, m.
        reach_m: Option<[f64; 2]>,
        /// Its least and greatest height, m.
        height_m: Option<[f64; 2]>,
    },
    /// In another plane.
    Coordinates {
        /// Its centre, m.
        centre_m: Option<[f64; 2]>,
        /// Its least and greatest first coordinate, m.
        first_m: Option<[f64; 2]>,
        /// Its least and greatest second coordinate, m.
        second_m: Option<[f64; 2]>,
    },
}

impl MapReport<'_> {
    /// The maps for programs.
    #[must_use]
    pub fn summary(&self) -> MapSummary {
        let set = &self.poses.set;
        let mechanisms = self.mechanisms.iter();
        MapSummary {
            robot: self.robot.name.clone(),
            factors: self.factors_name.clone(),
            sampling: self.poses.sampling,
            seed: self.seed,
            poses: set.len(),
            points: set.drawn,
            varied: set.free.iter().map(|&free| self.variable(free)).collect(),
            at_load_n: self.at_load_n,
            plane: (!self.poses.plane.is_of_the_paper())
                .then(|| self.poses.plane.letters().map(Into::into)),
            mechanisms: mechanisms
                .map(|(effects, study)| self.mechanism(effects, study))
                .collect(),
            paper: self.paper_cells(),
        }
    }

    fn variable(&self, index: usize) -> String {
        self.robot.variables[index].name.clone()
    }

    fn mechanism(&self, effects: &[String], study: &MechanismStudy) -> MechanismMap {
        let columns = study.columns.iter();
        MechanismMap {
            mechanism: study.map.mechanism.clone(),
            physics: effects.to_vec(),
            method: study.method.clone(),
            poses: study.map.len(),
            failed: self.failed(&study.map.failed),
            stiffness: columns.map(|found| self.column(study, found)).collect(),
            rigid: study.rigid().map(rigid_direction).collect(),
        }
    }

    /// Poses without an answer, by their place among the poses.
    pub(super) fn failed(&self, failed: &[(u32, String)]) -> Vec<FailedPose> {
        let of = |(place, reason): &(u32, String)| FailedPose {
            id: self.poses.set.ids[*place as usize],
            reason: reason.clone(),
        };
        failed.iter().map(of).collect()
    }

    fn column(&self, study: &MechanismStudy, found: &ColumnStudy) -> DirectionMap {
        let statistics = &found.statistics;
        let (unit, scale) = unit_of(&found.column);
        let exact = |si: f64| Reported::exact(si / scale, unit);
        let sampled = [statistics.smallest, statistics.largest];
        let extreme = |i: usize| {
            let row = sampled[i].row;
            let place = study.map.places[row] as usize;
            ExtremeStiffness {
                sampled: SampledStiffness {
                    value: exact(sampled[i].stiffness_n_per_m),
                    id: self.poses.set.ids[place],
                    end_m: study.map.end_m(row),
                    angles_deg: self.angles(&self.poses.set.pose(place).angles_deg),
                    matrix: matrix_of(study, row),
                },
                refined: self.refined(&found.column, found.refined[i].as_ref()),
            }
        };
        let quantiles = statistics.quantiles.iter().map(|quantile| {
            let value = quantile.stiffness_n_per_m / scale;
            let interval = quantile.interval_95.map(|ends| ends.map(|end| end / scale));
            StiffnessQuantile {
                share: quantile.share,
                stiffness: interval.map_or_else(
                    || Reported::exact(value, unit),
                    |interval| Reported::with_interval(value, interval, unit),
                ),
            }
        });
        DirectionMap {
            along: found.column.name().to_string(),
            unit_vector: found.column.unit(),
            principal: found.column.order(),
            smallest: extreme(0),
            largest: extreme(1),
            difference: exact(sampled[1].stiffness_n_per_m - sampled[0].stiffness_n_per_m),
            mean: Reported::from_estimate(&statistics.mean, scale, unit),
            standard_deviation: statistics.standard_deviation_n_per_m.map(exact),
            rigid_poses: Some(statistics.rigid).filter(|rigid| *rigid > 0),
            quantiles: quantiles.collect(),
            share_beyond_extremes_95: statistics.share_beyond_95,
            fit_uncertainty: found
                .fit
                .as_ref()
                .map(|fit| fitted_stiffness(&found.column, fit)),
            regions: found
                .regions
                .iter()
                .map(|region| self.region(&found.column, region))
                .collect(),
        }
    }

    fn angles(&self, angles_deg: &[f64]) -> IndexMap<String, f64> {
        let variables = self.robot.variables.iter().zip(angles_deg);
        variables
            .map(|(variable, angle)| (variable.name.clone(), *angle))
            .collect()
    }

    fn refined(
        &self,
        column: &MapColumn,
        refined: Result<&RefinedStiffness, &String>,
    ) -> RefinedExtremeJson {
        let (unit, scale) = unit_of(column);
        match refined {
            Ok(refined) => RefinedExtremeJson {
                value: Reported::exact(refined.stiffness_n_per_m / scale, unit),
                found: Some(RefinedPose {
                    end_m: refined.end_m,
                    angles_deg: self.angles(&refined.pose.angles_deg),
                    limits: refined.limits.clone(),
                    slope_per_deg: refined.slope_per_deg,
                }),
            },
            Err(reason) => RefinedExtremeJson {
                value: Reported::missing(unit, reason.clone()),
                found: None,
            },
        }
    }

    fn region(&self, column: &MapColumn, region: &Region) -> StiffnessRegion {
        let (unit, scale) = unit_of(column);
        let [first, second] = [0, 1].map(|i| region.extent_m.map(|extent| extent[i]));
        let place = if self.poses.plane.is_of_the_paper() {
            RegionPlace::ReachAndHeight {
                centre_zy_m: region.centre_m,
                reach_m: first,
                height_m: second,
            }
        } else {
            RegionPlace::Coordinates {
                centre_m: region.centre_m,
                first_m: first,
                second_m: second,
            }
        };
        let free = self.poses.set.free.iter().zip(&region.angles_deg);
        StiffnessRegion {
            level: region.level,
            between: region
                .between_n_per_m
                .map(|k| Reported::exact(k / scale, unit)),
            share_of_poses: region.share_of_poses,
            share_of_area: region.share_of_area,
            place,
            angles_deg: free
                .map(|(&variable, range)| (self.variable(variable), *range))
                .collect(),
            holds: self.words_of(&region.holds),
        }
    }
}

fn rigid_direction(column: &MapColumn) -> RigidDirection {
    let (unit, _) = unit_of(column);
    RigidDirection {
        along: column.name().to_owned(),
        value: Reported::missing(unit, "nothing yields there in any pose"),
    }
}

fn fitted_stiffness(column: &MapColumn, fit: &FitUncertainty) -> FittedStiffness {
    let (unit, scale) = unit_of(column);
    let reported = |estimate| Reported::from_estimate(estimate, scale, unit);
    FittedStiffness {
        smallest: reported(&fit.smallest),
        largest: reported(&fit.largest),
        mean: reported(&fit.mean),
    }
}

/// The matrix of a row, if the map has one.
fn matrix_of(study: &MechanismStudy, row: usize) -> Option<EndMatrix> {
    let kind = study.map.matrix?;
    let (rows, _) = study.map.matrix(row)?.as_chunks::<6>();
    let is_finite = rows.iter().flatten().all(|entry| entry.is_finite());
    Some(EndMatrix {
        kind,
        values: is_finite.then(|| rows.to_vec()),
    })
}
