//! What tests of the program in a terminal share.

pub(crate) mod screen_picture;
pub(crate) mod terminal;
