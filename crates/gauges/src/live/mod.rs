//! The gauges of a bench over serial lines, both at once.
//!
//! One thread with one event loop serves all lines: it sleeps until a byte comes, a deadline is over or somebody asks. Every byte is stamped
//! when it arrives. A lost line is searched for again by its identity, with a pause that grows up to a bound, and the gauge that answers has to be
//! the gauge that was there before. What happened waits in a queue of bounded length.

mod back_off;
mod line;
mod queue;
mod wire;

use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Duration;

use miette::Diagnostic;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use stiffbench_units_and_text::clock::Clock;

use super::decode::{Decoder, DecoderError};
use super::description::InstrumentDescription;
use super::driver::Acquisition;
use super::gauges::{Ask, GaugeEvent, Gauges};
use super::port::{PortIdentity, PortTimeouts};
use super::sample::Channel;
use super::trace::Sink;

use line::LiveLine;
use queue::Queue;

pub use back_off::RetryPolicy;

/// One gauge of a live bench.
pub struct LiveGauge {
    /// Its description.
    pub description: InstrumentDescription,
    /// Unit, where it does not send one.
    pub unit: Option<String>,
    /// Where it is.
    pub port: PortIdentity,
    /// How its values are had.
    pub acquisition: Acquisition,
    /// The identity that it reported, if known: another identity is another gauge.
    pub identity: Option<String>,
    /// Where its bytes are recorded.
    pub trace: Option<Box<dyn Sink>>,
}

/// Why a live bench cannot start.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum LiveError {
    /// A description that cannot decode as configured.
    #[error("the {channel} gauge cannot be read")]
    #[diagnostic(code(stiffbench::live::decoder))]
    Decoder {
        /// Which gauge.
        channel: Channel,
        /// Why not.
        #[source]
        #[diagnostic_source]
        source: DecoderError,
    },
    /// The system gives no event loop.
    #[error("no event loop is available for serial lines")]
    #[diagnostic(
        code(stiffbench::live::event_loop),
        help("too many files may be open; close other programs")
    )]
    EventLoop {
        /// Its content.
        source: std::io::Error,
    },
}

/// The gauges of a bench over serial lines.
#[derive(Debug)]
pub struct LiveGauges {
    queue: Arc<Queue>,
    asks: Vec<(Channel, UnboundedSender<Ask>)>,
    thread: Option<JoinHandle<()>>,
}

impl LiveGauges {
    /// Starts reading. Ports are opened in the background; how that goes comes as events.
    ///
    /// Samples are stamped by `clock`; deadlines of the lines run in real time.
    ///
    /// # Errors
    /// [`LiveError`], before any port is touched.
    pub fn start(
        gauges: Vec<LiveGauge>,
        clock: Clock,
        timeouts: PortTimeouts,
        retry_policy: RetryPolicy,
    ) -> Result<Self, LiveError> {
        let queue = Arc::new(Queue::default());
        let mut asks = Vec::new();
        let mut lines = Vec::new();
        for gauge in gauges {
            let channel = gauge.description.channel;
            Decoder::new(&gauge.description, gauge.unit.as_deref())
                .map_err(|source| LiveError::Decoder { channel, source })?;
            let (asking, asked) = unbounded_channel();
            asks.push((channel, asking));
            lines.push(LiveLine::new(
                gauge,
                clock,
                timeouts,
                retry_policy,
                asked,
                Arc::clone(&queue),
            ));
        }
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|source| LiveError::EventLoop { source })?;
        let thread = thread::spawn(move || {
            runtime.block_on(async {
                let local = tokio::task::LocalSet::new();
                for line in lines {
                    local.spawn_local(line.serve());
                }
                local.await;
            });
        });
        Ok(Self {
            queue,
            asks,
            thread: Some(thread),
        })
    }
}

impl Gauges for LiveGauges {
    fn next(&mut self, wait: Duration) -> Option<GaugeEvent> {
        self.queue.pop(wait)
    }

    fn ask(&mut self, channel: Channel, ask: Ask) {
        let line = self.asks.iter().find(|(of, _)| *of == channel);
        if line.is_none_or(|(_, asking)| asking.send(ask).is_err()) {
            let answer = Err(format!("there is no {channel} gauge on this bench").into());
            self.queue.push(GaugeEvent::Answered {
                channel,
                ask,
                answer,
            });
        }
    }
}

impl Drop for LiveGauges {
    /// Stops the streams that were started, closes the ports, ends the traces.
    fn drop(&mut self) {
        self.asks.clear();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to close.
            let _ = thread.join();
        }
    }
}
