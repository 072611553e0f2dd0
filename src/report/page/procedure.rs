//! The procedure as it was done: what the readings show, and what the session records of how they were taken.

use indexmap::{IndexMap, IndexSet};

use crate::count::counted;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{LoadOrder, ProcedureRecord, Reading, ReadingTable, RepeatOrder, ZeroScope};

use super::session::as_stated;
use crate::test_point::Branch;

/// So many names or loads are listed; more are counted.
const LISTED: usize = 12;

/// The procedure as it was done; `None` without readings that count.
pub(super) fn as_done(record: Option<&ProcedureRecord>, table: &ReadingTable) -> Option<String> {
    let taken = || table.one_of_each_load().filter(|one| one.is_accepted());
    let poses: IndexSet<&str> = taken().map(|one| one.pose.as_str()).collect();
    let directions: IndexSet<String> = taken().map(|one| table.load_name(one)).collect();
    if poses.is_empty() {
        return None;
    }
    let mut parts = vec![
        format!(
            "{}, loaded along {}",
            named(&poses, "pose"),
            joined(&directions)
        ),
        loads(&targets(taken())),
        times(record, taken().map(|one| (one, table.load_name(one)))),
    ];
    let on = |branch| targets(taken().filter(move |one| one.branch == branch));
    let (loading, unloading) = (on(Branch::Loading), on(Branch::Unloading));
    parts.push(match unloading.as_slice() {
        [] => "read while loading".to_owned(),
        [one] if loading.len() > 1 => format!(
            "read while loading, and at {} N after unloading",
            as_stated(*one, 1.0)
        ),
        _ => "read while loading and unloading".to_owned(),
    });
    parts.extend(record.into_iter().flat_map(how));
    Some(parts.join("; "))
}

fn joined(names: &IndexSet<String>) -> String {
    names
        .iter()
        .map(String::as_str)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Names with their number; of many the number alone.
fn named(names: &IndexSet<&str>, what: &str) -> String {
    let count = counted(names.len(), what);
    if names.len() > LISTED {
        return count;
    }
    let names: Vec<&str> = names.iter().copied().collect();
    format!("{count} ({})", names.join(", "))
}

/// Different target loads, N, in the order in which they came.
fn targets<'r>(taken: impl Iterator<Item = &'r Reading>) -> Vec<f64> {
    let mut loads: Vec<f64> = Vec::new();
    for reading in taken {
        if !loads.contains(&reading.target_n) {
            loads.push(reading.target_n);
        }
    }
    loads
}

fn loads(loads: &[f64]) -> String {
    let words = |load: f64| as_stated(load, 1.0);
    if loads.len() > LISTED {
        let ends = [f64::min, f64::max].map(|end: fn(f64, f64) -> f64| {
            words(loads.iter().copied().reduce(end).unwrap_or(0.0))
        });
        return format!(
            "{} from {} to {} N",
            counted(loads.len(), "load"),
            ends[0],
            ends[1]
        );
    }
    let each: Vec<String> = loads.iter().copied().map(words).collect();
    format!("loads {} N", each.join(", "))
}

/// How often each load was applied.
fn times<'r>(
    record: Option<&ProcedureRecord>,
    taken: impl Iterator<Item = (&'r Reading, String)>,
) -> String {
    let mut repeats: IndexMap<(&str, String), IndexSet<u32>> = IndexMap::new();
    for (reading, load) in taken {
        let own = repeats.entry((reading.pose.as_str(), load)).or_default();
        own.insert(reading.repeat);
    }
    let counts = || repeats.values().map(IndexSet::len);
    let (fewest, most) = (counts().min().unwrap_or(0), counts().max().unwrap_or(0));
    let count = if fewest == most {
        counted(most, "time")
    } else {
        format!("{fewest} to {}", counted(most, "time"))
    };
    match record.and_then(|record| record.repeat_order) {
        Some(RepeatOrder::AtLoad) => format!("each load {count}, released in between"),
        Some(RepeatOrder::Sweep) | None => format!("the sequence of loads {count}"),
    }
}

/// What a session records of how its readings are taken.
fn how(record: &ProcedureRecord) -> Vec<String> {
    let settle = &record.settle;
    let um = |metres: f64| as_stated(metres, METRES_PER_MICROMETRE);
    let parts = [
        (record.load_order == Some(LoadOrder::Shuffled))
            .then(|| "loads in random order".to_owned()),
        record.zero.map(|zero| match zero {
            ZeroScope::Cell => "gauge zeroed for each pose and direction".to_owned(),
            ZeroScope::Run => "gauge zeroed before each run".to_owned(),
        }),
        record
            .preload_n
            .map(|one| format!("contact force {} N", as_stated(one, 1.0))),
        (settle.force_tolerance_n)
            .map(|one| format!("force within {} N of the load", as_stated(one, 1.0))),
        settle.dwell_s.zip(settle.spread_m).map(|(dwell, spread)| {
            let slope = settle.slope_m_per_s;
            let slope = slope.map_or_else(String::new, |one| {
                format!(", drifting by less than {} µm/s", um(one))
            });
            format!(
                "displacement steady for {} s within {} µm{slope}",
                as_stated(dwell, 1.0),
                um(spread)
            )
        }),
        (!record.holds_s.is_empty()).then(|| {
            let holds: Vec<String> = record
                .holds_s
                .iter()
                .map(|one| as_stated(*one, 1.0))
                .collect();
            format!("largest load held and read after {} s", holds.join(", "))
        }),
    ];
    parts.into_iter().flatten().collect()
}
