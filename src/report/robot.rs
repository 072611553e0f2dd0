//! A robot, its mobility and its compliance, for people and for programs.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::robot::{ChainMobility, MechanismModel, Mobility, Robot};
use crate::structure::Compliance6;

use super::text::{TextTable, significant};

/// What a robot file says, counted.
#[must_use]
pub fn robot_text(robot: &Robot) -> String {
    let mut text = format!(
        "{} bodies, {} joints, {} nodes, {} elements, {} sections, end node {}, supports {}.\n\n",
        robot.bodies.len(),
        robot.joints.len(),
        robot.nodes.len(),
        robot.members.len(),
        robot.sections.len(),
        robot.nodes[robot.end].name,
        robot
            .supports
            .iter()
            .map(|&node| robot.nodes[node].name.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    );
    let mut rows = TextTable::new(&["mechanism", "chains", "elements", "joints"]);
    for mechanism in robot.mechanisms.values() {
        rows.row([
            mechanism.name.clone(),
            mechanism.chains.join(" "),
            mechanism.members.len().to_string(),
            mechanism.joints(robot).len().to_string(),
        ]);
    }
    text.push_str(&rows.text());
    let mut rows = TextTable::new(&["variable", "smallest, deg", "largest, deg", "nominal, deg"]);
    for variable in &robot.variables {
        rows.row([
            variable.name.clone(),
            variable.min_deg.to_string(),
            variable.max_deg.to_string(),
            variable.nominal_deg.to_string(),
        ]);
    }
    let _ = write!(text, "\n{}", rows.text());
    let heads: Vec<&str> = std::iter::once("pose")
        .chain(robot.variables.iter().map(|v| v.name.as_str()))
        .collect();
    let mut rows = TextTable::new(&heads);
    for named in &robot.poses {
        rows.row(
            std::iter::once(named.id.to_string())
                .chain(named.pose.angles_deg.iter().map(f64::to_string)),
        );
    }
    let _ = write!(text, "\n{}", rows.text());
    let sets = robot.factors.keys().cloned().collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        text,
        "\nFactor sets: {}.",
        if sets.is_empty() { "none" } else { &sets }
    );
    text
}

/// The same for programs.
#[must_use]
pub fn robot_json(robot: &Robot) -> Value {
    let names = |nodes: &[usize]| {
        nodes
            .iter()
            .map(|&node| robot.nodes[node].name.to_string())
            .collect::<Vec<_>>()
    };
    let mechanisms: Vec<Value> = robot
        .mechanisms
        .values()
        .map(|mechanism| {
            json!({
                "name": mechanism.name,
                "chains": mechanism.chains,
                "elements": mechanism.members.iter().map(|&m| &robot.members[m].name).collect::<Vec<_>>(),
                "joints": mechanism.joints(robot).iter().map(|&j| &robot.joints[j].name).collect::<Vec<_>>(),
            })
        })
        .collect();
    let variables: Vec<Value> = robot
        .variables
        .iter()
        .map(|v| json!({ "name": v.name, "min_deg": v.min_deg, "max_deg": v.max_deg, "nominal_deg": v.nominal_deg }))
        .collect();
    let poses: Vec<Value> = robot
        .poses
        .iter()
        .map(|named| json!({ "name": named.id, "angles_deg": named.pose.angles_deg }))
        .collect();
    json!({
        "name": robot.name,
        "bodies": robot.bodies.len(),
        "joints": robot.joints.len(),
        "nodes": robot.nodes.len(),
        "elements": robot.members.len(),
        "end": robot.nodes[robot.end].name.to_string(),
        "supports": names(&robot.supports),
        "mechanisms": mechanisms,
        "variables": variables,
        "poses": poses,
        "factors": robot.factors,
    })
}

/// Count by formula beside count by rank.
#[must_use]
pub fn mobility_text(chains: &[ChainMobility], mechanisms: &[(String, Mobility)]) -> String {
    let mut rows = TextTable::new(&["chain", "n", "g", "mu", "nu", "lambda", "equations", "F"]);
    for chain in chains {
        rows.row([
            chain.chain.clone(),
            chain.components.to_string(),
            chain.joints.to_string(),
            chain.overconstraints.to_string(),
            chain.redundant_constraints.to_string(),
            chain.general_constraints.to_string(),
            if chain.host {
                "(2) and (3)"
            } else {
                "(4) and (5)"
            }
            .to_owned(),
            chain.freedoms.to_string(),
        ]);
    }
    let mut text = match total(chains) {
        Some(total) => format!("{}\nTotal by eq. (1): F = {total}.\n\n", rows.text()),
        None => "No body of the robot file names its `chain`, so eqs. (1) to (5) have nothing to count.\n\n".to_owned(),
    };
    let mut rows = TextTable::new(&[
        "mechanism",
        "joints",
        "loops",
        "rank of 6 x loops conditions",
        "freedoms",
    ]);
    for (name, mobility) in mechanisms {
        rows.row([
            name.clone(),
            mobility.joints.to_string(),
            mobility.loops.to_string(),
            mobility.rank.to_string(),
            mobility.freedoms.to_string(),
        ]);
    }
    text.push_str(&rows.text());
    text.push_str("\nThe second table counts nothing: it is the rank of the conditions that the loops close, in the first pose of the robot.\n");
    text
}

/// Eq. (1); `None` without chains.
fn total(chains: &[ChainMobility]) -> Option<i64> {
    (!chains.is_empty()).then(|| chains.iter().map(|chain| chain.freedoms).sum())
}

/// The same for programs.
#[must_use]
pub fn mobility_json(chains: &[ChainMobility], mechanisms: &[(String, Mobility)]) -> Value {
    json!({
        "chains": chains,
        "total": total(chains),
        "mechanisms": mechanisms.iter().map(|(name, mobility)| json!({ "mechanism": name, "rank_check": mobility })).collect::<Vec<_>>(),
    })
}

/// Rows and columns of a compliance.
const DISPLACEMENTS: [&str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];
const LOADS: [&str; 6] = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];

/// The end compliance and the stiffness along each axis.
#[must_use]
pub fn compliance_text(compliance: &Compliance6) -> String {
    let heads: Vec<&str> = std::iter::once("").chain(LOADS).collect();
    let mut rows = TextTable::new(&heads);
    for (name, row) in DISPLACEMENTS.iter().zip(&compliance.0) {
        rows.row(
            std::iter::once((*name).to_owned())
                .chain(row.iter().map(|entry| format!("{entry:.6e}"))),
        );
    }
    let stiffness = [0, 1, 2].map(|i| significant(1e-6 / compliance.direct(i), 5));
    format!(
        "{}\nSI: m/N, rad/N, m/(N*m), rad/(N*m). Stiffness along x, y, z: {} N/um.\n",
        rows.text(),
        stiffness.join(", ")
    )
}

/// The same for programs, with the nodes.
#[must_use]
pub fn compliance_json(compliance: &Compliance6, model: &MechanismModel<'_>) -> Value {
    let nodes: serde_json::Map<String, Value> = model
        .structure()
        .nodes
        .iter()
        .map(|node| (node.name.to_string(), json!(node.position_m)))
        .collect();
    json!({
        "compliance": compliance.0,
        "rows": DISPLACEMENTS,
        "columns": LOADS,
        "unit": "SI: m/N, rad/N, m/(N*m), rad/(N*m)",
        "nodes": nodes,
    })
}
