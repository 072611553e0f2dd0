//! Parts of a recording that are left out of a fit in turn.

use crate::mismatch::observed::Observations;

/// Most parts of a recording that are left out in turn.
const FOLDS: usize = 5;

/// Share of an equal part that each fold of cycles holds at least (1): else most of a recording lies in one of them.
const FAIR: f64 = 0.5;

/// Blocks of a run that is not repeated and has no cycles.
const BLOCKS: usize = 20;

/// Readings of a part that are left out in turn: repeats, else cycles, else blocks of a run, its ends never: a law predicts within what was
/// seen. Empty where nothing can be left out.
pub(crate) fn unseen_parts(observations: &Observations) -> Vec<Vec<bool>> {
    let cycles = observations.cycles();
    let repeats: Vec<u32> = (0..observations.len())
        .map(|reading| observations.runs[observations.readings[reading].run].repeat - 1)
        .collect();
    let several = |labels: &[u32]| labels.iter().any(|label| *label > 0);
    if several(&repeats) {
        return folds_of(&repeats, FOLDS);
    }
    if several(&cycles) {
        let folds = folds_of(&cycles, FOLDS);
        let fair = observations.len() as f64 / folds.len() as f64;
        let count = |fold: &Vec<bool>| fold.iter().filter(|held| **held).count() as f64;
        if folds.iter().all(|fold| count(fold) >= FAIR * fair) {
            return folds;
        }
    }
    let block = |reading: usize| {
        let run = &observations.runs[observations.readings[reading].run].readings;
        (reading - run.start) * BLOCKS / run.len()
    };
    (0..2)
        .map(|half| {
            let is_left_out = |reading: usize| {
                let block = block(reading);
                block % 2 == half && (1..BLOCKS - 1).contains(&block)
            };
            (0..observations.len()).map(is_left_out).collect()
        })
        .collect()
}

/// Readings with neighbouring labels in different folds.
fn folds_of(labels: &[u32], most: usize) -> Vec<Vec<bool>> {
    let last = labels.iter().max().map_or(0, |last| *last as usize);
    let count = (last + 1).min(most);
    (0..count)
        .map(|fold| {
            let is_left_out = |label: &u32| *label as usize % count == fold;
            labels.iter().map(is_left_out).collect()
        })
        .collect()
}
