//! The archive of a release: what is in it, and its installer.

use std::path::Path;
use std::process::{Command, Output};

use super::desk;
use crate::support::Contains;

fn sh(folder: &Path, script: &str) -> Output {
    Command::new("sh")
        .current_dir(folder)
        .env("PROGRAM", env!("CARGO_BIN_EXE_stiffbench"))
        .env("REPOSITORY", env!("CARGO_MANIFEST_DIR"))
        .args(["-euc", script])
        .output()
        .unwrap()
}

fn succeeds(folder: &Path, script: &str) -> String {
    let done = sh(folder, script);
    assert!(
        done.status.success(),
        "{script}: {}",
        String::from_utf8_lossy(&done.stderr)
    );
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn the_archive_installs_the_program_and_refuses_a_damaged_file() {
    let desk = desk();
    let folder = desk.folder.path();
    succeeds(
        folder,
        "\"$REPOSITORY/packaging/archive.sh\" \"$PROGRAM\" made",
    );
    succeeds(
        folder,
        "cd made; sha256sum -c *.sha256; tar -xzf *.tar.gz; mv stiffbench-*/ ../unpacked",
    );
    let told = succeeds(folder, "./unpacked/install.sh \"$PWD/prefix\"");
    told.must_contain(&["prefix/bin/stiffbench"]);
    let version = succeeds(folder, "prefix/bin/stiffbench --version");
    assert_eq!(
        version.trim(),
        concat!("stiffbench ", env!("PROGRAM_VERSION"))
    );
    for file in [
        "man/man1/stiffbench-session-run.1.gz",
        "bash-completion/completions/stiffbench",
        "zsh/site-functions/_stiffbench",
        "fish/vendor_completions.d/stiffbench.fish",
        "doc/stiffbench/LICENSE-MIT",
    ] {
        assert!(
            desk.path(&format!("prefix/share/{file}")).exists(),
            "{file}"
        );
    }
    succeeds(
        folder,
        "printf x >> unpacked/share/doc/stiffbench/README.md",
    );
    let refused = sh(folder, "./unpacked/install.sh \"$PWD/other\"");
    assert!(!refused.status.success());
    let told = String::from_utf8(refused.stderr).unwrap();
    told.must_contain(&["nothing was installed"]);
    assert!(!desk.path("other").exists());
}
