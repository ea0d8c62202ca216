//! Writes the implementations of `json::Fields` and `json::Words` for the messages of some files,
//! from their descriptors: which fields they have and of which kind.

use std::fmt::Write as _;

use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    field_descriptor_proto::{Label, Type},
};

/// Tensors whose lists in JSON are of UINT32; all others are of FLOAT32.
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

/// The implementations as Rust code.
pub(crate) fn implementations<'f>(
    files: impl IntoIterator<Item = &'f FileDescriptorProto>,
) -> String {
    let mut code = String::new();
    for file in files {
        for message in &file.message_type {
            self::message(message, "crate::v1", &mut code);
        }
        for words in &file.enum_type {
            self::words(words, "crate::v1", &mut code);
        }
    }
    code
}

fn message(message: &DescriptorProto, module: &str, code: &mut String) {
    let inner = format!("{module}::{}", snake_case(message.name()));
    let names: Vec<&str> = message.field.iter().map(FieldDescriptorProto::name).collect();
    let (mut read, mut write) = (String::new(), String::new());
    for (index, field) in message.field.iter().enumerate() {
        let lines = Lines::of(message, field, &inner);
        writeln!(read, "{index} => {{ {} }}", lines.read).unwrap();
        writeln!(write, "{}", lines.write).unwrap();
    }
    write!(
        code,
        r#"
impl Fields for {module}::{name} {{
    const NAME: &'static str = "{name}";
    const FIELDS: &'static [&'static str] = &{names:?};
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
"#,
        name = message.name(),
    )
    .unwrap();
    for nested in &message.nested_type {
        self::message(nested, &inner, code);
    }
    for words in &message.enum_type {
        self::words(words, &inner, code);
    }
}

fn words(words: &EnumDescriptorProto, module: &str, code: &mut String) {
    let known = words.value.iter().filter(|v| v.number() != 0).map(|v| v.name().to_owned());
    let known: Vec<String> = known.collect();
    write!(
        code,
        r#"
impl Words for {module}::{name} {{
    const KNOWN: &'static [&'static str] = &{known:?};
    fn number(word: &str) -> Option<i32> {{
        Self::from_str_name(word).map(Into::into)
    }}
    fn word(number: i32) -> Option<&'static str> {{
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }}
}}
"#,
        name = words.name(),
    )
    .unwrap();
}

/// The code that reads a field and that writes it.
struct Lines {
    read: String,
    write: String,
}

impl Lines {
    fn of(message: &DescriptorProto, field: &FieldDescriptorProto, inner: &str) -> Self {
        let name = field.name();
        let is_repeated = field.label() == Label::Repeated;
        let oneof = field.oneof_index.filter(|_| !field.proto3_optional());
        let text = |read: String, write: String| Self { read, write };
        match field.r#type() {
            Type::Message if field.type_name().ends_with(".Tensor") => {
                let dtype = if INDICES.contains(&name) { "Uint32" } else { "Float32" };
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
fn rust_path(name: &str) -> String {
    let path = name.strip_prefix(".bendtwin.v1.").expect("a type of bendtwin.v1");
    let (outer, last) = path.rsplit_once('.').map_or((None, path), |(o, l)| (Some(o), l));
    let modules = outer.into_iter().flat_map(|o| o.split('.')).map(snake_case);
    let parts: Vec<String> = modules.chain([last.to_owned()]).collect();
    format!("crate::v1::{}", parts.join("::"))
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
