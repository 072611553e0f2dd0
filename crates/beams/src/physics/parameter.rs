//! Parameters of laws: which values they may have, where a fit starts, how it moves them.

use super::dimension::Dimension;
use super::place::Place;
use super::search::PlaceScale;

/// Which values physics allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignConstraint {
    /// Not below zero.
    Positive,
    /// Above zero: the law divides by it.
    AboveZero,
    /// Either sign.
    Either,
}

impl SignConstraint {
    /// Which values are allowed, in words.
    #[must_use]
    pub fn in_words(self) -> &'static str {
        match self {
            Self::AboveZero => "above zero",
            Self::Positive => "not below zero",
            Self::Either => "of either sign",
        }
    }

    /// Whether a value is allowed; none is that is not finite.
    #[must_use]
    pub fn allows(self, value: f64) -> bool {
        let allowed = match self {
            Self::AboveZero => value > 0.0,
            Self::Positive => value >= 0.0,
            Self::Either => true,
        };
        value.is_finite() && allowed
    }
}

/// Values that an engineer would accept, and why no others.
#[derive(Debug, Clone, Copy)]
pub struct PlausibleRange {
    /// Smallest and largest value at a place, SI; of a parameter fitted as a ratio, of that ratio.
    ///
    /// # Arguments
    /// - The scales of the place.
    /// - The values at which a fit starts, in the order of the parameters.
    pub bounds: fn(&PlaceScale, &[f64]) -> [f64; 2],
    /// The range in words, with its reason.
    pub reason: &'static str,
}

/// How a fit moves a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FitBy {
    /// By derivatives, from differences over this share of the value.
    Derivative {
        /// Step of the difference, as a share of the value.
        relative_step: f64,
    },
    /// By derivatives, from differences over this step: for values that may be anything, as a phase.
    FixedStep {
        /// Step of the difference, SI.
        step: f64,
    },
    /// By derivatives, from differences over a share of the plausible range: for values that may be zero.
    ShareOfRange {
        /// Step of the difference, as a share of the range.
        share: f64,
    },
    /// By derivatives of its ratio to the first parameter, which takes it along.
    RatioToFirst,
    /// By trial, for readings depend on it by kinks and steps.
    Search,
    /// Not at all: another parameter refers to it.
    Reference,
}

/// Step of the difference of a parameter that is a size.
pub(super) const OF_A_SIZE: FitBy = FitBy::Derivative {
    relative_step: 1e-3,
};

/// Step of the difference of a parameter that may be zero.
pub(super) const OVER_RANGE: FitBy = FitBy::ShareOfRange { share: 5e-4 };

/// A value in the middle of what is met in practice, and how far others lie from it.
#[derive(Debug, Clone, Copy)]
pub struct Typical {
    /// The value at a place, SI.
    pub value: fn(&PlaceScale) -> f64,
    /// Others lie within this factor of it, either way; not a number where any value is as likely.
    pub spread: f64,
}

/// One parameter of a law.
#[derive(Debug, Clone, Copy)]
pub struct ParameterSpec {
    /// Name in files.
    pub name: &'static str,
    /// Name in sentences.
    pub word: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// Values that physics allows.
    pub sign: SignConstraint,
    /// Values that are plausible; every fit keeps to them.
    pub plausible: PlausibleRange,
    /// A typical value; of a size a very small one, to be scaled up.
    pub typical: Typical,
    /// How a fit moves it.
    pub fit: FitBy,
}

impl ParameterSpec {
    /// Unit in files, which is SI.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// The parameter of the law at a place: of a joint that slides in units of translation.
    #[must_use]
    pub fn at(&self, place: &Place) -> Self {
        match place {
            Place::Slide(_) => Self {
                dimension: self.dimension.of_slide(),
                ..*self
            },
            _ => *self,
        }
    }

    /// Whether a fit moves it by derivatives.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        !self.is_searched() && !self.is_reference()
    }

    /// Whether a fit finds it by trial.
    #[must_use]
    pub fn is_searched(&self) -> bool {
        self.fit == FitBy::Search
    }

    /// Whether another parameter refers to it, so that no fit moves it.
    #[must_use]
    pub fn is_reference(&self) -> bool {
        self.fit == FitBy::Reference
    }

    /// Whether a fit moves it as its ratio to the first parameter.
    #[must_use]
    pub fn is_ratio(&self) -> bool {
        self.fit == FitBy::RatioToFirst
    }
}
