//! PNG from a figure's SVG.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::PlotError;
use super::font;

/// Largest side of an image, px: four times a poster at 300 dots per inch would not fit, a printed page does by far.
const LONGEST_SIDE_PX: f64 = 16_384.0;

/// A figure as PNG, drawn with the embedded font on every machine.
///
/// # Arguments
/// - `svg`: what [`super::Figure::to_svg`] gave, or any other SVG.
/// - `scale`: image pixels per pixel of the SVG; 2 is good on paper.
///
/// # Errors
/// [`PlotError::Svg`] for a text that is no SVG, [`PlotError::Scale`] for an image without pixels or with too many,
/// [`PlotError::Png`].
pub fn to_png(svg: &str, scale: f64) -> Result<Vec<u8>, PlotError> {
    let tree = parse(svg)?;
    let size = tree.size();
    let [width, height] =
        [size.width(), size.height()].map(|side| (f64::from(side) * scale).ceil());
    let fits = |side: f64| (1.0..=LONGEST_SIDE_PX).contains(&side);
    if !(fits(width) && fits(height)) {
        return Err(PlotError::Scale {
            scale,
            width_px: width,
            height_px: height,
        });
    }
    let mut image = Pixmap::new(width as u32, height as u32).ok_or(PlotError::Scale {
        scale,
        width_px: width,
        height_px: height,
    })?;
    resvg::render(
        &tree,
        Transform::from_scale(scale as f32, scale as f32),
        &mut image.as_mut(),
    );
    image.encode_png().map_err(|source| PlotError::Png {
        reason: source.to_string(),
    })
}

/// The SVG as resvg understands it, with the embedded font and no other.
pub(super) fn parse(svg: &str) -> Result<Tree, PlotError> {
    let options = Options {
        font_family: font::FAMILY.to_owned(),
        fontdb: fonts(),
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(|source| PlotError::Svg { source })
}

fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    Arc::clone(FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(font::BYTES.to_vec());
        fonts.set_sans_serif_family(font::FAMILY);
        Arc::new(fonts)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOT: &str = r#"<svg width="30" height="20" xmlns="http://www.w3.org/2000/svg"><rect width="30" height="20"/></svg>"#;

    #[test]
    fn an_image_has_the_size_asked_for() {
        let png = to_png(DOT, 2.0).unwrap();
        // PNG specification (W3C, 3rd edition) 5.2 and 11.2.1: signature, then width and height in the first chunk.
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(&png[16..24], &[0, 0, 0, 60, 0, 0, 0, 40]);
    }

    #[test]
    fn text_is_drawn_with_the_embedded_font() {
        let svg = |text: &str| {
            format!(
                r#"<svg width="60" height="30" xmlns="http://www.w3.org/2000/svg"><text x="5" y="20" font-family="{}" font-size="16">{text}</text></svg>"#,
                font::FAMILIES
            )
        };
        assert_ne!(
            to_png(&svg("µm"), 1.0).unwrap(),
            to_png(&svg(""), 1.0).unwrap()
        );
    }

    #[test]
    fn what_cannot_become_an_image_is_refused() {
        assert!(matches!(
            to_png("no figure", 1.0),
            Err(PlotError::Svg { .. })
        ));
        for scale in [0.0, -1.0, f64::NAN, 1e9] {
            assert!(matches!(to_png(DOT, scale), Err(PlotError::Scale { .. })));
        }
    }
}
