//! Shapes of the robot file that a derived reader takes too lightly or describes too vaguely.
//!
//! Derived readers take the first N entries of a longer array and drop the rest, and of two possible shapes of a table can only say
//! that neither fits.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::exact_array::{Exactly, exactly};
use super::expression::Expression;
use super::file::{NodeEntry, Radius};

/// All keys that a node of either shape may have.
#[derive(serde::Deserialize)]
#[serde(
    expecting = "{ on = body, at = [x, y, z] } or { loop = [[node, radius], [node, radius]], plane = name, branch = 1 or -1 }"
)]
struct AnyNode {
    on: Option<String>,
    at: Option<Exactly<Expression, 3>>,
    #[serde(rename = "loop")]
    circles: Option<Exactly<Circle, 2>>,
    plane: Option<String>,
    branch: Option<i64>,
}

impl<'de> Deserialize<'de> for NodeEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let wrong = |what| {
            Err(D::Error::custom(format_args!(
                "{what}: expected {{ on = body, at = [x, y, z] }} or {{ loop = [[node, radius], [node, radius]], plane = name, \
                 branch = 1 or -1 }}"
            )))
        };
        let node = AnyNode::deserialize(deserializer)?;
        let is_fixed = node.on.is_some() || node.at.is_some();
        let is_loop = node.circles.is_some() || node.plane.is_some() || node.branch.is_some();
        match node {
            _ if is_fixed && is_loop => wrong("this node mixes the keys of two kinds"),
            AnyNode {
                on: Some(on),
                at: Some(Exactly(at)),
                ..
            } => Ok(Self::Fixed { on, at }),
            AnyNode {
                circles: Some(Exactly(circles)),
                plane: Some(plane),
                branch: Some(branch),
                ..
            } => Ok(Self::Loop {
                circles: circles.map(|Circle(centre, radius)| (centre, radius)),
                plane,
                branch,
            }),
            _ => wrong("this node lacks a key"),
        }
    }
}

/// Centre and radius of a circle.
struct Circle(String, Radius);

impl<'de> Deserialize<'de> for Circle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CircleVisitor;

        impl<'de> Visitor<'de> for CircleVisitor {
            type Value = Circle;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("[node, radius]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Circle, A::Error> {
                let short = |count| A::Error::invalid_length(count, &self);
                let centre = entries.next_element()?.ok_or_else(|| short(0))?;
                let radius = entries.next_element()?.ok_or_else(|| short(1))?;
                match entries.next_element::<IgnoredAny>()? {
                    None => Ok(Circle(centre, radius)),
                    Some(_) => Err(short(3)),
                }
            }
        }

        deserializer.deserialize_seq(CircleVisitor)
    }
}

impl<'de> Deserialize<'de> for Radius {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct RadiusVisitor;

        #[derive(serde::Deserialize)]
        struct Distance {
            #[serde(deserialize_with = "exactly")]
            dist: [String; 2],
        }

        impl<'de> Visitor<'de> for RadiusVisitor {
            type Value = Radius;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a length or { dist = [node, node] }")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Radius, E> {
                Ok(Radius::Length(Expression::Number(value)))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Radius, E> {
                self.visit_f64(value as f64)
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Radius, E> {
                self.visit_f64(value as f64)
            }

            fn visit_str<E: Error>(self, value: &str) -> Result<Radius, E> {
                Ok(Radius::Length(Expression::Text(value.to_owned())))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Radius, A::Error> {
                let Distance { dist } = Distance::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Radius::Distance { dist })
            }
        }

        deserializer.deserialize_any(RadiusVisitor)
    }
}
