//! How force and displacement get from one load to the next.

/// How fast the jack is turned, N/s.
const JACK_N_PER_S: f64 = 20.0;

/// A turn of the jack takes this long at least, s.
const SHORTEST_RAMP_S: f64 = 0.1;

/// What is left when the jack stops dies away with this time constant, s, and is over after [`REST_S`]: less than the two seconds for which a
/// load is watched, so that what is read at their end is at rest.
const RELAXATION_S: f64 = 0.12;
const REST_S: f64 = 0.9;

/// Shares of a change that come only after the jack has stopped.
const FORCE_LEFT: f64 = 0.003;
const DISPLACEMENT_LEFT: f64 = 0.02;

/// Where force and displacement stand.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Stand {
    /// N, along the load.
    pub(super) force_n: f64,
    /// m, along the base axes, from where the tips of the gauges would hang free; zero where there is none.
    pub(super) along_m: [f64; 3],
}

impl Stand {
    /// This stand and another one on top.
    pub(super) fn plus(&self, by: &Self) -> Self {
        Self {
            force_n: self.force_n + by.force_n,
            along_m: std::array::from_fn(|axis| self.along_m[axis] + by.along_m[axis]),
        }
    }
}

/// A way from one stand to the next, and on from there under the same load.
#[derive(Debug, Clone, Default)]
pub(super) struct Motion {
    from: Stand,
    /// Stands, and when the way to each begins, s after the jack has stopped; the first is the load.
    stages: Vec<(f64, Stand)>,
    began_s: f64,
    ramp_s: f64,
}

impl Motion {
    /// Everything has always stood there.
    pub(super) fn standing(stand: Stand) -> Self {
        Self {
            from: stand,
            ..Self::default()
        }
    }

    /// Begins a way at a session time.
    pub(super) fn new(from: Stand, stages: Vec<(f64, Stand)>, now_s: f64) -> Self {
        let change_n = stages
            .first()
            .map_or(0.0, |(_, to)| (to.force_n - from.force_n).abs());
        Self {
            from,
            ramp_s: (change_n / JACK_N_PER_S).max(SHORTEST_RAMP_S),
            stages,
            began_s: now_s,
        }
    }

    /// The way from where everything stands at a session time to the same stands, each further by so much.
    pub(super) fn turned_by(&self, by: Stand, now_s: f64) -> Self {
        let stages = self.stages.iter().map(|(at_s, to)| (*at_s, to.plus(&by)));
        Self::new(self.at(now_s), stages.collect(), now_s)
    }

    /// Where everything stands at a session time.
    pub(super) fn at(&self, now_s: f64) -> Stand {
        let Some(&(_, load)) = self.stages.first() else {
            return self.from;
        };
        let stopped_s = now_s - self.began_s - self.ramp_s;
        let started = self.stages.partition_point(|(at_s, _)| *at_s <= stopped_s);
        if started > 1 {
            let (at_s, to) = self.stages[started - 1];
            return between(self.stages[started - 2].1, to, |_| {
                died_away(stopped_s - at_s, 1.0)
            });
        }
        between(self.from, load, |left| {
            if stopped_s >= 0.0 {
                died_away(stopped_s, left)
            } else {
                (1.0 - left) * ((now_s - self.began_s) / self.ramp_s).max(0.0)
            }
        })
    }

    /// Whether the load is set and nothing moves any more.
    pub(super) fn is_over(&self, now_s: f64) -> bool {
        self.stages.is_empty() || now_s - self.began_s >= self.ramp_s + REST_S
    }
}

/// The stand that has gone a share of the way, each quantity its own.
fn between(from: Stand, to: Stand, share: impl Fn(f64) -> f64) -> Stand {
    // At the end the number itself, without rounding.
    let way = |from: f64, to: f64, share: f64| {
        if share < 1.0 {
            from + share * (to - from)
        } else {
            to
        }
    };
    Stand {
        force_n: way(from.force_n, to.force_n, share(FORCE_LEFT)),
        along_m: std::array::from_fn(|axis| {
            let (from, to) = (from.along_m[axis], to.along_m[axis]);
            way(from, to, share(DISPLACEMENT_LEFT))
        }),
    }
}

/// Share of a way that is gone when a share was left `since_s` ago.
fn died_away(since_s: f64, left: f64) -> f64 {
    if since_s >= REST_S {
        1.0
    } else {
        1.0 - left * (-since_s / RELAXATION_S).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stand(force_n: f64, displacement_m: f64) -> Stand {
        Stand {
            force_n,
            along_m: [0.0, displacement_m, 0.0],
        }
    }

    #[test]
    fn the_jack_turns_at_its_rate_and_then_everything_stands() {
        let to = stand(-40.0, -1e-4);
        let motion = Motion::new(stand(0.0, 0.0), vec![(0.0, to)], 100.0);
        assert_eq!(motion.at(99.0), stand(0.0, 0.0));
        let halfway = motion.at(101.0);
        assert!((halfway.force_n + 20.0).abs() < 0.1, "{halfway:?}");
        assert!((halfway.along_m[1] + 5e-5).abs() < 2e-6);
        assert!(!motion.is_over(102.5));
        assert_ne!(motion.at(102.2), to);
        assert!(motion.is_over(103.0));
        assert_eq!(motion.at(103.0), to);
        assert_eq!(motion.at(1e6), to);
    }

    #[test]
    fn it_never_goes_back_or_too_far() {
        let to = stand(-40.0, -1e-4);
        let motion = Motion::new(stand(0.0, 0.0), vec![(0.0, to)], 0.0);
        let forces: Vec<f64> = (0..400)
            .map(|i| motion.at(f64::from(i) / 100.0).force_n)
            .collect();
        assert!(forces.is_sorted_by(|a, b| a >= b));
        assert_eq!(forces[399], -40.0);
    }

    #[test]
    fn under_a_hold_it_goes_on_to_the_next_stage() {
        let stages = vec![(0.0, stand(-20.0, -1.0e-4)), (50.0, stand(-20.0, -1.1e-4))];
        let motion = Motion::new(stand(0.0, 0.0), stages, 0.0);
        assert_eq!(motion.at(40.0).along_m[1], -1.0e-4);
        assert_eq!(motion.at(55.0).along_m[1], -1.1e-4);
        assert_eq!(motion.at(55.0).force_n, -20.0);
    }
}
