//! A long recording with fewer readings of the same path.

use super::table::{SpecimenReading, SpecimenTable};

impl SpecimenTable {
    /// The same table with every k-th reading of each run, its turning points and its last reading; k is the smallest that leaves about `most`.
    ///
    /// Neighbours in a fast recording say the same, and a diagnosis takes as long as there are readings.
    #[must_use]
    pub fn thinned(mut self, most: usize) -> Self {
        let every = self.readings.len().div_ceil(most.max(1));
        if every < 2 {
            return self;
        }
        let mut seen = vec![0_usize; self.runs.len()];
        let mut last: Vec<Option<usize>> = vec![None; self.runs.len()];
        let mut keep = vec![false; self.readings.len()];
        for (place, reading) in self.readings.iter().enumerate() {
            let run = reading.run as usize;
            keep[place] = seen[run].is_multiple_of(every);
            seen[run] += 1;
            // The turning point is the reading before the branch changes.
            let turned = |before: &usize| self.readings[*before].branch != reading.branch;
            if let Some(before) = last[run].filter(turned) {
                keep[before] = true;
            }
            last[run] = Some(place);
        }
        for place in last.into_iter().flatten() {
            keep[place] = true;
        }
        let before = self.readings.len();
        let readings = self.readings.iter().zip(&keep);
        let kept = readings.filter(|(_, keep)| **keep);
        self.readings = kept
            .map(|(reading, _)| *reading)
            .collect::<Vec<SpecimenReading>>();
        let used = self.readings.len();
        self.assumptions.push(format!(
            "{used} of {before} readings were used: every {every}th of each run, and its turning points; a bad reading between them is not seen"
        ));
        self
    }
}
