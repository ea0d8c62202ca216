//! Compatibility of `bendtwin.v1` with clients of an older one: compares the public contract in two
//! folders of .proto files, and lists what is gone or changed. `proto/compatibility` runs it with a
//! revision of the repository. From 1.0 on it is a test against the last release.
//!
//! ```sh
//! cargo run -p bendtwin-proto --example compatibility -- OLD_FOLDER [NEW_FOLDER]
//! ```

use std::{collections::BTreeSet, path::Path, process::ExitCode};

use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};

const PACKAGE: &str = "bendtwin.v1";

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<ExitCode, Failure> {
    let folders: Vec<String> = std::env::args().skip(1).collect();
    let (old, new) = match &folders[..] {
        [old] => (old.as_str(), env!("CARGO_MANIFEST_DIR")),
        [old, new] => (old.as_str(), new.as_str()),
        _ => return Err("usage: compatibility OLD_FOLDER [NEW_FOLDER]".into()),
    };
    let (old, new) = (read(Path::new(old))?, read(Path::new(new))?);
    let broken: Vec<_> = broken(&old, &new).collect();
    for line in &broken {
        println!("gone or changed: {line}");
    }
    println!("{} of {} parts of {PACKAGE} are gone or changed", broken.len(), old.len());
    Ok(if broken.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Everything that a client of the .proto files in a folder can depend on.
fn read(folder: &Path) -> Result<BTreeSet<String>, Failure> {
    let package = folder.join("bendtwin/v1");
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&package).map_err(|e| format!("{}: {e}", package.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "proto") {
            files.push(path);
        }
    }
    Ok(describe(&protox::compile(files, [folder])?))
}

/// Old lines that no longer hold.
fn broken<'a>(
    old: &'a BTreeSet<String>,
    new: &'a BTreeSet<String>,
) -> impl Iterator<Item = &'a String> + 'a {
    old.iter().filter(|line| !new.contains(*line))
}

/// One line for each field, enum value and method of the package.
fn describe(set: &FileDescriptorSet) -> BTreeSet<String> {
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
        let kind = field_kind(message, field);
        lines.insert(format!("{scope}.{} = {} {kind}", field.name(), field.number()));
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
        let (name, value, number) = (enumeration.name(), value.name(), value.number());
        lines.insert(format!("{scope}.{name}.{value} = {number}"));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_break_is_seen() {
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
        let old = "M.a = 1 optional float\nM.b = 2 repeated M2\nE.ON = 1\nS.Call(A) -> stream B";
        let breaks =
            |from: &str, to: &str| broken(&lines(old), &lines(&old.replace(from, to))).count();
        assert_eq!(breaks("", ""), 0);
        assert_eq!(breaks("E.ON = 1", "E.ON = 1\nE.OFF = 2"), 0);
        for (from, to) in [
            ("M.a = 1 optional float\n", ""),
            ("M.a = 1", "M.a = 3"),
            ("float", "double"),
            ("M.a", "M.renamed"),
            ("repeated", "optional"),
            ("E.ON = 1", "E.ON = 2"),
            ("stream B", "B"),
        ] {
            assert_eq!(breaks(from, to), 1, "{from:?} -> {to:?}");
        }
    }

    #[test]
    fn the_contract_is_compatible_with_itself() {
        let lines = read(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap();
        assert!(lines.contains("bendtwin.v1.Fit.name = 1 string"), "{lines:?}");
        assert_eq!(broken(&lines, &lines).count(), 0);
    }
}
