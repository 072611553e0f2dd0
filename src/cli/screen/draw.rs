//! A view of the session as cells of a screen.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::border;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Wrap};

use crate::quantity::METRES_PER_MICROMETRE;
use crate::session::{GaugeView, PromptKind, SettleView, View};

use super::big_digits;
use super::input::{Input, Mode};
use super::load_bar::{Cell, load_bar};
use super::words;

/// Characters for bars and borders: those of Unicode, or plain ones where the locale has no UTF-8.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Glyphs {
    unicode: bool,
}

impl Glyphs {
    /// What the locale's variables (`LC_ALL`, `LC_CTYPE`, `LANG`, the first that is set) allow.
    pub(super) fn of_locale(variable: impl Fn(&str) -> Option<String>) -> Self {
        let names = ["LC_ALL", "LC_CTYPE", "LANG"];
        let set = names
            .into_iter()
            .filter_map(variable)
            .find(|value| !value.is_empty());
        let unicode = set.is_some_and(|value| {
            let value = value.to_ascii_lowercase();
            value.contains("utf-8") || value.contains("utf8")
        });
        Self { unicode }
    }

    /// The character of a cell of the bar: told apart without colour too.
    fn cell(self, cell: Cell) -> char {
        match (self.unicode, cell) {
            (true, Cell::Empty) => '·',
            (true, Cell::Load) => '█',
            (true, Cell::TooMuch) => '▓',
            (true, Cell::Band) => '░',
            (true, Cell::BandReached) => '▒',
            (true, Cell::Zero) => '┃',
            (false, Cell::Empty) => '.',
            (false, Cell::Load) => '=',
            (false, Cell::TooMuch) => '!',
            (false, Cell::Band) => 'o',
            (false, Cell::BandReached) => '#',
            (false, Cell::Zero) => '|',
        }
    }

    fn ink(self) -> char {
        if self.unicode { '█' } else { '#' }
    }

    fn block(self, title: String) -> Block<'static> {
        let plain = border::Set {
            top_left: "+",
            top_right: "+",
            bottom_left: "+",
            bottom_right: "+",
            vertical_left: "|",
            vertical_right: "|",
            horizontal_top: "-",
            horizontal_bottom: "-",
        };
        let set = if self.unicode { border::PLAIN } else { plain };
        Block::bordered().border_set(set).title(title)
    }
}

/// Below this many rows the big digits and the list of readings give way.
const ROWS_FOR_BIG_DIGITS: u16 = 30;

const GOOD: Color = Color::Cyan;
const DOUBT: Color = Color::Yellow;
const BAD: Color = Color::LightRed;

/// Draws everything.
pub(super) fn draw(area: &mut Frame<'_>, view: &View, input: &Input, glyphs: Glyphs) {
    let whole = area.area();
    let big = whole.height >= ROWS_FOR_BIG_DIGITS && whole.width >= 76;
    let notices = notices(view);
    let asked = question(view, input);
    let question_rows = if asked.is_empty() {
        0
    } else {
        rows_of(&asked, whole.width) + 2
    };
    let [header, gauges, load, below, question_area, footer] = Layout::vertical([
        Constraint::Length(1 + rows_of(&notices, whole.width + 2).min(3)),
        Constraint::Length(if big { 10 } else { 4 }),
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
    draw_gauge(area, displacement, &view.displacement, um, big, glyphs);
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
fn notices(view: &View) -> Vec<Line<'static>> {
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

fn header_lines(view: &View, notices: Vec<Line<'static>>) -> Vec<Line<'static>> {
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
            words::duration(progress.left_s)
        )),
    ])];
    lines.extend(notices);
    lines
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
    let doubtful = gauge.stale || !gauge.link.is_empty() || gauge.value_si.is_none();
    let style = Style::new().fg(if doubtful { BAD } else { Color::Reset });
    let value = words::value(gauge, si_per_unit);
    let rate = gauge
        .rate_hz
        .map_or(String::new(), |rate| format!(", {rate:.0}/s"));
    let raw = match gauge.raw.as_str() {
        "" => String::new(),
        raw => format!(" | sent: {raw}"),
    };
    let state = match (gauge.link.as_str(), gauge.stale) {
        ("", true) => format!("STALE, {}{raw}", words::age(gauge.age_s)),
        ("", false) => format!("{}{rate}{raw}", words::age(gauge.age_s)),
        (link, _) => link.to_owned(),
    };
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
        lines.push(Line::styled(
            format!(" {unit}{sign}"),
            style.add_modifier(Modifier::BOLD),
        ));
    } else {
        let line = format!(" {value} {unit}{sign}");
        lines.push(Line::styled(line, style.add_modifier(Modifier::BOLD)));
    }
    lines.push(Line::raw(format!(" {state}")));
    let block = glyphs.block(format!(" {title} | {} ", gauge.name));
    area.render_widget(Paragraph::new(lines).block(block), place);
}

/// What to do, the bar, and how far the gauges have settled.
fn draw_load(area: &mut Frame<'_>, place: Rect, view: &View, glyphs: Glyphs) {
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
fn order(view: &View) -> Line<'static> {
    let mut spans = vec![Span::styled(
        format!(" {}", words::task(&view.task)),
        Style::new().add_modifier(Modifier::BOLD),
    )];
    if let (Some(band), Some(force_n)) = (&view.band, view.force.value_si) {
        let to_go = words::to_go(force_n, band.target_n, band.tolerance_n);
        let style = Style::new().fg(if band.inside { GOOD } else { DOUBT });
        spans.push(Span::styled(format!("   {to_go}"), style));
        if band.overshoot_n > band.tolerance_n {
            let past = format!("   went {:.1} N past it", band.overshoot_n);
            spans.push(Span::styled(past, Style::new().fg(BAD)));
        }
    }
    Line::from(spans)
}

fn style_of(cell: Cell) -> Style {
    match cell {
        Cell::Empty | Cell::Zero => Style::new().add_modifier(Modifier::DIM),
        Cell::Load => Style::new(),
        Cell::TooMuch => Style::new().fg(BAD),
        Cell::Band => Style::new().fg(DOUBT),
        Cell::BandReached => Style::new().fg(GOOD),
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

/// Loads with their repeats, stiffness so far, flags, zero.
fn draw_cell(area: &mut Frame<'_>, place: Rect, view: &View, glyphs: Glyphs) {
    let cell = &view.cell;
    let mut lines: Vec<Line<'static>> = Vec::new();
    if let Some(so_far) = &cell.stiffness {
        lines.extend(
            words::stiffness(so_far)
                .into_iter()
                .map(|text| Line::raw(format!(" {text}"))),
        );
    } else if let Some(why) = &cell.no_stiffness {
        lines.push(Line::raw(format!(" {why}")));
    }
    if let Some(zero) = &view.zero {
        let drift = zero.drift_m.map_or(String::new(), |drift_m| {
            let limit = words::displacement(zero.drift_limit_m);
            format!(
                ", drift {} um (limit {limit})",
                words::displacement(drift_m)
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
    let room = usize::from(place.height.saturating_sub(2)).saturating_sub(lines.len());
    let first = cell.spreads.len().saturating_sub(room);
    for spread in &cell.spreads[first..] {
        let way = if spread.branch == crate::test_point::Branch::Unloading {
            "u"
        } else {
            " "
        };
        lines.push(Line::raw(format!(
            "{:>8}{way} {:>2} {:>10} {:>9}",
            words::number(spread.target_n, 1),
            spread.n,
            words::displacement(spread.mean_m),
            words::displacement(spread.range_m)
        )));
    }
    area.render_widget(
        Paragraph::new(lines).block(glyphs.block(" This cell ".to_owned())),
        place,
    );
}

fn draw_messages(area: &mut Frame<'_>, place: Rect, view: &View, glyphs: Glyphs) {
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

/// The open question with the line that is being typed; empty if nothing is asked.
fn question(view: &View, input: &Input) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut lines = match &input.mode {
        Mode::Orders => return Vec::new(),
        Mode::Goto => {
            let cells = view.place.as_ref().map_or(0, |place| place.cells);
            vec![
                Line::styled(format!(" Go on with which cell, 1 to {cells}?"), bold),
                typed(&input.line, "Enter goes there, Esc stays here"),
            ]
        }
        Mode::Skip => vec![
            Line::styled(" Skip what?", bold),
            Line::raw(" r  this reading    c  what is open in this cell    Esc  nothing"),
        ],
        Mode::Asked(prompt) => {
            let mut lines = vec![Line::styled(format!(" {}", prompt.text), bold)];
            lines.extend(
                prompt
                    .details
                    .iter()
                    .map(|text| Line::raw(format!(" {text}"))),
            );
            lines.extend(answers(&prompt.kind, input));
            lines
        }
    };
    if let Some(complaint) = &input.complaint {
        lines.push(Line::styled(
            format!(" ! {complaint}"),
            Style::new().fg(BAD),
        ));
    }
    lines
}

/// How a question is answered.
fn answers(kind: &PromptKind, input: &Input) -> Vec<Line<'static>> {
    match kind {
        PromptKind::Text => vec![typed(&input.line, "Enter")],
        PromptKind::Number { unit, range } => {
            vec![typed(
                &input.line,
                &format!("{} to {} {unit}, Enter", range[0], range[1]),
            )]
        }
        PromptKind::Confirm => vec![Line::raw(" y  yes    n  no    Enter  as proposed")],
        PromptKind::Choice(choices) => choices
            .iter()
            .map(|choice| {
                let key = choice.word.chars().next().unwrap_or(' ');
                Line::raw(format!(" {key}  {}: {}", choice.word, choice.text))
            })
            .collect(),
        PromptKind::Checklist(items) => items
            .iter()
            .enumerate()
            .map(|(place, item)| {
                let tick = match place.cmp(&input.ticked) {
                    std::cmp::Ordering::Less => "[x]",
                    std::cmp::Ordering::Equal => "[ ] <-",
                    std::cmp::Ordering::Greater => "[ ]",
                };
                Line::raw(format!(" {tick} {item}"))
            })
            .chain([Line::raw(" Enter, any key or pedal ticks the next")])
            .collect(),
    }
}

fn typed(line: &str, hint: &str) -> Line<'static> {
    Line::from(vec![
        Span::raw(format!(" > {line}")),
        Span::styled(" ", Style::new().add_modifier(Modifier::REVERSED)),
        Span::styled(
            format!("  ({hint})"),
            Style::new().add_modifier(Modifier::DIM),
        ),
    ])
}

/// The keys that mean something now.
fn keys(input: &Input) -> &'static str {
    match input.mode {
        Mode::Orders => {
            " any key: take  r redo  g go to  s skip  n note  p pause  Ctrl-C finish, twice stop"
        }
        _ => " Ctrl-C finish, twice stop",
    }
}
