//! One gauge, read by waiting for it: for single readings, for probing and for recording.

use std::io::{ErrorKind, Read, Write};
use std::sync::Arc;
use std::time::Duration;

use serialport::SerialPort;

use stiffbench_units_and_text::clock::Clock;

use super::decode::Decoder;
use super::description::InstrumentDescription;
use super::driver::{AcquisitionSettings, Driver, DriverAction, DriverTimestamp};
use super::gauges::{Ask, GaugeEvent, LinkState};
use super::port::{OpenPort, PortError};
use super::trace::{Sink, TraceEntry, What};

/// One gauge on an open port, read by waiting for it. The same machine as in the live bench, without a second line and without reconnecting.
pub struct Reader {
    open: OpenPort,
    driver: Driver,
    real: Clock,
    clock: Clock,
    trace: Option<Box<dyn Sink>>,
    actions: Vec<DriverAction>,
}

impl Reader {
    /// A gauge on a port that was just opened. Samples are stamped by `clock`.
    #[must_use]
    pub fn new(
        open: OpenPort,
        description: Arc<InstrumentDescription>,
        decoder: Decoder,
        acquisition_settings: AcquisitionSettings,
        clock: Clock,
        trace: Option<Box<dyn Sink>>,
    ) -> Self {
        let real = Clock::default();
        let now = DriverTimestamp::of(&real, &clock);
        let driver = Driver::new(description, decoder, acquisition_settings, &open.path, now);
        Self {
            open,
            driver,
            real,
            clock,
            trace,
            actions: Vec::new(),
        }
    }

    /// The reply of the gauge to the identity request.
    #[must_use]
    pub fn identity(&self) -> Option<&str> {
        self.driver.identity()
    }

    /// Asks the gauge something; the answer comes as an event.
    pub fn ask(&mut self, ask: Ask) {
        self.driver.ask(ask, &mut self.actions);
    }

    /// What happens within `wait`: returns with the first events, or with none when the time is over.
    ///
    /// # Errors
    /// [`PortError::Lost`] when the port is gone.
    pub fn events(&mut self, wait: Duration) -> Result<Vec<GaugeEvent>, PortError> {
        let until_s = self.real.now_s() + wait.as_secs_f64();
        let mut events = Vec::new();
        let mut buffer = [0; 4096];
        loop {
            self.driver.wake(self.now(), &mut self.actions);
            self.carry_out(&mut events)?;
            let left_s = until_s - self.real.now_s();
            if !events.is_empty() || left_s <= 0.0 {
                return Ok(events);
            }
            let due_s =
                (self.driver.due_s() - self.real.now_s()).clamp(0.000_5, left_s.max(0.000_5));
            let waiting = self.open.port.set_timeout(Duration::from_secs_f64(due_s));
            waiting.map_err(|error| self.lost(&error.to_string()))?;
            match self.open.port.read(&mut buffer) {
                Ok(0) => return Err(self.lost("the system delivers no more bytes")),
                Ok(count) => {
                    let now = self.now();
                    self.record(now.at_s, What::Received(buffer[..count].to_vec()));
                    self.driver
                        .received(&buffer[..count], now, &mut self.actions);
                }
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                    ) => {}
                Err(error) => return Err(self.lost(&error.to_string())),
            }
        }
    }

    fn carry_out(&mut self, events: &mut Vec<GaugeEvent>) -> Result<(), PortError> {
        let at_s = self.clock.now_s();
        for action in std::mem::take(&mut self.actions) {
            if let Some(what) = action.traced() {
                self.record(at_s, what);
            }
            match action {
                DriverAction::Send { bytes, .. } => {
                    let written = self.open.port.write_all(&bytes);
                    written.map_err(|error| self.lost(&error.to_string()))?;
                }
                DriverAction::Tell(event) => events.push(event),
                DriverAction::Unused { .. } | DriverAction::Reset => {}
                DriverAction::Refuse { reason } => {
                    return Err(PortError::WrongDevice {
                        port: self.open.path.clone(),
                        problem: reason.to_string(),
                        help: "connect the gauge that was expected".to_owned(),
                    });
                }
            }
        }
        Ok(())
    }

    fn now(&self) -> DriverTimestamp {
        DriverTimestamp::of(&self.real, &self.clock)
    }

    fn record(&mut self, at_s: f64, what: What) {
        if let Some(trace) = &mut self.trace {
            trace.take(TraceEntry { at_s, what });
        }
    }

    fn lost(&mut self, problem: &str) -> PortError {
        let at_s = self.clock.now_s();
        self.record(
            at_s,
            What::Link(LinkState::Lost {
                reason: problem.into(),
            }),
        );
        PortError::Lost {
            port: self.open.path.clone(),
            problem: problem.to_owned(),
        }
    }
}
