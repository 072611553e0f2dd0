//! The `stiffbench` command.

fn main() {}
