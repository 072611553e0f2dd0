//! A robot in a pose, from two or three sides, and its shape under a load, magnified.

use stiffbench_numeric::vector::{norm, scale};
use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;

use super::bent_beam::bent_beam;
use super::caption::joined;
use super::figure::{
    Figure, FigureNote, FigurePoint, LegendEntry, LegendMark, Marks, NotePlacement, Panel, Style,
};
use super::palette::{Colour, Marker, QUALITATIVE, qualitative};
use super::range::distinct;
use super::robot_drawing::{DrawnKind, DrawnMember, RobotDrawing};
use super::robot_views::{RobotView, ViewLayout};
use super::ticks::{nearest_nice, signed};

/// The magnified largest displacement is about this share of the robot's size.
const SHOWN_SHARE: f64 = 0.08;
/// Room around the robot for names, supports and arrows, as a share of its size.
const ROOM: f64 = 0.09;

/// Colours of chains in the order in which they come: no black, which is the robot under load.
const CHAINS: [Colour; 7] = [
    QUALITATIVE[0],
    QUALITATIVE[1],
    QUALITATIVE[2],
    QUALITATIVE[3],
    QUALITATIVE[5],
    QUALITATIVE[4],
    Colour::GREY,
];

/// Kinds of members in the order in which they are drawn, with their looks: thick ones first, so that they do not hide the thinner ones at
/// shared nodes.
const KINDS: [(DrawnKind, &str); 4] = [
    (DrawnKind::Rigid, "hollow: rigid links"),
    (
        DrawnKind::Added,
        "hollow and dashed: rigid links that the robot file does not ask for",
    ),
    (DrawnKind::Beam, "thick: beams (drive-carrying)"),
    (DrawnKind::Link, "thin: links"),
];

/// The figure: views from the side, from above and, if the axes say so, from the front, all to the same scale.
#[must_use]
pub fn robot_pose(input: &RobotDrawing) -> Figure {
    let size_m = size_m(input);
    let largest_m = input
        .nodes
        .iter()
        .map(|node| norm(node.displacement_m))
        .filter(|displacement| displacement.is_finite())
        .fold(0.0, f64::max);
    let magnification = (input.force_n.is_some() && largest_m > 0.0)
        .then(|| nearest_nice(SHOWN_SHARE * size_m / largest_m));
    let shapes: Vec<Vec<[f64; 3]>> = input
        .members
        .iter()
        .filter_map(|member| deformed(input, member, magnification?))
        .collect();
    let points: Vec<[f64; 3]> = input
        .nodes
        .iter()
        .map(|node| node.position_m)
        .chain(shapes.iter().flatten().copied())
        .collect();
    let layout = ViewLayout::of(&input.axes, &points, ROOM * size_m);
    let panels = input
        .axes
        .views()
        .into_iter()
        .map(|view| panel(input, view, &layout.ranges, &shapes, magnification, size_m))
        .collect();
    Figure {
        columns: layout.columns,
        panel_px: [layout.column_widths_px[0], 300.0],
        column_widths_px: layout.column_widths_px,
        row_heights_px: layout.row_heights_px,
        panels,
        legend: legend(input, magnification.is_some()),
        ..Figure::new(input.name.clone(), caption(input, magnification))
    }
}

/// Largest extent of the robot along a global axis, m; 1 for a robot without extent.
fn size_m(input: &RobotDrawing) -> f64 {
    let size = (0..3).map(|axis| input.extent_m(axis)).fold(0.0, f64::max);
    if size > 0.0 { size } else { 1.0 }
}

/// Centre line of a member under the load, magnified; `None` if a node is missing or the member has no length.
fn deformed(
    input: &RobotDrawing,
    member: &DrawnMember,
    magnification: f64,
) -> Option<Vec<[f64; 3]>> {
    let [first, second] = member.nodes;
    let ends = [input.nodes.get(first)?, input.nodes.get(second)?];
    bent_beam(
        ends.map(|node| node.position_m),
        ends.map(|node| node.displacement_m),
        member.rotations_rad,
        magnification,
    )
}

fn panel(
    input: &RobotDrawing,
    view: RobotView,
    ranges: &[[f64; 2]; 3],
    shapes: &[Vec<[f64; 3]>],
    magnification: Option<f64>,
    size_m: f64,
) -> Panel {
    let [x, y] = view.axes(&input.axes, ranges);
    let mut panel = Panel::new(view.title, x, y);
    panel.equal_aspect = true;
    push_supports(&mut panel, input, view);
    push_members(&mut panel, input, view);
    for shape in shapes {
        panel.draw(
            deformed_style(),
            Marks::Line(shape.iter().map(|point| view.project(*point)).collect()),
        );
    }
    push_joints(&mut panel, input, view);
    push_nodes(&mut panel, input, view);
    push_load(&mut panel, input, view, magnification, size_m);
    panel
}

fn deformed_style() -> Style {
    Style {
        dash_px: Some([5.0, 2.5]),
        ..Style::line(Colour::BLACK, 1.3)
    }
}

fn displacement_style() -> Style {
    Style::line(qualitative(4), 2.0)
}

fn load_style() -> Style {
    Style::line(Colour::BLACK, 2.0)
}

fn push_supports(panel: &mut Panel, input: &RobotDrawing, view: RobotView) {
    let points = input
        .supports
        .iter()
        .filter_map(|&node| input.nodes.get(node))
        .map(|node| view.project(node.position_m))
        .map(|[z, up]| FigurePoint::new(z, up))
        .collect();
    panel.draw(
        Style::new(Colour::GREY, Marker::Ground).marker_size(5.0),
        Marks::Points(points),
    );
}

/// Chains in the order in which they come.
fn chains(input: &RobotDrawing) -> Vec<&str> {
    distinct(input.members.iter().map(|member| member.chain.as_str()))
}

fn push_members(panel: &mut Panel, input: &RobotDrawing, view: RobotView) {
    for (place, chain) in chains(input).into_iter().enumerate() {
        for kind in KINDS.map(|(kind, _)| kind) {
            let segments: Vec<[[f64; 2]; 2]> = input
                .members
                .iter()
                .filter(|member| member.chain == chain && member.kind == kind)
                .filter_map(|member| {
                    let [first, second] = member.nodes;
                    let ends = [input.nodes.get(first)?, input.nodes.get(second)?];
                    Some(ends.map(|node| view.project(node.position_m)))
                })
                .collect();
            if segments.is_empty() {
                continue;
            }
            let width = match kind {
                DrawnKind::Rigid | DrawnKind::Added => 6.0,
                DrawnKind::Beam => 4.2,
                DrawnKind::Link => 1.8,
            };
            let style = Style {
                dash_px: (kind == DrawnKind::Added).then_some([8.0, 5.0]),
                ..Style::new(CHAINS[place % CHAINS.len()], Marker::Dot)
            };
            panel.draw_named(
                format!("chain {chain}"),
                style.stroke(width),
                Marks::Segments(segments.clone()),
            );
            if matches!(kind, DrawnKind::Rigid | DrawnKind::Added) {
                let inside = Style::line(Colour::WHITE, 3.0);
                panel.draw(inside, Marks::Segments(segments));
            }
        }
    }
}

/// Looks of joints that turn and of joints that slide.
fn joint_style(slides: bool) -> Style {
    let marker = if slides {
        Marker::Square
    } else {
        Marker::Circle
    };
    Style::new(Colour::INK, marker).marker_size(5.0).stroke(1.2)
}

fn end_style() -> Style {
    Style::new(qualitative(4), Marker::Diamond).marker_size(5.6)
}

/// Joints as outlines around their nodes, and the end where there is no load to show it.
fn push_joints(panel: &mut Panel, input: &RobotDrawing, view: RobotView) {
    let at = |node: usize| {
        let [across, up] = view.project(input.nodes.get(node)?.position_m);
        Some(FigurePoint::new(across, up))
    };
    for slides in [false, true] {
        let joints = input.joints.iter().filter(|joint| joint.slides == slides);
        let points = joints.filter_map(|joint| Some(at(joint.node)?.hollow(true)));
        let marks = Marks::Points(points.collect());
        panel.draw(joint_style(slides), marks);
    }
    if input.force_n.is_none() {
        let marks = Marks::Points(at(input.end).into_iter().collect());
        panel.draw(end_style(), marks);
    }
}

/// Nodes and their names; nodes that coincide in this view share one name tag.
fn push_nodes(panel: &mut Panel, input: &RobotDrawing, view: RobotView) {
    let style = Style::new(Colour::INK, Marker::Circle).marker_size(2.4);
    let mut points = Vec::with_capacity(input.nodes.len());
    let mut tags: Vec<([f64; 2], String)> = Vec::new();
    let end = input.nodes.get(input.end);
    let others = input
        .nodes
        .iter()
        .enumerate()
        .filter(|(place, _)| *place != input.end)
        .map(|(_, node)| node);
    for node in end.into_iter().chain(others) {
        let at = view.project(node.position_m);
        points.push(FigurePoint::new(at[0], at[1]));
        let same = tags
            .iter_mut()
            .find(|(other, _)| (other[0] - at[0]).hypot(other[1] - at[1]) < 1e-6);
        match same {
            // The ground that a base on springs stands on has the name of its point.
            Some((_, names)) if names.split(", ").any(|name| name == node.name) => {}
            Some((_, names)) => {
                names.push_str(", ");
                names.push_str(&node.name);
            }
            None => tags.push((at, node.name.clone())),
        }
    }
    panel.draw(style, Marks::Points(points));
    for (at, text) in tags {
        panel
            .notes
            .push(FigureNote::new(at, text, 10.0, NotePlacement::Free));
    }
}

/// The force as an arrow of fixed length that ends at the end node, and the magnified displacement of the end.
fn push_load(
    panel: &mut Panel,
    input: &RobotDrawing,
    view: RobotView,
    magnification: Option<f64>,
    size_m: f64,
) {
    let (Some(force_n), Some(end)) = (input.force_n, input.nodes.get(input.end)) else {
        return;
    };
    let tip = end.position_m;
    if norm(force_n) > 0.0 {
        let back = scale(force_n, -0.085 * size_m / norm(force_n));
        let tail = [0, 1, 2].map(|i| tip[i] + back[i]);
        panel.draw_named(
            force_label(force_n),
            load_style(),
            Marks::Arrows(vec![[view.project(tail), view.project(tip)]]),
        );
    }
    if let Some(magnification) = magnification {
        let moved = [0, 1, 2].map(|i| tip[i] + magnification * end.displacement_m[i]);
        panel.draw_named(
            "displacement of the end",
            displacement_style(),
            Marks::Arrows(vec![[view.project(tip), view.project(moved)]]),
        );
    }
}

fn force_label(force_n: [f64; 3]) -> String {
    let parts: Vec<String> = ["x", "y", "z"]
        .into_iter()
        .zip(force_n)
        .filter(|(_, component)| *component != 0.0)
        .map(|(axis, component)| format!("F{axis} = {} N", signed(component, 0)))
        .collect();
    parts.join(", ")
}

fn legend(input: &RobotDrawing, is_deformed: bool) -> Vec<LegendEntry> {
    let mut legend = Vec::new();
    if is_deformed {
        legend.push(LegendEntry::new(
            "under load, magnified",
            deformed_style(),
            LegendMark::Line,
        ));
    }
    if !input.supports.is_empty() {
        legend.push(LegendEntry::new(
            "support",
            Style::new(Colour::GREY, Marker::Ground),
            LegendMark::Point,
        ));
    }
    for (slides, label) in [(false, "joint that turns"), (true, "joint that slides")] {
        if input.joints.iter().any(|joint| joint.slides == slides) {
            legend.push(LegendEntry::new(
                label,
                joint_style(slides),
                LegendMark::HollowPoint,
            ));
        }
    }
    if let (None, Some(end)) = (input.force_n, input.nodes.get(input.end)) {
        legend.push(LegendEntry::new(
            format!("end {}", end.name),
            end_style(),
            LegendMark::Point,
        ));
    }
    legend
}

fn caption(input: &RobotDrawing, magnification: Option<f64>) -> String {
    let under_load = match (magnification, input.nodes.get(input.end)) {
        (Some(magnification), Some(end)) => {
            let micrometres = scale(end.displacement_m, 1.0 / METRES_PER_MICROMETRE);
            let decimals = usize::from(norm(micrometres) < 1000.0);
            let [x, y, z] = micrometres.map(|component| signed(component, decimals));
            Some(format!(
                "Displacements are magnified {}\u{a0}times. The end {} moves by ({x}, {y}, {z})\u{a0}µm along x, y, z.",
                magnification_text(magnification),
                end.name
            ))
        }
        _ if input.force_n.is_some() => Some("Nothing moves under the load.".to_owned()),
        _ => None,
    };
    joined([
        kinds(input),
        Some("Names that would cover another are left out.".to_owned()),
        under_load,
    ])
}

/// How members are drawn, if there is more than one kind of them or only rigid ones.
fn kinds(input: &RobotDrawing) -> Option<String> {
    let has = |kind: DrawnKind| input.members.iter().any(|member| member.kind == kind);
    let words = KINDS.into_iter().filter(|(kind, _)| has(*kind));
    let words: Vec<&str> = words.map(|(_, words)| words).collect();
    let (first, rest) = words.split_first()?;
    let mut sentence = first[..1].to_uppercase() + &first[1..];
    for words in rest {
        sentence += "; ";
        sentence += words;
    }
    Some(sentence + ".")
}

/// A magnification, which is 1, 2 or 5 times a power of ten.
fn magnification_text(magnification: f64) -> String {
    super::ticks::number(magnification, magnification)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::png::parse;
    use crate::reading::assert_says;
    use crate::robot_drawing::DrawnNode;
    use crate::robot_views::DrawnAxes;

    /// A cantilever of 2 m along z from the origin with force f along -y at its tip: δ = f L³/(3EI), θ = f L²/(2EI).
    fn cantilever(tip_m: f64) -> RobotDrawing {
        let node = |name: &str, z: f64, y: f64| DrawnNode {
            name: name.to_owned(),
            position_m: [0.0, 0.0, z],
            displacement_m: [0.0, y, 0.0],
        };
        RobotDrawing {
            name: "cantilever".to_owned(),
            nodes: vec![node("A", 0.0, 0.0), node("B", 2.0, tip_m)],
            members: vec![DrawnMember {
                nodes: [0, 1],
                // θ/δ = 3/(2L); the tip moves along y when it turns about -x.
                rotations_rad: [[0.0; 3], [-1.5 * tip_m / 2.0, 0.0, 0.0]],
                chain: "A".to_owned(),
                kind: DrawnKind::Beam,
            }],
            joints: Vec::new(),
            axes: DrawnAxes::default(),
            supports: vec![0],
            end: 1,
            force_n: Some([0.0, -50.0, 0.0]),
        }
    }

    #[test]
    fn the_magnification_is_round_and_stated() {
        // 0.08 × 2 m / 1 mm = 160, nearest of 1-2-5 is 200.
        let figure = robot_pose(&cantilever(-1e-3));
        assert_says(&figure, "magnified 200 times");
        assert_says(&figure, "(0, −1000, 0) µm");
        parse(&figure.to_svg()).unwrap();
    }

    #[test]
    fn both_views_have_one_scale() {
        let figure = robot_pose(&cantilever(-1e-3));
        let per_px: Vec<f64> = figure
            .panels
            .iter()
            .zip(&figure.row_heights_px)
            .flat_map(|(panel, height)| {
                let [x, y] = [&panel.x, &panel.y].map(|axis| axis.range.unwrap());
                [(x[1] - x[0]) / figure.panel_px[0], (y[1] - y[0]) / height]
            })
            .collect();
        assert!(
            per_px.iter().all(|p| (p - per_px[0]).abs() < 1e-12),
            "{per_px:?}"
        );
    }

    #[test]
    fn missing_parts_do_not_break_the_figure() {
        let mut input = cantilever(0.0);
        input.members[0].nodes = [0, 7];
        input.supports = vec![9];
        input.end = 5;
        parse(&robot_pose(&input).to_svg()).unwrap();
        input.nodes.clear();
        parse(&robot_pose(&input).to_svg()).unwrap();
    }
}
