//! Which faults of a script are due.

use std::collections::BTreeMap;

use crate::Channel;

use super::fault_script::{FaultScript, ScriptedFault, When};

/// Hands out the faults of a script when their moment has come, each once.
#[derive(Debug, Default)]
pub struct FaultRunner {
    pending: Vec<ScriptedFault>,
    readings: u64,
    phases: BTreeMap<Box<str>, u64>,
}

impl FaultRunner {
    /// Nothing has happened yet.
    #[must_use]
    pub fn new(script: FaultScript) -> Self {
        Self {
            pending: script.faults,
            ..Self::default()
        }
    }

    /// Adds a fault.
    pub fn add(&mut self, fault: ScriptedFault) {
        self.pending.push(fault);
    }

    /// Whether faults are left.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.pending.is_empty()
    }

    /// The faults that are due at a session time, s.
    pub fn at_time(&mut self, session_s: f64) -> Vec<ScriptedFault> {
        self.take(|fault| match fault.when {
            When::Now => true,
            When::Time(at_s) => at_s <= session_s,
            _ => false,
        })
    }

    /// The faults that are due before a gauge sends its next packet. A fault of both gauges begins with the packet of the one that comes first.
    ///
    /// # Arguments
    /// - `sent`: how many packets it has sent.
    pub fn before_packet(&mut self, channel: Channel, sent: u64) -> Vec<ScriptedFault> {
        self.take(|fault| match fault.when {
            When::Packet(number) => number <= sent + 1 && fault.concerns(channel),
            _ => false,
        })
    }

    /// A load is set; the faults that are due.
    pub fn reading(&mut self) -> Vec<ScriptedFault> {
        self.readings += 1;
        let readings = self.readings;
        self.take(|fault| matches!(fault.when, When::Reading(number) if number <= readings))
    }

    /// A phase of the session begins; the faults that are due.
    pub fn phase(&mut self, name: &str) -> Vec<ScriptedFault> {
        let times = self.phases.entry(name.into()).or_default();
        *times += 1;
        let times = *times;
        self.take(|fault| match &fault.when {
            When::Phase(phase, number) => **phase == *name && *number <= times,
            _ => false,
        })
    }

    fn take(&mut self, due: impl Fn(&ScriptedFault) -> bool) -> Vec<ScriptedFault> {
        self.pending.extract_if(.., |fault| due(fault)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_units_and_text::source_text::SourceText;

    fn runner(moments: &[&str]) -> FaultRunner {
        let entries: Vec<String> = moments
            .iter()
            .map(|moment| format!("[[fault]]\nwhat = \"nul\"\ngauge = \"force\"\n{moment}\n"))
            .collect();
        let text = format!("schema = \"stiffbench/faults/1\"\n{}", entries.concat());
        FaultRunner::new(FaultScript::parse(&SourceText::new("f", text)).unwrap())
    }

    #[test]
    fn each_fault_occurs_once_at_its_time() {
        let mut runner = runner(&[
            "at_s = 5",
            "packet = 3",
            "reading = 2",
            "phase = \"zero\"\nnth = 2",
            "",
        ]);
        assert_eq!(runner.at_time(0.0).len(), 1, "at once");
        assert_eq!(runner.at_time(4.9).len(), 0);
        assert_eq!(runner.at_time(5.0).len(), 1);
        assert_eq!(runner.before_packet(Channel::Force, 1).len(), 0);
        assert_eq!(runner.before_packet(Channel::Displacement, 2).len(), 0);
        assert_eq!(runner.before_packet(Channel::Force, 2).len(), 1);
        assert_eq!((runner.reading().len(), runner.reading().len()), (0, 1));
        assert_eq!(runner.phase("settle").len(), 0);
        assert_eq!(
            (runner.phase("zero").len(), runner.phase("zero").len()),
            (0, 1)
        );
        assert!(runner.is_done());
        assert_eq!(runner.at_time(1e9).len(), 0);
    }
}
