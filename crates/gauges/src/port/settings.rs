//! Everything that is set on a port when it is opened.

use std::fmt;
use std::time::Duration;

use serialport::{DataBits, FlowControl, Parity, SerialPortBuilder, StopBits};

use crate::{Flow, LineSettings, ModemLines};

/// Everything that is set on a port when it is opened; nothing is left as a former program left it.
///
/// A pseudo-terminal does not keep parity and data bits, so what is meant is tested here and not on a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortSettings {
    /// Speed, bit/s.
    pub baud: u32,
    /// Data bits of a character.
    pub data_bits: DataBits,
    /// Parity bit.
    pub parity: Parity,
    /// Stop bits.
    pub stop_bits: StopBits,
    /// Flow control.
    pub flow: FlowControl,
    /// Level of DTR; `None` leaves it as the system opens the port.
    pub dtr: Option<bool>,
    /// Level of RTS; `None` leaves it as the system opens the port.
    pub rts: Option<bool>,
    /// Time to wait after opening before anything is sent or believed: cables that are powered by the port, devices that reset.
    pub settle: Duration,
}

impl PortSettings {
    /// What a description asks for.
    #[must_use]
    pub fn of(line: &LineSettings, modem: &ModemLines) -> Self {
        Self {
            baud: line.baud,
            data_bits: match line.data_bits {
                5 => DataBits::Five,
                6 => DataBits::Six,
                7 => DataBits::Seven,
                _ => DataBits::Eight,
            },
            parity: match line.parity {
                crate::Parity::None => Parity::None,
                crate::Parity::Even => Parity::Even,
                crate::Parity::Odd => Parity::Odd,
            },
            stop_bits: if line.stop_bits == 2 {
                StopBits::Two
            } else {
                StopBits::One
            },
            flow: match line.flow {
                Flow::None => FlowControl::None,
                Flow::XonXoff => FlowControl::Software,
                Flow::RtsCts => FlowControl::Hardware,
            },
            dtr: modem.dtr,
            rts: modem.rts,
            settle: Duration::try_from_secs_f64(modem.settle_s).unwrap_or_default(),
        }
    }

    /// The same at another speed.
    #[must_use]
    pub fn with_baud(mut self, baud: u32) -> Self {
        self.baud = baud;
        self
    }

    /// Settings passed to the serial library, which opens ports exclusively; modem lines are set after opening, both at once.
    #[must_use]
    pub fn builder(&self, path: &str) -> SerialPortBuilder {
        serialport::new(path, self.baud)
            .data_bits(self.data_bits)
            .parity(self.parity)
            .stop_bits(self.stop_bits)
            .flow_control(self.flow)
            .timeout(Duration::from_millis(100))
    }
}

impl fmt::Display for PortSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ", self.baud)?;
        write!(f, "{}", u8::from(self.data_bits))?;
        f.write_str(match self.parity {
            Parity::None => "N",
            Parity::Even => "E",
            Parity::Odd => "O",
        })?;
        write!(f, "{}", u8::from(self.stop_bits))?;
        f.write_str(match self.flow {
            FlowControl::None => "",
            FlowControl::Software => " xon/xoff",
            FlowControl::Hardware => " rts/cts",
        })?;
        for (name, level) in [("DTR", self.dtr), ("RTS", self.rts)] {
            if let Some(level) = level {
                write!(f, " {name} {}", if level { "on" } else { "off" })?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::shipped::shipped_instrument;

    use super::*;

    fn settings(instrument: &str) -> PortSettings {
        let description = shipped_instrument(instrument).unwrap();
        PortSettings::of(&description.line, &description.modem)
    }

    #[test]
    fn everything_that_a_description_states_is_set() {
        // Sylvac's duplex cable is powered by the port: DTR on, RTS off.
        let sylvac = settings("sylvac-opto-rs");
        assert_eq!((sylvac.dtr, sylvac.rts), (Some(true), Some(false)));
        let expected = serialport::new("/dev/ttyUSB0", 4800)
            .data_bits(DataBits::Seven)
            .parity(Parity::Even)
            .stop_bits(StopBits::Two)
            .flow_control(FlowControl::None)
            .exclusive(true)
            .timeout(Duration::from_millis(100));
        assert_eq!(sylvac.builder("/dev/ttyUSB0"), expected);
        assert_eq!(sylvac.to_string(), "4800 7E2 DTR on RTS off");
    }

    #[test]
    fn another_speed_changes_nothing_else() {
        let mark10 = settings("mark10-series5");
        let slower = mark10.clone().with_baud(9600);
        assert_eq!((mark10.baud, slower.baud), (115_200, 9600));
        assert_eq!(slower.with_baud(115_200), mark10);
    }
}
