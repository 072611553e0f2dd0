//! How readings scattered in earlier sessions on the same bench.
//!
//! Variances found under the same conditions are pooled, each weighed by its degrees of freedom (JCGM 100:2008, 4.2.4): five sessions tell
//! the scatter five times as well as one, and a law that leans on it needs fewer standard errors to be as rare on noise alone.

use stiffbench_numeric::statistics::f_upper_tail;

use crate::mismatch::observed::ReadingNoise;
use crate::search::constants::FEWEST_DOF;

/// Earlier sessions with a smaller chance to have the same noise are not pooled (1). By judgement (94fd81c).
const LEAST_CHANCE_OF_SAME_NOISE: f64 = 0.01;

/// The variances of earlier sessions, reading, zero and slope of a run, with their degrees of freedom; none where nothing is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarlierNoise {
    variances: [f64; 3],
    dof: [f64; 3],
}

impl EarlierNoise {
    /// Standard deviations with the degrees of freedom of each.
    #[must_use]
    pub fn new(noise: &ReadingNoise, dof: [f64; 3]) -> Self {
        Self {
            variances: variances(noise),
            dof: dof.map(|dof| if dof < FEWEST_DOF { 0.0 } else { dof }),
        }
    }

    /// Several sessions in one. `None` of none.
    #[must_use]
    pub fn pooled(sessions: &[Self]) -> Option<Self> {
        let first = sessions.first()?;
        let sum = |value: &dyn Fn(&Self) -> f64| sessions.iter().map(value).sum::<f64>();
        let dof: [f64; 3] = std::array::from_fn(|i| sum(&|session| session.dof[i]));
        let variances = std::array::from_fn(|i| {
            if dof[i] > 0.0 {
                sum(&|session| session.dof[i] * session.variances[i]) / dof[i]
            } else {
                first.variances[i]
            }
        });
        Some(Self { variances, dof })
    }

    /// The standard deviations.
    #[must_use]
    pub fn noise(&self) -> ReadingNoise {
        let [reading_sd_m, zero_sd_m, run_slope_sd] = self.variances.map(f64::sqrt);
        ReadingNoise {
            reading_sd_m,
            zero_sd_m,
            run_slope_sd,
            ..ReadingNoise::default()
        }
    }

    /// Degrees of freedom of reading, zero and slope of a run.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> [f64; 3] {
        self.dof
    }

    /// Chance that two sessions with the same noise differ as much in any of the three (F tests of both tails, Bonferroni).
    #[must_use]
    pub fn chance_of_the_same(&self, other: &Self) -> f64 {
        let chances = (0..3).filter_map(|i| {
            if self.dof[i] == 0.0 || other.dof[i] == 0.0 {
                return None;
            }
            let ratio = self.variances[i] / other.variances[i];
            let upper = f_upper_tail(ratio, self.dof[i], other.dof[i])?;
            Some(2.0 * upper.min(1.0 - upper))
        });
        (3.0 * chances.fold(1.0, f64::min)).min(1.0)
    }

    /// Whether a session scatters as this one does, as far as the two can tell.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.chance_of_the_same(other) >= LEAST_CHANCE_OF_SAME_NOISE
    }

    /// Minus twice the logarithm of the likelihood of a noise: each variance that was found is a multiple of a chi-squared one.
    pub(crate) fn misfit(&self, noise: &ReadingNoise) -> f64 {
        variances(noise)
            .into_iter()
            .zip(self.variances.into_iter().zip(self.dof))
            .filter(|(_, (_, dof))| *dof > 0.0)
            .map(|(variance, (found, dof))| {
                let ratio = found / variance;
                dof * (ratio - 1.0 - ratio.ln())
            })
            .sum()
    }
}

/// Variances of reading, zero and slope of a run, never zero.
fn variances(noise: &ReadingNoise) -> [f64; 3] {
    [noise.reading_sd_m, noise.zero_sd_m, noise.run_slope_sd]
        .map(|sd| (sd * sd).max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session(scale: f64, dof: f64) -> EarlierNoise {
        let noise = ReadingNoise {
            reading_sd_m: scale * 1e-6,
            zero_sd_m: scale * 2e-6,
            run_slope_sd: scale * 1e-3,
            ..ReadingNoise::default()
        };
        EarlierNoise::new(&noise, [dof, 2.0, dof])
    }

    #[test]
    fn variances_are_pooled_by_their_degrees_of_freedom() {
        let pooled = EarlierNoise::pooled(&[session(1.0, 10.0), session(2.0, 30.0)]).unwrap();
        // (10 · 1 + 30 · 4) / 40 = 3.25
        let noise = pooled.noise();
        assert!((noise.reading_sd_m / 1e-6 - 3.25_f64.sqrt()).abs() < 1e-12);
        assert!((noise.run_slope_sd / 1e-3 - 3.25_f64.sqrt()).abs() < 1e-12);
        // Two degrees of freedom carry no information on a zero.
        assert_eq!(pooled.degrees_of_freedom(), [40.0, 0.0, 40.0]);
        assert_eq!(EarlierNoise::pooled(&[]), None);
    }

    #[test]
    fn the_likeliest_noise_is_the_pooled_one() {
        let sessions = [session(1.0, 10.0), session(2.0, 30.0)];
        let misfit = |noise: &ReadingNoise| -> f64 {
            sessions.iter().map(|session| session.misfit(noise)).sum()
        };
        let best = EarlierNoise::pooled(&sessions).unwrap().noise();
        for factor in [0.99, 1.01] {
            let reading = ReadingNoise {
                reading_sd_m: best.reading_sd_m * factor,
                ..best
            };
            let slope = ReadingNoise {
                run_slope_sd: best.run_slope_sd * factor,
                ..best
            };
            assert!(misfit(&reading) > misfit(&best) && misfit(&slope) > misfit(&best));
        }
        // Nothing is known of the zero.
        let zero = ReadingNoise {
            zero_sd_m: 1.0,
            ..best
        };
        assert_eq!(misfit(&zero), misfit(&best));
    }

    #[test]
    fn sessions_with_another_scatter_are_rejected() {
        assert_eq!(
            session(1.0, 40.0).chance_of_the_same(&session(1.0, 40.0)),
            1.0
        );
        // The upper 0.5 % point of F with 40 and 40 degrees of freedom is 2.2958 (two-sided 1 %, times three).
        let apart = session(2.2958_f64.sqrt(), 40.0).chance_of_the_same(&session(1.0, 40.0));
        assert!((apart - 0.03).abs() < 1e-4, "{apart}");
        let swapped = session(1.0, 40.0).chance_of_the_same(&session(2.2958_f64.sqrt(), 40.0));
        assert!((apart - swapped).abs() < 1e-9);
        // What two degrees of freedom tell is not compared with anything.
        assert_eq!(
            session(9.0, 2.0).chance_of_the_same(&session(1.0, 2.0)),
            1.0
        );
    }
}
