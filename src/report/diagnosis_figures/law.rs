//! What the readings show of a found law, and its curve, over what drives it.

use indexmap::IndexSet;

use crate::analysis::DiagnosisReport;
use crate::mismatch::{EffectTrace, ReadingTrace};
use crate::physics::{Curve, Driving, Law, Place};
use crate::plot::{Bar, CurveShape, DrivingQuantity, FoundLaw, LawCurve, LawPanel, LawPoint};
use crate::report::diagnosis::short_phrase;
use crate::test_point::{Branch, Cell, Direction};

use super::left_m;

/// Loads of at least this share of the largest count as large: there a law that grows with the displacement shows best.
const LARGE_LOAD: f64 = 0.9;

/// Points into which a quantity is gathered that has a value of its own for each reading.
const GATHERED: usize = 24;

/// One reading as the figure sees it.
struct Seen<'a> {
    reading: &'a ReadingTrace,
    /// What drives the law.
    at: f64,
    /// What the law does, m.
    change_m: f64,
    /// What the reading shows without the law, m.
    shown_m: f64,
    variance_m2: f64,
}

/// The figure's input for one effect.
pub(super) fn law(report: &DiagnosisReport, effect: &EffectTrace) -> FoundLaw {
    let driving = driving(report, effect.effect.law);
    let seen = seen(report, effect, driving);
    let panels = if driving == DrivingQuantity::Change {
        Direction::ALL
            .into_iter()
            .filter_map(|axis| by_change(axis, &seen))
            .collect()
    } else if let Some(heading) = effect.effect.law.figure.pooled {
        vec![LawPanel {
            heading: heading.to_owned(),
            ..gathered(effect, seen)
        }]
    } else {
        let cells: IndexSet<&Cell> = seen.iter().map(|one| &one.reading.cell).collect();
        let panel = |cell: &&Cell| {
            let own = seen.iter().filter(|one| one.reading.cell == **cell);
            let heading = if report.is_of_part() {
                cell.pose.to_string()
            } else {
                cell.to_string()
            };
            by_step(heading, effect, driving, &own.collect::<Vec<_>>())
        };
        cells.iter().map(panel).collect()
    };
    FoundLaw {
        found: short_phrase(&effect.effect),
        driving,
        quantities: report.subject.quantities(),
        bar: Bar::StandardUncertainty,
        panels,
    }
}

/// What drives a law, as far as it was recorded.
fn driving(report: &DiagnosisReport, law: Law) -> DrivingQuantity {
    let recorded = report.observations.recorded;
    match law.figure.driving {
        _ if !report.observations.has_series() => DrivingQuantity::Change,
        Driving::Displacement => DrivingQuantity::Displacement,
        Driving::Clock if recorded.time => DrivingQuantity::Clock,
        Driving::Hold if recorded.hold => DrivingQuantity::Hold,
        Driving::Repeat => DrivingQuantity::Repeat,
        Driving::Force | Driving::Clock | Driving::Hold => DrivingQuantity::Force,
    }
}

/// The readings that show a law.
fn seen<'a>(
    report: &'a DiagnosisReport,
    effect: &'a EffectTrace,
    driving: DrivingQuantity,
) -> Vec<Seen<'a>> {
    let readings = &report.trace.readings;
    let largest_n = readings.iter().map(|r| r.force_n.abs()).fold(0.0, f64::max);
    let large_only = effect.effect.law.figure.large_loads_only;
    let shows = |reading: &ReadingTrace| match &effect.effect.place {
        Place::Run {
            pose,
            direction,
            repeat,
            gauge,
            ..
        } => {
            let of_run = (&reading.cell.pose, reading.repeat) == (pose, *repeat);
            let is_read = gauge.is_none_or(|axis| axis == reading.cell.direction);
            of_run && is_read && reading.cell.is_loaded_along(direction)
        }
        _ => !large_only || reading.force_n.abs() >= LARGE_LOAD * largest_n,
    };
    let period_m = match effect.effect.law.figure.curve {
        Curve::Period { parameter, .. } => effect.effect.values.get(parameter).copied(),
        Curve::Lines | Curve::Steps | Curve::Shape(_) => None,
    };
    readings
        .iter()
        .zip(&effect.change_m)
        .filter(|(reading, _)| shows(reading))
        .map(|(reading, &change_m)| Seen {
            reading,
            at: match driving {
                DrivingQuantity::Force => reading.force_n,
                DrivingQuantity::Displacement => match period_m {
                    Some(period_m) if period_m > 0.0 => reading.displacement_m.rem_euclid(period_m),
                    _ => reading.displacement_m,
                },
                DrivingQuantity::Clock => reading.since_zero_s.unwrap_or(0.0),
                DrivingQuantity::Hold => reading.hold_s.unwrap_or(0.0),
                DrivingQuantity::Repeat => f64::from(reading.repeat),
                DrivingQuantity::Change => change_m,
            },
            change_m,
            shown_m: left_m(report, reading) + change_m,
            variance_m2: reading.reading_sd_m.powi(2),
        })
        .collect()
}

/// One panel of all readings: gathered along the driving quantity, precise readings counting more.
fn gathered(effect: &EffectTrace, mut seen: Vec<Seen<'_>>) -> LawPanel {
    seen.sort_by(|a, b| a.at.total_cmp(&b.at));
    let (low, high) = match (seen.first(), seen.last()) {
        (Some(first), Some(last)) => (first.at, last.at),
        _ => (0.0, 0.0),
    };
    let width = ((high - low) / GATHERED as f64).max(f64::MIN_POSITIVE);
    let bin = |one: &Seen<'_>| (((one.at - low) / width) as usize).min(GATHERED - 1);
    let groups: Vec<&[Seen<'_>]> = seen.chunk_by(|a, b| bin(a) == bin(b)).collect();
    let points = groups.iter().map(|group| {
        let all: Vec<&Seen<'_>> = group.iter().collect();
        // Cells of different zeros and branches come together here: no branch is told.
        point(&all, Branch::Loading)
    });
    let values = &effect.effect.values;
    let curve = match effect.effect.law.figure.curve {
        Curve::Period { parameter, value_m } => one_period(values, parameter, value_m),
        Curve::Lines | Curve::Steps | Curve::Shape(_) => {
            groups.iter().map(|group| mean_of(group)).collect()
        }
    };
    LawPanel {
        heading: String::new(),
        points: points.collect(),
        curves: vec![LawCurve {
            name: "law as fitted".to_owned(),
            shape: CurveShape::Line,
            points: curve,
        }],
    }
}

/// A law over one period; nothing if the effect has none.
fn one_period(values: &[f64], period: usize, value_m: fn(&[f64], f64) -> f64) -> Vec<[f64; 2]> {
    let Some(period_m) = values.get(period) else {
        return Vec::new();
    };
    (0..=60)
        .map(|place| {
            let turn = f64::from(place) / 60.0;
            [turn * period_m, value_m(values, turn)]
        })
        .collect()
}

/// Means of where readings stand and of what the law does there.
fn mean_of(group: &[Seen<'_>]) -> [f64; 2] {
    let n = group.len().max(1) as f64;
    let at = group.iter().map(|one| one.at).sum::<f64>() / n;
    let change_m = group.iter().map(|one| one.change_m).sum::<f64>() / n;
    [at, change_m]
}

/// One panel of all readings along an axis: what each shows of the law over what the law does to it.
fn by_change(axis: Direction, seen: &[Seen<'_>]) -> Option<LawPanel> {
    let own = seen.iter().filter(|one| one.reading.cell.direction == axis);
    let points: Vec<LawPoint> = own.map(|one| point(&[one], Branch::Loading)).collect();
    let at = || points.iter().map(|point| point.at);
    let ends = [at().reduce(f64::min)?, at().reduce(f64::max)?];
    Some(LawPanel {
        heading: axis.to_string(),
        curves: vec![LawCurve {
            name: "law as fitted".to_owned(),
            shape: CurveShape::Line,
            points: ends.map(|end| [end, end]).to_vec(),
        }],
        points,
    })
}

/// One panel of a cell: the repeats of each load step together.
fn by_step(
    heading: String,
    effect: &EffectTrace,
    driving: DrivingQuantity,
    own: &[&Seen<'_>],
) -> LawPanel {
    let mut groups: Vec<Vec<&Seen<'_>>> = Vec::new();
    for one in own {
        let alike = |other: &Seen<'_>| {
            let (a, b) = (other.reading, one.reading);
            if driving == DrivingQuantity::Repeat {
                a.repeat == b.repeat
            } else {
                a.step == b.step && a.hold_number == b.hold_number && a.branch == b.branch
            }
        };
        match groups.iter_mut().find(|group| alike(group[0])) {
            Some(group) => group.push(one),
            None => groups.push(vec![one]),
        }
    }
    let key = |group: &[&Seen<'_>]| (group[0].reading.step, group[0].reading.hold_number);
    match driving {
        // The path of the load is the order of the steps: a loop is drawn as it was gone through.
        DrivingQuantity::Force => groups.sort_by_key(|group| key(group)),
        _ => groups.sort_by(|a, b| mean_at(a).total_cmp(&mean_at(b))),
    }
    let branch = |group: &[&Seen<'_>]| match driving {
        DrivingQuantity::Repeat => Branch::Loading,
        _ => group[0].reading.branch,
    };
    let means = groups.iter().map(|group| {
        let change_m = group.iter().map(|one| one.change_m).sum::<f64>() / group.len() as f64;
        [mean_at(group), change_m]
    });
    let means: Vec<[f64; 2]> = means.collect();
    let curve = effect.effect.law.figure.curve;
    let shape = match curve {
        Curve::Steps => CurveShape::Steps,
        Curve::Lines | Curve::Period { .. } | Curve::Shape(_) => CurveShape::Line,
    };
    LawPanel {
        heading,
        curves: vec![LawCurve {
            name: "law as fitted".to_owned(),
            shape,
            points: match curve {
                // Where what drives the law was not recorded the curve is drawn over the force.
                Curve::Shape(shape) if driving != DrivingQuantity::Force => {
                    between(&means, |at| shape(&effect.effect.values, at))
                }
                _ => means,
            },
        }],
        points: groups.iter().map(|g| point(g, branch(g))).collect(),
    }
}

/// A curve between means, its size that which fits them.
fn between(means: &[[f64; 2]], shape: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let [mut product, mut square] = [0.0; 2];
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &[at, change_m] in means {
        product += shape(at) * change_m;
        square += shape(at) * shape(at);
        (low, high) = (low.min(at), high.max(at));
    }
    if !(square > 0.0 && high > low) {
        return means.to_vec();
    }
    (0..=60)
        .map(|place| {
            let at = low + (high - low) * f64::from(place) / 60.0;
            [at, product / square * shape(at)]
        })
        .collect()
}

fn mean_at(group: &[&Seen<'_>]) -> f64 {
    group.iter().map(|one| one.at).sum::<f64>() / group.len() as f64
}

/// The mean of readings, each weighed by its precision.
fn point(group: &[&Seen<'_>], branch: Branch) -> LawPoint {
    let weight = |one: &&Seen<'_>| one.variance_m2.max(f64::MIN_POSITIVE).recip();
    let sum: f64 = group.iter().map(weight).sum();
    let shown = group.iter().map(|one| weight(one) * one.shown_m);
    LawPoint {
        at: mean_at(group),
        residual_m: shown.sum::<f64>() / sum,
        bar_m: Some(sum.sqrt().recip()),
        n: group.len(),
        branch,
        flagged: group.iter().any(|one| one.reading.flagged),
    }
}
