//! Writes the table of RPCs and their routes, from the options of the contract.

use std::fmt::Write as _;

use serde_json::Value;

use super::{
    contract::{Contract, Route, Rpc},
    json::rust_path,
    openapi,
};

/// The table as a Rust expression.
pub(crate) fn table(contract: &Contract) -> String {
    let mut code = "&[\n".to_owned();
    for rpc in &contract.rpcs {
        let Rpc { package, service, name, audited, .. } = rpc;
        let routes: String = rpc.routes.iter().map(|r| route(contract, rpc, r)).collect();
        let scope = camel_case(&rpc.scope);
        writeln!(
            code,
            "Rpc {{ path: \"/{package}.{service}/{name}\", scope: Scope::{scope}, \
             audited: {audited}, routes: &[{routes}] }},"
        )
        .unwrap();
    }
    code + "]\n"
}

/// Conditions of the routes that no RPC has, as a Rust expression.
pub(crate) fn by_hand(contract: &Contract, by_hand: &Value) -> String {
    let scopes = openapi::scopes_by_hand(contract, by_hand);
    let rows = scopes
        .iter()
        .map(|(name, scope)| format!("    (\"{name}\", Scope::{}),\n", camel_case(scope)));
    format!("&[\n{}]\n", rows.collect::<String>())
}

fn route(contract: &Contract, rpc: &Rpc, route: &Route) -> String {
    let Route { method, path, status, secret, .. } = route;
    let is_plain = !route.by_hand && !route.tensors && !rpc.is_streaming;
    let messages = match is_plain {
        true => format!("Some({})", messages(contract, rpc, route)),
        false => "None".to_owned(),
    };
    format!(
        "\n    Route {{ method: \"{method}\", path: \"{path}\", status: {status}, \
         secret: {secret}, messages: {messages} }},"
    )
}

fn messages(contract: &Contract, rpc: &Rpc, route: &Route) -> String {
    let source = match (contract.shown(&rpc.input).is_empty(), route.method.as_str()) {
        (true, _) => "Nothing",
        (false, "GET" | "DELETE") => "Query",
        (false, _) => "Body",
    };
    let request = contract.message(&rpc.input);
    let has_request_id = request.field.iter().any(|field| field.name() == "request_id");
    let mut bind = Vec::new();
    match route.id.split_once('.') {
        Some((resource, field)) => bind.push(format!(
            "message.{resource}.get_or_insert_default().{field} = given.id.to_owned();"
        )),
        None if !route.id.is_empty() => {
            bind.push(format!("message.{} = given.id.to_owned();", route.id));
        }
        None => {}
    }
    if has_request_id {
        bind.push("message.request_id = given.request_id.to_owned();".to_owned());
    }
    let names = if bind.is_empty() { "_, _" } else { "message, given" };
    let made = match route.location.split_once('.') {
        Some((resource, field)) => {
            format!("Some(|message| message.{resource}.as_ref().map(|made| &made.{field}))")
        }
        None if !route.location.is_empty() => {
            format!("Some(|message| Some(&message.{}))", route.location)
        }
        None => "None".to_owned(),
    };
    format!(
        "Messages {{ source: Source::{source}, has_request_id: {has_request_id}, \
         read: |given| read::<{input}>(given, |{names}| {{ {bind} }}), \
         write: |reply| write::<{output}>(reply, {made}) }}",
        input = rust_path(&rpc.input),
        output = rust_path(&rpc.output),
        bind = bind.join(" "),
    )
}

/// `CAPTURES_READ` as `CapturesRead`.
fn camel_case(word: &str) -> String {
    let parts = word.split('_');
    parts.map(|part| part[..1].to_owned() + &part[1..].to_lowercase()).collect()
}
