//! Results as tidy tables, taken from the JSON form of the results, so that both hold the same numbers.

use serde::Serialize;
use serde_json::Value;

use super::table::FieldKind::{self, Integer, Number, Text};
use super::table::{TidyColumn, TidyTable};

/// A column: name, kind, unit, meaning, and where its value stands in JSON. A place with `^` is one of the object around.
type ColumnPlan = (
    &'static str,
    FieldKind,
    &'static str,
    &'static str,
    &'static str,
);

const POSE: ColumnPlan = ("pose", Text, "", "Pose of the robot", "^/pose");
const DIRECTION: ColumnPlan = (
    "direction",
    Text,
    "",
    "Direction of the load",
    "^/direction",
);

#[rustfmt::skip]
const STIFFNESS: &[ColumnPlan] = &[
    POSE,
    DIRECTION,
    ("runs", Integer, "", "Number of runs", "/n_runs"),
    ("zeros", Integer, "", "Number of gauge zeros", "/n_zeros"),
    ("stiffness_N_per_um", Number, "N/um", "Stiffness by regression: inverse slope with a free intercept for each zero", "/stiffness_regression/value"),
    ("u_N_per_um", Number, "N/um", "Standard uncertainty of the stiffness by regression", "/stiffness_regression/u"),
    ("expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the stiffness by regression, 95 %", "/stiffness_regression/U"),
    ("coverage_factor", Number, "", "Coverage factor k of the expanded uncertainty", "/stiffness_regression/k"),
    ("degrees_of_freedom", Number, "", "Effective degrees of freedom; empty: infinite or not known", "/stiffness_regression/dof"),
    ("type_a_N_per_um", Number, "N/um", "Type A part of the standard uncertainty", "/uncertainty_regression/type_a_N_per_um"),
    ("type_b_N_per_um", Number, "N/um", "Type B part of the standard uncertainty", "/uncertainty_regression/type_b_N_per_um"),
    ("mean_ratio_N_per_um", Number, "N/um", "Stiffness as the mean of force over displacement", "/stiffness_paper/value"),
    ("mean_ratio_u_N_per_um", Number, "N/um", "Standard uncertainty of the mean of force over displacement", "/stiffness_paper/u"),
    ("mean_ratio_expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the mean of force over displacement, 95 %", "/stiffness_paper/U"),
    ("compliance_um_per_N", Number, "um/N", "Slope of displacement over force", "/compliance/value"),
    ("zero_offset_um", Number, "um", "Displacement of the line at zero force", "/zero_offset_um"),
    ("reason", Text, "", "Why a value or its uncertainty is missing", "/stiffness_regression/reason"),
];

#[rustfmt::skip]
const BUDGET: &[ColumnPlan] = &[
    POSE,
    DIRECTION,
    ("source", Text, "", "Source of uncertainty", "/source"),
    ("evaluation", Text, "", "Type A or B evaluation (GUM)", "/type"),
    ("distribution", Text, "", "Assumed distribution", "/distribution"),
    ("standing", Text, "", "Whether the row counts in the sum, and why not", "/standing"),
    ("standard_uncertainty", Number, "", "Standard uncertainty, in the unit of the next column", "/standard_uncertainty"),
    ("unit", Text, "", "Unit of the standard uncertainty", "/unit"),
    ("sensitivity", Number, "", "Sensitivity of the stiffness, in the unit of the next column", "/sensitivity"),
    ("sensitivity_unit", Text, "", "Unit of the sensitivity", "/sensitivity_unit"),
    ("contribution_N_per_um", Number, "N/um", "Contribution to the standard uncertainty of the stiffness", "/contribution_N_per_um"),
    ("degrees_of_freedom", Number, "", "Degrees of freedom; empty: infinite", "/dof"),
    ("share_percent", Number, "%", "Share of the variance", "/share_percent"),
    ("note", Text, "", "Note", "/note"),
];

#[rustfmt::skip]
const LOADS: &[ColumnPlan] = &[
    POSE,
    DIRECTION,
    ("branch", Text, "", "Loading or unloading", "/branch"),
    ("target_N", Number, "N", "Target force", "/target_N"),
    ("readings", Integer, "", "Number of readings", "/n"),
    ("mean_force_N", Number, "N", "Mean of the force", "/mean_force_N"),
    ("sd_force_N", Number, "N", "Standard deviation of the force", "/sd_force_N"),
    ("mean_displacement_um", Number, "um", "Mean of the displacement", "/mean_um"),
    ("sd_displacement_um", Number, "um", "Standard deviation of the displacement", "/sd_um"),
];

#[rustfmt::skip]
const FLAGS: &[ColumnPlan] = &[
    POSE,
    DIRECTION,
    ("rule", Text, "", "Rule that the readings break", "/rule"),
    ("message", Text, "", "What was found", "/message"),
    ("statistic", Number, "", "Test statistic", "/statistic"),
    ("limit", Number, "", "Critical value", "/limit"),
    ("seq", Integer, "", "Sequence number of the reading concerned", "/seq"),
];

#[rustfmt::skip]
const VECTOR_STIFFNESS: &[ColumnPlan] = &[
    POSE,
    DIRECTION,
    ("runs", Integer, "", "Number of runs", "/runs"),
    ("readings", Integer, "", "Number of readings", "/readings"),
    ("compliance_x_um_per_N", Number, "um/N", "Displacement along x per force along the load", "/compliance/x/value"),
    ("compliance_x_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_x_um_per_N", "/compliance/x/u"),
    ("compliance_y_um_per_N", Number, "um/N", "Displacement along y per force along the load", "/compliance/y/value"),
    ("compliance_y_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_y_um_per_N", "/compliance/y/u"),
    ("compliance_z_um_per_N", Number, "um/N", "Displacement along z per force along the load", "/compliance/z/value"),
    ("compliance_z_u_um_per_N", Number, "um/N", "Standard uncertainty of compliance_z_um_per_N", "/compliance/z/u"),
    ("stiffness_N_per_um", Number, "N/um", "Stiffness along the load", "/stiffness/value"),
    ("u_N_per_um", Number, "N/um", "Standard uncertainty of the stiffness", "/stiffness/u"),
    ("expanded_U_N_per_um", Number, "N/um", "Expanded uncertainty of the stiffness, 95 %", "/stiffness/U"),
    ("reason", Text, "", "Why a value or its uncertainty is missing", "/stiffness/reason"),
];

/// The stiffness of every pose and direction, its uncertainty budget, the means of each load and the flags.
///
/// # Arguments
/// - `result`: what `stiffness` hands back.
#[must_use]
pub fn stiffness_tables(result: &impl Serialize) -> Vec<TidyTable> {
    let result = serde_json::to_value(result).unwrap_or_default();
    let cells = array(&result, "/cells");
    let within = |place: &str| nested(cells, place);
    vec![
        table(
            "stiffness",
            "Stiffness of one pose and direction",
            STIFFNESS,
            nested(cells, ""),
        ),
        table(
            "budget",
            "One source of uncertainty of one stiffness",
            BUDGET,
            within("/uncertainty_regression/budget"),
        ),
        table(
            "loads",
            "One load in one pose and direction",
            LOADS,
            within("/loads"),
        ),
        table(
            "flags",
            "One finding in the readings",
            FLAGS,
            within("/flags"),
        ),
    ]
}

/// The compliance of every pose and direction of a session with displacement gauges along the base axes.
///
/// # Arguments
/// - `result`: what `stiffness` hands back for such a session.
#[must_use]
pub fn vector_stiffness_tables(result: &impl Serialize) -> Vec<TidyTable> {
    let result = serde_json::to_value(result).unwrap_or_default();
    let cells = nested(array(&result, "/cells"), "");
    vec![table(
        "stiffness",
        "Compliance of one pose under load in one direction",
        VECTOR_STIFFNESS,
        cells,
    )]
}

fn array<'a>(value: &'a Value, place: &str) -> &'a [Value] {
    value
        .pointer(place)
        .and_then(Value::as_array)
        .map_or(&[], Vec::as_slice)
}

/// Objects of an array inside each object, with the object around; for an empty place the objects themselves.
fn nested<'a>(objects: &'a [Value], place: &str) -> Vec<(&'a Value, &'a Value)> {
    if place.is_empty() {
        return objects.iter().map(|object| (object, object)).collect();
    }
    let inner = |object: &'a Value| array(object, place).iter().map(move |row| (object, row));
    objects.iter().flat_map(inner).collect()
}

fn table(
    name: &'static str,
    title: &'static str,
    plan: &[ColumnPlan],
    objects: Vec<(&Value, &Value)>,
) -> TidyTable {
    let columns = plan
        .iter()
        .map(|(name, kind, unit, meaning, _)| TidyColumn {
            name: (*name).to_owned(),
            kind: *kind,
            unit: (*unit).to_owned(),
            meaning: (*meaning).to_owned(),
        });
    let row = |(around, object): (&Value, &Value)| {
        let fields = plan
            .iter()
            .map(|(.., place)| match place.strip_prefix('^') {
                Some(place) => field(around.pointer(place)),
                None => field(object.pointer(place)),
            });
        fields.collect::<Vec<String>>()
    };
    let rows = objects.into_iter().map(row).collect();
    TidyTable::new(name, title, columns.collect(), rows)
}

fn field(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    }
}
