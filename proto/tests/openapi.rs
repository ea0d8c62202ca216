//! Properties of the description that all clients rely on.

use std::collections::HashSet;

use bendtwin_proto::OPENAPI;
use serde_json::{Value, json};

const PROBLEM: &str = "#/components/schemas/ProblemDocument";

fn document() -> Value {
    serde_json::from_str(OPENAPI).unwrap()
}

#[test]
fn the_document_is_complete() {
    let document = document();
    let mut ids = HashSet::new();
    for (path, methods) in document["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            let what = format!("{method} {path}");
            let id = operation["operationId"].as_str().unwrap();
            assert!(ids.insert(id.to_owned()), "{what}: {id} is taken");
            assert!(operation["summary"].is_string(), "{what}");
            assert!(!operation.to_string().contains("\"x-"), "{what}");
            for (status, response) in operation["responses"].as_object().unwrap() {
                assert_ne!(response["description"].as_str(), None, "{what} {status}");
                assert_ne!(response["description"], "", "{what} {status}");
                let is_problem = response.to_string().contains(PROBLEM);
                let media = response["content"].get("application/problem+json");
                assert_eq!(is_problem, media.is_some(), "{what} {status}");
            }
        }
    }
    // Every reference has its target.
    let text = document.to_string();
    for reference in text.split("\"$ref\":\"#").skip(1) {
        let target = reference.split('"').next().unwrap();
        assert!(document.pointer(target).is_some(), "{target} is missing");
    }
}

#[test]
fn generators_of_clients_know_every_array() {
    fn arrays(value: &Value) -> Vec<&Value> {
        let mut found = if value["type"] == "array" { vec![value] } else { Vec::new() };
        match value {
            Value::Object(fields) => found.extend(fields.values().flat_map(arrays)),
            Value::Array(entries) => found.extend(entries.iter().flat_map(arrays)),
            _ => {}
        }
        found
    }
    let document = document();
    let all = arrays(&document);
    assert!(all.len() > 50, "{}", all.len());
    for array in all {
        assert!(array.get("items").is_some(), "generators drop this: {array}");
    }
}

#[test]
fn parameters_that_are_refused_say_what_they_are() {
    let document = document();
    for path in ["captures", "fits", "twins"] {
        let parameters = &document["paths"][format!("/v1/{path}")]["get"]["parameters"];
        let of =
            |name: &str| parameters.as_array().unwrap().iter().find(|p| p["name"] == name).unwrap();
        let pattern = of("order_by")["schema"]["pattern"].as_str().unwrap();
        assert!(pattern.contains("create_time|name"), "{pattern}");
        assert!(of("page_size")["description"].to_string().contains("count as 1000"));
        assert_eq!(of("search")["schema"]["maxLength"], 200);
    }
}

#[test]
fn the_forms_of_fields_are_described() {
    let document = document();
    let schema = |name: &str| &document["components"]["schemas"][name];
    let request = schema("RollOutRequest");
    assert_eq!(request["additionalProperties"], false);
    let trajectories = &request["properties"]["trajectories"];
    assert_eq!(trajectories["$ref"], "#/components/schemas/ControlTrajectories");
    let frames = request["properties"]["frames"]["description"].as_str().unwrap();
    assert!(frames.contains("Horizon"), "{frames}");
    let when = &schema("Cost")["properties"]["when"]["enum"];
    assert_eq!(when, &json!(["LAST_FRAME", "EVERY_FRAME", "SOFT_MIN"]));
    let kind = schema("Cost")["properties"]["keypoints"]["description"].to_string();
    assert!(kind.contains("Only one of target_cloud, keypoints, smoothness"), "{kind}");
    assert!(schema("Tensor")["oneOf"].is_array());

    let job = schema("Job");
    assert_eq!(job["properties"]["settings"]["type"], "object");
    assert_eq!(job["properties"]["worker"]["type"], json!(["string", "null"]));
    assert_eq!(job["properties"]["fault"]["oneOf"][0], json!({"type": "null"}));
    assert_eq!(job["properties"]["create_time"]["format"], "date-time");
    let required = job["required"].as_array().unwrap();
    assert_eq!(required.len(), job["properties"].as_object().unwrap().len());
    let twin = schema("Twin")["required"].as_array().unwrap();
    assert!(twin.contains(&json!("quality")) && !twin.contains(&json!("mass_kg")));
    let change = schema("UpdateTwinRequest")["properties"].as_object().unwrap();
    let mut names: Vec<&str> = change.keys().map(String::as_str).collect();
    names.sort_unstable();
    assert_eq!(names, ["add_tags", "display_name", "note", "remove_tags", "tags"]);
    let order = schema("CreateFitRequest")["properties"].as_object().unwrap();
    assert!(order.contains_key("settings") && !order.contains_key("request_id"));
}
