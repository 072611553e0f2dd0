//! Calibration of a gauge, given beside its readings: an expanded uncertainty, or a table of applied and indicated values.
//!
//! # Source
//! The corrected value is read off the straight lines between the points of the table. EN ISO 376 fits a polynomial of up to third
//! degree instead; lines need no degree, go through each point and never turn back. What both have in common at a point of the
//! certificate is its uncertainty, which is taken as common to all readings of the gauge (JCGM 100:2008, F.1.2.3).

mod curve;

pub use curve::{CalibrationCurve, CalibrationPoint};
