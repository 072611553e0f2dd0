//! A beam as seen from a point far off: motion of one end against the other, and the force for it, both referred to that point.
//!
//! At its middle a uniform beam gives way in six ways that do not mix, each with one compliance:
//!
//! ```text
//!   along x   a  = L/EA               about x   j  = L/GJ
//!   along y   bz = L³/12EIz + L/GkA   about y   ry = L/EIy
//!   along z   by = L³/12EIy + L/GkA   about z   rz = L/EIz
//! ```
//!
//! With m from the point to the middle, a turn r moves the point by m × r more than the middle. So of the two blocks of a compliance,
//! or of a stiffness, one stays as it is and the other is carried: with D the block that stays, E the other and X = -[m]×,
//!
//! ```text
//!   [ D     D X        ]      compliance: D of turns, E of displacements,
//!   [ ..    E + Xᵀ D X ]      stiffness:  D of displacements, E of turns.
//! ```

use pulp::Simd;

use super::block::Block;
use super::schedule::ReductionForm;
use crate::structure::element::Element;
use stiffbench_numeric::simd::{
    Lane, Number, across, cross, dot, multiply_add, multiply_subtract, scale, subtract,
};

/// Constants of an element after its factors; all finite and above zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Constants {
    /// EA (N), E Iy, E Iz, GJ (N·m²).
    pub(super) stiffness: [f64; 4],
    /// Their inverses.
    pub(super) compliance: [f64; 4],
    /// 1/12EI of bending by Iy and by Iz, 1/(N·m²).
    pub(super) bow: [f64; 2],
    /// 1/GkA of the shear that goes with them, 1/N; zero for Euler-Bernoulli.
    pub(super) shear: [f64; 2],
}

impl Constants {
    /// Of an element; `None` if one is zero, negative or no number, or has no inverse.
    pub(super) fn of(element: &Element) -> Option<Self> {
        let section = element.section;
        let (e, g) = (
            element.material.youngs_modulus_pa,
            element.material.shear_modulus_pa,
        );
        let stiffness = [
            e * section.area_m2,
            e * section.iy_m4,
            e * section.iz_m4,
            g * section.j_m4,
        ];
        let compliance = stiffness.map(|k| 1.0 / k);
        let shear = element.shear.map_or([0.0; 2], |k| {
            [k.along_z, k.along_y].map(|coefficient| 1.0 / (g * coefficient * section.area_m2))
        });
        let bow = [compliance[1] / 12.0, compliance[2] / 12.0];
        let usable = stiffness.iter().chain(&compliance);
        let usable = usable.into_iter().all(|k| k.is_normal() && *k > 0.0);
        let shears = shear.iter().all(|s| s.is_finite() && *s >= 0.0);
        let sound = element.impossible_constant().is_none() && usable && shears;
        sound.then_some(Self {
            stiffness,
            compliance,
            bow,
            shear,
        })
    }
}

/// The six compliances at the middle, or their inverses.
pub(super) struct Middle<S: Simd> {
    pub(super) along: [Lane<S>; 3],
    pub(super) about: [Lane<S>; 3],
}

impl<S: Simd> Middle<S> {
    /// # Arguments
    /// - `length`, `inverse`: L and 1/L, m and 1/m.
    #[inline(always)]
    pub(super) fn of(
        constants: &Constants,
        form: ReductionForm,
        length: Lane<S>,
        inverse: Lane<S>,
    ) -> Self {
        let ([a, ry, rz, j], factor) = match form {
            ReductionForm::Compliance => (constants.compliance, length),
            ReductionForm::Stiffness => (constants.stiffness, inverse),
        };
        let mut sway = [length; 2];
        for plane in 0..2 {
            sway[plane] = match form {
                ReductionForm::Compliance => sway_compliance(constants, plane, length),
                // 12 EI/L³ needs no division.
                ReductionForm::Stiffness if constants.shear[plane] == 0.0 => {
                    let twelve_ei = length.of(12.0 * constants.stiffness[1 + plane]);
                    inverse * inverse * inverse * twelve_ei
                }
                ReductionForm::Stiffness => sway_compliance(constants, plane, length).inverse(),
            };
        }
        Self {
            along: [length.of(a) * factor, sway[1], sway[0]],
            about: [
                length.of(j) * factor,
                length.of(ry) * factor,
                length.of(rz) * factor,
            ],
        }
    }
}

/// Where an element lies in the plane of a frame n, p, q.
pub(super) struct PlaneFrame<S: Simd> {
    /// Components of local x.
    pub(super) c: Lane<S>,
    pub(super) s: Lane<S>,
    /// Components of the middle, seen from the point, m.
    pub(super) mp: Lane<S>,
    pub(super) mq: Lane<S>,
    pub(super) length: Lane<S>,
    pub(super) inverse: Lane<S>,
}

impl<S: Simd> PlaneFrame<S> {
    /// # Arguments
    /// - `ends`: components p and q of the two ends, seen from the point, m.
    #[inline(always)]
    pub(super) fn of([[p1, q1], [p2, q2]]: [[Lane<S>; 2]; 2]) -> Self {
        let (dp, dq) = (p2 - p1, q2 - q1);
        let squared = multiply_add(dp, dp, dq * dq);
        let inverse = squared.sqrt().inverse();
        let half = squared.of(0.5);
        Self {
            c: dp * inverse,
            s: dq * inverse,
            mp: half * (p1 + p2),
            mq: half * (q1 + q2),
            length: squared * inverse,
            inverse,
        }
    }

    /// Components along x, the normal and z at the middle, where that of the normal is carried: what [`reached`] multiplies.
    #[inline(always)]
    pub(super) fn reached(&self, [p, q, n]: [Lane<S>; 3]) -> [Lane<S>; 3] {
        let n = multiply_add(self.mq, p, multiply_subtract(self.mp, q, n));
        self.turned([p, q, n])
    }

    /// The same where those of the plane are carried: what [`carried`] multiplies.
    #[inline(always)]
    pub(super) fn carried(&self, [p, q, n]: [Lane<S>; 3]) -> [Lane<S>; 3] {
        let p = multiply_subtract(self.mq, n, p);
        self.turned([p, multiply_add(self.mp, n, q), n])
    }

    #[inline(always)]
    fn turned(&self, [p, q, n]: [Lane<S>; 3]) -> [Lane<S>; 3] {
        let x = multiply_add(self.c, p, self.s * q);
        [x, n, multiply_subtract(self.s, p, self.c * q)]
    }
}

/// L³/12EI + L/GkA for bending by Iy (`plane` 0) or Iz (1).
#[inline(always)]
fn sway_compliance<S: Simd>(constants: &Constants, plane: usize, length: Lane<S>) -> Lane<S> {
    let (bow, shear) = (constants.bow[plane], constants.shear[plane]);
    multiply_add(length * length, length.of(bow), length.of(shear)) * length
}

/// An element in the plane of the frame n, p, q through the point: motion up, uq, rn in the plane, and rp, rq, un across it.
///
/// # Arguments
/// - `ends`: components p and q of the two ends, seen from the point, m.
#[inline(always)]
pub(super) fn in_plane<S: Simd>(
    constants: &Constants,
    form: ReductionForm,
    ends: [[Lane<S>; 2]; 2],
) -> [Block<S, 3>; 2] {
    let PlaneFrame {
        c,
        s,
        mp,
        mq,
        length,
        inverse,
    } = PlaneFrame::of(ends);
    let Middle { along, about } = Middle::of(constants, form, length, inverse);
    // Local y is the normal, up to a sign; x and z lie in the plane.
    let displacements = dyads(c, s, along[0], along[2]);
    let turns = dyads(c, s, about[0], about[2]);
    match form {
        ReductionForm::Compliance => [
            reached(displacements, about[1], mp, mq),
            carried(turns, along[1], mp, mq),
        ],
        ReductionForm::Stiffness => [
            carried(displacements, about[1], mp, mq),
            reached(turns, along[1], mp, mq),
        ],
    }
}

/// of_x x xᵀ + of_z z zᵀ with x = (c, s): entries pp, pq, qq.
#[inline(always)]
fn dyads<S: Simd>(c: Lane<S>, s: Lane<S>, of_x: Lane<S>, of_z: Lane<S>) -> [Lane<S>; 3] {
    let difference = of_x - of_z;
    let (cd, sd) = (c * difference, s * difference);
    [multiply_add(c, cd, of_z), c * sd, multiply_add(s, sd, of_z)]
}

/// The block of p and q that stays, and n carried by it: with w = (-mq, mp), pn = D w and nn = E + wᵀ D w.
#[inline(always)]
fn carried<S: Simd>(
    [pp, pq, qq]: [Lane<S>; 3],
    nn: Lane<S>,
    mp: Lane<S>,
    mq: Lane<S>,
) -> Block<S, 3> {
    let pn = multiply_subtract(pp, mq, pq * mp);
    let qn = multiply_subtract(pq, mq, qq * mp);
    let nn = multiply_subtract(mq, pn, multiply_add(mp, qn, nn));
    [[pp, pq, pn], [pq, qq, qn], [pn, qn, nn]]
}

/// The entry of n that stays, and p and q carried by it.
#[inline(always)]
fn reached<S: Simd>(
    [pp, pq, qq]: [Lane<S>; 3],
    nn: Lane<S>,
    mp: Lane<S>,
    mq: Lane<S>,
) -> Block<S, 3> {
    let (pn, minus_qn) = (nn * mq, nn * mp);
    let pp = multiply_add(pn, mq, pp);
    let pq = multiply_subtract(pn, mp, pq);
    let qq = multiply_add(minus_qn, mp, qq);
    let qn = -minus_qn;
    [[pp, pq, pn], [pq, qq, qn], [pn, qn, nn]]
}

/// Where an element lies in space.
pub(super) struct SpaceFrame<S: Simd> {
    /// Local x, y, z.
    pub(super) axes: [[Lane<S>; 3]; 3],
    /// Its middle, seen from the point, m.
    pub(super) middle: [Lane<S>; 3],
    pub(super) length: Lane<S>,
    pub(super) inverse: Lane<S>,
}

impl<S: Simd> SpaceFrame<S> {
    /// Arguments as of [`in_space`].
    #[inline(always)]
    pub(super) fn of(
        [first, second]: [&[Lane<S>; 3]; 2],
        toward_y: &[Lane<S>; 3],
        fault: &mut Lane<S>,
    ) -> Self {
        let span = subtract(second, first);
        let half = span[0].of(0.5);
        let mut middle = span;
        for i in 0..3 {
            middle[i] = half * (first[i] + second[i]);
        }
        let squared = dot(&span, &span);
        let inverse = squared.sqrt().inverse();
        let x = scale(&span, inverse);
        let y = across(toward_y, &x);
        let y_squared = dot(&y, &y);
        let least = dot(toward_y, toward_y) * squared.of(1e-18);
        *fault += least.fault_unless_below(y_squared);
        let y = scale(&y, y_squared.sqrt().inverse());
        Self {
            axes: [x, y, cross(&x, &y)],
            middle,
            length: squared * inverse,
            inverse,
        }
    }
}

/// Components of a vector along axes.
#[inline(always)]
pub(super) fn components<S: Simd>(axes: &[[Lane<S>; 3]; 3], v: &[Lane<S>; 3]) -> [Lane<S>; 3] {
    [dot(&axes[0], v), dot(&axes[1], v), dot(&axes[2], v)]
}

/// An element anywhere: motion ux, uy, uz, rx, ry, rz.
///
/// # Arguments
/// - `ends`: its two ends seen from the point, m.
/// - `toward_y`: what local y is turned towards.
/// - `fault`: gains 1 in poses in which the element has no plane.
#[inline(always)]
pub(super) fn in_space<S: Simd>(
    constants: &Constants,
    form: ReductionForm,
    ends: [&[Lane<S>; 3]; 2],
    toward_y: &[Lane<S>; 3],
    fault: &mut Lane<S>,
) -> [Block<S, 6>; 1] {
    let SpaceFrame {
        axes,
        middle,
        length,
        inverse,
    } = SpaceFrame::of(ends, toward_y, fault);
    let Middle { along, about } = Middle::of(constants, form, length, inverse);
    let (displacements, turns) = (triad(&axes, &along), triad(&axes, &about));
    let mut whole = [[length; 6]; 6];
    let (stays, other, first) = match form {
        ReductionForm::Compliance => (&turns, &displacements, 3),
        ReductionForm::Stiffness => (&displacements, &turns, 0),
    };
    let second = 3 - first;
    for i in 0..3 {
        // Row i of D X is m × (row i of D).
        let row = cross(&middle, &stays[i]);
        for j in 0..3 {
            whole[first + i][first + j] = stays[i][j];
            whole[first + i][second + j] = row[j];
            whole[second + j][first + i] = row[j];
        }
    }
    for j in 0..3 {
        // Column j of Xᵀ (D X) is m × (column j of D X).
        let of_product = [
            whole[first][second + j],
            whole[first + 1][second + j],
            whole[first + 2][second + j],
        ];
        let column = cross(&middle, &of_product);
        for i in 0..=j {
            whole[second + i][second + j] = other[i][j] + column[i];
        }
    }
    [whole]
}

/// Adds the compliance of a hinge about the normal, in the plane of the frame n, p, q through the point: it moves nothing across.
///
/// # Arguments
/// - `node`: components p and q of the hinge, seen from the point, m.
/// - `fresh`: whether `sum` holds nothing yet.
#[inline(always)]
pub(super) fn add_hinge_in_plane<S: Simd>(
    rad_per_nm: f64,
    node: [Lane<S>; 2],
    fresh: bool,
    [within, across]: &mut [Block<S, 3>; 2],
) {
    let [motion, _] = hinge_motion_in_plane(node);
    if fresh {
        let zero = node[0].of(0.0);
        (*within, *across) = ([[zero; 3]; 3], [[zero; 3]; 3]);
    }
    add_dyad(node[0].of(rad_per_nm), &motion, within);
}

/// Motion of the point per unit of a hinge about the normal, in the plane and across it.
#[inline(always)]
pub(super) fn hinge_motion_in_plane<S: Simd>([p, q]: [Lane<S>; 2]) -> [[Lane<S>; 3]; 2] {
    let (zero, one) = (p.of(0.0), p.of(1.0));
    [[q, -p, one], [zero; 3]]
}

/// Adds the compliance of a hinge anywhere.
///
/// # Arguments
/// - `node`: the hinge, seen from the point, m.
/// - `axis`: unit vector of its axis.
/// - `fresh`: whether `sum` holds nothing yet.
#[inline(always)]
pub(super) fn add_hinge_in_space<S: Simd>(
    (rad_per_nm, slides): (f64, bool),
    node: &[Lane<S>; 3],
    axis: &[Lane<S>; 3],
    fresh: bool,
    [sum]: &mut [Block<S, 6>; 1],
) {
    if fresh {
        *sum = [[axis[0].of(0.0); 6]; 6];
    }
    let weight = axis[0].of(rad_per_nm);
    if slides {
        add_dyad(weight, axis, sum);
    } else {
        add_dyad(weight, &hinge_motion(node, axis, false), sum);
    }
}

/// The upper triangle of weight x xᵀ, added to the first rows and columns of a matrix.
#[inline(always)]
pub(super) fn add_dyad<S: Simd, const M: usize, const N: usize>(
    weight: Lane<S>,
    x: &[Lane<S>; M],
    sum: &mut Block<S, N>,
) {
    for i in 0..M {
        let weighted = x[i] * weight;
        for j in i..M {
            sum[i][j] = multiply_add(weighted, x[j], sum[i][j]);
        }
    }
}

/// Motion of the point per unit of a hinge; what a load on the point does in it, too.
#[inline(always)]
pub(super) fn hinge_motion<S: Simd>(
    node: &[Lane<S>; 3],
    axis: &[Lane<S>; 3],
    slides: bool,
) -> [Lane<S>; 6] {
    if slides {
        let zero = axis[0].of(0.0);
        return [axis[0], axis[1], axis[2], zero, zero, zero];
    }
    let moved = cross(node, axis);
    [moved[0], moved[1], moved[2], axis[0], axis[1], axis[2]]
}

/// Σ weights x xᵀ over the axes x, y, z.
#[inline(always)]
fn triad<S: Simd>(axes: &[[Lane<S>; 3]; 3], weights: &[Lane<S>; 3]) -> Block<S, 3> {
    let mut sum = *axes;
    let [x, y, z] = axes;
    for i in 0..3 {
        let (xw, yw, zw) = (x[i] * weights[0], y[i] * weights[1], z[i] * weights[2]);
        for j in i..3 {
            sum[i][j] = multiply_add(xw, x[j], multiply_add(yw, y[j], zw * z[j]));
            sum[j][i] = sum[i][j];
        }
    }
    sum
}
