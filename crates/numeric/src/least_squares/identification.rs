//! Combinations of parameters that the data do not determine, in terms of the parameters.

use std::fmt;

/// Why the data do not determine a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhyNotIdentified {
    /// No residual depends on it.
    NoEffect,
    /// It can be exchanged for others: see the direction with this index in `ParameterCovariance::unidentified`.
    OnlyInCombination {
        /// Index of the direction.
        direction: usize,
    },
}

/// A change of several parameters at once that leaves every residual as it is, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct UnidentifiedDirection {
    /// The changes that belong together; the first one is the reference and has the change 1 in its own unit.
    pub components: Vec<DirectionComponent>,
}

/// One parameter's part in an unidentified direction.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionComponent {
    /// Index in the full vector.
    pub parameter: usize,
    /// Name of the parameter.
    pub name: String,
    /// Change, in the parameter's unit.
    pub change: f64,
}

impl fmt::Display for UnidentifiedDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.components.as_slice() {
            [only] => write!(f, "no residual depends on {}", only.name),
            components => {
                f.write_str("no residual changes when together")?;
                for (place, component) in components.iter().enumerate() {
                    let comma = if place == 0 { "" } else { "," };
                    write!(
                        f,
                        "{comma} {} changes by {:+.4e}",
                        component.name, component.change
                    )?;
                }
                Ok(())
            }
        }
    }
}

/// A share of a null vector below this is rounding: the square root of the accuracy asked of the Jacobian, rounded up.
const NEGLIGIBLE_SHARE: f64 = 1e-5;

/// Brings null vectors to echelon form, so that separate degeneracies are reported separately and not as an arbitrary mixture.
///
/// Each vector is in scaled parameters (columns of unit length) and is overwritten; after this every vector has an entry 1 at a
/// parameter where all others have 0, and entries that are rounding are 0.
pub(super) fn reduce_to_echelon(vectors: &mut [Vec<f64>]) {
    let Some(length) = vectors.first().map(Vec::len) else {
        return;
    };
    let mut used = vec![false; length];
    for row in 0..vectors.len() {
        let pivot = (0..length)
            .filter(|&j| !used[j])
            .max_by(|&a, &b| vectors[row][a].abs().total_cmp(&vectors[row][b].abs()));
        let Some(pivot) = pivot else { return };
        used[pivot] = true;
        let divisor = vectors[row][pivot];
        if divisor == 0.0 {
            continue;
        }
        for entry in &mut vectors[row] {
            *entry /= divisor;
        }
        let reference = vectors[row].clone();
        for (other, vector) in vectors.iter_mut().enumerate() {
            if other != row {
                let factor = vector[pivot];
                for (entry, from) in vector.iter_mut().zip(&reference) {
                    *entry -= factor * from;
                }
            }
        }
    }
    for vector in vectors {
        let largest = vector
            .iter()
            .fold(0.0_f64, |largest, e| largest.max(e.abs()));
        for entry in vector {
            if entry.abs() <= NEGLIGIBLE_SHARE * largest {
                *entry = 0.0;
            }
        }
    }
}

/// The direction that belongs to a null vector in echelon form.
///
/// `columns` gives for each entry the parameter's index, name and the length of its column, by which the entry was scaled.
pub(super) fn direction(vector: &[f64], columns: &[(usize, &str, f64)]) -> UnidentifiedDirection {
    let mut components: Vec<(f64, DirectionComponent)> = vector
        .iter()
        .zip(columns)
        .filter(|(entry, _)| **entry != 0.0)
        .map(|(entry, &(parameter, name, length))| {
            // A column of zeros was not scaled.
            let change = if length == 0.0 {
                *entry
            } else {
                entry / length
            };
            let name = name.to_owned();
            (
                entry.abs(),
                DirectionComponent {
                    parameter,
                    name,
                    change,
                },
            )
        })
        .collect();
    components.sort_by(|a, b| b.0.total_cmp(&a.0));
    if let Some(reference) = components.first().map(|(_, component)| component.change) {
        for (_, component) in &mut components {
            component.change /= reference;
        }
    }
    UnidentifiedDirection {
        components: components
            .into_iter()
            .map(|(_, component)| component)
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_of_two_degeneracies_is_taken_apart() {
        // Truth: parameters 0 and 1 exchange one for one, 2 and 3 one for minus two.
        let (a, b) = ([1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 1.0]);
        let mix = |s: f64, t: f64| (0..4).map(|i| s * a[i] + t * b[i]).collect::<Vec<f64>>();
        let mut vectors = vec![mix(0.3, 0.8), mix(0.7, -0.2)];
        reduce_to_echelon(&mut vectors);
        for vector in &vectors {
            assert_eq!(
                vector.iter().filter(|e| **e != 0.0).count(),
                2,
                "{vector:?}"
            );
        }
    }

    #[test]
    fn an_undetermined_direction_has_the_units_of_the_parameters() {
        let columns = [(0, "c", 10.0), (2, "d", 1.0), (3, "e", 1.0)];
        let found = direction(&[1.0, -0.5, 0.0], &columns);
        assert_eq!(
            found.to_string(),
            "no residual changes when together c changes by +1.0000e0, d changes by -5.0000e0"
        );
        assert_eq!(
            direction(&[0.0, 0.0, 1.0], &columns).to_string(),
            "no residual depends on e"
        );
    }
}
