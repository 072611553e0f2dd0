//! Any text as a session header: no panic, and what is read survives being written.
use stiffbench::readings::SessionHeader;

/// Tries some bytes; those that are no text are left out.
pub(crate) fn run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if let Ok(read) = SessionHeader::from_toml("fuzz.toml", text) {
        let written = read.header.to_toml();
        let again =
            SessionHeader::from_toml("again.toml", &written).expect("what was written can be read");
        assert!(again.unknown_keys.is_empty());
        // A second time nothing may change any more.
        assert_eq!(again.header.to_toml(), written);
    }
}
