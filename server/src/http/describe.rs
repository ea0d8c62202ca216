//! Completes the OpenAPI document that is derived from the handlers: what holds of every operation
//! stands here once.

use serde_json::{Value, json};
use utoipa::openapi::OpenApi;

use crate::access::{self, Access};

/// Ids in paths.
const ID: &str = "^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$";
const PROBLEM: &str = "#/components/schemas/ProblemDocument";

/// The document as JSON.
pub(super) fn complete(description: &OpenApi) -> Value {
    let mut document = serde_json::to_value(description).unwrap_or_default();
    let paths = document.get_mut("paths").and_then(Value::as_object_mut);
    for (path, methods) in paths.into_iter().flatten() {
        for (method, operation) in methods.as_object_mut().into_iter().flatten() {
            name(operation);
            security(operation, access::find(&format!("{} {path}", method.to_uppercase())));
            operation.get_mut("parameters").map(parameters);
            operation.get_mut("responses").map(responses);
        }
    }
    arrays(&mut document);
    document["components"]["securitySchemes"]["key"] = json!({
        "type": "http", "scheme": "bearer",
        "description": "A key with the scope of the operation, or the client token.",
    });
    document
}

/// Gives arrays of anything their empty `items`, which are lost on the way here and without which
/// generators of clients drop everything that uses such an array.
fn arrays(value: &mut Value) {
    if value.get("type").is_some_and(|t| t == "array") && value.get("items").is_none() {
        value["items"] = json!({});
    }
    match value {
        Value::Object(fields) => fields.values_mut().for_each(arrays),
        Value::Array(entries) => entries.iter_mut().for_each(arrays),
        _ => {}
    }
}

/// The scope that the caller has to have.
fn security(operation: &mut Value, access: Option<Access>) {
    operation["security"] = match access {
        Some(Access::Open | Access::Worker) => json!([]),
        Some(Access::Scope(scope)) => json!([{ "key": [scope.as_str()] }]),
        Some(Access::Anyone) | None => json!([{ "key": [] }]),
    };
}

/// Handlers of several resources have the same name: ids of operations are `{tag}.{handler}`.
fn name(operation: &mut Value) {
    let tag = operation.pointer("/tags/0").and_then(Value::as_str).unwrap_or_default();
    let handler = operation.get("operationId").and_then(Value::as_str).unwrap_or_default();
    let id = format!("{tag}.{handler}");
    if operation.is_object() {
        operation["operationId"] = id.into();
    }
}

fn parameters(parameters: &mut Value) {
    for parameter in parameters.as_array_mut().into_iter().flatten() {
        if parameter["name"] == "id" && parameter["in"] == "path" {
            parameter["schema"] = json!({"type": "string", "pattern": ID});
            parameter["description"] = "The uuid of the resource's name.".into();
        }
    }
}

fn responses(responses: &mut Value) {
    for (status, response) in responses.as_object_mut().into_iter().flatten() {
        if response["description"].as_str().is_none_or(str::is_empty) {
            response["description"] = meaning(status).into();
        }
        let content = response.get_mut("content").and_then(Value::as_object_mut);
        if let Some(content) = content
            && content.get("application/json").is_some_and(|c| c["schema"]["$ref"] == PROBLEM)
            && let Some(problem) = content.remove("application/json")
        {
            content.insert("application/problem+json".to_owned(), problem);
        }
    }
}

fn meaning(status: &str) -> &'static str {
    match status {
        "200" => "Success.",
        "201" => "Created.",
        "202" => "Accepted: it is under way.",
        "204" => "Success, without content.",
        "503" => "Not ready.",
        "default" => "An RFC 9457 problem document: what happened and what to do.",
        _ => "See the description of the operation.",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_document_is_complete() {
        let (_, description) = crate::http::described().split_for_parts();
        let document = complete(&description);
        let mut ids = HashSet::new();
        for (path, methods) in document["paths"].as_object().unwrap() {
            for (method, operation) in methods.as_object().unwrap() {
                let what = format!("{method} {path}");
                let id = operation["operationId"].as_str().unwrap();
                assert!(ids.insert(id.to_owned()), "{what}: {id} is taken");
                assert!(operation["security"].is_array(), "{what}");
                for (status, response) in operation["responses"].as_object().unwrap() {
                    assert_ne!(response["description"].as_str(), None, "{what} {status}");
                    assert_ne!(response["description"], "", "{what} {status}");
                    let is_problem = response.to_string().contains(PROBLEM);
                    let media = response["content"].get("application/problem+json");
                    assert_eq!(is_problem, media.is_some(), "{what} {status}");
                }
                let ids = operation["parameters"].as_array().into_iter().flatten();
                for id in ids.filter(|p| p["name"] == "id") {
                    assert_eq!(id["schema"]["pattern"], ID, "{what}");
                }
            }
        }
        let all = all_arrays(&document);
        assert!(all.len() > 50, "{}", all.len());
        for array in all {
            assert!(array.get("items").is_some(), "generators drop this: {array}");
        }
        // Every reference has its target.
        let text = document.to_string();
        for reference in text.split("\"$ref\":\"#").skip(1) {
            let target = reference.split('"').next().unwrap();
            assert!(document.pointer(target).is_some(), "{target} is missing");
        }
    }

    /// Schemas of arrays, wherever they stand.
    fn all_arrays(value: &Value) -> Vec<&Value> {
        let is_array = match value.get("type") {
            Some(Value::String(word)) => word == "array",
            Some(Value::Array(words)) => words.iter().any(|word| word == "array"),
            _ => false,
        };
        let mut found = if is_array { vec![value] } else { Vec::new() };
        match value {
            Value::Object(fields) => found.extend(fields.values().flat_map(all_arrays)),
            Value::Array(entries) => found.extend(entries.iter().flat_map(all_arrays)),
            _ => {}
        }
        found
    }

    #[test]
    fn parameters_that_are_refused_say_what_they_are() {
        let (_, description) = crate::http::described().split_for_parts();
        let document = complete(&description);
        for path in ["captures", "fits", "twins"] {
            let parameters = &document["paths"][format!("/v1/{path}")]["get"]["parameters"];
            let of = |name: &str| {
                parameters.as_array().unwrap().iter().find(|p| p["name"] == name).unwrap()
            };
            let pattern = of("order_by")["schema"]["pattern"].as_str().unwrap();
            assert!(pattern.contains("create_time|name"), "{pattern}");
            assert!(of("page_size")["description"].to_string().contains("counts as 1000"));
        }
    }
}
