//! Every law at every place it can have, with the shapes under which it is searched for.

use stiffbench_beams::physics::{Law, Place, PlaceKind, PlaceScale, Shape};

use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{KINDS, LinearisedModel, PlaceScales, plausible_bounds};

/// A law at a place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) law: Law,
    pub(crate) place: Place,
    pub(crate) shapes: Vec<Shape>,
    /// What the loads make of the place.
    pub(crate) scale: PlaceScale,
    /// Whether it belongs to the wide search of a law that has a narrow one.
    pub(crate) wide: bool,
}

impl Candidate {
    /// The family whose critical value it must exceed: its law, and whether the search is the wide one.
    pub(crate) fn family(&self) -> (Law, bool) {
        (self.law, self.wide)
    }

    /// Largest size that is plausible, starting from a shape; infinite of a law without a size.
    pub(crate) fn largest(&self, shape: &Shape) -> f64 {
        let size = self.law.parameters.first();
        size.map_or(f64::INFINITY, |size| {
            (size.plausible.bounds)(&self.scale, &shape.values)[1]
        })
    }

    /// Bounds of the parameters for a fit that starts at a shape, as a fit moves them.
    pub(crate) fn bounds_near(&self, shape: &Shape) -> Vec<[f64; 2]> {
        let mut bounds = plausible_bounds(self.law, &self.scale, &shape.values);
        if let Some((held, tolerance)) = shape.held {
            let value = shape.values[held];
            let [low, high] = [1.0 - tolerance, 1.0 + tolerance].map(|factor| factor * value);
            bounds[held] = [bounds[held][0].max(low), bounds[held][1].min(high)];
        }
        bounds
    }
}

/// Whether laws at a kind of place act only where there is a force.
fn needs_force(kind: PlaceKind) -> bool {
    !matches!(
        kind,
        PlaceKind::Clock | PlaceKind::Run | PlaceKind::DisplacementGauge
    )
}

/// All candidates but missing elements, which are structures of their own.
///
/// # Arguments
/// - `poses`: the baseline, solved.
/// - `without`: laws that are left out.
pub(crate) fn candidates(
    observations: &Observations,
    poses: &LinearisedModel,
    without: &[Law],
) -> Vec<Candidate> {
    let scales = PlaceScales::of_session(observations);
    let is_tracked = observations.tracker.is_some();
    let is_loaded = scales.session.force_n > 0.0 || is_tracked;
    let mut out = Vec::new();
    for kind in KINDS
        .into_iter()
        .filter(|kind| is_loaded || !needs_force(*kind))
    {
        let here = |law: &Law| {
            law.place_kind == kind
                && !without.contains(law)
                && !(is_tracked && law.is_hidden_from_trackers())
        };
        let is_seen =
            |law: &Law| !observations.is_one_sweep() || !law.search.needs.more_than_a_sweep();
        let laws = Law::searched_on(observations.object).filter(here);
        let laws: Vec<Law> = laws.filter(is_seen).collect();
        for (place, scale) in scales.of_kind(kind, observations, poses) {
            for &law in &laws {
                // An angle that is wrong in one pose alone is one of many: a wide search of a wrong angle.
                let in_one_pose = matches!(place, Place::JointAngle { pose: Some(_), .. });
                let mut add = |shapes: Vec<Shape>, wide| {
                    if !shapes.is_empty() {
                        out.push(Candidate {
                            law,
                            place: place.clone(),
                            shapes,
                            scale,
                            wide,
                        });
                    }
                };
                add((law.search.shapes)(&scale), in_one_pose);
                if let Some(shapes) = law.search.wide_shapes {
                    add(shapes(&scale), true);
                }
            }
        }
    }
    out
}
