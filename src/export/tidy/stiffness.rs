//! Results as tidy tables, which hold the same numbers as JSON.

use serde_json::{Value, json};

use crate::analysis::VectorStiffnessCell;
use crate::stiffness::{
    BudgetRowReport, FlagReport, HysteresisReport, LoadMeanReport, LoopWidthReport,
    StiffnessCellReport, StiffnessReport,
};
use crate::test_point::PoseId;

use super::table::FieldKind::{self, Integer, Number, Text};
use super::table::{TidyColumn, TidyTable};

/// A column: name, kind, unit, meaning, and its value as JSON has it, of a row in a cell.
type ColumnPlan<C, R> = (
    &'static str,
    FieldKind,
    &'static str,
    &'static str,
    fn(&C, &R) -> Value,
);

const fn pose<R>() -> ColumnPlan<StiffnessCellReport, R> {
    let meaning = "Pose of the robot";
    ("pose", Text, "", meaning, |cell, _| json!(cell.pose))
}

const fn direction<R>() -> ColumnPlan<StiffnessCellReport, R> {
    let meaning = "Direction of the load";
    ("direction", Text, "", meaning, |cell, _| {
        json!(cell.direction)
    })
}

#[rustfmt::skip]
const STIFFNESS: &[ColumnPlan<StiffnessCellReport, StiffnessCellReport>] = &[
    pose(),
    direction(),
    ("runs", Integer, "", "Number of runs", |cell, _| json!(cell.n_runs)),
    ("zeros", Integer, "", "Number of gauge zeros", |cell, _| json!(cell.n_zeros)),
    ("stiffness_N_per_um", Number, "N/um", "Stiffness by regression: inverse slope with a free intercept for each zero", |cell, _| json!(cell.stiffness_regression.value)),
    ("u_N_per_um", Number, "N/um", "Standard uncertainty of the stiffness by regression", |cell, _| json!(cell.stiffness_regression.standard_uncertainty)),
    ("expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the stiffness by regression, 95 %", |cell, _| json!(cell.stiffness_regression.expanded_uncertainty)),
    ("coverage_factor", Number, "", "Coverage factor k of the expanded uncertainty", |cell, _| json!(cell.stiffness_regression.k)),
    ("degrees_of_freedom", Number, "", "Effective degrees of freedom; empty: infinite or not known", |cell, _| json!(cell.stiffness_regression.dof)),
    ("type_a_N_per_um", Number, "N/um", "Type A part of the standard uncertainty", |cell, _| json!(cell.uncertainty_regression.as_ref().map(|one| one.type_a))),
    ("type_b_N_per_um", Number, "N/um", "Type B part of the standard uncertainty", |cell, _| json!(cell.uncertainty_regression.as_ref().map(|one| one.type_b))),
    ("mean_ratio_N_per_um", Number, "N/um", "Stiffness as the mean of force over displacement", |cell, _| json!(cell.stiffness_paper.value)),
    ("mean_ratio_u_N_per_um", Number, "N/um", "Standard uncertainty of the mean of force over displacement", |cell, _| json!(cell.stiffness_paper.standard_uncertainty)),
    ("mean_ratio_expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the mean of force over displacement, 95 %", |cell, _| json!(cell.stiffness_paper.expanded_uncertainty)),
    ("compliance_um_per_N", Number, "um/N", "Slope of displacement over force", |cell, _| json!(cell.compliance.value)),
    ("zero_offset_um", Number, "um", "Displacement of the line at zero force", |cell, _| json!(cell.zero_offset_um)),
    ("reason", Text, "", "Why a value or its uncertainty is missing", |cell, _| json!(cell.stiffness_regression.reason)),
];

#[rustfmt::skip]
const BUDGET: &[ColumnPlan<StiffnessCellReport, BudgetRowReport>] = &[
    pose(),
    direction(),
    ("source", Text, "", "Source of uncertainty", |_, row| json!(row.source)),
    ("evaluation", Text, "", "Type A or B evaluation (GUM)", |_, row| json!(row.evaluation)),
    ("distribution", Text, "", "Assumed distribution", |_, row| json!(row.distribution)),
    ("standing", Text, "", "Whether the row counts in the sum, and why not", |_, row| json!(row.standing)),
    ("standard_uncertainty", Number, "", "Standard uncertainty, in the unit of the next column", |_, row| json!(row.standard_uncertainty)),
    ("unit", Text, "", "Unit of the standard uncertainty", |_, row| json!(row.unit)),
    ("sensitivity", Number, "", "Sensitivity of the stiffness, in the unit of the next column", |_, row| json!(row.sensitivity)),
    ("sensitivity_unit", Text, "", "Unit of the sensitivity", |_, row| json!(row.sensitivity_unit)),
    ("contribution_N_per_um", Number, "N/um", "Contribution to the standard uncertainty of the stiffness", |_, row| json!(row.contribution)),
    ("degrees_of_freedom", Number, "", "Degrees of freedom; empty: infinite", |_, row| json!(row.dof)),
    ("share_percent", Number, "%", "Share of the variance", |_, row| json!(row.share_percent)),
    ("note", Text, "", "Note", |_, row| json!(row.note)),
];

#[rustfmt::skip]
const LOADS: &[ColumnPlan<StiffnessCellReport, LoadMeanReport>] = &[
    pose(),
    direction(),
    ("branch", Text, "", "Loading or unloading", |_, load| json!(load.branch)),
    ("target_N", Number, "N", "Target force", |_, load| json!(load.target_n)),
    ("readings", Integer, "", "Number of readings", |_, load| json!(load.n)),
    ("mean_force_N", Number, "N", "Mean of the force", |_, load| json!(load.mean_force_n)),
    ("sd_force_N", Number, "N", "Standard deviation of the force", |_, load| json!(load.sd_force_n)),
    ("mean_displacement_um", Number, "um", "Mean of the displacement", |_, load| json!(load.mean_um)),
    ("sd_displacement_um", Number, "um", "Standard deviation of the displacement", |_, load| json!(load.sd_um)),
];

#[rustfmt::skip]
const FLAGS: &[ColumnPlan<StiffnessCellReport, FlagReport>] = &[
    pose(),
    direction(),
    ("rule", Text, "", "Rule that the readings break", |_, flag| json!(flag.rule)),
    ("message", Text, "", "What was found", |_, flag| json!(flag.message)),
    ("statistic", Number, "", "Test statistic", |_, flag| json!(flag.statistic)),
    ("limit", Number, "", "Critical value", |_, flag| json!(flag.limit)),
    ("seq", Integer, "", "Sequence number of the reading concerned", |_, flag| json!(flag.seq)),
];

#[rustfmt::skip]
const VECTOR_STIFFNESS: &[ColumnPlan<VectorStiffnessCell, VectorStiffnessCell>] = &[
    ("pose", Text, "", "Pose of the robot", |cell, _| json!(cell.pose)),
    ("direction", Text, "", "Direction of the load", |cell, _| json!(cell.direction)),
    ("runs", Integer, "", "Number of runs", |cell, _| json!(cell.runs)),
    ("readings", Integer, "", "Number of readings", |cell, _| json!(cell.readings)),
    ("compliance_x_um_per_N", Number, "um/N", "Displacement along x per force along the load", |cell, _| json!(cell.compliance.x.value)),
    ("compliance_x_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_x_um_per_N", |cell, _| json!(cell.compliance.x.standard_uncertainty)),
    ("compliance_y_um_per_N", Number, "um/N", "Displacement along y per force along the load", |cell, _| json!(cell.compliance.y.value)),
    ("compliance_y_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_y_um_per_N", |cell, _| json!(cell.compliance.y.standard_uncertainty)),
    ("compliance_z_um_per_N", Number, "um/N", "Displacement along z per force along the load", |cell, _| json!(cell.compliance.z.value)),
    ("compliance_z_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_z_um_per_N", |cell, _| json!(cell.compliance.z.standard_uncertainty)),
    ("stiffness_N_per_um", Number, "N/um", "Stiffness along the load", |cell, _| json!(cell.stiffness.value)),
    ("u_N_per_um", Number, "N/um", "Standard uncertainty of the stiffness", |cell, _| json!(cell.stiffness.standard_uncertainty)),
    ("expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the stiffness, 95 %", |cell, _| json!(cell.stiffness.expanded_uncertainty)),
    ("reason", Text, "", "Why a value or its uncertainty is missing", |cell, _| json!(cell.stiffness.reason)),
];

/// The loop of a pose and direction with their names.
struct NamedLoop {
    pose: PoseId,
    direction: String,
    found: HysteresisReport,
}

impl NamedLoop {
    /// `None` of a cell without a loop.
    fn new(
        pose: &PoseId,
        direction: &impl ToString,
        found: Option<&HysteresisReport>,
    ) -> Option<Self> {
        Some(Self {
            pose: pose.clone(),
            direction: direction.to_string(),
            found: found?.clone(),
        })
    }
}

#[rustfmt::skip]
const HYSTERESIS: &[ColumnPlan<NamedLoop, NamedLoop>] = &[
    ("pose", Text, "", "Pose of the robot", |cell, _| json!(cell.pose)),
    ("direction", Text, "", "Direction of the load", |cell, _| json!(cell.direction)),
    ("loops", Integer, "", "Number of loops", |cell, _| json!(cell.found.n_loops)),
    ("largest_width_um", Number, "um", "Largest width: displacement while unloading less that while loading at the same measured force, positive where it lags behind", |cell, _| json!(cell.found.largest.width.value)),
    ("largest_width_lower_um", Number, "um", "Lower end of its 95 % interval, which holds over all loads at once", |cell, _| json!(cell.found.largest.width.ci95.map(|ends| ends[0]))),
    ("largest_width_upper_um", Number, "um", "Upper end of its 95 % interval", |cell, _| json!(cell.found.largest.width.ci95.map(|ends| ends[1]))),
    ("largest_width_at_N", Number, "N", "Target force at which the width is largest", |cell, _| json!(cell.found.largest.target_n)),
    ("residual_um", Number, "um", "Displacement that remains without load", |cell, _| json!(cell.found.residual_displacement.value)),
    ("residual_expanded_U_um", Number, "um", "Expanded uncertainty of residual_um, 95 %", |cell, _| json!(cell.found.residual_displacement.expanded_uncertainty)),
    ("lost_motion_um", Number, "um", "Distance of the middle of both branches between +3 and -3 % of the largest load", |cell, _| json!(cell.found.lost_motion.value)),
    ("lost_motion_expanded_U_um", Number, "um", "Expanded uncertainty of lost_motion_um, 95 %", |cell, _| json!(cell.found.lost_motion.expanded_uncertainty)),
    ("stiffness_loading_N_per_um", Number, "N/um", "Inverse slope while loading", |cell, _| json!(cell.found.stiffness_loading.value)),
    ("stiffness_loading_expanded_U_N_per_um", Number, "N/um", "Its expanded uncertainty, 95 %", |cell, _| json!(cell.found.stiffness_loading.expanded_uncertainty)),
    ("stiffness_unloading_N_per_um", Number, "N/um", "Inverse slope while unloading", |cell, _| json!(cell.found.stiffness_unloading.value)),
    ("stiffness_unloading_expanded_U_N_per_um", Number, "N/um", "Its expanded uncertainty, 95 %", |cell, _| json!(cell.found.stiffness_unloading.expanded_uncertainty)),
    ("energy_uJ", Number, "uJ", "Energy lost in a loop", |cell, _| json!(cell.found.energy.value)),
    ("energy_expanded_U_uJ", Number, "uJ", "Expanded uncertainty of energy_uJ, 95 %", |cell, _| json!(cell.found.energy.expanded_uncertainty)),
    ("reason", Text, "", "Why there is no lost motion", |cell, _| json!(cell.found.lost_motion.reason)),
];

#[rustfmt::skip]
const LOOP_WIDTHS: &[ColumnPlan<NamedLoop, LoopWidthReport>] = &[
    ("pose", Text, "", "Pose of the robot", |cell, _| json!(cell.pose)),
    ("direction", Text, "", "Direction of the load", |cell, _| json!(cell.direction)),
    ("target_N", Number, "N", "Target force", |_, row| json!(row.target_n)),
    ("force_N", Number, "N", "Force at which the branches are compared", |_, row| json!(row.force_n)),
    ("width_um", Number, "um", "Displacement while unloading less that while loading", |_, row| json!(row.width.value)),
    ("u_um", Number, "um", "Standard uncertainty of width_um", |_, row| json!(row.width.standard_uncertainty)),
    ("expanded_U_um", Number, "um", "Expanded uncertainty of width_um, 95 %, of this load alone", |_, row| json!(row.width.expanded_uncertainty)),
    ("degrees_of_freedom", Number, "", "Effective degrees of freedom; empty: infinite or not known", |_, row| json!(row.width.dof)),
];

/// The loops between loading and unloading, and their width at each load; nothing without any.
fn loop_tables(loops: impl Iterator<Item = NamedLoop>) -> Vec<TidyTable> {
    let loops: Vec<NamedLoop> = loops.collect();
    if loops.is_empty() {
        return Vec::new();
    }
    let widths = loops
        .iter()
        .flat_map(|one| one.found.widths.iter().map(move |width| (one, width)));
    let titles = [
        "Loop between loading and unloading of one pose and direction",
        "Width of the loop at one load in one pose and direction",
    ];
    vec![
        table(
            "hysteresis",
            titles[0],
            HYSTERESIS,
            loops.iter().map(|one| (one, one)),
        ),
        table("loop_widths", titles[1], LOOP_WIDTHS, widths),
    ]
}

/// The stiffness of every pose and direction, its uncertainty budget, the means of each load the flags, and the loops between loading and unloading.
#[must_use]
pub fn stiffness_tables(result: &StiffnessReport) -> Vec<TidyTable> {
    let cells = || result.cells.iter();
    let budgets = cells().flat_map(|cell| {
        let found = cell.uncertainty_regression.iter();
        found.flat_map(move |found| found.budget.iter().map(move |row| (cell, row)))
    });
    let loads = cells().flat_map(|cell| cell.loads.iter().map(move |load| (cell, load)));
    let flags = cells().flat_map(|cell| cell.flags.iter().map(move |flag| (cell, flag)));
    let titles = [
        "Stiffness of one pose and direction",
        "One source of uncertainty of one stiffness",
        "One load in one pose and direction",
        "One finding in the readings",
    ];
    let mut tables = vec![
        table(
            "stiffness",
            titles[0],
            STIFFNESS,
            cells().map(|cell| (cell, cell)),
        ),
        table("budget", titles[1], BUDGET, budgets),
        table("loads", titles[2], LOADS, loads),
        table("flags", titles[3], FLAGS, flags),
    ];
    tables.extend(loop_tables(cells().filter_map(|cell| {
        NamedLoop::new(&cell.pose, &cell.direction, cell.hysteresis.as_ref())
    })));
    tables
}

/// The compliance of every pose and direction of a session with displacement gauges along the base axes.
#[must_use]
pub fn vector_stiffness_tables(cells: &[VectorStiffnessCell]) -> Vec<TidyTable> {
    let title = "Compliance of one pose under load in one direction";
    let rows = cells.iter().map(|cell| (cell, cell));
    let mut tables = vec![table("stiffness", title, VECTOR_STIFFNESS, rows)];
    tables.extend(loop_tables(cells.iter().filter_map(|cell| {
        NamedLoop::new(&cell.pose, &cell.direction, cell.hysteresis.as_ref())
    })));
    tables
}

fn table<'r, C: 'r, R: 'r>(
    name: &'static str,
    title: &'static str,
    plan: &[ColumnPlan<C, R>],
    rows: impl Iterator<Item = (&'r C, &'r R)>,
) -> TidyTable {
    let columns = plan
        .iter()
        .map(|(name, kind, unit, meaning, _)| TidyColumn {
            name: (*name).to_owned(),
            kind: *kind,
            unit: (*unit).to_owned(),
            meaning: (*meaning).to_owned(),
        });
    let field = |value: Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text,
        other => other.to_string(),
    };
    let row = |(cell, row): (&C, &R)| plan.iter().map(|(.., of)| field(of(cell, row))).collect();
    TidyTable::new(name, title, columns.collect(), rows.map(row).collect())
}
