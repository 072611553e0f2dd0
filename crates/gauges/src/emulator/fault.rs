//! What can go wrong between a gauge and a program, by name.

use super::gauge::PanelAction;

/// A fault of a bench.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// On the line of a gauge.
    Line(LineFault),
    /// At the gauge itself.
    Gauge(PanelAction),
    /// The adapter is pulled out and put back: the port is gone meanwhile.
    Unplug,
    /// Both adapters are pulled out and come back under each other's name.
    Swap,
    /// The machine sleeps: no line is served meanwhile.
    Suspend,
}

/// A fault of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum LineFault {
    /// A packet comes in two halves with a pause between them.
    PartialPacket {
        /// The pause, s.
        pause_s: f64,
    },
    /// The second half of a packet is lost.
    CutPacket,
    /// Packets are kept back and come at once.
    MergedPackets {
        /// How many.
        packets: usize,
    },
    /// Bytes of no packet come before one; the usual ones if none are given.
    Garbage(Option<Vec<u8>>),
    /// A NUL byte comes before a packet.
    NulBefore,
    /// What the host sends comes back to it.
    Echo,
    /// A packet comes late.
    LateReply {
        /// By how much, s.
        by_s: f64,
    },
    /// Nothing comes and nothing arrives.
    Silence,
}

#[cfg(unix)]
impl Fault {
    /// What ends a fault at the gauge; `None` for one that is over at once, or that the gauge's user must end.
    pub(super) fn undone(&self) -> Option<PanelAction> {
        let Self::Gauge(panel) = self else {
            return None;
        };
        match panel {
            PanelAction::PeakMode(_) => Some(PanelAction::PeakMode(false)),
            PanelAction::Hold(_) => Some(PanelAction::Hold(false)),
            PanelAction::LowBattery(_) => Some(PanelAction::LowBattery(false)),
            PanelAction::Overload(_) => Some(PanelAction::Overload(false)),
            PanelAction::Freeze(_) => Some(PanelAction::Freeze(false)),
            PanelAction::InvertSign(_) => Some(PanelAction::InvertSign(false)),
            PanelAction::ToolOff(_) => Some(PanelAction::ToolOff(false)),
            PanelAction::Zero | PanelAction::Unit(_) | PanelAction::DataKey => None,
        }
    }
}
