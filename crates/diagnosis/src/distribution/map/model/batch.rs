//! A mechanism solved in poses that stand in one slice, value after value: the form of numerical arrays of other languages.

use stiffbench_beams::structure::Compliance6;

use crate::distribution::map::MatrixKind;

use super::{MapModel, NoMap};

/// What a batch of poses has, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct SolvedBatch<T> {
    /// One result a pose; of those in `failed` not a number.
    pub results: Vec<T>,
    /// Poses that have no result, by index, and why.
    pub failed: Vec<(usize, String)>,
}

impl MapModel<'_> {
    /// Positions of the end, m.
    ///
    /// # Arguments
    /// - `values`: the variables of the robot in their order, degrees or m, pose after pose.
    ///
    /// # Errors
    /// [`NoMap::LinearOnly`] for a mechanism with laws that are not linear.
    ///
    /// # Panics
    /// If the number of values is no multiple of the number of variables.
    pub fn end_positions(&self, values: &[f64]) -> Result<SolvedBatch<[f64; 3]>, NoMap> {
        self.batch(values, [0.0; 3], [f64::NAN; 3], |end_m, _| end_m)
    }

    /// The matrices of the end, SI.
    ///
    /// # Arguments
    /// - `values`: the variables of the robot in their order, degrees or m, pose after pose.
    /// - `kind`: a stiffness is not a number where the compliance has no inverse.
    ///
    /// # Errors
    /// [`NoMap::LinearOnly`] for a mechanism with laws that are not linear.
    ///
    /// # Panics
    /// If the number of values is no multiple of the number of variables.
    pub fn matrices(
        &self,
        values: &[f64],
        kind: MatrixKind,
    ) -> Result<SolvedBatch<[[f64; 6]; 6]>, NoMap> {
        let (zero, missing) = ([[0.0; 6]; 6], [[f64::NAN; 6]; 6]);
        self.batch(values, zero, missing, |end_m, compliance| {
            kind.of(&self.on_its_base(compliance, end_m))
        })
    }

    /// Solves all poses. The results begin as zeros, which the system maps when a thread first writes there.
    pub(in crate::distribution) fn batch<T: Copy + Send>(
        &self,
        values: &[f64],
        zero: T,
        missing: T,
        result: impl Fn([f64; 3], &Compliance6) -> T + Sync,
    ) -> Result<SolvedBatch<T>, NoMap> {
        let sweep = self.sweep()?;
        let count = values.len() / self.robot.variables.len().max(1);
        let mut results = vec![zero; count];
        let failed = sweep.run_into(values, &mut results, result);
        for (index, _) in &failed {
            results[*index] = missing;
        }
        let failed = failed.into_iter();
        Ok(SolvedBatch {
            results,
            failed: failed
                .map(|(index, error)| (index, error.to_string()))
                .collect(),
        })
    }
}
