//! What tests share: a terminal to run the program in, tables of readings, and what is asked of its texts and JSON.

pub(crate) mod expect;
pub(crate) mod screen_picture;
pub(crate) mod tables;
pub(crate) mod terminal;

pub(crate) use expect::{Contains, Json};
