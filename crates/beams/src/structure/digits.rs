//! Digits that a solution keeps, and the element that takes them.

use super::element::NaturalStiffness;
use super::parts::{Structure, StructureError};

/// Where a pivot keeps less than this share of its diagonal entry beside a stiff element, six digits are not sure: of sixteen, eight are
/// gone at once, and errors grow some ten times on the way to the end.
pub(super) const SIX_DIGITS: f64 = 1e-8;

/// An element this many times as stiff as the middle one explains lost digits; the factors of shipped robots stay below 1e4.
const TOO_STIFF: f64 = 1e5;

/// The element that is stiffest beside the middle one, in the strain where it is most so, if it explains lost digits.
pub(super) fn too_stiff(
    elements: &[NaturalStiffness],
    structure: &Structure,
) -> Option<StructureError> {
    let strains = 0..elements.first()?.stiffness.len();
    let of_strain = |strain: usize| {
        let of = |element: &NaturalStiffness| element.stiffness[strain];
        let mut sorted: Vec<f64> = elements.iter().map(of).collect();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted[(sorted.len() - 1) / 2];
        let values = elements.iter().map(of).enumerate();
        let (element, largest) = values.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (middle > 0.0).then_some((element, largest / middle))
    };
    let stiffest = strains.filter_map(of_strain);
    let (element, ratio) = stiffest.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let ends = &structure.elements[element].ends;
    let [first, second] = [0, 1].map(|end| structure.nodes[ends[end].node].name.clone());
    (ratio > TOO_STIFF).then_some(StructureError::TooStiff {
        first,
        second,
        ratio,
    })
}
