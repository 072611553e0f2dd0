//! The stiffness of a mechanism, pose by pose.

use rayon::prelude::*;

use stiffbench_beams::robot::Pose;

use super::column::{MapColumn, row_width};
use super::matrix::{ENTRIES, MatrixKind};
use super::model::{MapModel, NoMap};
use crate::distribution::pose_set::PoseSample;

/// Poses computed before their full compliances are let go: memory grows with the rows alone.
const AT_ONCE: usize = 1 << 16;

/// The stiffness of a mechanism in the poses of a set.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffnessMap {
    /// The mechanism.
    pub mechanism: String,
    /// What each stiffness of a row is.
    pub columns: Vec<MapColumn>,
    /// The matrix at the end of each row, if there is one.
    pub matrix: Option<MatrixKind>,
    /// Place in the set of each pose that has a row.
    pub places: Vec<u32>,
    /// Poses that have none: their place in the set and why.
    pub failed: Vec<(u32, String)>,
    /// Row after row: position of the end, m; the columns, N/m or N·m/rad; unit vectors of the weakest direction and of the weakest axis,
    /// if the columns have them; the matrix, row by row.
    pub values: Vec<f64>,
}

impl StiffnessMap {
    /// Works out all columns in all poses, on all cores.
    ///
    /// # Errors
    /// [`NoMap`] if the model cannot be solved at all; a pose that cannot be taken is listed in `failed`.
    pub fn over(
        model: &MapModel<'_>,
        poses: &PoseSample,
        columns: &[MapColumn],
    ) -> Result<Self, NoMap> {
        Self::with_matrix(model, poses, columns, None)
    }

    /// As [`StiffnessMap::over`], with a matrix of each pose.
    ///
    /// # Errors
    /// As there; [`NoMap::LinearOnly`] for a matrix of laws that are not linear.
    pub fn with_matrix(
        model: &MapModel<'_>,
        poses: &PoseSample,
        columns: &[MapColumn],
        matrix: Option<MatrixKind>,
    ) -> Result<Self, NoMap> {
        let width = row_width(columns, matrix);
        let mut map = Self {
            mechanism: model.mechanism().name.clone(),
            columns: columns.to_vec(),
            matrix,
            places: Vec::with_capacity(poses.len()),
            failed: Vec::new(),
            values: Vec::with_capacity(poses.len() * width),
        };
        if poses.is_empty() {
            return Ok(map);
        }
        let mut chunk: Vec<Pose> = vec![poses.pose(0); poses.len().min(AT_ONCE)];
        for start in (0..poses.len()).step_by(AT_ONCE) {
            let count = AT_ONCE.min(poses.len() - start);
            let (chunk, _) = chunk.split_at_mut(count);
            chunk
                .par_iter_mut()
                .enumerate()
                .for_each(|(place, pose)| poses.fill(start + place, pose));
            map.add(start, model, chunk)?;
        }
        Ok(map)
    }

    /// Adds the rows of poses that stand in the set from `start` on.
    fn add(&mut self, start: usize, model: &MapModel<'_>, poses: &[Pose]) -> Result<(), NoMap> {
        let width = self.width();
        let before = self.values.len();
        self.values.resize(before + poses.len() * width, 0.0);
        let rows = &mut self.values[before..];
        let failed = model.rows(poses, &self.columns, self.matrix, rows)?;
        let mut failures = failed.into_iter().peekable();
        let mut kept = before;
        for place in 0..poses.len() {
            if let Some((_, reason)) = failures.next_if(|(failed, _)| *failed == place) {
                self.failed.push(((start + place) as u32, reason));
                continue;
            }
            let row = before + place * width;
            if row != kept {
                self.values.copy_within(row..row + width, kept);
            }
            kept += width;
            self.places.push((start + place) as u32);
        }
        self.values.truncate(kept);
        Ok(())
    }

    /// Number of poses that have a row.
    #[must_use]
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether no pose has a row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// A row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f64] {
        let width = self.width();
        &self.values[row * width..][..width]
    }

    /// Position of the end in a row, m.
    #[must_use]
    pub fn end_m(&self, row: usize) -> [f64; 3] {
        let row = self.row(row);
        [row[0], row[1], row[2]]
    }

    /// Numbers in a row.
    fn width(&self) -> usize {
        row_width(&self.columns, self.matrix)
    }

    /// Stiffness of a column in a row, N/m or N·m/rad.
    #[must_use]
    pub fn stiffness_n_per_m(&self, row: usize, column: usize) -> f64 {
        self.row(row)[3 + column]
    }

    /// A column, N/m or N·m/rad, row by row.
    pub fn column(&self, column: usize) -> impl Iterator<Item = f64> + '_ {
        let width = self.width();
        self.values
            .chunks_exact(width)
            .map(move |row| row[3 + column])
    }

    /// Unit vector along which the end gives way most in a row, if the columns have principal stiffnesses.
    #[must_use]
    pub fn weakest_direction(&self, row: usize) -> Option<[f64; 3]> {
        let mut columns = self.columns.iter();
        let has = columns.any(|column| matches!(column, MapColumn::Principal(_)));
        let (found, _) = self.row(row)[3 + self.columns.len()..].split_first_chunk::<3>()?;
        has.then_some(*found)
    }

    /// The matrix of a row, row by row, SI, if the map has one.
    #[must_use]
    pub fn matrix(&self, row: usize) -> Option<&[f64; ENTRIES]> {
        self.matrix?;
        self.row(row).last_chunk()
    }
}
