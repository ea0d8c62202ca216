//! The public contract only grows. `released/v1.txt` lists what clients may rely on, a line for each
//! field, enum value and method; a line that is gone or changed breaks clients that exist.
//!
//! What is new gets listed at a release:
//! `BENDTWIN_RELEASE=1 cargo test -p bendtwin-proto --test compatibility`.

use std::collections::BTreeSet;

use prost::Message as _;
use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};

const PACKAGE: &str = "bendtwin.v1";

fn released_path() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("released/v1.txt")
}

#[test]
fn nothing_released_was_removed_renumbered_or_retyped() {
    let current = describe(bendtwin_proto::DESCRIPTORS);
    let released = std::fs::read_to_string(released_path()).unwrap_or_default();
    let broken: Vec<_> = broken(&released, &current).collect();
    assert!(
        broken.is_empty(),
        "released parts of {PACKAGE} are gone or changed; restore them and add new fields beside them:\n{}",
        broken.join("\n")
    );
    if std::env::var_os("BENDTWIN_RELEASE").is_some() {
        let lines: Vec<_> = current.into_iter().collect();
        std::fs::write(released_path(), lines.join("\n") + "\n").unwrap();
    } else {
        assert!(!released.is_empty(), "{} is missing or empty", released_path().display());
    }
}

#[test]
fn the_guard_sees_each_kind_of_break() {
    let released = "M.a = 1 optional float\nM.b = 2 repeated M2\nE.ON = 1\nS.Call(A) -> stream B";
    let keeps = |changes: &[(&str, &str)]| {
        let changed = changes.iter().fold(released.to_owned(), |s, (a, b)| s.replace(a, b));
        broken(released, &changed.lines().map(str::to_owned).collect()).count()
    };
    assert_eq!(keeps(&[]), 0);
    assert_eq!(keeps(&[("E.ON = 1", "E.ON = 1\nE.OFF = 2")]), 0);
    for change in [
        ("M.a = 1 optional float\n", ""),
        ("M.a = 1", "M.a = 3"),
        ("float", "double"),
        ("M.a", "M.renamed"),
        ("repeated", "optional"),
        ("E.ON = 1", "E.ON = 2"),
        ("stream B", "B"),
    ] {
        assert_eq!(keeps(&[change]), 1, "{change:?}");
    }
}

/// Released lines that no longer hold.
fn broken<'a>(
    released: &'a str,
    current: &'a BTreeSet<String>,
) -> impl Iterator<Item = &'a str> + 'a {
    released.lines().filter(|line| !current.contains(*line))
}

/// Everything that a client can depend on, one line each.
fn describe(descriptors: &[u8]) -> BTreeSet<String> {
    let set = FileDescriptorSet::decode(descriptors).unwrap();
    let mut lines = BTreeSet::new();
    for file in set.file.iter().filter(|f| f.package() == PACKAGE) {
        for message in &file.message_type {
            describe_message(PACKAGE, message, &mut lines);
        }
        for enumeration in &file.enum_type {
            describe_enum(PACKAGE, enumeration, &mut lines);
        }
        for service in &file.service {
            for method in &service.method {
                let stream = |on: bool| if on { "stream " } else { "" };
                lines.insert(format!(
                    "{PACKAGE}.{}.{}({}{}) -> {}{}",
                    service.name(),
                    method.name(),
                    stream(method.client_streaming()),
                    method.input_type(),
                    stream(method.server_streaming()),
                    method.output_type(),
                ));
            }
        }
    }
    lines
}

fn describe_message(scope: &str, message: &DescriptorProto, lines: &mut BTreeSet<String>) {
    let scope = format!("{scope}.{}", message.name());
    for field in &message.field {
        lines.insert(format!(
            "{scope}.{} = {} {}",
            field.name(),
            field.number(),
            field_kind(message, field)
        ));
    }
    for nested in &message.nested_type {
        describe_message(&scope, nested, lines);
    }
    for enumeration in &message.enum_type {
        describe_enum(&scope, enumeration, lines);
    }
}

fn describe_enum(scope: &str, enumeration: &EnumDescriptorProto, lines: &mut BTreeSet<String>) {
    for value in &enumeration.value {
        lines.insert(format!(
            "{scope}.{}.{} = {}",
            enumeration.name(),
            value.name(),
            value.number()
        ));
    }
}

fn field_kind(message: &DescriptorProto, field: &FieldDescriptorProto) -> String {
    let kind = match field.r#type() {
        Type::Message | Type::Enum => field.type_name().to_owned(),
        scalar => scalar.as_str_name().trim_start_matches("TYPE_").to_lowercase(),
    };
    let presence = match (field.label(), field.oneof_index) {
        (Label::Repeated, _) => "repeated ".to_owned(),
        (_, Some(_)) if field.proto3_optional() => "optional ".to_owned(),
        (_, Some(i)) => {
            let oneof = usize::try_from(i).ok().and_then(|i| message.oneof_decl.get(i));
            format!("oneof {} ", oneof.map_or("?", |o| o.name()))
        }
        _ => String::new(),
    };
    format!("{presence}{kind}")
}
