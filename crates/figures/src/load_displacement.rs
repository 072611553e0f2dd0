//! Load against displacement, one panel for each pose and direction (the paper's Fig. 9).

use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::caption::{Bar, flagged_entry, hollow_sentence, joined};
use super::figure::{Axis, Figure, FigurePoint, Marks, Panel, Sharing, Style};
use super::palette::{Marker, qualitative};
use super::range::distinct;

/// What the figure shows: curves of one or more sessions.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadDisplacement {
    /// What the bars of all points are.
    pub bar: Bar,
    /// Sessions, each with its own shape and colour.
    pub sessions: Vec<SessionCurves>,
    /// Readings that stand out: drawn by themselves, part of no mean and joined with nothing.
    pub marked: Option<MarkedPoints>,
}

/// Readings that stand out.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkedPoints {
    /// What they are, for the legend.
    pub name: String,
    /// Pose, direction, force in N and displacement in m of each.
    pub points: Vec<(PoseId, Direction, [f64; 2])>,
}

/// The curves of one session.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionCurves {
    /// Name for the legend.
    pub name: String,
    /// One curve for each pose and direction.
    pub curves: Vec<LoadCurvePoints>,
}

/// Load and displacement of one pose along one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCurvePoints {
    /// The pose held.
    pub pose: PoseId,
    /// The direction of load and displacement.
    pub direction: Direction,
    /// Points, one for each load and branch, or single readings.
    pub points: Vec<DisplacementPoint>,
    /// Straight line fitted to them.
    pub line: Option<FittedLine>,
}

/// Displacement under one load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacementPoint {
    /// Signed force, N.
    pub force_n: f64,
    /// Signed displacement, m.
    pub displacement_m: f64,
    /// Half the length of the bar, m.
    pub bar_m: Option<f64>,
    /// How many repeats stand behind the point.
    pub n: usize,
    /// Loading or unloading.
    pub branch: Branch,
    /// Whether a reading behind it is flagged.
    pub flagged: bool,
}

/// displacement = intercept + compliance × force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedLine {
    /// Slope, m/N.
    pub compliance_m_per_n: f64,
    /// Displacement without load, m.
    pub intercept_m: f64,
}

/// Colour of readings that stand out: no other series of one session or two has it.
const MARKED_COLOUR: usize = 4;

/// The figure: loads across, displacements upward, both signed; rows are poses, columns directions.
///
/// The displacement axis is shared by the poses of a direction only: lateral displacements are thirty times the radial ones.
#[must_use]
pub fn load_displacement(input: &LoadDisplacement) -> Figure {
    let (poses, directions) = rows_and_columns(input);
    let has_unloading = all_points(input).any(|point| point.branch == Branch::Unloading);
    let mut panels = Vec::with_capacity(poses.len() * directions.len());
    for pose in &poses {
        for direction in &directions {
            panels.push(panel(input, pose, *direction, has_unloading));
        }
    }
    let flagged = all_points(input).filter(|point| point.flagged).count();
    Figure {
        columns: directions.len().max(1),
        panel_px: panel_px(poses.len(), directions.len()),
        share_x: Sharing::All,
        share_y: Sharing::Column,
        panels,
        legend: flagged_entry(flagged),
        ..Figure::new(
            "Displacement of the end against load",
            caption(input, flagged),
        )
    }
}

/// Size of a panel: a few large ones or many small ones fill a page.
fn panel_px(rows: usize, columns: usize) -> [f64; 2] {
    match (rows, columns) {
        (0 | 1, 0 | 1) => [420.0, 280.0],
        (_, 0 | 1) => [340.0, 180.0],
        _ => [190.0, 132.0],
    }
}

fn caption(input: &LoadDisplacement, flagged: usize) -> String {
    let is_fitted = input
        .sessions
        .iter()
        .flat_map(|session| &session.curves)
        .any(|curve| curve.line.is_some());
    let with_bar = all_points(input).filter(|point| point.bar_m.is_some());
    joined([
        Some(input.bar.sentence(with_bar.map(|point| point.n))),
        Some("A bar shorter than its point is covered by it.".to_owned()),
        hollow_sentence(flagged),
        Some(if is_fitted {
            "Lines: fitted with a free intercept.".to_owned()
        } else {
            "Lines join the points of a branch.".to_owned()
        }),
        Some(
            "Force and displacement are components along the positive axis; every direction has its own displacement scale."
                .to_owned(),
        ),
        input.marked.as_ref().map(|_| {
            "Readings of data findings are part of no mean, and no line joins them.".to_owned()
        }),
    ])
}

fn all_points(input: &LoadDisplacement) -> impl Iterator<Item = &DisplacementPoint> {
    input
        .sessions
        .iter()
        .flat_map(|session| &session.curves)
        .flat_map(|curve| &curve.points)
}

/// Poses in the order in which they come, and the directions that occur.
fn rows_and_columns(input: &LoadDisplacement) -> (Vec<PoseId>, Vec<Direction>) {
    let curves = input.sessions.iter().flat_map(|session| &session.curves);
    let of_curves = curves.map(|curve| (&curve.pose, curve.direction));
    let marked = input.marked.iter().flat_map(|marked| &marked.points);
    let marked = marked.map(|(pose, direction, _)| (pose, *direction));
    let cells: Vec<(&PoseId, Direction)> = of_curves.chain(marked).collect();
    let poses = distinct(cells.iter().map(|(pose, _)| (*pose).clone()));
    let directions = Direction::ALL
        .into_iter()
        .filter(|direction| cells.iter().any(|(_, of_cell)| of_cell == direction))
        .collect();
    (poses, directions)
}

fn panel(
    input: &LoadDisplacement,
    pose: &PoseId,
    direction: Direction,
    has_unloading: bool,
) -> Panel {
    let mut panel = Panel::new(
        format!("{pose}, {direction}"),
        Axis::linear("load", "N"),
        Axis::linear("displacement", "µm"),
    );
    for (place, session) in input.sessions.iter().enumerate() {
        for curve in session
            .curves
            .iter()
            .filter(|curve| curve.pose == *pose && curve.direction == direction)
        {
            // Each session takes two looks, so that its unloading branch differs from all other series too.
            if let Some(line) = &curve.line {
                let style = Style::nth(2 * place).stroke(1.1);
                panel.draw(style, Marks::Line(line_ends(line, &curve.points)));
            }
            for branch in [Branch::Loading, Branch::Unloading] {
                let points: Vec<FigurePoint> = curve
                    .points
                    .iter()
                    .filter(|point| point.branch == branch)
                    .map(|point| {
                        let y_m = point.displacement_m;
                        let bar = point.bar_m.map(|bar_m| bar_m / METRES_PER_MICROMETRE);
                        FigurePoint::of_reading(
                            point.force_n,
                            y_m / METRES_PER_MICROMETRE,
                            bar,
                            point.flagged,
                        )
                    })
                    .collect();
                if points.is_empty() {
                    continue;
                }
                // Without a fitted line a thin one joins the points, so that a branch can be followed.
                let look = 2 * place + usize::from(branch == Branch::Unloading);
                if curve.line.is_none() {
                    let joined = points.iter().map(|point| [point.x, point.y]).collect();
                    panel.draw(Style::nth(look).stroke(0.8), Marks::Line(joined));
                }
                let label = if has_unloading {
                    format!("{}, {branch}", session.name)
                } else {
                    session.name.clone()
                };
                panel.draw_named(
                    label,
                    Style::nth(look).marker_size(2.5),
                    Marks::Points(points),
                );
            }
        }
    }
    if let Some(marked) = &input.marked {
        let here = marked.points.iter();
        let here = here.filter(|(of_pose, of, _)| (of_pose, *of) == (pose, direction));
        let points = here.map(|(.., [force_n, displacement_m])| {
            FigurePoint::new(*force_n, displacement_m / METRES_PER_MICROMETRE)
        });
        let marker = Marker::nth(2 * input.sessions.len());
        panel.draw_named(
            marked.name.clone(),
            Style::new(qualitative(MARKED_COLOUR), marker).marker_size(4.0),
            Marks::Points(points.collect()),
        );
    }
    panel
}

/// Ends of a fitted line: from the smallest to the largest load, zero included, so that the intercept is seen.
fn line_ends(line: &FittedLine, points: &[DisplacementPoint]) -> Vec<[f64; 2]> {
    let low = points.iter().map(|p| p.force_n).fold(0.0, f64::min);
    let high = points.iter().map(|p| p.force_n).fold(0.0, f64::max);
    [low, high]
        .map(|force_n| {
            let displacement_m = line.intercept_m + line.compliance_m_per_n * force_n;
            [force_n, displacement_m / METRES_PER_MICROMETRE]
        })
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::{all_points, assert_says, line_of, points_of};

    fn input() -> LoadDisplacement {
        let curve = |pose: &str, direction, compliance_m_per_n: f64| LoadCurvePoints {
            pose: pose.into(),
            direction,
            points: (0..8)
                .map(|step| DisplacementPoint {
                    force_n: -10.0 * f64::from(step),
                    displacement_m: -10.0 * f64::from(step) * compliance_m_per_n,
                    bar_m: Some(2e-6),
                    n: 5,
                    branch: Branch::Loading,
                    flagged: step == 3,
                })
                .collect(),
            line: Some(FittedLine {
                compliance_m_per_n,
                intercept_m: 1e-6,
            }),
        };
        LoadDisplacement {
            bar: Bar::StandardDeviation,
            marked: None,
            sessions: vec![SessionCurves {
                name: "first".to_owned(),
                curves: vec![
                    curve("P1", Direction::X, 1e-4),
                    curve("P1", Direction::Z, 4e-6),
                    curve("P2", Direction::X, 1e-4),
                ],
            }],
        }
    }

    #[test]
    fn every_pose_and_direction_has_a_panel_with_the_numbers_in_micrometres() {
        let figure = load_displacement(&input());
        assert_eq!(figure.columns, 2);
        assert_eq!(figure.panels.len(), 4);
        assert_eq!(figure.panels[0].title, "P1, x");
        let points = points_of(&figure.panels[0].series[1]);
        assert_eq!(points.len(), 8);
        assert!((points[7].y + 7000.0).abs() < 1e-9);
        let [low, high] = points[7].y_bar.unwrap();
        assert!((high - low - 4.0).abs() < 1e-9);
        let line = line_of(&figure.panels[0].series[0]);
        assert!((line[1][1] - 1.0).abs() < 1e-9, "the intercept is 1 µm");
    }

    #[test]
    fn flagged_points_are_hollow_and_counted() {
        let figure = load_displacement(&input());
        let points = figure.panels.iter().flat_map(all_points);
        let hollow = points.filter(|point| point.hollow).count();
        assert_eq!(hollow, 3);
        assert_says(&figure, "standard deviation of n = 5 repeats");
        assert_says(&figure, "The 3 hollow points are flagged");
    }

    #[test]
    fn two_sessions_differ_in_shape_and_colour() {
        let mut input = input();
        let mut second = input.sessions[0].clone();
        second.name = "second".to_owned();
        input.sessions.push(second);
        let figure = load_displacement(&input);
        let looks: Vec<Style> = figure.panels[0]
            .series
            .iter()
            .filter(|series| series.label.is_some())
            .map(|series| series.style)
            .collect();
        assert_ne!(looks[0].colour, looks[1].colour);
        assert_ne!(looks[0].marker, looks[1].marker);
    }

    #[test]
    fn marked_readings_stand_by_themselves_in_their_panel() {
        let mut input = input();
        let point = ("P2".into(), Direction::Z, [-20.0, 5e-6]);
        input.marked = Some(MarkedPoints {
            name: "bad readings".to_owned(),
            points: vec![point],
        });
        let figure = load_displacement(&input);
        // Pose P2 has no curve along z.
        let series = &figure.panels[3].series;
        assert_eq!(series.len(), 1);
        assert_eq!(series[0].label.as_deref(), Some("bad readings"));
        let points = points_of(&series[0]);
        assert!((points[0].y - 5.0).abs() < 1e-9);
        let looks = |panel: &Panel| panel.series.iter().map(|one| one.style.marker).collect();
        let others: Vec<_> = looks(&figure.panels[0]);
        assert!(!others.contains(&series[0].style.marker));
    }

    #[test]
    fn the_svg_parses_with_and_without_data() {
        parse(&load_displacement(&input()).to_svg()).unwrap();
        let empty = LoadDisplacement {
            bar: Bar::Interval95,
            marked: None,
            sessions: Vec::new(),
        };
        parse(&load_displacement(&empty).to_svg()).unwrap();
    }
}
