//! How large a gain must be before it is believed: the whole search on noise alone.
//!
//! On noise alone the gain of every shape is a function of white numbers and the shape's vector only. Ten thousand draws of white
//! noise through all shapes of all candidates give the largest gain of each law; one constant for all laws makes the chance that any of
//! them passes exactly the level.

use std::collections::BTreeMap;
use std::ops::Range;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use stiffbench_beams::physics::{Law, Place};
use stiffbench_numeric::statistics::normal_upper_tail;

use super::candidate::Candidate;
use super::draws::{BLOCK, DrawTable, Drawn, Kind, Told};
use super::leftover::{Pattern, Stratum};
use super::observations::Observations;
use super::rounded::RoundedNoise;
use super::screen::WhiteCandidate;
use super::space::{Space, dot};

/// Chance that noise alone passes for one of the laws: together with what is left over 4 %.
pub const LAW_LEVEL: f64 = 0.035;

/// Chance that noise alone passes for structure that is left over.
pub const LEFT_OVER_LEVEL: f64 = 0.005;

/// Draws of noise.
pub const DRAWS: usize = 10_000;
const _: () = assert!(DRAWS.is_multiple_of(BLOCK), "draws come in whole blocks");

/// Shapes of one candidate whose directions differ by less count as one in the draws (cosine).
const SAME: f64 = 0.985;

/// No limit is lower: readings 20 times likelier with an effect than without, twice the logarithm. A loose member has no size to be fitted,
/// and one that changes next to nothing would pass by next to nothing.
const LEAST_LIMIT: f64 = 6.0;

/// A law, and whether it is its wide search.
pub type Family = (Law, bool);

/// Limits of the gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// For each law: drop of the weighted squares (χ² scale) that noise alone reaches with the law's share of the level.
    pub laws: BTreeMap<Family, f64>,
    /// The same for patterns that belong to no law.
    pub left_over: f64,
    /// Level that each law has in the end.
    pub levels: BTreeMap<Family, f64>,
    /// Sorted largest gains of the patterns, one a draw; for p-values.
    left_over_draws: Vec<f64>,
    /// The same for each law.
    law_draws: BTreeMap<Family, Vec<f64>>,
}

impl Limits {
    /// The limit of a law; of one that had no shape when the limits were drawn, the highest of all.
    #[must_use]
    pub fn of(&self, family: Family) -> f64 {
        let highest = || self.laws.values().copied().fold(0.0, f64::max);
        self.laws.get(&family).copied().unwrap_or_else(highest)
    }

    /// Chance that noise alone leaves a pattern with this gain.
    #[must_use]
    pub fn left_over_p(&self, gain: f64) -> f64 {
        exceedance(&self.left_over_draws, gain)
    }

    /// Chance that noise alone gives any law this gain or, for another law, one as rare.
    #[must_use]
    pub fn family_p(&self, family: Family, gain: f64) -> f64 {
        let Some(draws) = self.law_draws.get(&family) else {
            return 1.0;
        };
        let own = exceedance(draws, gain);
        let share = self.levels.get(&family).copied().unwrap_or(1.0);
        // As many times rarer than its level, out of the whole level.
        (own / share * LAW_LEVEL).min(1.0)
    }
}

fn exceedance(sorted: &[f64], gain: f64) -> f64 {
    let above = sorted.len() - sorted.partition_point(|value| *value < gain);
    (above as f64 + 1.0) / (sorted.len() as f64 + 1.0)
}

/// Works out the limits for candidates and patterns.
///
/// # Arguments
/// - `residuals`: white residuals of the baseline; the draws have their distribution, so that skewed or long-tailed readings raise the
///   limits of the laws that lean on few of them.
pub(super) fn limits(
    (observations, space): (&Observations, &Space),
    candidates: Vec<WhiteCandidate>,
    patterns: Vec<Pattern>,
    residuals: &[f64],
    rounded: Option<&RoundedNoise<'_>>,
    seed: u64,
) -> Limits {
    let families: Vec<Family> = {
        let mut all: Vec<Family> = candidates
            .iter()
            .filter(|c| !c.shapes.is_empty())
            .map(|c| (c.candidate.law, c.candidate.wide))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut places = Vec::new();
    let of_candidate = |candidate: &Candidate| {
        let family = (candidate.law, candidate.wide);
        let place = families.iter().position(|f| *f == family);
        let kind = kind_of(candidate, &mut places);
        (kind, place.unwrap_or(families.len()))
    };
    let seen = candidates.iter().map(|white| &white.candidate);
    let kinds: Vec<(Kind, usize)> = seen.map(of_candidate).collect();
    let mut drawn: Vec<Drawn> = candidates
        .into_par_iter()
        .zip(kinds)
        .flat_map_iter(|(candidate, (kind, family))| drawn_of(space, candidate, kind, family))
        .collect();
    let mut groups = Vec::new();
    drawn.extend(patterns.into_iter().map(|pattern| Drawn {
        kind: match pattern.stratum {
            Stratum::Rest => Kind::Period,
            _ => Kind::Pattern(number_of(&mut groups, &pattern.group)),
        },
        family: families.len(),
        units: pattern.units,
        length: 1.0,
        scale: [f64::NEG_INFINITY, f64::INFINITY],
    }));
    let cells: Vec<Range<usize>> = observations
        .cells
        .iter()
        .map(|c| c.readings.clone())
        .collect();
    let table = DrawTable::new(space, &cells, families.len() + 1, drawn);
    let pool = smoothed(&pool(residuals), seed);
    let draws = draw(&table, &pool, rounded, seed);
    calibrate(&families, draws)
}

/// What a candidate shares its bases with.
///
/// # Arguments
/// - `places`: those met before, of runs without their step.
fn kind_of(candidate: &Candidate, places: &mut Vec<Place>) -> Kind {
    match &candidate.place {
        joint @ Place::Joint(_) => Kind::Joint(number_of(places, joint)),
        Place::Run {
            pose,
            direction,
            repeat,
            ..
        } => {
            let run = Place::Run {
                pose: pose.clone(),
                direction: *direction,
                repeat: *repeat,
                step: 0,
            };
            Kind::Slip(number_of(places, &run))
        }
        _ if candidate.law.search.phase.is_some() => Kind::Period,
        _ => Kind::Law,
    }
}

/// The place of something in a list, appended where it is new.
fn number_of<T: PartialEq + Clone>(known: &mut Vec<T>, wanted: &T) -> usize {
    known
        .iter()
        .position(|one| one == wanted)
        .unwrap_or_else(|| {
            known.push(wanted.clone());
            known.len() - 1
        })
}

/// What of a candidate is drawn: its shapes, but for those of nearly the same direction.
fn drawn_of(space: &Space, candidate: WhiteCandidate, kind: Kind, family: usize) -> Vec<Drawn> {
    let mut drawn: Vec<Drawn> = Vec::new();
    // Those of any size, with their products with what the fit absorbs.
    let mut free: Vec<(usize, Vec<f64>)> = Vec::new();
    for shape in candidate.shapes {
        let length = shape.square.sqrt();
        let mut units = shape.vectors;
        for value in &mut units[0] {
            *value /= length;
        }
        // Nearly the same direction with as free a size adds nothing to the largest gain.
        if units.len() == 1 && shape.shape.scale[1] == f64::INFINITY {
            let absorbed = space.absorbed(&units[0]);
            let same = free.iter().any(|(place, other)| {
                let cosine = dot(&drawn[*place].units[0], &units[0]) - dot(other, &absorbed);
                drawn[*place].scale == shape.shape.scale && cosine > SAME
            });
            if same {
                continue;
            }
            free.push((drawn.len(), absorbed));
        }
        drawn.push(Drawn {
            kind,
            family,
            units,
            length,
            scale: shape.shape.scale,
        });
    }
    drawn
}

/// Readings from which on their residuals tell their distribution; with fewer the draws are normal.
const ENOUGH_FOR_A_DISTRIBUTION: usize = 200;

/// Residuals beyond this many standard deviations are drawn as if they were there: they may be the effect that is looked for.
const LARGEST_DRAWN: f64 = 4.5;

/// Normal part added to each residual drawn, so that a draw is none of the few hundred values seen.
const SMOOTHING: f64 = 0.3;

/// Residuals of mean 0 and standard deviation 1, as seen by the median deviation, the outermost drawn in.
fn pool(residuals: &[f64]) -> Vec<f64> {
    if residuals.len() < ENOUGH_FOR_A_DISTRIBUTION {
        return Vec::new();
    }
    let limited: Vec<f64> = {
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        // 0.6745 is the median of |z| for a normal z; the limit needs no more than a rough size.
        let sd = stiffbench_numeric::statistics::median(&mut sizes).unwrap_or(1.0) / 0.6745;
        let most = LARGEST_DRAWN * sd.max(f64::MIN_POSITIVE);
        residuals.iter().map(|r| r.clamp(-most, most)).collect()
    };
    let n = limited.len() as f64;
    let mean = limited.iter().sum::<f64>() / n;
    let variance = limited.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n;
    let sd = variance.sqrt().max(f64::MIN_POSITIVE);
    limited.iter().map(|r| (r - mean) / sd).collect()
}

/// Smoothed residuals from which draws are taken: so many that each is rare.
const SMOOTHED: usize = 1 << 16;

/// Residuals of a pool, each as often as any other, with other normal parts each time.
fn smoothed(pool: &[f64], seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let each = SMOOTHED / pool.len().max(1);
    let all = std::iter::repeat_n(pool, each).flatten();
    all.map(|residual| {
        let normal: f64 = StandardNormal.sample(&mut rng);
        ((residual + SMOOTHING * normal) / (1.0 + SMOOTHING * SMOOTHING).sqrt()) as f32
    })
    .collect()
}

/// Fills memory with noise.
///
/// # Arguments
/// - `pool`: what is drawn from; normal numbers if it is empty.
fn fill(noise: &mut [f32], pool: &[f32], rng: &mut ChaCha8Rng) {
    if pool.is_empty() {
        noise.fill_with(|| StandardNormal.sample(rng));
        return;
    }
    // The high half of 32 random bits times the count is a place in it: two from one random number.
    let taken = |bits: u64| pool[(((bits & 0xffff_ffff) * pool.len() as u64) >> 32) as usize];
    for pair in noise.chunks_mut(2) {
        let bits = rng.next_u64();
        for (value, bits) in pair.iter_mut().zip([bits, bits >> 32]) {
            *value = taken(bits);
        }
    }
}

/// Puts the noise of a coarse gauge in the place of that of its readings.
fn fill_rounded(noise: &mut [f32], rounded: &RoundedNoise<'_>, rng: &mut ChaCha8Rng) {
    for draw in 0..BLOCK {
        let of_draw = noise.iter_mut().skip(draw).step_by(BLOCK);
        for (value, white) in of_draw.zip(rounded.draw(rng)) {
            *value = white as f32;
        }
    }
}

/// Largest gain of each family, the patterns last, for each draw.
fn draw(
    table: &DrawTable,
    pool: &[f32],
    rounded: Option<&RoundedNoise<'_>>,
    seed: u64,
) -> Vec<Vec<f64>> {
    let blocks: Vec<Vec<[f32; BLOCK]>> = (0..DRAWS / BLOCK)
        .into_par_iter()
        .map_init(Told::default, |memory, block| {
            // Each block has a stream of its own, the smoothed residuals have the first: no seed has blocks of another.
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(1 + block as u64);
            let mut noise = vec![0.0; table.length() * BLOCK];
            fill(&mut noise, pool, &mut rng);
            if let Some(rounded) = rounded {
                fill_rounded(&mut noise, rounded, &mut rng);
            }
            table.largest(&mut noise, memory)
        })
        .collect();
    let families = blocks.first().map_or(0, Vec::len);
    (0..families)
        .map(|family| {
            blocks
                .iter()
                .flat_map(|block| block[family].map(f64::from))
                .collect()
        })
        .collect()
}

/// Length of an effect, standard errors, at which the laws are found as often as a level allows.
///
/// At this length a law with a single shape is found in more than nine of ten sessions; shorter effects are weak evidence anyway.
const DESIGN_LENGTH: f64 = 4.5;

/// Share of null samples by which the number of independent shapes of a law is counted.
const TAIL: f64 = 0.01;

/// Critical values under which noise alone passes for any law with the chance of the level, and with which most laws are found.
///
/// Of all ways to split a level between laws that one is taken which finds the most of them at the design length μ: where a little more
/// level would help each law as much. A law whose null samples exceed z² as often as m independent shapes, 2 m Φ(-z), is found with the
/// chance Φ(μ - z); that of the derivatives is exp(μ z)/m up to a constant, so that
///
/// ```text
/// z = z₁ + ln(m)/μ
/// ```
///
/// with one z₁ for all laws (the optimal weights of Roeder & Wasserman, Statistical Science 24, 2009, p. 398, for one size of effect).
fn calibrate(families: &[Family], mut draws: Vec<Vec<f64>>) -> Limits {
    let mut left_over_draws = draws.pop().unwrap_or_default();
    left_over_draws.par_sort_unstable_by(f64::total_cmp);
    let sorted: Vec<Vec<f64>> = draws
        .par_iter()
        .map(|values| {
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            sorted
        })
        .collect();
    let further: Vec<f64> = sorted
        .iter()
        .map(|values| independent_shapes(values).ln() / DESIGN_LENGTH)
        .collect();
    let limits_at = |z: f64| -> Vec<f64> {
        let of_law = |further: &f64| (z + further).max(0.0).powi(2).max(LEAST_LIMIT);
        further.iter().map(of_law).collect()
    };
    let count = draws.first().map_or(0, Vec::len);
    let passing = |limits: &[f64]| {
        (0..count)
            .into_par_iter()
            .with_min_len(BLOCK)
            .filter(|&number| {
                draws
                    .iter()
                    .zip(limits)
                    .any(|(values, limit)| values[number] > *limit)
            })
            .count() as f64
            / count.max(1) as f64
    };
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if passing(&limits_at(middle)) > LAW_LEVEL {
            low = middle;
        } else {
            high = middle;
        }
    }
    let limits = limits_at(high);
    let level = |(values, limit): (&Vec<f64>, &f64)| exceedance(values, *limit);
    let levels: Vec<f64> = sorted.iter().zip(&limits).map(level).collect();
    Limits {
        laws: families.iter().copied().zip(limits).collect(),
        left_over: quantile(&left_over_draws, 1.0 - LEFT_OVER_LEVEL),
        levels: families.iter().copied().zip(levels).collect(),
        left_over_draws,
        law_draws: families.iter().copied().zip(sorted).collect(),
    }
}

/// How many independent shapes would exceed a large gain as often as null samples of a law do.
fn independent_shapes(sorted: &[f64]) -> f64 {
    let z = quantile(sorted, 1.0 - TAIL).max(0.0).sqrt();
    TAIL / (2.0 * normal_upper_tail(z)).max(f64::MIN_POSITIVE)
}

/// The value that a share of sorted values does not exceed; beyond the last, the last.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() {
        return f64::INFINITY;
    }
    let place = (share * sorted.len() as f64).ceil() as usize;
    sorted[place.clamp(1, sorted.len()) - 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::ReadingNoise;
    use crate::mismatch::changes::tests::observations;
    use crate::mismatch::noise::Whitening;
    use crate::mismatch::{GaugeSteps, Observations};

    #[test]
    fn errors_of_a_coarse_gauge_keep_their_readings_in_every_draw() {
        // A gauge of 10 um with errors of 0.5 um, always at 3 um in the first run and at -3 um in the others: it reads zero.
        let observations = Observations {
            steps: GaugeSteps {
                displacement_m: Some(1e-5),
                ..GaugeSteps::default()
            },
            ..observations()
        };
        let noise = ReadingNoise {
            reading_sd_m: (2.5e-13_f64 + 1e-10 / 12.0).sqrt(),
            zero_sd_m: 1e-9,
            run_slope_sd: 1e-9,
        };
        let zeros = vec![0.0; observations.len()];
        let whitening = Whitening::new(&observations, &noise, &zeros, &zeros);
        let stood_m = |run: usize| if run == 0 { 3e-6 } else { -3e-6 };
        let stood: Vec<f64> = observations
            .readings
            .iter()
            .map(|r| stood_m(r.run))
            .collect();
        let rounded = RoundedNoise::new(&observations, &whitening, stood.clone()).unwrap();
        let mut block = vec![f32::NAN; observations.len() * BLOCK];
        fill_rounded(&mut block, &rounded, &mut ChaCha8Rng::seed_from_u64(1));
        for (draws, stood) in block.chunks(BLOCK).zip(&stood) {
            let error = -stood / noise.reading_sd_m;
            assert!(
                draws
                    .iter()
                    .all(|white| (f64::from(*white) - error).abs() < 1e-3)
            );
        }
    }
}
