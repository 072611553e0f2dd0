//! Explanations of error codes and verdicts, for `explain`.

use indexmap::IndexMap;
use serde::Deserialize;

/// Files of explanations of error codes; keys are codes without `stiffbench::`.
const ERRORS: [&str; 5] = [
    include_str!("../../data/explanations/files.toml"),
    include_str!("../../data/explanations/imports.toml"),
    include_str!("../../data/explanations/bench.toml"),
    include_str!("../../data/explanations/model.toml"),
    include_str!("../../data/explanations/program.toml"),
];

/// Explanations of verdicts; keys are their names in JSON.
const VERDICTS: &str = include_str!("../../data/explanations/verdicts.toml");

/// Cause, remedy and an example.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Explanation {
    /// What it means, or why it happens.
    pub cause: String,
    /// What to do.
    pub remedy: String,
    /// A command, or a line of a file.
    pub example: String,
}

/// Explanations of error codes without `stiffbench::`, in the order of the files.
#[must_use]
pub fn error_explanations() -> IndexMap<String, Explanation> {
    ERRORS.into_iter().flat_map(parse).collect()
}

/// Explanations of verdicts, by their names in JSON.
#[must_use]
pub fn verdict_explanations() -> IndexMap<String, Explanation> {
    parse(VERDICTS)
}

/// A shipped file; that each of them can be read is tested.
fn parse(text: &str) -> IndexMap<String, Explanation> {
    toml::from_str(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_can_be_read_and_no_code_stands_twice() {
        let mut codes = Vec::new();
        for text in ERRORS.into_iter().chain([VERDICTS]) {
            let read: IndexMap<String, Explanation> = toml::from_str(text).unwrap();
            assert!(!read.is_empty());
            codes.extend(read.into_keys());
        }
        let count = codes.len();
        codes.sort();
        codes.dedup();
        assert_eq!(codes.len(), count);
    }

    #[test]
    fn every_text_is_a_short_sentence_or_two() {
        for (code, explanation) in error_explanations()
            .into_iter()
            .chain(verdict_explanations())
        {
            for text in [&explanation.cause, &explanation.remedy] {
                assert!(text.ends_with('.'), "{code}: {text}");
                for sentence in text.split(". ") {
                    let words = sentence.split_whitespace().count();
                    assert!(words <= 25, "{code}: {words} words: {sentence}");
                }
            }
            assert!(!explanation.example.is_empty(), "{code}");
        }
    }
}
