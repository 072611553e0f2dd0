//! How much of the measured loop between loading and unloading the found laws give.

use indexmap::IndexMap;

use crate::analysis::DiagnosisReport;
use crate::mismatch::ReadingTrace;
use crate::readings::{Reading, ReadingStatus};
use crate::stiffness::{GaugePair, Hysteresis, LoopWidth};
use crate::test_point::Cell;

use super::answer::phrase_of;
use super::page::capital;

/// Share of the width of a loop below which a law is not said to give any of it (1): less than a percent would be printed as nothing. Stated.
const SAID: f64 = 0.01;

/// Where the loop is widest beyond doubt, and what each found law gives of its width there; `None` where no loop is beyond doubt, or no law has one.
pub(super) fn loop_words(report: &DiagnosisReport) -> Option<String> {
    let traced = &report.trace.readings;
    let mut cells: IndexMap<&Cell, Vec<usize>> = IndexMap::new();
    for (place, reading) in traced.iter().enumerate().filter(|(_, one)| !one.flagged) {
        cells.entry(&reading.cell).or_default().push(place);
    }
    let measured = |place: usize| traced[place].displacement_m;
    let loops = cells.iter().filter_map(|(cell, places)| {
        let found = loop_of(cell, traced, places, measured)?;
        let [low, high] = found.largest.interval_m?;
        // A force that lags behind a displacement that was set is smaller on the way back.
        let least = low.max(-high);
        (least > 0.0).then_some((*cell, places, found.largest, least))
    });
    let (widest, places, largest, _) = loops.max_by(|a, b| a.3.total_cmp(&b.3))?;
    let known = report.diagnosis.known_effects.len();
    let given = report
        .trace
        .effects
        .iter()
        .skip(known)
        .filter_map(|effect| {
            let found = loop_of(widest, traced, places, |place| effect.change_m[place])?;
            let is_there = |width: &&LoopWidth| width.target_n == largest.target_n;
            let width_m = found.widths.iter().find(is_there)?.width_m.value;
            // The lag of the effect alone has the sign of the effect, which may act against the load.
            let width_m = width_m.abs();
            let mut findings = report.diagnosis.findings.iter();
            let finding = findings.find(|one| {
                one.effect.law == effect.effect.law && one.effect.place == effect.effect.place
            })?;
            let phrase = phrase_of(finding);
            let width = report.subject.reading(width_m);
            (width_m >= SAID * largest.width_m.abs())
                .then(|| format!("{phrase} gives {width} of it"))
        });
    let given: Vec<String> = given.collect();
    if given.is_empty() {
        return None;
    }
    let width = report.subject.reading(largest.width_m.abs());
    let load = report.subject.load(largest.target_n);
    let single_part = report.is_of_part() && cells.len() == 1;
    let place = if single_part {
        String::new()
    } else {
        format!("in {widest} ")
    };
    Some(format!(
        "The loop between loading and unloading is widest {place}at {load}: {width}. {}.",
        capital(&given.join("; "))
    ))
}

/// The loop of some readings of a cell with other displacements, m.
fn loop_of(
    cell: &Cell,
    traced: &[ReadingTrace],
    places: &[usize],
    displacement_m: impl Fn(usize) -> f64,
) -> Option<Hysteresis> {
    let reading = |place: &usize| {
        let ReadingTrace {
            cell,
            repeat,
            branch,
            step,
            zero,
            line,
            target_n,
            force_n,
            ..
        } = &traced[*place];
        Reading {
            line: *line,
            seq: *place as u32,
            pose: cell.pose.clone(),
            direction: cell.direction,
            load: None,
            branch: *branch,
            step: *step,
            repeat: *repeat,
            attempt: 1,
            run: *zero,
            zero: *zero,
            status: ReadingStatus::Accepted,
            target_n: *target_n,
            force_n: *force_n,
            displacement_m: displacement_m(*place),
            time_s: None,
            hold_s: None,
            temperature_deg_c: None,
            text: None,
        }
    };
    let readings: Vec<Reading> = places.iter().map(reading).collect();
    let readings: Vec<&Reading> = readings.iter().collect();
    Hysteresis::of(cell, &readings, &GaugePair::default())
}
