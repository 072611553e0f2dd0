//! The data of a page beside those that were worked out again, key by key.

use serde_json::Value;

use super::verify::PageDifference;

/// Values of a page beside those worked out again.
pub(super) struct ValueComparison {
    /// Whether this program rendered the page.
    pub(super) same_program: bool,
    /// Values that differ, and keys that only one of both has.
    pub(super) differences: Vec<PageDifference>,
    /// Words and drawings that another program may have set otherwise, by their paths.
    pub(super) not_verified: Vec<String>,
}

impl ValueComparison {
    /// Compares every key of both, by its path.
    pub(super) fn compare(
        &mut self,
        path: &str,
        printed: Option<&Value>,
        expected: Option<&Value>,
    ) {
        let is_drawing = path.starts_with("/figures/") && path.ends_with("/svg");
        let is_set = is_drawing || path.ends_with("/text");
        match (printed, expected) {
            _ if printed == expected => {}
            (Some(_), Some(_)) if is_set && !self.same_program => {
                self.not_verified.push(path.to_owned());
            }
            (Some(Value::Object(ours)), Some(Value::Object(theirs))) => {
                let missing = theirs.keys().filter(|key| !ours.contains_key(*key));
                for key in ours.keys().chain(missing) {
                    self.compare(&format!("{path}/{key}"), ours.get(key), theirs.get(key));
                }
            }
            (Some(Value::Array(ours)), Some(Value::Array(theirs))) => {
                for place in 0..ours.len().max(theirs.len()) {
                    self.compare(
                        &format!("{path}/{place}"),
                        ours.get(place),
                        theirs.get(place),
                    );
                }
            }
            _ => self.differences.push(PageDifference {
                place: path.to_owned(),
                printed: shortened(printed),
                expected: shortened(expected),
            }),
        }
    }
}

fn shortened(value: Option<&Value>) -> String {
    value.map_or_else(
        || "nothing".to_owned(),
        |value| value.to_string().chars().take(60).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn of_another_program_every_key_is_compared_and_what_it_may_set_otherwise_is_named() {
        let printed = json!({
            "fit": { "text": ["old words"], "numbers": { "K": 1.0, "only": null } },
            "figures": { "fit": [{ "title": "a", "svg": "<svg/>" }] },
        });
        let mut expected = json!({
            "fit": { "text": ["new words", "more"], "numbers": { "K": 1.0, "rank": 4 } },
            "figures": { "fit": [{ "title": "a", "svg": "<svg></svg>" }] },
        });
        let compared = |expected: &Value, same_program| {
            let mut compared = ValueComparison {
                same_program,
                differences: Vec::new(),
                not_verified: Vec::new(),
            };
            compared.compare("", Some(&printed), Some(expected));
            let places = compared.differences.into_iter().map(|one| one.place);
            (places.collect::<Vec<String>>(), compared.not_verified)
        };
        let (places, not_verified) = compared(&expected, false);
        assert_eq!(places, ["/fit/numbers/only", "/fit/numbers/rank"]);
        assert_eq!(not_verified, ["/fit/text", "/figures/fit/0/svg"]);
        assert_eq!(compared(&expected, true).0.len(), 5);
        expected["fit"]["numbers"]["K"] = json!(1.1);
        assert_eq!(compared(&expected, false).0.len(), 3);
    }
}
