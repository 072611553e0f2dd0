//! A robot in its poses as characters, for the terminal.

use std::fmt::Write;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{Canvas, Line};

use crate::plot::RobotDrawing;

/// Narrowest sketch, and most lines of one, characters.
const NARROWEST: usize = 34;
const TALLEST: usize = 22;
/// Between two sketches, characters.
const GAP: usize = 3;
/// Most poses that are sketched.
const MOST: usize = 8;
/// Joints are marked up to so many: more would hide the members.
const FEW_JOINTS: usize = 10;

/// The sketches, side by side as the width of the terminal allows; all have one scale.
pub(super) fn sketch(drawings: &[(String, RobotDrawing)], width: usize, unicode: bool) -> String {
    let shown = &drawings[..drawings.len().min(MOST)];
    let Some((_, first)) = shown.first() else {
        return String::new();
    };
    let [across, depth] = first.axes.across_and_depth();
    let mut views = vec![("", [across, first.axes.up])];
    if first.axes.front {
        views.push((" from above", [across, depth]));
    }
    let beside = ((width + GAP) / (NARROWEST + GAP)).clamp(1, shown.len());
    let columns = ((width + GAP) / beside).saturating_sub(GAP).max(8);
    let scale = SketchScale::of(shown, &views, columns);
    let mut text = String::new();
    for row in shown.chunks(beside) {
        for (title, axes) in &views {
            let blocks: Vec<Vec<String>> = row
                .iter()
                .map(|(name, drawing)| {
                    let mut lines = vec![format!("{name}{title}")];
                    lines.extend(scale.lines(drawing, *axes, unicode));
                    lines
                })
                .collect();
            text.push_str(&side_by_side(&blocks, scale.columns));
        }
        text.push('\n');
    }
    let names = &first.axes.names;
    let marks = if unicode {
        "▲ support, ◆ end"
    } else {
        "^ support, X end"
    };
    let joints = if has_few_joints(first) {
        ", o joint"
    } else {
        ""
    };
    let mut notes = format!(
        "{} to the right, {} upward; {:.2} m per character.\n{marks}{joints}\n",
        names[across].replacen(", ", " (", 1)
            + if names[across].contains(", ") {
                ")"
            } else {
                ""
            },
        names[first.axes.up].split(',').next().unwrap_or_default(),
        scale.m_per_column
    );
    if shown.len() < drawings.len() {
        let _ = writeln!(
            notes,
            "{} of {} poses; --out FOLDER draws all.",
            shown.len(),
            drawings.len()
        );
    }
    text + &notes + "\n"
}

/// Joints at few nodes.
fn has_few_joints(drawing: &RobotDrawing) -> bool {
    (1..=FEW_JOINTS).contains(&drawing.joints.len())
}

/// One scale for all sketches.
struct SketchScale {
    columns: usize,
    /// Least value of each axis, m.
    low_m: [f64; 3],
    /// Extent of each axis, m.
    extent_m: [f64; 3],
    /// A character is twice as high as it is wide.
    m_per_column: f64,
}

impl SketchScale {
    fn of(shown: &[(String, RobotDrawing)], views: &[(&str, [usize; 2])], columns: usize) -> Self {
        let positions = || {
            let nodes = shown.iter().flat_map(|(_, drawing)| &drawing.nodes);
            nodes.map(|node| node.position_m)
        };
        let fold = |start: f64, of: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|axis| {
                let values = positions().map(|at| at[axis]).filter(|c| c.is_finite());
                values.fold(start, of)
            })
        };
        let (low_m, high_m) = (
            fold(f64::INFINITY, f64::min),
            fold(f64::NEG_INFINITY, f64::max),
        );
        let extent_m = [0, 1, 2].map(|axis| (high_m[axis] - low_m[axis]).max(0.0));
        let needed = views.iter().map(|(_, [across, upward])| {
            let wide = extent_m[*across] / (columns - 2) as f64;
            wide.max(0.5 * extent_m[*upward] / (TALLEST - 2) as f64)
        });
        let m_per_column = needed.fold(0.0, f64::max);
        let m_per_column = if m_per_column > 0.0 {
            m_per_column
        } else {
            1.0
        };
        // As wide as the robot: the rest of the line would be empty.
        let wide = views.iter().map(|(_, [across, _])| extent_m[*across]);
        let wide = wide.fold(0.0, f64::max) / m_per_column;
        Self {
            columns: (wide.ceil() as usize + 2).clamp(14, columns.max(14)),
            low_m,
            extent_m,
            m_per_column,
        }
    }

    /// One view of a robot, line by line.
    fn lines(
        &self,
        drawing: &RobotDrawing,
        [across, upward]: [usize; 2],
        unicode: bool,
    ) -> Vec<String> {
        let step = self.m_per_column;
        let rows = (0.5 * self.extent_m[upward] / step).ceil() as usize + 1;
        let bounds = [
            [self.low_m[across] - step, self.columns as f64 * step],
            [self.low_m[upward] - step, 2.0 * rows as f64 * step],
        ]
        .map(|[low, length]| [low, low + length]);
        let at = |node: usize| {
            let position = drawing.nodes.get(node)?.position_m;
            Some([position[across], position[upward]])
        };
        let area = Rect::new(0, 0, self.columns as u16, rows as u16);
        let mut buffer = Buffer::empty(area);
        let (marker, dots) = if unicode {
            (Marker::Braille, [2, 4])
        } else {
            (Marker::Custom('.'), [1, 1])
        };
        Canvas::default()
            .marker(marker)
            .x_bounds(bounds[0])
            .y_bounds(bounds[1])
            .paint(|context| {
                for member in &drawing.members {
                    if let (Some([x1, y1]), Some([x2, y2])) =
                        (at(member.nodes[0]), at(member.nodes[1]))
                    {
                        context.draw(&Line::new(x1, y1, x2, y2, Color::Reset));
                    }
                }
            })
            .render(area, &mut buffer);
        let mut mark = |node: usize, symbol: &str| {
            let Some(point) = at(node) else { return };
            let [right, up] =
                [0, 1].map(|i| (point[i] - bounds[i][0]) / (bounds[i][1] - bounds[i][0]));
            let [column, row] = [
                cell_of(right, self.columns, dots[0]),
                cell_of(1.0 - up, rows, dots[1]),
            ];
            if let Some(cell) = buffer.cell_mut((column, row)) {
                cell.set_symbol(symbol);
            }
        };
        if has_few_joints(drawing) {
            for joint in &drawing.joints {
                mark(joint.node, if joint.slides { "#" } else { "o" });
            }
        }
        let [support, end] = if unicode { ["▲", "◆"] } else { ["^", "X"] };
        for &node in &drawing.supports {
            mark(node, support);
        }
        mark(drawing.end, end);
        let symbol =
            |column: u16, row: u16| buffer.cell((column, row)).map_or(" ", |cell| cell.symbol());
        (0..rows as u16)
            .map(|row| {
                (0..self.columns as u16)
                    .map(|column| symbol(column, row))
                    .collect()
            })
            .collect()
    }
}

/// The character that holds a point, by the share of the way across, as the canvas rounds to its dots.
fn cell_of(share: f64, characters: usize, dots: usize) -> u16 {
    let dot = (share * (characters * dots - 1) as f64).round() as usize;
    (dot / dots) as u16
}

/// Blocks of lines beside each other.
fn side_by_side(blocks: &[Vec<String>], columns: usize) -> String {
    let rows = blocks.iter().map(Vec::len).max().unwrap_or_default();
    let mut text = String::new();
    for row in 0..rows {
        let mut line = String::new();
        for (place, block) in blocks.iter().enumerate() {
            let content = block.get(row).map_or("", String::as_str);
            let indent = place * (columns + GAP);
            let gap = indent.saturating_sub(line.chars().count());
            line.push_str(&" ".repeat(gap));
            line.push_str(content);
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{DrawnAxes, DrawnJoint, DrawnKind, DrawnMember, DrawnNode};

    /// An L of 1 m up and 2 m across.
    fn drawing() -> RobotDrawing {
        let node = |name: &str, z: f64, y: f64| DrawnNode {
            name: name.to_owned(),
            position_m: [0.0, y, z],
            displacement_m: [0.0; 3],
        };
        let member = |nodes| DrawnMember {
            nodes,
            rotations_rad: [[0.0; 3]; 2],
            chain: "S".to_owned(),
            kind: DrawnKind::Beam,
        };
        RobotDrawing {
            name: "L".to_owned(),
            nodes: vec![
                node("A", 0.0, 0.0),
                node("B", 0.0, 1.0),
                node("C", 2.0, 1.0),
            ],
            members: vec![member([0, 1]), member([1, 2])],
            supports: vec![0],
            end: 2,
            joints: vec![DrawnJoint {
                node: 1,
                slides: false,
            }],
            axes: DrawnAxes::default(),
            force_n: None,
        }
    }

    #[test]
    fn an_l_looks_like_one() {
        let text = sketch(&[("P1".to_owned(), drawing())], 42, false);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "P1");
        // 2 m over 40 characters, so 1 m upward is 10 lines: the top one goes from the joint to the end.
        assert_eq!(lines[1].trim_start().len(), 40, "{text}");
        assert!(
            lines[1].contains("o...") && lines[1].ends_with('X'),
            "{text}"
        );
        assert_eq!(lines[11].trim(), "^", "{text}");
        for line in &lines[2..11] {
            assert_eq!(line.trim(), ".", "{text}");
        }
        assert!(text.contains("0.05 m per character"), "{text}");
    }

    #[test]
    fn poses_stand_side_by_side_and_many_are_left_out() {
        let poses: Vec<(String, RobotDrawing)> =
            (1..=9).map(|i| (format!("P{i}"), drawing())).collect();
        let text = sketch(&poses, 80, true);
        assert!(text.lines().next().unwrap().contains("P2"), "{text}");
        assert!(text.contains("8 of 9 poses"), "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 80),
            "{text}"
        );
        assert_eq!(sketch(&[], 80, true), "");
    }

    #[test]
    fn a_robot_without_extent_is_a_point() {
        let mut point = drawing();
        for node in &mut point.nodes {
            node.position_m = [0.0; 3];
        }
        let text = sketch(&[("P1".to_owned(), point)], 10, true);
        assert!(text.contains('◆'), "{text}");
    }
}
