//! Which parameters a fit may move, and between which bounds.

use super::error::LeastSquaresError;

/// What a fit may do with a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterRole {
    /// Moved by the fit within its bounds; an absent bound is an infinite one.
    Free {
        /// Where the search begins.
        start: f64,
        /// Smallest value allowed.
        lower: f64,
        /// Largest value allowed.
        upper: f64,
    },
    /// Kept.
    Fixed {
        /// The value kept.
        value: f64,
    },
    /// A multiple of another parameter of the same set, which may itself be tied.
    TiedTo {
        /// Index of that parameter.
        parameter: usize,
        /// This parameter divided by that one.
        ratio: f64,
    },
}

/// A named parameter; its unit is that of the model it belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name under which results are given.
    pub name: String,
    /// What the fit may do with it.
    pub role: ParameterRole,
}

impl Parameter {
    /// A parameter that the fit moves between two bounds.
    #[must_use]
    pub fn free(name: impl Into<String>, start: f64, lower: f64, upper: f64) -> Self {
        Self {
            name: name.into(),
            role: ParameterRole::Free {
                start,
                lower,
                upper,
            },
        }
    }

    /// A parameter that the fit moves without bounds.
    #[must_use]
    pub fn unbounded(name: impl Into<String>, start: f64) -> Self {
        Self::free(name, start, f64::NEG_INFINITY, f64::INFINITY)
    }

    /// A parameter that keeps its value.
    #[must_use]
    pub fn fixed(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            role: ParameterRole::Fixed { value },
        }
    }

    /// A parameter that is `ratio` times parameter number `parameter`.
    #[must_use]
    pub fn tied(name: impl Into<String>, parameter: usize, ratio: f64) -> Self {
        Self {
            name: name.into(),
            role: ParameterRole::TiedTo { parameter, ratio },
        }
    }

    fn validate(&self) -> Result<(), LeastSquaresError> {
        let finite = |what, value: f64| {
            value
                .is_finite()
                .then_some(())
                .ok_or_else(|| LeastSquaresError::NotFinite {
                    name: self.name.clone(),
                    what,
                    value,
                })
        };
        match self.role {
            ParameterRole::Fixed { value } => finite("its value", value),
            ParameterRole::TiedTo { ratio, .. } => finite("its ratio", ratio),
            ParameterRole::Free {
                start,
                lower,
                upper,
            } => {
                finite("its start", start)?;
                for (what, bound) in [("its lower bound", lower), ("its upper bound", upper)] {
                    if bound.is_nan() {
                        return finite(what, bound);
                    }
                }
                let name = self.name.clone();
                if lower >= upper {
                    Err(LeastSquaresError::EmptyRange { name, lower, upper })
                } else if start < lower || start > upper {
                    Err(LeastSquaresError::StartOutsideBounds {
                        name,
                        start,
                        lower,
                        upper,
                    })
                } else {
                    Ok(())
                }
            }
        }
    }
}

/// A side of a parameter's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Bound {
    /// The smallest value allowed.
    Lower,
    /// The largest value allowed.
    Upper,
}

/// Where the value of a parameter comes from once ties are followed to their end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ValueSource {
    Free { free: usize },
    Multiple { free: usize, ratio: f64 },
    Constant { value: f64 },
}

/// Parameters of one fit, and the mapping between the vector of the free ones and the vector of all.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterSet {
    parameters: Vec<Parameter>,
    sources: Vec<ValueSource>,
    free: Vec<usize>,
    slots: Vec<Option<usize>>,
}

impl ParameterSet {
    /// Checks the parameters and follows their ties.
    ///
    /// # Errors
    /// `NotFinite`, `EmptyRange`, `StartOutsideBounds`, `DuplicateName` for a single parameter; `UnknownTie`, `TieCycle` for ties;
    /// `NoFreeParameter` if there is nothing to fit.
    pub fn new(parameters: Vec<Parameter>) -> Result<Self, LeastSquaresError> {
        let count = parameters.len();
        let set = Self::with_any_number_of_free(parameters)?;
        if set.free.is_empty() {
            return Err(LeastSquaresError::NoFreeParameter { count });
        }
        Ok(set)
    }

    /// The same, where all may be fixed: a model that is only evaluated.
    ///
    /// # Errors
    /// As [`ParameterSet::new`], without `NoFreeParameter`.
    pub fn with_any_number_of_free(parameters: Vec<Parameter>) -> Result<Self, LeastSquaresError> {
        for (index, parameter) in parameters.iter().enumerate() {
            parameter.validate()?;
            if parameters[..index].iter().any(|p| p.name == parameter.name) {
                return Err(LeastSquaresError::DuplicateName {
                    name: parameter.name.clone(),
                });
            }
        }
        let free: Vec<usize> = (0..parameters.len())
            .filter(|&index| matches!(parameters[index].role, ParameterRole::Free { .. }))
            .collect();
        let sources = (0..parameters.len())
            .map(|index| follow(&parameters, &free, index))
            .collect::<Result<Vec<_>, _>>()?;
        // Free columns come first so that the Jacobian of the free parameters is the beginning of the whole one.
        let mut next = free.len();
        let slots = sources
            .iter()
            .map(|source| match *source {
                ValueSource::Free { free } => Some(free),
                ValueSource::Multiple { .. } => {
                    next += 1;
                    Some(next - 1)
                }
                ValueSource::Constant { .. } => None,
            })
            .collect();
        Ok(Self {
            parameters,
            sources,
            free,
            slots,
        })
    }

    /// The same set with one free parameter kept at `value`, as a profile needs it; none may be left free.
    pub(super) fn with_fixed(&self, index: usize, value: f64) -> Result<Self, LeastSquaresError> {
        let mut parameters = self.parameters.clone();
        parameters[index].role = ParameterRole::Fixed { value };
        Self::with_any_number_of_free(parameters)
    }

    /// The same set started at other values of the free parameters.
    ///
    /// # Errors
    /// `WrongLength`, `NotFinite` or `StartOutsideBounds`.
    pub fn with_start(&self, free_values: &[f64]) -> Result<Self, LeastSquaresError> {
        if free_values.len() != self.free.len() {
            return Err(LeastSquaresError::WrongLength {
                what: "start",
                expected: self.free.len(),
                found: free_values.len(),
            });
        }
        let mut set = self.clone();
        for (&index, &value) in self.free.iter().zip(free_values) {
            if let ParameterRole::Free { start, .. } = &mut set.parameters[index].role {
                *start = value;
            }
            set.parameters[index].validate()?;
        }
        Ok(set)
    }

    /// All parameters, in the order of the full vector.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Indices of the free parameters in the full vector, in the order of the free vector.
    #[must_use]
    pub fn free_indices(&self) -> &[usize] {
        &self.free
    }

    /// Start values of the free parameters.
    #[must_use]
    pub fn free_start(&self) -> Vec<f64> {
        self.free_roles().map(|(start, ..)| start).collect()
    }

    /// Bounds (lower, upper) of the free parameters.
    #[must_use]
    pub fn free_bounds(&self) -> Vec<(f64, f64)> {
        self.free_roles()
            .map(|(_, lower, upper)| (lower, upper))
            .collect()
    }

    fn free_roles(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        self.parameters.iter().filter_map(|p| match p.role {
            ParameterRole::Free {
                start,
                lower,
                upper,
            } => Some((start, lower, upper)),
            ParameterRole::Fixed { .. } | ParameterRole::TiedTo { .. } => None,
        })
    }

    /// The full vector that belongs to values of the free parameters, written into `full`.
    ///
    /// # Errors
    /// `WrongLength` if either slice has not the length of this set.
    pub fn expand(&self, free_values: &[f64], full: &mut [f64]) -> Result<(), LeastSquaresError> {
        for (what, expected, found) in [
            ("free parameters", self.free.len(), free_values.len()),
            ("full vector", self.parameters.len(), full.len()),
        ] {
            if expected != found {
                return Err(LeastSquaresError::WrongLength {
                    what,
                    expected,
                    found,
                });
            }
        }
        self.fill(free_values, full);
        Ok(())
    }

    /// [`Self::expand`] for slices whose lengths are known to fit.
    pub(super) fn fill(&self, free_values: &[f64], full: &mut [f64]) {
        for (value, source) in full.iter_mut().zip(&self.sources) {
            *value = match *source {
                ValueSource::Free { free } => free_values[free],
                ValueSource::Multiple { free, ratio } => ratio * free_values[free],
                ValueSource::Constant { value } => value,
            };
        }
    }

    pub(super) fn source(&self, index: usize) -> ValueSource {
        self.sources[index]
    }

    /// Column of each parameter in the working Jacobian; `None` for those that cannot move.
    pub(super) fn slots(&self) -> &[Option<usize>] {
        &self.slots
    }

    /// Columns of tied parameters: (their column, column of the free parameter, ratio).
    pub(super) fn tied_columns(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        self.sources
            .iter()
            .zip(&self.slots)
            .filter_map(|(source, slot)| match *source {
                ValueSource::Multiple { free, ratio } => slot.map(|slot| (slot, free, ratio)),
                ValueSource::Free { .. } | ValueSource::Constant { .. } => None,
            })
    }
}

/// Follows the ties of parameter `first` to a free or fixed parameter.
fn follow(
    parameters: &[Parameter],
    free: &[usize],
    first: usize,
) -> Result<ValueSource, LeastSquaresError> {
    let mut index = first;
    let mut total_ratio = 1.0;
    let mut visited = vec![first];
    loop {
        match parameters[index].role {
            ParameterRole::Fixed { value } => {
                return Ok(ValueSource::Constant {
                    value: total_ratio * value,
                });
            }
            ParameterRole::Free { .. } => {
                let free = free.partition_point(|&candidate| candidate < index);
                return Ok(if index == first {
                    ValueSource::Free { free }
                } else {
                    ValueSource::Multiple {
                        free,
                        ratio: total_ratio,
                    }
                });
            }
            ParameterRole::TiedTo { parameter, ratio } => {
                if parameter >= parameters.len() {
                    return Err(LeastSquaresError::UnknownTie {
                        name: parameters[index].name.clone(),
                        index: parameter,
                        count: parameters.len(),
                    });
                }
                if let Some(begin) = visited.iter().position(|&seen| seen == parameter) {
                    visited.push(parameter);
                    return Err(LeastSquaresError::TieCycle {
                        names: visited[begin..]
                            .iter()
                            .map(|&i| parameters[i].name.clone())
                            .collect(),
                    });
                }
                visited.push(parameter);
                total_ratio *= ratio;
                index = parameter;
            }
        }
    }
}

#[cfg(test)]
mod tests;
