//! `bendtwin-lab suite`: a suite that is killed in the middle, resumed, and ends in the same table as an undisturbed one.
//! Each of its runs can be repeated by the command in its record, which is one of `bendtwin`.

use std::{
    path::Path,
    process::{Child, Output, Stdio},
    time::Duration,
};

use bendtwin_harness::{
    command::{bendtwin, binary, isolated},
    until,
};
use serde_json::Value;

/// Fits of about a second, two at a time; one configuration has too few substeps for any capture.
const SUITE: &str = r#"{
    "version": 1,
    "captures": [{"name": "rope", "path": "rope.zip"}, {"name": "cable", "path": "cable.zip"}],
    "base": {
        "graph": {"max_nodes": 24},
        "search": {"starts": 1, "generations": 60, "population": 8},
        "refine": {"passes": 60}
    },
    "configurations": [
        {"name": "axial", "settings": {"bending": false}},
        {"name": "bending"},
        {"name": "hopeless", "settings": {"substeps": {"fixed": 1}, "graph": {"radius_m": 0.03}}}
    ],
    "compare": [{"of": "bending", "against": "axial"}]
}"#;
const SUITE_ARGUMENTS: [&str; 10] = [
    "suite",
    "suite.json",
    "--data",
    "data",
    "--out",
    "out",
    "--backend",
    "cpu",
    "--checkpoint-every",
    "0",
];
const DEADLINE: Duration = Duration::from_secs(120);

fn start(place: &Path) -> Child {
    let mut command = isolated(env!("CARGO_BIN_EXE_bendtwin-lab"));
    command.args(SUITE_ARGUMENTS).current_dir(place);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn prepare(place: &Path) {
    let data = place.join("data");
    std::fs::create_dir(&data).unwrap();
    // One is what cameras recorded, the other points that were tracked already.
    for (scene, how) in [("rope", Some("--raw")), ("cable", None)] {
        let file = format!("{scene}.zip");
        let made = bendtwin()
            .args(["capture", "make", scene, &file, "--tiny"])
            .args(how)
            .current_dir(&data)
            .output()
            .unwrap();
        assert!(made.status.success(), "{made:?}");
    }
    std::fs::write(place.join("suite.json"), SUITE).unwrap();
}

/// The tables of a suite without times, which are in the last column.
fn tables(place: &Path) -> (Value, String) {
    let read = |name: &str| std::fs::read_to_string(place.join("out").join(name)).unwrap();
    let mut json: Value = serde_json::from_str(&read("table.json")).unwrap();
    for part in ["rows", "means"] {
        for row in json[part].as_array_mut().unwrap() {
            row.as_object_mut().unwrap().remove("fit_s");
        }
    }
    let timeless = |line: &str| match line.rsplit_once(" | ") {
        Some((rest, _)) => rest.to_owned(),
        None => line.to_owned(),
    };
    (json, read("table.md").lines().map(timeless).collect::<Vec<_>>().join("\n"))
}

fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .flat_map(|e| if e.path().is_dir() { files(&e.path()) } else { vec![e.path()] })
        .collect()
}

/// Records get their name when they are complete; a file that a killed process was writing has
/// another name.
fn is_record(file: &&std::path::PathBuf) -> bool {
    file.extension().is_some_and(|e| e == "json")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn ended_with_failures(output: &Output) {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("failed: see out/table.md for the reasons"), "{errors}");
}

#[tokio::test]
async fn a_suite_that_was_killed_ends_in_the_same_table() {
    let peace = tempfile::tempdir().unwrap();
    let war = tempfile::tempdir().unwrap();
    prepare(peace.path());
    prepare(war.path());
    let undisturbed = start(peace.path()).wait_with_output().unwrap();
    ended_with_failures(&undisturbed);
    let (table, markdown) = tables(peace.path());
    assert_eq!(table["rows"].as_array().unwrap().len(), 2 * 5 + 1 - missing(&table));
    assert!(markdown.contains("`rope/hopeless/0` (NO_STABLE_CANDIDATE)"), "{markdown}");
    assert!(text(&undisturbed.stdout).contains("bending against axial"));

    // Killed as soon as one run is done and another is under way.
    let mut child = start(war.path());
    until("a suite that is half done", DEADLINE, async || {
        let done = files(&war.path().join("out/runs")).iter().filter(is_record).count();
        let begun = files(&war.path().join("out/checkpoints")).len();
        (done > 0 && begun > 0).then_some(())
    })
    .await;
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!war.path().join("out/table.json").exists(), "it had ended already");
    let output = start(war.path()).wait_with_output().unwrap();
    ended_with_failures(&output);
    let progress = text(&output.stderr);
    assert!(
        progress.contains("resumes") && !progress.contains(" 0 are done already"),
        "{progress}"
    );
    assert_eq!(tables(war.path()), (table, markdown));

    // A third start has nothing to do.
    let output = start(war.path()).wait_with_output().unwrap();
    assert!(text(&output.stderr).contains("  0 runs"), "{}", text(&output.stderr));
    runs_name_commands_that_make_them_again(war.path());
}

/// A capture that has no twin under a configuration has no row for it, and no last residual.
fn missing(table: &Value) -> usize {
    let failures = table["failures"].as_array().unwrap();
    assert!(failures.iter().all(|f| f["run"]["configuration"] == "hopeless"), "{failures:?}");
    failures.len()
}

fn runs_name_commands_that_make_them_again(place: &Path) {
    let record = std::fs::read(place.join("out/runs/cable/bending/0.json")).unwrap();
    let record: Value = serde_json::from_slice(&record).unwrap();
    let command = record["command"].as_str().unwrap();
    let words = command.strip_prefix("bendtwin ").unwrap();
    let output = std::process::Command::new("sh")
        .args(["-c", &format!("'{}' {words} --json", binary().display())])
        .current_dir(place)
        .output()
        .unwrap();
    assert!(output.status.success(), "{command}: {}", text(&output.stderr));
    let again: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(again["quality"], record["outcome"]["finished"]["quality"], "{command}");
}
