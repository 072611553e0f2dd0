//! Packets written by the patterns that read them: for gauges that are emulated from their description, and to try a description out.

#[cfg(feature = "emulator")]
use super::check_sum::modbus_crc;
#[cfg(feature = "emulator")]
use super::description::RegisterFormat;
use super::grammar::{
    CharacterSet, ChoiceWord, Count, FieldPattern, PacketField, UnitWord, number_of,
};
use super::number::{MOST_DIGITS, NumberShape};
#[cfg(feature = "emulator")]
use super::registers::Registers;
use super::sample::Mark;

/// What a packet has to express.
#[derive(Debug, Clone, Copy)]
pub(super) struct PacketContent<'a> {
    /// The number, in the unit.
    pub(super) value: f64,
    /// Digits behind the point, where the packet leaves that open.
    pub(super) decimals: u8,
    /// The unit.
    pub(super) unit: &'a str,
    /// Its place in the list that the gauge gives.
    pub(super) unit_place: u8,
    /// Further content.
    pub(super) state: WrittenState,
    /// Bytes for the first field that leaves them open, in place of what has no meaning.
    pub(super) list: Option<&'a [u8]>,
}

/// What a packet can express beside a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(
    not(feature = "emulator"),
    expect(dead_code, reason = "only an emulated gauge is in all of them")
)]
pub(super) enum WrittenState {
    /// Nothing.
    Running,
    /// The peak is shown.
    Peak,
    /// The value is held.
    Hold,
    /// Beyond the capacity.
    Overload,
    /// The battery is low.
    LowBattery,
    /// Nothing is plugged in, or the probe is off.
    ToolOff,
}

impl WrittenState {
    /// Whether the operator's texts mention this.
    pub(super) fn is_reported_by(self, words: &str) -> bool {
        let telling: &[&str] = match self {
            Self::Running => &[],
            Self::Peak => &["peak", "maximum"],
            Self::Hold => &["hold"],
            Self::Overload => &["overload"],
            Self::LowBattery => &["battery"],
            Self::ToolOff => &["fault", "unplugged"],
        };
        let words = words.to_lowercase();
        telling.iter().any(|word| words.contains(word))
    }
}

impl FieldPattern {
    /// A packet of this pattern; `None` if it has no room for the number or no word for the unit.
    pub(super) fn write(&self, said: &PacketContent<'_>) -> Option<Vec<u8>> {
        let mut packet = Vec::new();
        let mut list = said.list;
        let has_sign = self
            .fields
            .iter()
            .any(|field| matches!(field, PacketField::Sign(_)));
        for (place, field) in self.fields.iter().enumerate() {
            let number = if field.is_number() {
                Some(place)
            } else {
                number_of(self.fields.iter(), place)
            };
            let value = self.value_at(number, said);
            match field {
                PacketField::Literal(bytes) => packet.extend_from_slice(bytes),
                PacketField::Any { set, count } => {
                    let bytes = list.take().and_then(|bytes| fitted(bytes, set, *count));
                    match bytes {
                        Some(bytes) => packet.extend_from_slice(bytes),
                        None => packet.extend(vec![set.filling()?; count.least]),
                    }
                }
                PacketField::Sign(texts) => {
                    let negative = value < 0.0;
                    let (text, _) = texts.iter().find(|(_, minus)| *minus == negative)?;
                    packet.extend_from_slice(text);
                }
                PacketField::Point { most } => packet.push(b'0' + said.decimals.min(*most)),
                PacketField::Number(shape) if has_sign || value >= 0.0 => {
                    let told = self.decimals_told(place, said.decimals);
                    let fixed = shape.most_points == 0 && told.is_none();
                    let open = told.unwrap_or(said.decimals);
                    let decimals = if fixed { shape.decimals } else { open };
                    packet.extend(shape.write(value.abs(), decimals, told.is_some())?);
                }
                PacketField::Number(_) => return None,
                PacketField::Integer(shape) => {
                    let size = if has_sign { value.abs() } else { value };
                    packet.extend(shape.write(size)?);
                }
                PacketField::Unit { codes, .. } => {
                    let means =
                        |word: &UnitWord| matches!(word, UnitWord::Unit(unit) if unit == said.unit);
                    let tells = |word: &UnitWord| matches!(word, UnitWord::Refuse(why) if said.state.is_reported_by(why));
                    let told = codes.iter().find(|(_, word)| tells(word));
                    let (code, _) = told.or_else(|| codes.iter().find(|(_, word)| means(word)))?;
                    packet.extend_from_slice(code);
                }
                PacketField::UnitPlace { most } => packet.push(b'0' + said.unit_place.min(*most)),
                PacketField::Choice(texts) => packet.extend_from_slice(chosen(texts, said.state)?),
                PacketField::CheckSum(sum) => packet.extend(sum.write(&packet)?),
            }
        }
        Some(packet)
    }

    /// The value of the number at a place: a quantity other than the gauge's own is left out.
    fn value_at(&self, number: Option<usize>, said: &PacketContent<'_>) -> f64 {
        match number.map(|place| &self.fields[place]) {
            Some(PacketField::Number(shape)) if shape.other.is_some() => 0.0,
            _ => said.value,
        }
    }

    /// The decimals that a digit of the packet states of the number at a place, of so many that are wanted.
    fn decimals_told(&self, number: usize, wanted: u8) -> Option<u8> {
        let fields = self.fields.iter().enumerate();
        let told = fields.filter_map(|(place, field)| match field {
            PacketField::Point { most } if number_of(self.fields.iter(), place) == Some(number) => {
                Some(wanted.min(*most))
            }
            _ => None,
        });
        told.min()
    }
}

/// The text of a choice: the text of the state if there is one, else the shortest that does not contradict the value.
fn chosen(texts: &[(Vec<u8>, ChoiceWord)], state: WrittenState) -> Option<&[u8]> {
    let tells = |word: &ChoiceWord| match word {
        ChoiceWord::Refuse(why) => state.is_reported_by(why),
        ChoiceWord::Note(mark) => *mark == Mark::LowBattery && state == WrittenState::LowBattery,
        ChoiceWord::Good => false,
    };
    let good = texts.iter().filter(|(_, word)| *word == ChoiceWord::Good);
    let is_note = |word: &ChoiceWord| matches!(word, ChoiceWord::Note(_));
    let find = |which: &dyn Fn(&ChoiceWord) -> bool| texts.iter().find(|(_, word)| which(word));
    let found = find(&tells)
        .or_else(|| good.min_by_key(|(text, _)| text.len()))
        .or_else(|| find(&is_note))
        .or_else(|| texts.first());
    found.map(|(text, _)| text.as_slice())
}

/// As many of the bytes as a field takes, if there are enough and they are of its set.
fn fitted<'a>(bytes: &'a [u8], set: &CharacterSet, count: Count) -> Option<&'a [u8]> {
    let bytes = &bytes[..bytes.len().min(count.most)];
    let fits = bytes.len() >= count.least && bytes.iter().all(|byte| set.contains(*byte));
    fits.then_some(bytes)
}

impl CharacterSet {
    /// A character of the set, the most neutral one.
    fn filling(&self) -> Option<u8> {
        let usual = b" 0".iter().copied();
        usual.chain(0..128).find(|byte| self.contains(*byte))
    }
}

impl NumberShape {
    /// A number in this shape, with fewer decimals if there is no room for all; `None` if it has no room.
    fn write(&self, size: f64, decimals: u8, decimals_are_told: bool) -> Option<Vec<u8>> {
        let may_shorten = self.most_points > 0 && !decimals_are_told;
        let mut decimals = usize::from(decimals);
        loop {
            let mut text = format!("{size:.decimals$}");
            if self.most_points == 0 {
                text.retain(|character| character != '.');
            } else if self.least_points > 0 && decimals == 0 {
                text.push('.');
            }
            let digits = text.bytes().filter(u8::is_ascii_digit).count();
            if text.len() <= self.most && digits <= MOST_DIGITS {
                let fill = if self.leading_blanks { " " } else { "0" };
                let missing = self.least.saturating_sub(text.len());
                let mut bytes = (fill.repeat(missing) + &text).into_bytes();
                if self.reversed {
                    bytes.reverse();
                }
                return Some(bytes);
            }
            if !may_shorten || decimals == 0 {
                return None;
            }
            decimals -= 1;
        }
    }
}

#[cfg(feature = "emulator")]
impl Registers {
    /// A reply with a value; `None` if the format has no room for it.
    pub(super) fn write(
        &self,
        value: f64,
        slave: u8,
        function: u8,
        data_bytes: usize,
    ) -> Option<Vec<u8>> {
        let mut words = vec![0_u16; data_bytes / 2];
        let size = if self.sign.is_some() {
            value.abs()
        } else {
            value
        };
        let counts = size / self.scale * 10_f64.powi(i32::from(self.decimals));
        let whole = counts.round();
        let within =
            |least: f64, most: f64| (least..=most).contains(&whole).then_some(whole as i64);
        let bits = match self.format {
            RegisterFormat::U16 => within(0.0, f64::from(u16::MAX))? as u32,
            RegisterFormat::I16 => within(f64::from(i16::MIN), f64::from(i16::MAX))? as u32,
            RegisterFormat::U32 => within(0.0, f64::from(u32::MAX))? as u32,
            RegisterFormat::I32 => within(f64::from(i32::MIN), f64::from(i32::MAX))? as u32,
            RegisterFormat::F32 => (counts as f32).to_bits(),
        };
        let (high, low) = ((bits >> 16) as u16, bits as u16);
        match (self.format.registers(), self.low_word_first) {
            (1, _) => *words.get_mut(self.first)? = low,
            (_, low_first) => {
                let pair = if low_first { [low, high] } else { [high, low] };
                words
                    .get_mut(self.first..self.first + 2)?
                    .copy_from_slice(&pair);
            }
        }
        for required in &self.require {
            *words.get_mut(required.register)? |= required.equals & required.mask;
        }
        if let Some(sign) = &self.sign {
            let bits = if value < 0.0 { sign.minus } else { sign.plus };
            *words.get_mut(sign.register)? |= bits & sign.mask;
        }
        let mut packet = vec![slave, function, u8::try_from(data_bytes).ok()?];
        packet.extend(words.iter().flat_map(|word| word.to_be_bytes()));
        packet.extend(modbus_crc(&packet).to_le_bytes());
        Some(packet)
    }
}
