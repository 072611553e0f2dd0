//! One law at one place as planned readings see it, and how far it is from another.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mismatch::candidates::{WhiteCandidate, WhiteShape};
use crate::search::constants::{CAN_TELL, CANNOT_TELL, POWER_80};
use crate::search::{RowVector, dot, norm};

use super::bench::LawAtPlace;

/// A law that is hard to tell from another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "NearLaw")]
pub struct NearRival {
    /// The law and its place.
    #[serde(flatten)]
    pub rival: LawAtPlace,
    /// Cosine of the two effects, the factors projected out, with the course of the rival that is hardest to tell from the law.
    pub cosine: f64,
    /// Size from which the expected log-likelihood ratio is 3, SI; `null` if no plausible size reaches it, or the law has no size.
    pub size_3: Option<f64>,
    /// The same for 5.
    pub size_5: Option<f64>,
    /// Largest change of a reading at `size_5`, m.
    #[serde(skip)]
    pub end_effect_5_m: Option<f64>,
    /// Whether no plausible size separates them.
    pub never: bool,
}

/// A candidate with the shape in which it is found most easily.
pub(super) struct EasiestShape<'a> {
    pub(super) candidate: &'a WhiteCandidate,
    pub(super) shape: &'a WhiteShape,
    /// Multiple of the shape that 80 % of sessions find.
    pub(super) scale_80: f64,
    /// The largest plausible multiple.
    pub(super) largest: f64,
}

/// The largest plausible multiple of a shape.
fn largest(candidate: &WhiteCandidate, shape: &WhiteShape) -> f64 {
    let size = shape.shape.values.first();
    let plausible = size.map_or(1.0, |size| candidate.candidate.largest(&shape.shape) / size);
    shape.shape.scale[1].min(plausible)
}

impl<'a> EasiestShape<'a> {
    /// The view of a candidate; `None` if the readings show nothing of it.
    ///
    /// # Arguments
    /// - `root`: length of an effect in standard errors from which it is believed.
    pub(super) fn new(candidate: &'a WhiteCandidate, root: f64) -> Option<Self> {
        let view = |shape: &'a WhiteShape| Self {
            candidate,
            shape,
            scale_80: (root + POWER_80) / shape.square.sqrt(),
            largest: largest(candidate, shape),
        };
        let end_m = |view: &Self| {
            if view.is_shown() && view.scale_80 >= view.shape.shape.scale[0] {
                view.scale_80 * view.shape.peak_m
            } else {
                f64::INFINITY
            }
        };
        candidate
            .shapes
            .iter()
            .map(view)
            .min_by(|a, b| end_m(a).total_cmp(&end_m(b)))
    }

    /// Whether a plausible size is found in 80 % of sessions.
    pub(super) fn is_shown(&self) -> bool {
        self.scale_80 <= self.largest
    }

    /// Size at a multiple of the shape; `None` beyond what is plausible, or without a size.
    pub(super) fn size(&self, scale: f64) -> Option<f64> {
        self.size_up_to(self.largest, scale)
    }

    fn size_up_to(&self, most: f64, scale: f64) -> Option<f64> {
        let value = self.shape.shape.values.first()?;
        (scale <= most).then(|| value * self.shape.shape.size_factor(scale))
    }

    /// Size that would be found in 80 % of sessions, plausible or not; `None` if the shape does not grow so far.
    pub(super) fn size_needed(&self) -> Option<f64> {
        self.size_up_to(self.shape.shape.scale[1], self.scale_80)
    }

    /// Multiple of the shape from which a rival's shape is told from it with an expected log-likelihood ratio, and the cosine of the two.
    ///
    /// The rival takes the size t within its range that comes nearest: J = ½ ‖s v - t w‖².
    fn scale_against(&self, rival: &RivalShape, wanted: f64) -> f64 {
        let (vv, ww) = (self.shape.square, rival.square);
        let vw = rival.cosine * (vv * ww).sqrt();
        let free = (2.0 * wanted / (vv - vw * vw / ww).max(f64::MIN_POSITIVE)).sqrt();
        if vw <= 0.0 {
            return (2.0 * wanted / vv).sqrt();
        }
        if free * vw / ww <= rival.largest {
            return free;
        }
        // The rival is at the end of its range: s² v² - 2 s t v·w + t² w² = 2 J.
        let t = rival.largest;
        let root = (t * t * vw * vw - vv * (t * t * ww - 2.0 * wanted)).max(0.0);
        (t * vw + root.sqrt()) / vv
    }

    /// Expected log-likelihood ratio of the shape as it stands against a rival's shape.
    fn log_lr_against(&self, rival: &RivalShape) -> f64 {
        let (vv, ww) = (self.shape.square, rival.square);
        let vw = rival.cosine.max(0.0) * (vv * ww).sqrt();
        let t = (vw / ww).clamp(rival.smallest, rival.largest);
        0.5 * (vv - 2.0 * t * vw + t * t * ww)
    }

    /// Shapes of another candidate, as seen from this one.
    fn shapes_of(&self, other: &WhiteCandidate) -> impl Iterator<Item = RivalShape> {
        let own = &self.shape.vectors[0].values;
        let length = dot(own, own).sqrt();
        let shapes = other.shapes.iter().map(move |shape| {
            let along = |vector: &RowVector| vector.dot(own) / (length * norm(&vector.values));
            let cosine = along(&shape.vectors[0]);
            let either = shape.shape.scale[0] < 0.0;
            RivalShape {
                cosine: match &shape.vectors[..] {
                    [_, second] => cosine.hypot(along(second)),
                    _ if either => cosine.abs(),
                    _ => cosine,
                },
                square: shape.square,
                smallest: shape.shape.scale[0].max(0.0),
                largest: largest(other, shape),
            }
        });
        // A shape whose smallest size is not plausible is none.
        shapes.filter(|shape| shape.smallest <= shape.largest)
    }
}

/// A rival's shape as seen from a view.
struct RivalShape {
    /// With the sign that the rival's size can have.
    cosine: f64,
    square: f64,
    smallest: f64,
    largest: f64,
}

/// Rivals of a view, the hardest to tell from it first; laws that contain it at the same place are no rivals.
pub(super) fn nearest(view: &EasiestShape<'_>, views: &[EasiestShape<'_>]) -> Vec<NearRival> {
    let own = &view.candidate.candidate;
    let mut out: Vec<(NearRival, f64)> = views
        .iter()
        .map(|other| other.candidate)
        .filter(|other| {
            let other = &other.candidate;
            let nested =
                other.law == own.law || other.law.contains(own.law) || own.law.contains(other.law);
            !(other.place == own.place && nested)
        })
        .filter_map(|other| rival(view, other))
        .collect();
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out.into_iter().map(|(rival, _)| rival).collect()
}

/// How a rival is told from a view, and the multiple of the view's shape it takes.
fn rival(view: &EasiestShape<'_>, other: &WhiteCandidate) -> Option<(NearRival, f64)> {
    let fixed = view.candidate.candidate.law.parameters.is_empty();
    let hardness = |shape: &RivalShape| {
        if fixed {
            // The less is left, the harder.
            CAN_TELL / view.log_lr_against(shape).max(f64::MIN_POSITIVE)
        } else {
            view.scale_against(shape, CAN_TELL)
        }
    };
    let (shape, hard) = view
        .shapes_of(other)
        .map(|shape| {
            let hard = hardness(&shape);
            (shape, hard)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let size_5 = view.size(hard);
    let scale_3 = view.scale_against(&shape, CANNOT_TELL);
    let rival = NearRival {
        rival: suspect(other),
        cosine: shape.cosine,
        size_3: view.size(scale_3),
        size_5,
        end_effect_5_m: size_5.map(|_| hard * view.shape.peak_m),
        never: if fixed {
            view.log_lr_against(&shape) < CANNOT_TELL
        } else {
            scale_3 > view.largest
        },
    };
    Some((rival, hard))
}

/// Sets of which each member is taken for each other whatever its size.
pub(super) fn groups(
    views: &[EasiestShape<'_>],
    rivals: &[Vec<NearRival>],
) -> Vec<Vec<LawAtPlace>> {
    let suspects: Vec<LawAtPlace> = views.iter().map(|view| suspect(view.candidate)).collect();
    let never = |place: usize, other: usize| {
        let taken_for = |rival: &&NearRival| rival.never && rival.rival == suspects[other];
        rivals[place].iter().any(|rival| taken_for(&rival))
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for place in 0..suspects.len() {
        let fits = |group: &&mut Vec<usize>| {
            group
                .iter()
                .all(|&member| never(place, member) && never(member, place))
        };
        match groups.iter_mut().find(fits) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
        .into_iter()
        .filter(|group| group.len() > 1)
        .map(|group| group.into_iter().map(|p| suspects[p].clone()).collect())
        .collect()
}

/// A candidate by law and place.
pub(super) fn suspect(candidate: &WhiteCandidate) -> LawAtPlace {
    LawAtPlace {
        law: candidate.candidate.law,
        place: candidate.candidate.place.clone(),
    }
}
