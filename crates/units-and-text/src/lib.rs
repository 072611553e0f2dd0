//! Words and units that every other crate shares.
//!
//! - [`quantity`]: units where bytes, files and people enter;
//! - [`test_point`]: where in the experiment a number belongs: pose, direction, branch;
//! - [`load_direction`]: a load along a base axis or any unit vector;
//! - [`read_axis`]: a displacement along an axis or a rotation about one;
//! - [`source_text`]: texts whose errors have places;
//! - [`toml_text`]: TOML with the place of every key and value;
//! - [`count`]: counts in words;
//! - [`digits`]: numbers with so many digits;
//! - [`nearest`]: the name that was meant;
//! - [`clock`]: time, which a test can make its own.

pub mod clock;
pub mod count;
pub mod digits;
pub mod load_direction;
pub mod nearest;
pub mod quantity;
pub mod read_axis;
pub mod source_text;
pub mod test_point;
pub mod toml_text;
