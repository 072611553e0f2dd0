//! Fields and registers of a packet as they stand in a file.

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::Mark;

use super::file::NamedTexts;
use super::keywords::{CheckSumKind, Measured, RegisterFormat};

/// One field of a packet: a table with one of these keys.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum FieldEntry {
    /// This very text.
    Literal(String),
    /// These very bytes.
    Bytes(Vec<u8>),
    /// Blanks: how many, or [least, most].
    Blanks(Vec<usize>),
    /// Characters that mean nothing here.
    Any(AnyField),
    /// The sign of the number behind it; where no number follows, of the one before.
    Sign(SignField),
    /// A digit that gives how many decimals the number behind it has; where no number follows, the one before.
    Point(PointField),
    /// The number, in decimal digits.
    Number(NumberField),
    /// The number, as an integer in hexadecimal digits.
    Hex(HexField),
    /// The number, as an integer in bytes.
    Integer(IntegerField),
    /// The unit.
    Unit(UnitField),
    /// The place of the unit in the list that the gauge gives when it is asked (a reply that means `units`), from 0.
    UnitPlace(UnitPlaceField),
    /// One of several texts: mode, judgement, tolerance, status.
    Choice(ChoiceField),
    /// A check sum of the bytes before it: a packet with another one is rejected.
    CheckSum(CheckSumField),
}

/// Characters that mean nothing here.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct AnyField {
    /// How many, or [least, most].
    pub(super) count: Vec<usize>,
    /// The characters that may stand there; every printable one if absent.
    pub(super) of: Option<String>,
}

/// The sign of the number behind it, or before it where none follows.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct SignField {
    /// Texts for plus; "" where a plus is not sent.
    pub(super) plus: Vec<String>,
    /// Texts for minus.
    pub(super) minus: Vec<String>,
}

/// A digit that gives how many decimals the number behind it has, or the one before it where none follows.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct PointField {
    /// Largest digit that may stand there.
    pub(super) most: u8,
}

/// A decimal number.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct NumberField {
    /// Characters, point and blanks counted: how many, or [least, most].
    pub(super) count: Vec<usize>,
    /// Where the point is; optional if absent.
    #[serde(default)]
    pub(super) point: PointPlace,
    /// Decimals of a number without a point; 0 if absent.
    #[serde(default)]
    pub(super) decimals: u8,
    /// Where blanks may stand; nowhere if absent.
    #[serde(default)]
    pub(super) blanks: BlankPlace,
    /// A comma may stand for the point.
    #[serde(default)]
    pub(super) comma: bool,
    /// The last digit is sent first.
    #[serde(default)]
    pub(super) reversed: bool,
    /// What the number measures where that is not what the gauge does, in a packet of two numbers; a session passes it over.
    pub(super) measures: Option<Measured>,
    /// Its unit then.
    pub(super) unit: Option<String>,
}

/// An integer in hexadecimal digits.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct HexField {
    /// Digits.
    pub(super) count: usize,
    /// Characters of the digits from 0 to 15, letters in either case; 0 to F if absent.
    #[serde(default = "hexadecimal")]
    pub(super) digits: String,
    /// Whether it is two's complement over all digits; without it the sign, if any, is a field of its own.
    #[serde(default)]
    pub(super) signed: bool,
    /// Decimals; 0 if absent.
    #[serde(default)]
    pub(super) decimals: u8,
    /// Factor by which the number is multiplied besides; 1 if absent.
    pub(super) scale: Option<f64>,
}

/// The digits of a hexadecimal number.
pub(super) const HEXADECIMAL_DIGITS: &str = "0123456789ABCDEF";

fn hexadecimal() -> String {
    HEXADECIMAL_DIGITS.to_owned()
}

/// An integer in bytes.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct IntegerField {
    /// Bytes.
    pub(super) bytes: usize,
    /// Which byte comes first; the high one if absent.
    #[serde(default)]
    pub(super) order: ByteOrder,
    /// Whether it is two's complement over all bytes; without it the sign, if any, is a field of its own.
    #[serde(default)]
    pub(super) signed: bool,
    /// Decimals; 0 if absent.
    #[serde(default)]
    pub(super) decimals: u8,
    /// Factor by which the number is multiplied besides; 1 if absent.
    pub(super) scale: Option<f64>,
}

/// Which byte of an integer comes first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ByteOrder {
    /// The high one.
    #[default]
    HighFirst,
    /// The low one.
    LowFirst,
}

/// A check sum of the bytes before it.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct CheckSumField {
    /// How it is worked out.
    pub(super) kind: CheckSumKind,
    /// First byte of the packet that it covers, from 0; start marks are counted.
    #[serde(default)]
    pub(super) from: usize,
    /// Which byte comes first where it is sent in bytes; in hexadecimal digits if absent.
    pub(super) bytes: Option<ByteOrder>,
    /// Characters of the hexadecimal digits from 0 to 15, letters in either case; 0 to F if absent.
    pub(super) digits: Option<String>,
}

/// Where the point of a number is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PointPlace {
    /// One stands among the digits.
    InPlace,
    /// None or one stands among the digits.
    #[default]
    Optional,
    /// None is sent: `decimals`, or a point field beside the number, states where it is.
    None,
}

/// Where blanks may stand in a number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum BlankPlace {
    /// Nowhere.
    #[default]
    None,
    /// Before the first digit.
    Leading,
}

/// The unit of the number before it.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
pub(super) struct UnitField {
    /// Texts that state that the value is none, and why.
    #[serde(default)]
    pub(super) refuse: NamedTexts,
    /// Characters of a unit that is not among the codes: how many, or [least, most]; such packets are recognised and refused.
    #[serde(default)]
    pub(super) others: Vec<usize>,
}

/// The place of the unit in a list.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
pub(super) struct UnitPlaceField {
    /// Largest digit that may stand there.
    pub(super) most: u8,
}

/// One of several texts.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
pub(super) struct ChoiceField {
    /// Texts with which the value can be used; "" where nothing need stand there.
    #[serde(default)]
    pub(super) good: Vec<String>,
    /// Texts with which it must not be used, and why.
    #[serde(default)]
    pub(super) refuse: NamedTexts,
    /// Texts with which it can be used and is marked.
    #[serde(default)]
    pub(super) note: IndexMap<String, Mark>,
}

/// Where the value stands in the registers of a Modbus reply.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct RegistersEntry {
    /// Register of the value, or of its first half, from 0.
    pub(super) first: u8,
    /// How it is written.
    pub(super) format: RegisterFormat,
    /// Which half of two registers comes first; the high one if absent.
    #[serde(default)]
    pub(super) low_word_first: bool,
    /// Decimals of a whole number; 0 if absent.
    #[serde(default)]
    pub(super) decimals: u8,
    /// Factor by which the number is multiplied besides; 1 if absent.
    pub(super) scale: Option<f64>,
    /// Where the sign stands, if not in the value.
    pub(super) sign: Option<RegisterSign>,
    /// What must hold besides.
    #[serde(default)]
    pub(super) require: Vec<RegisterCheck>,
}

/// The sign of a value that has it in another register.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct RegisterSign {
    /// Register, from 0.
    pub(super) register: u8,
    /// Bits that count.
    pub(super) mask: u16,
    /// What they are for plus.
    pub(super) plus: u16,
    /// What they are for minus.
    pub(super) minus: u16,
}

/// Bits that must be as they should.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
pub(super) struct RegisterCheck {
    /// Register, from 0.
    pub(super) register: u8,
    /// Bits that count.
    pub(super) mask: u16,
    /// What they must be.
    pub(super) equals: u16,
    /// Why the value must not be used if they are not.
    pub(super) otherwise: String,
}
