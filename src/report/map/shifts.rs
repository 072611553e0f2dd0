//! What a load or the own weight does to the end over the workspace.

use std::borrow::Cow;
use std::fmt::Write;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_document::{Document, Table, sign_of};

use crate::distribution::{PoseSpread, ShiftMap, largest_load};
use crate::plot::{BinValue, Figure, PlaneMap, PlaneMapFigure};
use crate::quantity::{METRES_PER_MICROMETRE, RAD_PER_MICRORADIAN};
use crate::report::axis_words::plane_letters;
use crate::report::text::significant;
use crate::reported::Reported;
use crate::robot::Masses;

use super::MapReport;
use super::figures::{DrawnMap, sheets};
use super::json::FailedPose;

/// Significant digits of printed values.
const DIGITS: usize = 4;

/// Why the end moves.
#[derive(Debug, Clone, PartialEq)]
pub enum ShiftCause {
    /// A force and a moment at the end, N and N·m, and how far it may move, m.
    Load {
        /// (Fx, Fy, Fz, Mx, My, Mz).
        load: [f64; 6],
        /// The limit, if the largest load is wanted.
        limit_m: Option<f64>,
    },
    /// Its own weight, with the masses of each mechanism and their sum, kg.
    Weight(Vec<(Masses, f64)>),
}

/// Displacements of the end of some mechanisms over the same poses.
#[derive(Debug)]
pub struct ShiftReport<'a> {
    /// The maps beside which this stands: robot, poses, names.
    pub about: &'a MapReport<'a>,
    /// Why the end moves.
    pub cause: ShiftCause,
    /// One a mechanism.
    pub maps: Vec<ShiftMap>,
}

/// Displacements of the end over the workspace, for programs.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ShiftSummary {
    /// Name of the robot.
    pub robot: String,
    /// Name of the factors.
    pub factors: String,
    /// Number of poses.
    pub poses: usize,
    /// One entry a mechanism.
    pub mechanisms: Vec<MechanismShift>,
    /// The load; absent for the own weight.
    #[serde(flatten)]
    pub load: Option<LoadAtEnd>,
}

/// A load at the end.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct LoadAtEnd {
    /// Force along x, y and z, N.
    #[serde(rename = "force_N")]
    pub force_n: [f64; 3],
    /// Moment about x, y and z, N·m.
    #[serde(rename = "moment_Nm")]
    pub moment_nm: [f64; 3],
    /// How far the end may move, mm; `null` if the largest load is not wanted.
    pub limit_mm: Option<f64>,
}

/// Displacements of the end of a mechanism.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MechanismShift {
    /// Name of the mechanism.
    pub mechanism: String,
    /// Poses that could be solved.
    pub poses: usize,
    /// The others.
    pub failed: Vec<FailedPose>,
    /// Its weight, if that is the load.
    #[serde(flatten)]
    pub weight: Option<MechanismWeight>,
    /// Statistics over the poses by quantity: `displacement`, `displacement_x`, `displacement_y`, `displacement_z`, `rotation` and, with a
    /// limit, `largest_load`.
    #[serde(flatten)]
    pub quantities: IndexMap<Cow<'static, str>, ShiftStatistics>,
}

/// The weight of a mechanism.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MechanismWeight {
    /// Its mass, kg.
    pub mass_kg: f64,
    /// Sections whose mass is not known.
    pub sections_without_mass: Vec<String>,
}

/// A quantity over the poses.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ShiftStatistics {
    /// Some poses have it.
    Found {
        /// Unit of the values.
        unit: Cow<'static, str>,
        /// The least.
        least: f64,
        /// The greatest.
        greatest: f64,
        /// The mean.
        mean: f64,
        /// Quantiles by their share.
        quantiles: IndexMap<Cow<'static, str>, f64>,
        /// The pose that a user should look at.
        worst: WorstPose,
    },
    /// No pose has it.
    Missing(Reported),
}

/// A pose with its end.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct WorstPose {
    /// Number of the point.
    pub id: u64,
    /// Position of the end, m.
    pub end_m: [f64; 3],
    /// The pose, degrees.
    pub angles_deg: Vec<f64>,
}

/// A quantity of every pose.
struct Quantity {
    key: &'static str,
    words: &'static str,
    unit: &'static str,
    /// Whether small values are the ones to look at.
    worst_is_least: bool,
    values: Vec<f64>,
}

impl ShiftReport<'_> {
    /// Tables for people.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::of(self.cause_words());
        document.paragraph(self.about.about());
        for (index, map) in self.maps.iter().enumerate() {
            let mass = self.mass_words(index);
            document.paragraph(format!("mechanism {}{mass}", map.mechanism));
            self.add_table(&mut document, map);
            if let Some((_, reason)) = map.failed.first() {
                let count = map.failed.len();
                document.paragraph(format!(
                    "{count} of the poses have no answer, for example: {reason}"
                ));
            }
        }
        document
    }

    fn add_table(&self, document: &mut Document, map: &ShiftMap) {
        let plane = &self.about.poses.plane;
        let [first, second] = plane_letters(plane);
        let (first, second) = (format!("worst at {first}, m"), format!("{second}, m"));
        let rows = self.quantities(map).into_iter().filter_map(|quantity| {
            let spread = PoseSpread::of(&quantity.values)?;
            let row = worst(&quantity, &spread);
            Some((quantity, spread, row))
        });
        let digits = |value: f64| significant(value, DIGITS);
        let place = |row: usize, axis: usize| format!("{:.3}", plane.place(map.ends_m[row])[axis]);
        document.table(
            Table::of(rows)
                .words("quantity", |(one, ..)| {
                    format!("{}, {}", one.words, sign_of(one.unit))
                })
                .numbers("least", |(_, spread, _)| digits(spread.least.0))
                .numbers("5 %", |(_, spread, _)| digits(spread.quantiles[0]))
                .numbers("median", |(_, spread, _)| digits(spread.quantiles[1]))
                .numbers("mean", |(_, spread, _)| digits(spread.mean))
                .numbers("95 %", |(_, spread, _)| digits(spread.quantiles[2]))
                .numbers("greatest", |(_, spread, _)| digits(spread.greatest.0))
                .numbers(&first, |(.., row)| place(*row, 0))
                .numbers(&second, |(.., row)| place(*row, 1))
                .numbers("angles, deg", |(.., row)| self.angles(map, *row)),
        );
    }

    /// Why the end moves, in a sentence.
    fn cause_words(&self) -> String {
        match &self.cause {
            ShiftCause::Load { load, limit_m } => {
                let [fx, fy, fz, mx, my, mz] = load;
                let limit = limit_m.map_or_else(String::new, |limit| {
                    format!(
                        "; largest load along it: the end moves by {} mm",
                        limit * 1e3
                    )
                });
                format!(
                    "Displacement and rotation of the end under F = ({fx}, {fy}, {fz}) N, M = ({mx}, {my}, {mz}) N·m{limit}."
                )
            }
            ShiftCause::Weight(_) => {
                "Sag of the end under the robot's own weight, from the shape without gravity."
                    .to_owned()
            }
        }
    }

    fn mass_words(&self, index: usize) -> String {
        let ShiftCause::Weight(masses) = &self.cause else {
            return String::new();
        };
        let Some((masses, sum_kg)) = masses.get(index) else {
            return String::new();
        };
        let mut words = format!(": {} kg", significant(*sum_kg, DIGITS));
        if !masses.unweighed.is_empty() {
            let _ = write!(
                words,
                ", without sections that have no mass: {}",
                masses.unweighed.join(", ")
            );
        }
        words
    }

    fn quantities(&self, map: &ShiftMap) -> Vec<Quantity> {
        let of = |key, words, unit, value: &dyn Fn(usize) -> f64| Quantity {
            key,
            words,
            unit,
            worst_is_least: false,
            values: (0..map.shifts.len()).map(value).collect(),
        };
        let shift = |row: usize| &map.shifts[row];
        let along =
            |axis: usize| move |row: usize| shift(row).displacement_m[axis] / METRES_PER_MICROMETRE;
        let mut all = vec![
            of("displacement", "displacement", "um", &|row| {
                shift(row).distance_m() / METRES_PER_MICROMETRE
            }),
            of("displacement_x", "  along x", "um", &along(0)),
            of("displacement_y", "  along y", "um", &along(1)),
            of("displacement_z", "  along z", "um", &along(2)),
            of("rotation", "rotation", "urad", &|row| {
                shift(row).angle_rad() / RAD_PER_MICRORADIAN
            }),
        ];
        if let ShiftCause::Load {
            load,
            limit_m: Some(limit_m),
        } = self.cause
        {
            let unit = if load[..3] == [0.0; 3] { "N*m" } else { "N" };
            let largest = |row: usize| largest_load(shift(row), load, limit_m).unwrap_or(f64::NAN);
            let mut quantity = of("largest_load", "largest load", unit, &largest);
            quantity.worst_is_least = true;
            all.push(quantity);
        }
        all
    }

    fn angles(&self, map: &ShiftMap, row: usize) -> String {
        let set = &self.about.poses.set;
        let free = set.free_angles_deg(map.places[row] as usize).iter();
        free.map(|angle| format!("{angle:.1}"))
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// The displacements for programs.
    #[must_use]
    pub fn summary(&self) -> ShiftSummary {
        let maps = self.maps.iter().enumerate();
        ShiftSummary {
            robot: self.about.robot.name.clone(),
            factors: self.about.factors_name.clone(),
            poses: self.about.poses.set.len(),
            mechanisms: maps
                .map(|(index, map)| self.mechanism(index, map))
                .collect(),
            load: match self.cause {
                ShiftCause::Load { load, limit_m } => {
                    let [fx, fy, fz, mx, my, mz] = load;
                    Some(LoadAtEnd {
                        force_n: [fx, fy, fz],
                        moment_nm: [mx, my, mz],
                        limit_mm: limit_m.map(|limit| limit * 1e3),
                    })
                }
                ShiftCause::Weight(_) => None,
            },
        }
    }

    fn mechanism(&self, index: usize, map: &ShiftMap) -> MechanismShift {
        let weight = match &self.cause {
            ShiftCause::Weight(masses) => masses.get(index),
            ShiftCause::Load { .. } => None,
        };
        let quantities = self.quantities(map).into_iter();
        MechanismShift {
            mechanism: map.mechanism.clone(),
            poses: map.shifts.len(),
            failed: self.about.failed(&map.failed),
            weight: weight.map(|(masses, sum_kg)| MechanismWeight {
                mass_kg: *sum_kg,
                sections_without_mass: masses.unweighed.clone(),
            }),
            quantities: quantities
                .map(|quantity| (quantity.key.into(), self.shift_statistics(map, &quantity)))
                .collect(),
        }
    }

    fn shift_statistics(&self, map: &ShiftMap, quantity: &Quantity) -> ShiftStatistics {
        let Some(spread) = PoseSpread::of(&quantity.values) else {
            return ShiftStatistics::Missing(Reported::missing(quantity.unit, "no pose has it"));
        };
        let row = worst(quantity, &spread);
        let place = map.places[row] as usize;
        let shares = ["0.05", "0.5", "0.95"].map(Cow::from);
        ShiftStatistics::Found {
            unit: quantity.unit.into(),
            least: spread.least.0,
            greatest: spread.greatest.0,
            mean: spread.mean,
            quantiles: shares.into_iter().zip(spread.quantiles).collect(),
            worst: WorstPose {
                id: self.about.poses.set.ids[place],
                end_m: map.ends_m[row],
                angles_deg: self.about.poses.set.pose(place).angles_deg.clone(),
            },
        }
    }

    /// Displacement over the workspace, of each mechanism and of all with one scale, by file name.
    #[must_use]
    pub fn figures(&self) -> Vec<(String, Figure)> {
        let (key, words) = match self.cause {
            ShiftCause::Load { .. } => ("load", "displacement under the load"),
            ShiftCause::Weight(_) => ("sag", "sag under its own weight"),
        };
        let all = PlaneMapFigure {
            title: format!("{}: {words}", self.about.robot.name),
            quantity: "displacement of the end".to_owned(),
            unit: "µm".to_owned(),
            about: format!("{} {}", self.cause_words(), self.about.about()),
            maps: self.plane_maps(),
            range: None,
        };
        let mechanisms = self.maps.iter().map(|map| map.mechanism.as_str());
        let mechanisms: Vec<&str> = mechanisms.collect();
        sheets(&all, &mechanisms, |name| format!("{key}-{name}"))
    }

    /// What a square shows of its poses: by default that which moves most, where a place has many postures.
    fn bin_value(&self) -> BinValue {
        match self.about.bin_value() {
            BinValue::Least if self.about.cell.is_none() => BinValue::Greatest,
            value => value,
        }
    }

    fn plane_maps(&self) -> Vec<PlaneMap> {
        let plane = &self.about.poses.plane;
        let maps = self.maps.iter().map(|map| {
            let shifts = map.shifts.iter();
            let values = shifts.map(|shift| shift.distance_m() / METRES_PER_MICROMETRE);
            let values: Vec<f64> = values.collect();
            let spread = PoseSpread::of(&values);
            DrawnMap {
                mechanism: &map.mechanism,
                points: map.ends_m.iter().map(|end| plane.place(*end)).collect(),
                least: spread.map(|spread| spread.least.1),
                greatest: spread.map(|spread| spread.greatest.1),
                values,
            }
        });
        self.about
            .drawn(&maps.collect::<Vec<_>>(), self.bin_value())
    }
}

/// The row that a user should look at.
fn worst(quantity: &Quantity, spread: &PoseSpread) -> usize {
    let is_negative = spread.least.0.abs() > spread.greatest.0.abs();
    if quantity.worst_is_least || is_negative {
        spread.least.1
    } else {
        spread.greatest.1
    }
}
