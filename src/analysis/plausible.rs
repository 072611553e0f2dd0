//! Results that are no error and hardly meant: each with its number and the likely cause.

use jiff::civil::Date;

use crate::count::counted;
use crate::digits::significant;
use crate::fit::FitOutcome;
use crate::fit::{PosedLoad, PosedLoadCases, ReadComponent};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{Reading, ReadingTable, SessionHeader};
use crate::stiffness::{Method, StiffnessTable};

/// Stiffness of robots at the tool, N/m: 1 N/mm yields under a finger; serial arms reach some N/um, and 10 N/um only parallel machines.
/// A displacement in mm that is taken for um makes a usual arm a thousand times too stiff, and it falls out of this range.
const STIFFNESS_N_PER_M: [f64; 2] = [1e3, 1e7];

/// Stiffness of joints about their axis, N·m/rad: a hobby servo holds 10, the gears of the heaviest arms some 10^7.
const JOINT_NM_PER_RAD: [f64; 2] = [10.0, 1e9];

/// A load case that gives, for its force, so many times what three quarters of them stay below has another unit or a slip of the pen.
const FAR_FROM_USUAL: f64 = 100.0;

/// A model that leaves so much of the displacements, root mean square, explains nothing.
const UNEXPLAINED: f64 = 0.95;

/// Loads are set, displacements follow: across cells the largest force varies less than this, relative.
const SET: f64 = 0.05;

/// And the largest displacement varies more than this.
const FOLLOWS: f64 = 0.3;

/// A scatter between runs so uneven is in one session of twenty by chance.
const UNEVEN_P: f64 = 0.05;

/// Residuals so many times what the scatter explains are no chance.
const FAR_OUTSIDE: f64 = 10.0;

/// A model that errs by more than this explains the stiffness badly, percent.
const BAD_FIT_PERCENT: f64 = 10.0;

/// No measurement takes longer: a time so far from the others has another unit, or is a slip of the pen, s.
const LONGEST_S: f64 = 366.0 * 86_400.0;

/// Doubts about single readings: beyond the range of their gauge, at a time that cannot be.
pub(super) fn doubts_about_readings(
    table: &ReadingTable,
    header: Option<&SessionHeader>,
    today: Option<Date>,
) -> Vec<String> {
    let far = |what: String, mut values: Vec<(String, u32)>| {
        // Of several gauges the readings of a load are on one line.
        values.dedup_by_key(|(_, line)| *line);
        let (value, line) = values.first()?;
        let count = counted(values.len(), "reading");
        Some(format!("{count} {what} (first {value} in line {line})"))
    };
    let mut odd = Vec::new();
    for (name, record) in header.iter().flat_map(|header| header.instruments.named()) {
        let Some(range) = record.range else { continue };
        let is_force = name == "force gauge";
        let (unit, per_si) = if is_force { ("N", 1.0) } else { ("mm", 1e3) };
        let is_of_it = |reading: &&Reading| {
            let along = reading.direction.to_string();
            !name.contains(" along ") || name.ends_with(&along)
        };
        let beyond = table.accepted().filter(is_of_it).filter_map(|reading| {
            let value = if is_force {
                reading.force_n
            } else {
                reading.displacement_m
            };
            let shown = || format!("{} {unit}", significant(value * per_si, 4));
            (value.abs() > range).then(|| (shown(), reading.line))
        });
        let what = format!(
            "beyond the range of the {name}, {} {unit}: check the unit, and the record of the gauge",
            significant(range * per_si, 4)
        );
        odd.extend(far(what, beyond.collect()));
    }
    let timed = || {
        table
            .accepted()
            .filter_map(|reading| Some((reading.time_s?, reading.line)))
    };
    let mut times: Vec<f64> = timed().map(|(time_s, _)| time_s).collect();
    times.sort_by(f64::total_cmp);
    if let Some(middle_s) = times.get(times.len() / 2) {
        let late = timed().filter(|(time_s, _)| (time_s - middle_s).abs() > LONGEST_S);
        let late = late.map(|(time_s, line)| (format!("{time_s:e} s"), line));
        odd.extend(far(
            "more than a year from the others: check their time".to_owned(),
            late.collect(),
        ));
    }
    // A day more, for the time zones.
    if let Some(last) = today
        .and_then(|today| today.tomorrow().ok())
        .map(|day| day.to_string())
    {
        let dated = table
            .accepted()
            .filter_map(|reading| Some((reading.text.as_ref()?, reading.line)));
        let ahead = dated.filter_map(|(text, line)| {
            let day = text.utc.get(..10)?;
            (day > last.as_str()).then(|| (day.to_owned(), line))
        });
        odd.extend(far(
            "after today: check the clock, or the date".to_owned(),
            ahead.collect(),
        ));
    }
    odd
}

/// Doubts about readings that were taken for force and displacement.
#[must_use]
pub fn doubts_about_stiffness(table: &StiffnessTable) -> Vec<String> {
    let mut odd = Vec::new();
    let mut values: Vec<f64> = table
        .cells
        .iter()
        .filter_map(|row| Some(row.by(Method::Regression).ok()?.estimate.value))
        .collect();
    if values.is_empty() {
        return odd;
    }
    values.sort_by(f64::total_cmp);
    let median = values[values.len() / 2];
    if median < 0.0 {
        odd.push(
            "force and displacement have opposite signs in most cells: turn the sign of one of the gauges".to_owned(),
        );
    }
    let size = median.abs();
    if !(STIFFNESS_N_PER_M[0]..=STIFFNESS_N_PER_M[1]).contains(&size) {
        odd.push(format!(
            "the stiffness of the middle cell is {} N/µm, and robots have {} to {}: {}",
            significant(size * METRES_PER_MICROMETRE, 4),
            STIFFNESS_N_PER_M[0] * METRES_PER_MICROMETRE,
            STIFFNESS_N_PER_M[1] * METRES_PER_MICROMETRE,
            guessed_units(size)
        ));
    }
    odd.extend(ratios_that_differ(table));
    let spoiled = table.cells.iter().filter_map(|row| {
        let mut flags = row.flags.iter();
        Some((&row.cell, flags.find(|flag| flag.spoils_stiffness())?))
    });
    if let Some((cell, flag)) = spoiled.clone().next() {
        odd.push(format!(
            "K is in doubt in {} of {} cells (first {cell}: {}): their flags give the reasons",
            spoiled.count(),
            table.cells.len(),
            flag.rule
        ));
    }
    if let Some(run_slope) = &table.run_slope
        && let Some(p) = run_slope.evenness_p.filter(|p| *p < UNEVEN_P)
    {
        odd.push(format!(
            "the scatter between runs is not the same in all cells (Bartlett's test, p = {p:.1e}); a fit assumes that it is, so that cells with more scatter weigh too much: check them for loose parts, or repeat them"
        ));
    }
    let largest = |of: fn(&crate::stiffness::LoadMean) -> f64| -> Vec<f64> {
        let cells = table.cells.iter();
        cells
            .map(|row| {
                row.loads
                    .iter()
                    .map(|load| of(load).abs())
                    .fold(0.0, f64::max)
            })
            .collect()
    };
    let forces = largest(|load| load.force_n.mean);
    let displacements = largest(|load| load.displacement_m.mean);
    if let (Some(force), Some(displacement)) = (variation(&forces), variation(&displacements))
        && displacement < SET
        && force > FOLLOWS
    {
        odd.push(format!(
            "the largest displacement is nearly the same in all cells and the largest force differs by {:.0} %: are the two columns exchanged?",
            100.0 * force
        ));
    }
    odd
}

/// Which units may be mistaken where a stiffness, N/m, is out of range: too soft, the number of the displacement is too large or that of the force
/// too small; too stiff, the other way round.
fn guessed_units(stiffness_n_per_m: f64) -> &'static str {
    if stiffness_n_per_m < STIFFNESS_N_PER_M[0] {
        "are displacements in µm taken for mm, or forces in kN for N?"
    } else {
        "are displacements in mm taken for µm, or forces in N for kN?"
    }
}

/// Cells in which force over displacement and the slope differ by more than their uncertainties: the displacement does not count from the
/// unloaded gauge, or loads are near zero.
fn ratios_that_differ(table: &StiffnessTable) -> Option<String> {
    /// A smaller difference matters to nobody.
    const SHARE: f64 = 0.02;
    let estimate = |row: &crate::stiffness::CellStiffness, method| {
        let found = row.by(method).ok()?;
        Some((found.estimate.value, found.estimate.expanded_95()?))
    };
    let differ: Vec<(String, f64, f64)> = table
        .cells
        .iter()
        .filter_map(|row| {
            let (slope, of_slope) = estimate(row, Method::Regression)?;
            let (ratio, of_ratio) = estimate(row, Method::PaperMean)?;
            let apart = (slope - ratio).abs();
            (apart > of_slope.hypot(of_ratio).max(SHARE * slope.abs()))
                .then(|| (row.cell.to_string(), slope, ratio))
        })
        .collect();
    let (cell, slope, ratio) = differ.first()?;
    Some(format!(
        "in {} of {} cells the mean of F/d and the slope differ by more than 2 % and more than their uncertainties (first {cell}: {} and {} N/µm): the displacement counts from a preload, loads are near zero, or the loads do not lie on a straight line; an offset does not enter the slope",
        differ.len(),
        table.cells.len(),
        significant(ratio * METRES_PER_MICROMETRE, 4),
        significant(slope * METRES_PER_MICROMETRE, 4)
    ))
}

/// Doubts about a model that was fitted.
#[must_use]
pub fn doubts_about_fit(outcome: &FitOutcome) -> Vec<String> {
    let mut odd = Vec::new();
    let agreement = outcome.agreement.as_ref();
    let agreement = agreement.and_then(|agreement| agreement.reduced_chi_squared);
    let times = agreement.map_or(0.0, f64::sqrt);
    if times > FAR_OUTSIDE {
        odd.push(format!(
            "the residuals are {times:.0} times what the scatter explains: `stiffbench diagnose` with the readings shows what the model leaves out"
        ));
    }
    let error = outcome
        .max_error_percent()
        .filter(|error| *error > BAD_FIT_PERCENT);
    if let Some(error) = error {
        odd.push(format!(
            "the model misses a measured stiffness by {error:.0} %: `stiffbench diagnose` with the readings shows what it leaves out"
        ));
    }
    odd
}

/// Doubts about displacements that were read under forces; none of absolute positions.
fn doubts_about_load_cases(posed: &PosedLoadCases) -> Vec<String> {
    let mut odd = Vec::new();
    let cases = posed.cases.iter();
    let compliances: Vec<(&PosedLoad, f64)> = cases
        .filter_map(|case| Some((case, compliance_m_per_n(case)?)))
        .collect();
    let mut sorted: Vec<f64> = compliances.iter().map(|(_, c)| *c).collect();
    sorted.sort_by(f64::total_cmp);
    // Where single gauges read across the force, most displacements are small.
    let Some(&usual) = sorted.get(3 * sorted.len() / 4) else {
        return odd;
    };
    let place = |case: &PosedLoad| {
        let read = case.components.iter().filter(|one| !one.is_rotation());
        let largest = read.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        let column = largest
            .map_or("displacement", |one| one.name())
            .replace(' ', "_");
        format!(
            "line {}, pose {}: {column}",
            case.line, posed.labels[case.label]
        )
    };
    let stiffness = 1.0 / usual;
    let [low, high] = STIFFNESS_N_PER_M;
    if !(low..=high).contains(&stiffness) {
        let case = compliances.iter().find(|(_, c)| *c == usual);
        let place = case.map_or_else(String::new, |(case, _)| place(case));
        let guess = guessed_units(stiffness);
        odd.push(format!(
            "{place}: force over displacement is {} N/µm, and about that in the other lines; expected {} to {}: {guess} The name of a column states its unit",
            significant(stiffness * METRES_PER_MICROMETRE, 4),
            significant(low * METRES_PER_MICROMETRE, 1),
            significant(high * METRES_PER_MICROMETRE, 1)
        ));
    }
    let far = compliances
        .iter()
        .filter(|(_, c)| *c > FAR_FROM_USUAL * usual);
    for (case, c) in far {
        odd.push(format!(
            "{} is, for its force, {:.0} times what is usual in this table: check its unit and its decimal point",
            place(case),
            c / usual
        ));
    }
    let against = compliances
        .iter()
        .filter(|(case, _)| work_nm(case) < 0.0)
        .count();
    if 2 * against > compliances.len() {
        odd.push(format!(
            "in {against} of {} load cases the tool moved against the force: turn the sign of forces or displacements",
            compliances.len()
        ));
    }
    odd
}

/// Length of the displacement over that of the force, where all that was applied is a force.
fn compliance_m_per_n(case: &PosedLoad) -> Option<f64> {
    let moment = case.load[3..].iter().any(|moment| *moment != 0.0);
    let read = case.components.iter();
    if moment || read.clone().any(ReadComponent::is_position) {
        return None;
    }
    let displacements = read.filter(|one| !one.is_rotation());
    let squares: f64 = displacements.map(|one| one.value * one.value).sum();
    (squares > 0.0).then(|| squares.sqrt() / case.force_n())
}

/// Force times displacement: of an elastic robot not below zero if all components were read.
fn work_nm(case: &PosedLoad) -> f64 {
    let displacements = case.components.iter().filter(|one| !one.is_rotation());
    displacements
        .map(|one| {
            let along: f64 = one.unit.iter().zip(&case.load).map(|(u, f)| u * f).sum();
            along * one.value
        })
        .sum()
}

/// Doubts about load cases and about a model that was fitted to them.
#[must_use]
pub fn doubts_about_load_case_fit(posed: &PosedLoadCases, fit: &FitOutcome) -> Vec<String> {
    let mut odd = doubts_about_load_cases(posed);
    let [low, high] = JOINT_NM_PER_RAD;
    let turns = |unit: &str| unit == "rad/(N*m)";
    let mut joints = fit.estimates.iter().filter(|one| {
        one.parameter.joint().is_some() && turns(one.parameter.unit()) && one.value > 0.0
    });
    // A spring that may be rigid says nothing.
    let odd_one = joints.find(|one| {
        one.interval_95
            .is_some_and(|[least, most]| least > 1.0 / low || (least > 0.0 && most < 1.0 / high))
    });
    if let Some(one) = odd_one {
        let read = fit.components.iter().filter(|one| !one.is_rotation);
        let largest = read.max_by(|a, b| a.measured.abs().total_cmp(&b.measured.abs()));
        let place = largest.map_or_else(String::new, |read| {
            format!(
                "; the largest is {} in line {}",
                read.component.replace(' ', "_"),
                read.line
            )
        });
        odd.push(format!(
            "{} has {} N·m/rad, joints of robots {low} to {high:e}: check the units of forces and displacements{place}",
            one.name,
            significant(1.0 / one.value, 4)
        ));
    }
    let read = fit.components.iter();
    let read: Vec<f64> = read
        .filter(|one| !one.is_rotation && !one.held_out)
        .map(|one| one.measured * one.measured)
        .collect();
    let measured = crate::statistics::mean(&read).unwrap_or_default().sqrt();
    if let [_, Some(fitted), _] = fit.rms_m()
        && fit.frames.is_none()
        && fitted > UNEXPLAINED * measured
    {
        odd.push(format!(
            "the model explains hardly anything: {:.1} µm are left of displacements of {:.1} µm. Are signs, axes and joint values right, and the loads large enough?",
            fitted / METRES_PER_MICROMETRE,
            measured / METRES_PER_MICROMETRE
        ));
    }
    odd
}

/// Standard deviation over mean, from three values on.
fn variation(values: &[f64]) -> Option<f64> {
    let mean = crate::statistics::mean(values).filter(|mean| *mean > 0.0)?;
    let enough = values.len() >= 3;
    crate::statistics::standard_deviation(values)
        .filter(|_| enough)
        .map(|sd| sd / mean)
}
