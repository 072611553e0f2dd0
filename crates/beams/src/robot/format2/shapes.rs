//! Values that may be written in two shapes, read so that an error inside one of them keeps its place and its words.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::file::{AxisValue, PoseAngles, SpringRow, SpringShape, SpringWord};
use crate::robot::exact_array::exactly;

impl<'de> Deserialize<'de> for AxisValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxisVisitor;

        impl<'de> Visitor<'de> for AxisVisitor {
            type Value = AxisValue;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"x\", \"-x\" and so on, or a vector [x, y, z]")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<AxisValue, E> {
                Ok(AxisValue::Word(word.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<AxisValue, A::Error> {
                exactly(SeqAccessDeserializer::new(entries)).map(AxisValue::Vector)
            }
        }

        deserializer.deserialize_any(AxisVisitor)
    }
}

impl<'de> Deserialize<'de> for PoseAngles {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PoseVisitor;

        impl<'de> Visitor<'de> for PoseVisitor {
            type Value = PoseAngles;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("{ VARIABLE = value } or all values in the order of the variables")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<PoseAngles, A::Error> {
                Deserialize::deserialize(MapAccessDeserializer::new(map)).map(PoseAngles::Named)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, entries: A) -> Result<PoseAngles, A::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(entries))
                    .map(PoseAngles::Listed)
            }
        }

        deserializer.deserialize_any(PoseVisitor)
    }
}

impl<'de> Deserialize<'de> for SpringShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SpringVisitor;

        impl<'de> Visitor<'de> for SpringVisitor {
            type Value = SpringShape;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"free\", \"rigid\", \"pinned\" or { stiffness = value }")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<SpringShape, E> {
                SpringWord::deserialize(StrDeserializer::new(word)).map(SpringShape::Word)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<SpringShape, A::Error> {
                SpringRow::deserialize(MapAccessDeserializer::new(map)).map(SpringShape::Table)
            }
        }

        deserializer.deserialize_any(SpringVisitor)
    }
}
