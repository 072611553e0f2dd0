//! The contrasts: between which stages of which basis each lies, and what it is tested against.

use super::results::Contrast;

/// Which columns of cells are taken out one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    /// Within runs: zeros and slopes of runs are taken out first, so that only the errors of readings are left to compare with. The holds stand
    /// next: what a load does under a long hold is no part of its level.
    Within,
    /// Between runs: slopes of runs, their zeros taken out.
    Between,
    /// Between runs: zeros of runs, their slopes taken out.
    Offsets,
    /// Within runs with the holds last.
    Held,
}

/// Columns of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Its zeros, and what the force gauge errs in its steps.
    Zeros,
    /// The slope of each of its runs.
    RunSlopes,
    /// Its slope.
    Slope,
    /// Its zero.
    Offset,
    /// Each later reading of a hold, by level, branch and its number.
    Holds,
    /// The slope of pull against that of push.
    Sign,
    /// Curves of the force as it was: the loads of a level differ by what the jack left.
    Curves,
    /// Levels of load.
    Levels,
    /// The unloading branch as a whole.
    Loops,
    /// Each level on the unloading branch.
    Branches,
}

impl Basis {
    pub(super) const ALL: [Self; 4] = [Self::Within, Self::Between, Self::Offsets, Self::Held];

    /// Its stages, each beyond those before it.
    pub(super) fn stages(self) -> &'static [Stage] {
        match self {
            Self::Within => &[
                Stage::Zeros,
                Stage::RunSlopes,
                Stage::Holds,
                Stage::Sign,
                Stage::Curves,
                Stage::Levels,
                Stage::Loops,
                Stage::Branches,
            ],
            Self::Between => &[Stage::Zeros, Stage::Slope, Stage::Sign],
            Self::Offsets => &[Stage::RunSlopes, Stage::Offset],
            Self::Held => &[
                Stage::Zeros,
                Stage::RunSlopes,
                Stage::Sign,
                Stage::Curves,
                Stage::Levels,
                Stage::Loops,
                Stage::Branches,
                Stage::Holds,
            ],
        }
    }

    /// How many of its stages stand before one.
    pub(super) fn before(self, stage: Stage) -> usize {
        self.stages()
            .iter()
            .take_while(|one| **one != stage)
            .count()
    }
}

/// What a contrast is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ErrorTerm {
    /// Slopes of runs within their cell.
    RunSlope,
    /// Zeros of runs within their cell.
    RunZero,
    /// Readings within their run and level.
    Pure,
}

impl ErrorTerm {
    /// Why there is nothing to compare with.
    pub(super) fn when_absent(self) -> &'static str {
        match self {
            Self::RunSlope => {
                "no load sequence was repeated: the scatter of slopes between runs is not known"
            }
            Self::RunZero => {
                "the gauge was zeroed once in each pose and direction: the scatter of its zeros is not known"
            }
            Self::Pure => "no reading was repeated under the same load: the scatter is not known",
        }
    }
}

/// Global columns taken out before a contrast.
#[derive(Clone, Copy)]
pub(super) enum Common {
    Model,
    Clock,
    Repeat,
}

/// A contrast before its spaces are computed.
pub(super) struct Plan {
    pub(super) contrast: Contrast,
    pub(super) error: ErrorTerm,
    pub(super) basis: Basis,
    /// Stages without and with the contrast.
    pub(super) stages: [Stage; 2],
    pub(super) common: Common,
}

/// All contrasts, each beyond those before it in the same basis. The clock stands before the load and its branches: a drift has one rate
/// in all cells, which a loop or a curve has not.
pub(super) fn plans(mixed: bool) -> Vec<Plan> {
    let plan = |contrast, error, basis, stages, common| Plan {
        contrast,
        error,
        basis,
        stages,
        common,
    };
    let slope = |contrast, stages, common| {
        plan(
            contrast,
            ErrorTerm::RunSlope,
            Basis::Between,
            stages,
            common,
        )
    };
    let pure =
        |contrast, basis, stages, common| plan(contrast, ErrorTerm::Pure, basis, stages, common);
    let within = |contrast, stages| pure(contrast, Basis::Within, stages, Common::Clock);
    let sign = if mixed {
        within(Contrast::Sign, [Stage::Holds, Stage::Sign])
    } else {
        slope(Contrast::Sign, [Stage::Slope, Stage::Sign], Common::Repeat)
    };
    vec![
        slope(
            Contrast::CellSlope,
            [Stage::Zeros, Stage::Slope],
            Common::Model,
        ),
        slope(Contrast::Repeat, [Stage::Slope; 2], Common::Model),
        plan(
            Contrast::CellOffset,
            ErrorTerm::RunZero,
            Basis::Offsets,
            [Stage::RunSlopes, Stage::Offset],
            Common::Model,
        ),
        pure(
            Contrast::Clock,
            Basis::Held,
            [Stage::RunSlopes; 2],
            Common::Model,
        ),
        sign,
        within(Contrast::Curve, [Stage::Sign, Stage::Curves]),
        within(Contrast::LoadStep, [Stage::Curves, Stage::Levels]),
        within(Contrast::Loop, [Stage::Levels, Stage::Loops]),
        within(Contrast::Branch, [Stage::Loops, Stage::Branches]),
        pure(
            Contrast::Hold,
            Basis::Held,
            [Stage::Branches, Stage::Holds],
            Common::Clock,
        ),
    ]
}
