//! How often intervals hold the truth where a law is stated and not searched.

use crate::prove::{ForcedPoint, Share};
use stiffbench::report::Table;

use super::share_words;

/// What is counted: the values of the law and the factors beside it by `diagnose`, and the factors by `fit`, which keeps the law as it is stated.
const COUNTED: [(&str, bool); 3] = [("diagnose", true), ("diagnose", false), ("fit", false)];

/// A table of the laws, and one of all together.
#[must_use]
pub fn forced_text(points: &[ForcedPoint]) -> String {
    let mut text = "Intervals that hold the truth where a law is stated and not searched; size in standard errors. Open: intervals of the law's values that reach both ends of what is plausible.\n\n".to_owned();
    let mut table = Table::new(&[
        "law",
        "door",
        "bench",
        "size",
        "law",
        "95 % interval",
        "open",
        "factors",
        "factors by fit",
    ]);
    for point in points {
        let [(law, open), (factors, _), (fit, _)] =
            COUNTED.map(|(command, of_law)| point.held(command, of_law));
        let [hits, _, interval] = share_words(&law);
        table.row([
            point.law.to_owned(),
            point.door.to_owned(),
            point.bench.clone(),
            format!("{}", point.size),
            hits,
            interval,
            open.to_string(),
            share_words(&factors)[0].clone(),
            share_words(&fit)[0].clone(),
        ]);
    }
    text.push_str(&table.text());
    text.push_str("\nAll laws together.\n\n");
    let mut table = Table::new(&[
        "door",
        "size",
        "intervals of",
        "command",
        "hits",
        "%",
        "95 % interval",
    ]);
    let mut groups: Vec<(&str, f64)> = Vec::new();
    for group in points.iter().map(|point| (point.door, point.size)) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (door, size) in groups {
        for (command, of_law) in COUNTED {
            let of_group = points
                .iter()
                .filter(|one| (one.door, one.size) == (door, size));
            let all = of_group.fold(Share::default(), |sum, point| {
                sum.with(point.held(command, of_law).0)
            });
            if all.trials > 0 {
                let [hits, percent, interval] = share_words(&all);
                table.row([
                    door.to_owned(),
                    format!("{size}"),
                    if of_law { "laws" } else { "factors" }.to_owned(),
                    command.to_owned(),
                    hits,
                    percent,
                    interval,
                ]);
            }
        }
    }
    text + &table.text() + "\n"
}
