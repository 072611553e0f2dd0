//! Elements in the main plane: they do not couple motion in the plane with motion across it.
//!
//! With local y along ± n and x = (c, s) in the axes p, q, z is ± (s, -c). Stretching and bending by I_y move nodes along p and q and turn
//! them about n; twist and bending by I_z move them along n and turn them about p and q. The sign of y cancels everywhere.

use pulp::Simd;

use super::bundle::ElementGeometry;
use super::elimination::Block;
use super::rigidity::Rigidity;
use stiffbench_numeric::lanes::{Lane, multiply_add, multiply_subtract};

/// The blocks of one half of the motion: of the first end, of the second, and between them.
pub(super) struct HalfBlocks<S: Simd> {
    pub(super) first: Block<S>,
    pub(super) second: Block<S>,
    pub(super) between: Block<S>,
}

/// Blocks of up, uq, rn: stretching, and bending in the plane.
#[inline(always)]
pub(super) fn blocks_in_plane<S: Simd>(
    rigidity: &Rigidity,
    geometry: &ElementGeometry<S>,
) -> HalfBlocks<S> {
    let [_, c, s] = geometry.axes[0];
    let inverse_length = geometry.inverse_length;
    let stretch = rigidity.stretch(inverse_length);
    let bending = rigidity.bending(0, inverse_length);
    let chord = inverse_length + inverse_length;
    let couple = chord * bending.shear_mode;
    let sway = chord * couple;
    let pp = multiply_add(stretch, c * c, sway * (s * s));
    let pq = (stretch - sway) * (c * s);
    let qq = multiply_add(stretch, s * s, sway * (c * c));
    let (pn, qn) = (-(couple * s), couple * c);
    let nn = bending.shear_mode + bending.curvature;
    let turn = bending.shear_mode - bending.curvature;
    HalfBlocks {
        first: [[pp, pq, pn], [pq, qq, qn], [pn, qn, nn]],
        second: [[pp, pq, -pn], [pq, qq, -qn], [-pn, -qn, nn]],
        between: [[-pp, -pq, pn], [-pq, -qq, qn], [-pn, -qn, turn]],
    }
}

/// Blocks of un, rp, rq: twist, and bending across the plane.
#[inline(always)]
pub(super) fn blocks_across<S: Simd>(
    rigidity: &Rigidity,
    geometry: &ElementGeometry<S>,
) -> HalfBlocks<S> {
    let [_, c, s] = geometry.axes[0];
    let inverse_length = geometry.inverse_length;
    let twist = rigidity.twist(inverse_length);
    let bending = rigidity.bending(1, inverse_length);
    let chord = inverse_length + inverse_length;
    let couple = chord * bending.shear_mode;
    let nn = chord * couple;
    let (np, nq) = (couple * s, -(couple * c));
    let (pp, pq, qq) = dyads(c, s, bending.shear_mode + bending.curvature, twist);
    let (pp2, pq2, qq2) = dyads(c, s, bending.shear_mode - bending.curvature, -twist);
    HalfBlocks {
        first: [[nn, np, nq], [np, pp, pq], [nq, pq, qq]],
        second: [[nn, -np, -nq], [-np, pp, pq], [-nq, pq, qq]],
        between: [[-nn, np, nq], [-np, pp2, pq2], [-nq, pq2, qq2]],
    }
}

/// of_z z zᵀ + of_x x xᵀ in the axes p, q: entries pp, pq, qq.
#[inline(always)]
fn dyads<S: Simd>(
    c: Lane<S>,
    s: Lane<S>,
    of_z: Lane<S>,
    of_x: Lane<S>,
) -> (Lane<S>, Lane<S>, Lane<S>) {
    (
        multiply_add(of_z, s * s, of_x * (c * c)),
        (of_x - of_z) * (c * s),
        multiply_add(of_z, c * c, of_x * (s * s)),
    )
}

/// Subtracts from the derivatives (loads × A, Iy, Iz, J) twice the strain energies under three loads.
///
/// # Arguments
/// - `ends`: displacements of the first and second end, each by half.
#[inline(always)]
pub(super) fn subtract_energies<S: Simd>(
    rigidity: &Rigidity,
    geometry: &ElementGeometry<S>,
    ends: &[[&Block<S>; 2]; 2],
    out: &mut [[Lane<S>; 4]; 3],
) {
    let [_, c, s] = geometry.axes[0];
    let inverse_length = geometry.inverse_length;
    let chord = inverse_length + inverse_length;
    let stretch = rigidity.stretch(inverse_length);
    let twist = rigidity.twist(inverse_length);
    let in_xz = rigidity.bending(0, inverse_length);
    let in_xy = rigidity.bending(1, inverse_length);
    let [[in_1, across_1], [in_2, across_2]] = ends;
    for load in 0..3 {
        let (up, uq) = (in_2[0][load] - in_1[0][load], in_2[1][load] - in_1[1][load]);
        let elongation = multiply_add(c, up, s * uq);
        let sway = multiply_subtract(c, uq, s * up);
        let curve_y = in_1[2][load] - in_2[2][load];
        let shear_y = multiply_add(chord, sway, in_1[2][load] + in_2[2][load]);

        let moved = across_2[0][load] - across_1[0][load];
        let (x1, z1) = turn(c, s, across_1, load);
        let (x2, z2) = turn(c, s, across_2, load);
        let phi = x2 - x1;
        let shear_z = multiply_subtract(chord, moved, z1 + z2);

        in_xz.subtract_energy(curve_y, shear_y, 1, &mut out[load]);
        in_xy.subtract_energy(z1 - z2, shear_z, 2, &mut out[load]);
        out[load][0] = multiply_subtract(stretch * elongation, elongation, out[load][0]);
        out[load][3] = multiply_subtract(twist * phi, phi, out[load][3]);
    }
}

/// Rotations of an end about local x and z.
#[inline(always)]
fn turn<S: Simd>(c: Lane<S>, s: Lane<S>, end: &Block<S>, load: usize) -> (Lane<S>, Lane<S>) {
    let (rp, rq) = (end[1][load], end[2][load]);
    (
        multiply_add(c, rp, s * rq),
        multiply_subtract(c, rq, s * rp),
    )
}
