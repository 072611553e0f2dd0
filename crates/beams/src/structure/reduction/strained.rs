//! What elements carry under loads, and their strain energies.

use pulp::Simd;

use super::execute::States;
use super::member::{Constants, Middle, PlaneFrame, SpaceFrame, components};
use super::schedule::ReductionForm;
use stiffbench_numeric::simd::{Lane, Number, cross, subtract};

impl<S: Simd> Middle<S> {
    /// Twice the bilinear strain energy of two states, by the property it depends on: A, Iy, Iz, J.
    ///
    /// # Arguments
    /// - `states`: forces and moments at the middle, or motions against each other, along and about x, y, z.
    #[inline(always)]
    fn energies(
        &self,
        constants: &Constants,
        length: Lane<S>,
        [first, second]: [&ElementState<S>; 2],
    ) -> [Lane<S>; 4] {
        let [mut along, mut about] = [self.along, self.about];
        for i in 0..3 {
            along[i] = along[i] * first.along[i] * second.along[i];
            about[i] = about[i] * first.about[i] * second.about[i];
        }
        let [mut area, along_y, along_z] = along;
        let mut sway = [along_z, along_y];
        for plane in 0..2 {
            if constants.shear[plane] != 0.0 {
                let shear = length.of(constants.shear[plane]);
                let bow = length * length * length.of(constants.bow[plane]);
                let bending = sway[plane] * bow / (bow + shear);
                area += sway[plane] - bending;
                sway[plane] = bending;
            }
        }
        [area, about[1] + sway[0], about[2] + sway[1], about[0]]
    }
}

/// What an element carries, or how it deforms, at its middle: along and about its axes x, y, z.
#[derive(Clone, Copy)]
struct ElementState<S: Simd> {
    along: [Lane<S>; 3],
    about: [Lane<S>; 3],
}

impl<S: Simd> ElementState<S> {
    #[inline(always)]
    fn zero(like: Lane<S>) -> Self {
        let zero = [like.of(0.0); 3];
        Self {
            along: zero,
            about: zero,
        }
    }
}

/// An element under several loads.
pub(super) struct StrainedElement<S: Simd, const L: usize> {
    middle: Middle<S>,
    length: Lane<S>,
    states: [ElementState<S>; L],
}

impl<S: Simd, const L: usize> StrainedElement<S, L> {
    /// In the plane.
    ///
    /// # Arguments
    /// - `states`: forces at the point for a compliance, motions there for a stiffness: up, uq, rn, then rp, rq, un, by load.
    #[inline(always)]
    pub(super) fn in_plane(
        constants: &Constants,
        form: ReductionForm,
        ends: [[Lane<S>; 2]; 2],
        [within, across]: &States<S, 3, 2>,
    ) -> Self {
        let at = PlaneFrame::of(ends);
        let middle = Middle::of(constants, form, at.length, at.inverse);
        let mut states = [ElementState::zero(at.length); L];
        for load in 0..L {
            let (moved, turned) = match form {
                ReductionForm::Compliance => (at.reached(within[load]), at.carried(across[load])),
                ReductionForm::Stiffness => (at.carried(within[load]), at.reached(across[load])),
            };
            states[load] = ElementState {
                along: [moved[0], turned[1], moved[2]],
                about: [turned[0], moved[1], turned[2]],
            };
        }
        Self {
            middle,
            length: at.length,
            states,
        }
    }

    /// Anywhere.
    ///
    /// # Arguments
    /// - `states`: forces and moments at the point for a compliance, motions there for a stiffness, by load.
    #[inline(always)]
    pub(super) fn in_space(
        constants: &Constants,
        form: ReductionForm,
        ends: [&[Lane<S>; 3]; 2],
        toward_y: &[Lane<S>; 3],
        [of_loads]: &States<S, 6, 1>,
    ) -> Self {
        let mut fault = toward_y[0].of(0.0);
        let at = SpaceFrame::of(ends, toward_y, &mut fault);
        let middle = Middle::of(constants, form, at.length, at.inverse);
        let mut states = [ElementState::zero(at.length); L];
        for load in 0..L {
            let [ux, uy, uz, rx, ry, rz] = of_loads[load];
            let (mut along, mut about) = ([ux, uy, uz], [rx, ry, rz]);
            match form {
                ReductionForm::Compliance => about = subtract(&about, &cross(&at.middle, &along)),
                ReductionForm::Stiffness => along = subtract(&along, &cross(&at.middle, &about)),
            }
            states[load] = ElementState {
                along: components(&at.axes, &along),
                about: components(&at.axes, &about),
            };
        }
        Self {
            middle,
            length: at.length,
            states,
        }
    }

    /// Twice the bilinear strain energy of two loads, by the property it depends on: A, Iy, Iz, J.
    #[inline(always)]
    pub(super) fn energies(&self, constants: &Constants, i: usize, j: usize) -> [Lane<S>; 4] {
        let states = [&self.states[i], &self.states[j]];
        self.middle.energies(constants, self.length, states)
    }
}
