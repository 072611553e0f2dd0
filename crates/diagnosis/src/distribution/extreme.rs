//! The outermost points of a workspace.

/// Reach or height that varies by less than this share of the other is constant: what is left is rounding.
const CONSTANT: f64 = 1e-6;

/// One of the four outermost points that enclose a workspace (the paper's P1 to P4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extreme {
    /// Largest height (P1).
    Highest,
    /// Largest reach (P2).
    Furthest,
    /// Smallest height (P3).
    Lowest,
    /// Smallest reach (P4).
    Nearest,
}

impl Extreme {
    /// All four, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Highest, Self::Furthest, Self::Lowest, Self::Nearest];

    /// What is largest at the point with this reach and height, or these two coordinates of another plane, m.
    #[must_use]
    pub fn of_reach_and_height(self, [reach_m, height_m]: [f64; 2]) -> f64 {
        match self {
            Self::Highest => height_m,
            Self::Furthest => reach_m,
            Self::Lowest => -height_m,
            Self::Nearest => -reach_m,
        }
    }

    /// Those along which points (reach and height, m) differ at all: an end that keeps its height has no highest place.
    pub fn of_points(points: impl Iterator<Item = [f64; 2]>) -> Vec<Self> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let ranges = points.fold([none; 2], |ranges, point| {
            [0, 1].map(|i| [ranges[i][0].min(point[i]), ranges[i][1].max(point[i])])
        });
        let [reach, height] = ranges.map(|[low, high]| high - low);
        let least = CONSTANT * reach.max(height);
        let differs = |extreme: &Self| match extreme {
            Self::Highest | Self::Lowest => height > least,
            Self::Furthest | Self::Nearest => reach > least,
        };
        Self::ALL.into_iter().filter(differs).collect()
    }

    /// What it is called.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Highest => "highest",
            Self::Furthest => "furthest",
            Self::Lowest => "lowest",
            Self::Nearest => "nearest",
        }
    }
}
