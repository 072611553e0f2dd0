//! What CalculiX prints of the end: a `.dat` file.

use super::deck::END_SET;
use super::error::ReferenceError;

const M_PER_MM: f64 = 1e-3;

/// Time at the end of a step, which is also the share of its load that acts.
const WHOLE: f64 = 1.0;

/// Displacement of the end, m, from the text of a `.dat` file; of several increments of the load the last, at which all of it must act.
///
/// # Errors
/// [`ReferenceError::NoAnswer`], [`ReferenceError::Answer`], [`ReferenceError::PartOfTheLoad`].
pub fn end_displacement_m(file: &str, text: &str) -> Result<[f64; 3], ReferenceError> {
    let mut found = None;
    let mut share = WHOLE;
    let mut lines = text.lines().enumerate();
    while let Some((_, line)) = lines.next() {
        let is_head = line.trim_start().starts_with("displacements")
            && line.split_whitespace().any(|word| word == END_SET);
        if !is_head {
            continue;
        }
        let time = line.split_whitespace().next_back();
        share = time.and_then(|time| time.parse().ok()).unwrap_or(0.0);
        let Some((number, row)) = lines.by_ref().find(|(_, line)| !line.trim().is_empty()) else {
            break;
        };
        let wrong = || ReferenceError::Answer {
            file: file.to_owned(),
            line: number + 1,
            found: row.trim().to_owned(),
        };
        let values: Vec<f64> = row
            .split_whitespace()
            .map(str::parse)
            .collect::<Result<_, _>>()
            .map_err(|_| wrong())?;
        match values[..] {
            [_, x, y, z] if [x, y, z].iter().all(|value| value.is_finite()) => {
                found = Some([x, y, z].map(|mm| M_PER_MM * mm));
            }
            _ => return Err(wrong()),
        }
    }
    // CalculiX prints time with seven digits.
    if (share - WHOLE).abs() > 1e-6 {
        let file = file.to_owned();
        return Err(ReferenceError::PartOfTheLoad { file, share });
    }
    found.ok_or_else(|| ReferenceError::NoAnswer {
        file: file.to_owned(),
    })
}
