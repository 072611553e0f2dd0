//! Names that were replaced by the term of the field and must not come back, and type names with one meaning each.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The search for missing physics and what reports it.
const SEARCH: &[&str] = &["crates/diagnosis/src/mismatch"];
const GAUGES: &[&str] = &["crates/gauges"];
const EVERYWHERE: &[&str] = &[""];

/// Identifiers, the term to use instead, and the folders where the identifier is wrong.
#[rustfmt::skip]
const REPLACED: &[(&str, &str, &[&str])] = &[
    ("Few", "LowRankBasis", EVERYWHERE),
    ("gain", "delta_chi2", SEARCH),
    ("gains", "delta_chi2s", SEARCH),
    ("Limits", "CriticalValues", EVERYWHERE),
    ("level_share", "alpha weights", EVERYWHERE),
    ("Drawn", "NullVectors", EVERYWHERE),
    ("DrawTable", "NullSampler", EVERYWHERE),
    ("Told", "NullScratch", EVERYWHERE),
    ("seen_candidates", "candidates_with_shapes", EVERYWHERE),
    ("Screened", "ScoredCandidate", EVERYWHERE),
    ("View", "CandidateScores, or the view that is meant", EVERYWHERE),
    ("look", "score", SEARCH),
    ("look_again", "rescore, recheck_instruments", EVERYWHERE),
    ("settle_anew", "iterated_gls_from", EVERYWHERE),
    ("Bench", "DiagnosisProblem, SessionInputs", &["crates/diagnosis/src", "crates/session/src"]),
    ("told_apart", "are_distinguishable", EVERYWHERE),
    ("TELL_ALIKE_APART", "BAYES_FACTOR_THRESHOLD", EVERYWHERE),
    ("TELL_APART", "ALIKE_LOG_BAYES", EVERYWHERE),
    ("TELL_APART_BY_COSINE", "COSINE_THRESHOLD", EVERYWHERE),
    ("left_over", "unexplained", EVERYWHERE),
    ("LeftOver", "Unexplained", EVERYWHERE),
    ("Pattern", "FieldPattern", GAUGES),
    ("Carrier", "SuspectComponent", EVERYWHERE),
    ("Carrying", "ExplainedShare", EVERYWHERE),
    ("LooseMember", "missing member", EVERYWHERE),
    ("LooseChange", "MissingMemberChange", EVERYWHERE),
    ("Frozen", "LinearisedModel", SEARCH),
    ("Near", "WarmStart", EVERYWHERE),
    ("Kept", "Memo", SEARCH),
    ("Of", "UseOf", SEARCH),
    ("Lasts", "FaultDuration", EVERYWHERE),
    ("place_many", "batched kinematics", EVERYWHERE),
    ("predict_many", "batched solve", EVERYWHERE),
    ("Twists", "JointRotations", EVERYWHERE),
    ("twists", "joint_rotations", &["crates/beams/src/physics", "crates/diagnosis", "crates/simulation"]),
    ("Deed", "DriverAction, OperatorAction", EVERYWHERE),
    ("deed", "action", EVERYWHERE),
    ("deeds", "actions", EVERYWHERE),
    ("Manner", "AcquisitionSettings", EVERYWHERE),
    ("manner", "acquisition_settings", EVERYWHERE),
    ("Moment", "DriverTimestamp; a moment is N·m", GAUGES),
    ("PieceKind", "FragmentKind", EVERYWHERE),
    ("Piece", "Fragment", GAUGES),
    ("Patience", "PortTimeouts", EVERYWHERE),
    ("patience", "timeouts", EVERYWHERE),
    ("Persistence", "RetryPolicy", EVERYWHERE),
    ("persistence", "retry_policy", EVERYWHERE),
    ("Maker", "EmulatedProtocol", EVERYWHERE),
    ("obey", "handle_command", EVERYWHERE),
    ("sends_unasked", "streams", EVERYWHERE),
    ("HelpingHand", "SimulatedOperator", EVERYWHERE),
    ("Feed", "GaugeStream", EVERYWHERE),
    ("feed", "stream", &["crates/session"]),
    ("Doubt", "CaptureCheck", EVERYWHERE),
    ("doubts", "warnings, failed_checks", EVERYWHERE),
    ("Chosen", "ResolvedEffect", EVERYWHERE),
    ("Hill", "AscentObjective", EVERYWHERE),
    ("Climb", "ProjectedAscent", EVERYWHERE),
    ("climb", "ascend", EVERYWHERE),
    ("cheapest", "quadratic programme", EVERYWHERE),
    ("Compound", "substructure", EVERYWHERE),
    ("Promise", "AcceptanceCriterion", EVERYWHERE),
    ("promises", "criteria", EVERYWHERE),
    ("tell_branches", "assign_branches", EVERYWHERE),
    ("told", "the term for what is reported", &["crates/gauges/src/decode", "crates/session/src", "crates/diagnosis/src", "src"]),
];

/// Files and folders of modules, and the name to use instead.
#[rustfmt::skip]
const REPLACED_FILES: &[(&str, &str)] = &[
    ("few", "low_rank_basis"),
    ("limits", "critical_values"),
    ("draws", "null_samples"),
    ("screen.rs", "score_test.rs"),
    ("leftover", "unexplained"),
    ("carriers", "suspects"),
    ("loose", "missing_member"),
    ("climb", "projected_ascent"),
    ("lanes", "simd"),
    ("practice", "rehearsal"),
    ("look", "inspect"),
    ("zero_look", "zero_check"),
    ("feed", "gauge_stream"),
    ("doubts", "warnings"),
    ("unasked", "streaming"),
    ("promises", "criteria"),
    ("words", "what the words are: keywords, labels, phrases"),
];

/// Types that share a name, and why.
#[rustfmt::skip]
const SHARED: &[(&str, &str)] = &[
    ("BenchOperator", "one for systems with pseudo-terminals and its stand-in for the others"),
    ("Counter", "one for systems with pseudo-terminals and its stand-in for the others"),
    ("NativePort", "one for each family of systems"),
];

/// Folder of the workspace.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Rust files of the workspace, relative to it.
fn sources() -> Vec<(String, String)> {
    let mut folders: Vec<PathBuf> = ["src", "crates", "tests", "benches", "fuzz"]
        .iter()
        .map(|folder| root().join(folder))
        .collect();
    let mut out = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("folder").flatten() {
            let path = entry.path();
            if path.is_dir() && entry.file_name() != "target" {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let name = path.strip_prefix(root()).expect("inside");
                let name = name.to_string_lossy().replace('\\', "/");
                if name != "tests/words.rs" {
                    out.push((name, code_of(&fs::read_to_string(&path).expect("source"))));
                }
            }
        }
    }
    out.sort();
    out
}

/// A source without comments and without the texts of strings; lines stay.
fn code_of(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(hashes) = raw_string(rest) {
            let end = format!("\"{}", "#".repeat(hashes));
            let start = hashes + 2;
            rest[start..]
                .find(&end)
                .map_or(rest.len(), |at| start + at + end.len())
        } else if first == '"' {
            string_length(rest)
        } else if first == '\'' {
            character_length(rest)
        } else {
            0
        };
        if skipped > 0 {
            out.extend(rest[..skipped].chars().filter(|&sign| sign == '\n'));
            out.push(' ');
            rest = &rest[skipped..];
            continue;
        }
        // A word is copied whole, so that the r of a name begins no raw string.
        let end = rest
            .find(|sign: char| !is_word(sign))
            .unwrap_or(rest.len())
            .max(first.len_utf8());
        out.push_str(&rest[..end]);
        rest = &rest[end..];
    }
    out
}

fn is_word(sign: char) -> bool {
    sign.is_alphanumeric() || sign == '_'
}

/// Number of hashes of a raw string that begins here.
fn raw_string(rest: &str) -> Option<usize> {
    let after = rest.strip_prefix('r')?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    after[hashes..].starts_with('"').then_some(hashes)
}

fn string_length(rest: &str) -> usize {
    let mut escaped = false;
    for (at, sign) in rest.char_indices().skip(1) {
        if !escaped && sign == '"' {
            return at + 1;
        }
        escaped = !escaped && sign == '\\';
    }
    rest.len()
}

/// Length of a character literal; zero for a lifetime.
fn character_length(rest: &str) -> usize {
    let inside = &rest[1..];
    if inside.starts_with('\\') {
        return inside[2..].find('\'').map_or(0, |end| end + 4);
    }
    let length = inside.chars().next().map_or(0, char::len_utf8);
    if inside[length..].starts_with('\'') {
        length + 2
    } else {
        0
    }
}

fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    code.lines().enumerate().flat_map(|(line, text)| {
        text.split(|sign: char| !is_word(sign))
            .filter(|word| !word.is_empty())
            .map(move |word| (line + 1, word))
    })
}

fn assert_none(problems: &[String]) {
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

#[test]
fn replaced_names_do_not_come_back() {
    let mut problems = Vec::new();
    for (name, code) in sources() {
        for (line, word) in words(&code) {
            for (old, new, folders) in REPLACED {
                if word == *old && folders.iter().any(|folder| name.starts_with(folder)) {
                    problems.push(format!("{name}, line {line}: `{old}`: use {new}"));
                }
            }
        }
    }
    assert_none(&problems);
}

#[test]
fn replaced_files_do_not_come_back() {
    let mut problems = Vec::new();
    for (name, _) in sources() {
        // The screen of the terminal is a screen.
        let parts = Path::new(&name).iter().filter_map(|part| part.to_str());
        for part in parts {
            for (old, new) in REPLACED_FILES {
                if part == *old || part.strip_suffix(".rs") == Some(old) {
                    problems.push(format!("{name}: `{old}`: use {new}"));
                }
            }
        }
    }
    assert_none(&problems);
}

/// The name that a line declares a type by.
fn declared(line: &str) -> Option<&str> {
    let is_alias_inside = line.starts_with(' ') && line.trim_start().starts_with("type ");
    let mut rest = line.trim_start();
    if let Some(after) = rest.strip_prefix("pub") {
        rest = after.trim_start();
        if let Some(after) = rest.strip_prefix('(') {
            rest = after.split_once(')')?.1.trim_start();
        }
    }
    let (keyword, after) = rest.split_once(' ')?;
    let is_type = matches!(keyword, "struct" | "enum" | "trait" | "type") && !is_alias_inside;
    let end = after
        .find(|sign: char| !is_word(sign))
        .unwrap_or(after.len());
    (is_type && end > 0).then(|| &after[..end])
}

#[test]
fn a_type_name_has_one_meaning() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, code) in sources() {
        if name.contains("tests") || name.starts_with("benches") || name.starts_with("fuzz") {
            continue;
        }
        let inline_tests = code.find("\nmod tests {").unwrap_or(code.len());
        for type_name in code[..inline_tests].lines().filter_map(declared) {
            let places = places.entry(type_name.to_owned()).or_default();
            places.push(name.clone());
        }
    }
    let shared = |name: &str| SHARED.iter().any(|(known, _)| *known == name);
    let problems: Vec<String> = places
        .iter()
        .filter(|(name, places)| places.len() > 1 && !shared(name))
        .map(|(name, places)| format!("{name}: {}", places.join(", ")))
        .collect();
    assert_none(&problems);
}
