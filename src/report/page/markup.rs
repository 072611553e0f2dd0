//! What a drawing and a page may consist of: elements that show something, and none that acts, hides or fetches.

use super::packed::FONTS_OF_ALL;

/// Elements and attributes.
type Markup = (&'static [&'static str], &'static [&'static str]);

/// Those of a drawing.
#[rustfmt::skip]
const DRAWING: Markup = (
    &["circle", "desc", "line", "polygon", "polyline", "rect", "svg", "text", "title"],
    &[
        "cx", "cy", "dy", "fill", "font-size", "height", "opacity", "points", "r", "role", "stroke", "stroke-width", "style",
        "text-anchor", "transform", "viewBox", "width", "x", "x1", "x2", "y", "y1", "y2",
    ],
);

/// Those that a page has besides.
#[rustfmt::skip]
const PAGE: Markup = (
    &[
        "!DOCTYPE", "body", "br", "caption", "code", "dd", "div", "dl", "dt", "em", "figcaption", "figure", "footer", "h1", "h2", "h3",
        "h4", "head", "header", "hr", "html", "li", "main", "meta", "ol", "p", "pre", "section", "span", "strong", "style", "sub", "sup",
        "table", "tbody", "td", "th", "thead", "tr", "ul",
    ],
    &["aria-hidden", "aria-label", "charset", "class", "colspan", "content", "lang", "name", "rowspan", "scope"],
);

/// The first tag of a drawing that is none of a drawing.
pub(super) fn foreign_in_drawing(svg: &str) -> Option<String> {
    foreign(svg, &[DRAWING])
}

/// The first tag of a page without its data that is neither text nor drawing.
pub(super) fn foreign_in_page(page: &str) -> Option<String> {
    foreign(page, &[DRAWING, PAGE])
}

fn foreign(text: &str, allowed: &[Markup]) -> Option<String> {
    let mut tags = text.split('<').skip(1);
    let tag = tags.find(|tag| !is_allowed(tag, allowed))?;
    Some(format!("<{}", tag.chars().take(40).collect::<String>()))
}

/// Whether a text that stands behind `<` is a whole tag in its plainest form, of an element and with attributes that are allowed. So every
/// reader of HTML or XML takes it for the same tag.
fn is_allowed(tag: &str, allowed: &[Markup]) -> bool {
    let Some((tag, _)) = tag.split_once('>') else {
        return false;
    };
    let tag = tag
        .strip_prefix('/')
        .or_else(|| tag.strip_suffix('/'))
        .unwrap_or(tag);
    let (element, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
    if !allowed
        .iter()
        .any(|(elements, _)| elements.contains(&element))
    {
        return false;
    }
    if element == "!DOCTYPE" {
        return rest == "html";
    }
    while !rest.is_empty() {
        let Some((name, value)) = rest.split_once("=\"") else {
            return false;
        };
        let Some((value, behind)) = value.split_once('"') else {
            return false;
        };
        let is_inert = match name {
            "style" => FONTS_OF_ALL == format!(" style=\"{value}\""),
            "aria-label" | "content" | "transform" => true,
            // Functions, as `url()` is one, and signs that hide them.
            _ => !value.contains(['(', '\\']),
        };
        if !is_inert || !allowed.iter().any(|(_, names)| names.contains(&name)) {
            return false;
        }
        rest = behind.trim_start_matches(' ');
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_tags_that_show_something_are_let_through() {
        let good = format!(
            "<svg{FONTS_OF_ALL} width=\"1\" role=\"img\"><text x=\"1\" transform=\"rotate(270, 1, 2)\">K = 9 &lt;script></text><rect x=\"1\"/></svg>"
        );
        assert_eq!(foreign_in_drawing(&good), None);
        for bad in [
            "<script>alert(1)</script>",
            "<SCRIPT>",
            "<svg onload=\"x\">",
            "<svg/onload=x>",
            "<svg\nonload=\"x\">",
            "<rect x=\"1\" onclick=\"a\"/>",
            "<rect x=\"1\"onclick=\"a\"/>",
            "<rect x='1'/>",
            "<rect x=1/>",
            "<rect x=\"1\"",
            "<svg class=\"mark\">",
            "<svg style=\"position:fixed\">",
            "<style>",
            "<foreignObject>",
            "<a href=\"x\">",
            "<use href=\"#a\"/>",
            "<image href=\"x\"/>",
            "<animate/>",
            "<p>",
            "</figure>",
            "<!--><script>-->",
            "<![CDATA[x]]>",
            "<?x ?>",
            "<rect fill=\"url(x)\"/>",
            "<rect fill=\"u\\72l(x)\"/>",
            "< rect/>",
            "<",
        ] {
            assert!(foreign_in_drawing(bad).is_some(), "{bad}");
        }
        let page = crate::report::page::PageFormat::Html.template().text;
        let (page, _) = page.split_once("<script").unwrap();
        assert_eq!(foreign_in_page(page), None);
        for bad in [
            "<meta http-equiv=\"refresh\">",
            "<link rel=\"x\">",
            "<iframe>",
            "<img src=\"x\">",
            "<form>",
            "<script>",
            "<base>",
        ] {
            assert!(foreign_in_page(bad).is_some(), "{bad}");
        }
    }
}
