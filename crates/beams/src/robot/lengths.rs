//! Lengths that a robot file states, each with the points that it moves.

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlDocument, TomlNumber};

use super::Robot;
use super::format2::is_of_this_format;
use super::format2::measure::{MeasuredKind, unit_in_si};
use super::model::{BodyPlace, NodePlace, RadiusOf};

/// Tables of a robot file whose numbers may be lengths.
const TABLES: [&str; 5] = ["parameters", "nodes", "joints", "points", "tool"];

/// By how much a length is changed to see what it moves, m: points are sums of lengths, so that rounding alone counts.
const STEP_M: f64 = 1e-3;

/// A number of the file is a length where a point follows it by more than this share of its change, 1.
const MOVES: f64 = 1e-6;

/// A length in the text of a robot file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileLength {
    /// The entry: the name of a parameter, or the keys that lead to a coordinate, with points between.
    pub entry: String,
    /// The body whose size it states.
    pub body: String,
    /// Byte of the file at which its value begins.
    pub begins: usize,
    /// Its value, m.
    pub value_m: f64,
    /// Points fixed on a body, and by how much they move in its axes for each metre.
    points: Vec<(usize, [f64; 3])>,
    /// Points of loops, the place of the radius, and its growth for each metre.
    radii: Vec<(usize, usize, f64)>,
}

impl Robot {
    /// The lengths of the file, in its order; those that move nothing are left out.
    #[must_use]
    pub fn lengths(&self) -> Vec<FileLength> {
        let Ok(document) = TomlDocument::parse(&self.source) else {
            return Vec::new();
        };
        let has_units = is_of_this_format(&self.source);
        let numbers = TABLES.iter().flat_map(|table| document.numbers(table));
        let in_m = |number: &TomlNumber| {
            if has_units {
                unit_m(&number.keys)
            } else {
                Some(1.0)
            }
        };
        let lengths = numbers.filter_map(|number| self.length(&number, in_m(&number)?));
        lengths.collect()
    }

    /// A number of the file as a length; `None` if it is none.
    fn length(&self, number: &TomlNumber, unit_m: f64) -> Option<FileLength> {
        if number.value == 0.0 {
            return None;
        }
        let changed = format!("{:?}", number.value + STEP_M / unit_m);
        let mut text = self.source.text.clone();
        text.replace_range(number.span.clone(), &changed);
        let moved = Self::parse(&SourceText::new(&self.source.name, text)).ok()?;
        if moved.nodes.len() != self.nodes.len() {
            return None;
        }
        let (mut points, mut radii) = (Vec::new(), Vec::new());
        for (node, (before, after)) in self.nodes.iter().zip(&moved.nodes).enumerate() {
            match (&before.place, &after.place) {
                (NodePlace::Fixed { at_m: before, .. }, NodePlace::Fixed { at_m: after, .. }) => {
                    let by: [f64; 3] = std::array::from_fn(|i| (after[i] - before[i]) / STEP_M);
                    if by.iter().any(|by| by.abs() > MOVES) {
                        points.push((node, by));
                    }
                }
                (NodePlace::Loop { radii: before, .. }, NodePlace::Loop { radii: after, .. }) => {
                    for (place, pair) in before.iter().zip(after).enumerate() {
                        if let (RadiusOf::Length(before), RadiusOf::Length(after)) = pair
                            && (after - before).abs() > MOVES * STEP_M
                        {
                            radii.push((node, place, (after - before) / STEP_M));
                        }
                    }
                }
                _ => return None,
            }
        }
        let body = self.body_of(&points, &radii)?;
        Some(FileLength {
            entry: match &number.keys[..] {
                [table, name] if table == "parameters" => name.clone(),
                keys => keys.join("."),
            },
            body: self.bodies[body].name.clone(),
            begins: number.span.start,
            value_m: number.value * unit_m,
            points,
            radii,
        })
    }

    /// The body whose size a length states: the one that it ends, at the next joint or at the tool; else the crank that has it for its
    /// radius; else any on which a point moves.
    fn body_of(
        &self,
        points: &[(usize, [f64; 3])],
        radii: &[(usize, usize, f64)],
    ) -> Option<usize> {
        let body_of = |node: usize| match self.nodes[node].place {
            NodePlace::Fixed { body, .. } => Some(body),
            NodePlace::Loop { .. } => None,
        };
        let ends = |node: usize| {
            let origin = |body: &super::Body| match body.place {
                BodyPlace::Turned { origin, .. } | BodyPlace::Slid { origin, .. } => origin,
                _ => self.end,
            };
            node == self.end || self.bodies.iter().any(|body| origin(body) == node)
        };
        let moved = || points.iter().map(|(node, _)| *node);
        let is_alone = |node: usize| {
            let here = self.nodes.iter().enumerate();
            let mut others =
                here.filter(|(other, _)| *other != node && body_of(*other) == body_of(node));
            others.next().is_none()
        };
        let crank = |&(node, place, _): &(usize, usize, f64)| {
            let NodePlace::Loop { centres, .. } = &self.nodes[node].place else {
                return None;
            };
            let along = |body: &super::Body| match &body.place {
                BodyPlace::Along { nodes, .. } => {
                    nodes.contains(&node) && nodes.contains(&centres[place])
                }
                _ => false,
            };
            self.bodies.iter().position(along)
        };
        moved()
            .find(|node| ends(*node))
            .or_else(|| moved().find(|node| is_alone(*node)))
            .and_then(body_of)
            .or_else(|| radii.iter().find_map(crank))
            .or_else(|| moved().find_map(body_of))
    }
}

impl FileLength {
    /// The robot with this length changed.
    ///
    /// # Arguments
    /// - `by_m`: added to the value in the file.
    #[must_use]
    pub fn changed(&self, robot: &Robot, by_m: f64) -> Robot {
        let mut robot = robot.clone();
        for (node, by) in &self.points {
            if let NodePlace::Fixed { at_m, .. } = &mut robot.nodes[*node].place {
                for (at_m, by) in at_m.iter_mut().zip(by) {
                    *at_m += by * by_m;
                }
            }
        }
        for (node, place, by) in &self.radii {
            if let NodePlace::Loop { radii, .. } = &mut robot.nodes[*node].place
                && let RadiusOf::Length(radius) = &mut radii[*place]
            {
                *radius += by * by_m;
            }
        }
        robot
    }
}

/// Keys of a length that states no unit.
const LENGTH_KEYS: [&str; 4] = ["at", "a", "d", "radii"];

/// The unit of a number by its keys, m; `None` if it is no length.
fn unit_m(keys: &[String]) -> Option<f64> {
    let key = keys
        .iter()
        .rev()
        .find(|key| key.parse::<usize>().is_err())?;
    match key.rsplit_once('_').and_then(|(_, unit)| unit_in_si(unit)) {
        Some((MeasuredKind::Length, unit_m)) => Some(unit_m),
        Some(_) => None,
        None => (keys[0] == "parameters" || LENGTH_KEYS.contains(&key.as_str())).then_some(1.0),
    }
}
