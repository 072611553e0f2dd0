//! Power and right names.

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{AcceptanceCriterion, IdealPoint, PowerCase, PowerPoint, Share, Target};
use stiffbench::physics::Law;
use stiffbench::plot::{Figure, LawPower, PowerAtSize, PowerCurves, Rate, power_curves};
use stiffbench::report::Table;

use super::{criteria_table, share_words};

/// Sizes, standard errors, at which 80 % are to be rightly named, and those at which 95 % are and intervals are held to their promise.
const AT_80: [f64; 2] = [4.49, 5.9];
const FROM_95: [f64; 2] = [5.9, f64::INFINITY];

/// What is counted of a point.
type Counted = fn(&PowerPoint) -> Share;

/// The table of all points, and what was promised.
#[must_use]
pub fn power_text(cases: &[PowerCase]) -> String {
    let percent = |share: &Share| share_words(share)[1].clone();
    let points = cases
        .iter()
        .flat_map(|case| case.points.iter().map(move |point| (case, point)));
    let table = Table::of(points)
        .words("effect", |(case, _)| title(case))
        .words("bench", |(case, _)| &case.bench)
        .words("loop", |(case, _)| match case.in_closed_loop {
            None => "",
            Some(true) => "closed",
            Some(false) => "open",
        })
        .numbers("size", |(_, point)| format!("{:.1}", point.size))
        .numbers("found, %", |(_, point)| percent(&point.found))
        .numbers("truth in the set, %", |(_, point)| percent(&point.named))
        .numbers_each(["right name, %", "95 % interval"], |(_, point)| {
            let [_, right, interval] = share_words(&point.right);
            [right, interval]
        })
        .numbers("named alone, %", |(_, point)| percent(&point.alone))
        .numbers("wrong name, %", |(_, point)| percent(&point.wrong))
        .numbers("size in interval", |(_, point)| {
            format!("{}/{}", point.sizes.hits, point.sizes.trials)
        });
    format!(
        "Power and right names against size in standard errors; right: named alone, or with indistinguishable effects, and nothing else\n\n{}\n{}\n{IDEAL}\n\n{}\n{}\n",
        table.text(),
        law_table(cases).text(),
        ideal_table(cases).text(),
        criteria_table(&criteria(cases))
    )
}

/// What the second table of laws compares the counts with.
const IDEAL: &str = "The same beside an ideal observer: known noise, and each effect is one of the searched shapes; limits and rules are the same. \
Nameable: found, and the likeliest is the truth or may be named with it, which no set around the likeliest exceeds";

/// Laws and places of a case; the two drifts share a name.
fn title(case: &PowerCase) -> String {
    match case.laws[..] {
        [law] => case.title.replacen(law.name, law.row, 1),
        _ => case.title.clone(),
    }
}

/// Each law by itself, all its benches together.
fn law_table(cases: &[PowerCase]) -> Table {
    let benches = |name: &&'static str| cases.iter().filter(|case| is_of_law(case, name)).count();
    let counted = |name: &str, range: [f64; 2], of: Counted| {
        share_words(&sum(of_law(cases, name, range).into_iter(), of))
    };
    let named = |range: &str, what: &str| {
        [
            format!("{range}: {what}"),
            "%".to_owned(),
            "95 % interval".to_owned(),
        ]
    };
    Table::of(names().into_iter().filter(|name| benches(name) > 0))
        .words("law", |name| *name)
        .numbers("benches", benches)
        .numbers_each(named("4.5", "right"), |name| {
            counted(name, AT_80, |point| point.right)
        })
        .numbers_each(named("6 and more", "right"), |name| {
            counted(name, FROM_95, |point| point.right)
        })
        .numbers_each(named("6 and more", "truth in the set"), |name| {
            counted(name, FROM_95, |point| point.named)
        })
        .into()
}

/// Names of the laws that act in every run.
fn names() -> Vec<&'static str> {
    let mut names = Law::names();
    names.retain(|name| Law::named(name).all(|law| !law.is_of_one_run()));
    names
}

fn is_of_law(case: &PowerCase, name: &str) -> bool {
    case.laws.len() == 1 && case.laws[0].name == name
}

/// Points of a law in a range of sizes.
fn of_law<'a>(cases: &'a [PowerCase], name: &str, [least, most]: [f64; 2]) -> Vec<&'a PowerPoint> {
    let own = cases.iter().filter(|case| is_of_law(case, name));
    own.flat_map(|case| &case.points)
        .filter(|point| (least..most).contains(&point.size))
        .collect()
}

/// Each law by itself, counted and at best.
fn ideal_table(cases: &[PowerCase]) -> Table {
    let sizes = [("4.5", AT_80), ("6 and more", FROM_95)];
    let mut rows: Vec<(&str, String, Vec<&PowerPoint>)> = Vec::new();
    for name in names() {
        for (size, range) in sizes {
            rows.push((name, size.to_owned(), of_law(cases, name, range)));
        }
    }
    for (size, range) in sizes {
        let all = points(cases, false, range).collect();
        rows.push(("all of these", size.to_owned(), all));
    }
    for point in points(cases, true, [0.0, f64::INFINITY]) {
        rows.push(("slip", format!("{:.1}", point.size), vec![point]));
    }
    for (.., points) in &mut rows {
        points.retain(|point| point.ideal.is_some());
    }
    rows.retain(|(.., points)| !points.is_empty());
    let ideal = |points: &[&PowerPoint], of: fn(&IdealPoint) -> Share| {
        let tried = points.iter().filter_map(|point| point.ideal.as_ref());
        let all = tried.fold(Share::default(), |sum, ideal| sum.with(of(ideal)));
        share_words(&all)[1].clone()
    };
    Table::of(rows)
        .words("law", |(name, ..)| *name)
        .numbers("size", |(_, size, _)| size.clone())
        .numbers_each(["counted: right, %", "95 % interval"], |(.., points)| {
            let right = sum(points.iter().copied(), |point| point.right);
            let [_, right, interval] = share_words(&right);
            [right, interval]
        })
        .numbers("ideal: found, %", |(.., points)| {
            ideal(points, |ideal| ideal.found)
        })
        .numbers("ideal: right, %", |(.., points)| {
            ideal(points, |ideal| ideal.right)
        })
        .numbers("ideal: nameable, %", |(.., points)| {
            ideal(points, |ideal| ideal.nameable)
        })
        .into()
}

/// Points of single effects, of slip or of all others, in a range of sizes.
fn points(
    cases: &[PowerCase],
    slip: bool,
    [least, most]: [f64; 2],
) -> impl Iterator<Item = &PowerPoint> {
    cases
        .iter()
        .filter(move |case| case.laws.len() == 1 && case.laws[0].is_of_one_run() == slip)
        .flat_map(|case| &case.points)
        .filter(move |point| (least..most).contains(&point.size))
}

fn sum<'a>(points: impl Iterator<Item = &'a PowerPoint>, of: Counted) -> Share {
    points.fold(Share::default(), |sum, point| sum.with(of(point)))
}

fn criteria(cases: &[PowerCase]) -> Vec<AcceptanceCriterion> {
    let right = |point: &PowerPoint| point.right;
    let of_slip = |number: usize| {
        cases
            .iter()
            .filter(|case| case.laws.len() == 1 && case.laws[0].is_of_one_run())
            .filter_map(move |case| case.points.get(number))
    };
    let pairs = cases
        .iter()
        .filter(|case| case.laws.len() == 2)
        .flat_map(|case| &case.points);
    let criterion = |what, target, share| AcceptanceCriterion {
        what,
        target: Some(target),
        share,
    };
    vec![
        criterion(
            "4.5 standard errors, not slip: rightly named",
            Target::AtLeast(0.80),
            sum(points(cases, false, AT_80), right),
        ),
        criterion(
            "6 and more, not slip: rightly named",
            Target::AtLeast(0.95),
            sum(points(cases, false, FROM_95), right),
        ),
        criterion(
            "slip at its limit + 0.84: rightly named",
            Target::AtLeast(0.80),
            sum(of_slip(0), right),
        ),
        criterion(
            "slip at its limit + 1.64: rightly named",
            Target::AtLeast(0.95),
            sum(of_slip(1), right),
        ),
        AcceptanceCriterion {
            what: "the same: nothing but slips of its run named",
            target: None,
            share: sum(of_slip(1), |point| point.in_run),
        },
        criterion(
            "two effects of 12 each: both rightly named and nothing else",
            Target::AtLeast(0.90),
            sum(pairs, right),
        ),
        criterion(
            "sizes of 6 and more inside their 95 % intervals",
            Target::Between(0.93, 0.97),
            sum(points(cases, false, FROM_95), |p| p.sizes),
        ),
        criterion(
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
        .filter(|case| case.laws.len() == 1 && !case.laws[0].is_missing_element())
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
                    ideal: point.ideal.and_then(|ideal| ideal.right.value()),
                    covered: (point.sizes.trials > 0).then(|| rate(&point.sizes)),
                })
                .collect(),
        })
        .collect();
    power_curves(&PowerCurves { laws })
}

/// Power and right names, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PowerReport {
    /// What was promised.
    #[serde(rename = "promises")]
    pub criteria: Vec<AcceptanceCriterion>,
    /// Each law on each bench.
    pub cases: Vec<PowerCase>,
}

impl PowerReport {
    /// The cases with what was promised of them.
    #[must_use]
    pub fn new(cases: &[PowerCase]) -> Self {
        Self {
            criteria: criteria(cases),
            cases: cases.to_vec(),
        }
    }
}
