//! Whatever a host sends, no emulated gauge stops, and no line loses more than its faults take.

use std::sync::Arc;

use proptest::prelude::*;

use super::{EmulatedGauge, EmulatedLine, LineFault, Until};
use crate::shipped::shipped_instrument;

/// Bytes that commands are made of, and others.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let usual = prop::sample::select(b"?RDXACZPTLISTOUNEMF0123459=p\r\n\x01\x02\x03".to_vec());
    prop::collection::vec(prop_oneof![3 => usual, 1 => any::<u8>()], 0..60)
}

proptest! {
    #[test]
    fn no_gauge_stops(pieces in prop::collection::vec((bytes(), 0.0..0.2), 0..6), value in -1e4..1e4) {
        for file in stiffbench_test_files::shipped_instruments() {
            let description = shipped_instrument(file.name).unwrap();
            let mut gauge = EmulatedGauge::described(&description, Arc::new(move || value));
            let mut now_s = 0.0;
            for (bytes, wait_s) in &pieces {
                now_s += wait_s;
                gauge.receive(bytes, now_s);
                gauge.tick(now_s);
                prop_assert!(gauge.next_due_s().is_none_or(f64::is_finite));
            }
        }
    }

    #[test]
    fn late_partial_and_merged_packets_all_arrive(
        requests in 1_usize..30,
        by_s in 0.0..1.0,
        packets in 1_usize..5,
        pause_s in 0.0..0.5,
    ) {
        let description = shipped_instrument("aikoh-rx").unwrap();
        let gauge = EmulatedGauge::described(&description, Arc::new(|| -12.3));
        let mut line = EmulatedLine::new(gauge);
        line.fail(LineFault::LateReply { by_s }, Until::Packets(5));
        line.fail(LineFault::MergedPackets { packets }, Until::Packets(7));
        line.fail(LineFault::PartialPacket { pause_s }, Until::Packets(9));
        let mut arrived = Vec::new();
        for request in 0..requests {
            arrived.extend(line.receive(b"RDF0\r", request as f64 * 0.1));
        }
        // What is kept back for merging comes with the packets that follow.
        for more in 0..10 {
            arrived.extend(line.receive(b"RDF0\r", 100.0 + f64::from(more)));
        }
        arrived.extend(line.tick(1000.0));
        prop_assert_eq!(arrived, b" +12.3 N\r\n".repeat(requests + 10));
        prop_assert_eq!(line.packets_sent(), requests as u64 + 10);
    }
}
