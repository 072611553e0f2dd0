//! The embedded font: its bytes for drawing, the widths of its characters for layout.
//!
//! plotters without a font backend only guesses text sizes, so the widths are read from the tables of the font itself.

use std::sync::OnceLock;

/// DejaVu Sans, cut down to the characters of figures (`fonts/README.md`).
pub(super) static BYTES: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");

/// Family of the embedded font.
pub(super) const FAMILY: &str = "DejaVu Sans";

/// What the SVG asks for: a browser without DejaVu Sans takes Verdana, drawn to nearly the same widths.
pub(super) const FAMILIES: &str = "DejaVu Sans, Verdana, sans-serif";

/// Height of digits and capitals as a share of the size (DejaVu Sans: 1493 of 2048).
pub(super) const CAPITAL_HEIGHT: f64 = 0.729;

/// Width of a text in one line, px.
pub(super) fn width_px(text: &str, size_px: f64) -> f64 {
    let metrics = metrics();
    let units: f64 = text.chars().map(|c| metrics.advance(c)).sum();
    units * size_px
}

/// A text no wider than `width_limit_px`: what is too much is cut off, and three dots stand for it.
pub(super) fn shortened(text: &str, size_px: f64, width_limit_px: f64) -> String {
    if width_px(text, size_px) <= width_limit_px {
        return text.to_owned();
    }
    let room_px = width_limit_px - width_px("…", size_px);
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if width_px(&kept, size_px) > room_px {
            kept.pop();
            break;
        }
    }
    kept.truncate(kept.trim_end().len());
    kept.push('…');
    kept
}

/// Breaks a text at spaces into lines no wider than `width_limit_px`; a single longer word gets a line of its own.
pub(super) fn wrap(text: &str, size_px: f64, width_limit_px: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    // A non-breaking space keeps a number and its unit in one line, so only the plain space separates.
    for word in text.split([' ', '\n']).filter(|word| !word.is_empty()) {
        match lines.last_mut() {
            Some(line)
                if width_px(&as_wide_as_can_be(&format!("{line} {word}")), size_px)
                    <= width_limit_px =>
            {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A text with checksums as wide as any: a caption must not break elsewhere because its data have another checksum.
fn as_wide_as_can_be(text: &str) -> String {
    let is_checksum = |word: &str| {
        let digits = word.trim_matches(|c: char| !c.is_ascii_alphanumeric());
        digits.len() == CHECKSUM_DIGITS && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
    };
    let words = text.split(' ').map(|word| {
        if is_checksum(word) {
            // No letter of hexadecimal digits is wider than a digit.
            word.replace(|c: char| c.is_ascii_hexdigit(), "0")
        } else {
            word.to_owned()
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Digits of a checksum as captions give it.
const CHECKSUM_DIGITS: usize = 12;

/// Advance widths in units of the size, by character.
#[derive(Debug)]
struct Metrics {
    /// Sorted by character.
    advances: Vec<(char, f64)>,
    missing: f64,
}

impl Metrics {
    fn advance(&self, c: char) -> f64 {
        self.advances
            .binary_search_by_key(&c, |(character, _)| *character)
            .map_or(self.missing, |place| self.advances[place].1)
    }
}

fn metrics() -> &'static Metrics {
    static METRICS: OnceLock<Metrics> = OnceLock::new();
    METRICS.get_or_init(|| read_metrics(BYTES).expect("the embedded font is complete"))
}

/// Character widths of a TrueType font: tables head, hhea, hmtx and a cmap of format 4.
///
/// # Source
/// OpenType specification 1.9, chapters on these tables.
fn read_metrics(font: &[u8]) -> Option<Metrics> {
    let head = table(font, *b"head")?;
    let hhea = table(font, *b"hhea")?;
    let hmtx = table(font, *b"hmtx")?;
    let cmap = table(font, *b"cmap")?;
    let units_per_em = f64::from(u16_at(head, 18)?);
    let metric_count = usize::from(u16_at(hhea, 34)?);
    // Glyphs after the last metric share its advance.
    let advance = |glyph: u16| {
        let place = usize::from(glyph).min(metric_count.checked_sub(1)?);
        Some(f64::from(u16_at(hmtx, 4 * place)?) / units_per_em)
    };
    let mut advances = Vec::new();
    for (code, glyph) in glyphs(cmap)? {
        if let Some(character) = char::from_u32(u32::from(code)) {
            advances.push((character, advance(glyph)?));
        }
    }
    Some(Metrics {
        advances,
        missing: advance(0)?,
    })
}

/// Code and glyph of every character in the cmap subtable of format 4, ascending.
fn glyphs(cmap: &[u8]) -> Option<Vec<(u16, u16)>> {
    let subtable_count = usize::from(u16_at(cmap, 2)?);
    let subtable = (0..subtable_count)
        .filter_map(|i| {
            let offset = u32_at(cmap, 4 + 8 * i + 4)?;
            cmap.get(usize::try_from(offset).ok()?..)
        })
        .find(|subtable| u16_at(subtable, 0) == Some(4))?;
    let segments = usize::from(u16_at(subtable, 6)?) / 2;
    let mut found = Vec::new();
    for segment in 0..segments {
        let end = u16_at(subtable, 14 + 2 * segment)?;
        let start = u16_at(subtable, 16 + 2 * (segments + segment))?;
        let delta = u16_at(subtable, 16 + 2 * (2 * segments + segment))?;
        let range_place = 16 + 2 * (3 * segments + segment);
        let range = usize::from(u16_at(subtable, range_place)?);
        for code in start..=end {
            let glyph = if range == 0 {
                code.wrapping_add(delta)
            } else {
                match u16_at(
                    subtable,
                    range_place + range + 2 * usize::from(code - start),
                )? {
                    0 => 0,
                    glyph => glyph.wrapping_add(delta),
                }
            };
            if glyph != 0 {
                found.push((code, glyph));
            }
        }
    }
    Some(found)
}

fn table(font: &[u8], tag: [u8; 4]) -> Option<&[u8]> {
    let table_count = usize::from(u16_at(font, 4)?);
    (0..table_count).find_map(|i| {
        let record = font.get(12 + 16 * i..28 + 16 * i)?;
        if record[..4] != tag {
            return None;
        }
        let offset = usize::try_from(u32_at(record, 8)?).ok()?;
        let length = usize::try_from(u32_at(record, 12)?).ok()?;
        font.get(offset..offset.checked_add(length)?)
    })
}

fn u16_at(bytes: &[u8], place: usize) -> Option<u16> {
    let pair = bytes.get(place..place.checked_add(2)?)?;
    Some(u16::from_be_bytes([pair[0], pair[1]]))
}

fn u32_at(bytes: &[u8], place: usize) -> Option<u32> {
    Some(u32::from(u16_at(bytes, place)?) << 16 | u32::from(u16_at(bytes, place + 2)?))
}

#[cfg(test)]
mod tests {
    #[test]
    fn lines_break_alike_whatever_the_checksum() {
        for limit_px in 60..260 {
            let lines = |sum: &str| {
                wrap(
                    &format!("readings.csv ({sum}), nobody"),
                    10.0,
                    f64::from(limit_px),
                )
                .len()
            };
            assert_eq!(
                lines("ffffffffffff"),
                lines("0b1e2c3d4e5f"),
                "{limit_px} px"
            );
        }
    }

    use super::*;

    #[test]
    fn widths_are_those_another_reader_finds_in_the_font() {
        // Advances printed by fonttools for the embedded file, of 2048 units.
        for (text, units) in [
            ("0", 1303.0),
            ("W", 2025.0),
            ("µ", 1303.0),
            ("−", 1716.0),
            ("00W", 4631.0),
        ] {
            let expected = units / 2048.0 * 12.0;
            assert!(
                (width_px(text, 12.0) - expected).abs() < 1e-9,
                "{text}: {} against {expected}",
                width_px(text, 12.0)
            );
        }
    }

    #[test]
    fn every_character_used_in_figures_is_in_the_font() {
        for c in "µδθφ±×°·−⁰¹²³⁴⁵⁶⁷⁸⁹⁻≤≥≈√σχρΔ→↑–—’“”…äöüßéčłøñΩ∞αβ▲◆".chars()
        {
            assert!(
                metrics().advances.iter().any(|(known, _)| *known == c),
                "{c} is missing"
            );
        }
    }

    #[test]
    fn a_long_text_is_cut_with_an_ellipsis() {
        assert_eq!(shortened("play < 0", 10.0, 100.0), "play < 0");
        let cut = shortened("softens and stiffens at once", 10.0, 80.0);
        assert!(cut.starts_with("softens") && cut.ends_with('…'), "{cut}");
        assert!(width_px(&cut, 10.0) <= 80.0 && width_px(&cut, 10.0) > 65.0);
        assert_eq!(shortened("abc", 10.0, 0.0), "…");
    }

    #[test]
    fn a_cut_font_is_refused_without_panic() {
        for length in (0..BYTES.len()).step_by(997) {
            let _ = read_metrics(&BYTES[..length]);
        }
        assert!(read_metrics(&BYTES[..200]).is_none());
    }

    #[test]
    fn lines_stay_within_the_width_and_keep_every_word() {
        let text = "bars: ± one standard deviation of n = 5 repeats; hollow points are flagged";
        let lines = wrap(text, 11.0, 150.0);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| width_px(line, 11.0) <= 150.0));
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrap("unbreakable", 11.0, 1.0), ["unbreakable"]);
        assert!(wrap("", 11.0, 100.0).is_empty());
    }
}
