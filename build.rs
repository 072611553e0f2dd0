//! Records the commit that the program is built from, for `--version`, sessions and reports.

use std::path::Path;
use std::process::Command;

/// What the program consists of.
const SOURCES: [&str; 5] = ["src", "crates", "build.rs", "Cargo.toml", "Cargo.lock"];
/// Length of a shortened commit.
const LENGTH: usize = 12;

fn main() {
    for path in SOURCES {
        println!("cargo:rerun-if-changed={path}");
    }
    let commit = of_checkout().or_else(of_package).unwrap_or_default();
    println!("cargo:rustc-env=PROGRAM_COMMIT={commit}");
    let version = env!("CARGO_PKG_VERSION");
    let version = match commit.as_str() {
        "" => version.to_owned(),
        commit => format!("{version} ({commit})"),
    };
    println!("cargo:rustc-env=PROGRAM_VERSION={version}");
}

/// The commit of the checkout, and whether the sources were changed after it.
fn of_checkout() -> Option<String> {
    // A folder without `.git` may lie inside the repository of somebody else.
    if !Path::new(".git").exists() {
        return None;
    }
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    println!("cargo:rerun-if-changed={log}");
    let commit = git(&["rev-parse", "HEAD"])?;
    let mut status = vec!["status", "--porcelain", "--untracked-files=no", "--"];
    status.extend(SOURCES);
    let changed = !git(&status)?.is_empty();
    let changed = if changed { "+changes" } else { "" };
    Some(format!("{}{changed}", commit.get(..LENGTH)?))
}

/// The commit that Cargo noted when it made the package.
fn of_package() -> Option<String> {
    let noted = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, rest) = noted.split_once("\"sha1\"")?;
    let commit = rest.split('"').nth(1)?;
    let dirty = if noted.contains("\"dirty\": true") {
        "+changes"
    } else {
        ""
    };
    Some(format!("{}{dirty}", commit.get(..LENGTH)?))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
