//! Somebody deletes a colleague's recording, and gets it back; an administrator has old ones deleted by
//! a rule, after a look at what it would do.

use serde_json::Value;

use crate::harness::{
    TestCluster,
    command::{run, run_json, run_ok},
};

#[tokio::test]
async fn what_was_deleted_is_restored_and_rules_show_what_they_would_delete() {
    let server = TestCluster::ordinary().await;
    let (url, archive) = (server.url(), server.path("rope.zip"));
    tokio::task::spawn_blocking(move || {
        let at = ["--server", url.as_str()];
        let json = |arguments: &[&str]| run_json(&[arguments, &at[..]].concat());
        let ok = |arguments: &[&str]| run_ok(&[arguments, &at[..]].concat());
        let fails = |arguments: &[&str]| {
            let output = run(&[arguments, &at[..]].concat());
            assert!(!output.status.success());
            String::from_utf8(output.stderr).unwrap()
        };
        ok(&["capture", "make", "rope", &archive]);
        let pushed = json(&["capture", "push", &archive, "--watch"]);
        let capture = pushed["name"].as_str().unwrap();
        let listed = |trash: &Value| -> Vec<String> {
            let names = trash.as_array().unwrap().iter();
            names.map(|trashed| trashed["name"].as_str().unwrap().to_owned()).collect()
        };

        ok(&["capture", "delete", capture]);
        let shown = fails(&["capture", "show", capture]);
        assert!(shown.contains(&format!("bendtwin trash restore {capture}")), "{shown}");
        assert_eq!(listed(&json(&["trash", "list"])), [capture]);
        assert!(ok(&["trash", "list"]).contains("rope"));
        ok(&["trash", "restore", capture]);
        assert_eq!(json(&["capture", "show", capture])["digest"], pushed["digest"]);
        assert!(listed(&json(&["trash", "list"])).is_empty());

        let create = ["retention", "create", "all ropes", "captures", "--min-age-days", "0"];
        let rule = json(&create);
        assert_eq!(rule["collection"], "captures", "{rule}");
        assert!(ok(&["retention", "list"]).contains("all ropes"));
        ok(&["capture", "edit", capture, "--tag", "+keep"]);
        let preview = json(&["retention", "preview"]);
        let outcome = &preview["outcomes"][0];
        assert_eq!(
            (outcome["name"].as_str(), &outcome["rule"]),
            (Some(capture), &"all ropes".into())
        );
        assert_eq!(outcome["kept_because"], "it has the tag `keep`", "{preview}");
        assert!(ok(&["retention", "preview"]).contains("0 to delete"));
        ok(&["capture", "edit", capture, "--tag", "-keep"]);
        assert!(ok(&["retention", "preview"]).contains("1 to delete"));
        ok(&["retention", "delete", rule["name"].as_str().unwrap()]);

        ok(&["capture", "delete", capture]);
        fails(&["trash", "empty"]);
        ok(&["trash", "empty", "--all"]);
        let shown = fails(&["trash", "restore", capture]);
        assert!(shown.contains("does not exist"), "{shown}");
    })
    .await
    .unwrap();
}
