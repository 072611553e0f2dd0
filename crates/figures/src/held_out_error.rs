//! Error in poses that the fit has not seen, without and with what was found.

use stiffbench_units_and_text::test_point::PoseId;

use super::before_after::three_digits;
use super::caption::{count_range, joined};
use super::figure::{Axis, Figure, FigureNote, FigurePoint, Marks, NotePlacement, Panel, Style};
use super::palette::{Colour, Marker, qualitative};
use super::range::finite_ends;

/// Errors that differ by more than this factor stand on a logarithmic axis: on an even one the small ones would touch zero.
const WIDEST_EVEN: f64 = 15.0;
/// What noise alone leaves, in its own units.
const NOISE_ALONE: f64 = 1.0;
/// Width of a pose, px: two numbers must fit beside the points.
const POSE_PX: f64 = 96.0;

/// What the figure shows.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutError {
    /// What was added to the prediction, for example `joint-backlash at A3`.
    pub found: String,
    /// One entry for each pose that was left out in turn.
    pub poses: Vec<HeldOutPose>,
}

/// The error in one pose, predicted by a fit to all others.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOutPose {
    /// The pose left out.
    pub pose: PoseId,
    /// Root mean square residual without what was found, each reading as a multiple of its noise.
    pub before: f64,
    /// The same with it.
    pub after: f64,
    /// Readings of the pose.
    pub n: usize,
}

/// The figure: for every pose a line from the error before to the error after, and the noise floor.
#[must_use]
pub fn held_out_error(input: &HeldOutError) -> Figure {
    let names = input.poses.iter().map(|p| p.pose.to_string()).collect();
    let mut panel = Panel::new(
        "",
        Axis::categories("pose left out", names),
        vertical(input),
    );
    push_floor(&mut panel, input);
    let pairs = input.poses.iter().enumerate().map(|(place, pose)| {
        let x = place as f64;
        [[x, pose.before], [x, pose.after]]
    });
    panel.draw(
        Style::line(Colour::GREY, 2.0),
        Marks::Segments(pairs.collect()),
    );
    push_points(&mut panel, input, false);
    push_points(&mut panel, input, true);
    let poses = input.poses.len();
    Figure {
        panel_px: [(POSE_PX * poses as f64).clamp(440.0, 900.0), 240.0],
        panels: vec![panel],
        ..Figure::new(
            format!("Error in poses left out, without and with {}", input.found),
            caption(input),
        )
    }
}

/// An even axis from zero, or a logarithmic one for errors of very different sizes.
fn vertical(input: &HeldOutError) -> Axis {
    let name = "rms residual in units of the noise";
    let poses = input.poses.iter();
    let values = poses.flat_map(|pose| [pose.before, pose.after, NOISE_ALONE]);
    let [low, high] = finite_ends(values).unwrap_or([0.0; 2]);
    if low > 0.0 && high > WIDEST_EVEN * low {
        return Axis::log10(name, "").within([low / 1.4, high * 2.0]);
    }
    let top = if high > 0.0 { 1.15 * high } else { 1.0 };
    Axis::linear(name, "").within([low.min(0.0), top])
}

fn push_floor(panel: &mut Panel, input: &HeldOutError) {
    let floors = (0..input.poses.len()).map(|place| {
        let x = place as f64;
        [[x - 0.38, NOISE_ALONE], [x + 0.38, NOISE_ALONE]]
    });
    panel.draw_named(
        "noise alone",
        Style::new(Colour::INK, Marker::Dash).stroke(1.4).dashed(),
        Marks::Segments(floors.collect()),
    );
}

fn push_points(panel: &mut Panel, input: &HeldOutError, after: bool) {
    let (label, style) = if after {
        (
            "with",
            Style::new(qualitative(0), Marker::Square).marker_size(4.2),
        )
    } else {
        // Larger, so that it shows behind the other where the errors agree.
        (
            "without",
            Style::new(qualitative(1), Marker::Circle).marker_size(5.6),
        )
    };
    let at = |(place, pose): (usize, &HeldOutPose)| {
        let value = if after { pose.after } else { pose.before };
        [place as f64, value]
    };
    let places: Vec<[f64; 2]> = input.poses.iter().enumerate().map(at).collect();
    // The two numbers of a pose stand on different sides, so that they cannot touch when the errors agree; and a little higher than
    // their points, because the noise floor lies below.
    let side = if after { 1.0 } else { -1.0 };
    panel
        .notes
        .extend(places.iter().filter(|p| p[1].is_finite()).map(|p| {
            FigureNote::new(
                *p,
                three_digits(p[1]),
                10.5,
                NotePlacement::Toward([side, 0.4]),
            )
        }));
    panel.draw_named(
        label,
        style,
        Marks::Points(
            places
                .into_iter()
                .map(|[x, y]| FigurePoint::new(x, y))
                .collect(),
        ),
    );
}

fn caption(input: &HeldOutError) -> String {
    let poses = input.poses.len();
    let fell = input
        .poses
        .iter()
        .filter(|pose| pose.after < pose.before)
        .count();
    joined([
        Some(format!(
            "Root mean square of measured minus predicted displacement in a pose, predicted by a fit to all other poses, each reading \
             as a multiple of its noise; {} readings a pose, no bars.",
            count_range(input.poses.iter().map(|pose| pose.n))
        )),
        Some(format!("The error fell in {fell} of {poses} poses.")),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::AxisScale;
    use crate::png::parse;
    use crate::reading::{assert_says, labelled, notes_of, points_of};

    fn pose(name: &str, before: f64, after: f64) -> HeldOutPose {
        HeldOutPose {
            pose: name.into(),
            before,
            after,
            n: 120,
        }
    }

    fn input(poses: Vec<HeldOutPose>) -> HeldOutError {
        HeldOutError {
            found: "joint-backlash at A3".to_owned(),
            poses,
        }
    }

    #[test]
    fn the_numbers_are_multiples_of_the_noise_and_stand_beside_the_points() {
        let figure = held_out_error(&input(vec![pose("P1", 12.0, 6.6), pose("P2", 1.2, 1.3)]));
        let points = |label: &str| -> Vec<f64> {
            let points = points_of(labelled(&figure.panels[0], label)).iter();
            points.map(|p| p.y.round()).collect()
        };
        assert_eq!(points("without"), [12.0, 1.0]);
        assert_eq!(points("with"), [7.0, 1.0]);
        let texts = notes_of(&figure.panels[0]);
        assert_eq!(texts, ["12.0", "1.20", "6.60", "1.30"]);
        assert_says(&figure, "n = 120 readings a pose");
        assert_says(&figure, "fell in 1 of 2 poses");
        assert_eq!(figure.panels[0].y.scale, AxisScale::Linear);
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn very_different_errors_stand_on_a_logarithmic_axis() {
        let figure = held_out_error(&input(vec![pose("P1", 900.0, 6.0)]));
        assert_eq!(figure.panels[0].y.scale, AxisScale::Log10);
        let figure = held_out_error(&input(vec![pose("P1", 900.0, 0.0)]));
        assert_eq!(
            figure.panels[0].y.scale,
            AxisScale::Linear,
            "zero has no logarithm"
        );
    }

    #[test]
    fn what_is_not_a_number_is_counted_as_not_drawn() {
        let svg = held_out_error(&input(vec![pose("P1", f64::NAN, 1.0)])).to_svg();
        assert!(svg.contains("1 point has no place on the axes"));
        parse(&svg).unwrap();
        parse(&held_out_error(&input(Vec::new())).to_svg()).unwrap();
    }
}
