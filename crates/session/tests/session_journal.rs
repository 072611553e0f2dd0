//! The journal's reader takes any bytes, and finds every byte that was changed.

use crate::support::{Rig, short};
use jiff::Timestamp;
use proptest::prelude::*;
use stiffbench_session::{
    Damage, Event, Gap, Journal, JournalEnd, JournalError, Noted, OperatorEvent, Surroundings,
    read_journal, write_lines,
};

fn journal(texts: &[&str]) -> Vec<u8> {
    let mut journal = Journal::behind(Vec::new(), 0);
    for (i, text) in texts.iter().enumerate() {
        let note = Event::Note(Noted {
            cell: Some(i),
            text: (*text).to_owned(),
        });
        journal
            .append(note, Timestamp::UNIX_EPOCH, i as f64 * 0.1)
            .unwrap();
    }
    journal.into_store()
}

/// The checksum by the bitwise definition of CRC-32C (polynomial 82F63B78 reversed, RFC 3720 appendix B.4).
#[test]
fn a_line_is_what_the_documentation_shows() {
    let bytes = journal(&["bolt tightened"]);
    let line = String::from_utf8(bytes).unwrap();
    assert_eq!(
        line,
        "{\"seq\":1,\"utc\":\"1970-01-01T00:00:00Z\",\"t_s\":0.0,\"kind\":\"note\",\"data\":{\"cell\":0,\"text\":\"bolt tightened\"},\"crc\":\"3ce6b855\"}\n"
    );
}

#[test]
fn every_changed_byte_is_found_and_named_by_its_line() {
    let bytes = journal(&["one", "two", "three"]);
    let lines: Vec<usize> = bytes
        .iter()
        .enumerate()
        .filter(|(_, b)| **b == b'\n')
        .map(|(i, _)| i)
        .collect();
    for place in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[place] ^= 0x10;
        let read = read_journal(&changed);
        let line = lines.iter().filter(|end| **end < place).count();
        let JournalEnd::Damaged {
            line: found,
            lines: lost,
            ..
        } = read.end
        else {
            panic!("byte {place} is not missed");
        };
        assert_eq!(found, line + 1, "byte {place}");
        // The others stay, and where a line break was damaged all do.
        let expected = usize::from(bytes[place] != b'\n');
        let kept = read.records.len();
        assert_eq!((lost, kept), (expected, 3 - expected), "byte {place}");
    }
}

#[test]
fn a_checksum_in_capitals_is_damage_and_its_record_is_kept() {
    let bytes = journal(&["one", "two", "three"]);
    let seals = bytes.split(|byte| *byte == b'\n').scan(0, |end, line| {
        let from = *end + line.len().saturating_sub(10);
        *end += line.len() + 1;
        Some(from..*end - 1)
    });
    let letters: Vec<usize> = seals
        .flatten()
        .filter(|place| bytes[*place].is_ascii_lowercase())
        .collect();
    assert!(!letters.is_empty());
    for place in letters {
        let mut changed = bytes.clone();
        changed[place] ^= 0x20;
        let read = read_journal(&changed);
        assert!(
            matches!(read.end, JournalEnd::Damaged { lines: 0, .. }),
            "byte {place}: {:?}",
            read.end
        );
        assert_eq!(read.records.len(), 3, "byte {place}");
    }
}

#[test]
fn a_line_that_is_missing_or_twice_is_found() {
    let bytes = journal(&["one", "two", "three"]);
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // The second is missing and the third stands twice; the first stands twice; lines are exchanged.
    let orders = [
        (vec![0, 2, 2], 3, 1, vec![1, 3]),
        (vec![0, 0, 1], 1, 0, vec![1, 2]),
        (vec![0, 2, 1], 3, 0, vec![1, 2, 3]),
    ];
    for (order, found, lost, kept) in orders {
        let mixed: String = order.iter().map(|i| lines[*i]).collect();
        let read = read_journal(mixed.as_bytes());
        let expected = Damage::Sequence { found, expected: 2 };
        assert!(
            matches!(read.end, JournalEnd::Damaged { line: 2, problem, lines } if problem == expected && lines == lost)
        );
        assert_eq!(
            read.records
                .iter()
                .map(|record| record.seq)
                .collect::<Vec<_>>(),
            kept
        );
    }
}

#[test]
fn a_newer_event_is_distinguished_from_a_damaged_one() {
    let body = "{\"seq\":1,\"utc\":\"1970-01-01T00:00:00Z\",\"t_s\":0.0,\"kind\":\"levitated\",\"data\":{}";
    let line = format!(
        "{body},\"crc\":\"{:08x}\"}}\n",
        crc32c::crc32c(body.as_bytes())
    );
    let read = read_journal(line.as_bytes());
    assert!(matches!(
        read.end,
        JournalEnd::Damaged {
            problem: Damage::NotUnderstood { .. },
            ..
        }
    ));
}

#[test]
fn a_number_that_is_not_finite_is_refused() {
    let mut journal = Journal::behind(Vec::new(), 0);
    for value in [f64::NAN, f64::INFINITY] {
        let event = Event::Environment(Surroundings {
            temperature_deg_c: Some(value),
            ..Surroundings::default()
        });
        let error = journal
            .append(event, Timestamp::UNIX_EPOCH, 0.0)
            .unwrap_err();
        assert!(matches!(error, JournalError::NotWritable { .. }));
    }
    assert!(
        journal
            .append(Event::Gap(Gap { seconds: 1.0 }), Timestamp::UNIX_EPOCH, 0.0)
            .is_ok()
    );
    assert_eq!(read_journal(&journal.into_store()).records.len(), 1);
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let read = read_journal(&bytes);
        prop_assert!(read.good_bytes <= bytes.len());
    }

    #[test]
    fn any_number_and_text_comes_back(
        seconds in prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL,
        text in any::<String>(),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut journal = Journal::behind(Vec::new(), 0);
        let events = [Event::Gap(Gap { seconds }), Event::Note(Noted { cell: None, text })];
        for event in events.clone() {
            journal.append(event, Timestamp::UNIX_EPOCH, seconds).unwrap();
        }
        let bytes = journal.into_store();
        let read = read_journal(&bytes);
        prop_assert_eq!(&read.end, &JournalEnd::Clean);
        for (record, event) in read.records.iter().zip(&events) {
            prop_assert_eq!(&record.event, event);
        }
        // Cut anywhere: what was whole stays, the rest is a cut line and nothing else.
        let cut = cut.index(bytes.len());
        let part = read_journal(&bytes[..cut]);
        prop_assert_eq!(&part.records[..], &read.records[..part.records.len()]);
        let whole_lines = bytes[..cut].split(|b| *b == b'\n').count() - 1;
        // A line of which only the line break is missing is whole.
        let needs_break = part.end == JournalEnd::Cut { bytes: 0 };
        prop_assert_eq!(part.records.len(), whole_lines + usize::from(needs_break));
        let is_damaged = matches!(part.end, JournalEnd::Damaged { .. });
        prop_assert!(!is_damaged);
    }
}

/// Whatever an editor, a transfer or a power cut adds, no record whose bytes are all there is lost.
#[test]
fn what_another_program_adds_costs_no_record() {
    let bytes = journal(&["one", "two", "three"]);
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let utf16 = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let units = "\u{feff}".encode_utf16().chain(text.encode_utf16());
        units.flat_map(order).collect()
    };
    #[rustfmt::skip]
    let added: [(&str, usize, Vec<u8>); 17] = [
        ("CR LF", 1, text.replace('\n', "\r\n").into()),
        ("CR", 1, text.replace('\n', "\r").into()),
        ("mark", 1, format!("\u{feff}{text}").into()),
        ("CR LF and mark", 1, format!("\u{feff}{}", text.replace('\n', "\r\n")).into()),
        ("blanks behind", 1, text.replace('\n', "  \n").into()),
        ("tab before", 1, format!("\t{text}").into()),
        ("blank lines", 2, format!("{}\n\n\n{}\n{}\n", lines[0], lines[1], lines[2]).into()),
        ("blank line first", 1, format!("\n{text}").into()),
        ("blank line last", 4, format!("{text}\n").into()),
        ("one line", 1, lines.concat().into()),
        ("a list", 1, format!("[{}]\n", lines.join(",\n")).into()),
        ("quoted", 1, format!("> {}\n", lines.join("\n> ")).into()),
        ("NUL between", 2, format!("{}\n\0\0\0{}\n{}\n", lines[0], lines[1], lines[2]).into()),
        ("words behind", 3, format!("{} # end\n", text.trim_end()).into()),
        ("UTF-16 LE", 1, utf16(u16::to_le_bytes)),
        ("UTF-16 BE", 1, utf16(u16::to_be_bytes)),
        ("another journal behind", 4, [text.as_str(), &text].concat().into()),
    ];
    for (name, at, bytes) in added {
        let read = read_journal(&bytes);
        let seqs: Vec<u64> = read.records.iter().map(|record| record.seq).collect();
        assert_eq!(seqs, [1, 2, 3], "{name}");
        assert!(
            matches!(read.end, JournalEnd::Damaged { line, lines: 0, .. } if line == at),
            "{name}: {:?}",
            read.end
        );
        let again = read_journal(&write_lines(&read.records).unwrap());
        assert_eq!(
            (again.records, again.end),
            (read.records, JournalEnd::Clean),
            "{name}"
        );
    }
    // What a power cut leaves is no damage.
    for (tail, bytes) in [("\0\0\0", 3), ("{\"se", 4), ("{\"seq\":4,\"utc", 13)] {
        let read = read_journal(format!("{text}{tail}").as_bytes());
        assert_eq!(
            (read.records.len(), read.end),
            (3, JournalEnd::Cut { bytes })
        );
        assert_eq!(read.good_bytes, text.len());
    }
    let read = read_journal(text.trim_end().as_bytes());
    assert_eq!(
        (read.records.len(), read.end),
        (3, JournalEnd::Cut { bytes: 0 })
    );
}

#[test]
fn a_number_that_was_forged_or_is_there_with_other_words_counts_once() {
    let (mut bytes, other) = (journal(&["one", "two"]), journal(&["another"]));
    let mut far = read_journal(&other).records.remove(0);
    bytes.extend(other);
    let read = read_journal(&bytes);
    assert!(matches!(
        read.end,
        JournalEnd::Damaged {
            line: 3,
            lines: 1,
            ..
        }
    ));
    assert!(matches!(&read.records[0].event, Event::Note(noted) if noted.text == "one"));
    far.seq = u64::MAX;
    bytes.extend(stiffbench_session::write_line(&far).unwrap());
    assert_eq!(read_journal(&bytes).records.len(), 2);
}

#[test]
fn a_lost_event_leaves_a_note_and_all_others() {
    let mut bytes = journal(&["one", "two", "three", "four"]);
    let second = bytes.iter().position(|byte| *byte == b'\n').unwrap() + 30;
    bytes[second] ^= 0x01;
    let read = read_journal(&bytes);
    let again = read_journal(&write_lines(&read.records).unwrap());
    assert_eq!(again.end, JournalEnd::Clean);
    let texts: Vec<String> = again
        .records
        .iter()
        .map(|record| match &record.event {
            Event::Note(noted) => noted.text.clone(),
            other => panic!("{other:?}"),
        })
        .collect();
    let lost = "event 2 was lost: its line in the journal was damaged";
    assert_eq!(texts, ["one", lost, "three", "four"]);
}

#[test]
fn a_note_at_the_question_for_a_pose_is_on_the_cell_that_is_set_up() {
    let mut rig = Rig::start(&short(false));
    rig.leaves_open = "setup";
    rig.until(1000, |rig| rig.machine.view().prompt.is_some());
    let text = Some("the bolt was loose".to_owned());
    rig.operator(OperatorEvent::Note { text });
    let notes = &rig.machine.state().notes;
    assert_eq!(notes[0].1.cell, Some(0));
    assert!(
        rig.machine.view().prompt.is_some(),
        "the question is still open"
    );
}
