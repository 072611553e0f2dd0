//! Numbers of a robot file that are no error and hardly meant.

use super::Robot;
use super::model::NodePlace;

/// Young's moduli of what robots are made of: soft plastics 0.1 GPa, tungsten carbide 700 GPa.
const YOUNGS_PA: [f64; 2] = [1e8, 1e12];

/// No coordinate of a robot's node is larger, m.
const LARGEST_M: f64 = 50.0;

/// What is odd, with the number and the likely cause.
pub(super) fn oddities(robot: &Robot) -> Vec<String> {
    let mut odd = Vec::new();
    for (name, rated) in &robot.sections {
        let modulus = rated.material.youngs_modulus_pa;
        if !(YOUNGS_PA[0]..=YOUNGS_PA[1]).contains(&modulus) {
            odd.push(format!(
                "section `{name}`: E = {modulus:e} Pa, expected {:e} to {:e}: is it in MPa or GPa? (steel: E = 2.1e11)",
                YOUNGS_PA[0], YOUNGS_PA[1]
            ));
        }
    }
    let coordinates = robot.nodes.iter().filter_map(|node| match &node.place {
        NodePlace::Fixed { at_m, .. } => {
            let largest = at_m.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            Some((node, largest))
        }
        NodePlace::Loop { .. } => None,
    });
    if let Some((node, largest)) = coordinates.max_by(|a, b| a.1.total_cmp(&b.1))
        && largest > LARGEST_M
    {
        odd.push(format!(
            "node `{}` lies {largest} m from the origin of its body: are lengths in mm?",
            node.name
        ));
    }
    odd
}
