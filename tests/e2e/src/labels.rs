//! A lab that keeps order: names, notes and tags, lists that are searched and sorted, fits that are
//! compared, and a fit that continues when its client is gone.

use std::{
    io::{BufRead as _, BufReader, Read as _},
    process::{Command, Stdio},
};

use serde_json::Value;

use crate::harness::{
    TestCluster,
    command::{bendtwin, run, run_json, run_ok},
    reference::{ENDLESS, SETTINGS},
};

fn text(value: &Value, field: &str) -> String {
    let found = value[field].as_str();
    found.unwrap_or_else(|| panic!("no `{field}` in {value}")).to_owned()
}

fn names(list: &Value) -> Vec<String> {
    list.as_array().unwrap().iter().map(|item| text(item, "display_name")).collect()
}

#[tokio::test]
async fn fits_are_named_tagged_searched_and_compared() {
    let server = TestCluster::ordinary().await;
    let (url, archive, settings) =
        (server.url(), server.path("rope.zip"), server.path("settings.json"));
    std::fs::write(&settings, SETTINGS).unwrap();
    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        let json = |arguments: &[&str]| run_json(&[arguments, &at[..]].concat());
        let ok = |arguments: &[&str]| run_ok(&[arguments, &at[..]].concat());
        ok(&["capture", "make", "rope", &archive]);
        let pushed = json(&["capture", "push", &archive, "--recorded-by", "Ada"]);
        assert_eq!(pushed["recorded_by"], "Ada", "{pushed}");
        let capture = text(&pushed, "name");
        assert!(ok(&["capture", "show", &capture]).contains("  recorded by Ada\n"));
        ok(&["capture", "edit", &capture, "--recorded-by", "Grace"]);
        assert_eq!(names(&json(&["capture", "list", "--recorded-by", "Grace"])), ["rope"]);
        assert!(names(&json(&["capture", "list", "--recorded-by", "Ada"])).is_empty());
        let edit = ["capture", "edit", &capture, "--name", "blue rope", "--note", "Left hand"];
        let edited = json(&[&edit[..], &["--tag", "+wet", "--tag", "+long"]].concat());
        assert_eq!(edited["tags"].as_array().unwrap().len(), 2, "{edited}");
        ok(&["capture", "edit", &capture, "--tag", "-long"]);
        assert_eq!(names(&json(&["capture", "list", "--search", "LEFT"])), ["blue rope"]);
        assert!(names(&json(&["capture", "list", "--tag", "long"])).is_empty());
        assert!(ok(&["capture", "list", "--tag", "wet"]).contains("blue rope [wet]"));

        let start = ["fit", "start", &capture, "--settings", &settings, "--watch"];
        let soft = [&start[..], &["--name", "soft", "--axial"]].concat();
        let watched = run(&[&soft[..], &at[..]].concat());
        let shown = String::from_utf8(watched.stderr).unwrap();
        assert!(watched.status.success(), "{shown}");
        let soft = shown.lines().next().unwrap().to_owned();
        assert!(soft.starts_with("fits/"), "a fit that is watched is named: {shown}");
        let both = |line: &str| line.contains("bending ") && line.contains("axial ");
        assert!(shown.lines().any(both), "both models are shown: {shown}");
        let other = json(&[&start[..], &["--set", "seed=5"]].concat());
        assert_eq!(text(&other, "display_name"), "blue rope", "a fit has its capture's name");
        let other = text(&other, "name");

        let shown = ok(&["fit", "show", &soft]);
        for part in ["soft", "(blue rope)", "*  seed", "graph.max_nodes", "refine  axial", "track"]
        {
            assert!(shown.contains(part), "no {part} in\n{shown}");
        }
        let shown = json(&["fit", "show", &soft]);
        let curves = shown["losses"].as_array().unwrap();
        let curve = |stage: &str, variant: &str| {
            let found = curves.iter().find(|c| c["stage"] == stage && c["variant"] == variant);
            found.unwrap_or_else(|| panic!("no {stage} {variant} in {shown}"))
        };
        for variant in ["bending", "axial"] {
            for (stage, iterations) in [("search", 12), ("refine", 24)] {
                let iterations: Vec<u32> = (1..=iterations).collect();
                assert_eq!(curve(stage, variant)["iterations"], serde_json::json!(iterations));
            }
        }
        let compared = ok(&["fit", "compare", &soft, &other]);
        for part in ["seed", "compare_axial", "best losses", "track future"] {
            assert!(compared.contains(part), "no {part} in\n{compared}");
        }
        let judged = ["is nearest on", "no difference beyond"].map(|part| compared.contains(part));
        assert_ne!(judged, [false; 2], "{compared}");
        let compared = json(&["fit", "compare", &soft, &other]);
        assert_eq!(compared["fits"].as_array().unwrap().len(), 2, "{compared}");

        let fits = json(&["fit", "list", "--sort", "error", "--state", "succeeded"]);
        let error = |fit: &Value| fit["error_m"].as_f64().unwrap();
        let errors: Vec<f64> = fits.as_array().unwrap().iter().map(error).collect();
        assert!(errors.len() == 2 && errors[0] <= errors[1], "{fits}");
        let twin = text(&shown, "twin");
        ok(&["twin", "edit", &twin, "--name", "A soft one", "--tag", "best"]);
        assert_eq!(names(&json(&["twin", "list", "--sort", "name"])), ["A soft one", "blue rope"]);
        let listed = ok(&["twin", "list", "--tag", "best"]);
        assert!(listed.contains(" mm ") && !listed.contains("blue rope"), "{listed}");
        let refused = run(&[&["twin", "edit", &twin, "--tag", "two words"], &at[..]].concat());
        assert!(String::from_utf8_lossy(&refused.stderr).contains("letters, digits"));
    })
    .await
    .unwrap();
}

#[tokio::test]
async fn a_fit_continues_without_watchers() {
    let server = TestCluster::ordinary().await;
    let (url, archive, settings) =
        (server.url(), server.path("rope.zip"), server.path("endless.json"));
    std::fs::write(&settings, ENDLESS).unwrap();
    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        run_ok(&["capture", "make", "rope", &archive]);
        let pushed = run_json(&[&["capture", "push", &archive], &at[..]].concat());
        let capture = text(&pushed, "name");
        let start = ["fit", "start", &capture, "--settings", &settings, "--watch"];
        let mut watching = bendtwin().args(start).args(at).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(watching.stderr.take().unwrap());
        let mut name = String::new();
        said.read_line(&mut name).unwrap();
        let mut progress = String::new();
        while !progress.contains('%') {
            assert!(said.read_line(&mut progress).unwrap() > 0, "it ended: {progress}");
        }
        let pid = watching.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        let mut rest = String::new();
        said.read_to_string(&mut rest).unwrap();
        assert!(!watching.wait().unwrap().success());
        let name = name.trim();
        let hints = [format!("fit watch {name}"), format!("fit cancel {name}")];
        assert!(
            rest.contains("continues at the server") && hints.iter().all(|h| rest.contains(h)),
            "{rest}"
        );
        let fit = run_json(&[&["fit", "show", name], &at[..]].concat());
        assert_eq!(fit["job"]["state"], "RUNNING", "{fit}");
        run_ok(&[&["fit", "cancel", name], &at[..]].concat());
    })
    .await
    .unwrap();
}
