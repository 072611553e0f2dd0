//! A screen of a terminal as an SVG picture, for documentation.

use std::fmt::Write;

/// Size of a character cell.
const CELL: (f64, f64) = (8.0, 17.0);

/// Draws a screen with its colours: one text element a run of equal style, so that letters stay text.
pub(crate) fn svg(screen: &vt100::Screen) -> String {
    let (rows, columns) = screen.size();
    let (rows, columns) = (rows.get(), columns.get());
    let (width, height) = (
        f64::from(columns) * CELL.0 + 20.0,
        f64::from(rows) * CELL.1 + 20.0,
    );
    let mut picture = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         <rect width=\"{width}\" height=\"{height}\" rx=\"6\" fill=\"#16181d\"/>\n\
         <g font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"13\" xml:space=\"preserve\">\n"
    );
    for row in 0..rows {
        for column in 0..columns {
            let Some(cell) = screen.cell(row, column) else {
                continue;
            };
            let text = cell.contents();
            let blank = text.trim().is_empty();
            if blank && !cell.inverse() {
                continue;
            }
            let (x, y) = (
                10.0 + f64::from(column) * CELL.0,
                10.0 + f64::from(row) * CELL.1,
            );
            let ink = colour(cell.fgcolor());
            // Bars and borders are drawn, so that they meet whatever the font.
            if cell.inverse() || text == "█" {
                let _ = writeln!(
                    picture,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"{ink}\"/>",
                    CELL.0 + 0.3,
                    CELL.1 + 0.3
                );
            }
            if blank || text == "█" {
                continue;
            }
            let fill = if cell.inverse() { "#16181d" } else { ink };
            let weight = if cell.bold() {
                " font-weight=\"bold\""
            } else {
                ""
            };
            let dim = if cell.dim() { " opacity=\"0.6\"" } else { "" };
            let text = text.replace('&', "&amp;").replace('<', "&lt;");
            let _ = writeln!(
                picture,
                "<text x=\"{x}\" y=\"{}\" fill=\"{fill}\"{weight}{dim}>{text}</text>",
                y + 13.0
            );
        }
    }
    picture + "</g>\n</svg>\n"
}

fn colour(colour: vt100::Color) -> &'static str {
    match colour {
        vt100::Color::Idx(3 | 11) => "#e6c34a",
        vt100::Color::Idx(6 | 14) => "#4fc3d9",
        vt100::Color::Idx(1 | 9) => "#ff7b72",
        _ => "#e6e6e6",
    }
}
