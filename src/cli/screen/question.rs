//! The open question, how it is answered, and the keys that mean something.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use crate::session::{PromptKind, SessionView};

use super::draw::BAD;
use super::input::{Mode, TypedLine};

/// The open question with the line that is being typed; empty if nothing is asked.
pub(super) fn question(view: &SessionView, input: &TypedLine) -> Vec<Line<'static>> {
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
        Mode::Note(prompt) => {
            let back = if prompt.is_some() {
                "Enter keeps it, Esc leaves it; then the question"
            } else {
                "Enter keeps it, Esc leaves it"
            };
            vec![
                Line::styled(" A note on this cell:", bold),
                typed(&input.line, back),
            ]
        }
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
fn answers(kind: &PromptKind, input: &TypedLine) -> Vec<Line<'static>> {
    match kind {
        PromptKind::Text => vec![typed(&input.line, "Enter")],
        PromptKind::Number { unit, range } => {
            vec![typed(
                &input.line,
                &format!("{} to {} {unit}, Enter", range[0], range[1]),
            )]
        }
        PromptKind::Confirm => vec![Line::raw(" y  yes    n  no    Enter  as proposed")],
        PromptKind::Choice(choices) => {
            let lines = choices.iter().map(|choice| {
                let chosen = choice.word == input.line;
                let enter = match (choice.harmless, chosen) {
                    (true, _) => "",
                    (false, true) => "  <- Enter",
                    (false, false) => "  (and Enter)",
                };
                let text = format!(" {}  {}: {}{enter}", choice.key, choice.word, choice.text);
                let style = Style::new();
                let style = if chosen {
                    style.add_modifier(Modifier::BOLD)
                } else {
                    style
                };
                Line::styled(text, style)
            });
            lines.collect()
        }
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
pub(super) fn keys(input: &TypedLine) -> &'static str {
    match input.mode {
        Mode::Orders => {
            " any key: take  r redo  g go to  s skip, S cell  n note  p pause  Ctrl-C end, twice stop"
        }
        Mode::Asked(_) => {
            " n note (Ctrl-N where n is an answer or text)  Ctrl-C finish, twice stop"
        }
        Mode::Goto | Mode::Note(_) => " Ctrl-C finish, twice stop",
    }
}
