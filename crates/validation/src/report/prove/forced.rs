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
    let held = |point: &ForcedPoint, place: usize| {
        let (command, of_law) = COUNTED[place];
        point.held(command, of_law)
    };
    let table = Table::of(points)
        .words("law", |point| point.law)
        .words("door", |point| point.door)
        .words("bench", |point| &point.bench)
        .words("size", |point| point.size)
        .words("law", |point| share_words(&held(point, 0).0)[0].clone())
        .words("95 % interval", |point| {
            share_words(&held(point, 0).0)[2].clone()
        })
        .words("open", |point| held(point, 0).1)
        .words("factors", |point| share_words(&held(point, 1).0)[0].clone())
        .words("factors by fit", |point| {
            share_words(&held(point, 2).0)[0].clone()
        });
    text.push_str(&table.text());
    text.push_str("\nAll laws together.\n\n");
    let mut groups: Vec<(&str, f64)> = Vec::new();
    for group in points.iter().map(|point| (point.door, point.size)) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    let counted = groups.iter().flat_map(|group| {
        COUNTED.map(|(command, of_law)| {
            let of_group = points.iter().filter(|one| (one.door, one.size) == *group);
            let all = of_group.fold(Share::default(), |sum, point| {
                sum.with(point.held(command, of_law).0)
            });
            (group, command, of_law, all)
        })
    });
    let table = Table::of(counted.filter(|(.., all)| all.trials > 0))
        .words("door", |((door, _), ..)| *door)
        .words("size", |((_, size), ..)| *size)
        .words(
            "intervals of",
            |(_, _, of_law, _)| {
                if *of_law { "laws" } else { "factors" }
            },
        )
        .words("command", |(_, command, ..)| *command)
        .words("hits", |(.., all)| share_words(all)[0].clone())
        .words("%", |(.., all)| share_words(all)[1].clone())
        .words("95 % interval", |(.., all)| share_words(all)[2].clone());
    text + &table.text() + "\n"
}
