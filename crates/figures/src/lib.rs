//! Results drawn as figures: SVG text, and PNG from the same SVG. No files are touched here.
//!
//! Every figure of the program is a [`Figure`]: panels with axes, series of marks in them, a legend above the panels that can
//! never lie on data, and a caption below that states what the bars are and how many readings a point has. Each file of this
//! module after the general ones is one figure: a plain struct of numbers in SI units, and a function that makes it a [`Figure`].
//!
//! Invariants. The same input gives the same bytes. A flagged reading is drawn hollow, never left out, and what cannot be placed on
//! the axes is counted in the caption. Two sessions differ in shape and in colour; all colours are distinguished in grey or have numbers
//! beside them. Texts are measured with the font that is embedded for PNG.

mod before_after;
mod bent_beam;
mod canvas;
mod caption;
mod colour_scale;
mod contour;
mod correlation;
mod detection_limits;
mod evidence;
mod factor_intervals;
mod factor_shift;
mod figure;
mod font;
mod found_law;
mod hatching;
mod held_out_error;
mod labels;
mod layout;
mod load_case_components;
mod load_case_residuals;
mod load_displacement;
mod marks;
mod misfit_shares;
mod mismatch_map;
mod palette;
mod plane_bins;
mod plane_map;
mod plane_panel;
mod png;
mod power_curves;
mod quantities;
mod range;
#[cfg(test)]
mod reading;
mod render;
mod residuals;
mod robot_drawing;
mod robot_pose;
mod robot_views;
mod stiffness_comparison;
mod surface_panel;
mod text_room;
mod ticks;
mod value_table;

pub use before_after::{
    BeforeAfterPoint, ResidualsAgainst, ResidualsBeforeAfter, residuals_before_after,
};
pub use caption::Bar;
pub use correlation::{Correlation, correlation};
pub use detection_limits::{DetectionLimitBar, DetectionLimits, detection_limits};
pub use evidence::{CandidateDecision, EvidenceBars, EvidenceCandidate, evidence_bars};
pub use factor_intervals::{DrawnFactor, FactorFate, FactorIntervals, factor_intervals};
pub use factor_shift::{FactorShift, FactorValue, ShiftedFactor, factor_shift};
pub use figure::{
    Axis, AxisScale, Figure, FigureNote, FigurePoint, LegendEntry, LegendMark, Marks,
    NotePlacement, Panel, Polygon, Series, Sharing, Style,
};
pub use found_law::{
    CurveShape, DrivingQuantity, FoundLaw, LawCurve, LawPanel, LawPoint, found_law,
};
pub use held_out_error::{HeldOutError, HeldOutPose, held_out_error};
pub use load_case_components::{ComponentPoint, LoadCaseComponents, load_case_components};
pub use load_case_residuals::{LoadCaseResiduals, ResidualVector, load_case_residuals};
pub use load_displacement::{
    DisplacementPoint, FittedLine, LoadCurvePoints, LoadDisplacement, MarkedPoints, SessionCurves,
    load_displacement,
};
pub use misfit_shares::{MisfitWaterfall, WaterfallStep, misfit_waterfall};
pub use mismatch_map::{MapLoadStep, MapValue, MismatchMap, RunSummary, mismatch_map};
pub use palette::{Colour, Marker, QUALITATIVE, diverging, lightening, qualitative, sequential};
pub use plane_bins::{BinValue, PlaneBin, PlaneBins};
pub use plane_map::{
    PlaneMapDifference, PlaneMapFigure, plane_map, plane_map_difference, plane_map_sheet,
};
pub use plane_panel::{NamedPoint, PlaneMap, ValueAt};
pub use png::to_png;
pub use power_curves::{LawPower, PowerAtSize, PowerCurves, Rate, power_curves};
pub use quantities::{AxisQuantity, Quantities};
pub use residuals::{ResidualMeasure, ResidualPoint, Residuals, residuals};
pub use robot_drawing::{DrawnJoint, DrawnKind, DrawnMember, DrawnNode, RobotDrawing};
pub use robot_pose::robot_pose;
pub use robot_views::DrawnAxes;
pub use stiffness_comparison::{ComparedCell, StiffnessComparison, stiffness_comparison};

/// Why a figure could not become an image.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PlotError {
    /// The text is not SVG.
    #[error("the text is not an SVG figure")]
    #[diagnostic(
        code(stiffbench::plot::svg),
        help("give the text of an .svg file as this program writes it")
    )]
    Svg {
        /// The error of the parser.
        source: resvg::usvg::Error,
    },
    /// The image would have no pixels, or too many.
    #[error("at scale {scale} the image would be {width_px} by {height_px} pixels")]
    #[diagnostic(
        code(stiffbench::plot::scale),
        help("choose a scale between 0.1 and 10; both sides must lie between 1 and 16384 pixels")
    )]
    Scale {
        /// Image pixels per pixel of the figure.
        scale: f64,
        /// Width that follows, pixels.
        width_px: f64,
        /// Height that follows, pixels.
        height_px: f64,
    },
    /// The image could not be encoded.
    #[error("the image could not be encoded as PNG: {reason}")]
    #[diagnostic(code(stiffbench::plot::png))]
    Png {
        /// The error of the encoder.
        reason: String,
    },
}
