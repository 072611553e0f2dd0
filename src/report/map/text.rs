//! Maps for people.

use indexmap::IndexSet;
use stiffbench_document::{Document, Table, sign_of};

use crate::distribution::{ColumnStudy, Extreme, Level, MapColumn, MechanismStudy};
use crate::report::axis_words::{plane_column_heads, plane_letters};
use crate::report::text::{or_dash, significant};
use crate::statistics::Estimate;

use super::paper;
use super::{MapReport, unit_of};

/// Share of a stiffness up to which its differences are those of rounding.
const SAME: f64 = 1e-9;

impl MapReport<'_> {
    /// Where each mechanism is softest, statistics, where the extremes and regions lie, and the paper's tables.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::of(format!(
            "{}, factors {}",
            self.robot.name, self.factors_name
        ));
        self.add_softest(&mut document);
        document.paragraph(format!("{}.", self.sampling_words()));
        let columns = self.mechanisms.iter();
        let columns = columns.map(|(_, study)| study.map.columns.len());
        for column in 0..columns.max().unwrap_or_default() {
            let Some(name) = self.column_name(column) else {
                continue;
            };
            document.paragraph(format!("Stiffness {name}"));
            document.table(statistics_table("mechanism", self.found(column), true));
            self.add_fits(&mut document, column);
        }
        self.add_rigid(&mut document);
        if self.directions().next().is_some() {
            self.add_extremes(&mut document);
            self.add_regions(&mut document);
        }
        paper::add_tables(&mut document, &self.paper_cells());
        self.add_methods(&mut document);
        document.append(self.notes());
        document
    }

    /// The softest direction of each mechanism, and where it is that.
    fn add_softest(&self, document: &mut Document) {
        let [first, second] = plane_letters(&self.poses.plane);
        for (_, study) in &self.mechanisms {
            let directions = study.columns.iter().map(|found| {
                let sampled = found.statistics.smallest.stiffness_n_per_m;
                let refined = found.refined[0].as_ref().ok();
                let least = refined.map_or(sampled, |to| to.stiffness_n_per_m.min(sampled));
                (&found.column, least, refined)
            });
            let along = directions.filter(|(of, ..)| !of.is_principal() && !of.is_rotational());
            let Some((column, least, refined)) = along.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                continue;
            };
            let place = refined.map_or_else(String::new, |refined| {
                let [across, upward] = self.poses.plane.place(refined.end_m);
                format!(" at {first} {across:.3} m, {second} {upward:.3} m")
            });
            document.item(format!(
                "Mechanism {} is softest {}: {} N/µm{place}",
                study.map.mechanism,
                direction_words(column),
                stiffness(column, least),
            ));
        }
    }

    fn column_name(&self, column: usize) -> Option<String> {
        let mut studies = self.mechanisms.iter();
        let study = studies.find_map(|(_, study)| study.found(column))?;
        let (unit, _) = unit_of(&study.column);
        Some(format!(
            "{}, {}",
            direction_words(&study.column),
            sign_of(unit)
        ))
    }

    fn add_methods(&self, document: &mut Document) {
        document.paragraph("How the poses are solved:");
        for (effects, study) in &self.mechanisms {
            let (map, method) = (&study.map, study.method.join("; "));
            // Their words are those of the machine: a line holds all of them.
            document.lines(format!("  mechanism {}: {method}", map.mechanism));
            for effect in effects {
                document.lines(format!("    with {effect}"));
            }
            if let Some((_, reason)) = map.failed.first() {
                document.lines(format!(
                    "    {} of the poses cannot be reached, for example: {reason}",
                    map.failed.len()
                ));
            }
        }
    }

    /// What was found of a column, with the name of the mechanism.
    fn found(&self, column: usize) -> impl Iterator<Item = (&str, &ColumnStudy)> {
        self.mechanisms
            .iter()
            .filter_map(move |(_, study)| Some((&study.map.mechanism[..], study.found(column)?)))
    }

    /// What does not yield.
    fn add_rigid(&self, document: &mut Document) {
        for (_, study) in &self.mechanisms {
            let name = &study.map.mechanism;
            let rigid: Vec<String> = study.rigid().map(direction_words).collect();
            if !rigid.is_empty() {
                document.paragraph(format!(
                    "Mechanism {name} is rigid {}: nothing yields there in any pose.",
                    rigid.join(", ")
                ));
            }
            for found in study.columns.iter().filter(|c| c.statistics.rigid > 0) {
                document.paragraph(format!(
                    "Mechanism {name} is rigid {} in {} of {} poses; the numbers are for the other poses.",
                    direction_words(&found.column),
                    found.statistics.rigid,
                    study.map.len()
                ));
            }
        }
    }

    /// What the uncertainty of the fit does to a column, if it was carried.
    fn add_fits(&self, document: &mut Document, column: usize) {
        let found = self.found(column);
        let found = found.filter_map(|(name, one)| Some((name, &one.column, one.fit.as_ref()?)));
        let found: Vec<_> = found.collect();
        if found.is_empty() {
            return;
        }
        document.table(
            Table::of(found)
                .words("by the fit", |(name, ..)| *name)
                .numbers_each(["smallest", "U, k"], |(_, of, fit)| {
                    with_u(of, &fit.smallest)
                })
                .numbers_each(["largest", "U, k"], |(_, of, fit)| with_u(of, &fit.largest))
                .numbers_each(["mean", "U, k"], |(_, of, fit)| with_u(of, &fit.mean)),
        );
    }

    fn add_extremes(&self, document: &mut Document) {
        let [first, second] = plane_column_heads(&self.poses.plane);
        let heads = [format!("{first}, m"), format!("{second}, m")];
        let free = &self.poses.set.free;
        let variables = free.iter();
        let variables = variables.map(|&variable| &self.robot.variables[variable].name);
        let rows = self.directions().flat_map(|(study, found)| {
            let ends = ["smallest", "largest"].into_iter().zip(&found.refined);
            ends.map(move |(word, refined)| (study, found, word, refined.as_ref()))
        });
        document.paragraph("Where the extremes lie, refined to the limits");
        document.table(
            Table::of(rows)
                .words("extreme", |(study, found, word, _)| {
                    format!("{} {} {word}", study.map.mechanism, found.column.name())
                })
                .numbers(self.units(), |(_, found, _, refined)| {
                    let known = refined.map(|to| stiffness(&found.column, to.stiffness_n_per_m));
                    known.unwrap_or_default()
                })
                .numbers_each(heads, |(.., refined)| {
                    let place = refined.map(|to| self.poses.plane.place(to.end_m));
                    let known = place.map(|place| place.map(|m| format!("{m:.4}")));
                    known.unwrap_or_default()
                })
                .numbers_each(variables, |(.., refined)| {
                    let angle = |&variable: &usize| {
                        let known = refined.map(|to| to.pose.angles_deg[variable]);
                        known.map_or_else(|_| String::new(), |angle| format!("{angle:.3}"))
                    };
                    free.iter().map(angle).collect::<Vec<_>>()
                })
                .words("held by", |(.., refined)| {
                    refined.map_or_else(Clone::clone, |to| to.limits.join(", "))
                }),
        );
    }

    /// The studied directions, mechanism by mechanism; principal stiffnesses have their regions in the JSON only.
    fn directions(&self) -> impl Iterator<Item = (&MechanismStudy, &ColumnStudy)> {
        self.mechanisms.iter().flat_map(|(_, study)| {
            let directions = study.columns.iter();
            directions
                .filter(|found| !found.column.is_principal())
                .map(move |found| (study, found))
        })
    }

    /// The units of the directions in one table.
    fn units(&self) -> String {
        let units = self.directions();
        let units = units.map(|(_, found)| sign_of(unit_of(&found.column).0));
        let units: IndexSet<String> = units.collect();
        units.into_iter().collect::<Vec<_>>().join(" or ")
    }

    /// Names of outermost points.
    pub(super) fn words_of(&self, extremes: &[Extreme]) -> Vec<String> {
        let words = extremes.iter();
        words
            .map(|extreme| self.poses.plane.word(*extreme))
            .collect()
    }

    fn add_regions(&self, document: &mut Document) {
        let [first, second] = plane_column_heads(&self.poses.plane);
        let (first, second) = (format!("{first}, m"), format!("{second}, m"));
        let centre = format!("centre {}, m", plane_letters(&self.poses.plane).join(", "));
        let unit = self.units();
        let level = |level: Level| match level {
            Level::Low => "low",
            Level::Medium => "medium",
            Level::High => "high",
        };
        let range = |[low, high]: [f64; 2]| format!("{low:.3} to {high:.3}");
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let (same, divided): (Vec<_>, Vec<_>) = self.directions().partition(|(_, found)| {
            let [least, most] = [&found.statistics.smallest, &found.statistics.largest];
            most.stiffness_n_per_m <= (1.0 + SAME) * least.stiffness_n_per_m
        });
        for (study, found) in same {
            document.paragraph(format!(
                "The stiffness of mechanism {} {} is the same in every pose: it has no regions.",
                study.map.mechanism,
                direction_words(&found.column)
            ));
        }
        if divided.is_empty() {
            return;
        }
        let rows = divided.into_iter().flat_map(|(study, found)| {
            let regions = found.regions.iter();
            regions.map(move |region| (&study.map.mechanism, &found.column, region))
        });
        document.paragraph("Where stiffness is low, medium and high (thirds of the range between the extremes, or of the poses where the range spans a decade or leaves a third empty)");
        document.table(
            Table::of(rows)
                .words("region", |(mechanism, of, one)| {
                    format!("{mechanism} {} {}", of.name(), level(one.level))
                })
                .numbers(&unit, |(_, of, one)| {
                    one.between_n_per_m.map(|k| stiffness(of, k)).join(" to ")
                })
                .numbers("poses", |(.., one)| percent(one.share_of_poses))
                .numbers("area", |(.., one)| or_dash(one.share_of_area, percent))
                .numbers(&first, |(.., one)| {
                    or_dash(one.extent_m, |[reach, _]| range(reach))
                })
                .numbers(&second, |(.., one)| {
                    or_dash(one.extent_m, |[_, height]| range(height))
                })
                .numbers(&centre, |(.., one)| {
                    or_dash(one.centre_m, |[z, y]| format!("{z:.3}, {y:.3}"))
                })
                .words("outermost points in it", |(.., one)| {
                    self.words_of(&one.holds).join(", ")
                }),
        );
    }

    /// What the columns of the tables mean, with the coverage that is claimed.
    fn notes(&self) -> Document {
        let mut document = Document::new();
        let studies = || self.mechanisms.iter().map(|(_, study)| study);
        if let Some(found) = studies().flat_map(|study| &study.columns).next() {
            let sampling = match found.statistics.share_beyond_95 {
                Some(share) => format!(
                    "The interval of the mean is its sampling uncertainty; beyond each sampled extreme lies at most {} % of the workspace, with 95 % confidence.",
                    significant(100.0 * share, 2)
                ),
                None => "A grid has no sampling uncertainty.".to_owned(),
            };
            document.paragraph(format!("U is the expanded uncertainty for 95 %, k its coverage factor (Student's t). {sampling}"));
        } else if studies().all(|study| study.map.is_empty()) {
            document.paragraph("No pose can be reached: there is no result.");
        }
        document
    }
}

/// Head of the columns of extremes that were followed.
const REFINED: &str = "refined";

/// Statistics of columns, each under a name.
///
/// # Arguments
/// - `names`: what the names are.
/// - `refined`: whether the table has the extremes that were followed from those of the sample.
pub(in crate::report) fn statistics_table<'s>(
    names: &str,
    rows: impl Iterator<Item = (&'s str, &'s ColumnStudy)>,
    refined: bool,
) -> Table {
    let ends = |one: &ColumnStudy| {
        let ends = [one.statistics.smallest, one.statistics.largest];
        ends.map(|end| end.stiffness_n_per_m)
    };
    let end = |one: &ColumnStudy, place: usize| stiffness(&one.column, ends(one)[place]);
    let followed = |one: &ColumnStudy, place: usize| {
        let found = one.refined[place].as_ref().ok();
        or_dash(found, |to| stiffness(&one.column, to.stiffness_n_per_m))
    };
    let difference = |one: &ColumnStudy| ends(one)[1] - ends(one)[0];
    let quantile = |one: &ColumnStudy, share: f64| {
        let mut quantiles = one.statistics.quantiles.iter();
        let found = quantiles.find(|quantile| quantile.share == share);
        found.map_or_else(String::new, |q| stiffness(&one.column, q.stiffness_n_per_m))
    };
    let table = Table::of(rows)
        .words(names, |(name, _)| *name)
        .numbers("smallest", |(_, one)| end(one, 0))
        .when(refined, |table| {
            table.numbers(REFINED, |(_, one)| followed(one, 0))
        })
        .numbers("largest", |(_, one)| end(one, 1))
        .when(refined, |table| {
            table.numbers(REFINED, |(_, one)| followed(one, 1))
        })
        .numbers("difference", |(_, one)| {
            stiffness(&one.column, difference(one))
        })
        .numbers("mean", |(_, one)| {
            stiffness(&one.column, one.statistics.mean.value)
        })
        .numbers("U of the sampling, k", |(_, one)| {
            expanded(&one.column, &one.statistics.mean)
        })
        .numbers("5 %", |(_, one)| quantile(one, 0.05))
        .numbers("median", |(_, one)| quantile(one, 0.5))
        .numbers("95 %", |(_, one)| quantile(one, 0.95));
    table.into()
}

/// The direction of a column in words.
fn direction_words(column: &MapColumn) -> String {
    let name = column.name();
    match (column.is_principal(), column.is_rotational()) {
        (false, false) => format!("along {name}"),
        (true, false) => format!("along the {name} of its principal directions"),
        (false, true) => format!("about {}", &name[1..]),
        (true, true) => format!("about its principal axes, {name}"),
    }
}

/// A stiffness in the unit of its column.
fn stiffness(column: &MapColumn, si: f64) -> String {
    significant(si / unit_of(column).1, 4)
}

/// A stiffness, and its expanded uncertainty with the coverage factor.
fn with_u(column: &MapColumn, estimate: &Estimate) -> [String; 2] {
    [
        stiffness(column, estimate.value),
        expanded(column, estimate),
    ]
}

/// Expanded uncertainty in the unit of its column, with its coverage factor.
fn expanded(column: &MapColumn, estimate: &Estimate) -> String {
    let both = estimate.expanded_95().zip(estimate.coverage_factor_95());
    or_dash(both, |(u, k)| {
        format!("{}, {k:.2}", significant(u / unit_of(column).1, 2))
    })
}
