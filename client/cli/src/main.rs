//! The `bendtwin` command.
fn main() {}
