//! Power and right names.

use schemars::JsonSchema;
use serde::Serialize;

use crate::prove::{AcceptanceCriterion, IdealPoint, PowerCase, PowerPoint, Share, Target};
use stiffbench::physics::Law;
use stiffbench::plot::{Figure, LawPower, PowerAtSize, PowerCurves, Rate, power_curves};
use stiffbench::report::{Table, numbers, words};

use super::{criteria_table, share_words};

/// Sizes, standard errors, at which 80 % are to be rightly named, and those at which 95 % are and intervals are held to their promise.
const AT_80: [f64; 2] = [4.49, 5.9];
const FROM_95: [f64; 2] = [5.9, f64::INFINITY];

/// What is counted of a point.
type Counted = fn(&PowerPoint) -> Share;

/// The table of all points, and what was promised.
#[must_use]
pub fn power_text(cases: &[PowerCase]) -> String {
    let mut table = Table::new([
        words("effect"),
        words("bench"),
        words("loop"),
        numbers("size"),
        numbers("found, %"),
        numbers("truth in the set, %"),
        numbers("right name, %"),
        numbers("95 % interval"),
        numbers("named alone, %"),
        numbers("wrong name, %"),
        numbers("size in interval"),
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
    let mut table = Table::new([
        words("law"),
        numbers("benches"),
        numbers("4.5: right"),
        numbers("%"),
        numbers("95 % interval"),
        numbers("6 and more: right"),
        numbers("%"),
        numbers("95 % interval"),
        numbers("6 and more: truth in the set"),
        numbers("%"),
        numbers("95 % interval"),
    ]);
    for name in Law::names()
        .into_iter()
        .filter(|name| Law::named(name).all(|law| !law.is_of_one_run()))
    {
        let benches = cases.iter().filter(|case| is_of_law(case, name)).count();
        if benches == 0 {
            continue;
        }
        let of_sizes = |(range, of): ([f64; 2], Counted)| {
            share_words(&sum(of_law(cases, name, range).into_iter(), of))
        };
        let counts: [([f64; 2], Counted); 3] = [
            (AT_80, |point| point.right),
            (FROM_95, |point| point.right),
            (FROM_95, |point| point.named),
        ];
        let mut row = vec![name.to_owned(), benches.to_string()];
        row.extend(counts.into_iter().flat_map(of_sizes));
        table.row(row);
    }
    table
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
    let mut table = Table::new([
        words("law"),
        numbers("size"),
        numbers("counted: right, %"),
        numbers("95 % interval"),
        numbers("ideal: found, %"),
        numbers("ideal: right, %"),
        numbers("ideal: nameable, %"),
    ]);
    let mut row = |name: &str, size: &str, points: Vec<&PowerPoint>| {
        // What has no size, the observer has not tried: it is left out of the counts too.
        let tried = || {
            let points = points.iter();
            points.filter_map(|point| Some((*point, point.ideal.as_ref()?)))
        };
        if tried().next().is_none() {
            return;
        }
        let ideal = |of: fn(&IdealPoint) -> Share| {
            let all = tried().fold(Share::default(), |sum, (_, ideal)| sum.with(of(ideal)));
            share_words(&all)[1].clone()
        };
        let [_, right, interval] = share_words(&sum(tried().map(|(point, _)| point), |p| p.right));
        table.row([
            name.to_owned(),
            size.to_owned(),
            right,
            interval,
            ideal(|ideal| ideal.found),
            ideal(|ideal| ideal.right),
            ideal(|ideal| ideal.nameable),
        ]);
    };
    let sizes = [("4.5", AT_80), ("6 and more", FROM_95)];
    for name in Law::names()
        .into_iter()
        .filter(|name| Law::named(name).all(|law| !law.is_of_one_run()))
    {
        for (size, range) in sizes {
            row(name, size, of_law(cases, name, range));
        }
    }
    for (size, range) in sizes {
        row("all of these", size, points(cases, false, range).collect());
    }
    for point in points(cases, true, [0.0, f64::INFINITY]) {
        row("slip", &format!("{:.1}", point.size), vec![point]);
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
