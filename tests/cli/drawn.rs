//! Numbers read off a figure again: ticks and marks of its SVG.

/// A frame with an axis at its left and marks inside.
#[derive(Debug)]
pub(super) struct Panel {
    /// Two opposite corners, px.
    frame: [(f64, f64); 2],
    /// Place, px, and value of each labelled tick.
    ticks: Vec<(f64, f64)>,
    /// Centres of marks, px, from left to right.
    marks: Vec<(f64, f64)>,
}

/// The panels of a figure, from the top down.
pub(super) fn panels(svg: &str) -> Vec<Panel> {
    let mut panels: Vec<Panel> = svg.lines().filter_map(framed).collect();
    let mut tick = None;
    for (line, label) in svg.lines().zip(svg.lines().skip(1)) {
        if line.starts_with("<line") {
            let [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map(|key| number(line, key));
            // A labelled tick points 40 px to the left.
            tick = (y1 == y2 && x1 - x2 == 40.0).then_some((x1, y1));
        } else if line.starts_with("<text") {
            if let Some(at) = tick.take()
                && let Ok(value) = label.replace('−', "-").parse()
                && let Some(panel) = panels.iter_mut().find(|panel| panel.holds(at))
            {
                panel.ticks.push((at.1, value));
            }
        } else if let Some(mark) = centre(line)
            && let Some(panel) = panels.iter_mut().find(|panel| panel.holds(mark))
            && !panel.marks.contains(&mark)
        {
            panel.marks.push(mark);
        }
    }
    for panel in &mut panels {
        panel.marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    panels
}

impl Panel {
    fn holds(&self, (x, y): (f64, f64)) -> bool {
        let [(left, top), (right, bottom)] = self.frame;
        (left..=right).contains(&x) && (top..=bottom).contains(&y)
    }

    /// Holds the marks against values, to one and a half pixels. `scale` is what the axis is even in.
    pub(super) fn assert_shows(&self, values: &[f64], scale: fn(f64) -> f64) {
        let ((low, from), (high, to)) = (self.ticks[0], self.ticks[self.ticks.len() - 1]);
        let px = |value: f64| {
            low + (scale(value) - scale(from)) / (scale(to) - scale(from)) * (high - low)
        };
        assert_eq!(self.marks.len(), values.len(), "{self:?}");
        for ((_, drawn), value) in self.marks.iter().zip(values) {
            // Ticks and marks are each rounded to a pixel.
            let off = (drawn - px(*value)).abs();
            assert!(off <= 1.5, "{value} is drawn {off} px off: {self:?}");
        }
    }
}

/// A frame is a closed line of four corners.
fn framed(line: &str) -> Option<Panel> {
    let corners = points(line.strip_prefix("<polyline")?);
    let is_closed = corners.len() == 5 && corners[0] == corners[4];
    is_closed.then(|| Panel {
        frame: [corners[0], corners[2]],
        ticks: Vec::new(),
        marks: Vec::new(),
    })
}

/// The middle of a circle or square.
fn centre(line: &str) -> Option<(f64, f64)> {
    if line.starts_with("<circle") && number(line, "r") > 30.0 {
        return Some((number(line, "cx"), number(line, "cy")));
    }
    let corners = points(line.strip_prefix("<polygon")?);
    let mean =
        |of: fn(&(f64, f64)) -> f64| corners.iter().map(of).sum::<f64>() / corners.len() as f64;
    (corners.len() == 4).then(|| (mean(|point| point.0), mean(|point| point.1)))
}

fn points(line: &str) -> Vec<(f64, f64)> {
    let point = |point: &str| {
        let (x, y) = point.split_once(',')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    };
    let listed = attribute(line, "points").unwrap_or_default();
    listed.split_whitespace().filter_map(point).collect()
}

fn number(line: &str, key: &str) -> f64 {
    let value = attribute(line, key).and_then(|digits| digits.parse().ok());
    value.unwrap_or(f64::NAN)
}

fn attribute<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    line.split(&format!(" {key}=\"")).nth(1)?.split('"').next()
}
