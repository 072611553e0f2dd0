//! Every law at every place it can have, with the shapes under which it is searched for.

use stiffbench_beams::physics::{Law, Place, PlaceKind, PlaceScale, Shape};

use super::linearised::LinearisedModel;
use super::observations::Observations;
use super::place_scales::{KINDS, PlaceScales, plausible_bounds};

/// A law at a place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub(super) law: Law,
    pub(super) place: Place,
    pub(super) shapes: Vec<Shape>,
    /// What the loads make of the place.
    pub(super) scale: PlaceScale,
    /// Whether it belongs to the wide search of a law that has a narrow one.
    pub(super) wide: bool,
}

impl Candidate {
    /// The family whose critical value it must exceed: its law, and whether the search is the wide one.
    pub(super) fn family(&self) -> (Law, bool) {
        (self.law, self.wide)
    }

    /// Largest size that is plausible, starting from a shape; infinite of a law without a size.
    pub(super) fn largest(&self, shape: &Shape) -> f64 {
        let size = self.law.parameters.first();
        size.map_or(f64::INFINITY, |size| {
            (size.plausible.bounds)(&self.scale, &shape.values)[1]
        })
    }

    /// Bounds of the parameters for a fit that starts at a shape, as a fit moves them.
    pub(super) fn bounds_near(&self, shape: &Shape) -> Vec<[f64; 2]> {
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
pub(super) fn candidates(
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
        let laws: Vec<Law> = Law::searched_on(observations.bench).filter(here).collect();
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
