//! The misfit of a model, divided between what was found and what is left.

use super::caption::joined;
use super::figure::{Axis, Figure, FigureNote, Marks, NotePlacement, Panel, Polygon, Style};
use super::palette::{Colour, Marker, qualitative};

/// Width of the plot area and height of a row, px.
const WIDTH_PX: f64 = 430.0;
const ROW_PX: f64 = 26.0;
/// Half the height of a bar, in rows.
const HALF_BAR: f64 = 0.34;
/// Size of the numbers beside bars, px.
const TEXT_PX: f64 = 10.5;
/// Noise beyond this share of the misfit is stated and not drawn: the bars beside it would vanish.
const MOST_NOISE: f64 = 1.5;

/// What the figure shows; all values are shares of the misfit without what was found (1).
#[derive(Debug, Clone, PartialEq)]
pub struct MisfitWaterfall {
    /// What was found, in the order in which it was found.
    pub found: Vec<WaterfallStep>,
    /// What is left.
    pub left: f64,
    /// What noise alone leaves in any model, beside the misfit.
    pub noise: f64,
}

/// What one finding explains beyond those before it.
#[derive(Debug, Clone, PartialEq)]
pub struct WaterfallStep {
    /// Its name, for example `joint-backlash at A3`.
    pub name: String,
    /// What it explains.
    pub explained: f64,
    /// Whether it is named as a weak sign only.
    pub tentative: bool,
}

/// A bar before it is drawn.
struct WaterfallBar {
    name: String,
    ends: [f64; 2],
    colour: Colour,
    text: String,
}

/// The figure: a bar for the misfit before, one for what each finding takes away, one for what is left, and one for noise.
#[must_use]
pub fn misfit_waterfall(input: &MisfitWaterfall) -> Figure {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let bar = |name: &str, ends: [f64; 2], colour| WaterfallBar {
        name: name.to_owned(),
        ends,
        colour,
        text: percent(ends[1] - ends[0]),
    };
    let mut bars = vec![bar("without findings", [0.0, 1.0], Colour::GREY)];
    let mut level = 1.0;
    for step in &input.found {
        let below = level - step.explained;
        let blue = qualitative(0);
        let colour = if step.tentative {
            blue.with_opacity(0.4)
        } else {
            blue
        };
        bars.push(bar(&step.name, [below, level], colour));
        level = below;
    }
    bars.push(bar("left", [0.0, input.left], qualitative(1)));
    let is_drawn = input.noise <= MOST_NOISE;
    if is_drawn {
        bars.push(bar(
            "noise alone",
            [0.0, input.noise],
            Colour::GREY.with_opacity(0.5),
        ));
    }
    let longest = bars.iter().map(|bar| bar.ends[1]).fold(1.0, f64::max);
    let names = bars.iter().map(|bar| bar.name.clone()).collect();
    let mut panel = Panel::new(
        "",
        Axis::linear("share of the misfit, %", "").within([0.0, 118.0 * longest]),
        Axis::rows(names),
    );
    for (place, bar) in bars.iter().enumerate() {
        let across = [place as f64 - HALF_BAR, place as f64 + HALF_BAR];
        let along = bar.ends.map(|end| 100.0 * end);
        panel.draw(
            Style::new(bar.colour, Marker::Square),
            Marks::Polygons(vec![Polygon::rectangle(along, across, bar.colour)]),
        );
    }
    panel.notes = bars
        .iter()
        .enumerate()
        .map(|(place, bar)| {
            FigureNote::new(
                [100.0 * bar.ends[1].max(bar.ends[0]), place as f64],
                bar.text.clone(),
                TEXT_PX,
                NotePlacement::Toward([1.0, 0.0]),
            )
        })
        .collect();
    let noise = format!(
        "Beside the misfit, noise adds {} of it to the squares of any model{}.",
        percent(input.noise),
        if is_drawn { "" } else { ", which is not drawn" }
    );
    Figure {
        panel_px: [WIDTH_PX, ROW_PX * bars.len() as f64],
        panels: vec![panel],
        ..Figure::new(
            "Share of the misfit that was explained",
            joined([
                Some(
                    "Misfit: weighted squares of the residuals beyond their degrees of freedom. Bar of a finding: what it explains beyond \
                     those before it."
                        .to_owned(),
                ),
                Some(noise),
            ]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{areas_of, assert_says, notes_of};

    #[test]
    fn bars_hang_from_each_other_and_noise_is_drawn_where_it_fits() {
        let mut input = MisfitWaterfall {
            found: vec![
                WaterfallStep {
                    name: "joint-backlash at A3".to_owned(),
                    explained: 0.7,
                    tentative: false,
                },
                WaterfallStep {
                    name: "creep".to_owned(),
                    explained: 0.2,
                    tentative: true,
                },
            ],
            left: 0.1,
            noise: 0.4,
        };
        let figure = misfit_waterfall(&input);
        let texts = notes_of(&figure.panels[0]);
        assert_eq!(texts, ["100.0 %", "70.0 %", "20.0 %", "10.0 %", "40.0 %"]);
        let second = areas_of(&figure.panels[0].series[2]);
        assert!((second[0].corners[0][0] - 10.0).abs() < 1e-9);
        assert!((second[0].corners[2][0] - 30.0).abs() < 1e-9);
        parse(&figure.to_svg()).unwrap();
        input.noise = 7.0;
        let figure = misfit_waterfall(&input);
        assert_eq!(figure.panels[0].notes.len(), 4);
        assert_says(&figure, "not drawn");
    }
}
