//! The noise of a diagnosis, and where it comes from.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, Table};

use crate::analysis::{DiagnosisReport, EarlierSession, NoiseOrigin};
use crate::mismatch::{NoiseBasis, ReadingNoise};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::report::text::{significant, unit_behind};
use crate::statistics::chi_squared_quantile;

use super::is_known;
use super::summary::SiValue;
use super::units::um_shown;
use crate::count::{counted, degrees_of_freedom};

/// The noise, and where it comes from.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NoiseReport {
    /// Its standard deviations.
    #[serde(flatten)]
    pub deviations: NoiseDeviations,
    /// Where they come from: `estimated`: repeats, or neighbours in long runs; `fit`: what the model leaves, nothing being repeated; `stated` with the
    /// data; `records` or `earlier-sessions`.
    pub source: Cow<'static, str>,
    /// What each earlier session showed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub earlier: Option<Vec<EarlierReport>>,
    /// All its parts.
    pub components: Vec<NoiseComponent>,
    /// Root mean square that noise alone would leave, µm; `null` of readings that are no lengths.
    pub floor_rms_um: Option<f64>,
}

/// A part of the noise. Parts that not every bench has are there where the readings ask for them.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NoiseComponent {
    /// `white`: standard deviation of a reading without the step of its gauge. `resolution`: that of the step. `zero`: that of a gauge zero.
    /// `slope`: relative standard deviation of the slope of a run. `growth`: standard deviation of a reading as a share of its displacement.
    /// `ar1`: correlation of the scatter of a reading with that of the one before it in its run. `tails`: degrees of freedom of Student's t.
    /// Of several gauges that were read at once: `white-x`, `white-y`, `white-z`: standard deviation of a reading of the gauge along that axis, the
    /// step included; `slope-of-gauge`: that of the slope that a run has in one gauge alone; `force`: that of the force of a reading.
    pub name: Cow<'static, str>,
    /// The value in `unit`.
    pub value: f64,
    /// ASCII unit.
    pub unit: String,
    /// 95 % interval; `null` where the value is given, or the nearest of a few that were tried.
    pub ci95: Option<[f64; 2]>,
}

/// Standard deviations of the noise of readings.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NoiseDeviations {
    /// Of a reading, the step of its gauge included.
    pub reading_sd: NoiseDeviation,
    /// Of a gauge zero.
    pub zero_sd: NoiseDeviation,
    /// Of the slope of a run, relative.
    pub run_slope_sd: NoiseDeviation,
}

/// A standard deviation.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NoiseDeviation {
    /// The value in `unit`.
    pub value: f64,
    /// ASCII unit.
    pub unit: String,
    /// Degrees of freedom; `null` of one that was given.
    pub dof: Option<f64>,
    /// Why there are no degrees of freedom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Cow<'static, str>>,
    /// The same in SI, of the readings of a part; as in the file where its table has no units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub si: Option<SiValue>,
}

/// The noise of an earlier session.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct EarlierReport {
    /// Its standard deviations.
    #[serde(flatten)]
    pub deviations: NoiseDeviations,
    /// Name of the session.
    pub session: String,
    /// Chance that two sessions with the same noise differ as much.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_same: f64,
    /// Whether it counts; one that scatters otherwise does not.
    pub used: bool,
}

impl From<&DiagnosisReport> for NoiseReport {
    fn from(report: &DiagnosisReport) -> Self {
        let diagnosis = &report.diagnosis;
        let (source, earlier) = match &report.noise_origin {
            NoiseOrigin::Readings if diagnosis.noise_basis == NoiseBasis::Fit => ("fit", None),
            NoiseOrigin::Readings => ("estimated", None),
            NoiseOrigin::Stated => ("stated", None),
            NoiseOrigin::Records => ("records", None),
            NoiseOrigin::EarlierSessions(sessions) => {
                let sessions = sessions.iter().map(Into::into).collect();
                ("earlier-sessions", Some(sessions))
            }
        };
        let mut noise = diagnosis.noise;
        if report.observations.free_zeros {
            // A zero that may be anything is not noise.
            noise.zero_sd_m = 0.0;
        }
        let mut deviations =
            NoiseDeviations::new(&noise, diagnosis.noise_dof, report.subject.reading_unit());
        deviations.reading_sd.si = report
            .subject
            .in_table(noise.reading_sd_m)
            .map(|one| one.si);
        Self {
            deviations,
            source: source.into(),
            earlier,
            components: components(report),
            floor_rms_um: report.subject.micrometres(report.noise_floor_m()),
        }
    }
}

/// The parts of the noise of a diagnosis.
fn components(report: &DiagnosisReport) -> Vec<NoiseComponent> {
    let (diagnosis, noise) = (&report.diagnosis, &report.diagnosis.noise);
    let (si, unit) = report.subject.reading_unit();
    let unit = unit.as_str();
    let step_sd = report.observations.steps.displacement_m.unwrap_or(0.0) / si / 12.0_f64.sqrt();
    let without_step = |reading: f64| (reading.powi(2) - step_sd.powi(2)).max(0.0).sqrt();
    let [reading, zero, slope] = diagnosis.noise_dof;
    let reading_sd = noise.reading_sd_m / si;
    let zero_sd = noise.zero_sd_m / si;
    let part = |name: &'static str, value, unit: &str, ci95| NoiseComponent {
        name: name.into(),
        value,
        unit: unit.to_owned(),
        ci95,
    };
    let of_reading = interval(reading_sd, reading).map(|ends| ends.map(without_step));
    let mut all = vec![part("white", without_step(reading_sd), unit, of_reading)];
    if step_sd > 0.0 {
        all.push(part("resolution", step_sd, unit, None));
    }
    // Zeros that may be anything are not noise.
    if !report.observations.free_zeros {
        all.push(part("zero", zero_sd, unit, interval(zero_sd, zero)));
    }
    let run_slope = noise.run_slope_sd;
    all.push(part("slope", run_slope, "1", interval(run_slope, slope)));
    let [growth, correlation] = diagnosis.further_noise;
    if growth.is_some() {
        all.push(part("growth", noise.growth_sd, "1", growth));
    }
    if correlation.is_some() {
        all.push(part("ar1", noise.correlation, "1", correlation));
    }
    let gauges = &noise.gauges;
    for axis in &report.observations.gauges {
        let name = ["white-x", "white-y", "white-z"][axis.index()];
        let of_gauge = reading_sd * gauges.reading_ratios[axis.index()];
        all.push(part(name, of_gauge, unit, None));
    }
    if gauges.own_slope_sd > 0.0 {
        all.push(part("slope-of-gauge", gauges.own_slope_sd, "1", None));
    }
    if gauges.force_sd_n > 0.0 {
        all.push(part("force", gauges.force_sd_n, "N", None));
    }
    let tails = report.tails_dof.map(|dof| part("tails", dof, "1", None));
    all.extend(tails);
    all
}

/// 95 % interval of a standard deviation; none of one that was given.
fn interval(deviation: f64, dof: f64) -> Option<[f64; 2]> {
    if is_known(dof) {
        return None;
    }
    let end = |p| Some(deviation * (dof / chi_squared_quantile(p, dof)?).sqrt());
    Some([end(0.975)?, end(0.025)?])
}

impl From<&EarlierSession> for EarlierReport {
    fn from(earlier: &EarlierSession) -> Self {
        let noise = &earlier.noise;
        Self {
            deviations: NoiseDeviations::new(
                &noise.noise(),
                noise.degrees_of_freedom(),
                (METRES_PER_MICROMETRE, "um".to_owned()),
            ),
            session: earlier.name.clone(),
            p_same: earlier.chance,
            used: earlier.used,
        }
    }
}

impl NoiseDeviations {
    /// # Arguments
    /// - `unit`: SI units in one of the readings' unit, and its name.
    fn new(
        noise: &ReadingNoise,
        [reading, zero, slope]: [f64; 3],
        (si, unit): (f64, String),
    ) -> Self {
        let one = |value: f64, unit: &str, dof: f64| NoiseDeviation {
            value,
            unit: unit.to_owned(),
            dof: (!is_known(dof)).then_some(dof),
            reason: is_known(dof).then_some("given, not estimated".into()),
            si: None,
        };
        Self {
            reading_sd: one(noise.reading_sd_m / si, &unit, reading),
            zero_sd: one(noise.zero_sd_m / si, &unit, zero),
            run_slope_sd: one(noise.run_slope_sd, "1", slope),
        }
    }
}

/// The standard deviations of the noise; where earlier sessions tell them too, a table of what each told.
pub(super) fn noise_text(noise: &NoiseReport) -> Document {
    let mut document = Document::new();
    if let Some(sessions) = &noise.earlier {
        document.append(noise_table(&noise.deviations, sessions));
    } else {
        document.paragraph(noise_sentence(&noise.deviations));
    }
    document.paragraphs(noise.components.iter().filter_map(further_part));
    document
}

/// What a part says that not every bench has.
fn further_part(part: &NoiseComponent) -> Option<String> {
    let between = |printed: &dyn Fn(f64) -> String| {
        let ends = part.ci95.map(|[low, high]| (printed(low), printed(high)));
        ends.map_or_else(String::new, |(low, high)| format!(" ({low} to {high})"))
    };
    let plain = |value: f64| significant(value, 2);
    match &*part.name {
        "white-x" | "white-y" | "white-z" => Some(format!(
            "A reading of the gauge along {} scatters by {}.",
            &part.name["white-".len()..],
            deviation(part.value, &part.unit)
        )),
        "slope-of-gauge" => Some(format!(
            "The slope of a run scatters by {} % in each gauge separately.",
            percent(part.value)
        )),
        "force" => Some(format!(
            "The force of a reading scatters by {} N, which moves all gauges at once.",
            plain(part.value)
        )),
        "growth" => Some(format!(
            "The scatter of a reading grows with its displacement, by {} %{} of it.",
            percent(part.value),
            between(&percent)
        )),
        "ar1" => Some(format!(
            "The scatter of a reading is correlated with that of the reading before it in its run: {}{}.",
            plain(part.value),
            between(&plain)
        )),
        "tails" => Some(format!(
            "Readings have longer tails than normal errors: Student's t with {}.",
            counted(plain(part.value), "degree of freedom")
        )),
        _ => None,
    }
}

fn noise_sentence(noise: &NoiseDeviations) -> String {
    let dof = |of: &NoiseDeviation| {
        of.dof
            .map_or_else(|| "given".to_owned(), degrees_of_freedom)
    };
    // Of one load in each run nobody can tell the zero.
    let zero = if noise.zero_sd.value > 0.0 {
        let NoiseDeviation { value, unit, .. } = &noise.zero_sd;
        format!(
            ", gauge zero {} ({})",
            deviation(*value, unit),
            dof(&noise.zero_sd)
        )
    } else {
        String::new()
    };
    format!(
        "Noise, standard deviations: reading {} ({}){zero}, slope of a run {} % ({}).",
        deviation(noise.reading_sd.value, &noise.reading_sd.unit),
        dof(&noise.reading_sd),
        percent(noise.run_slope_sd.value),
        dof(&noise.run_slope_sd)
    )
}

fn noise_table(together: &NoiseDeviations, sessions: &[EarlierReport]) -> Document {
    let each = sessions.iter().map(|one| {
        let counts = if one.used { "yes" } else { "no" };
        let same = significant(one.p_same, 2);
        (&*one.session, &one.deviations, same, counts)
    });
    let rows = each.chain([("together", together, String::new(), "")]);
    let dof = |of: &NoiseDeviation| {
        of.dof
            .map_or_else(|| "given".to_owned(), |dof| format!("{dof:.0}"))
    };
    let with_dof = |of: &NoiseDeviation| [significant(of.value, 2), dof(of)];
    let head = "Noise: standard deviations with their degrees of freedom (dof) of the earlier sessions, and pooled with this session. p same: probability that two sessions with the same noise differ this much.";
    let mut document = Document::of(head);
    document.table(
        Table::of(rows)
            .words("noise estimated from", |(name, ..)| *name)
            .numbers_each(["reading, µm", "dof"], |(_, noise, ..)| {
                with_dof(&noise.reading_sd)
            })
            .numbers_each(["gauge zero, µm", "dof"], |(_, noise, ..)| {
                with_dof(&noise.zero_sd)
            })
            .numbers("run slope, %", |(_, noise, ..)| {
                percent(noise.run_slope_sd.value)
            })
            .numbers("dof", |(_, noise, ..)| dof(&noise.run_slope_sd))
            .numbers("p same", |(_, _, same, _)| same.clone())
            .words("counts", |(.., counts)| *counts),
    );
    document
}

/// A standard deviation with its unit.
fn deviation(value: f64, unit: &str) -> String {
    match unit {
        "um" => um_shown(value),
        unit => significant(value, 3) + &unit_behind(unit),
    }
}

fn percent(share: f64) -> String {
    significant(100.0 * share, 2)
}
