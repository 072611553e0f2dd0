//! Characters for bars and borders, by what the terminal can show.

use ratatui::symbols::border;
use ratatui::widgets::Block;

use super::load_bar::BarCell;
use crate::cli::locale::{is_utf8, locale};

/// Characters for bars and borders: those of Unicode, or plain ones where the locale has no UTF-8.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cli) struct Glyphs {
    unicode: bool,
}

impl Glyphs {
    /// What the locale allows; without one plain characters.
    pub(in crate::cli) fn of_locale(variable: impl Fn(&str) -> Option<String>) -> Self {
        let unicode = locale(variable).is_some_and(|locale| is_utf8(&locale));
        Self { unicode }
    }

    /// The character of a cell of the bar: distinguished without colour too.
    pub(super) fn cell(self, cell: BarCell) -> char {
        let (unicode, plain) = match cell {
            BarCell::Empty => ('·', '.'),
            BarCell::Load => ('█', '='),
            BarCell::TooMuch => ('▓', '!'),
            BarCell::Band => ('░', 'o'),
            BarCell::BandReached => ('▒', '#'),
            BarCell::Zero => ('┃', '|'),
        };
        if self.unicode { unicode } else { plain }
    }

    pub(super) fn ink(self) -> char {
        if self.unicode { '█' } else { '#' }
    }

    pub(super) fn block(self, title: String) -> Block<'static> {
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
