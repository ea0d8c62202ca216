//! Writes the implementations of `json::Fields` and `json::Words` for the messages of some files,
//! from their descriptors: which fields they have and of which kind.

use std::{collections::BTreeSet, fmt::Write as _};

use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, field_descriptor_proto::Type,
};

use super::contract::{Contract, Form, Shown, is_repeated};

const PACKAGE: &str = ".bendtwin.v1.";

/// Tensors whose lists in JSON are of UINT32; those that are not named here or below are of FLOAT32.
const INDICES: [&str; 8] = [
    "gripper_of_control",
    "group_of_control",
    "nodes",
    "instances",
    "closed",
    "phases",
    "holders",
    "gradient_exploded",
];

/// Tensors whose lists are of UINT8.
const BYTES: [&str; 2] = ["background", "color"];

/// The implementations as Rust code.
pub(crate) fn implementations(contract: &Contract) -> String {
    let wanted = contract.in_json();
    let mut code = String::new();
    for file in contract.set.file.iter().filter(|f| f.package() == "bendtwin.v1") {
        for message in &file.message_type {
            self::message(contract, &wanted, ".bendtwin.v1", message, &mut code);
        }
        for words in &file.enum_type {
            self::words(&wanted, ".bendtwin.v1", words, &mut code);
        }
    }
    code
}

fn message(
    contract: &Contract,
    wanted: &BTreeSet<String>,
    scope: &str,
    message: &DescriptorProto,
    code: &mut String,
) {
    let full = format!("{scope}.{}", message.name());
    if wanted.contains(&full) {
        implementation(contract, &full, message, code);
    }
    for nested in &message.nested_type {
        self::message(contract, wanted, &full, nested, code);
    }
    for words in &message.enum_type {
        self::words(wanted, &full, words, code);
    }
}

fn implementation(contract: &Contract, full: &str, message: &DescriptorProto, code: &mut String) {
    let shown = contract.shown(full);
    let names: Vec<String> = shown.iter().map(|field| field.name(contract)).collect();
    let is_required = |field: &&Shown| contract.field(&field.of.0, field.field.name()).required;
    let required: Vec<String> =
        shown.iter().filter(is_required).map(|field| field.name(contract)).collect();
    let (mut read, mut write) = (String::new(), String::new());
    for (index, (field, name)) in shown.iter().zip(&names).enumerate() {
        let lines = match &field.inside {
            Some(resource) => Lines::of_update(resource, field.field.name()),
            None => Lines::of(contract, full, message, &field.field, name),
        };
        writeln!(read, "{index} => {{ {} }}", lines.read).unwrap();
        writeln!(write, "{}", lines.write).unwrap();
    }
    write!(
        code,
        r#"
impl Fields for {path} {{
    const NAME: &'static str = "{name}";
    const FIELDS: &'static [&'static str] = &{names:?};
    const REQUIRED: &'static [&'static str] = &{required:?};
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {{
        match field {{
            {read}
            _ => {{}}
        }}
        Ok(())
    }}
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {{
        {write}
        Ok(())
    }}
}}
written!({path});
"#,
        path = rust_path(full),
        name = message.name(),
    )
    .unwrap();
}

fn words(wanted: &BTreeSet<String>, scope: &str, words: &EnumDescriptorProto, code: &mut String) {
    let full = format!("{scope}.{}", words.name());
    if !wanted.contains(&full) {
        return;
    }
    let known = words.value.iter().filter(|v| v.number() != 0).map(|v| v.name().to_owned());
    let known: Vec<String> = known.collect();
    write!(
        code,
        r#"
impl Words for {path} {{
    const KNOWN: &'static [&'static str] = &{known:?};
    fn number(word: &str) -> Option<i32> {{
        Self::from_str_name(word).map(Into::into)
    }}
    fn word(number: i32) -> Option<&'static str> {{
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }}
}}
word_written!({path});
"#,
        path = rust_path(&full),
    )
    .unwrap();
}

/// The code that reads a field and that writes it.
struct Lines {
    read: String,
    write: String,
}

impl Lines {
    /// Lines of a field that an update may change: a given value is in the mask.
    fn of_update(resource: &str, field: &str) -> Self {
        let read = format!(
            "if let Some(value) = map.next_value::<Option<_>>()? {{ \
             self.{resource}.get_or_insert_default().{field} = value; \
             self.update_mask.get_or_insert_default().paths.push(\"{field}\".to_owned()); }}"
        );
        Self { read, write: String::new() }
    }

    fn of(
        contract: &Contract,
        full: &str,
        message: &DescriptorProto,
        field: &FieldDescriptorProto,
        json: &str,
    ) -> Self {
        let inner = module_of(full);
        let inner = inner.as_str();
        let name = field.name();
        let is_repeated = is_repeated(field);
        let oneof = field.oneof_index.filter(|_| !field.proto3_optional());
        let form = contract.field(full, name).form;
        let text = |read: String, write: String| Self { read, write };
        match field.r#type() {
            _ if form == Form::Nested => text(
                format!("self.{name} = document(map)?;"),
                format!("write_document(map, \"{json}\", &self.{name})?;"),
            ),
            Type::Message if field.type_name() == ".google.protobuf.Timestamp" => text(
                format!("self.{name} = time(map)?;"),
                match form {
                    Form::Null => {
                        format!("map.serialize_entry(\"{name}\", &self.{name}.map(Time))?;")
                    }
                    Form::Always => format!(
                        "map.serialize_entry(\"{name}\", &Time(self.{name}.unwrap_or_default()))?;"
                    ),
                    _ => format!(
                        "if let Some(time) = self.{name} {{ map.serialize_entry(\"{name}\", &Time(time))?; }}"
                    ),
                },
            ),
            Type::Message if form == Form::Null => text(
                format!("self.{name} = message(map)?;"),
                format!(
                    "map.serialize_entry(\"{name}\", &self.{name}.as_ref().map(|message| Write {{ message, tensors }}))?;"
                ),
            ),
            Type::Message if form == Form::Always => text(
                format!("self.{name} = message(map)?;"),
                format!(
                    "write_message(map, \"{name}\", Some(self.{name}.as_ref().unwrap_or(&Default::default())), tensors)?;"
                ),
            ),
            Type::Message if field.type_name().ends_with(".Tensor") => {
                let dtype = match name {
                    _ if INDICES.contains(&name) => "Uint32",
                    _ if BYTES.contains(&name) => "Uint8",
                    _ => "Float32",
                };
                match oneof {
                    None => text(
                        format!("self.{name} = tensor(map, Dtype::{dtype})?;"),
                        format!("write_tensor(map, \"{name}\", self.{name}.as_ref(), tensors)?;"),
                    ),
                    Some(index) => {
                        let (group, variant) = member(message, index, inner, name);
                        text(
                            format!(
                                "only_one(&mut self.{group}, tensor(map, Dtype::{dtype})?.map({variant}))?;"
                            ),
                            format!(
                                "if let Some({variant}(value)) = &self.{group} {{ write_tensor(map, \"{name}\", Some(value), tensors)?; }}"
                            ),
                        )
                    }
                }
            }
            Type::Message if is_repeated => text(
                format!("self.{name} = messages(map)?;"),
                format!("write_messages(map, \"{name}\", &self.{name}, tensors)?;"),
            ),
            Type::Message => match oneof {
                None => text(
                    format!("self.{name} = message(map)?;"),
                    format!("write_message(map, \"{name}\", self.{name}.as_ref(), tensors)?;"),
                ),
                Some(index) => {
                    let (group, variant) = member(message, index, inner, name);
                    text(
                        format!("only_one(&mut self.{group}, message(map)?.map({variant}))?;"),
                        format!(
                            "if let Some({variant}(value)) = &self.{group} {{ write_message(map, \"{name}\", Some(value), tensors)?; }}"
                        ),
                    )
                }
            },
            Type::Enum => {
                let kind = rust_path(field.type_name());
                text(
                    format!("self.{name} = word::<{kind}, A>(map)?;"),
                    format!("write_word::<{kind}, M>(map, \"{name}\", self.{name})?;"),
                )
            }
            _ if oneof.is_some() => {
                let (group, variant) = member(message, oneof.unwrap_or_default(), inner, name);
                text(
                    format!(
                        "only_one(&mut self.{group}, map.next_value::<Option<_>>()?.map({variant}))?;"
                    ),
                    format!(
                        "if let Some({variant}(value)) = &self.{group} {{ map.serialize_entry(\"{name}\", value)?; }}"
                    ),
                )
            }
            _ if form == Form::Null && field.proto3_optional() => text(
                format!("self.{name} = map.next_value()?;"),
                format!("map.serialize_entry(\"{name}\", &self.{name})?;"),
            ),
            _ if form == Form::Null && !is_repeated => text(
                format!("self.{name} = map.next_value::<Option<_>>()?.unwrap_or_default();"),
                format!("map.serialize_entry(\"{name}\", &filled(&self.{name}))?;"),
            ),
            _ if field.proto3_optional() => text(
                format!("self.{name} = map.next_value()?;"),
                format!(
                    "if let Some(value) = &self.{name} {{ map.serialize_entry(\"{name}\", value)?; }}"
                ),
            ),
            _ => text(
                format!("self.{name} = map.next_value::<Option<_>>()?.unwrap_or_default();"),
                format!("map.serialize_entry(\"{name}\", &self.{name})?;"),
            ),
        }
    }
}

/// The group that a field belongs to, and its variant there.
fn member<'m>(
    message: &'m DescriptorProto,
    group: i32,
    inner: &str,
    field: &str,
) -> (&'m str, String) {
    let group = message.oneof_decl[group as usize].name();
    (group, format!("{inner}::{}::{}", camel_case(group), camel_case(field)))
}

/// `.bendtwin.v1.Cost.When` as `crate::v1::cost::When`.
pub(crate) fn rust_path(name: &str) -> String {
    let path = name.strip_prefix(PACKAGE).expect("a type of bendtwin.v1");
    let (outer, last) = path.rsplit_once('.').map_or((None, path), |(o, l)| (Some(o), l));
    let modules = outer.into_iter().flat_map(|o| o.split('.')).map(snake_case);
    let parts: Vec<String> = modules.chain([last.to_owned()]).collect();
    format!("crate::v1::{}", parts.join("::"))
}

/// The module of what is declared inside of a message.
fn module_of(message: &str) -> String {
    let path = message.strip_prefix(PACKAGE).expect("a type of bendtwin.v1");
    let modules: Vec<String> = path.split('.').map(snake_case).collect();
    format!("crate::v1::{}", modules.join("::"))
}

fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(c.to_lowercase());
    }
    snake
}

fn camel_case(name: &str) -> String {
    let words = name.split('_');
    words.map(|w| w[..1].to_uppercase() + &w[1..]).collect()
}
