//! What is wrong with the data themselves, whatever the physics: bad readings and runs, wrong units, exchanged names, too few readings.
//!
//! Owner: [`ScreenedData`]. It imports `problem` and the rooms below it.

mod bad_readings;
mod bad_runs;
mod cell_compliance;
mod curve_residuals;
mod data_screen;
mod deleted_residuals;
mod lacking;
mod misread;
mod reading_screen;
mod screened;
mod usual_factor;
mod wrong_cells;

pub use data_screen::screen_data;
pub(crate) use lacking::{lacking, lacking_cells, lacking_scatter};
pub(crate) use misread::{
    Exchanged, FoundMistake, NamedValue, RecordedValues, ValueChange, ValueFit, ValueModel,
    ValueName, ValueScale, find_mistake,
};
pub(crate) use reading_screen::{against_repeats, kept};
pub use screened::{BadReading, BadRun, OtherJointValue, ReadQuantity, ScreenedData};
pub(crate) use usual_factor::{misread_factor, usual_factors_of_lengths};
