//! Figures of maps (the paper's Figs. 11 to 28).

use crate::distribution::{Extreme, MapColumn, MapPlane, MechanismStudy};
use crate::plot::{
    BinValue, Figure, NamedPoint, PlaneBins, PlaneMap, PlaneMapDifference, PlaneMapFigure, ValueAt,
    plane_map, plane_map_difference, plane_map_sheet,
};

use super::MapReport;
use crate::report::axis_words::plane_axis_names;
use crate::report::figures::SAME_PLACE_M;

/// N/m in a N/mm, in which the numbers on contour lines are short.
const N_PER_MM: f64 = 1e3;

/// The unit in which a column is drawn, and what it is in SI.
fn drawn_unit(column: &MapColumn) -> (&'static str, f64) {
    if column.is_rotational() {
        ("N·m/rad", 1.0)
    } else {
        ("N/mm", N_PER_MM)
    }
}

impl MapReport<'_> {
    /// One figure for each mechanism and column, and one for each column of all mechanisms with one scale, by file name.
    #[must_use]
    pub fn figures(&self) -> Vec<(String, Figure)> {
        let mechanisms = self.mechanisms.iter();
        let mechanisms = mechanisms.map(|(_, study)| study.map.mechanism.as_str());
        let mechanisms: Vec<&str> = mechanisms.collect();
        let mut figures = Vec::new();
        for (index, column) in self.columns() {
            let words = column_words(&column);
            let all = PlaneMapFigure {
                title: format!("{}: {words}", self.robot.name),
                quantity: words,
                unit: drawn_unit(&column).0.to_owned(),
                about: self.about_stiffness(&column),
                maps: self.plane_maps(index, &column),
                range: None,
            };
            figures.extend(sheets(&all, &mechanisms, |name| file_name(&column, name)));
        }
        figures
    }

    /// What the second of two mechanisms has more than the first, for each column; `None` if one of them is not among the maps.
    #[must_use]
    pub fn differences(&self, before: &str, after: &str) -> Option<Vec<(String, Figure)>> {
        let place = |name: &str| {
            let mut studies = self.mechanisms.iter();
            studies.position(|(_, study)| study.map.mechanism == name)
        };
        let places = [place(before)?, place(after)?];
        Some(
            self.columns()
                .into_iter()
                .map(|(index, column)| {
                    let words = column_words(&column);
                    let maps = self.plane_maps(index, &column);
                    let [before_map, after_map] = places.map(|place| maps[place].clone());
                    let figure = plane_map_difference(&PlaneMapDifference {
                        title: format!("{}: {words}, {after} against {before}", self.robot.name),
                        quantity: words,
                        unit: drawn_unit(&column).0.to_owned(),
                        about: self.about_stiffness(&column),
                        before: before_map,
                        after: after_map,
                    });
                    (
                        file_name(&column, &format!("{after}-against-{before}")),
                        figure,
                    )
                })
                .collect(),
        )
    }

    /// The columns that are drawn: of the principal stiffnesses the weakest, which is what a user must know.
    fn columns(&self) -> Vec<(usize, MapColumn)> {
        let first = self.mechanisms.first();
        let columns = first.map_or_else(Vec::new, |(_, study)| study.map.columns.clone());
        let is_drawn = |column: &MapColumn| !column.is_principal() || column.order() == Some(0);
        // Every mechanism must have something to draw.
        let yields = |place: usize| {
            self.mechanisms
                .iter()
                .all(|(_, s)| s.found(place).is_some())
        };
        columns
            .into_iter()
            .enumerate()
            .filter(|(place, column)| is_drawn(column) && yields(*place))
            .collect()
    }

    pub(in crate::report) fn about(&self) -> String {
        let load = self.at_load_n.map_or_else(String::new, |load| {
            format!(", secant at {load} N where not linear")
        });
        format!(
            "Factors {}{load}; {}.",
            self.factors_name,
            self.sampling_words()
        )
    }

    /// The same, and how the unit of the figures goes with that of the tables.
    fn about_stiffness(&self, column: &MapColumn) -> String {
        if column.is_rotational() {
            return self.about();
        }
        format!("{} 1\u{a0}N/mm is 0.001\u{a0}N/µm.", self.about())
    }

    /// The maps of a column, all with bins of one side.
    fn plane_maps(&self, index: usize, column: &MapColumn) -> Vec<PlaneMap> {
        let (_, scale) = drawn_unit(column);
        let studies = self.mechanisms.iter().map(|(_, study)| {
            let values: Vec<f64> = study.map.column(index).map(|k| k / scale).collect();
            let rows = || (0..values.len()).filter(|&row| values[row].is_finite());
            let ordered = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
            DrawnMap {
                mechanism: &study.map.mechanism,
                points: places_of(study, &self.poses.plane),
                least: rows().min_by(ordered),
                greatest: rows().max_by(ordered),
                values,
            }
        });
        self.drawn(&studies.collect::<Vec<_>>(), self.bin_value())
    }

    /// Values of mechanisms in the plane, all with bins of one side.
    pub(super) fn drawn(&self, maps: &[DrawnMap<'_>], bin_value: BinValue) -> Vec<PlaneMap> {
        let sides = maps.iter().map(|map| PlaneBins::side_for(&map.points));
        let side_m = sides.fold(0.0, f64::max);
        let drawn = maps.iter().map(|map| {
            let pairs = map.points.iter().copied().zip(map.values.iter().copied());
            let pairs = pairs.filter(|(_, value)| value.is_finite());
            let at = |row: usize| ValueAt {
                at_m: map.points[row],
                value: map.values[row],
            };
            PlaneMap {
                heading: format!("mechanism {}", map.mechanism),
                axes: plane_axis_names(&self.poses.plane, self.robot),
                bins: PlaneBins::gather_as(bin_value, pairs, side_m),
                extremes: self.outermost(&map.points),
                least: map.least.map(at),
                greatest: map.greatest.map(at),
            }
        });
        drawn.collect()
    }

    /// The outermost of points (z, y), with the name of the pose that the robot file states nearby.
    fn outermost(&self, points: &[[f64; 2]]) -> Vec<NamedPoint> {
        Extreme::of_points(points.iter().copied())
            .into_iter()
            .filter_map(|extreme| {
                let value = |point: &[f64; 2]| extreme.of_reach_and_height(*point);
                let at = points.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?;
                let is_stated = self.poses.plane.is_of_the_paper();
                let near = self.robot.poses.iter().filter(|_| is_stated).find(|pose| {
                    pose.stated_zy_m
                        .is_some_and(|[z, y]| (z - at[0]).hypot(y - at[1]) < SAME_PLACE_M)
                });
                Some(NamedPoint {
                    name: near.map_or_else(
                        || self.poses.plane.word(extreme),
                        |pose| pose.id.to_string(),
                    ),
                    across_m: at[0],
                    up_m: at[1],
                })
            })
            .collect()
    }
}

/// A value of a mechanism over the plane, row by row.
pub(super) struct DrawnMap<'a> {
    pub(super) mechanism: &'a str,
    /// Where the end is, m.
    pub(super) points: Vec<[f64; 2]>,
    pub(super) values: Vec<f64>,
    /// Row of the least value.
    pub(super) least: Option<usize>,
    /// Row of the greatest value.
    pub(super) greatest: Option<usize>,
}

/// A figure for each mechanism, and one of all with one scale, by file name.
///
/// # Arguments
/// - `all`: with the title that each begins with.
pub(super) fn sheets(
    all: &PlaneMapFigure,
    mechanisms: &[&str],
    file: impl Fn(&str) -> String,
) -> Vec<(String, Figure)> {
    let figure = |of: &str, maps: &[PlaneMap]| PlaneMapFigure {
        title: format!("{}, {of}", all.title),
        maps: maps.to_vec(),
        ..all.clone()
    };
    let each = all.maps.chunks(1).zip(mechanisms).map(|(map, name)| {
        let one = figure(&format!("mechanism {name}"), map);
        (file(name), plane_map(&one))
    });
    let mut figures: Vec<(String, Figure)> = each.collect();
    if all.maps.len() > 1 {
        let all = figure("one scale for all mechanisms", &all.maps);
        figures.push((file("all"), plane_map_sheet(&all)));
    }
    figures
}

/// Where the end is in the plane in each row, m.
fn places_of(study: &MechanismStudy, plane: &MapPlane) -> Vec<[f64; 2]> {
    let rows = 0..study.map.len();
    rows.map(|row| plane.place(study.map.end_m(row))).collect()
}

fn column_words(column: &MapColumn) -> String {
    match (column.is_principal(), column.is_rotational()) {
        (true, false) => format!("{} principal stiffness", column.name()),
        (true, true) => "weakest principal stiffness of rotation".to_owned(),
        (false, false) => format!("stiffness along {}", column.name()),
        (false, true) => format!("stiffness about {}", &column.name()[1..]),
    }
}

/// A file name without what file systems do not like.
fn file_name(column: &MapColumn, of: &str) -> String {
    let plain = |text: &str| -> String {
        let keep = |c: char| {
            if c.is_alphanumeric() || "-.".contains(c) {
                c
            } else {
                '_'
            }
        };
        text.chars().map(keep).collect()
    };
    format!("stiffness-{}-{}", plain(column.name()), plain(of))
}
