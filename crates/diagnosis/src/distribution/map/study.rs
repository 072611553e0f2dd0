//! A mechanism's map with all that is said of it.

use rayon::prelude::*;

use stiffbench_beams::robot::RobotError;

use super::column::MapColumn;
use super::fit_uncertainty::{FitUncertainty, FittedCovariance, fit_uncertainty};
use super::model::MapModel;
use super::refine::RefinedStiffness;
use super::regions::{Region, regions};
use super::statistics::{ColumnStatistics, column_statistics};
use super::stiffness_map::StiffnessMap;
use super::surface::Surface;
use crate::distribution::plane::MapPlane;
use crate::distribution::pose_set::{PoseSample, Sampling};

/// Poses, how they were chosen, and the triangles between them.
#[derive(Debug)]
pub struct StudyPoses {
    /// The poses.
    pub set: PoseSample,
    /// How they were chosen.
    pub sampling: Sampling,
    /// The plane over which they are shown.
    pub plane: MapPlane,
    /// The triangles, where poses make a surface.
    pub surface: Option<Surface>,
}

impl StudyPoses {
    /// Joins poses to a surface where they make one.
    #[must_use]
    pub fn new(set: PoseSample, sampling: Sampling, plane: MapPlane) -> Self {
        Self {
            surface: Surface::over(&set),
            set,
            sampling,
            plane,
        }
    }
}

/// A map with its statistics.
#[derive(Debug)]
pub struct MechanismStudy {
    /// The map.
    pub map: StiffnessMap,
    /// How the poses were solved.
    pub method: Vec<String>,
    /// Triangles between its rows, where poses make a surface.
    pub triangles: Option<Vec<[u32; 3]>>,
    /// What is said of each column in which something yields; empty for a map without rows.
    pub columns: Vec<ColumnStudy>,
}

/// What is said of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnStudy {
    /// What it is.
    pub column: MapColumn,
    /// Its statistics.
    pub statistics: ColumnStatistics,
    /// Its smallest and largest value, followed to where the limits hold them, or why they could not be.
    pub refined: [Result<RefinedStiffness, String>; 2],
    /// Where it is low, medium and high.
    pub regions: [Region; 3],
    /// What the uncertainty of the fit does to it.
    pub fit: Option<FitUncertainty>,
}

impl MechanismStudy {
    /// Works out everything about a map, on all cores.
    ///
    /// # Errors
    /// [`RobotError`] if the model cannot be built for the derivatives to the factors.
    pub fn of(
        model: &MapModel<'_>,
        map: StiffnessMap,
        poses: &StudyPoses,
        covariance: Option<&FittedCovariance>,
    ) -> Result<Self, RobotError> {
        let surface = poses.surface.as_ref();
        let triangles = surface.map(|surface| surface.rows_of(&map, &poses.set));
        let ends = (0..map.len()).map(|row| map.end_m(row));
        let places: Vec<[f64; 2]> = ends.map(|end| poses.plane.place(end)).collect();
        let columns = (0..map.columns.len()).into_par_iter().filter_map(|column| {
            let statistics = column_statistics(&map, &poses.set, poses.sampling, column)?;
            let rows = [statistics.smallest.row, statistics.largest.row];
            let refined: Vec<_> = rows
                .into_par_iter()
                .zip([false, true])
                .map(|(row, largest)| {
                    let refined = map.refined(model, &poses.set, column, row, largest);
                    refined
                        .map_err(|error| error.to_string())
                        .and_then(|refined| {
                            if refined.stiffness_n_per_m.is_finite() {
                                return Ok(refined);
                            }
                            Err("rises without limit to where nothing yields".to_owned())
                        })
                })
                .collect();
            let nothing = || Err("not followed".to_owned());
            let mut refined = refined.into_iter();
            Some(ColumnStudy {
                column: map.columns[column].clone(),
                refined: [(); 2].map(|()| refined.next().unwrap_or_else(nothing)),
                regions: regions(
                    &map,
                    &poses.set,
                    &places,
                    triangles.as_deref(),
                    (&statistics, column),
                ),
                statistics,
                fit: None,
            })
        });
        let mut columns: Vec<ColumnStudy> = columns.collect();
        if let Some(covariance) = covariance {
            let statistics: Vec<(MapColumn, ColumnStatistics)> = columns
                .iter()
                .map(|found| (found.column.clone(), found.statistics.clone()))
                .collect();
            let fits = fit_uncertainty(model, &map, &poses.set, covariance, &statistics)?;
            for (column, fit) in columns.iter_mut().zip(fits) {
                column.fit = fit;
            }
        }
        Ok(Self {
            method: model.method(),
            map,
            triangles,
            columns,
        })
    }

    /// What is said of a column of the map; `None` if nothing yields there in any pose.
    #[must_use]
    pub fn found(&self, column: usize) -> Option<&ColumnStudy> {
        let column = self.map.columns.get(column)?;
        self.columns.iter().find(|found| found.column == *column)
    }

    /// Columns in which nothing yields in any pose.
    pub fn rigid(&self) -> impl Iterator<Item = &MapColumn> {
        let columns = self.map.columns.iter().enumerate();
        let rigid =
            columns.filter(|(place, _)| !self.map.is_empty() && self.found(*place).is_none());
        rigid.map(|(_, column)| column)
    }

    /// What is said of a global axis, if it is among the columns.
    #[must_use]
    pub fn axis(&self, axis: usize) -> Option<&ColumnStudy> {
        self.columns
            .iter()
            .find(|column| column.column.axis() == Some(axis))
    }
}
