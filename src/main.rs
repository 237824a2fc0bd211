//! The octray command.

fn main() {}
