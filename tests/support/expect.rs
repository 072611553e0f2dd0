//! What tests ask of texts and JSON: the answer, or a failure that shows what was there.

use serde_json::Value;

/// What a text has to contain.
pub(crate) trait Contains {
    /// It contains all of these.
    fn must_contain(&self, words: &[&str]);
}

impl Contains for str {
    #[track_caller]
    fn must_contain(&self, words: &[&str]) {
        for word in words {
            assert!(self.contains(word), "`{word}` is not in {self}");
        }
    }
}

/// A JSON value as what it has to be.
pub(crate) trait Json {
    /// The elements of an array.
    fn list(&self) -> &[Value];
    /// A number.
    fn number(&self) -> f64;
    /// A text.
    fn word(&self) -> &str;
    /// Of an array of objects, the one with this `name`.
    fn named(&self, name: &str) -> &Value;
}

impl Json for Value {
    #[track_caller]
    fn list(&self) -> &[Value] {
        self.as_array()
            .unwrap_or_else(|| panic!("{self} is no array"))
    }

    #[track_caller]
    fn number(&self) -> f64 {
        self.as_f64()
            .unwrap_or_else(|| panic!("{self} is no number"))
    }

    #[track_caller]
    fn word(&self) -> &str {
        self.as_str().unwrap_or_else(|| panic!("{self} is no text"))
    }

    #[track_caller]
    fn named(&self, name: &str) -> &Value {
        let mut all = self.list().iter();
        all.find(|one| one["name"] == name)
            .unwrap_or_else(|| panic!("no {name} in {self}"))
    }
}
