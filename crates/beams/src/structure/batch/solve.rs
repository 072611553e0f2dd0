//! Assembles, factorises and differentiates one bundle of poses.

use pulp::Simd;

use super::bundle::{Bundle, ElementGeometry, components};
use super::elimination::{Block, Elimination, zero};
use super::plan::{ACROSS, ElementPlaces, IN_PLANE, Plan};
use super::rigidity::Rigidity;
use super::{general, in_plane};
use general::Of;
use stiffbench_numeric::lanes::{Kernel, Lane, dot};

/// Order of elimination and the memory for it.
#[derive(Debug)]
pub(super) struct System<S: Simd> {
    pub(super) plan: Plan,
    matrix: Elimination<S>,
}

impl<S: Simd> System<S> {
    pub(super) fn new(simd: S, plan: Plan) -> Self {
        Self {
            matrix: Elimination::new(simd, &plan),
            plan,
        }
    }
}

/// Assembles, factorises and takes the compliance of the end.
pub(super) struct Factorise<'a, S: Simd> {
    pub(super) system: &'a mut System<S>,
    pub(super) rigidities: &'a [Rigidity],
    pub(super) bundle: &'a mut Bundle<S>,
}

impl<S: Simd> Kernel for Factorise<'_, S> {
    #[inline(always)]
    fn run(self) {
        let System { plan, matrix } = self.system;
        let bundle = self.bundle;
        matrix.clear();
        let elements = plan.elements.iter().zip(self.rigidities);
        for ((places, rigidity), geometry) in elements.zip(&bundle.elements) {
            if places.in_plane {
                add_in_plane(matrix, places, rigidity, geometry);
            } else {
                add_general(matrix, places, rigidity, geometry);
            }
        }
        matrix.factorise(plan, &mut bundle.results.faults);
        let compliance = matrix.end_compliance(plan);
        bundle.results.compliance = in_global_axes(&bundle.frame, &compliance);
    }
}

#[inline(always)]
fn add_in_plane<S: Simd>(
    matrix: &mut Elimination<S>,
    places: &ElementPlaces,
    rigidity: &Rigidity,
    geometry: &ElementGeometry<S>,
) {
    let halves = [
        in_plane::blocks_in_plane(rigidity, geometry),
        in_plane::blocks_across(rigidity, geometry),
    ];
    for half in [IN_PLANE, ACROSS] {
        let blocks = &halves[half];
        if let Some(columns) = places.ends[0] {
            matrix.add_to_diagonal(columns[half], &blocks.first);
        }
        if let Some(columns) = places.ends[1] {
            matrix.add_to_diagonal(columns[half], &blocks.second);
        }
        if let Some(place) = places.between.and_then(|between| between[half][half]) {
            matrix.add_to_panel(place, &blocks.between);
        }
    }
}

#[inline(always)]
fn add_general<S: Simd>(
    matrix: &mut Elimination<S>,
    places: &ElementPlaces,
    rigidity: &Rigidity,
    geometry: &ElementGeometry<S>,
) {
    let parts = general::Parts::new(rigidity, geometry);
    for (end, of) in [Of::First, Of::Second].into_iter().enumerate() {
        if let Some(columns) = places.ends[end] {
            matrix.add_to_diagonal(columns[IN_PLANE], &parts.block(of, IN_PLANE, IN_PLANE));
            matrix.add_to_diagonal(columns[ACROSS], &parts.block(of, ACROSS, ACROSS));
        }
        if let Some(place) = places.within[end] {
            matrix.add_to_panel(place, &parts.block(of, IN_PLANE, ACROSS));
        }
    }
    if let Some(panels) = &places.between {
        for rows in [IN_PLANE, ACROSS] {
            for columns in [IN_PLANE, ACROSS] {
                if let Some(place) = panels[rows][columns] {
                    matrix.add_to_panel(place, &parts.block(Of::Between, rows, columns));
                }
            }
        }
    }
}

/// The compliance of the end, given by halves in the frame, over ux uy uz rx ry rz.
#[inline(always)]
fn in_global_axes<S: Simd>(
    frame: &[[Lane<S>; 3]; 3],
    halves: &[[Block<S>; 2]; 2],
) -> [[Lane<S>; 6]; 6] {
    let mut local = [[frame[0][0]; 6]; 6];
    for (row, rows) in general::FREEDOMS.iter().enumerate() {
        for (column, columns) in general::FREEDOMS.iter().enumerate() {
            for i in 0..3 {
                for j in 0..3 {
                    local[rows[i]][columns[j]] = halves[row][column][i][j];
                }
            }
        }
    }
    let mut global = local;
    for (row, column) in [(0, 0), (0, 3), (3, 3)] {
        for i in 0..3 {
            // One row of frameᵀ times the local part, then times the frame.
            let mut half = frame[0];
            for b in 0..3 {
                let part = [
                    local[row][column + b],
                    local[row + 1][column + b],
                    local[row + 2][column + b],
                ];
                half[b] = dot(&[frame[0][i], frame[1][i], frame[2][i]], &part);
            }
            for j in 0..3 {
                let value = dot(&half, &[frame[0][j], frame[1][j], frame[2][j]]);
                global[row + i][column + j] = value;
                global[column + j][row + i] = value;
            }
        }
    }
    global
}

/// Works out the derivatives from the factor that [`Factorise`] left.
pub(super) struct Differentiate<'a, S: Simd> {
    pub(super) system: &'a mut System<S>,
    pub(super) rigidities: &'a [Rigidity],
    pub(super) bundle: &'a mut Bundle<S>,
}

impl<S: Simd> Kernel for Differentiate<'_, S> {
    #[inline(always)]
    fn run(self) {
        let System { plan, matrix } = self.system;
        let bundle = self.bundle;
        let along = [0, 1, 2].map(|load: usize| components(&bundle.frame, &bundle.toward[load]));
        let end = end_fields(&along, &matrix.end_compliance(plan));
        matrix.respond(plan, &end);
        let held = zero(bundle.frame[0][0].simd());
        let elements = plan.elements.iter().zip(self.rigidities);
        for ((places, rigidity), geometry) in elements.zip(&bundle.elements) {
            let mut ends = [[&held; 2]; 2];
            for (end, columns) in ends.iter_mut().zip(&places.ends) {
                if let Some([in_plane, across]) = *columns {
                    *end = [matrix.field(in_plane), matrix.field(across)];
                }
            }
            let out = &mut bundle.results.derivatives[rigidity.group];
            if places.in_plane {
                in_plane::subtract_energies(rigidity, geometry, &ends, out);
            } else {
                general::subtract_energies(rigidity, geometry, &ends, out);
            }
        }
    }
}

/// Displacements of the end, by half, under unit forces along three directions, given by their components along n, p, q.
#[inline(always)]
fn end_fields<S: Simd>(
    along: &[[Lane<S>; 3]; 3],
    compliance: &[[Block<S>; 2]; 2],
) -> [Block<S>; 2] {
    let mut fields = [compliance[0][0]; 2];
    for half in [IN_PLANE, ACROSS] {
        for freedom in 0..3 {
            let of_n = compliance[half][ACROSS][freedom][0];
            let [of_p, of_q, _] = compliance[half][IN_PLANE][freedom];
            for load in 0..3 {
                fields[half][freedom][load] = dot(&along[load], &[of_n, of_p, of_q]);
            }
        }
    }
    fields
}
