//! What is said of where a model fails.

use std::borrow::Cow;
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mismatch::observed::Observations;
use crate::mismatch::unexplained::stratum::{Location, Stratum};
use crate::search::constants::STRATUM_LEVEL;
use stiffbench_beams::physics::Place;
use stiffbench_units_and_text::quantity::micro;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::map::MapEntry;

/// Share of a stratum's squares above which one spot is said to hold it (1). By judgement (f10797f).
const ONE_SPOT: f64 = 0.8;

/// What is compared within a stratum.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Contrast {
    /// Slopes of cells beyond one set of factors.
    CellSlope,
    /// Slopes that change with the repeat.
    Repeat,
    /// Mean zeros of cells.
    CellOffset,
    /// Displacement that grows with the clock or the temperature.
    Clock,
    /// Slopes under positive and negative loads.
    Sign,
    /// Smooth curves over the load.
    Curve,
    /// What levels of load have beyond smooth curves: dead zones, steps.
    LoadStep,
    /// Loading against unloading on the whole.
    Loop,
    /// The same level by level.
    Branch,
    /// Readings of a hold against the first under the same load.
    Hold,
    /// Size of the scatter of readings against what is known of it.
    NoiseSize,
    /// The largest single departure.
    Outlier,
    /// A period in the reading.
    Period,
}

/// Its name in files.
impl fmt::Display for Contrast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Contrast {
    /// The stratum it belongs to.
    #[must_use]
    pub fn stratum(self) -> Stratum {
        match self {
            Self::CellSlope => Stratum::CellSlope,
            Self::Repeat | Self::Clock | Self::Hold => Stratum::RepeatTime,
            Self::CellOffset | Self::Curve | Self::LoadStep => Stratum::LoadStep,
            Self::Sign => Stratum::Sign,
            Self::Loop | Self::Branch => Stratum::Branch,
            Self::NoiseSize | Self::Outlier | Self::Period => Stratum::Rest,
        }
    }

    /// Why these readings have nothing of the contrast.
    pub(super) fn when_absent(self, observations: &Observations) -> &'static str {
        match self {
            Self::CellSlope => "the factors fit the slopes of as many cells exactly",
            Self::Repeat => "no load sequence was repeated",
            Self::CellOffset => "the slopes of the runs absorb the zeros",
            Self::Clock if observations.is_one_sweep() => "time and load rose together",
            Self::Clock if !observations.recorded.time => "no times were recorded",
            Self::Clock => "time and load increase together: they cannot be distinguished",
            Self::Sign => "the loads have one sign",
            Self::Curve => "two loads cannot show a curve",
            Self::LoadStep => "a smooth curve fits all levels of load exactly",
            Self::Loop | Self::Branch => "no load was approached from above",
            Self::Hold => "no load was held for further readings",
            Self::NoiseSize => "the noise was estimated from these readings",
            Self::Outlier | Self::Period => "too few readings remain for a comparison",
        }
    }
}

/// A test of one contrast.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StratumTest {
    /// Where it belongs.
    pub stratum: Stratum,
    /// What is compared.
    pub contrast: Contrast,
    /// F; of the largest outlier t², of a period the largest F.
    pub statistic: f64,
    /// Degrees of freedom of numerator and denominator; the second is infinite where the variance is known.
    #[schemars(with = "[Option<f64>; 2]")]
    pub dof: [f64; 2],
    /// Chance that noise alone gives as much; for the largest of several at most that (Bonferroni). Zero means below 1e-300.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
    /// The same for the family of all tests, by Holm.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Whether both are the smallest that the draws for a coarse gauge can show.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub p_at_floor: bool,
    /// Largest departure of a reading, m, once the fit has absorbed what it can; in files µm.
    #[serde(
        rename = "size_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub size_m: f64,
    /// Part of all weighted squares beyond noise that lies here; 0 where noise alone gives as much once in twenty times.
    pub share: f64,
    /// Poses, directions and cells in which it sits, those that hold most of it first; none where the test does not pass
    /// [`STRATUM_LEVEL`].
    pub spots: Vec<Spot>,
}

impl StratumTest {
    /// A test alone, without its spots.
    pub(super) fn new(
        contrast: Contrast,
        statistic: f64,
        dof: [f64; 2],
        p: f64,
        size_m: f64,
    ) -> Self {
        Self {
            stratum: contrast.stratum(),
            contrast,
            statistic,
            dof,
            p,
            p_family: 1.0,
            p_at_floor: false,
            size_m,
            share: 0.0,
            spots: Vec::new(),
        }
    }
}

/// Part of a contrast.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spot {
    /// The pose, if one.
    pub pose: Option<PoseId>,
    /// The direction, if one.
    pub direction: Option<Direction>,
    /// The repeat, if it is one reading.
    pub repeat: Option<u32>,
    /// The step, if it is one reading.
    pub step: Option<u32>,
    /// Chance that noise alone gives as much in this or another spot of the stratum (Holm), not below that of the stratum.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Largest departure of a reading there, m; in files µm.
    #[serde(
        rename = "size_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub size_m: f64,
    /// Share of the contrast's squares that letting this part go free explains.
    pub share: f64,
}

/// A contrast that these readings cannot test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Untested {
    /// The contrast.
    pub contrast: Contrast,
    /// Why.
    pub why: String,
}

/// Where a model fails, and what carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// All tests, in the order of the strata.
    pub tests: Vec<StratumTest>,
    /// What could not be tested.
    pub untested: Vec<Untested>,
    /// Parts of the structure by how much of the misfit of slopes each explains alone, the most first; empty if slopes do not misfit.
    pub slope_components: Vec<ExplainedShare>,
    /// The same for curves, steps and loops over the load: joints and supports.
    pub shape_components: Vec<ExplainedShare>,
    /// Mean residuals by pose, direction, load step, branch and repeat.
    pub map: Vec<MapEntry>,
}

impl Located {
    /// Strata that noise does not explain, each with the pose and direction that hold it; the one with the largest share of what noise
    /// does not explain first.
    ///
    /// Where no single cell, pose or direction holds four fifths of a stratum, none is named.
    #[must_use]
    pub fn locations(&self) -> Vec<Location> {
        let mut tests: Vec<&StratumTest> = self
            .tests
            .iter()
            .filter(|test| test.p_family <= STRATUM_LEVEL)
            .collect();
        // The clock is tested first. A drift leaves no loop beyond itself, and no curve larger than itself: where there is one, it shows
        // over the clock too, which then is no trend.
        let clock = tests.iter().find(|test| test.contrast == Contrast::Clock);
        let clock_m = clock.map_or(0.0, |test| test.size_m);
        let is_of_load = tests.iter().any(|test| match test.contrast {
            Contrast::Loop | Contrast::Branch => true,
            Contrast::Sign | Contrast::Curve | Contrast::LoadStep => test.size_m >= clock_m,
            _ => false,
        });
        if is_of_load {
            tests.retain(|test| test.contrast != Contrast::Clock);
        }
        tests.sort_by(|a, b| b.share.total_cmp(&a.share));
        let mut out: Vec<Location> = Vec::new();
        for test in tests {
            let known = out.iter_mut().find(|known| known.stratum == test.stratum);
            if let Some(known) = known {
                if test.p_family < known.p_family {
                    known.p_family = test.p_family;
                    known.p_at_floor = test.p_at_floor;
                }
                continue;
            }
            // The smallest part that holds it: a cell before a pose or direction.
            let held = test
                .spots
                .iter()
                .filter(|spot| spot.share >= ONE_SPOT)
                .min_by_key(|spot| (spot.pose.is_none(), spot.direction.is_none()));
            out.push(Location {
                stratum: test.stratum,
                pose: held.and_then(|spot| spot.pose.clone()),
                direction: held.and_then(|spot| spot.direction),
                period_s: None,
                p_family: test.p_family,
                p_at_floor: test.p_at_floor,
                size_m: held.map_or(test.size_m, |spot| spot.size_m.min(test.size_m)),
            });
        }
        out
    }
}

/// A part of the structure that may give way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SuspectComponent {
    /// The joint, element, base axis or direction of the gauge's stand.
    pub place: Place,
    /// Section property of an element: A (along), Iy, Iz (bending), J (twisting).
    pub property: Option<Cow<'static, str>>,
}

impl fmt::Display for SuspectComponent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.place, &self.property) {
            (Place::Direction(direction), _) => write!(f, "the gauge's stand in {direction}"),
            (place, Some(property)) => write!(f, "{place}, {property}"),
            (place, None) => write!(f, "{place}"),
        }
    }
}

/// How much of a misfit a part of the structure explains alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExplainedShare {
    /// The part.
    #[serde(flatten)]
    pub component: SuspectComponent,
    /// Parts that cannot be distinguished from it with these cells.
    pub alike: Vec<SuspectComponent>,
    /// Share of the misfit's squares, the factors refitted: cosine² of the two patterns.
    pub share: f64,
    /// Chance that noise alone gives as much.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p: f64,
    /// Chance that noise alone leaves what this part does not explain; above 0.05 it suffices.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_left: f64,
    /// What it would take: compliance beyond the model's, rad/(N·m) of a joint or the base, m/N of a stand, 1 of an element (relative).
    /// `None` for shapes over the load, which have no one size, and where no size would do.
    pub size: Option<f64>,
    /// Whether the part can have that size: no joint, base or stand is stiffer than rigid, a joint in a closed loop gives way no more
    /// than a pin, and no property of an element is wrong by more than a factor of ten.
    pub possible: bool,
}
