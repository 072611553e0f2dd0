//! Values of options, by the words that stand for them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::stiffness::Branches;
use crate::table_files::TextEncoding;

/// A word with others that mean the same behind bars, what help says of it, and its value.
pub(super) type OptionValue<T> = (&'static str, &'static str, T);

/// Branches that count.
pub(super) const BRANCHES: [OptionValue<Branches>; 2] = [
    ("loading", "Loading only", Branches::LoadingOnly),
    ("both", "Loading and unloading", Branches::Both),
];

/// Encodings of text.
pub(super) const ENCODINGS: [OptionValue<TextEncoding>; 8] = [
    ("utf-8", "Unicode", TextEncoding::Utf8),
    ("utf-16", "Unicode of two bytes", TextEncoding::Utf16),
    (
        "windows-1252|latin1|cp1252",
        "Western Europe",
        TextEncoding::Windows1252,
    ),
    (
        "windows-1250|cp1250",
        "Central Europe",
        TextEncoding::Windows1250,
    ),
    ("windows-1251|cp1251", "Cyrillic", TextEncoding::Windows1251),
    ("windows-1254|cp1254", "Turkish", TextEncoding::Windows1254),
    ("gb18030|gbk|gb2312", "Chinese", TextEncoding::Gb18030),
    ("shift-jis|sjis|cp932", "Japanese", TextEncoding::ShiftJis),
];

/// The decimal sign, as two values.
pub(super) fn decimal_signs<T>(point: T, comma: T) -> [OptionValue<T>; 2] {
    [("point|.", "1.5", point), ("comma|,", "1,5", comma)]
}

/// Takes one of the words.
pub(super) fn one_of<T: Clone + Send + Sync + 'static, const N: usize>(
    words: [OptionValue<T>; N],
) -> impl TypedValueParser<Value = T> {
    let possible: Vec<PossibleValue> = words
        .iter()
        .map(|(word, help, _)| {
            let mut names = word.split('|');
            let value = PossibleValue::new(names.next().unwrap_or_default()).help(help);
            value.aliases(names)
        })
        .collect();
    PossibleValuesParser::new(possible).try_map(move |typed| {
        let mut words = words.iter();
        let found = words.find(|(word, ..)| word.split('|').any(|name| name == typed));
        found.map(|(.., value)| value.clone()).ok_or("no such word")
    })
}

/// The word of a value.
pub(super) fn word_of<T: PartialEq, const N: usize>(
    words: [OptionValue<T>; N],
    value: &T,
) -> Option<String> {
    let (word, ..) = words.into_iter().find(|(.., known)| known == value)?;
    word.split('|').next().map(str::to_owned)
}
