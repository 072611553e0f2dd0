//! Compliance along each base axis of sessions with several displacement gauges: the slopes that a fit takes.

use indexmap::{IndexMap, IndexSet};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mismatch::{CellSlopes, Observations};
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::readings::Reading;
use crate::reported::Reported;
use crate::statistics::{Estimate, mean, standard_deviation};
use crate::stiffness::{Branches, GaugePair, GaugeTerms, Hysteresis, HysteresisReport};
use crate::test_point::{Branch, Direction, PoseId};

use super::data::LoadedSession;

/// Components of a unit vector below this are none.
const NO_COMPONENT: f64 = 1e-9;

/// Metres per newton in a micrometre per newton.
const UM_PER_N: f64 = 1e-6;

/// Metres per newton in a millimetre per newton.
const MM_PER_N: f64 = 1e-3;

/// Compliance of one pose under a load in one direction.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct VectorStiffnessCell {
    /// The pose.
    pub pose: PoseId,
    /// Name of the direction of the load.
    pub direction: String,
    /// The direction, a unit vector along the base axes.
    pub unit_vector: [f64; 3],
    /// Number of runs.
    pub runs: usize,
    /// Number of readings.
    pub readings: usize,
    /// Displacement along the base axes per force along the load, slope over the loads.
    pub compliance: AxisValues,
    /// Stiffness along the load, the inverse of the compliance along it.
    pub stiffness: Reported,
    /// The loop between loading and unloading of the displacement along the load; not there where no load was read in both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisReport>,
    /// Largest load in size, N.
    #[serde(skip)]
    pub largest_n: f64,
    /// Displacement along the base axes at the largest load per that load from the zero of the gauges, averaged over the runs.
    #[serde(skip)]
    pub at_largest: Option<AxisValues>,
}

/// Values along the base axes.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct AxisValues {
    /// Along x.
    pub x: Reported,
    /// Along y.
    pub y: Reported,
    /// Along z.
    pub z: Reported,
}

impl AxisValues {
    /// Values in a unit, with the reason where there is none.
    fn new(values: &[Option<Estimate>; 3], si_per_unit: f64, unit: &'static str) -> Self {
        let [x, y, z] = values.map(|value| match value {
            Some(estimate) => Reported::from_estimate(&estimate, si_per_unit, unit),
            None => Reported::missing(unit, "not read along this axis"),
        });
        Self { x, y, z }
    }
}

/// The inverse of a compliance along the load.
fn stiffness_along(compliance_m_per_n: Option<Estimate>) -> Reported {
    let along = compliance_m_per_n.filter(|along| along.value != 0.0);
    let inverse = along.map(|along| Estimate {
        value: 1.0 / along.value,
        standard_uncertainty: along.standard_uncertainty / along.value.powi(2),
        dof: along.dof,
    });
    match &inverse {
        Some(inverse) => Reported::from_estimate(inverse, N_PER_UM, "N/um"),
        None => Reported::missing(
            "N/um",
            "the load has a component along an axis that was not read",
        ),
    }
}

impl LoadedSession {
    /// Compliance along each axis for every pose and direction of load, of several gauges along the base axes, in the order in which they
    /// first appear.
    ///
    /// The calibration of the gauges is not in the uncertainty.
    #[must_use]
    pub fn compliances(&self, branches: Branches) -> Vec<VectorStiffnessCell> {
        let mut found = self.compliances_of(|branch| branches.include(branch));
        let of_branches = [Branch::Loading, Branch::Unloading];
        let of_branches = of_branches.map(|own| self.compliances_of(|branch| branch == own));
        for cell in &mut found {
            let is_own = |other: &&VectorStiffnessCell| {
                (&other.pose, &other.direction) == (&cell.pose, &cell.direction)
            };
            let stiffness = of_branches.each_ref().map(|all| {
                let own = all.iter().find(is_own);
                own.map_or_else(|| stiffness_along(None), |own| own.stiffness.clone())
            });
            let loops = self.loop_along(cell);
            cell.hysteresis = loops.map(|found| HysteresisReport::new(&found, stiffness));
        }
        found
    }

    /// The loop of the displacement along a load.
    fn loop_along(&self, cell: &VectorStiffnessCell) -> Option<Hysteresis> {
        let table = &self.table;
        let is_of_cell = |load: &&[Reading]| {
            let is_one = |one: &Reading| {
                one.is_accepted() && one.force_n.is_finite() && one.displacement_m.is_finite()
            };
            load[0].pose == cell.pose
                && table.load_name(&load[0]) == cell.direction
                && load.iter().all(is_one)
        };
        let along = |load: &[Reading]| {
            let axes = Direction::ALL.into_iter().zip(cell.unit_vector);
            let axes = axes.filter(|(_, share)| share.abs() > NO_COMPONENT);
            let parts = axes.map(|(axis, share)| {
                let read = load.iter().find(|one| one.direction == axis)?;
                Some(share * read.displacement_m)
            });
            Some(Reading {
                displacement_m: parts.sum::<Option<f64>>()?,
                ..load[0].clone()
            })
        };
        let loads = table.loads().filter(is_of_cell);
        let readings: Vec<Reading> = loads.map(along).collect::<Option<_>>()?;
        let readings: Vec<&Reading> = readings.iter().collect();
        let first = readings.first()?;
        Hysteresis::of(
            &first.cell(),
            &readings,
            &self.gauges_along(cell.unit_vector),
        )
    }

    /// The force gauge, and the displacement gauge of the axis that the load has most of, as far as the session states them.
    fn gauges_along(&self, unit: [f64; 3]) -> GaugePair {
        let share = |axis: &&Direction| unit[axis.index()].abs();
        let most = Direction::ALL
            .iter()
            .max_by(|a, b| share(a).total_cmp(&share(b)));
        let instruments = self.header.as_ref().map(|header| &header.instruments);
        let of_axis = most.zip(instruments);
        let of_axis = of_axis.and_then(|(axis, own)| own.displacement_along[axis.index()].as_ref());
        let terms = |record| GaugeTerms::of(record).unwrap_or_default();
        GaugePair {
            force: terms(instruments.and_then(|own| own.force.as_ref())),
            displacement: terms(of_axis),
        }
    }

    /// The compliances of some branches, without loops.
    fn compliances_of(&self, includes: impl Fn(Branch) -> bool) -> Vec<VectorStiffnessCell> {
        let mut table = self.table.clone();
        let counts = |one: &Reading| one.is_accepted() && includes(one.branch);
        table.readings.retain(counts);
        let header = self.header.as_ref();
        let slopes = CellSlopes::new(Observations::new(&table, header));
        let procedure = header.and_then(|header| header.procedure.as_ref());
        let preload_n = procedure.and_then(|procedure| procedure.preload_n);
        let mut groups: IndexMap<(&PoseId, String), Vec<&[Reading]>> = IndexMap::new();
        for load in table.loads() {
            let cell = (&load[0].pose, table.load_name(&load[0]));
            groups.entry(cell).or_default().push(load);
        }
        let of_group = |((pose, direction), loads): ((&PoseId, String), Vec<&[Reading]>)| {
            let unit = table.load_direction(&loads[0][0]).unit_vector();
            // The cell of each gauge: its series and its place there.
            let cells = Direction::ALL.map(|axis| {
                let mut own = loads.iter().copied().flatten();
                let read = own.find(|reading| reading.direction == axis)?;
                slopes.as_ref()?.find(&table.cell(read))
            });
            let estimate = |weights: [f64; 3]| {
                let slopes = slopes.as_ref()?;
                let weighed = weights.into_iter().zip(cells);
                let weighed = weighed.filter(|(weight, _)| weight.abs() > NO_COMPONENT);
                let parts: Vec<(f64, [usize; 2])> = weighed
                    .map(|(weight, cell)| Some((weight, cell?)))
                    .collect::<Option<_>>()?;
                let series = &slopes.series[parts.first()?.1[0]];
                let value = parts
                    .iter()
                    .map(|(w, [_, at])| w * series.compliance_m_per_n[*at]);
                let variance = parts.iter().flat_map(|(a, [_, i])| {
                    let products = parts.iter();
                    products.map(move |(b, [_, j])| a * b * series.covariance[(*i, *j)])
                });
                Some(Estimate {
                    value: value.sum(),
                    standard_uncertainty: variance.sum::<f64>().sqrt(),
                    dof: slopes.dof,
                })
            };
            let along_axis = |axis: usize| {
                let mut weights = [0.0; 3];
                weights[axis] = 1.0;
                estimate(weights)
            };
            let runs: IndexSet<u32> = loads.iter().map(|load| load[0].run).collect();
            let forces = loads.iter().map(|load| load[0].force_n.abs());
            let at_largest = at_largest(&loads, preload_n.unwrap_or(0.0));
            VectorStiffnessCell {
                pose: pose.clone(),
                direction,
                unit_vector: unit,
                runs: runs.len(),
                readings: loads.len(),
                compliance: AxisValues::new(&[0, 1, 2].map(along_axis), UM_PER_N, "um/N"),
                stiffness: stiffness_along(estimate(unit)),
                hysteresis: None,
                largest_n: forces.fold(0.0, f64::max),
                at_largest: Some(AxisValues::new(&at_largest, MM_PER_N, "mm/N")),
            }
        };
        groups.into_iter().map(of_group).collect()
    }
}

/// Displacement along x, y, z at the largest load per that load, m/N, with the standard uncertainty of its scatter.
fn at_largest(loads: &[&[Reading]], preload_n: f64) -> [Option<Estimate>; 3] {
    let targets = loads.iter().map(|load| load[0].target_n);
    let largest_n = targets.fold(
        0.0,
        |most: f64, n| if n.abs() > most.abs() { n } else { most },
    );
    Direction::ALL.map(|axis| {
        let all = loads.iter().copied().flatten();
        let read = all.filter(|one| one.direction == axis && one.target_n == largest_n);
        let ratios = read.map(|one| one.displacement_m / (one.force_n - preload_n));
        let ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
        let value = mean(&ratios)?;
        Some(match standard_deviation(&ratios) {
            Some(sd) if ratios.len() > 1 => Estimate {
                value,
                standard_uncertainty: sd / (ratios.len() as f64).sqrt(),
                dof: ratios.len() as f64 - 1.0,
            },
            _ => Estimate::without_uncertainty(value),
        })
    })
}
