//! Evidence of the data for each candidate physics.

use super::caption::{counted_sentence, joined};
use super::figure::{Axis, Figure, FigureNote, Marks, NotePlacement, Panel, Polygon, Style};
use super::font;
use super::hatching::hatching;
use super::palette::{Colour, Marker, qualitative};
use super::text_room::{Reach, range_with_texts};
use super::ticks::signed;

/// Candidates that are drawn: the best of them.
const MOST_BARS: usize = 20;
/// Width of the plot area, height of a row, size of the texts beside bars, px.
const WIDTH_PX: f64 = 430.0;
const ROW_PX: f64 = 22.0;
const TEXT_PX: f64 = 10.5;
/// Between a bar and its text, px; the notes of a panel keep this distance.
const TEXT_GAP_PX: f64 = 15.0;
/// Longest text beside a bar, px: the longest that [`range_with_texts`] can give room.
const LONGEST_TEXT_PX: f64 = 300.0;
/// Half the height of a bar, in rows.
const HALF_BAR: f64 = 0.34;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct EvidenceBars {
    /// The candidates in any order.
    pub candidates: Vec<EvidenceCandidate>,
    /// Difference of logarithms within which candidates that look alike are indistinguishable; those that look different are within less.
    pub alike_within: f64,
}

/// One candidate physics.
#[derive(Debug, Clone, PartialEq)]
pub struct EvidenceCandidate {
    /// Physics and place, for example `joint-backlash at A3`.
    pub name: String,
    /// Natural logarithm of its Bayes factor against the baseline.
    pub log_bayes_factor: f64,
    /// What was decided about it.
    pub standing: CandidateDecision,
}

/// What was decided about a candidate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CandidateDecision {
    /// The diagnosis names it.
    Named,
    /// The diagnosis names it as a weak sign.
    Tentative,
    /// It was considered and is not named.
    Rival,
    /// It fits with a value that cannot be.
    Impossible {
        /// What cannot be, in two or three words, for example `play < 0`; cut short if it is longer than the bars leave room.
        reason: String,
    },
}

impl CandidateDecision {
    fn is_named(&self) -> bool {
        matches!(self, Self::Named | Self::Tentative)
    }
}

/// Looks of the bars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum BarLook {
    Named,
    Tentative,
    NotApart,
    Rival,
    Impossible,
}

impl BarLook {
    const FILLED: [Self; 4] = [Self::Named, Self::Tentative, Self::NotApart, Self::Rival];

    fn of(candidate: &EvidenceCandidate, band: AlikeBand) -> Self {
        match &candidate.standing {
            CandidateDecision::Named => Self::Named,
            CandidateDecision::Tentative => Self::Tentative,
            CandidateDecision::Rival if candidate.log_bayes_factor >= band.lowest() => {
                Self::NotApart
            }
            CandidateDecision::Rival => Self::Rival,
            CandidateDecision::Impossible { .. } => Self::Impossible,
        }
    }

    fn label_and_colour(self, band: AlikeBand) -> (String, Colour) {
        match self {
            Self::Named => ("named".to_owned(), qualitative(0)),
            Self::Tentative => (
                "named as a weak sign".to_owned(),
                qualitative(0).with_opacity(0.4),
            ),
            Self::NotApart => (
                format!("rival within {}, unlike it", band.width),
                qualitative(1),
            ),
            Self::Rival => ("other rival".to_owned(), Colour::GREY),
            Self::Impossible => ("impossible".to_owned(), Colour::INK),
        }
    }
}

/// Where those that look alike are indistinguishable.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AlikeBand {
    best: f64,
    width: f64,
}

impl AlikeBand {
    fn lowest(self) -> f64 {
        self.best - self.width
    }
}

/// The figure: a bar for each candidate, the best at the top; those that look alike are indistinguishable beyond the line below the best.
#[must_use]
pub fn evidence_bars(input: &EvidenceBars) -> Figure {
    let mut candidates: Vec<&EvidenceCandidate> = input
        .candidates
        .iter()
        .filter(|candidate| candidate.log_bayes_factor.is_finite())
        .collect();
    let unknown = input.candidates.len() - candidates.len();
    candidates.sort_by(|a, b| b.log_bayes_factor.total_cmp(&a.log_bayes_factor));
    // What is named is always drawn; of the others the best fill the places that remain.
    let named = candidates.iter().filter(|c| c.standing.is_named());
    let mut places = MOST_BARS.saturating_sub(named.count());
    let all = candidates.len();
    candidates.retain(|candidate| {
        let is_named = candidate.standing.is_named();
        let stays = is_named || places > 0;
        places -= usize::from(stays && !is_named);
        stays
    });
    let left_out = all - candidates.len();
    let band = AlikeBand {
        best: best(&candidates),
        width: input.alike_within,
    };
    let panel = panel(&candidates, band);
    Figure {
        panel_px: [WIDTH_PX, ROW_PX * candidates.len().max(3) as f64],
        panels: vec![panel],
        ..Figure::new(
            "Evidence for what is missing",
            caption(&candidates, left_out, unknown),
        )
    }
}

/// Logarithm that the others are compared with: of the best possible candidate, or 0 of the baseline if that is better.
fn best(candidates: &[&EvidenceCandidate]) -> f64 {
    candidates
        .iter()
        .filter(|candidate| !matches!(candidate.standing, CandidateDecision::Impossible { .. }))
        .map(|candidate| candidate.log_bayes_factor)
        .fold(0.0, f64::max)
}

fn panel(candidates: &[&EvidenceCandidate], band: AlikeBand) -> Panel {
    let names = candidates.iter().map(|c| c.name.clone()).collect();
    let range = range(candidates, band);
    let mut panel = Panel::new(
        "",
        Axis::linear(
            "log Bayes factor against the baseline, natural logarithm",
            "",
        )
        .within(range),
        Axis::rows(names),
    );
    if !candidates.is_empty() {
        // A line and no ground: texts beside bars cross it.
        let ends = [-0.5, candidates.len() as f64 - 0.5].map(|row| [band.lowest(), row]);
        panel.draw_named(
            format!(
                "{} below the best: beyond it those alike are indistinguishable",
                band.width
            ),
            Style::new(Colour::GREY, Marker::Dash).stroke(1.2).dashed(),
            Marks::Segments(vec![ends]),
        );
    }
    for look in BarLook::FILLED {
        push_filled(&mut panel, candidates, band, look);
    }
    let units_per_px = (range[1] - range[0]) / WIDTH_PX;
    push_hollow(&mut panel, candidates, units_per_px);
    panel.draw(Style::line(Colour::INK, 1.0), Marks::UprightAt(0.0));
    panel.notes = candidates
        .iter()
        .enumerate()
        .map(|(place, candidate)| {
            FigureNote::new(
                [candidate.log_bayes_factor.max(0.0), place as f64],
                text(candidate),
                TEXT_PX,
                NotePlacement::Toward([1.0, 0.0]),
            )
        })
        .collect();
    panel
}

fn push_filled(
    panel: &mut Panel,
    candidates: &[&EvidenceCandidate],
    band: AlikeBand,
    look: BarLook,
) {
    let (label, colour) = look.label_and_colour(band);
    let bars: Vec<Polygon> = candidates
        .iter()
        .enumerate()
        .filter(|(_, candidate)| BarLook::of(candidate, band) == look)
        .map(|(place, candidate)| bar(place, candidate, colour))
        .collect();
    let style = Style::new(colour, Marker::Square);
    panel.draw_named(label, style, Marks::Polygons(bars));
}

/// Bars of impossible candidates: an outline with hatching.
fn push_hollow(panel: &mut Panel, candidates: &[&EvidenceCandidate], units_per_px: f64) {
    let mut lines = Vec::new();
    for (place, candidate) in candidates.iter().enumerate() {
        if !matches!(candidate.standing, CandidateDecision::Impossible { .. }) {
            continue;
        }
        let Polygon { corners, .. } = bar(place, candidate, Colour::INK);
        lines.extend((0..4).map(|i| [corners[i], corners[(i + 1) % 4]]));
        lines.extend(hatching([&corners[0], &corners[2]], ROW_PX, units_per_px));
    }
    let style = Style::new(Colour::INK, Marker::Square).stroke(0.8);
    panel.draw(style, Marks::Segments(lines));
}

fn bar(place: usize, candidate: &EvidenceCandidate, colour: Colour) -> Polygon {
    let value = candidate.log_bayes_factor;
    let place = place as f64;
    Polygon::rectangle(
        [value.min(0.0), value.max(0.0)],
        [place - HALF_BAR, place + HALF_BAR],
        colour,
    )
}

/// What stands beside a bar.
fn text(candidate: &EvidenceCandidate) -> String {
    let value = candidate.log_bayes_factor;
    let number = signed(value, usize::from(value.abs() < 99.95));
    match &candidate.standing {
        CandidateDecision::Named | CandidateDecision::Tentative | CandidateDecision::Rival => {
            number
        }
        CandidateDecision::Impossible { reason } => font::shortened(
            &format!("{number}, impossible: {reason}"),
            TEXT_PX,
            LONGEST_TEXT_PX,
        ),
    }
}

/// Range in which all bars, their texts and the band lie.
fn range(candidates: &[&EvidenceCandidate], band: AlikeBand) -> [f64; 2] {
    let mut reaches: Vec<Reach> = candidates
        .iter()
        .flat_map(|candidate| {
            let value = candidate.log_bayes_factor;
            let right_px = TEXT_GAP_PX + font::width_px(&text(candidate), TEXT_PX);
            let at = |place, right_px| Reach {
                place,
                left_px: 4.0,
                right_px,
            };
            [at(value.min(0.0), 0.0), at(value.max(0.0), right_px)]
        })
        .collect();
    reaches.push(Reach {
        place: band.lowest(),
        left_px: 4.0,
        right_px: 0.0,
    });
    range_with_texts(&reaches, WIDTH_PX).unwrap_or([-1.0, 1.0])
}

fn caption(candidates: &[&EvidenceCandidate], left_out: usize, unknown: usize) -> String {
    let impossible = candidates
        .iter()
        .filter(|candidate| matches!(candidate.standing, CandidateDecision::Impossible { .. }))
        .count();
    let is_named = candidates.iter().any(|c| c.standing.is_named());
    joined([
        Some(
            "Bar: logarithm of how much more probable the readings are with the candidate than without; the baseline stands at 0, \
             and 3 is a factor of twenty."
                .to_owned(),
        ),
        (!is_named).then(|| "No candidate is named.".to_owned()),
        counted_sentence(
            impossible,
            ["hatched candidate fits", "hatched candidates fit"],
            "well only with a value that cannot be, and the bar is what the evidence would have been with it.",
        ),
        counted_sentence(
            left_out,
            [
                "further candidate with less evidence is",
                "further candidates with less evidence are",
            ],
            "not drawn.",
        ),
        counted_sentence(
            unknown,
            ["candidate is", "candidates are"],
            "without a finite value and not drawn.",
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{areas_of, assert_says, labelled, notes_of};

    fn candidate(
        name: &str,
        log_bayes_factor: f64,
        standing: CandidateDecision,
    ) -> EvidenceCandidate {
        EvidenceCandidate {
            name: name.to_owned(),
            log_bayes_factor,
            standing,
        }
    }

    fn impossible() -> CandidateDecision {
        CandidateDecision::Impossible {
            reason: "play < 0".to_owned(),
        }
    }

    fn input() -> EvidenceBars {
        EvidenceBars {
            candidates: vec![
                candidate("creep", -2.5, CandidateDecision::Rival),
                candidate("joint-friction at A3", 39.0, CandidateDecision::Rival),
                candidate("joint-backlash at A3", 41.0, CandidateDecision::Named),
                candidate("joint-backlash at B1", 60.0, impossible()),
                candidate("slip", f64::NAN, CandidateDecision::Rival),
                candidate("setting-in", 12.0, CandidateDecision::Rival),
            ],
            alike_within: 5.0,
        }
    }

    fn bars<'a>(figure: &'a Figure, label: &str) -> &'a [Polygon] {
        areas_of(labelled(&figure.panels[0], label))
    }

    /// Where the line below the best stands.
    fn line(figure: &Figure) -> f64 {
        let series = figure.panels[0].series.iter();
        let mut labelled = series.filter(|series| series.label.is_some());
        let lines = labelled.find_map(|series| match &series.marks {
            Marks::Segments(lines) => Some(lines),
            _ => None,
        });
        lines.unwrap()[0][0][0]
    }

    #[test]
    fn the_line_stands_five_below_the_best_possible_candidate() {
        let figure = evidence_bars(&input());
        assert_eq!(line(&figure), 36.0);
        assert_eq!(bars(&figure, "named")[0].corners[1], [41.0, 1.0 - HALF_BAR]);
        let not_apart = bars(&figure, "rival within 5, unlike it");
        assert_eq!(not_apart.len(), 1);
        assert_eq!(not_apart[0].corners[1][0], 39.0);
        let rivals = bars(&figure, "other rival");
        assert_eq!(rivals[0].corners[1][0], 12.0);
        assert_eq!(rivals[1].corners[0][0], -2.5, "a bar may point left");
    }

    #[test]
    fn impossible_candidates_are_hatched_and_labelled() {
        let figure = evidence_bars(&input());
        let texts = notes_of(&figure.panels[0]);
        assert_eq!(
            texts,
            ["60.0, impossible: play < 0", "41.0", "39.0", "12.0", "−2.5"]
        );
        let hatched = figure.panels[0].series.iter().find_map(|s| match &s.marks {
            Marks::Segments(lines) if s.label.is_none() => Some(lines),
            _ => None,
        });
        let lines = hatched.unwrap();
        assert!(lines.len() > 20);
        for [x, y] in lines.iter().flatten() {
            assert!((-1e-9..=60.0 + 1e-9).contains(x), "{x}");
            assert!(y.abs() <= HALF_BAR + 1e-9, "{y}");
        }
        assert_says(&figure, "1 candidate is without a finite value");
        assert_says(&figure, "1 hatched candidate fits");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn without_a_better_candidate_the_baseline_is_the_best() {
        let figure = evidence_bars(&EvidenceBars {
            candidates: vec![candidate("creep", -2.5, CandidateDecision::Rival)],
            alike_within: 5.0,
        });
        assert_eq!(line(&figure), -5.0);
    }

    #[test]
    fn of_many_candidates_the_best_and_the_named_are_drawn() {
        let mut candidates: Vec<EvidenceCandidate> = (0..30)
            .map(|i| candidate("rival", f64::from(i), CandidateDecision::Rival))
            .collect();
        candidates[0].standing = CandidateDecision::Named;
        let figure = evidence_bars(&EvidenceBars {
            candidates,
            alike_within: 5.0,
        });
        assert_eq!(figure.panels[0].notes.len(), 20);
        assert_eq!(figure.panels[0].notes[19].text, "0.0");
        assert_says(&figure, "10 further candidates");
        parse(&figure.to_svg()).unwrap();
        parse(
            &evidence_bars(&EvidenceBars {
                candidates: vec![],
                alike_within: 5.0,
            })
            .to_svg(),
        )
        .unwrap();
    }
}
