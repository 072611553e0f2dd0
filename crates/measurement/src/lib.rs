//! What was measured, and the stiffness that follows from it.
//!
//! - [`readings`]: what was measured, as stored. Acquisition ends by writing a session folder, analysis begins by reading one.
//! - [`load_cases`]: loads and readings as vectors, one load application a row.
//! - [`specimen`]: force against displacement of anything, without a robot.
//! - [`procedure`]: which loads are applied where and in which order, as data.
//! - [`table_files`]: tables as test machines, loggers, spreadsheets and people write them.
//! - [`calibration`]: calibration of a gauge, given beside its readings.
//! - [`import`]: tables of other programs to readings.
//! - [`run_check`]: whether readings agree with their repeats, for sessions and for analysis.
//! - [`stiffness`]: readings to measured stiffness. Contains no model.
//! - [`stiffness_list`]: stiffness values that come without readings.

pub mod calibration;
pub mod import;
pub mod load_cases;
pub mod procedure;
pub mod readings;
pub mod run_check;
pub mod specimen;
pub mod stiffness;
pub mod stiffness_list;
pub mod table_files;
