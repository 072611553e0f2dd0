//! The proof as tables, JSON and figures.

mod calibration;
mod concealed;
mod idealised;
mod power;
mod recordings;
mod twelve_values;
mod verdicts;

pub use calibration::{calibration_json, calibration_text};
pub use concealed::{concealed_json, concealed_text};
pub use idealised::{idealised_json, idealised_text};
pub use power::{power_figure, power_json, power_text};
pub use recordings::{recordings_json, recordings_text};
pub use twelve_values::{twelve_values_json, twelve_values_text};
pub use verdicts::verdicts_json;

use serde_json::{Value, json};

use crate::prove::{AcceptanceCriterion, Share, Target};

use stiffbench::report::AlignedTable;

/// A share with its interval, percent.
fn share_words(share: &Share) -> [String; 3] {
    let percent = |value: f64| format!("{:.1}", 100.0 * value);
    [
        format!("{}/{}", share.hits, share.trials),
        share.value().map_or_else(|| "-".to_owned(), percent),
        share.interval_95().map_or_else(
            || "-".to_owned(),
            |[low, high]| format!("{} to {}", percent(low), percent(high)),
        ),
    ]
}

fn target_words(target: Option<Target>) -> String {
    match target {
        None => "counted".to_owned(),
        Some(Target::AtLeast(least)) => format!("at least {:.0}", 100.0 * least),
        Some(Target::AtMost(most)) => format!("at most {:.1}", 100.0 * most),
        Some(Target::Between(least, most)) => {
            format!("{:.0} to {:.0}", 100.0 * least, 100.0 * most)
        }
    }
}

fn share_json(share: &Share) -> Value {
    json!({
        "hits": share.hits,
        "trials": share.trials,
        "share": share.value(),
        "ci95": share.interval_95(),
        "upper95": share.upper_95(),
    })
}

/// Promises beside what became of them.
fn criteria_table(criteria: &[AcceptanceCriterion]) -> String {
    let mut rows =
        AlignedTable::new(&["promise", "target, %", "hits", "%", "95 % interval", "kept"]);
    for criterion in criteria {
        let [hits, share, interval] = share_words(&criterion.share);
        let kept = criterion
            .target
            .and_then(|target| target.is_met(&criterion.share));
        rows.row([
            criterion.what.to_owned(),
            target_words(criterion.target),
            hits,
            share,
            interval,
            match kept {
                None => "-",
                Some(true) => "yes",
                Some(false) => "NO",
            }
            .to_owned(),
        ]);
    }
    rows.text()
}

fn criteria_json(criteria: &[AcceptanceCriterion]) -> Value {
    criteria
        .iter()
        .map(|criterion| {
            let target = match criterion.target {
                None => Value::Null,
                Some(Target::AtLeast(least)) => json!({ "at_least": least }),
                Some(Target::AtMost(most)) => json!({ "at_most": most }),
                Some(Target::Between(least, most)) => json!({ "between": [least, most] }),
            };
            json!({
                "what": criterion.what,
                "target": target,
                "share": share_json(&criterion.share),
                "kept": criterion.target.and_then(|target| target.is_met(&criterion.share)),
            })
        })
        .collect()
}
