//! What stands between a session and whoever operates it: Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::cli::outcome::print_error;
use crate::session::{Operator, OperatorEvent};

/// An operator whose signals count: the first Ctrl-C (or request to end) stops at the next safe point, the second at once.
pub(super) struct AtBench {
    inner: Box<dyn Operator>,
    /// Set by the signal, taken back here.
    signalled: Arc<AtomicBool>,
    interrupted: bool,
}

impl AtBench {
    /// Listens to signals from now on; where that cannot be, Ctrl-C ends the program, and the session can be resumed.
    pub(super) fn new(inner: Box<dyn Operator>) -> Self {
        let signalled = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
            if let Err(error) = signal_hook::flag::register(signal, Arc::clone(&signalled)) {
                print_error(&format!("note: no signal handler: {error}"));
            }
        }
        Self {
            inner,
            signalled,
            interrupted: false,
        }
    }
}

impl Operator for AtBench {
    fn behind(&mut self) -> Option<&mut dyn Operator> {
        Some(&mut *self.inner)
    }

    fn poll(&mut self, wait: Duration) -> Option<OperatorEvent> {
        let event = if self.signalled.swap(false, Ordering::Relaxed) {
            OperatorEvent::Interrupt
        } else {
            self.inner.poll(wait)?
        };
        // Whatever the first came from, the second is the last.
        if event == OperatorEvent::Interrupt && std::mem::replace(&mut self.interrupted, true) {
            return Some(OperatorEvent::Abort);
        }
        Some(event)
    }
}
