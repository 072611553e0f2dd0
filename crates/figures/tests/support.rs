//! What every test of figures does with a figure, and the noise of made-up data.

use std::fs;
use std::path::PathBuf;

use rand::{Rng, RngExt};
use resvg::tiny_skia::Rect;
use resvg::usvg::{Group, Node, Options, TextChunk, Tree};
use stiffbench_figures::{Figure, to_png};

/// Writes a figure and checks what holds for all.
pub(crate) fn check(name: &str, figure: &Figure) {
    let svg = figure.to_svg();
    assert_eq!(
        svg,
        figure.to_svg(),
        "{name}: the same figure, the same bytes"
    );
    assert!(svg.len() < 1_500_000, "{name}: {} bytes", svg.len());
    assert!(svg.contains("<title>") && svg.contains("<desc>"));
    check_texts(name, &svg);
    let png = to_png(&svg, 2.0).expect("a figure becomes an image");
    let folder = stiffbench_test_files::repository().join("target/figures-check");
    fs::create_dir_all(&folder).expect("the target folder can be written");
    fs::write(folder.join(format!("{name}.svg")), &svg).expect("the SVG is written");
    fs::write(folder.join(format!("{name}.png")), &png).expect("the PNG is written");
}

/// Measures every text as the renderer does: none may leave the sheet or lie on another.
fn check_texts(name: &str, svg: &str) {
    let font = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fonts/DejaVuSans-subset.ttf");
    let mut options = Options::default();
    options
        .fontdb_mut()
        .load_font_data(fs::read(font).expect("the font is in the tree"));
    let tree = Tree::from_str(svg, &options).expect("a figure is SVG");
    let sheet = tree.size();
    let mut texts: Vec<(String, Rect)> = Vec::new();
    collect_texts(tree.root(), &mut texts);
    assert!(texts.len() > 5, "{name}: too few texts");
    for (place, (text, area)) in texts.iter().enumerate() {
        assert!(
            area.left() >= 0.0
                && area.top() >= 0.0
                && area.right() <= sheet.width()
                && area.bottom() <= sheet.height(),
            "{name}: `{text}` leaves the sheet"
        );
        for (other, other_area) in &texts[..place] {
            let apart = area.left() >= other_area.right()
                || other_area.left() >= area.right()
                || area.top() >= other_area.bottom()
                || other_area.top() >= area.bottom();
            assert!(apart, "{name}: `{text}` touches `{other}`");
        }
    }
}

/// Every text below a group with the box of its ink.
fn collect_texts(group: &Group, texts: &mut Vec<(String, Rect)>) {
    for node in group.children() {
        match node {
            Node::Group(inner) => collect_texts(inner, texts),
            Node::Text(text) => {
                let words = text.chunks().iter().map(TextChunk::text).collect();
                texts.push((words, text.flattened().abs_bounding_box()));
            }
            Node::Path(_) | Node::Image(_) => {}
        }
    }
}

/// Sum of four uniform numbers, scaled to a standard deviation of one: nearly normal, and enough for a picture.
pub(crate) fn noise(random: &mut impl Rng) -> f64 {
    let sum: f64 = (0..4).map(|_| random.random_range(-0.5..0.5)).sum();
    sum * 3f64.sqrt()
}
