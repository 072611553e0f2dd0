//! Text of XML files, escaped, with comments and numbers that read back as they are.

use std::fmt::Display;

use quick_xml::Writer;
use quick_xml::events::{BytesEnd, BytesStart, BytesText, Event};

/// Digits that a number of a file has: more than any robot is known to, and few enough that 0.00012 is not 0.00011999999999999999.
const DIGITS: usize = 12;

/// An XML text that grows.
pub(super) struct Xml {
    writer: Writer<Vec<u8>>,
    open: Vec<String>,
}

/// Attributes of an element.
pub(super) type Attributes<'a> = &'a [(&'a str, String)];

impl Xml {
    /// An empty document with its declaration and comments, one each.
    pub(super) fn new(comments: &[String]) -> Self {
        let mut xml = Self {
            writer: Writer::new_with_indent(Vec::new(), b' ', 2),
            open: Vec::new(),
        };
        xml.write(Event::Decl(quick_xml::events::BytesDecl::new(
            "1.0",
            Some("UTF-8"),
            None,
        )));
        for comment in comments {
            xml.comment(comment);
        }
        xml
    }

    /// Begins an element that holds others.
    pub(super) fn open(&mut self, name: &str, attributes: Attributes<'_>) {
        self.write(Event::Start(element(name, attributes)));
        self.open.push(name.to_owned());
    }

    /// Begins a joint.
    pub(super) fn open_joint(&mut self, name: &str, kind: &str) {
        let attributes = [("name", name), ("type", kind)];
        self.open(
            "joint",
            &attributes.map(|(key, value)| (key, value.to_owned())),
        );
    }

    /// Ends the element begun last.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.write(Event::End(BytesEnd::new(name)));
        }
    }

    /// An element that holds nothing.
    pub(super) fn empty(&mut self, name: &str, attributes: Attributes<'_>) {
        self.write(Event::Empty(element(name, attributes)));
    }

    /// An element that holds a text.
    pub(super) fn text(&mut self, name: &str, text: impl Display) {
        self.write(Event::Start(BytesStart::new(name)));
        self.write(Event::Text(BytesText::new(&allowed(&text.to_string()))));
        self.write(Event::End(BytesEnd::new(name)));
    }

    /// A comment; two hyphens, which end one, are parted.
    pub(super) fn comment(&mut self, text: &str) {
        let mut parted = allowed(text);
        while parted.contains("--") {
            parted = parted.replace("--", "- -");
        }
        self.write(Event::Comment(BytesText::from_escaped(format!(
            " {parted} "
        ))));
    }

    /// The document, with what is still open closed.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        let mut text = String::from_utf8_lossy(&self.writer.into_inner()).into_owned();
        text.push('\n');
        text
    }

    fn write(&mut self, event: Event<'_>) {
        self.writer
            .write_event(event)
            .expect("memory takes whatever is written");
    }
}

fn element(name: &str, attributes: Attributes<'_>) -> BytesStart<'static> {
    let mut start = BytesStart::new(name.to_owned());
    for (key, value) in attributes {
        start.push_attribute((*key, allowed(value).as_str()));
    }
    start
}

/// A text without the characters that XML 1.0 has no way to hold (section 2.2).
fn allowed(text: &str) -> String {
    let is_allowed = |c: char| !c.is_control() || matches!(c, '\t' | '\n' | '\r');
    let is_allowed = |c: char| is_allowed(c) && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let kept = text.chars().map(|c| if is_allowed(c) { c } else { '_' });
    kept.collect()
}

/// A number to twelve digits.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

/// A number to twelve digits, in the shortest form that reads back as it.
#[must_use]
pub fn number(value: f64) -> String {
    let rounded = rounded(value);
    let size = rounded.abs();
    if rounded == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e12).contains(&size) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// Numbers with blanks between them.
pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    let texts: Vec<String> = values.into_iter().map(number).collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back() {
        for (value, text) in [
            (100.0 * 1.2e-6, "0.00012"),
            (-0.0, "0"),
            (1e-17 - 1e-17, "0"),
            (1.0 / 3.0, "0.333333333333"),
            (4.2e-6, "4.2e-6"),
            (2.5e13, "2.5e13"),
            (70.0, "70"),
        ] {
            assert_eq!(number(value), text);
            let back: f64 = text.parse().unwrap();
            assert!((back - value).abs() <= 1e-11 * value.abs());
        }
    }

    #[test]
    fn names_and_comments_cannot_break_a_document() {
        let name = "a\"<b>&'\u{1}--é";
        let mut xml = Xml::new(&["x -- y --->".to_owned(), name.to_owned()]);
        xml.open("robot", &[("name", name.to_owned())]);
        xml.text("model", name);
        let text = xml.finish();
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("name"), Some("a\"<b>&'_--é"));
        let model = root.first_element_child().unwrap();
        assert_eq!(model.text(), Some("a\"<b>&'_--é"));
    }
}
