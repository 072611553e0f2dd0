//! How the line to a gauge stands, in words for the operator.

use stiffbench_gauges::LinkState;

/// How a line stands, in words.
pub(super) fn link_text(state: &LinkState) -> String {
    match state {
        LinkState::Connected { port } => format!("connected on {port}"),
        LinkState::Silent => {
            "connected, but nothing comes: switched off, asleep or in a menu?".to_owned()
        }
        LinkState::Slow { reason } => reason.to_string(),
        LinkState::Lost { reason } => format!("the line is lost: {reason}"),
        LinkState::Reconnecting { attempt } => format!("looking for it again, try {attempt}"),
        LinkState::WrongDevice { reason } => format!("something else answers: {reason}"),
        LinkState::GivenUp => "not found; plug it in and press p to search again".to_owned(),
    }
}
