//! Writing a trace.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::{CommandRole, LinkState};

use super::escape::escaped;
use super::{TRACE_SCHEMA, TraceEntry, TraceHeader, What};

/// Writes a trace line by line, each whole before the next.
#[derive(Debug)]
pub struct TraceWriter<W> {
    to: W,
}

impl<W: Write> TraceWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// The content of `to`.
    pub fn begin(mut to: W, header: &TraceHeader) -> io::Result<Self> {
        let mut text = format!("# {TRACE_SCHEMA}\n");
        for (key, value) in header.fields() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "# {key} {}", one_line(&value));
        }
        to.write_all(text.as_bytes())?;
        to.flush()?;
        Ok(Self { to })
    }

    /// Writes one entry.
    ///
    /// # Errors
    /// The content of the file.
    pub fn write(&mut self, entry: &TraceEntry) -> io::Result<()> {
        self.to.write_all(line(entry).as_bytes())
    }

    /// Hands everything to the file; what makes it durable is up to the file.
    ///
    /// # Errors
    /// The content of the file.
    pub fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn line(entry: &TraceEntry) -> String {
    let what = match &entry.what {
        What::Received(bytes) => format!("< {} {}", bytes.len(), escaped(bytes)),
        What::Sent { role, bytes } => {
            let word = role.map_or("other", CommandRole::key);
            format!("> {word} {} {}", bytes.len(), escaped(bytes))
        }
        What::Unused { count, reason } => format!("- unused {count} {}", one_line(reason)),
        What::Reset => "- reset".to_owned(),
        What::Link(state) => format!("- link {}", link(state)),
        What::Note(text) => format!("- note {}", one_line(text)),
        What::End => "- end".to_owned(),
    };
    format!("{:.6} {what}\n", entry.at_s)
}

fn link(state: &LinkState) -> String {
    match state {
        LinkState::Connected { port } => format!("connected {}", one_line(port)),
        LinkState::Silent => "silent".to_owned(),
        LinkState::Slow { reason } => format!("slow {}", one_line(reason)),
        LinkState::Lost { reason } => format!("lost {}", one_line(reason)),
        LinkState::Reconnecting { attempt } => format!("reconnecting {attempt}"),
        LinkState::WrongDevice { reason } => format!("wrong-device {}", one_line(reason)),
        LinkState::GivenUp => "given-up".to_owned(),
    }
}

/// Text on one line; anything but what can be read back from a line becomes a blank.
fn one_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").replace(char::is_control, " ")
}
