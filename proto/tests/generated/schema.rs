//! Schemas of the messages that HTTP has as JSON, from their descriptors, options and comments.

use std::collections::{BTreeSet, HashMap};

use prost_types::{
    DescriptorProto, FieldDescriptorProto, FileDescriptorSet, field_descriptor_proto::Type,
};
use serde_json::{Map, Value, json};

use super::contract::{Contract, Form, Rpc, Shown, is_repeated, is_tensor};

const PACKAGE: &str = ".bendtwin.v1.";

/// Numbers of the fields of descriptors in the paths of comments.
const MESSAGE: i32 = 4;
const SERVICE: i32 = 6;
const FIELD: i32 = 2;
const METHOD: i32 = 2;
const NESTED: i32 = 3;

/// Comments by what they are about.
pub(crate) struct Comments {
    /// By file and path.
    texts: HashMap<(String, Vec<i32>), String>,
    /// Files and paths of messages.
    places: HashMap<String, (String, Vec<i32>)>,
}

impl Comments {
    pub(crate) fn read(set: &FileDescriptorSet) -> Self {
        let mut comments = Self { texts: HashMap::new(), places: HashMap::new() };
        for file in &set.file {
            let locations = file.source_code_info.iter().flat_map(|info| &info.location);
            for location in locations {
                let lines = location.leading_comments().lines().map(str::trim);
                let text = lines.collect::<Vec<_>>().join(" ").trim().to_owned();
                comments.texts.insert((file.name().to_owned(), location.path.clone()), text);
            }
            for (i, message) in (0..).zip(&file.message_type) {
                let scope = format!(".{}", file.package());
                comments.place(file.name(), &scope, message, vec![MESSAGE, i]);
            }
        }
        comments
    }

    fn place(&mut self, file: &str, scope: &str, message: &DescriptorProto, path: Vec<i32>) {
        let name = format!("{scope}.{}", message.name());
        for (i, nested) in (0..).zip(&message.nested_type) {
            self.place(file, &name, nested, [path.as_slice(), &[NESTED, i]].concat());
        }
        self.places.insert(name, (file.to_owned(), path));
    }

    fn text(&self, file: &str, path: &[i32]) -> String {
        self.texts.get(&(file.to_owned(), path.to_vec())).cloned().unwrap_or_default()
    }

    pub(crate) fn of_rpc(&self, rpc: &Rpc) -> String {
        let (file, service, method) = &rpc.place;
        self.text(file, &[SERVICE, *service, METHOD, *method])
    }

    fn of_message(&self, name: &str) -> String {
        let (file, path) = &self.places[name];
        self.text(file, path)
    }

    /// Of a field by its message and its place there.
    pub(crate) fn of_field(&self, (message, index): &(String, i32)) -> String {
        let (file, path) = &self.places[message];
        self.text(file, &[path.as_slice(), &[FIELD, *index]].concat())
    }
}

/// A reference to the schema of a message.
pub(crate) fn reference(message: &str) -> Value {
    json!({"$ref": format!("#/components/schemas/{}", short(message))})
}

fn short(message: &str) -> &str {
    message.strip_prefix(PACKAGE).expect("a message of bendtwin.v1")
}

/// The schemas of messages in replies and in bodies, by name. What a body may have, a client may leave
/// out, and a name that is not there is refused.
pub(crate) fn all(
    contract: &Contract,
    comments: &Comments,
    replies: &BTreeSet<String>,
    bodies: &BTreeSet<String>,
) -> Map<String, Value> {
    let mut schemas = Map::new();
    let is_message = |name: &&String| comments.places.contains_key(*name);
    for name in replies.union(bodies).filter(is_message) {
        let origin = (replies.contains(name), bodies.contains(name));
        schemas.insert(short(name).to_owned(), message(contract, comments, name, origin));
    }
    schemas.insert("Tensor".to_owned(), tensor());
    schemas
}

/// The schema of a message of a reply, of a body, or of both.
fn message(
    contract: &Contract,
    comments: &Comments,
    name: &str,
    (is_answered, is_given): (bool, bool),
) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for field in contract.shown(name) {
        let mut schema = property(contract, &field);
        let mut text = comments.of_field(&field.of);
        let others = alternatives(contract.message(&field.of.0), &field.field);
        if others.len() > 1 {
            text = format!("{text} Only one of {} may be given.", others.join(", "));
        }
        if !text.is_empty() {
            schema["description"] = text.trim().into();
        }
        let has_default = schema.get("enum").is_none() && schema.get("$ref").is_none();
        if is_answered && is_given && has_default && is_always_there(contract, &field) {
            schema["default"] = default(&schema);
        }
        let name = field.name(contract);
        let is_demanded = contract.field(&field.of.0, field.field.name()).required;
        if is_demanded || !is_given && is_always_there(contract, &field) {
            required.push(name.clone());
        }
        properties.insert(name, schema);
    }
    let mut schema = json!({
        "type": "object",
        "description": comments.of_message(name),
        "properties": properties,
    });
    if is_given {
        schema["additionalProperties"] = false.into();
    }
    if !required.is_empty() {
        schema["required"] = required.into();
    }
    schema
}

/// The value of a field that is left out.
fn default(schema: &Value) -> Value {
    match schema["type"].as_str() {
        Some("string") => json!(""),
        Some("boolean") => json!(false),
        Some("array") => json!([]),
        Some("object") => json!({}),
        Some(_) => json!(0),
        None => Value::Null,
    }
}

/// Names of the fields of which only one may be given.
fn alternatives<'m>(message: &'m DescriptorProto, field: &FieldDescriptorProto) -> Vec<&'m str> {
    if field.proto3_optional() || field.oneof_index.is_none() {
        return Vec::new();
    }
    let group = message.field.iter().filter(|f| f.oneof_index == field.oneof_index);
    group.filter(|f| !f.proto3_optional()).map(FieldDescriptorProto::name).collect()
}

/// True if JSON always has the field.
fn is_always_there(contract: &Contract, field: &Shown) -> bool {
    let form = contract.field(&field.of.0, field.field.name()).form;
    let can_miss = field.field.r#type() == Type::Message || field.field.oneof_index.is_some();
    is_repeated(&field.field) || matches!(form, Form::Null | Form::Always) || !can_miss
}

fn property(contract: &Contract, field: &Shown) -> Value {
    let form = contract.field(&field.of.0, field.field.name()).form;
    if form == Form::Nested {
        return json!({"type": "object", "additionalProperties": true});
    }
    let mut each = plain(contract, &field.field);
    if form == Form::Null {
        each = match each.get("type").cloned() {
            Some(kind) => {
                each["type"] = json!([kind, "null"]);
                each
            }
            None => json!({"oneOf": [{"type": "null"}, each]}),
        };
    }
    if is_repeated(&field.field) { json!({"type": "array", "items": each}) } else { each }
}

/// The schema of a single value of a field.
pub(crate) fn plain(contract: &Contract, field: &FieldDescriptorProto) -> Value {
    match field.r#type() {
        Type::Message if field.type_name() == ".google.protobuf.Timestamp" => {
            json!({"type": "string", "format": "date-time"})
        }
        Type::Message if is_tensor(field.type_name()) => {
            json!({"$ref": "#/components/schemas/Tensor"})
        }
        Type::Message => reference(field.type_name()),
        Type::Enum => json!({"type": "string", "enum": contract.words(field.type_name())}),
        Type::String => json!({"type": "string"}),
        Type::Bool => json!({"type": "boolean"}),
        Type::Int32 => json!({"type": "integer", "format": "int32"}),
        Type::Uint32 | Type::Uint64 => json!({"type": "integer", "format": "int64", "minimum": 0}),
        Type::Float => json!({"type": "number", "format": "float"}),
        Type::Double => json!({"type": "number", "format": "double"}),
        other => panic!("{other:?} in JSON"),
    }
}

fn tensor() -> Value {
    json!({
        "description": "A dense array: nested lists of numbers, in which null stands for what is no finite number, or raw bytes.",
        "oneOf": [
            {"type": "array", "items": {}, "description": "Nested lists of numbers."},
            {
                "type": "object",
                "description": "Raw bytes.",
                "required": ["dtype", "shape", "data"],
                "properties": {
                    "dtype": {
                        "type": "string",
                        "enum": ["FLOAT32", "FLOAT64", "UINT32", "INT32", "UINT8", "INT16_SCALED"],
                    },
                    "shape": {"type": "array", "items": {"type": "integer", "minimum": 0}},
                    "data": {
                        "type": "string",
                        "description": "Base64 of the little-endian, row-major bytes.",
                    },
                    "scale": {
                        "type": "number",
                        "description": "Of INT16_SCALED: value = int16 * scale + offset.",
                    },
                    "offset": {"type": "number", "description": "Of INT16_SCALED."},
                },
                "additionalProperties": false,
            },
        ],
    })
}
