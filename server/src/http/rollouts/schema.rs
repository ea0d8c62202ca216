//! Schemas of the messages that HTTP has as bodies, for the OpenAPI document, from their descriptors
//! and comments.

use std::{borrow::Cow, collections::HashMap};

use bendtwin_proto::DESCRIPTORS;
use prost::Message as _;
use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};
use serde_json::{Map, Value, json};
use utoipa::{
    PartialSchema, ToSchema,
    openapi::{RefOr, Schema, schema::Ref},
};

/// The files whose messages are described, all or some of them.
const FILES: [(&str, Option<&str>); 8] = [
    ("bendtwin/v1/fault.proto", None),
    ("bendtwin/v1/world.proto", None),
    ("bendtwin/v1/rollout.proto", None),
    ("bendtwin/v1/planning.proto", None),
    ("bendtwin/v1/registration.proto", None),
    ("bendtwin/v1/session.proto", None),
    ("bendtwin/v1/twin.proto", Some("TwinGeometry")),
    ("bendtwin/v1/evaluation.proto", Some("PredictedMotion")),
];
const PACKAGE: &str = ".bendtwin.v1.";

/// Numbers of the fields of descriptors in the paths of comments.
const MESSAGE: i32 = 4;
const FIELD: i32 = 2;
const NESTED: i32 = 3;

/// Schemas by the names of messages.
macro_rules! described {
    ($($message:ident)*) => {$(
        #[doc = concat!("`bendtwin.v1.", stringify!($message), "` as JSON.")]
        pub(in crate::http) struct $message;

        impl PartialSchema for $message {
            fn schema() -> RefOr<Schema> {
                schema(stringify!($message))
            }
        }

        impl ToSchema for $message {
            fn name() -> Cow<'static, str> {
                Cow::Borrowed(stringify!($message))
            }

            fn schemas(found: &mut Vec<(String, RefOr<Schema>)>) {
                found.extend(all());
            }
        }
    )*};
}

described! {
    AdvanceSessionRequest
    CorrectSessionRequest
    CorrectedSession
    ForkSessionRequest
    OpenSessionRequest
    PlanRequest
    PlanUpdate
    PredictedMotion
    RegisterStateRequest
    RegisteredState
    ResetSessionRequest
    RollOutRequest
    RollOutResponse
    Session
    SessionStates
    StepSessionRequest
    SteppedSession
    TwinGeometry
}

fn schema(name: &str) -> RefOr<Schema> {
    let found = all().into_iter().find(|(n, _)| n == name);
    found.map_or_else(|| RefOr::Ref(Ref::from_schema_name(name)), |(_, schema)| schema)
}

/// The schemas of all messages, by name.
fn all() -> Vec<(String, RefOr<Schema>)> {
    let Ok(set) = FileDescriptorSet::decode(DESCRIPTORS) else { return Vec::new() };
    let mut messages = Messages::default();
    let chosen = |file: &FileDescriptorProto| {
        FILES.iter().find(|(name, _)| *name == file.name()).map(|(_, only)| *only)
    };
    for (file, only) in set.file.iter().filter_map(|file| Some((file, chosen(file)?))) {
        let comments = comments(file);
        for words in &file.enum_type {
            messages.words(PACKAGE, words);
        }
        for message in &file.message_type {
            messages.collect_words(PACKAGE, message);
        }
        let messages_of = (0..).zip(&file.message_type);
        for (i, message) in messages_of.filter(|(_, m)| only.is_none_or(|only| m.name() == only)) {
            messages.message("", message, vec![MESSAGE, i], &comments);
        }
    }
    messages.schemas.push(("Tensor".to_owned(), tensor()));
    let schema = |value| serde_json::from_value(value).map(RefOr::T).ok();
    messages.schemas.into_iter().filter_map(|(name, v)| Some((name, schema(v)?))).collect()
}

/// Comments of a file by the path of what they are about.
type Comments = HashMap<Vec<i32>, String>;

fn comments(file: &FileDescriptorProto) -> Comments {
    let locations = file.source_code_info.iter().flat_map(|info| &info.location);
    let text = |comment: &str| comment.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    locations.map(|l| (l.path.clone(), text(l.leading_comments()).trim().to_owned())).collect()
}

#[derive(Default)]
struct Messages {
    schemas: Vec<(String, Value)>,
    /// Words of the enums, by type name.
    words: HashMap<String, Vec<String>>,
}

impl Messages {
    fn collect_words(&mut self, scope: &str, message: &DescriptorProto) {
        let scope = format!("{scope}{}.", message.name());
        for words in &message.enum_type {
            self.words(&scope, words);
        }
        for nested in &message.nested_type {
            self.collect_words(&scope, nested);
        }
    }

    fn words(&mut self, scope: &str, words: &EnumDescriptorProto) {
        let known = words.value.iter().filter(|v| v.number() != 0).map(|v| v.name().to_owned());
        self.words.insert(format!("{scope}{}", words.name()), known.collect());
    }

    fn message(
        &mut self,
        scope: &str,
        message: &DescriptorProto,
        path: Vec<i32>,
        about: &Comments,
    ) {
        let name = format!("{scope}{}", message.name());
        let at = |part: i32, index: i32| [path.as_slice(), &[part, index]].concat();
        let mut properties = Map::new();
        for (i, field) in (0..).zip(&message.field) {
            let mut schema = self.field(field);
            let others = message.field.iter().filter(|f| {
                !field.proto3_optional()
                    && f.oneof_index.is_some()
                    && f.oneof_index == field.oneof_index
            });
            let others: Vec<_> = others.map(FieldDescriptorProto::name).collect();
            let mut text = about.get(&at(FIELD, i)).cloned().unwrap_or_default();
            if others.len() > 1 {
                text = format!("{text} Only one of {} may be given.", others.join(", "));
            }
            if let (Some(schema), false) = (schema.as_object_mut(), text.is_empty()) {
                schema.insert("description".to_owned(), text.trim().into());
            }
            properties.insert(field.name().to_owned(), schema);
        }
        let schema = json!({
            "type": "object",
            "description": about.get(&path).cloned().unwrap_or_default(),
            "properties": properties,
            "additionalProperties": false,
        });
        for (i, nested) in (0..).zip(&message.nested_type) {
            self.message(&format!("{name}."), nested, at(NESTED, i), about);
        }
        self.schemas.push((name, schema));
    }

    fn field(&self, field: &FieldDescriptorProto) -> Value {
        let each = match field.r#type() {
            Type::Message => {
                let name = field.type_name().strip_prefix(PACKAGE).unwrap_or_default();
                json!({"$ref": format!("#/components/schemas/{name}")})
            }
            Type::Enum => json!({"type": "string", "enum": self.words.get(field.type_name())}),
            Type::String => json!({"type": "string"}),
            Type::Bool => json!({"type": "boolean"}),
            Type::Uint32 | Type::Uint64 => {
                json!({"type": "integer", "format": "int64", "minimum": 0})
            }
            Type::Float => json!({"type": "number", "format": "float"}),
            _ => json!({"type": "number", "format": "double"}),
        };
        if field.label() == Label::Repeated {
            json!({"type": "array", "items": each})
        } else {
            each
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_a_rollout_is_described() {
        let all: HashMap<_, _> = all().into_iter().collect();
        let of = |name: &str| serde_json::to_value(&all[name]).unwrap();
        let request = of("RollOutRequest");
        assert_eq!(request["additionalProperties"], false);
        let trajectories = &request["properties"]["trajectories"];
        assert_eq!(trajectories["$ref"], "#/components/schemas/ControlTrajectories");
        let frames = request["properties"]["frames"]["description"].as_str().unwrap();
        assert!(frames.contains("Horizon"), "{frames}");
        let when = &of("Cost")["properties"]["when"]["enum"];
        assert_eq!(when, &json!(["LAST_FRAME", "EVERY_FRAME", "SOFT_MIN"]));
        let kind = of("Cost")["properties"]["keypoints"]["description"].to_string();
        assert!(kind.contains("Only one of target_cloud, keypoints, smoothness"), "{kind}");
        assert!(all.contains_key("RollOutResponse.Timing") && all.contains_key("Tensor"));
        assert!(of("Tensor")["oneOf"].is_array());
    }
}
