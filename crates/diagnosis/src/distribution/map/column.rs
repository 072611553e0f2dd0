//! What a map is of.

use nalgebra::Matrix3;

use stiffbench_numeric::vector::{norm, scale};

/// A stiffness of the end: force over displacement along it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MapColumn {
    /// Along a direction: 1/(nᵀ C n).
    Direction {
        /// Its name.
        name: String,
        /// Unit vector, global.
        unit: [f64; 3],
    },
    /// Along the principal directions of the displacement per force, in the order of stiffness: 0 the weakest, 2 the stiffest.
    Principal(u8),
}

impl MapColumn {
    /// The three global axes.
    #[must_use]
    pub fn axes() -> Vec<Self> {
        let axes = [
            ("x", [1.0, 0.0, 0.0]),
            ("y", [0.0, 1.0, 0.0]),
            ("z", [0.0, 0.0, 1.0]),
        ];
        let column = |(name, unit): (&str, [f64; 3])| Self::Direction {
            name: name.to_owned(),
            unit,
        };
        axes.map(column).to_vec()
    }

    /// The three principal stiffnesses.
    #[must_use]
    pub fn principal() -> [Self; 3] {
        [0, 1, 2].map(Self::Principal)
    }

    /// Along any vector but zero; axes have their names, others are named as given. `None` for a vector without direction.
    #[must_use]
    pub fn along(name: &str, vector: [f64; 3]) -> Option<Self> {
        let length = norm(vector);
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let unit = scale(vector, 1.0 / length);
        let axes = Self::axes();
        let axis = axes.into_iter().find(|axis| axis.unit() == Some(unit));
        Some(axis.unwrap_or_else(|| Self::Direction {
            name: name.to_owned(),
            unit,
        }))
    }

    /// The direction; `None` for a principal stiffness, whose direction changes from pose to pose.
    #[must_use]
    pub fn unit(&self) -> Option<[f64; 3]> {
        match self {
            Self::Direction { unit, .. } => Some(*unit),
            Self::Principal(_) => None,
        }
    }

    /// The global axis it is, if it is one.
    #[must_use]
    pub fn axis(&self) -> Option<usize> {
        let unit = self.unit()?;
        (0..3).find(|&axis| (0..3).all(|i| unit[i] == f64::from(u8::from(i == axis))))
    }

    /// Whether it is a principal stiffness.
    #[must_use]
    pub fn is_principal(&self) -> bool {
        matches!(self, Self::Principal(_))
    }

    /// Its name in tables and files.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Direction { name, .. } => name,
            Self::Principal(0) => "weakest",
            Self::Principal(1) => "middle",
            Self::Principal(_) => "stiffest",
        }
    }
}

/// Fills the columns and the weakest direction of a row from the displacement per force, 3 × 3, m/N.
pub(super) fn fill_row(columns: &[MapColumn], compliance: &[[f64; 3]; 3], row: &mut [f64]) {
    let (stiffness, weakest) = row[3..].split_at_mut(columns.len());
    let principal = (!weakest.is_empty()).then(|| principal(compliance));
    for (value, column) in stiffness.iter_mut().zip(columns) {
        *value = match (column, &principal) {
            (MapColumn::Direction { unit, .. }, _) => 1.0 / along(compliance, *unit),
            (MapColumn::Principal(order), Some((stiffness, _))) => stiffness[usize::from(*order)],
            (MapColumn::Principal(_), None) => {
                unreachable!("rows with it have room for its direction")
            }
        };
    }
    if let Some((_, [direction, ..])) = principal {
        weakest.copy_from_slice(&direction);
    }
}

/// nᵀ C n.
fn along(compliance: &[[f64; 3]; 3], unit: [f64; 3]) -> f64 {
    let mut sum = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            // A direction along an axis takes its entry untouched.
            if unit[i] != 0.0 && unit[j] != 0.0 {
                sum += unit[i] * compliance[i][j] * unit[j];
            }
        }
    }
    sum
}

/// Stiffness of a column and the direction it is along.
pub(super) fn stiffness_and_unit(
    column: &MapColumn,
    compliance: &[[f64; 3]; 3],
) -> (f64, [f64; 3]) {
    match column {
        MapColumn::Direction { unit, .. } => (1.0 / along(compliance, *unit), *unit),
        MapColumn::Principal(order) => {
            let (stiffness, directions) = principal(compliance);
            let order = usize::from(*order);
            (stiffness[order], directions[order])
        }
    }
}

/// Principal stiffnesses from the weakest on, and their directions, the largest component of each positive.
fn principal(compliance: &[[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let symmetric =
        Matrix3::from_fn(|i, j| 0.5 * (compliance[i][j] + compliance[j][i])).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| symmetric.eigenvalues[b].total_cmp(&symmetric.eigenvalues[a]));
    let stiffness = order.map(|place| 1.0 / symmetric.eigenvalues[place]);
    let directions = order.map(|place| {
        let direction = symmetric.eigenvectors.column(place);
        let sign = direction[direction.iamax()].signum();
        [0, 1, 2].map(|i| sign * direction[i])
    });
    (stiffness, directions)
}

/// Numbers in a row: the end, the columns, and the weakest direction where there are principal stiffnesses.
#[must_use]
pub fn row_width(columns: &[MapColumn]) -> usize {
    let principal = columns.iter().any(MapColumn::is_principal);
    3 + columns.len() + if principal { 3 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_stiffnesses_of_a_turned_spring() {
        // Springs of 2, 5 and 10 N/m along axes turned by 30 degrees about z.
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let axes = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let compliance = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let springs = axes.iter().zip([5.0, 2.0, 10.0]);
                springs.map(|(axis, k)| axis[i] * axis[j] / k).sum()
            })
        });
        let mut columns = MapColumn::principal().to_vec();
        columns.extend(MapColumn::along("oblique", [2.0 * cos, 2.0 * sin, 0.0]));
        let mut row = [0.0; 10];
        fill_row(&columns, &compliance, &mut row);
        let expected = [2.0, 5.0, 10.0, 5.0, sin, -cos, 0.0];
        for (found, expected) in row[3..].iter().zip(expected) {
            // The largest component of the weakest direction is positive.
            let expected = if expected == sin || expected == -cos {
                -expected
            } else {
                expected
            };
            assert!((found - expected).abs() < 1e-14, "{row:?}");
        }
    }

    #[test]
    fn axes_are_known_by_their_vectors() {
        assert_eq!(
            MapColumn::along("0,3,0", [0.0, 3.0, 0.0]),
            Some(MapColumn::axes()[1].clone())
        );
        assert_eq!(MapColumn::along("zero", [0.0; 3]), None);
        let oblique = MapColumn::along("1,1,0", [1.0, 1.0, 0.0]).unwrap();
        assert_eq!((oblique.name(), oblique.axis()), ("1,1,0", None));
        // Along an axis the entry of the diagonal is not touched, also where others are large.
        let mut row = [0.0; 6];
        let compliance = [[0.1, 1e9, 0.0], [1e9, 0.3, 0.0], [0.0, 0.0, 0.7]];
        fill_row(&MapColumn::axes(), &compliance, &mut row);
        assert_eq!(row[3..], [1.0 / 0.1, 1.0 / 0.3, 1.0 / 0.7]);
    }
}
