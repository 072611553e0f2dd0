//! Elements of any direction: they couple both halves of the motion of their ends.

use pulp::Simd;

use super::bundle::ElementGeometry;
use super::elimination::Block;
use super::rigidity::Rigidity;
use stiffbench_numeric::lanes::{Lane, dot, multiply_add, multiply_subtract, subtract};

/// Freedoms of the halves among un, up, uq, rn, rp, rq.
pub(super) const FREEDOMS: [[usize; 3]; 2] = [[1, 2, 3], [0, 4, 5]];

/// The four parts that make up an element's matrix in the axes n, p, q; see `element::global_matrix`.
pub(super) struct Parts<S: Simd> {
    /// Between displacements of one end; the other sign between those of both.
    sway: Block<S>,
    /// Displacement of the first end and rotation of either; the other sign for the second end.
    couple: Block<S>,
    /// Between rotations of one end, and of both.
    rotations: [Block<S>; 2],
}

/// Which block of an element's matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    First,
    Second,
    /// Rows of the first end, columns of the second.
    Between,
}

impl<S: Simd> Parts<S> {
    #[inline(always)]
    pub(super) fn new(rigidity: &Rigidity, geometry: &ElementGeometry<S>) -> Self {
        let [x, y, z] = &geometry.axes;
        let inverse_length = geometry.inverse_length;
        let stretch = rigidity.stretch(inverse_length);
        let twist = rigidity.twist(inverse_length);
        let in_xz = rigidity.bending(0, inverse_length);
        let in_xy = rigidity.bending(1, inverse_length);
        let chord = inverse_length + inverse_length;
        let (couple_y, couple_z) = (chord * in_xz.shear_mode, chord * in_xy.shear_mode);
        let (sway_y, sway_z) = (chord * couple_y, chord * couple_z);
        let unset = [[inverse_length; 3]; 3];
        let mut parts = Self {
            sway: unset,
            couple: unset,
            rotations: [unset; 2],
        };
        for i in 0..3 {
            for j in 0..3 {
                let (xx, yy, zz) = (x[i] * x[j], y[i] * y[j], z[i] * z[j]);
                let stretched = multiply_add(sway_z, yy, stretch * xx);
                parts.sway[i][j] = multiply_add(sway_y, zz, stretched);
                let turned = couple_z * (y[i] * z[j]);
                parts.couple[i][j] = multiply_subtract(couple_y, z[i] * y[j], turned);
                let shear = multiply_add(in_xz.shear_mode, yy, in_xy.shear_mode * zz);
                let curvature = multiply_add(in_xz.curvature, yy, in_xy.curvature * zz);
                let bend = multiply_add(twist, xx, curvature);
                parts.rotations[0][i][j] = shear + bend;
                parts.rotations[1][i][j] = shear - bend;
            }
        }
        parts
    }

    /// The part of a block between two halves of the motion.
    #[inline(always)]
    pub(super) fn block(&self, of: Of, rows: usize, columns: usize) -> Block<S> {
        let mut block = self.sway;
        for i in 0..3 {
            for j in 0..3 {
                block[i][j] = self.entry(of, FREEDOMS[rows][i], FREEDOMS[columns][j]);
            }
        }
        block
    }

    #[inline(always)]
    fn entry(&self, of: Of, row: usize, column: usize) -> Lane<S> {
        match (row < 3, column < 3, of) {
            (true, true, Of::Between) => -self.sway[row][column],
            (true, true, _) => self.sway[row][column],
            (true, false, Of::Second) => -self.couple[row][column - 3],
            (true, false, _) => self.couple[row][column - 3],
            (false, true, Of::First) => self.couple[column][row - 3],
            (false, true, _) => -self.couple[column][row - 3],
            (false, false, Of::Between) => self.rotations[1][row - 3][column - 3],
            (false, false, _) => self.rotations[0][row - 3][column - 3],
        }
    }
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
    let inverse_length = geometry.inverse_length;
    let chord = inverse_length + inverse_length;
    let stretch = rigidity.stretch(inverse_length);
    let twist = rigidity.twist(inverse_length);
    let in_xz = rigidity.bending(0, inverse_length);
    let in_xy = rigidity.bending(1, inverse_length);
    let [x, y, z] = &geometry.axes;
    for load in 0..3 {
        let (u1, r1) = motion(&ends[0], load);
        let (u2, r2) = motion(&ends[1], load);
        let moved = subtract(&u2, &u1);
        let (elongation, v, w) = (dot(x, &moved), dot(y, &moved), dot(z, &moved));
        let phi = dot(x, &subtract(&r2, &r1));
        let (y1, z1, y2, z2) = (dot(y, &r1), dot(z, &r1), dot(y, &r2), dot(z, &r2));
        let shear_y = multiply_add(chord, w, y1 + y2);
        let shear_z = multiply_subtract(chord, v, z1 + z2);

        in_xz.subtract_energy(y1 - y2, shear_y, 1, &mut out[load]);
        in_xy.subtract_energy(z1 - z2, shear_z, 2, &mut out[load]);
        out[load][0] = multiply_subtract(stretch * elongation, elongation, out[load][0]);
        out[load][3] = multiply_subtract(twist * phi, phi, out[load][3]);
    }
}

/// Displacement and rotation of an end in the axes of the frame.
#[inline(always)]
fn motion<S: Simd>(
    [in_plane, across]: &[&Block<S>; 2],
    load: usize,
) -> ([Lane<S>; 3], [Lane<S>; 3]) {
    (
        [across[0][load], in_plane[0][load], in_plane[1][load]],
        [in_plane[2][load], across[1][load], across[2][load]],
    )
}
