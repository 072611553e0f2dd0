//! Maps for programs.

use serde_json::{Map, Value, json};

use crate::distribution::{ColumnStudy, MapColumn, MechanismStudy, RefinedStiffness, Region};
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::report::paper::cell_json;
use crate::reported::Reported;

use super::MapReport;

/// Unit of every stiffness.
const UNIT: &str = "N/um";

impl MapReport<'_> {
    /// The JSON contract's `data` of a map.
    #[must_use]
    pub fn json(&self) -> Value {
        let set = &self.poses.set;
        let names: Vec<&str> = set
            .free
            .iter()
            .map(|&variable| self.robot.variables[variable].name.as_str())
            .collect();
        json!({
            "robot": self.robot.name,
            "factors": self.factors_name,
            "sampling": self.poses.sampling,
            "seed": self.seed,
            "poses": set.len(),
            "points": set.drawn,
            "varied": names,
            "at_load_N": self.at_load_n,
            "mechanisms": self
                .mechanisms
                .iter()
                .map(|(effects, study)| self.mechanism(effects, study))
                .collect::<Vec<_>>(),
            "paper": self.paper_cells().iter().map(cell_json).collect::<Vec<_>>(),
        })
    }

    fn mechanism(&self, effects: &[String], study: &MechanismStudy) -> Value {
        let columns = study.columns.iter();
        let failed = study.map.failed.iter().map(|(place, reason)| {
            json!({ "id": self.poses.set.ids[*place as usize], "reason": reason })
        });
        json!({
            "mechanism": study.map.mechanism,
            "physics": effects,
            "method": study.method,
            "poses": study.map.len(),
            "failed": failed.collect::<Vec<_>>(),
            "stiffness": columns.map(|found| self.column(study, found)).collect::<Vec<_>>(),
        })
    }

    fn column(&self, study: &MechanismStudy, found: &ColumnStudy) -> Value {
        let statistics = &found.statistics;
        let sampled = [statistics.smallest, statistics.largest];
        let extreme = |i: usize| {
            let row = sampled[i].row;
            let place = study.map.places[row] as usize;
            json!({
                "sampled": {
                    "value": exact(sampled[i].stiffness_n_per_m),
                    "id": self.poses.set.ids[place],
                    "end_m": study.map.end_m(row),
                    "angles_deg": self.angles(&self.poses.set.pose(place).angles_deg),
                },
                "refined": match &found.refined[i] {
                    Ok(refined) => self.refined(refined),
                    Err(reason) => json!({ "value": Reported::missing(UNIT, reason.clone()) }),
                },
            })
        };
        let quantiles = statistics.quantiles.iter().map(|quantile| {
            let value = quantile.stiffness_n_per_m / N_PER_UM;
            let reported = quantile.interval_95.map_or_else(
                || Reported::exact(value, UNIT),
                |interval| Reported::with_interval(value, interval.map(|end| end / N_PER_UM), UNIT),
            );
            json!({ "share": quantile.share, "stiffness": reported })
        });
        json!({
            "along": found.column.name(),
            "unit_vector": found.column.unit(),
            "principal": match &found.column {
                MapColumn::Principal(order) => Some(*order),
                MapColumn::Direction { .. } => None,
            },
            "smallest": extreme(0),
            "largest": extreme(1),
            "difference": exact(sampled[1].stiffness_n_per_m - sampled[0].stiffness_n_per_m),
            "mean": Reported::from_estimate(&statistics.mean, N_PER_UM, UNIT),
            "standard_deviation": statistics.standard_deviation_n_per_m.map(exact),
            "quantiles": quantiles.collect::<Vec<_>>(),
            "share_beyond_extremes_95": statistics.share_beyond_95,
            "fit_uncertainty": found.fit.map(|fit| json!({
                "smallest": Reported::from_estimate(&fit.smallest, N_PER_UM, UNIT),
                "largest": Reported::from_estimate(&fit.largest, N_PER_UM, UNIT),
                "mean": Reported::from_estimate(&fit.mean, N_PER_UM, UNIT),
            })),
            "regions": found.regions.iter().map(|region| self.region(region)).collect::<Vec<_>>(),
        })
    }

    fn angles(&self, angles_deg: &[f64]) -> Map<String, Value> {
        let variables = self.robot.variables.iter().zip(angles_deg);
        variables
            .map(|(variable, angle)| (variable.name.clone(), json!(angle)))
            .collect()
    }

    fn refined(&self, refined: &RefinedStiffness) -> Value {
        json!({
            "value": exact(refined.stiffness_n_per_m),
            "end_m": refined.end_m,
            "angles_deg": self.angles(&refined.pose.angles_deg),
            "limits": refined.limits,
            "slope_per_deg": refined.slope_per_deg,
        })
    }

    fn region(&self, region: &Region) -> Value {
        let free = self.poses.set.free.iter().zip(&region.angles_deg);
        let angles: Map<String, Value> = free
            .map(|(&variable, range)| (self.robot.variables[variable].name.clone(), json!(range)))
            .collect();
        json!({
            "level": region.level,
            "between": region.between_n_per_m.map(exact),
            "share_of_poses": region.share_of_poses,
            "share_of_area": region.share_of_area,
            "centre_zy_m": region.centre_m,
            "reach_m": region.extent_m.map(|[reach, _]| reach),
            "height_m": region.extent_m.map(|[_, height]| height),
            "angles_deg": angles,
            "holds": region.holds.iter().map(|extreme| extreme.word()).collect::<Vec<_>>(),
        })
    }
}

fn exact(n_per_m: f64) -> Reported {
    Reported::exact(n_per_m / N_PER_UM, UNIT)
}
