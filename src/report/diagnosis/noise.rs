//! The noise of a diagnosis, and where it comes from.

use serde_json::{Value, json};

use crate::analysis::{DiagnosisReport, EarlierSession, NoiseOrigin};
use crate::mismatch::ReadingNoise;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::report::{AlignedTable, significant};

use super::phrases::{paragraph, um};
use super::{finite, is_known};

/// The standard deviations of the noise, and where they come from.
pub(super) fn noise_json(report: &DiagnosisReport) -> Value {
    let diagnosis = &report.diagnosis;
    let mut object = deviations_json(&diagnosis.noise, diagnosis.noise_dof);
    object["source"] = json!(match &report.noise_origin {
        NoiseOrigin::Readings => "estimated",
        NoiseOrigin::Records => "records",
        NoiseOrigin::EarlierSessions(_) => "earlier-sessions",
    });
    if let NoiseOrigin::EarlierSessions(sessions) = &report.noise_origin {
        object["earlier"] = sessions.iter().map(earlier_json).collect();
    }
    object["floor_rms_um"] = super::um(report.noise_floor_m());
    object
}

fn earlier_json(earlier: &EarlierSession) -> Value {
    let mut object = deviations_json(&earlier.noise.noise(), earlier.noise.degrees_of_freedom());
    object["session"] = json!(earlier.name);
    object["p_same"] = finite(earlier.chance);
    object["used"] = json!(earlier.used);
    object
}

fn deviations_json(noise: &ReadingNoise, dof: [f64; 3]) -> Value {
    let one = |value: f64, unit: &str, dof: f64| {
        let mut quantity = json!({ "value": finite(value), "unit": unit, "dof": finite(dof) });
        if is_known(dof) {
            quantity["dof"] = Value::Null;
            quantity["reason"] = json!("given, not estimated");
        }
        quantity
    };
    let [reading, zero, slope] = dof;
    json!({
        "reading_sd": one(noise.reading_sd_m / METRES_PER_MICROMETRE, "um", reading),
        "zero_sd": one(noise.zero_sd_m / METRES_PER_MICROMETRE, "um", zero),
        "run_slope_sd": one(noise.run_slope_sd, "1", slope),
    })
}

/// The standard deviations of the noise; where earlier sessions tell them too, a table of what each told.
pub(super) fn noise_text(report: &DiagnosisReport) -> String {
    match &report.noise_origin {
        NoiseOrigin::EarlierSessions(sessions) => noise_table(report, sessions),
        NoiseOrigin::Readings | NoiseOrigin::Records => noise_sentence(report),
    }
}

fn noise_sentence(report: &DiagnosisReport) -> String {
    let noise = &report.diagnosis.noise;
    let [reading, zero, slope] = report.diagnosis.noise_dof.map(|dof| {
        if is_known(dof) {
            "given".to_owned()
        } else {
            format!("{dof:.0} degrees of freedom")
        }
    });
    let sentence = format!(
        "Noise, standard deviations: reading {} ({reading}), gauge zero {} ({zero}), slope of a run {} % ({slope}).",
        um(noise.reading_sd_m),
        um(noise.zero_sd_m),
        percent(noise.run_slope_sd)
    );
    paragraph(&sentence, "", "")
}

fn noise_table(report: &DiagnosisReport, sessions: &[EarlierSession]) -> String {
    let mut rows = AlignedTable::new(&[
        "noise estimated from",
        "reading, um",
        "dof",
        "gauge zero, um",
        "dof",
        "run slope, %",
        "dof",
        "p same",
        "counts",
    ]);
    let mut row = |name: &str, noise: &ReadingNoise, dof: [f64; 3], same: &str, counts: &str| {
        let [reading, zero, slope] = dof.map(|dof| format!("{dof:.0}"));
        rows.row([
            name.to_owned(),
            significant(noise.reading_sd_m / METRES_PER_MICROMETRE, 2),
            reading,
            significant(noise.zero_sd_m / METRES_PER_MICROMETRE, 2),
            zero,
            percent(noise.run_slope_sd),
            slope,
            same.to_owned(),
            counts.to_owned(),
        ]);
    };
    for earlier in sessions {
        row(
            &earlier.name,
            &earlier.noise.noise(),
            earlier.noise.degrees_of_freedom(),
            &significant(earlier.chance, 2),
            if earlier.used { "yes" } else { "no" },
        );
    }
    let diagnosis = &report.diagnosis;
    row("together", &diagnosis.noise, diagnosis.noise_dof, "", "");
    let head = "Noise, standard deviations with their degrees of freedom (dof): of earlier sessions, and of those that count together with this one. \
                p same: chance that two sessions with the same noise differ as much as the earlier one and this.";
    format!("{}{}", paragraph(head, "", ""), rows.text())
}

fn percent(share: f64) -> String {
    significant(100.0 * share, 2)
}
