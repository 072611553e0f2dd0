//! Values scattered over a plane, gathered in square bins.
//!
//! Decision. What is drawn over a plane goes through bins, never through its points: a figure of fifty thousand poses then has
//! a few thousand areas, however unevenly the points fell. Each bin keeps sums, from which follow its mean and a smooth estimate at its
//! centre.

use super::range::finite_ends;

/// Points wanted in a bin, and most bins along a side.
const WANTED_IN_A_BIN: f64 = 12.0;
const MOST_BINS: f64 = 110.0;
/// Fewest points behind the smooth estimate: a plane has three coefficients.
const FEWEST_OF_A_PLANE: usize = 4;
/// Neighbours with points, of eight, among which an empty bin is a gap that chance left; one less will do where two of them face each
/// other across it, which is how a straight border is notched.
const FEWEST_AROUND_A_GAP: usize = 6;
/// A plane fitted to points on (nearly) a line carries no information across it: least ratio of the two spreads.
const LEAST_SPREAD_RATIO: f64 = 1e-3;

/// What the value of a bin is of the values of its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BinValue {
    /// Their mean.
    #[default]
    Mean,
    /// The median.
    Median,
    /// The least.
    Least,
    /// The greatest.
    Greatest,
}

/// Square bins over the part of a plane where there are points.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneBins {
    origin_m: [f64; 2],
    side_m: f64,
    size: [usize; 2],
    sums: Vec<BinSums>,
    left_out: usize,
    value: BinValue,
}

/// One bin with at least one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneBin {
    /// Column and row, from the least coordinates on.
    pub place: [usize; 2],
    /// Centre, m.
    pub centre_m: [f64; 2],
    /// Number of points.
    pub count: usize,
    /// Mean of their values, or what [`BinValue`] states instead.
    pub value: f64,
    /// Least and greatest of their values.
    pub range: [f64; 2],
}

/// What a bin keeps of its points; coordinates count from the centre of the bin, in sides.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BinSums {
    count: usize,
    /// Σa, Σb, Σa², Σab, Σb².
    places: [f64; 5],
    /// Σv, Σav, Σbv.
    values: [f64; 3],
    range: [f64; 2],
}

impl BinSums {
    /// One value at the centre of the bin in place of all; the number of points and their range stay.
    fn set(&mut self, value: f64) {
        let n = self.count as f64;
        self.places = [0.0; 5];
        self.values = [n * value, 0.0, 0.0];
    }

    const EMPTY: Self = Self {
        count: 0,
        places: [0.0; 5],
        values: [0.0; 3],
        range: [f64::INFINITY, f64::NEG_INFINITY],
    };

    fn add(&mut self, [a, b]: [f64; 2], value: f64) {
        self.count += 1;
        for (sum, term) in self.places.iter_mut().zip([a, b, a * a, a * b, b * b]) {
            *sum += term;
        }
        for (sum, term) in self.values.iter_mut().zip([value, a * value, b * value]) {
            *sum += term;
        }
        self.range = [self.range[0].min(value), self.range[1].max(value)];
    }

    /// The same points seen from the centre of a bin that lies by (da, db) sides behind.
    fn seen_from(&self, [da, db]: [f64; 2]) -> ([f64; 5], [f64; 3]) {
        let n = self.count as f64;
        let [sa, sb, saa, sab, sbb] = self.places;
        let [sv, sav, sbv] = self.values;
        (
            [
                sa + n * da,
                sb + n * db,
                saa + 2.0 * da * sa + n * da * da,
                sab + da * sb + db * sa + n * da * db,
                sbb + 2.0 * db * sb + n * db * db,
            ],
            [sv, sav + da * sv, sbv + db * sv],
        )
    }
}

impl PlaneBins {
    /// A side for which a map of these points is even and fine: a dozen points in a bin, and no more bins than can be seen.
    #[must_use]
    pub fn side_for(points: &[[f64; 2]]) -> f64 {
        let span = |i: usize| {
            let ends = finite_ends(points.iter().map(|point| point[i]));
            ends.map_or(0.0, |[low, high]| high - low)
        };
        let [wide, high] = [span(0), span(1)];
        // The workspace of an arm fills about half of the rectangle around it.
        let even = (0.5 * wide * high * WANTED_IN_A_BIN / points.len().max(1) as f64).sqrt();
        let side = even.max(wide.max(high) / MOST_BINS);
        // Tenths of a millimetre are easier to state.
        if side > 1e-4 {
            (side * 1e4).ceil() * 1e-4
        } else {
            1e-4
        }
    }

    /// Gathers points with their values; those that are not finite are counted in [`PlaneBins::left_out`].
    ///
    /// # Arguments
    /// - `points`: place on the plane, m, and value.
    /// - `side_m`: side of a bin, positive. Bins are aligned to its multiples, so that maps with the same side lie bin on bin.
    #[must_use]
    pub fn gather(points: impl Iterator<Item = ([f64; 2], f64)> + Clone, side_m: f64) -> Self {
        let is_finite =
            |([a, b], value): &([f64; 2], f64)| a.is_finite() && b.is_finite() && value.is_finite();
        let finite = points.clone().filter(is_finite);
        let mut ends: Option<[[i64; 2]; 2]> = None;
        for (at, _) in finite.clone() {
            let place = at.map(|c| (c / side_m).floor() as i64);
            let [low, high] = ends.unwrap_or([place, place]);
            ends = Some([
                [0, 1].map(|i| low[i].min(place[i])),
                [0, 1].map(|i| high[i].max(place[i])),
            ]);
        }
        let size = ends.map_or([0, 0], |[low, high]| {
            [0, 1].map(|i| (high[i] - low[i]) as usize + 1)
        });
        let first = ends.map_or([0, 0], |[low, _]| low);
        let mut bins = Self {
            origin_m: first.map(|place| place as f64 * side_m),
            side_m,
            size,
            sums: vec![BinSums::EMPTY; size[0] * size[1]],
            left_out: points.count(),
            value: BinValue::Mean,
        };
        for (at, value) in finite {
            let place = [0, 1].map(|i| ((at[i] / side_m).floor() as i64 - first[i]) as usize);
            let centre = bins.centre_m(place);
            let from_centre = [0, 1].map(|i| (at[i] - centre[i]) / side_m);
            bins.sums[place[1] * size[0] + place[0]].add(from_centre, value);
            bins.left_out -= 1;
        }
        bins
    }

    /// As [`PlaneBins::gather`], with another value than the mean in each bin, which then stands at its centre.
    #[must_use]
    pub fn gather_as(
        value: BinValue,
        points: impl Iterator<Item = ([f64; 2], f64)> + Clone,
        side_m: f64,
    ) -> Self {
        let mut bins = Self::gather(points.clone(), side_m);
        bins.value = value;
        match value {
            BinValue::Mean => {}
            BinValue::Least | BinValue::Greatest => {
                let end = usize::from(value == BinValue::Greatest);
                for sums in bins.sums.iter_mut().filter(|sums| sums.count > 0) {
                    sums.set(sums.range[end]);
                }
            }
            BinValue::Median => {
                let mut by_bin = vec![Vec::new(); bins.sums.len()];
                for (at, value) in points.filter(|(_, value)| value.is_finite()) {
                    if let Some(index) = bins.index(at) {
                        by_bin[index].push(value);
                    }
                }
                for (sums, values) in bins.sums.iter_mut().zip(&mut by_bin) {
                    values.sort_unstable_by(f64::total_cmp);
                    if let Some(upper) = values.get(values.len() / 2) {
                        sums.set(0.5 * (values[(values.len() - 1) / 2] + upper));
                    }
                }
            }
        }
        bins
    }

    /// What the value of a bin is.
    #[must_use]
    pub fn value(&self) -> BinValue {
        self.value
    }

    /// Side of a bin, m.
    #[must_use]
    pub fn side_m(&self) -> f64 {
        self.side_m
    }

    /// Columns and rows.
    #[must_use]
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Points that are in no bin because a coordinate or their value is not finite.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// Points in all bins.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sums.iter().map(|bin| bin.count).sum()
    }

    /// Centre of a bin, m, also of one beyond the bins.
    #[must_use]
    pub(super) fn centre_m(&self, [column, row]: [usize; 2]) -> [f64; 2] {
        let [a, b] = self.origin_m;
        [
            a + (column as f64 + 0.5) * self.side_m,
            b + (row as f64 + 0.5) * self.side_m,
        ]
    }

    /// The bins with points, row by row.
    pub fn filled(&self) -> impl Iterator<Item = PlaneBin> + '_ {
        let columns = self.size[0];
        let bins = self.sums.iter().enumerate();
        bins.filter(|(_, sums)| sums.count > 0)
            .map(move |(index, sums)| {
                let place = [index % columns, index / columns];
                PlaneBin {
                    place,
                    centre_m: self.centre_m(place),
                    count: sums.count,
                    value: sums.values[0] / sums.count as f64,
                    range: sums.range,
                }
            })
    }

    /// Whether a place lies in a bin with points.
    pub(super) fn holds(&self, at_m: [f64; 2]) -> bool {
        let [column, row] =
            [0, 1].map(|i| ((at_m[i] - self.origin_m[i]) / self.side_m).floor() as i64);
        self.at(column, row).is_some()
    }

    /// Index of the bin of a point that was gathered; `None` for one that is not finite.
    fn index(&self, at_m: [f64; 2]) -> Option<usize> {
        if !at_m.iter().all(|c| c.is_finite()) {
            return None;
        }
        let place = [0, 1].map(|i| {
            let first = (self.origin_m[i] / self.side_m).round();
            ((at_m[i] / self.side_m).floor() - first) as usize
        });
        Some(place[1] * self.size[0] + place[0])
    }

    /// What is drawn, row by row: the mean of every bin with points, and the estimate of every gap between them.
    pub(super) fn drawn(&self) -> impl Iterator<Item = ([usize; 2], f64)> + '_ {
        let [columns, rows] = self.size;
        let places = (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]));
        places.filter_map(|[column, row]| {
            let own = self.at(column as i64, row as i64);
            let mean = own.map(|own| own.values[0] / own.count as f64);
            Some(([column, row], mean.or_else(|| self.smooth([column, row]))?))
        })
    }

    /// Estimate at the centre of a bin: the plane through the points of the bin and its eight neighbours, least squares; the mean of
    /// the bin where too few points or points on one line give no plane. `None` for a bin without a point, unless it is a gap: most of
    /// its neighbours have some.
    ///
    /// A mean belongs to where the points happen to lie, which at the border is not the centre; the plane follows a slope exactly.
    #[must_use]
    pub(super) fn smooth(&self, [column, row]: [usize; 2]) -> Option<f64> {
        let own = self.at(column as i64, row as i64);
        let mean = own.map(|own| own.values[0] / own.count as f64);
        let (mut bins, mut count, mut places, mut values) = (0, 0, [0.0; 5], [0.0; 3]);
        for (da, db) in (-1..=1).flat_map(|da| (-1..=1).map(move |db| (da, db))) {
            let Some(sums) = self.at(column as i64 + da, row as i64 + db) else {
                continue;
            };
            let (p, v) = sums.seen_from([da as f64, db as f64]);
            bins += 1;
            count += sums.count;
            places = std::array::from_fn(|i| places[i] + p[i]);
            values = std::array::from_fn(|i| values[i] + v[i]);
        }
        if own.is_none() && bins + usize::from(self.is_between([column, row])) < FEWEST_AROUND_A_GAP
        {
            return None;
        }
        if count < FEWEST_OF_A_PLANE {
            return mean;
        }
        plane_at_centre(count as f64, places, values).or(mean)
    }

    /// Whether the bins to the left and right, or those above and below, have points.
    fn is_between(&self, place: [usize; 2]) -> bool {
        let [column, row] = place.map(|n| n as i64);
        let facing = |da: i64, db: i64| {
            self.at(column - da, row - db).is_some() && self.at(column + da, row + db).is_some()
        };
        facing(1, 0) || facing(0, 1)
    }

    fn at(&self, column: i64, row: i64) -> Option<&BinSums> {
        let [columns, rows] = self.size.map(|n| n as i64);
        if !(0..columns).contains(&column) || !(0..rows).contains(&row) {
            return None;
        }
        let sums = &self.sums[(row * columns + column) as usize];
        (sums.count > 0).then_some(sums)
    }
}

/// Value at the origin of the plane fitted to points with these sums; `None` if they lie on a line.
fn plane_at_centre(
    n: f64,
    [sa, sb, saa, sab, sbb]: [f64; 5],
    [sv, sav, sbv]: [f64; 3],
) -> Option<f64> {
    // About the mean place, so that the slopes are those of two unknowns.
    let [ma, mb, mv] = [sa / n, sb / n, sv / n];
    let [caa, cab, cbb] = [saa - sa * ma, sab - sa * mb, sbb - sb * mb];
    let [cav, cbv] = [sav - ma * sv, sbv - mb * sv];
    let determinant = caa * cbb - cab * cab;
    let trace = caa + cbb;
    // The smaller eigenvalue is about determinant / trace.
    if determinant <= LEAST_SPREAD_RATIO * trace * trace {
        return None;
    }
    let slope_a = (cav * cbb - cbv * cab) / determinant;
    let slope_b = (cbv * caa - cav * cab) / determinant;
    Some(mv - slope_a * ma - slope_b * mb)
}

#[cfg(test)]
mod tests;
