//! Power and right names.

use serde_json::{Value, json};

use crate::physics::Law;
use crate::plot::{Figure, LawPower, PowerAtSize, PowerCurves, Rate, power_curves};
use crate::prove::{PowerCase, PowerPoint, Promise, Share, Target};
use crate::report::diagnosis::law_row;
use crate::report::text::TextTable;

use super::{promise_table, promises_json, share_json, share_words};

/// Sizes, standard errors, at which 80 % are to be rightly named, and those at which 95 % are and intervals are held to their promise.
const AT_80: [f64; 2] = [4.49, 5.9];
const FROM_95: [f64; 2] = [5.9, f64::INFINITY];

/// What is counted of a point.
type Counted = fn(&PowerPoint) -> Share;

/// The table of all points, and what was promised.
#[must_use]
pub fn power_text(cases: &[PowerCase]) -> String {
    let mut table = TextTable::new(&[
        "effect",
        "bench",
        "loop",
        "size",
        "found, %",
        "truth in the set, %",
        "right name, %",
        "95 % interval",
        "named alone, %",
        "wrong name, %",
        "size in interval",
    ]);
    let percent = |share: &Share| share_words(share)[1].clone();
    for case in cases {
        for point in &case.points {
            let [_, right, interval] = share_words(&point.right);
            table.row([
                title(case),
                case.bench.clone(),
                match case.in_closed_loop {
                    None => "",
                    Some(true) => "closed",
                    Some(false) => "open",
                }
                .to_owned(),
                format!("{:.1}", point.size),
                percent(&point.found),
                percent(&point.named),
                right,
                interval,
                percent(&point.alone),
                percent(&point.wrong),
                format!("{}/{}", point.sizes.hits, point.sizes.trials),
            ]);
        }
    }
    format!(
        "Power and right names against size in standard errors; right: named alone, or with what cannot be told apart, and nothing else\n\n{}\n{}\n{}\n",
        table.text(),
        law_table(cases).text(),
        promise_table(&promises(cases))
    )
}

/// Laws and places of a case; the two drifts share a name.
fn title(case: &PowerCase) -> String {
    match case.laws[..] {
        [law] => case.title.replacen(law.name(), &law_row(law), 1),
        _ => case.title.clone(),
    }
}

/// Each law by itself, all its benches together.
fn law_table(cases: &[PowerCase]) -> TextTable {
    let mut table = TextTable::new(&[
        "law",
        "benches",
        "4.5: right",
        "%",
        "95 % interval",
        "6 and more: right",
        "%",
        "95 % interval",
        "truth in the set",
        "%",
        "95 % interval",
    ]);
    let mut names: Vec<&str> = Law::ALL.into_iter().map(Law::name).collect();
    names.dedup();
    for name in names {
        let own = || {
            cases
                .iter()
                .filter(|case| case.laws.len() == 1 && case.laws[0].name() == name)
        };
        if name == Law::Slip.name() || own().next().is_none() {
            continue;
        }
        let of_sizes = |([least, most], of): ([f64; 2], Counted)| {
            let points = own().flat_map(|case| &case.points);
            let within = points.filter(|point| (least..most).contains(&point.size));
            share_words(&sum(within, of))
        };
        let counts: [([f64; 2], Counted); 3] = [
            (AT_80, |point| point.right),
            (FROM_95, |point| point.right),
            (FROM_95, |point| point.named),
        ];
        let mut row = vec![name.to_owned(), own().count().to_string()];
        row.extend(counts.into_iter().flat_map(of_sizes));
        table.row(row);
    }
    table
}

/// Points of single effects, of slip or of all others, in a range of sizes.
fn points(
    cases: &[PowerCase],
    slip: bool,
    [least, most]: [f64; 2],
) -> impl Iterator<Item = &PowerPoint> {
    cases
        .iter()
        .filter(move |case| case.laws.len() == 1 && (case.laws[0] == Law::Slip) == slip)
        .flat_map(|case| &case.points)
        .filter(move |point| (least..most).contains(&point.size))
}

fn sum<'a>(points: impl Iterator<Item = &'a PowerPoint>, of: Counted) -> Share {
    points.fold(Share::default(), |sum, point| sum.with(of(point)))
}

fn promises(cases: &[PowerCase]) -> Vec<Promise> {
    let right = |point: &PowerPoint| point.right;
    let of_slip = |number: usize| {
        cases
            .iter()
            .filter(|case| case.laws == [Law::Slip])
            .filter_map(move |case| case.points.get(number))
    };
    let pairs = cases
        .iter()
        .filter(|case| case.laws.len() == 2)
        .flat_map(|case| &case.points);
    let promise = |what, target, share| Promise {
        what,
        target: Some(target),
        share,
    };
    vec![
        promise(
            "4.5 standard errors, not slip: rightly named",
            Target::AtLeast(0.80),
            sum(points(cases, false, AT_80), right),
        ),
        promise(
            "6 and more, not slip: rightly named",
            Target::AtLeast(0.95),
            sum(points(cases, false, FROM_95), right),
        ),
        promise(
            "slip at its limit + 0.84: rightly named",
            Target::AtLeast(0.80),
            sum(of_slip(0), right),
        ),
        promise(
            "slip at its limit + 1.64: rightly named",
            Target::AtLeast(0.95),
            sum(of_slip(1), right),
        ),
        Promise {
            what: "the same: nothing but slips of its run named",
            target: None,
            share: sum(of_slip(1), |point| point.in_run),
        },
        promise(
            "two effects of 12 each: both rightly named and nothing else",
            Target::AtLeast(0.90),
            sum(pairs, right),
        ),
        promise(
            "sizes of 6 and more inside their 95 % intervals",
            Target::Between(0.93, 0.97),
            sum(points(cases, false, FROM_95), |p| p.sizes),
        ),
        promise(
            "identified factors inside their 95 % intervals, 6 and more",
            Target::Between(0.93, 0.97),
            sum(points(cases, false, FROM_95), |p| p.factors),
        ),
    ]
}

/// The curves as a figure, one panel for each effect.
#[must_use]
pub fn power_figure(cases: &[PowerCase]) -> Figure {
    let rate = |share: &Share| Rate {
        share: share.value().unwrap_or(0.0),
        ci95: share.interval_95(),
    };
    let laws = cases
        .iter()
        // A member is loose or it is not: it has one size, far beyond those of the curves, and stands in the table.
        .filter(|case| case.laws.len() == 1 && case.laws[0] != Law::LooseMember)
        .map(|case| LawPower {
            name: match case.in_closed_loop {
                Some(false) => format!("{}, open", title(case)),
                _ => title(case),
            },
            sizes: case
                .points
                .iter()
                .filter(|point| point.found.trials > 0)
                .map(|point| PowerAtSize {
                    size_standard_errors: point.size,
                    trials: point.found.trials,
                    detected: rate(&point.found),
                    named: Some(rate(&point.right)),
                    covered: (point.sizes.trials > 0).then(|| rate(&point.sizes)),
                })
                .collect(),
        })
        .collect();
    power_curves(&PowerCurves { laws })
}

/// The same for programs.
#[must_use]
pub fn power_json(cases: &[PowerCase]) -> Value {
    json!({
        "promises": promises_json(&promises(cases)),
        "cases": cases.iter().map(|case| json!({
            "laws": case.laws.iter().map(|law| law.name()).collect::<Vec<_>>(),
            "effects": case.title,
            "bench": case.bench,
            "in_closed_loop": case.in_closed_loop,
            "points": case.points.iter().map(|point| json!({
                "standard_errors": point.size,
                "found": share_json(&point.found),
                "named": share_json(&point.named),
                "right": share_json(&point.right),
                "alone": share_json(&point.alone),
                "in_run": share_json(&point.in_run),
                "wrong": share_json(&point.wrong),
                "sizes_in_intervals": share_json(&point.sizes),
                "factors_in_intervals": share_json(&point.factors),
            })).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
    })
}
