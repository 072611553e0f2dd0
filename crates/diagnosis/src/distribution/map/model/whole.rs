//! What loads need of a model beyond its stiffness: the whole compliance, the rocking base.

use crate::distribution::end_load::EndShift;
use stiffbench_beams::robot::{Keep, Pose, PoseSweep};
use stiffbench_beams::structure::Compliance6;

use super::{MapModel, NoMap, SolutionMethod};

/// Where the end is and its whole compliance, or why there is none.
type WholeCompliance = Result<([f64; 3], Compliance6), String>;

impl MapModel<'_> {
    /// The whole compliance in poses, on all cores.
    pub(in crate::distribution) fn compliances(
        &self,
        poses: &[Pose],
    ) -> Result<Vec<WholeCompliance>, NoMap> {
        let swept = self.sweep()?.run(poses, Keep::Full);
        let solved = swept.poses.iter().zip(&swept.compliances);
        let mut failed = swept.failed.iter();
        Ok(solved
            .map(|found| match found {
                (Some(pose), Some(compliance)) => {
                    Ok((pose.end_m, self.on_its_base(compliance, pose.end_m)))
                }
                _ => Err(failed
                    .next()
                    .map_or_else(String::new, |(_, error)| error.to_string())),
            })
            .collect())
    }

    /// How the end moves because the base rocks under moments, N·m, which `about` gives about a point; `None` where it stands firm.
    pub(in crate::distribution) fn rocking_under(
        &self,
        about: impl Fn([f64; 3]) -> [f64; 3],
        end_m: [f64; 3],
    ) -> Option<EndShift> {
        let support_m = self.rocks_at_m?;
        let (compliance, moment) = (self.physics.laws.base_rad_per_nm(), about(support_m));
        let rotation_rad = [0, 1, 2].map(|axis| compliance[axis] * moment[axis]);
        Some(EndShift::turned(rotation_rad, support_m, end_m))
    }

    /// The sweep over poses; laws that are not linear are refused.
    pub(in crate::distribution) fn sweep(&self) -> Result<&PoseSweep<'_>, NoMap> {
        match &self.means {
            SolutionMethod::Sweep { sweep, .. } => Ok(sweep),
            SolutionMethod::Secant { effect, .. } => Err(NoMap::LinearOnly {
                effect: effect.clone(),
            }),
        }
    }
}
