//! Drawings as they stand in the data of a page: deflated, in base64. So a page holds them twice and stays small.

use std::collections::HashMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::deflate::compress_to_vec_zlib;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use serde::Serializer;
use serde_json::Value;

/// Level of compression.
const LEVEL: u8 = 9;
/// No drawing is larger, bytes.
const LARGEST: usize = 8 << 20;
/// Fonts of the drawings.
const FONTS: &str = " font-family=\"DejaVu Sans, Verdana, sans-serif\"";
/// The same as a property of the whole drawing.
const FONTS_OF_ALL: &str = " style=\"font-family:DejaVu Sans,Verdana,sans-serif\"";
/// What is said by leaving it out; the last is of the namespace, which inline SVG does not need: a page names no address.
const USUAL: [&str; 5] = [
    " opacity=\"1\"",
    " stroke=\"none\" stroke-width=\"0\"",
    " stroke=\"none\"",
    " text-anchor=\"start\"",
    " xmlns=\"http://www.w3.org/2000/svg\"",
];

/// The element with the data of a page.
const DATA_TAG: &str = "<script type=\"application/json\" id=\"stiffbench-data\">";

/// Words of the tags of a drawing: elements, their ends, attributes. Another one makes the drawing none.
#[rustfmt::skip]
const WORDS: [&str; 42] = [
    "", "/", "circle", "/circle", "desc", "/desc", "line", "/line", "polygon", "/polygon", "polyline", "/polyline", "rect", "/rect",
    "svg", "/svg", "text", "/text", "title", "/title", "cx=", "cy=", "dy=", "fill=", "font-size=", "height=", "opacity=", "points=",
    "r=", "role=", "stroke=", "stroke-width=", "text-anchor=", "transform=", "viewBox=", "width=", "x=", "x1=", "x2=", "y=", "y1=",
    "y2=",
];

/// Further words of the tags of a page around its drawings.
#[rustfmt::skip]
const PAGE_WORDS: [&str; 72] = [
    "!DOCTYPE", "html", "/html", "head", "/head", "meta", "style", "/style", "body", "/body", "div", "/div", "span", "/span", "header",
    "/header", "h1", "/h1", "h2", "/h2", "h3", "/h3", "h4", "/h4", "p", "/p", "strong", "/strong", "main", "/main", "section", "/section",
    "dl", "/dl", "dt", "/dt", "dd", "/dd", "ul", "/ul", "li", "/li", "table", "/table", "thead", "/thead", "tbody", "/tbody", "tr", "/tr",
    "th", "/th", "td", "/td", "pre", "/pre", "code", "/code", "small", "/small", "br", "figure", "/figure", "/script",
    "class=", "lang=", "charset=", "name=", "content=", "scope=", "aria-hidden=", "aria-label=",
];

/// What a style sheet does not have: it would hide what stands on the page, or fetch something.
#[rustfmt::skip]
const HIDING: [&str; 9] = [
    "display:none", "visibility:", "opacity:", "clip", "text-indent", "font-size:0", "transparent", "url(", "@import",
];

/// A drawing for a page, without what goes without saying.
pub(super) fn lean(svg: &str) -> String {
    let mut lean = svg.replace(FONTS, "");
    for usual in USUAL {
        lean = lean.replace(usual, "");
    }
    let start = lean.find("<svg").unwrap_or(0);
    let drawing = lean[start..].trim_end();
    drawing.replacen("<svg", &format!("<svg{FONTS_OF_ALL}"), 1)
}

/// Writes a drawing into the data of a page.
pub(super) fn pack<S: Serializer>(svg: &str, serializer: S) -> Result<S::Ok, S::Error> {
    let packed = compress_to_vec_zlib(svg.as_bytes(), LEVEL);
    serializer.serialize_str(&STANDARD.encode(packed))
}

/// Puts the drawings themselves in the place of packed ones, and into the figures of the body; of what is no drawing nothing is left.
pub(super) fn unpack_all(data: &mut Value) {
    let sections = data.get_mut("figures").and_then(Value::as_object_mut);
    let figures = sections
        .into_iter()
        .flat_map(|sections| sections.values_mut());
    let figures = figures.filter_map(Value::as_array_mut).flatten();
    let mut drawings: HashMap<Value, Value> = HashMap::new();
    for figure in figures {
        if let Some(svg) = figure.get_mut("svg") {
            let text = svg.as_str().and_then(unpack).unwrap_or_default();
            *svg = Value::String(text);
            drawings.insert(figure["name"].clone(), figure["svg"].clone());
        }
    }
    let blocks = data.get_mut("body").and_then(Value::as_array_mut);
    for block in blocks.into_iter().flatten() {
        if block["kind"] == "figure" {
            block["svg"] = drawings.get(&block["name"]).cloned().unwrap_or_default();
        }
    }
}

fn unpack(packed: &str) -> Option<String> {
    let bytes = STANDARD.decode(packed).ok()?;
    let text = decompress_to_vec_zlib_with_limit(&bytes, LARGEST).ok()?;
    String::from_utf8(text).ok().filter(|svg| is_drawing(svg))
}

/// Whether every tag is one of a drawing in its plainest form: it shows shapes and text, and neither acts, hides nor fetches.
fn is_drawing(svg: &str) -> bool {
    let svg = svg.replacen(FONTS_OF_ALL, "", 1);
    let mut tags = svg.split('<').skip(1);
    tags.all(|tag| {
        let tag = tag.split_once('>');
        let is_inert = |value: &str| value.starts_with("rotate(") || !value.contains('(');
        tag.is_some_and(|(tag, _)| is_plain(tag, &[&WORDS], is_inert))
    })
}

/// Whether the words of a tag are known, and its values neither act nor fetch.
fn is_plain(tag: &str, known: &[&[&str]], is_inert: impl Fn(&str) -> bool) -> bool {
    let parts: Vec<&str> = tag.split('"').collect();
    let mut words = parts.iter().step_by(2).flat_map(|part| part.split(' '));
    let mut values = parts.iter().skip(1).step_by(2);
    parts.len() % 2 == 1
        && words.all(|word| known.iter().any(|words| words.contains(&word)))
        && values.all(|value| is_inert(value) && !value.contains('\\'))
}

/// What no report has, whatever its template: elements that act or fetch, and styles that hide; each with its line, from 1.
pub(super) fn foreign_markup(page: &str) -> Vec<(usize, String)> {
    let is_inert = |value: &str| !value.to_lowercase().contains("url(");
    let page = page.replace(FONTS_OF_ALL, "").replacen(DATA_TAG, "<br>", 1);
    let mut foreign = Vec::new();
    let mut line = 1;
    for (place, part) in page.split('<').enumerate() {
        let tag = part.split_once('>').map_or(part, |(tag, _)| tag);
        if place > 0 && !is_plain(tag, &[&WORDS, &PAGE_WORDS], is_inert) {
            foreign.push((line, format!("<{tag}>")));
        }
        if let Some(sheet) = part.strip_prefix("style>") {
            let sheet = sheet.split_whitespace().collect::<String>().to_lowercase();
            let hiding = HIDING.iter().find(|hiding| sheet.contains(*hiding));
            foreign.extend(hiding.map(|hiding| (line, format!("{hiding} in a style sheet"))));
        }
        line += part.matches('\n').count();
    }
    foreign
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_drawing_is_the_same_afterwards_and_rubbish_is_none() {
        let svg = "<svg><text x=\"1\">1.5 µm</text></svg>";
        let packed = pack(svg, serde_json::value::Serializer).unwrap();
        let figures = json!({"readings": [{"svg": packed}, {"svg": "no base64!"}]});
        let mut data = json!({"figures": figures});
        unpack_all(&mut data);
        assert_eq!(data["figures"]["readings"][0]["svg"], svg);
        assert_eq!(data["figures"]["readings"][1]["svg"], "");
        assert!(unpack("AAAA").is_none());
    }

    #[test]
    fn a_drawing_shows_shapes_and_text_and_does_nothing() {
        let good = format!(
            "<svg{FONTS_OF_ALL} width=\"1\" role=\"img\"><desc>a</desc><text x=\"1\" transform=\"rotate(270, 1, 2)\">K = 9 &lt;script></text><rect x=\"1\"/></svg>"
        );
        assert!(is_drawing(&good));
        #[rustfmt::skip]
        let others = [
            "<script>a()</script>", "<SCRIPT>", "<svg onload=\"x\">", "<svg/onload=x>", "<svg\nonload=\"x\">", "<rect x=\"1\" onclick=\"a\"/>",
            "<rect x=\"1\"onclick=\"a\"/>", "<rect x='1'/>", "<rect x=1/>", "<rect x=\"1\"", "<svg class=\"mark\">", "<svg style=\"position:fixed\">",
            "<style>", "<foreignObject>", "<a href=\"x\">", "<use href=\"#a\"/>", "<image href=\"x\"/>", "<animate/>", "<p>", "</figure>", "<",
            "<!--><script>-->", "<![CDATA[x]]>", "<?x ?>", "<rect fill=\"url(x)\"/>", "<rect fill=\"u\\72l(x)\"/>",
            "<rect x=\"1><text y=\" onload=\" fill=\">",
        ];
        for other in others {
            assert!(!is_drawing(other), "{other}");
        }
    }

    #[test]
    fn a_lean_drawing_keeps_its_fonts_and_names_no_address() {
        let svg = format!(
            "<?xml?><svg width=\"1\" xmlns=\"http://www.w3.org/2000/svg\"><text{FONTS} opacity=\"1\">a</text></svg>\n"
        );
        let expected = format!("<svg{FONTS_OF_ALL} width=\"1\"><text>a</text></svg>");
        assert_eq!(lean(&svg), expected);
    }
}
