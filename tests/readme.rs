//! What the README and the pages name exists: files, links, questions, numbers of the search. Their commands: `page_commands.rs`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use stiffbench_test_files::documentation;

use crate::architecture::sources;
use crate::support::Contains;

/// Lines above which the README is to be split.
const LONGEST_README: usize = 130;

/// Folders whose files a page may name.
const FOLDERS: [&str; 9] = [
    "crates/",
    "src/",
    "tests/",
    "docs/",
    "data/",
    "fixtures/",
    "protocols/",
    "benches/",
    "examples/",
];

/// Pages that must name files as they are: who maintains the program starts there.
const NAMES_FILES: [&str; 4] = [
    "docs/architecture.md",
    "docs/method.md",
    "docs/dependencies.md",
    "docs/glossary.md",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The README, the changelog and all pages, from the root.
fn pages() -> Vec<PathBuf> {
    let mut pages = documentation();
    pages.push(PathBuf::from("CHANGELOG.md"));
    pages
}

/// Lines outside code blocks.
fn prose(markdown: &str) -> impl Iterator<Item = &str> {
    let mut in_block = false;
    markdown.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        in_block ^= fence;
        !fence && !in_block
    })
}

/// Targets of links and pictures, without the part behind `#`.
fn targets(markdown: &str) -> Vec<&str> {
    let ends = prose(markdown).flat_map(|line| line.split("](").skip(1));
    let targets = ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    let files = targets.filter_map(|target| target.split('#').next());
    files
        .filter(|file| !file.is_empty() && !file.contains("://"))
        .collect()
}

/// Paths of this repository that a page names in code spans; those with a placeholder are left out.
fn named_files(markdown: &str) -> Vec<&str> {
    let spans = prose(markdown).flat_map(|line| line.split('`').skip(1).step_by(2));
    spans
        .filter(|span| FOLDERS.iter().any(|folder| span.starts_with(folder)))
        .filter(|span| !span.contains(['*', '<', ' ', '{']))
        .collect()
}

#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap();
    let count = lines.lines().count();
    assert!(count <= LONGEST_README, "the README has {count} lines");
}

#[test]
fn the_readme_and_its_page_name_every_dependency() {
    let members = fs::read_dir(root().join("crates")).unwrap();
    let members = members.map(|member| member.unwrap().path());
    let of_users = members.filter(|path| !path.ends_with("test-files"));
    let folders = of_users.chain([root().to_owned(), root().join("python")]);
    let mut named = BTreeSet::new();
    for folder in folders {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let manifest: toml::Table = toml::from_str(&manifest).unwrap();
        let for_systems = manifest.get("target").and_then(toml::Value::as_table);
        let for_systems = for_systems.into_iter().flat_map(toml::Table::values);
        let tables = for_systems.filter_map(|system| system.get("dependencies"));
        for table in tables.chain(manifest.get("dependencies")) {
            named.extend(table.as_table().unwrap().keys().cloned());
        }
    }
    named.retain(|name| !name.starts_with("stiffbench"));
    assert!(named.contains("faer") && named.contains("rustix"));
    for page in ["README.md", "docs/dependencies.md"] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let is_part = |c: char| c.is_alphanumeric() || "-_".contains(c);
        let words: BTreeSet<&str> = text.split(|c| !is_part(c)).collect();
        let missing = named.iter().filter(|name| !words.contains(name.as_str()));
        assert_eq!(missing.collect::<Vec<_>>(), Vec::<&String>::new(), "{page}");
    }
}

#[test]
fn links_of_the_pages_lead_to_files() {
    for page in pages() {
        let markdown = fs::read_to_string(root().join(&page)).unwrap();
        let folder = page.parent().unwrap();
        for target in targets(&markdown) {
            let file = root().join(folder).join(target);
            assert!(file.exists(), "{}: no file {target}", page.display());
        }
    }
}

/// The anchors of a page: its headings as links name them.
fn anchors(markdown: &str) -> Vec<String> {
    let headings = prose(markdown).filter(|line| line.starts_with('#'));
    let anchor = |line: &str| {
        let text = line.trim_start_matches('#').trim().to_lowercase();
        let kept = text
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.collect::<String>().replace(' ', "-")
    };
    headings.map(anchor).collect()
}

/// Words of the questions that a newcomer asks first: each must be a question of the page.
const FIRST_QUESTIONS: [&str; 11] = [
    "Which robots",
    "Which gauges",
    "How many repeats",
    "What does U hold",
    "add a robot",
    "add a gauge",
    "add a law",
    "my CSV",
    "my testing machine",
    "exit codes mean",
    "sent anywhere",
];

/// The README leads to the questions, each question to a heading: two clicks.
#[test]
fn first_questions_are_answered_within_two_clicks() {
    let text = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    text("README.md").must_contain(&["(docs/questions.md)"]);
    let page = text("docs/questions.md");
    let answers: Vec<&str> = page
        .split("\n\n")
        .filter(|one| one.starts_with("**"))
        .collect();
    for words in FIRST_QUESTIONS {
        let question = |answer: &&&str| answer.split("?**").next().unwrap().contains(words);
        assert_eq!(answers.iter().filter(question).count(), 1, "{words}");
    }
    for answer in answers {
        let links = answer.split("](").skip(1);
        let links = links.filter_map(|rest| rest.split_once(')'));
        let links: Vec<&str> = links.map(|(target, _)| target).collect();
        assert!(!links.is_empty(), "{answer}");
        for link in links {
            let (file, anchor) = link.split_once('#').unwrap_or_else(|| panic!("{link}"));
            let known = anchors(&text(&format!("docs/{file}")));
            assert!(known.iter().any(|one| one == anchor), "{link}: {known:?}");
        }
    }
}

#[test]
fn the_book_lists_every_page() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed = targets(&summary);
    let is_listed = |page: &Path| {
        let name = page.strip_prefix("docs").ok().and_then(Path::to_str);
        name.is_none_or(|name| name == "SUMMARY.md" || listed.contains(&name))
    };
    let missing: Vec<PathBuf> = pages()
        .into_iter()
        .filter(|page| !is_listed(page))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn files_that_pages_for_maintainers_name_exist() {
    for page in NAMES_FILES {
        let markdown = fs::read_to_string(root().join(page)).unwrap();
        // Those of drawings stand without marks.
        let bare = markdown
            .split_whitespace()
            .filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder)));
        for file in named_files(&markdown).into_iter().chain(bare) {
            assert!(root().join(file).exists(), "{page}: no file {file}");
        }
    }
}

/// The page of the search names its files without their folder.
#[test]
fn files_of_the_search_exist() {
    let markdown = fs::read_to_string(root().join("docs/method.md")).unwrap();
    let spans = prose(&markdown).flat_map(|line| line.split('`').skip(1).step_by(2));
    for span in spans.filter(|span| !FOLDERS.iter().any(|folder| span.starts_with(folder))) {
        let extension = Path::new(span).extension();
        let is_file = extension.is_some_and(|end| end == "rs") || span.ends_with('/');
        let file = root().join("crates/diagnosis/src").join(span);
        assert!(!is_file || file.exists(), "docs/method.md: no file {span}");
    }
}

#[test]
fn numbers_of_the_search_on_the_page_are_those_of_the_code() {
    let text = |path: &str| fs::read_to_string(root().join(path)).unwrap();
    let code = sources();
    let code = code
        .iter()
        .filter(|one| one.folder == "crates/diagnosis/src" && !one.path.ends_with("tests.rs"));
    let lines: Vec<&str> = code.flat_map(|one| one.text.lines()).collect();
    let page = text("docs/method.md");
    let (_, section) = page.split_once("\n## 11. ").unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows: Vec<&str> = section.lines().filter(|l| l.starts_with("| `")).collect();
    assert!(rows.len() >= 16, "{} rows", rows.len());
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let name = cells[1].trim_matches('`');
        // Constants of tests are indented.
        let constant = format!("const {name}: ");
        let is_own = |line: &&&str| !line.starts_with(' ') && line.contains(&constant);
        let line = lines.iter().find(is_own);
        let value = line.and_then(|line| line.rsplit_once(" = "));
        let value = value.map(|(_, value)| value.trim_end_matches(';').replace('_', ""));
        assert_eq!(
            value.as_deref(),
            Some(&*cells[2].replace(' ', "")),
            "{name}"
        );
    }
}

#[test]
fn links_and_files_are_found_in_prose_only() {
    let markdown = "see [a](b.md#c), ![d](e.png), [f](https://g.h) and [i](#j); `src/k.rs`, `src/l/<name>.rs`, `m`\n```text\n[n](o) `src/p.rs`\n```\n";
    assert_eq!(targets(markdown), ["b.md", "e.png"]);
    assert_eq!(named_files(markdown), ["src/k.rs"]);
}
