//! Words of a description, as they are written.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far a description can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Status")]
pub enum DescriptionStatus {
    /// The maker's manual or protocol sheet was read.
    Documented,
    /// Seen working in public code; the manual was not read.
    Implemented,
    /// From memory; nothing was found. Not to be used without a check at the bench.
    Recalled,
}

impl fmt::Display for DescriptionStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// How a push on the gauge arrives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SignMeaning {
    /// As a positive value.
    Positive,
    /// As a negative value.
    Negative,
    /// No source states it: the operator pushes by hand and the sign is observed.
    Ask,
}

impl SignMeaning {
    /// What a push arrives as: 1 for a value above zero, -1 below; `None` where no source states it.
    #[must_use]
    pub fn sign(self) -> Option<f64> {
        match self {
            Self::Positive => Some(1.0),
            Self::Negative => Some(-1.0),
            Self::Ask => None,
        }
    }
}

/// Where the unit of a value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum UnitSource {
    /// Every packet carries it.
    Packet,
    /// The gauge is asked; until it has answered, the configured unit holds.
    Query,
    /// Not in the packet: it is configured.
    Configuration,
    /// The gauge has only one.
    Fixed,
}

/// The meaning of an error packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Trouble {
    /// The command is not known or cannot be done.
    Refused,
    /// There is no such value.
    NoData,
    /// Load or travel beyond the range.
    Overload,
    /// The sensor does not follow or is broken.
    SensorFault,
    /// The value is held, or the gauge is busy.
    Hold,
    /// The battery is low.
    LowBattery,
    /// Something that is sent but is no value.
    NotAValue,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Refused => "refused",
            Self::NoData => "no data",
            Self::Overload => "overload",
            Self::SensorFault => "sensor fault",
            Self::Hold => "hold",
            Self::LowBattery => "low battery",
            Self::NotAValue => "no value",
        })
    }
}

/// The content of a packet that answers a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReplyMeaning {
    /// Done.
    Acknowledged,
    /// Who the gauge is.
    Identity,
    /// Its unit.
    Unit,
    /// The units of its values in order, as codes of one length in the first field that is no fixed text.
    Units,
    /// Its mode or settings.
    State,
    /// Something else.
    Text,
}

/// How a check sum is worked out from the bytes that it covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CheckSumKind {
    /// Exclusive or of all bytes.
    Xor,
    /// Their sum, lowest 8 bits.
    Sum,
    /// The ones' complement of that sum.
    SumOnesComplement,
    /// Its two's complement: with it the sum is 0.
    SumTwosComplement,
    /// CRC-16/MODBUS.
    #[serde(rename = "crc-16-modbus")]
    Crc16Modbus,
    /// CRC-16/XMODEM: polynomial 0x1021, start 0.
    #[serde(rename = "crc-16-xmodem")]
    Crc16Xmodem,
    /// CRC-16/IBM-3740, known as CCITT-FALSE: polynomial 0x1021, start 0xFFFF.
    #[serde(rename = "crc-16-ccitt-false")]
    Crc16CcittFalse,
}

/// How a number is written in Modbus registers of 16 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RegisterFormat {
    /// IEEE 754 single precision in two registers.
    F32,
    /// 32 bits with sign in two registers.
    I32,
    /// 32 bits without sign in two registers.
    U32,
    /// 16 bits with sign.
    I16,
    /// 16 bits without sign.
    U16,
}

impl RegisterFormat {
    /// Registers that the number takes.
    #[must_use]
    pub fn registers(self) -> usize {
        match self {
            Self::F32 | Self::I32 | Self::U32 => 2,
            Self::I16 | Self::U16 => 1,
        }
    }
}

/// What a gauge measures, in a word. Where it stands on the bench is not part of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Channel")]
pub(super) enum Measured {
    /// The force gauge (tension-compression dynamometer).
    Force,
    /// The dial or length gauge.
    Displacement,
}

impl From<Measured> for crate::Channel {
    fn from(measured: Measured) -> Self {
        match measured {
            Measured::Force => Self::Force,
            Measured::Displacement => Self::Displacement,
        }
    }
}
