//! Every shape of every candidate against the residuals, with the fit's freedom projected out: linear, exact in the shape, in parallel.

use rayon::prelude::*;

use crate::physics::{Effect, Law, LawSet, Place, PoseMechanics, Twists, period_m};

use super::candidate::{Candidate, PHASES, Shape};
use super::observations::Observations;
use super::space::{Space, dot, norm};

/// The solved poses of one structure, shared by all threads.
#[derive(Debug, Clone)]
pub(super) struct Frozen {
    pub(super) poses: Vec<PoseMechanics>,
    pub(super) joints: Vec<String>,
}

impl Frozen {
    /// Displacements of all readings under effects, m; `None` if one sits in a joint that is not there.
    pub(super) fn predict(
        &self,
        observations: &Observations,
        effects: &[&Effect],
        twists: &mut Twists,
        out: &mut [f64],
    ) -> Option<()> {
        let mut laws = LawSet::default();
        for effect in effects
            .iter()
            .filter(|effect| effect.law != Law::LooseMember)
        {
            let joint = match &effect.place {
                Place::Joint(name) => Some(self.joints.iter().position(|joint| joint == name)?),
                _ => None,
            };
            laws.push(effect, joint);
        }
        for (index, run) in observations.runs.iter().enumerate() {
            laws.displacements_m(
                &self.poses[observations.cells[run.cell].pose],
                &observations.run_loads(index),
                twists,
                &mut out[run.readings.clone()],
            );
        }
        Some(())
    }
}

/// A shape, white and projected.
#[derive(Debug, Clone)]
pub(super) struct WhiteShape {
    pub(super) shape: Shape,
    /// One vector, or two orthogonal ones for a law with a phase.
    pub(super) vectors: Vec<Vec<f64>>,
    /// Square of the first vector.
    pub(super) square: f64,
    /// Largest change of a reading, m.
    pub(super) peak_m: f64,
}

/// A candidate with its shapes ready.
#[derive(Debug, Clone)]
pub(super) struct WhiteCandidate {
    pub(super) candidate: Candidate,
    pub(super) shapes: Vec<WhiteShape>,
}

/// What the screen says of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Screened {
    /// Place of the best shape.
    pub(super) shape: usize,
    /// Its size, as a multiple of the shape's.
    pub(super) scale: f64,
    /// Drop of the weighted squares.
    pub(super) gain: f64,
    /// The drop that the impossible sign would give, if the law has one.
    pub(super) impossible_gain: f64,
}

/// An effect this many standard errors long at its largest possible size cannot be seen.
const INVISIBLE: f64 = 1e-3;

/// Works out all shapes.
pub(super) fn white_candidates(
    observations: &Observations,
    frozen: &Frozen,
    effects: &[Effect],
    space: &Space,
    candidates: Vec<Candidate>,
) -> Vec<WhiteCandidate> {
    let n = observations.len();
    let base: Vec<&Effect> = effects.iter().collect();
    let mut before = vec![0.0; n];
    let known = frozen.predict(observations, &base, &mut Twists::default(), &mut before);
    if known.is_none() {
        return Vec::new();
    }
    let whiten = |candidates: Vec<Candidate>| -> Vec<WhiteCandidate> {
        candidates
            .into_par_iter()
            .map_init(
                || (Twists::default(), vec![0.0; n]),
                |(twists, scratch), candidate| {
                    let shapes = candidate
                        .shapes
                        .iter()
                        .filter_map(|shape| {
                            let mut vectors: Vec<Vec<f64>> = Vec::new();
                            let mut peak_m = 0.0_f64;
                            let phases: &[f64] = if candidate.law == Law::GaugePeriodic {
                                &PHASES
                            } else {
                                &PHASES[..1]
                            };
                            for phase in phases {
                                let mut effect = effect_of(&candidate, shape);
                                if candidate.law == Law::GaugePeriodic {
                                    effect.values[2] = *phase;
                                }
                                if !add_to_what_is_read(
                                    observations,
                                    effects,
                                    &effect,
                                    &before,
                                    scratch,
                                ) {
                                    let mut all = base.clone();
                                    all.push(&effect);
                                    frozen.predict(observations, &all, twists, scratch)?;
                                }
                                for (value, before) in scratch.iter_mut().zip(&before) {
                                    *value -= before;
                                    peak_m = peak_m.max(value.abs());
                                }
                                let mut white = space.white(scratch);
                                space.project(&mut white);
                                for other in &vectors {
                                    let share = dot(other, &white) / dot(other, other);
                                    for (value, other) in white.iter_mut().zip(other) {
                                        *value -= share * other;
                                    }
                                }
                                vectors.push(white);
                            }
                            let square = dot(&vectors[0], &vectors[0]);
                            let seen = square > INVISIBLE * INVISIBLE;
                            seen.then(|| WhiteShape {
                                shape: shape.clone(),
                                vectors,
                                square,
                                peak_m,
                            })
                        })
                        .collect();
                    WhiteCandidate { candidate, shapes }
                },
            )
            .collect()
    };
    // A joint that could not be seen if it turned freely cannot be seen under any law: none turns it further.
    let (compliances, rest): (Vec<Candidate>, Vec<Candidate>) = candidates
        .into_iter()
        .partition(|candidate| candidate.law == Law::JointCompliance);
    let mut out = whiten(compliances);
    let unseen: Vec<Place> = out
        .iter()
        .filter(|white| !white.can_be_seen())
        .map(|white| white.candidate.place.clone())
        .collect();
    let rest = rest
        .into_iter()
        .filter(|candidate| !unseen.contains(&candidate.place))
        .collect();
    out.extend(whiten(rest));
    out
}

/// Displacements under one effect more, m, where those without it give them to the last bit: the effect acts after all mechanics, and
/// nothing among the others acts after it. Slips and periods are most of the shapes, and the mechanics most of the work.
///
/// # Returns
/// `false` if the effect is another one, and nothing was written.
fn add_to_what_is_read(
    observations: &Observations,
    others: &[Effect],
    effect: &Effect,
    before: &[f64],
    out: &mut [f64],
) -> bool {
    let is_last = |law: Law| law == Law::GaugePeriodic || law == effect.law;
    if others.iter().any(|other| is_last(other.law)) {
        return false;
    }
    match (&effect.place, &effect.values[..]) {
        (Place::DisplacementGauge, &[amplitude, period, phase]) => {
            let readings = before.iter().zip(&observations.loads);
            for (out, (before, load)) in out.iter_mut().zip(readings) {
                let read = load.position_m.unwrap_or(*before);
                *out = before + period_m([amplitude, period, phase], read);
            }
            true
        }
        (
            Place::Run {
                pose,
                direction,
                repeat,
                step,
            },
            &[jump],
        ) => {
            out.copy_from_slice(before);
            for run in observations.runs.iter().filter(|run| run.repeat == *repeat) {
                let cell = &observations.cells[run.cell];
                if cell.direction != *direction || observations.poses[cell.pose] != *pose {
                    continue;
                }
                for reading in run.readings.clone() {
                    if observations.loads[reading].step >= *step {
                        out[reading] += jump;
                    }
                }
            }
            true
        }
        _ => false,
    }
}

impl WhiteCandidate {
    /// Whether its largest possible effect is longer than two standard errors.
    fn can_be_seen(&self) -> bool {
        self.shapes.iter().any(|shape| {
            let largest = shape.shape.scale[1];
            largest == f64::INFINITY || largest * largest * shape.square > 4.0
        })
    }
}

/// The effect of a shape.
pub(super) fn effect_of(candidate: &Candidate, shape: &Shape) -> Effect {
    Effect {
        law: candidate.law,
        place: candidate.place.clone(),
        values: shape.values.clone(),
    }
}

impl WhiteShape {
    /// Best size and the drop of the squares for residuals; and the drop of the impossible sign.
    pub(super) fn gain(&self, residuals: &[f64]) -> (f64, f64, f64) {
        let product = dot(&self.vectors[0], residuals);
        if let [_, second] = &self.vectors[..] {
            let first = product * product / self.square;
            let other = dot(second, residuals).powi(2) / dot(second, second).max(f64::MIN_POSITIVE);
            return (product / self.square, first + other, 0.0);
        }
        let [lowest, highest] = self.shape.scale;
        let free = product / self.square;
        let scale = free.clamp(lowest, highest);
        let gain = scale * (2.0 * product - scale * self.square);
        let impossible = if lowest >= 0.0 && free < 0.0 {
            product * product / self.square
        } else {
            0.0
        };
        (scale, gain, impossible)
    }

    /// The effect at a size, with its phase from the residuals where it has one.
    pub(super) fn effect(&self, candidate: &Candidate, scale: f64, residuals: &[f64]) -> Effect {
        let mut effect = effect_of(candidate, &self.shape);
        if let [sine, cosine] = &self.vectors[..] {
            let s = dot(sine, residuals) / norm(sine).powi(2);
            let c = dot(cosine, residuals) / norm(cosine).powi(2);
            effect.values[0] *= s.hypot(c);
            effect.values[2] = c.atan2(s);
            return effect;
        }
        let factor = self.shape.size_factor(scale);
        if let Some(size) = effect.values.first_mut() {
            *size *= factor;
        }
        if candidate.law == Law::JointNonlinearity {
            effect.values[1] *= factor;
        }
        effect
    }
}

/// Screens all candidates against residuals.
pub(super) fn screen(candidates: &[WhiteCandidate], residuals: &[f64]) -> Vec<Option<Screened>> {
    candidates
        .par_iter()
        .map(|candidate| {
            let mut best: Option<Screened> = None;
            let mut impossible_gain = 0.0_f64;
            for (place, shape) in candidate.shapes.iter().enumerate() {
                let (scale, gain, impossible) = shape.gain(residuals);
                impossible_gain = impossible_gain.max(impossible);
                if best.is_none_or(|best| gain > best.gain) {
                    best = Some(Screened {
                        shape: place,
                        scale,
                        gain,
                        impossible_gain: 0.0,
                    });
                }
            }
            best.map(|best| Screened {
                impossible_gain,
                ..best
            })
        })
        .collect()
}

impl WhiteShape {
    /// Whether the size may have any value of its sign.
    pub(super) fn scale_is_free(&self) -> bool {
        self.shape.scale[1] == f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::{GaugeSteps, PlannedCell, PlannedLoad};
    use crate::structure::TwistInfluence;
    use crate::test_point::{Branch, Direction};

    /// Two cells, two repeats of five loads.
    fn observations() -> Observations {
        let load = |repeat: u32, step: u32| PlannedLoad {
            step,
            force_n: -13.7 * f64::from(step),
            branch: Branch::Loading,
            repeat,
            hold_s: 5.0,
            time_s: 12.0 * f64::from(10 * repeat + step),
            temperature_deg_c: None,
            zero_before: step == 0,
        };
        let cell = |direction| PlannedCell {
            pose: "P1".into(),
            direction,
            loads: (1..=2)
                .flat_map(|repeat| (0..5).map(move |step| load(repeat, step)))
                .collect(),
        };
        let cells = [Direction::X, Direction::Y].map(cell);
        Observations::planned(&cells, GaugeSteps::default(), None)
    }

    #[test]
    fn slips_and_periods_are_added_to_the_last_bit() {
        let observations = observations();
        let frozen = Frozen {
            poses: vec![PoseMechanics {
                influence: TwistInfluence::of_one_joint(3e-7, 0.3),
                ..PoseMechanics::default()
            }],
            joints: vec!["A3".to_owned()],
        };
        let predict = |effects: &[&Effect]| {
            let mut out = vec![f64::NAN; observations.len()];
            frozen
                .predict(&observations, effects, &mut Twists::default(), &mut out)
                .unwrap();
            out
        };
        let effect = |text: &str| text.parse::<Effect>().unwrap();
        let others = [
            effect("joint-compliance@A3:c=1urad/(N*m)"),
            effect("creep@structure:k=0.01 1/decade,t0=1s"),
        ];
        let before = predict(&others.each_ref());
        for (text, changed) in [
            ("slip@P1.y.2.3:jump=7um", 2),
            (
                "gauge-periodic@displacement:amplitude=3um,period=150um,phase=0.4rad",
                20,
            ),
        ] {
            let one = effect(text);
            let mut added = vec![f64::NAN; observations.len()];
            assert!(add_to_what_is_read(
                &observations,
                &others,
                &one,
                &before,
                &mut added
            ));
            assert_eq!(added, predict(&[&others[0], &others[1], &one]), "{text}");
            let differ = added.iter().zip(&before).filter(|(a, b)| a != b);
            assert_eq!(differ.count(), changed, "{text}");
        }
        // What acts in the joints does not only add; nor does a slip below a period that is there.
        let compliance = effect("joint-compliance@A3:c=1urad/(N*m)");
        let period = effect("gauge-periodic@displacement:amplitude=3um,period=150um,phase=0.4rad");
        let slip = effect("slip@P1.y.2.3:jump=7um");
        let mut out = before.clone();
        assert!(!add_to_what_is_read(
            &observations,
            &others,
            &compliance,
            &before,
            &mut out
        ));
        assert!(!add_to_what_is_read(
            &observations,
            &[period],
            &slip,
            &before,
            &mut out
        ));
    }
}
