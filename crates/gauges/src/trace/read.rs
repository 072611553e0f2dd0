//! Reading a trace, also one that was cut or damaged.

use miette::Diagnostic;

use crate::Channel;
use crate::LinkState;

use super::escape::unescaped;
use super::{TRACE_SCHEMA, TraceEntry, TraceHeader, What, role_of};

/// A trace that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeTrace {
    /// Known properties of it as a whole.
    pub header: TraceHeader,
    /// Its lines, in order of time.
    pub entries: Vec<TraceEntry>,
    /// Lines that could not be read; none of them is used.
    pub damage: Vec<DamagedLine>,
    /// Recording ended as it should; otherwise it was interrupted, or the file was cut.
    pub complete: bool,
}

/// A line that could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DamagedLine {
    /// Its number, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub problem: String,
}

/// What is no trace.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum TraceError {
    /// The first line is another.
    #[error("{file} is not a trace: its first line is not # {TRACE_SCHEMA}")]
    #[diagnostic(
        code(stiffbench::trace::schema),
        help(
            "traces are made by stiffbench gauge record and by sessions (raw/*.trace); docs/trace-file.md describes them"
        )
    )]
    NoTrace {
        /// The file.
        file: String,
    },
    /// A trace of a newer version.
    #[error("{file} is {found}; this version reads {TRACE_SCHEMA}")]
    #[diagnostic(
        code(stiffbench::trace::version),
        help("read it with the version that wrote it")
    )]
    Newer {
        /// The file.
        file: String,
        /// Its content.
        found: String,
    },
}

impl GaugeTrace {
    /// Reads a trace. Lines that are cut or damaged are listed and left out; `file` names it in errors.
    ///
    /// # Errors
    /// [`TraceError`] if the first line is not that of a trace.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, TraceError> {
        let text = String::from_utf8_lossy(bytes);
        let mut lines = text.split_inclusive('\n').enumerate();
        let first = lines.next().map_or("", |(_, line)| line.trim_end());
        match first.strip_prefix("# ") {
            Some(TRACE_SCHEMA) => {}
            Some(other) if other.starts_with("stiffbench/trace/") => {
                return Err(TraceError::Newer {
                    file: file.to_owned(),
                    found: other.to_owned(),
                });
            }
            _ => {
                return Err(TraceError::NoTrace {
                    file: file.to_owned(),
                });
            }
        }
        let mut trace = Self {
            header: TraceHeader::default(),
            entries: Vec::new(),
            damage: Vec::new(),
            complete: false,
        };
        for (place, line) in lines {
            if let Err(problem) = trace.take_line(line) {
                trace.damage.push(DamagedLine {
                    line: place + 1,
                    problem,
                });
            }
        }
        Ok(trace)
    }

    fn take_line(&mut self, line: &str) -> Result<(), String> {
        let Some(line) = line.strip_suffix('\n') else {
            return Err("it is cut: its end is missing".to_owned());
        };
        let line = line.strip_suffix('\r').unwrap_or(line);
        if line.is_empty() {
            return Ok(());
        }
        if let Some(comment) = line.strip_prefix('#') {
            self.header.take(comment.trim());
            return Ok(());
        }
        let entry = entry(line)?;
        let before_s = self
            .entries
            .last()
            .map_or(f64::NEG_INFINITY, |last| last.at_s);
        if entry.at_s < before_s {
            return Err(format!(
                "its time {:.6} s lies before that of the line above, {before_s:.6} s",
                entry.at_s
            ));
        }
        self.complete = entry.what == What::End;
        self.entries.push(entry);
        Ok(())
    }
}

impl TraceHeader {
    fn take(&mut self, comment: &str) {
        let Some((key, value)) = comment.split_once(' ') else {
            return;
        };
        let text = Some(value.to_owned());
        match key {
            "instrument" => self.instrument = text,
            "channel" => {
                self.channel = Channel::EVERY
                    .into_iter()
                    .find(|channel| channel.to_string() == value);
            }
            "unit" => self.unit = text,
            "port" => self.port = text,
            "line" => self.line = text,
            "started" => self.started = text,
            "speed" => {
                self.speed = value
                    .parse()
                    .ok()
                    .filter(|speed: &f64| speed.is_finite() && *speed > 0.0);
            }
            // A comment.
            _ => {}
        }
    }
}

fn entry(line: &str) -> Result<TraceEntry, String> {
    let (time, rest) = word(line);
    let at_s: f64 = time
        .parse()
        .map_err(|_| format!("{time:?} is not a time"))?;
    if !at_s.is_finite() {
        return Err(format!("{time:?} is not a time"));
    }
    let (mark, rest) = word(rest);
    let what = match mark {
        "<" => What::Received(counted(rest)?),
        ">" => {
            let (role, rest) = word(rest);
            What::Sent {
                role: role_of(role),
                bytes: counted(rest)?,
            }
        }
        "-" => event(rest)?,
        _ => return Err(format!("{mark:?} must be <, > or -")),
    };
    Ok(TraceEntry { at_s, what })
}

/// Bytes behind their count.
fn counted(text: &str) -> Result<Vec<u8>, String> {
    let (count, rest) = word(text);
    let count: usize = count
        .parse()
        .map_err(|_| format!("{count:?} is not a count of bytes"))?;
    let bytes = unescaped(rest).ok_or_else(|| "it holds an invalid escape".to_owned())?;
    if bytes.len() == count {
        Ok(bytes)
    } else {
        Err(format!(
            "it should hold {count} bytes and holds {}",
            bytes.len()
        ))
    }
}

fn event(text: &str) -> Result<What, String> {
    let (kind, rest) = word(text);
    match kind {
        "unused" => {
            let (count, reason) = word(rest);
            let count = count
                .parse()
                .map_err(|_| format!("{count:?} is not a count of values"))?;
            Ok(What::Unused {
                count,
                reason: reason.to_owned(),
            })
        }
        "reset" => Ok(What::Reset),
        "note" => Ok(What::Note(rest.to_owned())),
        "end" => Ok(What::End),
        "link" => link(rest)
            .map(What::Link)
            .ok_or_else(|| format!("{rest:?} is not a state of a line")),
        _ => Err(format!("{kind:?} is not an event of a trace")),
    }
}

fn link(text: &str) -> Option<LinkState> {
    let (state, rest) = word(text);
    Some(match state {
        "connected" => LinkState::Connected { port: rest.into() },
        "silent" => LinkState::Silent,
        "slow" => LinkState::Slow {
            reason: rest.into(),
        },
        "lost" => LinkState::Lost {
            reason: rest.into(),
        },
        "reconnecting" => LinkState::Reconnecting {
            attempt: rest.parse().ok()?,
        },
        "wrong-device" => LinkState::WrongDevice {
            reason: rest.into(),
        },
        "given-up" => LinkState::GivenUp,
        _ => return None,
    })
}

/// The first word and what follows the blank behind it.
fn word(text: &str) -> (&str, &str) {
    text.split_once(' ').unwrap_or((text, ""))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use crate::description::CommandRole;
    use crate::trace::TraceWriter;

    use super::*;

    fn header() -> TraceHeader {
        TraceHeader {
            instrument: Some("mark10-series5".to_owned()),
            channel: Some(Channel::Force),
            unit: Some("N".to_owned()),
            port: Some("USB 0403:6001 serial A at 1-1:1.0".to_owned()),
            line: Some("115200 8N1".to_owned()),
            started: Some("2026-11-20T10:00:00Z".to_owned()),
            speed: Some(50.0),
        }
    }

    fn entries() -> Vec<TraceEntry> {
        let whats = [
            What::Link(LinkState::Connected {
                port: "/dev/pts/3".into(),
            }),
            What::Sent {
                role: Some(CommandRole::Read),
                bytes: b"?\r".to_vec(),
            },
            What::Received(b"\x00 4.285 N\r\n ".to_vec()),
            What::Unused {
                count: 1,
                reason: "first after opening".to_owned(),
            },
            What::Reset,
            What::Link(LinkState::Silent),
            What::Link(LinkState::Slow {
                reason: "answers later than 0.5 s".into(),
            }),
            What::Link(LinkState::Lost {
                reason: "Broken pipe".into(),
            }),
            What::Link(LinkState::Reconnecting { attempt: 3 }),
            What::Link(LinkState::WrongDevice {
                reason: "another".into(),
            }),
            What::Link(LinkState::GivenUp),
            What::Note("two\nlines".to_owned()),
            What::Received(Vec::new()),
            What::Sent {
                role: None,
                bytes: vec![3],
            },
            What::End,
        ];
        whats
            .into_iter()
            .enumerate()
            .map(|(i, what)| TraceEntry {
                at_s: i as f64 * 0.25,
                what,
            })
            .collect()
    }

    fn written(entries: &[TraceEntry]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = TraceWriter::begin(&mut bytes, &header()).unwrap();
        for entry in entries {
            writer.write(entry).unwrap();
        }
        bytes
    }

    #[test]
    fn what_is_written_is_read_again() {
        let trace = GaugeTrace::parse(&written(&entries()), "t").unwrap();
        assert_eq!(trace.header, header());
        let mut expected = entries();
        expected[11].what = What::Note("two lines".to_owned());
        assert_eq!(trace.entries, expected);
        assert_eq!(trace.damage, []);
        assert!(trace.complete);
    }

    #[test]
    fn a_trace_cut_anywhere_gives_what_stands_before_the_cut() {
        let whole = written(&entries());
        let all = GaugeTrace::parse(&whole, "t").unwrap().entries;
        let head = written(&[]).len();
        for cut in head..whole.len() {
            let trace = GaugeTrace::parse(&whole[..cut], "t").unwrap();
            assert!(!trace.complete, "cut at {cut}");
            assert_eq!(trace.entries, all[..trace.entries.len()], "cut at {cut}");
            let is_between_lines = whole[cut - 1] == b'\n';
            assert_eq!(
                trace.damage.len(),
                usize::from(!is_between_lines),
                "cut at {cut}"
            );
            let lines = whole[head..cut].split(|byte| *byte == b'\n').count() - 1;
            assert_eq!(trace.entries.len(), lines, "cut at {cut}");
        }
    }

    #[test]
    fn damaged_lines_are_named_and_left_out() {
        let text = "# stiffbench/trace/1\n0.1 < 3 abc\n0.2 < 4 abc\n0.15 < 1 a\n0.05 < 1 a\nx < 1 a\n0.3 ? 1 a\n0.4 < 2 \\x4\n0.5 - leap\n";
        let trace = GaugeTrace::parse(text.as_bytes(), "t").unwrap();
        assert_eq!(trace.entries.len(), 2);
        let lines: Vec<usize> = trace.damage.iter().map(|damage| damage.line).collect();
        assert_eq!(lines, [3, 5, 6, 7, 8, 9]);
        assert_eq!(
            trace.damage[0].problem,
            "it should hold 4 bytes and holds 3"
        );
    }

    #[test]
    fn what_is_no_trace_is_refused() {
        for text in ["", "time,force\n", "# stiffbench/session/1\n"] {
            assert!(matches!(
                GaugeTrace::parse(text.as_bytes(), "t"),
                Err(TraceError::NoTrace { .. })
            ));
        }
        let newer = GaugeTrace::parse(b"# stiffbench/trace/2\n", "t");
        assert!(matches!(newer, Err(TraceError::Newer { .. })));
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes: Vec<u8>) {
            let mut text = b"# stiffbench/trace/1\n".to_vec();
            text.extend(bytes);
            prop_assert!(GaugeTrace::parse(&text, "t").is_ok());
        }
    }
}
