//! The four laws of a joint: twist φ from the moment that would act if the joint were rigid.
//!
//! In a closed loop the twist unloads the joint: τ = T - k φ, with T the moment of the rigid joint (other joints' twists included) and
//! k the stiffness that the structure sets against the twist. Each law below solves that with its own equation in closed form.

#![expect(
    clippy::inline_always,
    reason = "twists side by side are compiled for the instructions of their caller"
)]

use super::effect::Effect;
use super::law::Law;

/// A law of a joint with its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum JointLaw {
    /// twist = c τ.
    Compliance { c: f64 },
    /// Play behind a seat.
    Backlash { play: f64, seat_moment: f64 },
    /// A spring 1/c in parallel with a Coulomb slider.
    Friction { c: f64, friction_moment: f64 },
    /// twist = c τ + q τ |τ|.
    Nonlinearity { c: f64, q: f64 },
}

impl JointLaw {
    /// The law of an effect that sits in a joint.
    pub(super) fn of(effect: &Effect) -> Self {
        let v = |index: usize| effect.values.get(index).copied().unwrap_or(0.0);
        match effect.law {
            Law::JointBacklash => Self::Backlash {
                play: v(0),
                seat_moment: v(1),
            },
            Law::JointFriction => Self::Friction {
                c: v(0),
                friction_moment: v(1),
            },
            Law::JointNonlinearity => Self::Nonlinearity { c: v(0), q: v(1) },
            _ => Self::Compliance { c: v(0) },
        }
    }

    /// Moment per twist in a state, N·m/rad; infinite where the joint does not turn, zero where it turns freely.
    ///
    /// # Arguments
    /// - `twist_rad`, `moment_nm`: the state; without a moment the stiffness is that under the smallest one.
    pub(super) fn secant_nm_per_rad(self, twist_rad: f64, moment_nm: f64) -> f64 {
        if moment_nm != 0.0 {
            return if twist_rad == 0.0 {
                f64::INFINITY
            } else {
                moment_nm / twist_rad
            };
        }
        match self {
            Self::Compliance { c } | Self::Nonlinearity { c, .. } => 1.0 / c,
            Self::Backlash { play, seat_moment } if seat_moment == 0.0 && play > 0.0 => 0.0,
            Self::Friction {
                c,
                friction_moment: 0.0,
            } => 1.0 / c,
            Self::Backlash { .. } | Self::Friction { .. } => f64::INFINITY,
        }
    }

    /// How fast the twist grows with the driving moment, rad/(N·m); arguments as of [`JointLaw::twist_rad`], at that twist.
    pub(super) fn slope_rad_per_nm(
        self,
        driving_nm: f64,
        stiffness_nm_per_rad: f64,
        before_rad: f64,
    ) -> f64 {
        let k = stiffness_nm_per_rad.max(0.0);
        let twist = self.twist_rad(driving_nm, k, before_rad);
        match self {
            Self::Compliance { c } => c / (1.0 + c * k),
            Self::Backlash { play, .. } if twist == 0.0 || twist.abs() >= play => 0.0,
            Self::Backlash { .. } => 1.0 / k,
            Self::Friction { .. } if twist == before_rad => 0.0,
            Self::Friction { c, .. } => c / (1.0 + c * k),
            Self::Nonlinearity { c, q } => {
                // φ = c τ + q τ |τ|, τ = T - k φ.
                let growth = (c + 2.0 * q * (driving_nm - k * twist).abs()).max(0.0);
                growth / (1.0 + growth * k)
            }
        }
    }

    /// The twist, rad.
    ///
    /// # Arguments
    /// - `driving_nm`: T, the joint's moment at zero twist.
    /// - `stiffness_nm_per_rad`: k, not below zero.
    /// - `before_rad`: the twist at the reading before, zero in a virgin run; only friction remembers.
    pub(super) fn twist_rad(
        self,
        driving_nm: f64,
        stiffness_nm_per_rad: f64,
        before_rad: f64,
    ) -> f64 {
        let k = stiffness_nm_per_rad.max(0.0);
        match self {
            Self::Compliance { c } => compliance_twist(c, driving_nm, k),
            Self::Backlash { play, seat_moment } => {
                backlash_twist([play, seat_moment], driving_nm, k)
            }
            Self::Friction { c, friction_moment } => {
                friction_twist([c, friction_moment], driving_nm, k, before_rad)
            }
            Self::Nonlinearity { c, q } => nonlinear_twist([c, q], driving_nm, k),
        }
    }
}

/// Twist of c τ with τ = T - k twist.
#[inline(always)]
pub(super) fn compliance_twist(c: f64, driving_nm: f64, k: f64) -> f64 {
    c * driving_nm / (1.0 + c * k)
}

/// Twist of play behind a seat; all cases are worked out, so that loads can stand side by side.
#[inline(always)]
pub(super) fn backlash_twist([play, seat_moment]: [f64; 2], driving_nm: f64, k: f64) -> f64 {
    let beyond = driving_nm.abs() - seat_moment;
    let partly = beyond / k;
    let taken_up = if beyond >= k * play { play } else { partly };
    let taken_up = if beyond <= 0.0 { 0.0 } else { taken_up };
    taken_up.copysign(driving_nm)
}

/// Twist of a spring 1/c in parallel with a Coulomb slider.
#[inline(always)]
pub(super) fn friction_twist(
    [c, friction_moment]: [f64; 2],
    driving_nm: f64,
    k: f64,
    before_rad: f64,
) -> f64 {
    if c == 0.0 {
        return 0.0;
    }
    let slider = driving_nm - (k + 1.0 / c) * before_rad;
    if slider.abs() <= friction_moment {
        before_rad
    } else {
        c * (driving_nm - friction_moment.copysign(slider)) / (1.0 + c * k)
    }
}

/// Twist of c τ + q τ|τ| with τ = T - k twist; all cases are worked out, so that loads can stand side by side.
///
/// With q below zero the law has a largest twist, c²/(4|q|), at the moment c/(2|q|): beyond it the joint is at its stop.
#[inline(always)]
pub(super) fn nonlinear_twist([c, q]: [f64; 2], driving_nm: f64, k: f64) -> f64 {
    let driving = driving_nm.abs();
    let linear = 1.0 + c * k;
    let root = linear * linear + 4.0 * q * k * driving;
    let stop = c / (-2.0 * q);
    let at_the_stop = q < 0.0 && driving >= stop + k * c * stop * 0.5;
    let moment = 2.0 * driving / (linear + root.sqrt());
    let twist = if at_the_stop || root < 0.0 {
        c * c / (-4.0 * q)
    } else {
        (c + q * moment) * moment
    };
    twist.copysign(driving_nm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn backlash_follows_its_three_pieces() {
        let law = JointLaw::Backlash {
            play: 1e-3,
            seat_moment: 2.0,
        };
        // k = 1000 N·m/rad takes up the play over 1 N·m.
        for (driving, expected) in [(1.9, 0.0), (2.5, 0.5e-3), (3.5, 1e-3), (-2.5, -0.5e-3)] {
            assert!((law.twist_rad(driving, 1000.0, 0.0) - expected).abs() < 1e-15);
        }
        assert_eq!(law.twist_rad(2.1, 0.0, 0.0), 1e-3);
        assert_eq!(law.twist_rad(2.0, 0.0, 0.0), 0.0);
    }

    #[test]
    fn friction_sticks_slips_and_sticks_until_twice_its_moment() {
        let law = JointLaw::Friction {
            c: 1e-3,
            friction_moment: 2.0,
        };
        let mut twist = 0.0;
        let path = [
            (1.0, 0.0),
            (5.0, 3e-3),
            (2.0, 3e-3),
            (1.0, 3e-3),
            (0.0, 2e-3),
        ];
        for (moment, expected) in path {
            twist = law.twist_rad(moment, 0.0, twist);
            assert!((twist - expected).abs() < 1e-15, "{moment}: {twist}");
        }
    }

    proptest! {
        /// Every law's twist satisfies its own equation with τ = T - k φ.
        #[test]
        fn twists_satisfy_their_equation(
            c in 1e-6..1e-2_f64, q in -1e-4..1e-3_f64, driving in -50.0..50.0_f64, k in 0.0..1e4_f64,
        ) {
            let twist = JointLaw::Compliance { c }.twist_rad(driving, k, 0.0);
            let moment = driving - k * twist;
            prop_assert!((twist - c * moment).abs() <= 1e-9 * (c * driving).abs());
            let twist = JointLaw::Nonlinearity { c, q }.twist_rad(driving, k, 0.0);
            let moment = driving - k * twist;
            let stop = q < 0.0 && moment.abs() >= c / (-2.0 * q) * (1.0 - 1e-6);
            let law = c * moment + q * moment * moment.abs();
            prop_assert!(stop || (twist - law).abs() <= 1e-8 * (c * driving).abs(), "{twist} {law}");
        }

        /// Play never exceeds its size, and the moment stays at the seat while it is taken up.
        #[test]
        fn backlash_holds_its_seat(
            play in 1e-6..1e-2_f64, seat_moment in 0.0..20.0_f64, driving in -50.0..50.0_f64, k in 1.0..1e4_f64,
        ) {
            let twist = JointLaw::Backlash { play, seat_moment }.twist_rad(driving, k, 0.0);
            prop_assert!(twist.abs() <= play && twist * driving >= 0.0);
            let moment = (driving - k * twist).abs();
            if twist != 0.0 && twist.abs() < play {
                prop_assert!((moment - seat_moment).abs() < 1e-9 * driving.abs());
            }
        }
    }
}
