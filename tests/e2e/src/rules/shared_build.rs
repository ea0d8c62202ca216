//! The program has each library with the features that it has beside the tests, so that `cargo build --package
//! bendtwin-cli`, and with it the wheel, compiles nothing that `cargo build --workspace --tests` has compiled.

use std::{collections::BTreeSet, process::Command};

use super::workspace;

#[test]
fn the_program_is_built_of_what_its_tests_are_built_of() {
    let program = libraries(&["--package", "bendtwin-cli", "--edges", "normal,build"]);
    let everything = libraries(&["--workspace", "--edges", "normal,build,dev"]);
    let alone: Vec<_> = program.difference(&everything).collect();
    assert!(
        alone.is_empty(),
        "tests ask for other features of these libraries: {alone:#?}\n\
         `cargo tree --workspace --edges features --invert LIBRARY` shows which; add them to client/cli/Cargo.toml"
    );
}

/// Name, version and features of the libraries of some packages, as cargo unites them.
fn libraries(of: &[&str]) -> BTreeSet<String> {
    let mut tree = Command::new(env!("CARGO"));
    tree.args(["tree", "--locked", "--prefix", "none", "--format", "{p} {f}"])
        .args(of)
        .current_dir(workspace::root());
    let output = tree.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}
