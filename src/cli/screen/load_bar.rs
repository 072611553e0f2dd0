//! The signed bar from no load to the target, with its band.

use crate::session::Band;

/// What a cell of the bar is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BarCell {
    /// Nothing there yet.
    Empty,
    /// Load that is on.
    Load,
    /// Load beyond the band.
    TooMuch,
    /// The band, not reached yet.
    Band,
    /// The band with the load in it.
    BandReached,
    /// No load.
    Zero,
}

/// A bar: its cells, and labels below it by the column they are centred on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LoadBar {
    /// Cells from left to right.
    pub(super) cells: Vec<BarCell>,
    /// Labels with their columns.
    pub(super) labels: Vec<(usize, String)>,
}

/// Room beyond the largest load and on the other side of zero, as a part of the largest load.
const BEYOND: f64 = 0.12;

/// The bar of a force on so many columns; negative loads grow to the left, as the axis does.
pub(super) fn load_bar(band: &Band, force_n: Option<f64>, columns: usize) -> LoadBar {
    let columns = columns.max(8);
    let scale_n = band
        .largest_n
        .abs()
        .max(band.target_n.abs())
        .max(band.tolerance_n)
        .max(1e-9);
    let negative = band.target_n < 0.0 || (band.target_n == 0.0 && band.from_n < 0.0);
    let reach = [-BEYOND * scale_n, (1.0 + BEYOND) * scale_n];
    // A preload or a zero may be left with the load still on the other side.
    let [low_n, high_n] = if negative {
        [-reach[1], -reach[0]]
    } else {
        reach
    };
    let column = |n: f64| {
        let share = ((n - low_n) / (high_n - low_n)).clamp(0.0, 1.0);
        (share * (columns - 1) as f64).round() as usize
    };
    let zero = column(0.0);
    let band_columns = [
        column(band.target_n - band.tolerance_n),
        column(band.target_n + band.tolerance_n),
    ];
    let load = force_n.map(column);
    let cells = (0..columns).map(|at| {
        let in_band = band_columns[0] <= at && at <= band_columns[1];
        let loaded = load.is_some_and(|load| between(at, zero, load));
        match (in_band, loaded) {
            (true, _) if band.inside => BarCell::BandReached,
            (true, true) => BarCell::BandReached,
            (true, false) => BarCell::Band,
            (false, true) if between(column(band.target_n), zero, at) && at != zero => {
                BarCell::TooMuch
            }
            (false, true) if at != zero => BarCell::Load,
            (false, _) if at == zero => BarCell::Zero,
            (false, _) => BarCell::Empty,
        }
    });
    let mut labels = vec![(zero, "0".to_owned())];
    if band.target_n != 0.0 {
        labels.push((column(band.target_n), format!("{:.1} N", band.target_n)));
    }
    LoadBar {
        cells: cells.collect(),
        labels,
    }
}

/// Whether `at` lies between two columns, both counted.
fn between(at: usize, one: usize, other: usize) -> bool {
    one.min(other) <= at && at <= one.max(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: Band = Band {
        target_n: -30.0,
        tolerance_n: 1.0,
        from_n: -20.0,
        largest_n: 70.0,
        inside: false,
        overshoot_n: 0.0,
    };

    fn drawn(band: &Band, force_n: Option<f64>) -> String {
        let glyph = |cell: &BarCell| match cell {
            BarCell::Empty => '.',
            BarCell::Load => '=',
            BarCell::TooMuch => '!',
            BarCell::Band => 'o',
            BarCell::BandReached => '#',
            BarCell::Zero => '|',
        };
        load_bar(band, force_n, 44)
            .cells
            .iter()
            .map(glyph)
            .collect()
    }

    #[test]
    fn load_grows_from_zero_toward_the_band_and_past_it() {
        // -78.4 to 8.4 N on 44 columns: two newtons a column, zero at column 39, the band from 23.5 to 24.5.
        let none = drawn(&BAND, None);
        assert_eq!(none.find('|'), Some(39), "{none}");
        assert_eq!(none.find('o'), Some(23), "{none}");
        assert_eq!(none.matches('o').count(), 2, "{none}");
        assert!(drawn(&BAND, Some(-20.0)).ends_with(".==========|...."));
        let past = drawn(&BAND, Some(-40.0));
        assert_eq!(past.matches('!').count(), 4, "{past}");
        assert_eq!(past.matches('=').count(), 14, "{past}");
        let inside = Band {
            inside: true,
            ..BAND
        };
        assert!(drawn(&inside, Some(-30.2)).contains("##"));
    }

    #[test]
    fn a_load_against_a_positive_target_stands_left_of_zero() {
        let band = Band {
            target_n: 30.0,
            from_n: 0.0,
            ..BAND
        };
        let bar = drawn(&band, Some(-5.0));
        let zero = bar.find('|').unwrap();
        assert!(bar[..zero].contains('='), "{bar}");
    }

    #[test]
    fn no_width_and_no_number_breaks_it() {
        let broken = Band {
            target_n: 0.0,
            tolerance_n: 0.0,
            largest_n: 0.0,
            ..BAND
        };
        for columns in 0..20 {
            for force_n in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
                assert!(load_bar(&broken, Some(force_n), columns).cells.len() >= 8);
            }
        }
    }
}
