//! The suites that come along, and the example of the documentation, are sound.

use std::path::Path;

use bendtwin_study::Suite;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

#[test]
fn the_suites_that_come_along_can_be_read() {
    let mut seen = 0;
    for entry in std::fs::read_dir(Path::new(ROOT).join("studies")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            Suite::read(&path).unwrap_or_else(|e| panic!("{e}"));
            seen += 1;
        }
    }
    assert!(seen > 0);
}

#[test]
fn the_documented_example_can_be_read() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/develop/suites.md")).unwrap();
    let example = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("example.json");
    std::fs::write(&file, example).unwrap();
    let suite = Suite::read(&file).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(suite.runs().count(), 12);
}
