//! Names in messages: those that are known, and the one that comes nearest to a mistyped one.
//!
//! Leaf module.

use strsim::levenshtein;

/// So many names are listed in a message.
const MOST_NAMES: usize = 40;

/// The name in `known` nearest to `name`, if it is near enough to be worth suggesting.
///
/// Near enough: at most one change in three characters, one at least (insertion, deletion, replacement; capitals do not count), or one name
/// starts with the other.
#[must_use]
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    known
        .into_iter()
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let changes = levenshtein(&name, &lower);
            let prefix = name.len() >= 3 && lower.starts_with(&name)
                || lower.len() >= 3 && name.starts_with(&lower);
            let longest = name.chars().count().max(lower.chars().count());
            (prefix || changes <= (longest / 3).max(1)).then_some((changes, candidate))
        })
        .min_by_key(|(changes, _)| *changes)
        .map(|(_, candidate)| candidate)
}

/// Names in backquotes; of very many the first, and how many more there are.
#[must_use]
pub fn listed_names<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let first = names.by_ref().take(MOST_NAMES);
    let mut text = first
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    let further = names.count();
    if further > 0 {
        text = format!("{text} and {further} more");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["P1", "P2", "reach-out", "direction"];
        assert_eq!(nearest("reachout", known), Some("reach-out"));
        assert_eq!(nearest("p1", known), Some("P1"));
        assert_eq!(nearest("dir", known), Some("direction"));
        assert_eq!(nearest("banana", known), None);
    }

    #[test]
    fn of_very_many_names_the_first_are_listed() {
        assert_eq!(listed_names(["a", "b"]), "`a`, `b`");
        let listed = listed_names(vec!["a"; 1_000_000]);
        assert!(listed.ends_with("`a` and 999960 more"), "{listed}");
    }
}
