//! Orthographic views of a robot: which axes run across and upward in each, and how large the panels are at one scale.

use super::figure::Axis;
use super::range::finite_ends;

/// Width of the plot area of two views, one above the other, px.
const WIDTH_PX: f64 = 600.0;
/// Width of both plot areas side by side where there are three views, px.
const THREE_WIDTH_PX: f64 = 820.0;
/// Height of all panels together, and least width of one, px.
const TALLEST_PX: f64 = 900.0;
const NARROWEST_PX: f64 = 340.0;
/// Least width of the view from the front, px.
const FRONT_PX: f64 = 150.0;

/// The axes of the world in a drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnAxes {
    /// Names of x, y and z, for example `y, vertical`.
    pub names: [String; 3],
    /// The axis that points up: 0 is x.
    pub up: usize,
    /// Whether the robot is drawn from the front too, not only from the side and from above.
    pub front: bool,
}

impl Default for DrawnAxes {
    /// Those of the paper: y up, z radial, from the side and from above.
    fn default() -> Self {
        Self {
            names: ["x, lateral", "y, vertical", "z, radial"].map(str::to_owned),
            up: 1,
            front: false,
        }
    }
}

impl DrawnAxes {
    /// The axis that runs across in the view from the side, and the one that points away from the viewer there.
    #[must_use]
    pub fn across_and_depth(&self) -> [usize; 2] {
        match self.up {
            0 => [1, 2],
            1 => [2, 0],
            _ => [0, 1],
        }
    }

    /// The views, in the order of their panels: side, front if there is one, top.
    pub(super) fn views(&self) -> Vec<RobotView> {
        let [across, depth] = self.across_and_depth();
        let view = |title, across, upward| RobotView {
            title,
            across,
            upward,
        };
        let mut views = vec![view("from the side", across, self.up)];
        if self.front {
            views.push(view("from the front", depth, self.up));
        }
        views.push(view("from above", across, depth));
        views
    }
}

/// One view.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobotView {
    pub(super) title: &'static str,
    across: usize,
    upward: usize,
}

impl RobotView {
    /// The axes that run across and upward.
    pub(super) fn drawn(self) -> [usize; 2] {
        [self.across, self.upward]
    }

    /// Where a point is in the view.
    pub(super) fn project(self, point: [f64; 3]) -> [f64; 2] {
        [point[self.across], point[self.upward]]
    }

    /// The axes of its panel.
    pub(super) fn axes(self, axes: &DrawnAxes, ranges: &[[f64; 2]; 3]) -> [Axis; 2] {
        [self.across, self.upward]
            .map(|axis| Axis::linear(&axes.names[axis], "m").within(ranges[axis]))
    }
}

/// Ranges of the three axes and sizes of the panels, all at one scale.
pub(super) struct ViewLayout {
    /// Range of each axis, m.
    pub(super) ranges: [[f64; 2]; 3],
    pub(super) columns: usize,
    pub(super) column_widths_px: Vec<f64>,
    pub(super) row_heights_px: Vec<f64>,
}

impl ViewLayout {
    /// The layout for points, with so much room around them, m.
    pub(super) fn of(axes: &DrawnAxes, points: &[[f64; 3]], room_m: f64) -> Self {
        let finite = || points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let mut ranges = [0, 1, 2].map(|axis| {
            let ends = finite_ends(finite().map(|p| p[axis]));
            ends.map_or([0.0, 1.0], |[low, high]| [low - room_m, high + room_m])
        });
        let [across, depth] = axes.across_and_depth();
        let length = |[low, high]: [f64; 2]| high - low;
        let upward = length(ranges[axes.up]) + length(ranges[depth]);
        let (wide, widest_px) = if axes.front {
            (
                length(ranges[across]) + length(ranges[depth]),
                THREE_WIDTH_PX,
            )
        } else {
            (length(ranges[across]), WIDTH_PX)
        };
        // A robot that stands in a corner of a tall picture is drawn narrower, not the picture taller.
        let per_px = (wide / widest_px).max(upward / TALLEST_PX);
        widen(&mut ranges[across], NARROWEST_PX * per_px);
        if axes.front {
            widen(&mut ranges[depth], FRONT_PX * per_px);
        }
        let px = |axis: usize| length(ranges[axis]) / per_px;
        let mut column_widths_px = vec![px(across)];
        if axes.front {
            column_widths_px.push(px(depth));
        }
        Self {
            columns: column_widths_px.len(),
            column_widths_px,
            row_heights_px: vec![px(axes.up), px(depth)],
            ranges,
        }
    }
}

/// Widens a range about its middle to a least length.
fn widen(range: &mut [f64; 2], least: f64) {
    let lacking = (least - (range[1] - range[0])).max(0.0);
    *range = [range[0] - 0.5 * lacking, range[1] + 0.5 * lacking];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_view_is_right_handed_and_has_the_same_scale() {
        let unit =
            |axis: usize| -> [f64; 3] { std::array::from_fn(|i| f64::from(u8::from(i == axis))) };
        for up in 0..3 {
            let axes = DrawnAxes {
                up,
                front: true,
                ..DrawnAxes::default()
            };
            let [across, depth] = axes.across_and_depth();
            // The viewer from above sees up toward the eye: across × depth = up.
            let [a, b] = [unit(across), unit(depth)];
            let cross: [f64; 3] = std::array::from_fn(|i| {
                let [j, k] = [(i + 1) % 3, (i + 2) % 3];
                a[j] * b[k] - a[k] * b[j]
            });
            assert_eq!(cross, unit(up));
            let points = [[0.0; 3], [1.0, 2.0, 0.5]];
            let layout = ViewLayout::of(&axes, &points, 0.1);
            for (place, view) in axes.views().into_iter().enumerate() {
                let size = [
                    layout.column_widths_px[place % 2],
                    layout.row_heights_px[place / 2],
                ];
                let per_px = [view.across, view.upward].map(|axis| layout.ranges[axis]);
                let [x, y] = [0, 1].map(|i| (per_px[i][1] - per_px[i][0]) / size[i]);
                assert!((x - y).abs() < 1e-12, "{up} {place}");
            }
        }
    }
}
