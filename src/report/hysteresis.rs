//! The loop between loading and unloading, for people.

use stiffbench_document::{Document, Table};

use crate::reported::Reported;
use crate::stiffness::HysteresisReport;

use super::text::{interval, value_and_u, with_u};

/// What the columns of the table are.
const ABOUT_WIDTH: &str = "Width: displacement while unloading less displacement while loading at the same measured force, along the load, positive where the displacement lags behind; the interval of the largest holds over all loads at once (95 %). Residual: the width without load; drift and creep are not taken off. Energy: the area of the loop. U is the expanded uncertainty for 95 % from the scatter of the loops, with the steps and the reversibility of the gauges as far as they are stated.";

/// What the lost motion is.
const ABOUT_LOST_MOTION: &str = "Lost motion: distance of the middle of both branches between +3 and -3 % of the largest load; the spring of the part is in it.";

/// The loops of some poses and directions: their largest width, what remains, the stiffness of each branch and the energy. Nothing without loops.
///
/// # Arguments
/// - `cells`: pose, direction and loop.
pub(super) fn hysteresis_document(cells: &[(String, String, HysteresisReport)]) -> Document {
    let mut document = Document::new();
    if cells.is_empty() {
        return document;
    }
    let printed = |value: &Reported| with_u(value, 3);
    let mut table = Table::of(cells)
        .words("pose", |(pose, ..)| pose)
        .words("direction", |(_, direction, _)| direction)
        .numbers("loops", |(.., found)| found.n_loops)
        .numbers("largest width, µm", |(.., found)| {
            let width = &found.largest.width;
            let half = width.ci95.map(|[low, high]| 0.5 * (high - low));
            value_and_u([width.value, half], 3, "-")[0].clone()
        })
        .numbers("95 % interval", |(.., found)| {
            interval(found.largest.width.ci95, 3)
        })
        .numbers("at, N", |(.., found)| found.largest.target_n)
        .numbers_each(["residual, µm", "U"], |(.., found)| {
            printed(&found.residual_displacement)
        });
    let has_lost_motion =
        |(.., found): &(String, String, HysteresisReport)| found.lost_motion.value.is_some();
    let has_lost_motion = cells.iter().any(has_lost_motion);
    if has_lost_motion {
        table = table.numbers_each(["lost motion, µm", "U"], |(.., found)| {
            printed(&found.lost_motion)
        });
    }
    document.table(
        table
            .numbers_each(["K loading, N/µm", "U"], |(.., found)| {
                printed(&found.stiffness_loading)
            })
            .numbers_each(["K unloading, N/µm", "U"], |(.., found)| {
                printed(&found.stiffness_unloading)
            })
            .numbers_each(["energy, µJ", "U"], |(.., found)| printed(&found.energy)),
    );
    document.paragraph(ABOUT_WIDTH);
    if has_lost_motion {
        document.paragraph(ABOUT_LOST_MOTION);
    }
    for (pose, direction, found) in cells {
        if let Some([from, to]) = found.closing_line_n {
            document.item(format!(
                "{pose} {direction}: the loop is open; for its energy a straight line from {from:.3} to {to:.3} N closes it"
            ));
        }
    }
    document
}
