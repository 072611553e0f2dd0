//! A list of stiffness values as load cases, so that a diagnosis takes them like readings.
//!
//! Each value is read as the displacement under the load at which its standard uncertainty is [`LIST_SCATTER_M`]: the logarithm of a stiffness
//! and such a displacement have the same rows to the first order, and all rows scatter alike.

use crate::fit::{LnUncertainty, MeasuredCell, MeasuredStiffness};
use crate::load_cases::{LoadAxes, LoadCase, LoadCaseTable};
use crate::mismatch::StatedScatter;

use super::data::LoadedLoadCases;
use super::session_table::SessionTable;

/// Standard uncertainty of each displacement, m.
const LIST_SCATTER_M: f64 = 1e-6;

/// Displacement of values of which no uncertainty is known, m: 1 um is then one percent of a stiffness.
const WITHOUT_UNCERTAINTY_M: f64 = 1e-4;

/// Load cases of a list, with the standard uncertainty of their displacements if it is known, and what a user should know.
pub(super) fn listed_load_cases(name: &str, measured: &MeasuredStiffness) -> LoadedLoadCases {
    let known = |cell: &MeasuredCell| cell.ln_uncertainty.map(|u| LnUncertainty::combined(&u));
    let is_known = measured.cells.iter().all(|cell| known(cell).is_some());
    let case = |cell: &MeasuredCell| {
        let axis = cell.cell.direction.index();
        let displacement_m = match known(cell) {
            Some(u) if is_known => LIST_SCATTER_M / u,
            _ => WITHOUT_UNCERTAINTY_M,
        };
        let mut force_n = [0.0; 3];
        force_n[axis] = cell.stiffness_n_per_m * displacement_m;
        let mut read = [None; 3];
        read[axis] = Some(displacement_m);
        LoadCase {
            line: cell.line,
            pose: cell.cell.pose.clone(),
            joints: Vec::new(),
            repeat: 1,
            axes: LoadAxes::Base,
            force_n,
            moment_nm: [0.0; 3],
            displacement_m: read,
            rotation_rad: [None; 3],
            position_m: [None; 3],
        }
    };
    let table = LoadCaseTable {
        source: name.to_owned(),
        cases: measured.cells.iter().map(case).collect(),
        ..LoadCaseTable::default()
    };
    let unit = if is_known {
        "each under the load at which its standard uncertainty is 1 µm"
    } else {
        "each 100 µm, so that 1 µm is one percent of a stiffness; no uncertainty is stated (column u_N_per_um)"
    };
    let note = format!("stiffness values are taken as displacements, {unit}");
    let scatter = is_known.then_some(StatedScatter {
        displacement_sd_m: LIST_SCATTER_M,
        force_sd_n: None,
    });
    SessionTable {
        warnings: vec![note],
        scatter,
        ..SessionTable::bare(name.to_owned(), &[], table)
    }
}
