//! Every place at which a diagnosis looked for each law.

use indexmap::IndexMap;

use crate::report::significant;

use super::PageDiagnosis;
use super::session::PageEntry;

/// The places of a law.
#[derive(Debug, Default)]
struct LawPlaces {
    /// With the largest change of a reading, µm, that would have been found in four sessions of five.
    found: Vec<(f64, String)>,
    /// At which only an impossible value would improve the fit.
    impossible: Vec<String>,
    /// At which no size would have been found.
    untested: Vec<String>,
}

/// Each law with its places in words; none of a part.
pub(super) fn places(diagnosis: &PageDiagnosis) -> Vec<PageEntry> {
    let one = &diagnosis.numbers;
    let mut laws: IndexMap<&str, LawPlaces> = IndexMap::new();
    for limit in &one.detection_limits {
        let law = laws.entry(limit.physics.row).or_default();
        let place = limit.place.as_ref();
        let place = place.map_or_else(|| "everywhere".to_owned(), ToString::to_string);
        match limit.seen.as_ref().and_then(|seen| seen.end_effect_um) {
            Some(um) => law.found.push((um, place)),
            None => law.untested.push(place),
        }
    }
    for rejected in &one.impossible {
        let law = laws.entry(rejected.law.law.row).or_default();
        law.impossible.push(rejected.law.place.to_string());
    }
    let entries = laws.into_iter();
    entries
        .map(|(law, places)| PageEntry::new(law, places.words()))
        .collect()
}

impl LawPlaces {
    /// Sizes, the best place first, then the places without one.
    fn words(mut self) -> String {
        self.found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sizes = self.found.iter().map(|(um, place)| {
            let um = significant(*um, 2);
            format!("{place} {um}\u{a0}µm")
        });
        let lists = [
            ("", sizes.collect()),
            ("Rejected as impossible: ", self.impossible),
            ("Could not be tested: ", self.untested),
        ];
        let known = lists.into_iter().filter(|(_, places)| !places.is_empty());
        let sentences = known.map(|(what, places)| format!("{what}{}.", places.join("; ")));
        sentences.collect::<Vec<_>>().join(" ")
    }
}
