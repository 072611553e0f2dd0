//! Several sessions of one robot, analysed together: each with its zeros, runs, gauges and noise, all with one structure and one physics.
//!
//! The covariance has a block for each session. The ratios of their noises are those that each session shows alone, which hardly depend on
//! the physics, for the mean of every load step is free (`restricted_likelihood.rs`). The common scale is estimated with every model.

use std::collections::BTreeSet;
use std::ops::Range;

use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::observations::{
    GaugeSteps, Observations, ObservedCell, ObservedReading, ObservedRun, ObservedSession, Recorded,
};
use super::reading_noise::ReadingNoise;

/// Readings with one noise and one pair of gauges.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NoisePart {
    pub(crate) readings: Range<usize>,
    pub(crate) noise: ReadingNoise,
    pub(crate) steps: GaugeSteps,
}

impl NoisePart {
    /// Variance of what was read of a force, by its step and by what scatters, N².
    pub(crate) fn force_variance(&self) -> f64 {
        self.force_step_variance() + self.noise.gauges.force_sd_n.powi(2)
    }

    /// The part of it by the step, N².
    pub(crate) fn force_step_variance(&self) -> f64 {
        let step_n = self.steps.force_n.unwrap_or(0.0);
        step_n * step_n / 12.0
    }
}

impl Observations {
    /// The readings of several sessions, one after the other; their poses are called `session/pose`.
    ///
    /// # Arguments
    /// - `sessions`: what each is called, its readings, and the noise that these alone show ([`noise_alone`](crate::mismatch::noise_alone)).
    #[must_use]
    pub fn joined(sessions: &[(&str, &Self, ReadingNoise)]) -> Self {
        let all = |of: &dyn Fn(&Recorded) -> bool| sessions.iter().all(|one| of(&one.1.recorded));
        let steps = common_steps(sessions.iter().map(|one| one.1.steps));
        let recorded = Recorded {
            time: all(&|recorded| recorded.time),
            hold: all(&|recorded| recorded.hold),
            temperature: all(&|recorded| recorded.temperature),
        };
        let mut out = Self {
            free_zeros: sessions.iter().any(|one| one.1.free_zeros),
            gauges: gauges_of(sessions.iter().map(|one| one.1)),
            ..Self::without_readings(steps, recorded)
        };
        let (mut zeros, mut clock_s) = (0, 0.0);
        for (name, one, noise) in sessions {
            let (poses, cells) = (out.poses.len(), out.cells.len());
            let (runs, readings) = (out.runs.len(), out.readings.len());
            let moved = |range: &Range<usize>, by: usize| range.start + by..range.end + by;
            let named = one
                .poses
                .iter()
                .map(|pose| PoseId::new(&format!("{name}/{pose}")));
            out.poses.extend(named);
            out.cells.extend(one.cells.iter().map(|cell| ObservedCell {
                pose: cell.pose + poses,
                load: cell.load.clone(),
                read: cell.read,
                runs: moved(&cell.runs, runs),
                readings: moved(&cell.readings, readings),
            }));
            out.runs.extend(one.runs.iter().map(|run| ObservedRun {
                cell: run.cell + cells,
                repeat: run.repeat,
                session_run: run.session_run,
                readings: moved(&run.readings, readings),
                goes_on: run.goes_on,
            }));
            out.readings
                .extend(one.readings.iter().map(|reading| ObservedReading {
                    run: reading.run + runs,
                    zero: reading.zero + zeros,
                    time_s: reading.time_s.map(|time_s| time_s + clock_s),
                    ..*reading
                }));
            out.loads.extend_from_slice(&one.loads);
            out.displacement_m.extend_from_slice(&one.displacement_m);
            out.sessions.push(ObservedSession {
                name: (*name).to_owned(),
                readings: readings..out.readings.len(),
                runs: runs..out.runs.len(),
                steps: one.steps,
                release_n: one.release_n,
                noise: *noise,
            });
            let own = &out.readings[readings..];
            zeros = own
                .iter()
                .map(|reading| reading.zero + 1)
                .fold(zeros, u32::max);
            let times = own.iter().filter_map(|reading| reading.time_s);
            clock_s = times.fold(clock_s, f64::max);
        }
        out
    }

    /// The same readings with other names of the poses; poses of one name are one pose.
    ///
    /// # Arguments
    /// - `names`: one for each pose.
    #[must_use]
    pub fn with_pose_names(&self, names: &[PoseId]) -> Self {
        let mut out = self.clone();
        out.poses.clear();
        let mut places = Vec::with_capacity(names.len());
        for name in names {
            let known = out.poses.iter().position(|pose| pose == name);
            places.push(known.unwrap_or(out.poses.len()));
            if known.is_none() {
                out.poses.push(name.clone());
            }
        }
        for cell in &mut out.cells {
            cell.pose = places.get(cell.pose).copied().unwrap_or(cell.pose);
        }
        out
    }

    /// The noise of each session, under a noise of the first; one part where all readings are of one session.
    pub(crate) fn noise_parts(&self, noise: &ReadingNoise) -> Vec<NoisePart> {
        let Some(first) = self.sessions.first() else {
            return vec![NoisePart {
                readings: 0..self.len(),
                noise: *noise,
                steps: self.steps,
            }];
        };
        let parts = self.sessions.iter().map(|session| NoisePart {
            readings: session.readings.clone(),
            noise: session.noise.in_proportion(noise, &first.noise),
            steps: session.steps,
        });
        parts.collect()
    }

    /// The noise of one of several sessions, under a noise of the first.
    #[must_use]
    pub fn noise_of_session(&self, session: usize, noise: &ReadingNoise) -> Option<ReadingNoise> {
        let session = self.sessions.get(session)?;
        let first = self.sessions.first()?;
        Some(session.noise.in_proportion(noise, &first.noise))
    }

    /// Force between the loads of a run, if each load is released before the next.
    pub(crate) fn release_of(&self, run: usize) -> Option<f64> {
        let mut sessions = self.sessions.iter();
        let own = sessions.find(|session| session.runs.contains(&run));
        own.map_or(self.release_n, |session| session.release_n)
    }
}

/// Axes of the gauges of sessions, where several were read at once in any of them.
fn gauges_of<'o>(sessions: impl Iterator<Item = &'o Observations>) -> Vec<Direction> {
    let axes: BTreeSet<Direction> = sessions.flat_map(|one| one.gauges.clone()).collect();
    axes.into_iter().collect()
}

/// Steps that all gauges have.
fn common_steps(mut steps: impl Iterator<Item = GaugeSteps>) -> GaugeSteps {
    let first = steps.next().unwrap_or_default();
    steps.fold(first, |common, own| GaugeSteps {
        force_n: common.force_n.filter(|step| own.force_n == Some(*step)),
        displacement_m: common
            .displacement_m
            .filter(|step| own.displacement_m == Some(*step)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::noise::NoiseCovariance;
    use crate::mismatch::observed::reading_noise::GaugeNoise;
    use crate::mismatch::observed::tests::observations;
    use crate::search::{WhiteSpace, dot};

    const FINE: ReadingNoise = ReadingNoise {
        reading_sd_m: 1e-6,
        zero_sd_m: 2e-6,
        run_slope_sd: 0.0,
        growth_sd: 0.0,
        correlation: 0.0,
        gauges: GaugeNoise::ALIKE,
    };
    const COARSE: ReadingNoise = ReadingNoise {
        reading_sd_m: 3e-6,
        zero_sd_m: 4e-6,
        run_slope_sd: 0.01,
        growth_sd: 0.0,
        correlation: 0.5,
        gauges: GaugeNoise::ALIKE,
    };

    fn joined() -> Observations {
        let mut other = observations();
        other.release_n = Some(-1.0);
        Observations::joined(&[("a", &observations(), FINE), ("b", &other, COARSE)])
    }

    #[test]
    fn each_session_weighs_by_its_own_noise() {
        let (one, both) = (observations(), joined());
        let slope = |n: usize| -> Vec<f64> { (0..n).map(|i| 1e-5 * (i % 5) as f64).collect() };
        let zeros = |n: usize| vec![0.0; n];
        let n = one.len();
        let space = |observations: &Observations, noise: &ReadingNoise| {
            let n = observations.len();
            let noise = NoiseCovariance::new(observations, noise, &slope(n), &zeros(n)[..]);
            WhiteSpace::new(noise.covariance, &[], &[])
        };
        // Least squares of one size, which is 1 in the first session and 2 in the second, on readings without errors.
        let estimate = |space: &WhiteSpace, shape: &[f64], y: &[f64]| {
            let (shape, y) = (space.white(shape), space.white(y));
            let information = dot(&shape, &shape);
            (dot(&shape, &y) / information, information)
        };
        let shape = slope(n);
        let double: Vec<f64> = shape.iter().map(|s| 2.0 * s).collect();
        let (a, of_a) = estimate(&space(&one, &FINE), &shape, &shape);
        let (b, of_b) = estimate(&space(&one, &COARSE), &shape, &double);
        assert!((a - 1.0).abs() < 1e-12 && (b - 2.0).abs() < 1e-12 && of_a > 4.0 * of_b);
        let together = estimate(
            &space(&both, &FINE),
            &slope(2 * n),
            &[&shape[..], &double[..]].concat(),
        );
        // The weighted mean, and the sum of what each tells.
        let mean = (of_a * a + of_b * b) / (of_a + of_b);
        assert!((together.0 - mean).abs() < 1e-12, "{together:?} {mean}");
        assert!((together.1 / (of_a + of_b) - 1.0).abs() < 1e-12);
        // The noise of all grows with that of the first.
        let larger = ReadingNoise {
            reading_sd_m: 2.0 * FINE.reading_sd_m,
            ..FINE
        };
        let second = both.noise_of_session(1, &larger).unwrap();
        assert_eq!(second.reading_sd_m, 2.0 * COARSE.reading_sd_m);
        assert_eq!(second.zero_sd_m, COARSE.zero_sd_m);
        assert_eq!(second.run_slope_sd, COARSE.run_slope_sd);
    }

    #[test]
    fn joined_sessions_keep_what_is_their_own() {
        let (one, both) = (observations(), joined());
        let n = one.len();
        assert_eq!(both.len(), 2 * n);
        let names: Vec<&str> = both.poses.iter().map(PoseId::as_str).collect();
        assert_eq!(names, ["a/P1", "b/P1"]);
        let zeros = |range: Range<usize>| -> Vec<u32> {
            both.readings[range]
                .iter()
                .map(|reading| reading.zero)
                .collect()
        };
        let (first, second) = (zeros(0..n), zeros(n..2 * n));
        assert!(first.iter().all(|zero| !second.contains(zero)));
        for (run, own) in both.runs.iter().enumerate() {
            assert!(both.cells[own.cell].runs.contains(&run));
            assert!(
                both.readings[own.readings.clone()]
                    .iter()
                    .all(|r| r.run == run)
            );
        }
        let runs = one.runs.len();
        assert_eq!(both.release_of(runs - 1), None);
        assert_eq!(both.release_of(runs), Some(-1.0));
        // Without the first session the second is what it was.
        let keep: Vec<bool> = (0..2 * n).map(|reading| reading >= n).collect();
        let rest = both.filtered(&keep);
        assert_eq!(rest.displacement_m, one.displacement_m);
        assert_eq!(rest.sessions[0].readings, 0..0);
        assert_eq!(rest.sessions[1].readings, 0..n);
        assert_eq!(rest.sessions[1].runs, 0..runs);
        assert_eq!(rest.release_of(0), Some(-1.0));
        assert_eq!(rest.noise_parts(&FINE)[1].noise, COARSE);
        let plain = both.with_pose_names(&["P1".into(), "P1".into()]);
        assert_eq!(plain.poses, one.poses);
        assert!(plain.cells.iter().all(|cell| cell.pose == 0));
    }
}
