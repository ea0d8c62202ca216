//! Writes the description of the HTTP API, OpenAPI 3.1: routes of RPCs from the contract, with its
//! comments, and the rest from `http/by_hand.json`, where what holds of every operation is left out.

use std::collections::BTreeSet;

use prost_types::field_descriptor_proto::Type;
use serde_json::{Map, Value, json};

use super::{
    contract::{Contract, Route, Rpc, Shown, is_repeated},
    schema::{self, Comments},
};

const ABOUT: &str = "Captures in, twins out, rollouts served. The same API over gRPC is bendtwin.v1, \
                     on the same port.";
const EVENTS: &str = "Server-sent events with messages as data.";
/// Of calls that compute.
const EVENTS_WITH_ERROR: &str = "Server-sent events with messages as data; an event named `error` \
                                 has a problem document and ends them.";
const PROTOBUF: &str = "application/x-protobuf";
/// Ids in paths.
const ID: &str = "^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$";

/// Tags by service.
const TAGS: [(&str, &str); 16] = [
    ("CaptureService", "captures"),
    ("FitService", "fits"),
    ("TwinService", "twins"),
    ("RolloutService", "rollouts"),
    ("RegistrationService", "rollouts"),
    ("EvaluationService", "twins"),
    ("PlanningService", "plans"),
    ("SessionService", "sessions"),
    ("TrashService", "trash"),
    ("RetentionService", "retention"),
    ("KeyService", "keys"),
    ("ShareService", "twins"),
    ("ProjectService", "projects"),
    ("UsageService", "usage"),
    ("SignInService", "sign-in"),
    ("WorkerService", "workers"),
];

/// The document as text: a line for each path and each schema.
pub(crate) fn document(contract: &Contract, by_hand: &Value) -> String {
    let comments = Comments::read(&contract.set);
    let mut paths = Map::new();
    for (path, methods) in by_hand["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            let name = format!("{} {path}", method.to_uppercase());
            let scope = scope_of(contract, by_hand, &name);
            let mut operation = completed(operation.clone(), path, &scope);
            let metadata = rpc_of(contract, &name).and_then(|rpc| contract.metadata(rpc));
            if let Some(parameters) = operation.get_mut("parameters").and_then(Value::as_array_mut)
            {
                let fields = metadata.into_iter().flat_map(|name| contract.shown(name));
                parameters.extend(fields.map(|f| parameter(contract, &comments, &f)));
            }
            add(&mut paths, path, method, operation);
        }
    }
    for rpc in &contract.rpcs {
        for route in rpc.routes.iter().filter(|route| !route.by_hand) {
            let described = operation(contract, &comments, rpc, route);
            let described = completed(described, &route.path, &rpc.scope);
            add(&mut paths, &route.path, &route.method.to_lowercase(), described);
        }
    }
    let mut schemas = by_hand["schemas"].as_object().unwrap().clone();
    schemas.extend(schema::all(contract, &comments, &replies(contract), &bodies(contract)));
    let text = |fields: &Map<String, Value>| {
        let lines = fields.iter().map(|(name, value)| format!("{}:{value}", json!(name)));
        lines.collect::<Vec<_>>().join(",\n")
    };
    paths.sort_keys();
    schemas.sort_keys();
    let security = json!({"key": {
        "type": "http", "scheme": "bearer",
        "description": "A key with the scope of the operation, or the client token.",
    }});
    let license = env!("CARGO_PKG_LICENSE");
    let info = json!({
        "title": "BendTwin", "version": env!("CARGO_PKG_VERSION"), "description": ABOUT,
        "license": {"name": license, "identifier": license},
    });
    format!(
        "{{\"openapi\":\"3.1.0\",\"info\":{info},\n\"tags\":{},\n\"paths\":{{\n{}\n}},\n\
         \"components\":{{\"securitySchemes\":{security},\"schemas\":{{\n{}\n}}}}}}\n",
        by_hand["tags"],
        text(&paths),
        text(&schemas),
    )
}

/// Scopes of the routes that no RPC has, `METHOD /path`.
pub(crate) fn scopes_by_hand(contract: &Contract, by_hand: &Value) -> Vec<(String, String)> {
    let mut scopes = Vec::new();
    for (path, methods) in by_hand["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            let name = format!("{} {path}", method.to_uppercase());
            let scope = operation["x-scope"].as_str();
            let of_rpc = rpc_of(contract, &name);
            assert!(scope.is_some() != of_rpc.is_some(), "{name}: one scope");
            scopes.extend(scope.map(|scope| (name, scope.to_owned())));
        }
    }
    scopes
}

fn scope_of(contract: &Contract, by_hand: &Value, name: &str) -> String {
    let scopes = scopes_by_hand(contract, by_hand);
    let stated = scopes.into_iter().find(|(n, _)| n == name).map(|(_, scope)| scope);
    stated.or_else(|| Some(rpc_of(contract, name)?.scope.clone())).unwrap()
}

fn rpc_of<'c>(contract: &'c Contract, name: &str) -> Option<&'c Rpc> {
    let is_here = |route: &Route| format!("{} {}", route.method, route.path) == name;
    contract.rpcs.iter().find(|rpc| rpc.routes.iter().any(is_here))
}

fn add(paths: &mut Map<String, Value>, path: &str, method: &str, operation: Value) {
    let methods = paths.entry(path).or_insert_with(|| json!({}));
    assert!(methods.get(method).is_none(), "{method} {path} is described twice");
    methods[method] = operation;
}

/// Messages of replies.
fn replies(contract: &Contract) -> BTreeSet<String> {
    let described = described(contract);
    let replies = described.filter(|(_, route)| route.status != 204);
    let names: Vec<&str> = replies.map(|(rpc, _)| rpc.output.as_str()).collect();
    contract.parts(names)
}

/// Messages of bodies.
fn bodies(contract: &Contract) -> BTreeSet<String> {
    let with_body = described(contract).filter(|(rpc, route)| has_body(contract, rpc, route));
    let names: Vec<&str> = with_body.map(|(rpc, _)| rpc.input.as_str()).collect();
    // The resource of an update stands in its body flat.
    let updates =
        |name: &str| contract.message(name).field.iter().any(|f| f.name() == "update_mask");
    let (flat, whole): (Vec<&str>, Vec<&str>) = names.into_iter().partition(|name| updates(name));
    let mut parts = contract.parts(whole);
    parts.extend(flat.into_iter().map(str::to_owned));
    parts
}

fn described(contract: &Contract) -> impl Iterator<Item = (&Rpc, &Route)> {
    let all = contract.rpcs.iter().flat_map(|rpc| rpc.routes.iter().map(move |r| (rpc, r)));
    all.filter(|(_, route)| !route.by_hand)
}

/// True if the fields of a request are in the query.
fn has_query(route: &Route) -> bool {
    matches!(route.method.as_str(), "GET" | "DELETE")
}

fn has_body(contract: &Contract, rpc: &Rpc, route: &Route) -> bool {
    !has_query(route) && !contract.shown(&rpc.input).is_empty()
}

fn operation(contract: &Contract, comments: &Comments, rpc: &Rpc, route: &Route) -> Value {
    let tag = TAGS.iter().find(|(service, _)| *service == rpc.service).unwrap().1;
    let mut operation = json!({
        "operationId": rpc.name,
        "tags": [tag],
        "summary": sentence(&rpc.name),
        "description": comments.of_rpc(rpc),
    });
    let mut parameters = Vec::new();
    if has_query(route) {
        let fields = contract.shown(&rpc.input);
        parameters.extend(fields.iter().map(|f| parameter(contract, comments, f)));
    }
    if route.tensors {
        parameters.push(json!({
            "name": "tensors", "in": "query", "schema": {"type": "string", "pattern": "lists|base64"},
            "description": "`lists` (nested lists of numbers, the default) or `base64`.",
        }));
    }
    if route.tensors && route.method == "POST" {
        parameters.push(json!({
            "name": "timeout_s", "in": "query", "schema": {"type": "number", "format": "double"},
            "description": "Give up after so many seconds.",
        }));
    }
    let header = |name: &str, about: &str| {
        json!({
            "name": name, "in": "header", "schema": {"type": "string"}, "description": about,
        })
    };
    for field in &contract.message(&rpc.input).field {
        match field.name() {
            "request_id" => {
                let about = "Makes the call idempotent.";
                parameters.push(header("Idempotency-Key", about));
            }
            "after_revision" => {
                let about = "Skip revisions up to this one; an invalid id skips nothing.";
                parameters.push(header("Last-Event-ID", about));
            }
            _ => {}
        }
    }
    operation["parameters"] = parameters.into();
    let is_binary = route.tensors && route.method == "POST" && contract.has_tensors(&rpc.input);
    if has_body(contract, rpc, route) {
        let mut content = json!({"application/json": {"schema": schema::reference(&rpc.input)}});
        if is_binary {
            content[PROTOBUF] = binary();
        }
        operation["requestBody"] = json!({"required": true, "content": content});
    }
    let reply = json!({"schema": schema::reference(&rpc.output)});
    let mut response = json!({});
    if rpc.is_streaming {
        response["content"] = json!({"text/event-stream": reply});
        let about = if route.tensors { EVENTS_WITH_ERROR } else { EVENTS };
        response["description"] = about.into();
    } else if route.status != 204 {
        response["content"] = json!({"application/json": reply});
        if is_binary && contract.has_tensors(&rpc.output) {
            response["content"][PROTOBUF] = binary();
        }
    }
    operation["responses"] = json!({(route.status.to_string()): response});
    operation
}

fn binary() -> Value {
    json!({"schema": {"type": "string", "format": "binary"}})
}

/// A parameter of the query. Lists are numbers with commas between them, messages are JSON.
fn parameter(contract: &Contract, comments: &Comments, field: &Shown) -> Value {
    let is_text = is_repeated(&field.field) || field.field.r#type() == Type::Message;
    let mut schema = match is_text {
        true => json!({"type": "string"}),
        false => schema::plain(contract, &field.field),
    };
    let options = contract.field(&field.of.0, field.field.name());
    if !options.pattern.is_empty() {
        schema["pattern"] = options.pattern.into();
    }
    if options.max_length > 0 {
        schema["maxLength"] = options.max_length.into();
    }
    json!({
        "name": field.name(contract), "in": "query", "schema": schema,
        "description": comments.of_field(&field.of),
    })
}

/// `ListCaptures` as `List captures`.
fn sentence(name: &str) -> String {
    let mut words = String::new();
    for c in name.chars() {
        match c.is_uppercase() && !words.is_empty() {
            true => {
                words.push(' ');
                words.extend(c.to_lowercase());
            }
            false => words.push(c),
        }
    }
    words
}

/// An operation with what holds of all.
fn completed(mut operation: Value, path: &str, scope: &str) -> Value {
    let scopes = match scope {
        "OPEN" => json!([]),
        "ANYONE" => json!([{"key": []}]),
        scope => json!([{"key": [scope.to_lowercase().replace('_', ":")]}]),
    };
    let operation_fields = operation.as_object_mut().unwrap();
    operation_fields.remove("x-scope");
    operation_fields.insert("security".to_owned(), scopes);
    if operation_fields.get("description").is_some_and(|d| d == "") {
        operation_fields.remove("description");
    }
    let parameters = operation_fields.entry("parameters").or_insert_with(|| json!([]));
    let parameters = parameters.as_array_mut().unwrap();
    if path.contains("{id}") {
        let id = json!({
            "name": "id", "in": "path", "required": true,
            "schema": {"type": "string", "pattern": ID},
            "description": "The uuid of the resource's name.",
        });
        parameters.insert(0, id);
    }
    if parameters.is_empty() {
        operation_fields.remove("parameters");
    }
    let responses = operation_fields["responses"].as_object_mut().unwrap();
    for (status, response) in responses.iter_mut() {
        if response.get("description").is_none() {
            response["description"] = meaning(status).into();
        }
    }
    let problem = json!({
        "description": "An RFC 9457 problem document: what happened and what to do.",
        "content": {"application/problem+json": {
            "schema": {"$ref": "#/components/schemas/ProblemDocument"},
        }},
    });
    if scope != "OPEN" {
        responses.insert("default".to_owned(), problem);
    }
    operation
}

fn meaning(status: &str) -> &'static str {
    match status {
        "200" => "Success.",
        "201" => "Created.",
        "202" => "Accepted: it is under way.",
        "204" => "Success, without content.",
        "206" => "The range that was asked for.",
        "503" => "Not ready.",
        other => panic!("what status {other} means"),
    }
}
