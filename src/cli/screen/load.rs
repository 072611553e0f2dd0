//! The load: what to do, the bar, and how far the gauges have settled.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use crate::quantity::METRES_PER_MICROMETRE;
use crate::session::{SessionView, SettleView};

use super::draw::{BAD, DOUBT, GOOD};
use super::glyphs::Glyphs;
use super::labels;
use super::load_bar::{BarCell, load_bar};

/// Draws it.
pub(super) fn draw_load(area: &mut Frame<'_>, place: Rect, view: &SessionView, glyphs: Glyphs) {
    let title = match &view.place {
        Some(at) => {
            let hold = at
                .extra_hold_s
                .map_or(String::new(), |s| format!(" | held {s:.0} s"));
            let attempt = match at.attempt {
                1 => String::new(),
                attempt => format!(" | try {attempt}"),
            };
            format!(
                " {} {} | {} | load {} of {} | repeat {} of {}{hold}{attempt} | cell {} of {} ",
                at.pose,
                at.direction,
                at.branch,
                at.step + 1,
                at.steps,
                at.repeat,
                at.repeats,
                at.cell + 1,
                at.cells
            )
        }
        None => " Session ".to_owned(),
    };
    let block = glyphs.block(title);
    let inner = block.inner(place);
    let mut lines = vec![order(view)];
    if let Some(band) = &view.band {
        let bar = load_bar(
            band,
            view.force.value_si,
            usize::from(inner.width.saturating_sub(2)),
        );
        let cells = bar
            .cells
            .iter()
            .map(|&cell| Span::styled(glyphs.cell(cell).to_string(), style_of(cell)));
        let indent = std::iter::once(Span::raw(" "));
        lines.push(Line::from(indent.chain(cells).collect::<Vec<_>>()));
        lines.push(Line::raw(label_line(&bar.labels, inner.width)));
    } else {
        lines.extend([Line::raw(""), Line::raw("")]);
    }
    if let Some(settle) = &view.settle {
        lines.extend(settle_lines(settle, inner.width));
    }
    area.render_widget(Paragraph::new(lines).block(block), place);
}

/// The order of the moment, and how far there is to go.
fn order(view: &SessionView) -> Line<'static> {
    let mut spans = vec![Span::styled(
        format!(" {}", labels::task(&view.task)),
        Style::new().add_modifier(Modifier::BOLD),
    )];
    if let (Some(band), Some(force_n)) = (&view.band, view.force.value_si) {
        let to_go = labels::to_go(force_n, band.target_n, band.tolerance_n);
        let style = Style::new().fg(if band.inside { GOOD } else { DOUBT });
        spans.push(Span::styled(format!("   {to_go}"), style));
        if band.overshoot_n > band.tolerance_n {
            let past = format!("   went {:.1} N past it", band.overshoot_n);
            spans.push(Span::styled(past, Style::new().fg(BAD)));
        }
    }
    Line::from(spans)
}

fn style_of(cell: BarCell) -> Style {
    match cell {
        BarCell::Empty | BarCell::Zero => Style::new().add_modifier(Modifier::DIM),
        BarCell::Load => Style::new(),
        BarCell::TooMuch => Style::new().fg(BAD),
        BarCell::Band => Style::new().fg(DOUBT),
        BarCell::BandReached => Style::new().fg(GOOD),
    }
}

/// Labels centred on their columns; one that would run into another is left out.
fn label_line(labels: &[(usize, String)], width: u16) -> String {
    let mut line = vec![' '; usize::from(width)];
    // The last is the target: it goes first.
    for (column, label) in labels.iter().rev() {
        let begin = (column + 1).saturating_sub(label.chars().count() / 2);
        let end = begin + label.chars().count();
        let around = line.get(begin.saturating_sub(1)..(end + 1).min(line.len()));
        if end <= line.len() && around.is_some_and(|cells| cells.iter().all(|&c| c == ' ')) {
            for (cell, c) in line[begin..end].iter_mut().zip(label.chars()) {
                *cell = c;
            }
        }
    }
    line.into_iter().collect()
}

fn settle_lines(settle: &SettleView, width: u16) -> [Line<'static>; 2] {
    let share = (settle.dwell_s / settle.dwell_needed_s.max(1e-9)).clamp(0.0, 1.0);
    let columns = usize::from((width / 4).clamp(5, 20));
    let full = (share * columns as f64).round() as usize;
    let bar = format!("[{}{}]", "=".repeat(full), " ".repeat(columns - full));
    let state = if settle.settled {
        "settled"
    } else {
        "settling"
    };
    let style = Style::new().fg(if settle.settled { GOOD } else { DOUBT });
    let um = METRES_PER_MICROMETRE;
    let quantity = |name: &str, value: Option<f64>, limit: f64, scale: f64, unit: &str| {
        let value_text = value.map_or("-".to_owned(), |value| {
            format!("{:.1}", value.abs() / scale)
        });
        let ok = value.is_some_and(|value| value.abs() <= limit);
        let style = Style::new().fg(if ok { GOOD } else { DOUBT });
        Span::styled(
            format!("{name} {value_text}/{:.1} {unit}  ", limit / scale),
            style,
        )
    };
    [
        Line::styled(
            format!(
                " {state} {bar} {:.1} of {:.1} s",
                settle.dwell_s.min(settle.dwell_needed_s),
                settle.dwell_needed_s
            ),
            style,
        ),
        Line::from(vec![
            Span::raw(" "),
            quantity("spread", settle.spread_m, settle.spread_limit_m, um, "um"),
            quantity(
                "slope",
                settle.slope_m_per_s,
                settle.slope_limit_m_per_s,
                um,
                "um/s",
            ),
            quantity(
                "force spread",
                settle.force_spread_n,
                settle.force_spread_limit_n,
                1.0,
                "N",
            ),
            quantity(
                "slope",
                settle.force_slope_n_per_s,
                settle.force_slope_limit_n_per_s,
                1.0,
                "N/s",
            ),
        ]),
    ]
}
