//! The example of `docs/robot-file-1.md`, which the tests of robot files change.

/// The text between the first TOML fence of the page and its end.
pub(crate) fn text() -> &'static str {
    let page = stiffbench_test_files::text("docs/robot-file-1.md");
    let start = page.find("```toml\n").expect("the page has an example") + "```toml\n".len();
    let length = page[start..].find("```").expect("the example ends");
    &page[start..start + length]
}

/// The example with one piece of text replaced, which must be there.
pub(crate) fn with(find: &str, replacement: &str) -> String {
    assert!(text().contains(find), "the example has no {find}");
    text().replacen(find, replacement, 1)
}
