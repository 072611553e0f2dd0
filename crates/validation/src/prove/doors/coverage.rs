//! How often 95 % intervals hold the truth, by door.

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::statistics::{mean, standard_deviation, student_t_quantile};

use crate::prove::share::Share;

use super::answer::{DoorAnswer, DoorEstimate};

/// Intervals of one door and command.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CoverageRow {
    /// How the readings came: `session`, `table`, `three-gauges`, `load-cases`, `part`.
    pub door: &'static str,
    /// `fit` or `diagnose`.
    pub command: &'static str,
    /// The factor; `null` for all of a session.
    pub parameter: Option<String>,
    /// Intervals that hold the truth.
    pub share: Share,
    /// Intervals that reach both ends of what is plausible, and hold everything: the readings do not determine the value.
    pub undetermined: usize,
    /// 95 % interval of that share; of all factors from session to session, because the intervals of one session are correlated.
    pub ci95: Option<[f64; 2]>,
}

/// Intervals that hold the truth, of answers to sessions that differ in their noise alone.
///
/// # Arguments
/// - `truth`: of each factor, and of each value of a law that was stated.
#[must_use]
pub fn coverage(
    door: &'static str,
    answers: &[DoorAnswer],
    truth: &[(String, f64)],
) -> Vec<CoverageRow> {
    let mut rows = Vec::new();
    for command in ["fit", "diagnose"] {
        let estimates = |answer: &DoorAnswer| match command {
            "fit" => answer.fitted.clone(),
            _ => answer.parameters.clone(),
        };
        let of_sessions: Vec<Vec<DoorEstimate>> = answers.iter().map(estimates).collect();
        let row = |parameter: Option<&String>, share: Share, ci95| CoverageRow {
            door,
            command,
            parameter: parameter.cloned(),
            share,
            undetermined: of_sessions
                .iter()
                .flatten()
                .filter(|one| {
                    one.is_open == [true; 2] && parameter.is_none_or(|name| one.name == *name)
                })
                .count(),
            ci95,
        };
        let mut all = Share::default();
        for one in truth {
            let share = of_sessions.iter().fold(Share::default(), |sum, session| {
                sum.with(held(session, std::slice::from_ref(one)))
            });
            if share.trials > 0 {
                rows.push(row(Some(&one.0), share, share.interval_95()));
            }
            all = all.with(share);
        }
        let of_session = |session: &Vec<DoorEstimate>| held(session, truth).value();
        let shares: Vec<f64> = of_sessions.iter().filter_map(of_session).collect();
        rows.push(row(None, all, interval_of_mean(&shares)));
    }
    rows
}

/// Intervals of one session that hold the truth.
fn held(session: &[DoorEstimate], truth: &[(String, f64)]) -> Share {
    let holds = truth.iter().filter_map(|(name, truth)| {
        let estimate = session.iter().find(|estimate| estimate.name == *name)?;
        estimate.holds(*truth)
    });
    Share::of(holds, |holds| *holds)
}

fn interval_of_mean(values: &[f64]) -> Option<[f64; 2]> {
    let count = values.len() as f64;
    let quantile = student_t_quantile(0.975, count - 1.0)?;
    let half = quantile * standard_deviation(values)? / count.sqrt();
    let middle = mean(values)?;
    Some([middle - half, middle + half])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_counted_by_parameter_and_pooled_by_session() {
        let answer = |ends: [f64; 2]| DoorAnswer {
            fitted: vec![
                DoorEstimate {
                    name: "beam.A".to_owned(),
                    value: 1.0,
                    ci95: Some(ends),
                    is_open: [false; 2],
                },
                DoorEstimate {
                    name: "beam.J".to_owned(),
                    value: 1.0,
                    ci95: Some([0.0, 2.0]),
                    is_open: [true; 2],
                },
            ],
            ..DoorAnswer::default()
        };
        let [good, bad] = [[0.9, 1.1], [1.05, 1.1]].map(answer);
        let truth = [("beam.A".to_owned(), 1.0), ("beam.J".to_owned(), 1.0)];
        let rows = coverage("table", &[bad, good], &truth);
        let shares: Vec<String> = rows
            .iter()
            .map(|row| {
                format!(
                    "{} {}/{} {}",
                    row.command, row.share.hits, row.share.trials, row.undetermined
                )
            })
            .collect();
        assert_eq!(
            shares,
            ["fit 1/2 0", "fit 2/2 2", "fit 3/4 2", "diagnose 0/0 0"]
        );
        let [low, high] = rows[2].ci95.unwrap();
        assert!(low < 0.75 && high > 0.75 && (low + high - 1.5).abs() < 1e-12);
    }
}
