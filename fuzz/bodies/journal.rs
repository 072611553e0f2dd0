//! Any bytes as a journal: no panic, the fold of what is read is a state, and what is read survives being written.
use stiffbench::session::{JournalEnd, SessionState, checksum, read_journal, table, write_lines};

/// Tries some bytes.
pub(crate) fn run(bytes: &[u8]) {
    // The checksum would keep a fuzzer out: each line gets the one that belongs to it.
    let mut sealed = Vec::new();
    for line in bytes.split(|byte| *byte == b'\n') {
        sealed.extend_from_slice(line);
        sealed.extend_from_slice(format!(",\"crc\":\"{:08x}\"}}\n", checksum(line)).as_bytes());
    }
    for bytes in [bytes, &sealed] {
        let read = read_journal(bytes);
        assert!(read.good_bytes <= bytes.len());
        let state = SessionState::fold(&read.records);
        let mut rows = Vec::new();
        table(&state, &mut rows).expect("JSON has only finite numbers");
        let again = write_lines(&read.records).expect("what was read is finite");
        let back = read_journal(&again);
        assert_eq!(back.end, JournalEnd::Clean);
        // Notes stand where records were lost.
        let kept = back
            .records
            .iter()
            .filter(|record| read.records.contains(record));
        assert!(kept.eq(&read.records));
    }
}
