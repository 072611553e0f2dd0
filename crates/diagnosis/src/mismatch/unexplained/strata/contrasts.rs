//! The contrasts: between which stages of which basis each lies, and what it is tested against.

use super::results::Contrast;

/// Within runs: zeros and slopes of runs are taken out first, so that only the errors of readings are left to compare with.
pub(super) const WITHIN: usize = 0;
/// Between runs: slopes of runs, their zeros taken out.
pub(super) const BETWEEN: usize = 1;
/// Between runs: zeros of runs, their slopes taken out.
pub(super) const OFFSETS: usize = 2;

/// Within runs with the holds last.
const HELD: usize = 3;

/// Stages of the basis within runs. The holds stand first: what a load does under a long hold is no part of its level.
pub(super) mod within {
    pub(crate) const SLOPES: usize = 1;
    pub(crate) const HOLDS: usize = 2;
    pub(crate) const SIGN: usize = 3;
    pub(crate) const CURVES: usize = 4;
    pub(crate) const LEVELS: usize = 5;
    pub(crate) const LOOPS: usize = 6;
    pub(crate) const BRANCHES: usize = 7;
}

/// Stages of the basis with the holds last.
mod held {
    pub(crate) const SLOPES: usize = 1;
    pub(crate) const BRANCHES: usize = 6;
    pub(crate) const HOLDS: usize = 7;
}

/// Stages of the basis of slopes.
pub(super) mod between {
    pub(crate) const ZEROS: usize = 0;
    pub(crate) const CELLS: usize = 1;
    pub(crate) const SIGN: usize = 2;
}

/// Stages of the basis of zeros.
pub(super) mod offsets {
    pub(crate) const SLOPES: usize = 0;
    pub(crate) const CELLS: usize = 1;
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
    pub(super) basis: usize,
    /// Stages without and with the contrast.
    pub(super) stages: [usize; 2],
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
    let slope =
        |contrast, stages, common| plan(contrast, ErrorTerm::RunSlope, BETWEEN, stages, common);
    let pure =
        |contrast, basis, stages, common| plan(contrast, ErrorTerm::Pure, basis, stages, common);
    let within = |contrast, stages| pure(contrast, WITHIN, stages, Common::Clock);
    let sign = if mixed {
        within(Contrast::Sign, [within::HOLDS, within::SIGN])
    } else {
        slope(
            Contrast::Sign,
            [between::CELLS, between::SIGN],
            Common::Repeat,
        )
    };
    vec![
        slope(
            Contrast::CellSlope,
            [between::ZEROS, between::CELLS],
            Common::Model,
        ),
        slope(
            Contrast::Repeat,
            [between::CELLS, between::CELLS],
            Common::Model,
        ),
        plan(
            Contrast::CellOffset,
            ErrorTerm::RunZero,
            OFFSETS,
            [offsets::SLOPES, offsets::CELLS],
            Common::Model,
        ),
        pure(
            Contrast::Clock,
            HELD,
            [held::SLOPES, held::SLOPES],
            Common::Model,
        ),
        sign,
        within(Contrast::Curve, [within::SIGN, within::CURVES]),
        within(Contrast::LoadStep, [within::CURVES, within::LEVELS]),
        within(Contrast::Loop, [within::LEVELS, within::LOOPS]),
        within(Contrast::Branch, [within::LOOPS, within::BRANCHES]),
        pure(
            Contrast::Hold,
            HELD,
            [held::BRANCHES, held::HOLDS],
            Common::Clock,
        ),
    ]
}
