//! One line of the live bench: found, opened, served, lost, found again.

use std::sync::Arc;
use std::thread;
use std::time::Duration;

use miette::Diagnostic;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::time::sleep;

use crate::Channel;
use crate::Decoder;
use crate::driver::{Acquisition, AcquisitionSettings, Driver, DriverAction, DriverTimestamp};
use crate::port::{
    OpenPort, PortError, PortIdentity, PortSettings, PortTimeouts, list_ports, open,
};
use crate::trace::{Sink, TraceEntry, What};
use crate::{Ask, GaugeEvent, LinkState};
use crate::{CommandEffect, CommandRole, InstrumentDescription};
use stiffbench_units_and_text::clock::Clock;

use super::LiveGauge;
use super::back_off::RetryPolicy;
use super::queue::Queue;
use super::wire::Wire;

/// Bytes taken at once; a line at full speed gives far fewer between two looks.
const AT_ONCE: usize = 4096;

/// One line of the live bench.
pub(super) struct LiveLine {
    description: Arc<InstrumentDescription>,
    unit: Option<String>,
    port: PortIdentity,
    acquisition: Acquisition,
    identity: Option<Box<str>>,
    clock: Clock,
    real: Clock,
    timeouts: PortTimeouts,
    retry_policy: RetryPolicy,
    asked: UnboundedReceiver<Ask>,
    /// The last trouble that was reported.
    trouble: String,
    out: Out,
}

/// Where things go: to the session and into the trace.
struct Out {
    channel: Channel,
    queue: Arc<Queue>,
    trace: Option<Box<dyn Sink>>,
    /// Bytes that the gauge sent so far: where the next stands among those of the trace.
    received: u64,
}

/// Why a line is not served any more.
enum Ending {
    /// No receiver is left.
    Stopped,
    /// The port is gone.
    Lost(PortError),
    /// Another instrument answers.
    Refused(Box<str>),
}

impl LiveLine {
    pub(super) fn new(
        gauge: LiveGauge,
        clock: Clock,
        timeouts: PortTimeouts,
        retry_policy: RetryPolicy,
        asked: UnboundedReceiver<Ask>,
        queue: Arc<Queue>,
    ) -> Self {
        Self {
            out: Out {
                channel: gauge.description.channel,
                queue,
                trace: gauge.trace,
                received: 0,
            },
            description: Arc::new(gauge.description),
            unit: gauge.unit,
            port: gauge.port,
            acquisition: gauge.acquisition,
            identity: gauge.identity.map(Into::into),
            clock,
            real: Clock::default(),
            trouble: String::new(),
            timeouts,
            retry_policy,
            asked,
        }
    }

    /// Serves the line until no receiver is left.
    pub(super) async fn serve(mut self) {
        let mut attempt = 0;
        loop {
            let ending = match self.connect().await {
                Ok(wire) => self.talk(wire, &mut attempt).await,
                Err(ending) => ending,
            };
            if matches!(ending, Ending::Stopped) {
                return;
            }
            self.report_trouble(ending, attempt);
            attempt += 1;
            if !self.pause(&mut attempt).await {
                return;
            }
        }
    }

    /// Reports why the line is not served; while it is searched for, each reason once.
    fn report_trouble(&mut self, ending: Ending, attempt: u32) {
        let (text, is_wrong) = match ending {
            Ending::Stopped => return,
            // Its absence has been reported.
            Ending::Lost(PortError::Absent { .. }) if attempt > 0 => return,
            Ending::Lost(error) => (
                reason(&error),
                matches!(error, PortError::WrongDevice { .. }),
            ),
            Ending::Refused(reason) => (reason.into_string(), true),
        };
        if attempt > 0 && self.trouble == text {
            return;
        }
        self.trouble.clone_from(&text);
        let reason = text.into();
        match (is_wrong, attempt) {
            (true, _) => self.link(LinkState::WrongDevice { reason }),
            (false, 0) => self.link(LinkState::Lost { reason }),
            (false, _) => self.note(reason.into()),
        }
    }

    /// Waits before the next try; questions meanwhile are answered with what is known. `false` if no receiver is left.
    async fn pause(&mut self, attempt: &mut u32) -> bool {
        let Some(pause_s) = self.retry_policy.pause_s(*attempt) else {
            self.link(LinkState::GivenUp);
            *attempt = 1;
            let Some(ask) = self.asked.recv().await else {
                return false;
            };
            self.out.unanswered(ask);
            self.link(LinkState::Reconnecting { attempt: 1 });
            return true;
        };
        let over = sleep(Duration::from_secs_f64(pause_s));
        tokio::pin!(over);
        loop {
            tokio::select! {
                () = &mut over => break,
                asked = self.asked.recv() => match asked {
                    Some(ask) => self.out.unanswered(ask),
                    None => return false,
                },
            }
        }
        self.link(LinkState::Reconnecting { attempt: *attempt });
        true
    }

    /// Finds the port by its identity and opens it on a worker; the other line goes on meanwhile.
    async fn connect(&mut self) -> Result<Wire, Ending> {
        let ports = list_ports().map_err(Ending::Lost)?;
        let resolved = self.port.resolve(&ports).map_err(Ending::Lost)?;
        if let Some(note) = resolved.note {
            self.note(note);
        }
        let settings = PortSettings::of(&self.description.line, &self.description.modem);
        let timeouts = self.timeouts;
        let (report, mut reported) = unbounded_channel();
        thread::spawn(move || {
            let mut note = |text| {
                // Nobody listens any more: the port is closed when it goes out of scope.
                let _ = report.send(Opening::Note(text));
            };
            let opened = open(&resolved.path, &settings, &timeouts, &mut note);
            let _ = report.send(Opening::Done(opened));
        });
        loop {
            tokio::select! {
                told = reported.recv() => match told {
                    Some(Opening::Note(text)) => {
                        if self.trouble != text {
                            self.trouble.clone_from(&text);
                            self.note(text);
                        }
                    }
                    Some(Opening::Done(opened)) => {
                        return opened.and_then(Wire::of).map_err(Ending::Lost);
                    }
                    None => return Err(Ending::Stopped),
                },
                asked = self.asked.recv() => match asked {
                    Some(ask) => self.out.unanswered(ask),
                    None => return Err(Ending::Stopped),
                },
            }
        }
    }

    /// Talks with the gauge until something ends it.
    async fn talk(&mut self, mut wire: Wire, attempt: &mut u32) -> Ending {
        let Ok(decoder) = Decoder::new(&self.description, self.unit.as_deref()) else {
            // It was checked at the start.
            return Ending::Stopped;
        };
        let decoder = decoder.behind(self.out.received);
        let mut driver = Driver::new(
            Arc::clone(&self.description),
            decoder,
            AcquisitionSettings {
                acquisition: self.acquisition,
                keep_awake: true,
                expected: self.identity.clone(),
            },
            wire.path(),
            self.now(),
        );
        let ending = self.converse(&mut wire, &mut driver, attempt).await;
        if matches!(ending, Ending::Stopped) && self.acquisition == Acquisition::Stream {
            self.stop_stream(&mut wire).await;
        }
        let mut actions = Vec::new();
        driver.abandon(&mut actions);
        for action in actions {
            if let DriverAction::Tell(event) = action {
                self.out.queue.push(event);
            }
        }
        ending
    }

    async fn converse(
        &mut self,
        wire: &mut Wire,
        driver: &mut Driver,
        attempt: &mut u32,
    ) -> Ending {
        let mut buffer = vec![0; AT_ONCE];
        let mut actions = Vec::new();
        loop {
            driver.wake(self.now(), &mut actions);
            if let Err(ending) = self.carry_out(&mut actions, wire).await {
                return ending;
            }
            if driver.is_up() {
                *attempt = 0;
                if self.identity.is_none() {
                    self.identity = driver.identity().map(Into::into);
                }
            }
            let wait_s = (driver.due_s() - self.real.now_s()).max(0.0);
            tokio::select! {
                read = wire.read(&mut buffer) => match read {
                    Ok(count) => {
                        let now = self.now();
                        self.out.record(now.at_s, What::Received(buffer[..count].to_vec()));
                        driver.received(&buffer[..count], now, &mut actions);
                    }
                    Err(error) => return Ending::Lost(error),
                },
                () = sleep(Duration::try_from_secs_f64(wait_s).unwrap_or(Duration::MAX)) => {}
                asked = self.asked.recv() => match asked {
                    Some(ask) => driver.ask(ask, &mut actions),
                    None => return Ending::Stopped,
                },
            }
        }
    }

    async fn carry_out(
        &mut self,
        actions: &mut Vec<DriverAction>,
        wire: &mut Wire,
    ) -> Result<(), Ending> {
        for action in actions.drain(..) {
            let at_s = self.clock.now_s();
            if let Some(what) = action.traced() {
                self.out.record(at_s, what);
            }
            match action {
                DriverAction::Send { bytes, .. } => {
                    wire.write(&bytes).await.map_err(Ending::Lost)?;
                }
                DriverAction::Refuse { reason } => return Err(Ending::Refused(reason)),
                DriverAction::Tell(event) => self.out.queue.push(event),
                DriverAction::Unused { .. } | DriverAction::Reset => {}
            }
        }
        Ok(())
    }

    /// Leaves the gauge as it was found.
    async fn stop_stream(&mut self, wire: &mut Wire) {
        let Some(command) = self.description.command(CommandRole::StreamStop) else {
            return;
        };
        if command.effect == CommandEffect::Sets {
            let bytes = command.bytes.clone();
            self.out.record(
                self.clock.now_s(),
                What::Sent {
                    role: Some(CommandRole::StreamStop),
                    bytes: bytes.clone(),
                },
            );
            // The line may be gone; then there is nothing to stop.
            let _ = wire.write(&bytes).await;
        }
    }

    fn now(&self) -> DriverTimestamp {
        DriverTimestamp::of(&self.real, &self.clock)
    }

    fn link(&mut self, state: LinkState) {
        let at_s = self.clock.now_s();
        self.out.record(at_s, What::Link(state.clone()));
        self.out.queue.push(GaugeEvent::Link {
            channel: self.out.channel,
            state,
            at_s,
        });
    }

    fn note(&mut self, text: String) {
        let at_s = self.clock.now_s();
        self.out.record(at_s, What::Note(text.clone()));
        self.out.queue.push(GaugeEvent::Note {
            channel: self.out.channel,
            text: text.into(),
            at_s,
        });
    }
}

/// How opening goes.
enum Opening {
    Note(String),
    Done(Result<OpenPort, PortError>),
}

impl Out {
    fn record(&mut self, at_s: f64, what: What) {
        if let What::Received(bytes) = &what {
            self.received += bytes.len() as u64;
        }
        if let Some(trace) = &mut self.trace {
            trace.take(TraceEntry { at_s, what });
        }
    }

    fn unanswered(&mut self, ask: Ask) {
        let answer = Err("the gauge is not connected".into());
        self.queue.push(GaugeEvent::Answered {
            channel: self.channel,
            ask,
            answer,
        });
    }
}

/// An error and its remedy in one line.
fn reason(error: &PortError) -> String {
    match error.help() {
        Some(help) => format!("{error}; {help}"),
        None => error.to_string(),
    }
}
