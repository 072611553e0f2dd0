//! A robot with a mechanism, solved in many poses at once.

use std::path::PathBuf;

use numpy::prelude::*;
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyUntypedArray};
use pyo3::exceptions::{PyRuntimeWarning, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use stiffbench::analysis::{ModelChoice, resolve};
use stiffbench::cli::failure::Failure;
use stiffbench::distribution::{MapModel, MatrixKind, NoMap, SolvedBatch};
use stiffbench::physics::{ActingPhysics, Effect};
use stiffbench::robot::{FittingFactors, JointMotion, Pose, Robot as BeamRobot};

use crate::failure::exception_of;

/// A robot with one mechanism, factors and physics, ready to be solved in any number of poses.
///
/// Poses are float64 arrays of shape (n, dof): a row holds the variables of one pose in the order of `variables`, degrees or, of
/// sliding ones, metres. Arrays in C order are read where they are. Other threads may run meanwhile, but must not write to them.
///
/// Parameters
/// ----------
/// robot : str or path, optional
///     Name of a shipped robot, or a robot file. Without it the robot of `model`, else "hp-robot".
/// mechanism : str, optional
///     One of `mechanisms`. Without it that of `model`, else the last one.
/// factors : str, optional
///     Factor set of the robot, or a TOML file of factors, as `stiffbench fit --save-factors` writes it.
/// model : path, optional
///     File of a model with found physics, as `stiffbench diagnose` writes it.
/// effects : sequence of str, optional
///     Linear effects beside the beams, LAW@PLACE:NAME=VALUE.
#[pyclass(frozen, module = "stiffbench")]
pub(crate) struct Robot {
    robot: BeamRobot,
    physics: ActingPhysics,
    factors: FittingFactors,
    factors_name: String,
    /// What a user should know of robot and model.
    #[pyo3(get)]
    warnings: Vec<String>,
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (robot=None, *, mechanism=None, factors=None, model=None, effects=Vec::new()))]
    fn new(
        py: Python<'_>,
        robot: Option<PathBuf>,
        mechanism: Option<String>,
        factors: Option<PathBuf>,
        model: Option<PathBuf>,
        effects: Vec<String>,
    ) -> PyResult<Self> {
        let text = |path: PathBuf| path.to_string_lossy().into_owned();
        let choice = ModelChoice {
            robot: robot.map(text),
            mechanism,
            factors: factors.map(text),
            model,
            ..ModelChoice::default()
        };
        let made = py.detach(|| Self::resolved(choice, &effects));
        made.map_err(|failure| exception_of(py, failure))
    }

    /// Name of the robot.
    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    /// Name of the mechanism that is solved.
    #[getter]
    fn mechanism(&self) -> &str {
        &self.physics.mechanism.name
    }

    /// Names of all mechanisms of the robot.
    #[getter]
    fn mechanisms(&self) -> Vec<&str> {
        self.robot.mechanisms.keys().map(String::as_str).collect()
    }

    /// Name of the factor set.
    #[getter]
    fn factors(&self) -> &str {
        &self.factors_name
    }

    /// Names of the variables, in the order of a row of poses.
    #[getter]
    fn variables(&self) -> Vec<&str> {
        let variables = self.robot.variables.iter();
        variables.map(|variable| variable.name.as_str()).collect()
    }

    /// Unit of each variable, "deg" or "m".
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        let variables = self.robot.variables.iter();
        let unit = |turns| if turns { "deg" } else { "m" };
        variables
            .map(|variable| unit(variable.motion == JointMotion::Turns))
            .collect()
    }

    /// Least and largest value of each variable, shape (dof, 2), in its unit.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let limits = self
            .robot
            .variables
            .iter()
            .flat_map(|v| [v.min_deg, v.max_deg]);
        let count = self.robot.variables.len();
        PyArray1::from_iter(py, limits).reshape([count, 2])
    }

    /// The named poses of the robot file, each of shape (dof,).
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let poses = PyDict::new(py);
        for named in &self.robot.poses {
            let values = PyArray1::from_slice(py, &named.pose.angles_deg);
            poses.set_item(named.id.as_str(), values)?;
        }
        Ok(poses)
    }

    /// Compliance of the end in many poses.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n, 6, 6)
    ///     Rows ux, uy, uz (m), rx, ry, rz (rad); columns Fx, Fy, Fz (N), Mx, My, Mz (N*m). NaN in poses that cannot be taken, with a
    ///     RuntimeWarning.
    fn compliance<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.matrices(py, poses, MatrixKind::Compliance)
    }

    /// Stiffness of the end in many poses: the inverse of the compliance.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n, 6, 6)
    ///     Rows Fx, Fy, Fz (N), Mx, My, Mz (N*m); columns ux, uy, uz (m), rx, ry, rz (rad). NaN where the end is rigid in a direction,
    ///     and in poses that cannot be taken, these with a RuntimeWarning.
    fn stiffness<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.matrices(py, poses, MatrixKind::Stiffness)
    }

    /// Position of the end in many poses, m, shape (n, 3).
    fn positions<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let found = self.solve(py, poses, |model, values| model.end_positions(values))?;
        let count = found.len();
        PyArray1::from_vec(py, found.into_flattened()).reshape([count, 3])
    }

    /// Whether each pose is within all limits of the robot, shape (n,).
    fn within_limits<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let poses = self.poses_of(poses)?;
        let values = values(&poses)?;
        let within = values.chunks_exact(self.robot.variables.len()).map(|row| {
            self.robot.is_within_limits(&Pose {
                angles_deg: row.to_vec(),
            })
        });
        Ok(PyArray1::from_iter(py, within))
    }

    fn __repr__(&self) -> String {
        format!(
            "Robot({:?}, mechanism={:?}, factors={:?})",
            self.robot.name, self.physics.mechanism.name, self.factors_name
        )
    }
}

impl Robot {
    fn resolved(mut choice: ModelChoice, effects: &[String]) -> Result<Self, Failure> {
        for effect in effects {
            choice.effects.push(effect.parse()?);
        }
        let model = resolve(&choice, None)?;
        let mut warnings = model.warnings.clone();
        let mut acting = Vec::new();
        for effect in model.physics.effects.clone() {
            if effect.law.place_kind.is_of_robot() {
                acting.push(effect);
            } else {
                warnings.push(format!(
                    "{effect}: of the bench, not of the robot, and left out"
                ));
            }
        }
        acting.extend(Effect::of_springs(&model.factors));
        let mechanism = model.mechanism()?;
        let physics = ActingPhysics::new(&model.robot, mechanism, acting)?;
        let made = Self {
            factors: model.factors.without_springs(),
            factors_name: model.factors_name,
            robot: model.robot,
            physics,
            warnings,
        };
        // What cannot be solved at all is refused now.
        made.model()?.matrices(&[], MatrixKind::Compliance)?;
        Ok(made)
    }

    fn model(&self) -> Result<MapModel<'_>, NoMap> {
        // A load would give the laws that are not linear a stiffness along the axes, but no matrix.
        MapModel::new(&self.robot, &self.physics, &self.factors, Some(1.0))
    }

    fn matrices<'py>(
        &self,
        py: Python<'py>,
        poses: &Bound<'py, PyAny>,
        kind: MatrixKind,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let found = self.solve(py, poses, |model, values| model.matrices(values, kind))?;
        let count = found.len();
        let entries = found.into_flattened().into_flattened();
        PyArray1::from_vec(py, entries).reshape([count, 6, 6])
    }

    /// Solves all poses, and warns of those that have no result.
    fn solve<T: Send>(
        &self,
        py: Python<'_>,
        poses: &Bound<'_, PyAny>,
        work: impl FnOnce(&MapModel<'_>, &[f64]) -> Result<SolvedBatch<T>, NoMap> + Send,
    ) -> PyResult<Vec<T>> {
        let poses = self.poses_of(poses)?;
        let values = values(&poses)?;
        let solved = py.detach(|| work(&self.model()?, values));
        let solved = solved.map_err(|error| exception_of(py, error))?;
        if let Some((index, reason)) = solved.failed.first() {
            let text = format!(
                "{} of {} poses have no result; the first is row {index}: {reason}",
                solved.failed.len(),
                solved.results.len()
            );
            let text = std::ffi::CString::new(text)?;
            PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 1)?;
        }
        Ok(solved.results)
    }

    /// The array of poses, if its form is right.
    fn poses_of<'py>(&self, poses: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray2<'py, f64>> {
        let count = self.robot.variables.len();
        let help = "numpy.asarray(poses, dtype=float) makes a float64 array";
        let Ok(array) = poses.cast::<PyUntypedArray>() else {
            let kind = poses.get_type().name()?;
            return Err(PyTypeError::new_err(format!(
                "poses: expected a float64 array of shape (n, {count}), got {kind}; {help}"
            )));
        };
        if !array.dtype().is_equiv_to(&f64::get_dtype(poses.py())) {
            let kind = array.dtype();
            return Err(PyTypeError::new_err(format!(
                "poses: expected dtype float64, got {kind}; {help}"
            )));
        }
        let wrong_shape = || {
            PyValueError::new_err(format!(
                "poses: expected shape (n, {count}), got {:?}; a row holds {}",
                array.shape(),
                self.variables().join(", ")
            ))
        };
        let aligned: bool = array.getattr("flags")?.getattr("aligned")?.extract()?;
        match array.cast::<PyArray2<f64>>() {
            Ok(array) if array.shape()[1] != count => Err(wrong_shape()),
            Ok(array) if array.is_c_contiguous() && aligned => Ok(array.try_readonly()?),
            // Any other order in memory is put right in a copy.
            Ok(array) => Ok(array
                .call_method1("copy", ("C",))?
                .cast::<PyArray2<f64>>()?
                .try_readonly()?),
            Err(_) => Err(wrong_shape()),
        }
    }
}

/// The values of all poses, row by row.
fn values<'a>(poses: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [f64]> {
    let values = poses.as_slice()?;
    if values.iter().all(|value| value.is_finite()) {
        return Ok(values);
    }
    let count = poses.shape()[1];
    let place = values.iter().position(|value| !value.is_finite());
    let place = place.unwrap_or_default();
    Err(PyValueError::new_err(format!(
        "poses[{}, {}] is {}; every value must be finite",
        place / count,
        place % count,
        values[place]
    )))
}
