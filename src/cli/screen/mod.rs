//! The full-screen view of a guided session: what the gauges say, where the load stands, what has been measured, what is asked.
//!
//! [`Screen`] owns the terminal and puts it back however it ends. What is drawn is a pure function of the session's [`SessionView`] and of the line
//! that is being typed ([`draw`]), so that tests look at the very cells of a screen.

mod big_digits;
mod draw;
mod glyphs;
mod input;
pub(in crate::cli) mod labels;
mod load;
mod load_bar;
mod question;

use std::io::{self, Write};
use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyEventKind};

use crate::session::{Bell, Operator, OperatorEvent, Prompt, SessionView};

use draw::draw;
pub(super) use glyphs::Glyphs;
use input::TypedLine;

/// The operator at a terminal, seen on the whole of it.
pub(super) struct Screen {
    terminal: DefaultTerminal,
    input: TypedLine,
    glyphs: Glyphs,
    shown: Option<SessionView>,
    /// Whether the terminal went away: it is not asked again, and the session ends as after a Ctrl-C.
    gone: bool,
}

impl Screen {
    /// Takes the terminal over.
    ///
    /// # Errors
    /// What the system states where there is no terminal to take.
    pub(super) fn open() -> io::Result<Self> {
        Ok(Self {
            terminal: ratatui::try_init()?,
            input: TypedLine::default(),
            glyphs: Glyphs::of_locale(|name| std::env::var(name).ok()),
            shown: None,
            gone: false,
        })
    }

    fn redraw(&mut self) {
        let Some(view) = &self.shown else { return };
        let drawn = self
            .terminal
            .draw(|area| draw(area, view, &self.input, self.glyphs));
        self.gone |= drawn.is_err();
    }

    /// The next event of the terminal; `None` if there is none for so long.
    fn event(&mut self, wait: Duration) -> Option<Event> {
        match event::poll(wait).and_then(|there| there.then(event::read).transpose()) {
            Ok(event) => event,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => None,
            Err(_) => {
                self.gone = true;
                None
            }
        }
    }
}

impl Operator for Screen {
    fn show(&mut self, view: &SessionView) {
        if self.shown.as_ref() != Some(view) {
            self.input.follow(view.prompt.as_ref());
            self.shown = Some(view.clone());
            self.redraw();
        }
    }

    fn prompt(&mut self, prompt: &Prompt) {
        self.input.follow(Some(prompt));
        self.redraw();
    }

    fn poll(&mut self, wait: Duration) -> Option<OperatorEvent> {
        if self.gone {
            // The window was closed or the line to it broke: nobody can be asked any more.
            std::thread::sleep(wait);
            return self.input.terminal_is_gone();
        }
        match self.event(wait)? {
            Event::Key(key) if key.kind != KeyEventKind::Release => {
                let done = self.input.key(key);
                self.redraw();
                done
            }
            Event::Paste(text) => {
                self.input.paste(&text);
                self.redraw();
                None
            }
            Event::Resize(..) => {
                self.redraw();
                None
            }
            _ => None,
        }
    }

    fn bell(&mut self, bell: Bell) {
        let mut out = io::stdout();
        self.gone |= out
            .write_all(bell.rings())
            .and_then(|()| out.flush())
            .is_err();
    }

    /// The view holds what was said.
    fn notify(&mut self, _line: &str) {}
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

#[cfg(test)]
mod tests;
