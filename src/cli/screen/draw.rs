//! A view of the session as cells of a screen.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Clear, Paragraph, Wrap};

use crate::quantity::METRES_PER_MICROMETRE;
use crate::session::{GaugeView, SessionView};

use super::big_digits;
use super::glyphs::Glyphs;
use super::input::TypedLine;
use super::labels;
use super::load::draw_load;
use super::question::{keys, question};

/// Below this many rows the big digits and the list of readings give way.
const ROWS_FOR_BIG_DIGITS: u16 = 30;

/// Columns and rows below which values or questions would be cut off.
const LEAST: [u16; 2] = [60, 20];

pub(super) const GOOD: Color = Color::Cyan;
pub(super) const DOUBT: Color = Color::Yellow;
pub(super) const BAD: Color = Color::LightRed;

/// Draws everything.
pub(super) fn draw(area: &mut Frame<'_>, view: &SessionView, input: &TypedLine, glyphs: Glyphs) {
    let whole = area.area();
    if whole.width < LEAST[0] || whole.height < LEAST[1] {
        let text = format!(
            "This terminal is {} x {}; the session needs {} x {}. Make it larger: nothing is lost meanwhile.",
            whole.width, whole.height, LEAST[0], LEAST[1]
        );
        let warning = Style::new().fg(BAD).add_modifier(Modifier::BOLD);
        area.render_widget(
            Paragraph::new(text)
                .wrap(Wrap { trim: true })
                .style(warning),
            whole,
        );
        return;
    }
    let big = whole.height >= ROWS_FOR_BIG_DIGITS && whole.width >= 76;
    let notices = notices(view);
    let asked = question(view, input);
    let question_rows = if asked.is_empty() {
        0
    } else {
        rows_of(&asked, whole.width) + 2
    };
    // One displacement gauge has a box as the force gauge, several a line each.
    let small = 4.max(2 + view.displacements.len().min(3) as u16);
    let [header, gauges, load, below, question_area, footer] = Layout::vertical([
        Constraint::Length(1 + rows_of(&notices, whole.width + 2).min(3)),
        Constraint::Length(if big { 10 } else { small }),
        Constraint::Length(7),
        Constraint::Min(0),
        Constraint::Length(question_rows.min(whole.height / 2)),
        Constraint::Length(1),
    ])
    .areas(whole);
    area.render_widget(Paragraph::new(header_lines(view, notices)), header);
    let halves = Layout::horizontal([Constraint::Percentage(50), Constraint::Percentage(50)]);
    let [force, displacement] = halves.areas(gauges);
    draw_gauge(area, force, &view.force, ("Force", "N", 1.0), big, glyphs);
    let um = ("Displacement", "um", METRES_PER_MICROMETRE);
    match &view.displacements[..] {
        [gauge] => draw_gauge(area, displacement, gauge, um, big, glyphs),
        gauges => draw_axis_gauges(area, displacement, gauges, glyphs),
    }
    draw_load(area, load, view, glyphs);
    let [cell, messages] = halves.areas(below);
    draw_cell(area, cell, view, glyphs);
    draw_messages(area, messages, view, glyphs);
    if !asked.is_empty() {
        area.render_widget(Clear, question_area);
        let block = glyphs
            .block(" Question ".to_owned())
            .style(Style::new().fg(DOUBT));
        let text = Paragraph::new(asked)
            .wrap(Wrap { trim: false })
            .style(Style::reset());
        area.render_widget(text.block(block), question_area);
    }
    area.render_widget(
        Paragraph::new(keys(input)).style(Style::new().add_modifier(Modifier::DIM)),
        footer,
    );
}

/// Rows that lines take when they are wrapped inside a border.
fn rows_of(lines: &[Line<'_>], width: u16) -> u16 {
    let inner = usize::from(width.saturating_sub(2).max(1));
    let rows = lines.iter().map(|line| line.width().div_ceil(inner).max(1));
    rows.sum::<usize>().min(usize::from(u16::MAX)) as u16
}

/// What holds the session up, and what stays true for all of it.
fn notices(view: &SessionView) -> Vec<Line<'static>> {
    let held = view.held_up.iter().map(|text| {
        let style = Style::new()
            .fg(BAD)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED);
        Line::styled(format!(" ! {text} "), style)
    });
    let warned = view
        .warnings
        .iter()
        .map(|text| Line::styled(format!(" ! {text}"), Style::new().fg(DOUBT)));
    held.chain(warned).collect()
}

fn header_lines(view: &SessionView, notices: Vec<Line<'static>>) -> Vec<Line<'static>> {
    let progress = &view.progress;
    let skipped = match progress.skipped {
        0 => String::new(),
        skipped => format!(", {skipped} skipped"),
    };
    let mut lines = vec![Line::from(vec![
        Span::styled(
            format!(" {} ", view.session),
            Style::new().add_modifier(Modifier::BOLD),
        ),
        Span::raw(format!(
            "| procedure {} | {} of {} readings{skipped} | {} left",
            view.procedure,
            progress.accepted,
            progress.planned,
            labels::duration(progress.left_s)
        )),
    ])];
    lines.extend(notices);
    lines
}

/// Red while its value is not to be used.
fn style_of_gauge(gauge: &GaugeView) -> Style {
    let doubtful = gauge.stale || !gauge.link.is_empty() || gauge.value_si.is_none();
    Style::new().fg(if doubtful { BAD } else { Color::Reset })
}

/// How old its value is, how many come, what it sent, or what is wrong with its line.
fn state_of_gauge(gauge: &GaugeView) -> String {
    let rate = gauge
        .rate_hz
        .map_or(String::new(), |rate| format!(", {rate:.0}/s"));
    let raw = match gauge.raw.as_str() {
        "" => String::new(),
        raw => format!(" | sent: {raw}"),
    };
    match (gauge.link.as_str(), gauge.stale) {
        ("", true) => format!("STALE, {}{raw}", labels::age(gauge.age_s)),
        ("", false) => format!("{}{rate}{raw}", labels::age(gauge.age_s)),
        (link, _) => link.to_owned(),
    }
}

/// Displacement gauges along base axes, a line each.
fn draw_axis_gauges(area: &mut Frame<'_>, place: Rect, gauges: &[GaugeView], glyphs: Glyphs) {
    let lines = gauges.iter().map(|gauge| {
        let axis = gauge.channel.axis();
        let axis = axis.map_or_else(String::new, |axis| axis.to_string());
        let sign = if gauge.sign_known { "" } else { " (sign?)" };
        let value = labels::value(gauge, METRES_PER_MICROMETRE);
        let style = style_of_gauge(gauge);
        Line::from(vec![
            Span::styled(
                format!(" {axis} {value:>9} um{sign}"),
                style.add_modifier(Modifier::BOLD),
            ),
            Span::raw(format!(
                "  {}",
                labels::extremes(gauge, METRES_PER_MICROMETRE)
            )),
            Span::styled(format!("  {}", state_of_gauge(gauge)), style),
        ])
    });
    let text = Paragraph::new(lines.collect::<Vec<_>>());
    let block = glyphs.block(" Displacement along the base axes ".to_owned());
    area.render_widget(text.block(block), place);
}

/// A gauge: its value as large as there is room, how old, how fast, and what is wrong with its line.
fn draw_gauge(
    area: &mut Frame<'_>,
    place: Rect,
    gauge: &GaugeView,
    (title, unit, si_per_unit): (&str, &str, f64),
    big: bool,
    glyphs: Glyphs,
) {
    let style = style_of_gauge(gauge);
    let value = labels::value(gauge, si_per_unit);
    let state = state_of_gauge(gauge);
    let extremes = labels::extremes(gauge, si_per_unit);
    let sign = if gauge.sign_known {
        ""
    } else {
        " (sign not known yet)"
    };
    let mut lines = Vec::new();
    if big {
        lines.push(Line::raw(""));
        for row in big_digits::rows(&value, glyphs.ink()) {
            lines.push(Line::styled(format!(" {row}"), style));
        }
        lines.push(Line::from(vec![
            Span::styled(format!(" {unit}{sign}"), style.add_modifier(Modifier::BOLD)),
            Span::raw(format!("   {extremes}")),
        ]));
    } else {
        lines.push(Line::from(vec![
            Span::styled(
                format!(" {value} {unit}{sign}"),
                style.add_modifier(Modifier::BOLD),
            ),
            Span::raw(format!("   {extremes}")),
        ]));
    }
    lines.push(Line::raw(format!(" {state}")));
    let block = glyphs.block(format!(" {title} | {} ", gauge.name));
    area.render_widget(Paragraph::new(lines).block(block), place);
}

/// Loads with their repeats, stiffness so far, flags, zero.
fn draw_cell(area: &mut Frame<'_>, place: Rect, view: &SessionView, glyphs: Glyphs) {
    let cell = &view.cell;
    let mut lines: Vec<Line<'static>> = Vec::new();
    if let Some(so_far) = &cell.stiffness {
        lines.extend(
            labels::stiffness(so_far)
                .into_iter()
                .map(|text| Line::raw(format!(" {text}"))),
        );
    } else if let Some(why) = &cell.no_stiffness {
        lines.push(Line::raw(format!(" {why}")));
    }
    if let Some(zero) = &view.zero {
        let drift = zero.drift_m.map_or(String::new(), |drift_m| {
            let limit = labels::displacement(zero.drift_limit_m);
            format!(
                ", drift {} um (limit {limit})",
                labels::displacement(drift_m)
            )
        });
        let past = zero
            .drift_m
            .is_some_and(|drift_m| drift_m.abs() > zero.drift_limit_m);
        let style = Style::new().fg(if past { BAD } else { Color::Reset });
        lines.push(Line::styled(format!(" zero {}{drift}", zero.label), style));
    }
    lines.extend(
        cell.flags
            .iter()
            .map(|flag| Line::styled(format!(" ! {flag}"), Style::new().fg(DOUBT))),
    );
    if !cell.spreads.is_empty() {
        lines.push(Line::styled(
            "  load N   n    mean um  range um",
            Style::new().add_modifier(Modifier::DIM),
        ));
    }
    // The loads that are being worked on stay in sight.
    let above = usize::from(rows_of(&lines, place.width));
    let room = usize::from(place.height.saturating_sub(2)).saturating_sub(above);
    let first = cell.spreads.len().saturating_sub(room);
    for spread in &cell.spreads[first..] {
        let way = if spread.branch == crate::test_point::Branch::Unloading {
            "u"
        } else {
            " "
        };
        lines.push(Line::raw(format!(
            "{:>8}{way} {:>2} {:>10} {:>9}",
            labels::number(spread.target_n, 1),
            spread.n,
            labels::displacement(spread.mean_m),
            labels::displacement(spread.range_m)
        )));
    }
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    area.render_widget(text.block(glyphs.block(" This cell ".to_owned())), place);
}

fn draw_messages(area: &mut Frame<'_>, place: Rect, view: &SessionView, glyphs: Glyphs) {
    let room = place.height.saturating_sub(2);
    let mut lines: Vec<Line<'static>> = Vec::new();
    let mut rows = 0;
    for message in view.messages.iter().rev() {
        let style = Style::new().fg(if message.urgent { DOUBT } else { Color::Reset });
        let line = Line::styled(format!(" {}", message.text), style);
        rows += rows_of(std::slice::from_ref(&line), place.width);
        if rows > room {
            break;
        }
        lines.push(line);
    }
    lines.reverse();
    let text = Paragraph::new(lines).wrap(Wrap { trim: false });
    area.render_widget(text.block(glyphs.block(" Messages ".to_owned())), place);
}
