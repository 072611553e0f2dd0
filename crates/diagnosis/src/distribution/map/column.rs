//! What a map is of.

use nalgebra::Matrix3;

use stiffbench_beams::structure::Compliance6;
use stiffbench_numeric::vector::{norm, scale};
use stiffbench_units_and_text::test_point::Direction;

use super::matrix::{ENTRIES, MatrixKind};

/// A stiffness of the end: force over displacement along it, N/m, or moment over rotation about it, N·m/rad.
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
    /// About a direction: 1/(nᵀ C n) of the rotation per moment.
    About {
        /// Its name.
        name: String,
        /// Unit vector, global.
        unit: [f64; 3],
    },
    /// About the principal axes of the rotation per moment, in the order of stiffness.
    PrincipalAbout(u8),
}

impl MapColumn {
    /// The three global axes.
    #[must_use]
    pub fn axes() -> Vec<Self> {
        let column = |axis: Direction| Self::Direction {
            name: axis.to_string(),
            unit: axis.unit_vector(),
        };
        Direction::ALL.map(column).to_vec()
    }

    /// About the three global axes.
    #[must_use]
    pub fn axes_of_rotation() -> Vec<Self> {
        let about = |column: Self| {
            let (name, unit) = (format!("r{}", column.name()), column.unit()?);
            Some(Self::About { name, unit })
        };
        Self::axes().into_iter().filter_map(about).collect()
    }

    /// The three principal stiffnesses.
    #[must_use]
    pub fn principal() -> [Self; 3] {
        [0, 1, 2].map(Self::Principal)
    }

    /// The three principal stiffnesses of rotation.
    #[must_use]
    pub fn principal_of_rotation() -> [Self; 3] {
        [0, 1, 2].map(Self::PrincipalAbout)
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
            Self::Direction { unit, .. } | Self::About { unit, .. } => Some(*unit),
            Self::Principal(_) | Self::PrincipalAbout(_) => None,
        }
    }

    /// The global axis along which it is, if it is one.
    #[must_use]
    pub fn axis(&self) -> Option<usize> {
        let unit = self.unit().filter(|_| !self.is_rotational())?;
        (0..3).find(|&axis| (0..3).all(|i| unit[i] == f64::from(u8::from(i == axis))))
    }

    /// Whether it is a principal stiffness.
    #[must_use]
    pub fn is_principal(&self) -> bool {
        self.order().is_some()
    }

    /// Place of a principal stiffness in their order, 0 the weakest.
    #[must_use]
    pub fn order(&self) -> Option<u8> {
        match self {
            Self::Principal(order) | Self::PrincipalAbout(order) => Some(*order),
            Self::Direction { .. } | Self::About { .. } => None,
        }
    }

    /// Whether it is about a direction rather than along one.
    #[must_use]
    pub fn is_rotational(&self) -> bool {
        matches!(self, Self::About { .. } | Self::PrincipalAbout(_))
    }

    /// Its name in tables and files.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Direction { name, .. } | Self::About { name, .. } => name,
            Self::Principal(0) => "weakest",
            Self::Principal(1) => "middle",
            Self::Principal(_) => "stiffest",
            Self::PrincipalAbout(0) => "weakest rotation",
            Self::PrincipalAbout(1) => "middle rotation",
            Self::PrincipalAbout(_) => "stiffest rotation",
        }
    }
}

/// Fills a row after the end from its compliance: the columns, the weakest direction and axis where there are principal stiffnesses, and
/// the matrix.
pub(super) fn fill_row(
    columns: &[MapColumn],
    matrix: Option<MatrixKind>,
    compliance: &Compliance6,
    row: &mut [f64],
) {
    let (stiffness, mut rest) = row[3..].split_at_mut(columns.len());
    let translation = compliance.translation();
    let [has_directions, has_axes] = has_principal(columns);
    let along_axes = has_directions.then(|| principal(&translation));
    let rotation = columns.iter().any(MapColumn::is_rotational);
    let rotation = rotation.then(|| rotation_per_moment(compliance));
    let about_axes = rotation.filter(|_| has_axes);
    let about_axes = about_axes.map(|rotation| principal(&rotation));
    let value = |column: &MapColumn| {
        Some(match column {
            MapColumn::Direction { unit, .. } => stiffness_along(&translation, *unit),
            MapColumn::Principal(order) => along_axes?.0[usize::from(*order)],
            MapColumn::About { unit, .. } => stiffness_along(&rotation?, *unit),
            MapColumn::PrincipalAbout(order) => about_axes?.0[usize::from(*order)],
        })
    };
    for (place, column) in stiffness.iter_mut().zip(columns) {
        *place = value(column).unwrap_or(f64::NAN);
    }
    for (_, [direction, ..]) in [along_axes, about_axes].into_iter().flatten() {
        let (place, after) = rest.split_at_mut(3);
        place.copy_from_slice(&direction);
        rest = after;
    }
    if let Some(matrix) = matrix {
        matrix.fill(compliance, rest);
    }
}

/// Rotation per moment, 3 × 3, rad/(N·m).
fn rotation_per_moment(compliance: &Compliance6) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| compliance.0[3 + i][3 + j]))
}

/// Whether there are principal stiffnesses along the principal directions, and about the principal axes.
fn has_principal(columns: &[MapColumn]) -> [bool; 2] {
    [false, true].map(|rotational| {
        let mut columns = columns.iter();
        columns.any(|column| column.is_principal() && column.is_rotational() == rotational)
    })
}

/// Share of the largest compliance below which another one is rounding: nothing yields there.
const RIGID_SHARE: f64 = 1e-13;

/// 1/(nᵀ C n); infinite where nothing yields.
fn stiffness_along(compliance: &[[f64; 3]; 3], unit: [f64; 3]) -> f64 {
    let largest = (0..3).fold(0.0_f64, |largest, i| largest.max(compliance[i][i]));
    let yields = along(compliance, unit);
    if yields.abs() <= RIGID_SHARE * largest {
        return f64::INFINITY;
    }
    1.0 / yields
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

/// Stiffness of a column along a direction, and the direction; a column about one is not asked for.
pub(super) fn stiffness_and_unit(
    column: &MapColumn,
    compliance: &[[f64; 3]; 3],
) -> (f64, [f64; 3]) {
    match column {
        MapColumn::Direction { unit, .. } | MapColumn::About { unit, .. } => {
            (stiffness_along(compliance, *unit), *unit)
        }
        MapColumn::Principal(order) | MapColumn::PrincipalAbout(order) => {
            let (stiffness, directions) = principal(compliance);
            let order = usize::from(*order);
            (stiffness[order], directions[order])
        }
    }
}

/// Principal stiffnesses from the weakest on, infinite where nothing yields, and their directions, the largest component of each positive.
fn principal(compliance: &[[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let symmetric =
        Matrix3::from_fn(|i, j| 0.5 * (compliance[i][j] + compliance[j][i])).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| symmetric.eigenvalues[b].total_cmp(&symmetric.eigenvalues[a]));
    let largest = symmetric.eigenvalues[order[0]];
    let stiffness = order.map(|place| {
        let yields = symmetric.eigenvalues[place];
        if yields.abs() <= RIGID_SHARE * largest.abs() {
            return f64::INFINITY;
        }
        1.0 / yields
    });
    let directions = order.map(|place| {
        let direction = symmetric.eigenvectors.column(place);
        let sign = direction[direction.iamax()].signum();
        [0, 1, 2].map(|i| sign * direction[i])
    });
    (stiffness, directions)
}

/// Numbers in a row: the end, the columns, the weakest direction and axis where there are principal stiffnesses, and the matrix.
#[must_use]
pub fn row_width(columns: &[MapColumn], matrix: Option<MatrixKind>) -> usize {
    let directions = has_principal(columns).into_iter();
    let directions = directions.filter(|has| *has).count();
    3 + columns.len() + 3 * directions + if matrix.is_some() { ENTRIES } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same displacement per force as rotation per moment, and nothing between them.
    fn whole(block: [[f64; 3]; 3]) -> Compliance6 {
        let mut compliance = Compliance6([[0.0; 6]; 6]);
        for i in 0..3 {
            for j in 0..3 {
                compliance.0[i][j] = block[i][j];
                compliance.0[3 + i][3 + j] = 10.0 * block[i][j];
            }
        }
        compliance
    }

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
        fill_row(&columns, None, &whole(compliance), &mut row);
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
        fill_row(&MapColumn::axes(), None, &whole(compliance), &mut row);
        assert_eq!(row[3..], [1.0 / 0.1, 1.0 / 0.3, 1.0 / 0.7]);
    }

    #[test]
    fn what_does_not_yield_is_infinitely_stiff() {
        // One spring along (3, 4, 0)/5: nothing across it yields.
        let axis: [f64; 3] = [0.6, 0.8, 0.0];
        let block = axis.map(|row| axis.map(|column| 1e-3 * row * column));
        let mut columns = MapColumn::axes();
        columns.extend(MapColumn::principal());
        columns.extend(MapColumn::along("across", [-0.8, 0.6, 0.0]));
        columns.extend(MapColumn::axes_of_rotation());
        let mut row = vec![0.0; row_width(&columns, None)];
        fill_row(&columns, None, &whole(block), &mut row);
        for (place, expected) in [(3, 1e3 / 0.36), (4, 1e3 / 0.64), (6, 1e3), (10, 1e2 / 0.36)] {
            assert!((row[place] / expected - 1.0).abs() < 1e-12, "{row:?}");
        }
        for place in [5, 7, 8, 9, 12] {
            assert_eq!(row[place], f64::INFINITY, "{place}: {row:?}");
        }
    }

    #[test]
    fn rotation_has_its_own_columns() {
        let block = [[0.5, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]];
        let mut columns = MapColumn::axes();
        columns.extend(MapColumn::axes_of_rotation());
        columns.extend(MapColumn::principal());
        columns.extend(MapColumn::principal_of_rotation());
        let width = row_width(&columns, Some(MatrixKind::Compliance));
        assert_eq!(width, 3 + 12 + 6 + 36);
        let mut row = vec![0.0; width];
        let matrix = Some(MatrixKind::Compliance);
        fill_row(&columns, matrix, &whole(block), &mut row);
        let expected = [2.0, 5.0, 10.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 0.2, 0.5, 1.0];
        for (found, expected) in row[3..15].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{row:?}");
        }
        assert_eq!(row[15..21], [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        assert_eq!((row[21], row[21 + 35]), (0.5, 1.0));
        assert_eq!(columns[3].axis(), None, "no axis along which it is stiff");
        assert_eq!(columns[9].name(), "weakest rotation");
    }
}
