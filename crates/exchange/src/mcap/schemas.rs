//! JSON schemas of the messages: the fields of Foxglove's PointCloud and SceneUpdate that are
//! written, with their types. Foxglove knows a message by its schema's name and its bytes as base64
//! by `contentEncoding`.

use serde_json::{Value, json};

/// `foxglove.PointCloud`.
pub(super) fn point_cloud() -> Vec<u8> {
    let field = object(&[("name", text()), ("offset", integer()), ("type", integer())]);
    let schema = object(&[
        ("timestamp", time()),
        ("frame_id", text()),
        ("pose", pose()),
        ("point_stride", integer()),
        ("fields", array(&field)),
        ("data", json!({"type": "string", "contentEncoding": "base64"})),
    ]);
    titled(schema, "foxglove.PointCloud")
}

/// `foxglove.SceneUpdate`.
pub(super) fn scene_update() -> Vec<u8> {
    let lines = object(&[
        ("type", integer()),
        ("pose", pose()),
        ("thickness", number()),
        ("scale_invariant", json!({"type": "boolean"})),
        ("points", array(&xyz())),
        ("color", color()),
        ("colors", array(&color())),
        ("indices", array(&integer())),
    ]);
    let triangles = object(&[
        ("pose", pose()),
        ("points", array(&xyz())),
        ("color", color()),
        ("colors", array(&color())),
        ("indices", array(&integer())),
    ]);
    let other = array(&json!({"type": "object"}));
    let entity = object(&[
        ("timestamp", time()),
        ("frame_id", text()),
        ("id", text()),
        ("lifetime", time()),
        ("frame_locked", json!({"type": "boolean"})),
        ("metadata", other.clone()),
        ("arrows", other.clone()),
        ("cubes", other.clone()),
        ("spheres", other.clone()),
        ("cylinders", other.clone()),
        ("lines", array(&lines)),
        ("triangles", array(&triangles)),
        ("texts", other.clone()),
        ("models", other.clone()),
    ]);
    let schema = object(&[("deletions", other), ("entities", array(&entity))]);
    titled(schema, "foxglove.SceneUpdate")
}

fn titled(mut schema: Value, title: &str) -> Vec<u8> {
    schema["title"] = json!(title);
    schema.to_string().into_bytes()
}

fn object(properties: &[(&str, Value)]) -> Value {
    let properties: serde_json::Map<String, Value> =
        properties.iter().map(|(name, schema)| ((*name).to_owned(), schema.clone())).collect();
    json!({"type": "object", "properties": properties})
}

fn array(items: &Value) -> Value {
    json!({"type": "array", "items": items})
}

fn text() -> Value {
    json!({"type": "string"})
}

fn integer() -> Value {
    json!({"type": "integer", "minimum": 0})
}

fn number() -> Value {
    json!({"type": "number"})
}

fn time() -> Value {
    object(&[("sec", integer()), ("nsec", integer())])
}

fn xyz() -> Value {
    object(&[("x", number()), ("y", number()), ("z", number())])
}

fn color() -> Value {
    object(&[("r", number()), ("g", number()), ("b", number()), ("a", number())])
}

fn pose() -> Value {
    let orientation = object(&[("x", number()), ("y", number()), ("z", number()), ("w", number())]);
    object(&[("position", xyz()), ("orientation", orientation)])
}
