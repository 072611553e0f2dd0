//! Bytes to text.

use std::borrow::Cow;

use encoding_rs::{
    Encoding, GB18030, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1250, WINDOWS_1251,
    WINDOWS_1252, WINDOWS_1254,
};

use super::keywords;
use super::layout::TextEncoding;
use crate::readings::{TableError, line_of};

/// Bytes in which the encoding is looked for.
const LOOKED_AT: usize = 4096;

/// Code pages of text that is not UTF-8; of those that suit equally the first is taken.
const CODE_PAGES: [(TextEncoding, &Encoding); 6] = [
    (TextEncoding::Windows1252, WINDOWS_1252),
    (TextEncoding::Windows1254, WINDOWS_1254),
    (TextEncoding::Windows1250, WINDOWS_1250),
    (TextEncoding::Windows1251, WINDOWS_1251),
    (TextEncoding::Gb18030, GB18030),
    (TextEncoding::ShiftJis, SHIFT_JIS),
];

/// The text of a file: as stated, else UTF-8 or UTF-16, else in the code page in which its words are words.
///
/// # Errors
/// [`TableError`] for bytes that are none.
pub(super) fn decode<'a>(
    file: &str,
    bytes: &'a [u8],
    stated: Option<TextEncoding>,
) -> Result<(Cow<'a, str>, TextEncoding), TableError> {
    let (text, encoding) = match (bytes, stated) {
        ([0xEF, 0xBB, 0xBF, rest @ ..], None) => (eight_bits(rest).0, TextEncoding::Utf8Marked),
        ([0xFF, 0xFE, rest @ ..], None) => (of(UTF_16LE, rest), TextEncoding::Utf16),
        ([0xFE, 0xFF, rest @ ..], None) => (of(UTF_16BE, rest), TextEncoding::Utf16),
        (_, None) => match unmarked_utf16(bytes) {
            Some(encoding) => (of(encoding, bytes), TextEncoding::Utf16),
            None => eight_bits(bytes),
        },
        (_, Some(stated)) => {
            let mut pages = CODE_PAGES.into_iter();
            let page = pages.find(|(encoding, _)| *encoding == stated);
            let encoding = match stated {
                TextEncoding::Utf16 => unmarked_utf16(bytes).unwrap_or(UTF_16LE),
                _ => page.map_or(UTF_8, |(_, page)| page),
            };
            // A byte order mark states the same.
            (encoding.decode(bytes).0, stated)
        }
    };
    let wrong = |place: usize| {
        let line = text[..place].matches('\n').count() as u32 + 1;
        TableError::new(
            "stiffbench::table::not_text",
            format!("{}: not text", line_of(file, line)),
            "export the measured values as text, CSV or XLSX; state the encoding of a text with --encoding",
        )
    };
    let broken = (encoding == TextEncoding::Utf16 || stated.is_some())
        .then(|| text.find('\u{fffd}'))
        .flatten();
    match text.find('\0').or(broken) {
        Some(place) => Err(wrong(place)),
        None => Ok((text, encoding)),
    }
}

fn of<'a>(encoding: &'static Encoding, bytes: &'a [u8]) -> Cow<'a, str> {
    encoding.decode_without_bom_handling(bytes).0
}

/// Text of one byte a character, or more where a code page has too many for that.
fn eight_bits(bytes: &[u8]) -> (Cow<'_, str>, TextEncoding) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return (text.into(), TextEncoding::Utf8);
    }
    let lines = bytes.split_inclusive(|byte| *byte == b'\n');
    let mut looked_at: Vec<u8> = Vec::new();
    for line in lines.filter(|line| !line.is_ascii()) {
        if looked_at.len() + line.len() > LOOKED_AT && !looked_at.is_empty() {
            break;
        }
        looked_at.extend_from_slice(line);
    }
    let suits = CODE_PAGES.map(|(encoding, page)| (plausibility(page, &looked_at), encoding, page));
    let (_, encoding, page) =
        suits.into_iter().fold(
            suits[0],
            |best, next| {
                if next.0 > best.0 { next } else { best }
            },
        );
    (of(page, bytes), encoding)
}

/// How plausible the words of a text are in a code page, in letters beyond ASCII: those of words that a language could have, and that
/// columns have, less the others.
fn plausibility(page: &'static Encoding, bytes: &[u8]) -> i64 {
    /// A word of the names of columns counts as this many letters more.
    const KNOWN: i64 = 8;
    let Some(text) = page.decode_without_bom_handling_and_without_replacement(bytes) else {
        return i64::MIN;
    };
    // What stands between letters belongs to their word: no sign does.
    let is_sign = |c: char| !(c.is_ascii() || c.is_alphanumeric() || c.is_whitespace());
    let words = text.split(|c: char| !(c.is_alphanumeric() || is_sign(c)));
    let of_word = |word: &str| {
        let word = word.trim_matches(is_sign);
        let letters = word.chars().filter(|c| !c.is_ascii()).count() as i64;
        match letters {
            0 => 0,
            // A letter alone is a sign of another page.
            1 if word.chars().count() == 1 => 0,
            _ if is_hungarian_misread(word) => -letters,
            _ if keywords::is_known(&keywords::plain(word)) => letters + KNOWN,
            _ if is_word(word) => letters,
            _ => -letters,
        }
    };
    words.map(of_word).sum()
}

/// Whether a word has the letters that Hungarian ő and ű become in a page without them: at its end, or beside vowels that no word of
/// Portuguese, French or Estonian has with them.
fn is_hungarian_misread(word: &str) -> bool {
    const SHORTEST: usize = 3;
    let word = word.to_lowercase();
    let (has_o, has_u) = (word.contains('õ'), word.contains('û'));
    let is_at_end = word.chars().count() >= SHORTEST && word.ends_with(['õ', 'û']);
    let has_others = word.contains(['á', 'í', 'ó', 'ö', 'ú', 'ü']);
    is_at_end || (has_o || has_u) && has_others || has_o && (has_u || word.contains('é'))
}

/// Whether a language could have a word: letters of one script, of Latin ones some in ASCII, no capital behind a small letter.
fn is_word(word: &str) -> bool {
    let letters = || word.chars().filter(|c| c.is_alphabetic());
    let count = |is: fn(char) -> bool| letters().filter(|c| is(*c)).count();
    let cyrillic = count(|c| ('\u{400}'..'\u{460}').contains(&c));
    // Ideographs and syllables; halves of syllables are what single bytes become.
    let east = count(|c| ('\u{3041}'..'\u{a000}').contains(&c));
    let latin = letters().count() - cyrillic - east;
    let rare = word.contains(['Ð', 'ð', 'Þ', 'þ', 'Ý', 'ý']) && !word.is_ascii();
    let beyond = count(|c| !c.is_ascii());
    let is_turned = letters()
        .zip(letters().skip(1))
        .any(|(a, b)| a.is_lowercase() && b.is_uppercase());
    let is_half = |c: char| ('\u{ff61}'..='\u{ff9f}').contains(&c);
    let is_of_letters = word.chars().all(|c| c.is_alphanumeric() && !is_half(c));
    match (latin, cyrillic, east) {
        (_, 0, 0) => {
            let of_ascii = latin - beyond;
            is_of_letters && !rare && (2 * of_ascii >= beyond || latin == 1) && !is_turned
        }
        (0, _, 0) => is_of_letters && !is_turned,
        // Letters of ASCII behind ideographs are a unit.
        (_, 0, _) => {
            let behind = word.trim_start_matches(|c: char| !c.is_ascii());
            is_of_letters && behind.is_ascii()
        }
        _ => false,
    }
}

/// UTF-16 without a mark: nearly all bytes of one half are zero.
fn unmarked_utf16(bytes: &[u8]) -> Option<&'static Encoding> {
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    if start.len() < 4 {
        return None;
    }
    let zeros = |odd: usize| {
        start
            .iter()
            .skip(odd)
            .step_by(2)
            .filter(|b| **b == 0)
            .count()
    };
    let (high, low) = (zeros(0), zeros(1));
    let most = start.len() / 2 * 3 / 4;
    if low > most && high == 0 {
        Some(UTF_16LE)
    } else if high > most && low == 0 {
        Some(UTF_16BE)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> (String, TextEncoding) {
        let (text, encoding) = decode("t", bytes, None).unwrap();
        (text.into_owned(), encoding)
    }

    #[test]
    fn encodings_are_recognised() {
        let expected = "Weg [µm]; Kraft\n1;2\n";
        assert_eq!(
            text(expected.as_bytes()),
            (expected.into(), TextEncoding::Utf8)
        );
        let marked = [b"\xEF\xBB\xBF", expected.as_bytes()].concat();
        assert_eq!(text(&marked), (expected.into(), TextEncoding::Utf8Marked));
        let western: Vec<u8> = expected.chars().map(|c| c as u8).collect();
        assert_eq!(text(&western), (expected.into(), TextEncoding::Windows1252));
        for (order, mark) in [
            (u16::to_le_bytes as fn(u16) -> [u8; 2], [0xFF, 0xFE]),
            (u16::to_be_bytes, [0xFE, 0xFF]),
        ] {
            let wide: Vec<u8> = expected.encode_utf16().flat_map(order).collect();
            assert_eq!(text(&wide), (expected.into(), TextEncoding::Utf16));
            let marked = [&mark[..], &wide].concat();
            assert_eq!(text(&marked), (expected.into(), TextEncoding::Utf16));
        }
        // 0x80 is the euro sign there and nothing in ISO 8859-1.
        assert_eq!(text(b"\x80 5").0, "€ 5");
    }

    #[test]
    fn a_code_page_is_that_in_which_words_are_words() {
        for (expected, encoding) in [
            (
                "Prüfkraft [N];Größe;Standardweg [µm]",
                TextEncoding::Windows1252,
            ),
            (
                "Déplacement (mm);Température (°C);Pièce n° 3",
                TextEncoding::Windows1252,
            ),
            ("Repetición;Fuerza;Señal ±", TextEncoding::Windows1252),
            ("Kraft;Weg µm;± 5 °C", TextEncoding::Windows1252),
            ("Czas;Przemieszczenie;Obciążenie", TextEncoding::Windows1250),
            ("Siła [N];Wydłużenie;Próbka", TextEncoding::Windows1250),
            ("Síla;Dráha;Čas;Zkušební těleso", TextEncoding::Windows1250),
            ("Erő [N];Elmozdulás [mm];Idő [s]", TextEncoding::Windows1250),
            ("Hőmérséklet (°C);Gyűrű", TextEncoding::Windows1250),
            ("Posições;Força;Direções", TextEncoding::Windows1252),
            ("Sûreté;Coût;Effort dû", TextEncoding::Windows1252),
            ("Jõud;Nihe", TextEncoding::Windows1252),
            ("Yük;Değişim;Şekil", TextEncoding::Windows1254),
            (
                "Нагрузка, Н;Перемещение, мм;Время, с",
                TextEncoding::Windows1251,
            ),
            ("Сила;Ход", TextEncoding::Windows1251),
            ("时间(s),位移(mm),试验力(N)", TextEncoding::Gb18030),
            ("力N,变形mm", TextEncoding::Gb18030),
            ("時間,変位,荷重", TextEncoding::ShiftJis),
            ("試験力(N),ストローク(mm)", TextEncoding::ShiftJis),
        ] {
            let page = CODE_PAGES.into_iter().find(|page| page.0 == encoding);
            let (bytes, _, is_lossy) = page.unwrap().1.encode(expected);
            assert!(!is_lossy, "{expected}");
            assert_eq!(text(&bytes), (expected.to_owned(), encoding));
        }
    }

    #[test]
    fn a_stated_encoding_holds() {
        let (found, _) = decode("t", b"\xB5m", Some(TextEncoding::Windows1251)).unwrap();
        assert_eq!(found, "µm");
        let (found, _) = decode("t", b"\xEF\xBB\xBFF", Some(TextEncoding::Utf8)).unwrap();
        assert_eq!(found, "F");
        assert!(decode("t", b"F\n\xFF", Some(TextEncoding::Utf8)).is_err());
    }

    #[test]
    fn what_is_no_text_is_refused_with_its_line() {
        for broken in [&b"F\nd\0\n"[..], b"\xFF\xFEa\0\n\0\x00\xD8b\0"] {
            let error = decode("t", broken, None).unwrap_err();
            assert!(error.to_string().contains("line 2"), "{error}");
        }
    }
}
