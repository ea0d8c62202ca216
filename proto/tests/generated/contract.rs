//! The contract as the generators read it: descriptors, and what the options of `options.proto` say
//! of RPCs and fields.

use std::collections::{BTreeMap, BTreeSet};

use prost_types::{
    DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorSet,
    field_descriptor_proto::{Label, Type},
};
use protox::prost_reflect::{DescriptorPool, DynamicMessage, ReflectMessage as _, Value};

/// Fields of requests that HTTP does not have in a body or a query.
const ELSEWHERE: [&str; 3] = ["request_id", "update_mask", "after_revision"];

/// Descriptors and options.
pub(crate) struct Contract {
    pub(crate) set: FileDescriptorSet,
    pub(crate) rpcs: Vec<Rpc>,
    messages: BTreeMap<String, DescriptorProto>,
    enums: BTreeMap<String, EnumDescriptorProto>,
    fields: BTreeMap<(String, String), JsonField>,
}

/// An RPC of a server.
#[derive(Clone)]
pub(crate) struct Rpc {
    pub(crate) package: String,
    pub(crate) service: String,
    pub(crate) name: String,
    /// Full names of messages, with a dot before them.
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) is_streaming: bool,
    /// Word of the enum `Scope`.
    pub(crate) scope: String,
    pub(crate) audited: bool,
    pub(crate) routes: Vec<Route>,
    /// Place of the method in its file, for its comment: service, method.
    pub(crate) place: (String, i32, i32),
}

/// A route of an RPC.
#[derive(Clone)]
pub(crate) struct Route {
    pub(crate) method: String,
    pub(crate) path: String,
    /// The field that the id goes to; empty if the path has none.
    pub(crate) id: String,
    pub(crate) status: u32,
    pub(crate) location: String,
    pub(crate) secret: bool,
    pub(crate) tensors: bool,
    pub(crate) by_hand: bool,
}

/// Options of a field.
#[derive(Clone, Default)]
pub(crate) struct JsonField {
    pub(crate) form: Form,
    pub(crate) changeable: bool,
    pub(crate) required: bool,
    pub(crate) pattern: String,
    pub(crate) max_length: u32,
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Form {
    #[default]
    Usual,
    Nested,
    Null,
    Always,
}

impl Contract {
    pub(crate) fn read(set: FileDescriptorSet, pool: &DescriptorPool) -> Self {
        let mut contract = Self {
            set: set.clone(),
            rpcs: Vec::new(),
            messages: BTreeMap::new(),
            enums: BTreeMap::new(),
            fields: BTreeMap::new(),
        };
        for file in set.file.iter().filter(|f| f.package().starts_with("bendtwin.")) {
            let scope = format!(".{}", file.package());
            for message in &file.message_type {
                contract.collect(&scope, message, pool);
            }
            for words in &file.enum_type {
                contract.enums.insert(format!("{scope}.{}", words.name()), words.clone());
            }
        }
        contract.rpcs = rpcs(&set, pool);
        contract
    }

    fn collect(&mut self, scope: &str, message: &DescriptorProto, pool: &DescriptorPool) {
        let name = format!("{scope}.{}", message.name());
        let known = pool.get_message_by_name(&name[1..]).unwrap();
        for field in &message.field {
            let options = known.get_field_by_name(field.name()).unwrap().options();
            if let Some(Value::Message(options)) = extension(&options, pool, "json") {
                let json = JsonField {
                    form: match number(&options, "form") {
                        1 => Form::Nested,
                        2 => Form::Null,
                        3 => Form::Always,
                        _ => Form::Usual,
                    },
                    changeable: flag(&options, "changeable"),
                    required: flag(&options, "required"),
                    pattern: text(&options, "pattern"),
                    max_length: number(&options, "max_length"),
                };
                self.fields.insert((name.clone(), field.name().to_owned()), json);
            }
        }
        for nested in &message.nested_type {
            self.collect(&name, nested, pool);
        }
        for words in &message.enum_type {
            self.enums.insert(format!("{name}.{}", words.name()), words.clone());
        }
        self.messages.insert(name, message.clone());
    }

    /// The options of a field of a message.
    pub(crate) fn field(&self, message: &str, field: &str) -> JsonField {
        self.fields.get(&(message.to_owned(), field.to_owned())).cloned().unwrap_or_default()
    }

    pub(crate) fn message(&self, name: &str) -> &DescriptorProto {
        &self.messages[name]
    }

    /// Words of an enum but the one for none.
    pub(crate) fn words(&self, name: &str) -> Vec<String> {
        let values = &self.enums[name].value;
        values.iter().filter(|v| v.number() != 0).map(|v| v.name().to_owned()).collect()
    }

    /// The messages that HTTP has as JSON, and the enums in them, by full name.
    pub(crate) fn in_json(&self) -> BTreeSet<String> {
        let described = self.rpcs.iter().filter(|rpc| rpc.routes.iter().any(|r| !r.by_hand));
        let roots = described.flat_map(|rpc| [rpc.input.as_str(), rpc.output.as_str()]);
        let uploads = self.rpcs.iter().filter_map(|rpc| self.metadata(rpc));
        self.parts(roots.chain(uploads).chain([".bendtwin.v1.Fault"]))
    }

    /// The message that an upload begins with, which HTTP has as its query.
    pub(crate) fn metadata(&self, rpc: &Rpc) -> Option<&str> {
        let mut parts = self.messages.get(&rpc.input)?.field.iter();
        let is_upload = rpc.routes.iter().any(|route| route.method == "POST" && route.by_hand);
        let metadata = parts.find(|field| is_upload && field.name() == "metadata")?;
        Some(metadata.type_name())
    }

    /// Messages, and all messages and enums that they have, tensors and times apart.
    pub(crate) fn parts<'n>(&self, roots: impl IntoIterator<Item = &'n str>) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        let mut open: Vec<String> = roots.into_iter().map(str::to_owned).collect();
        while let Some(name) = open.pop() {
            if !name.starts_with(".bendtwin.") || is_tensor(&name) || !found.insert(name.clone()) {
                continue;
            }
            let fields = self.messages.get(&name).into_iter().flat_map(|message| &message.field);
            let types = fields.filter(|f| matches!(f.r#type(), Type::Message | Type::Enum));
            open.extend(types.map(|field| field.type_name().to_owned()));
        }
        found
    }

    /// True if a message has tensors somewhere.
    pub(crate) fn has_tensors(&self, message: &str) -> bool {
        let parts = self.parts([message]);
        parts.iter().filter_map(|name| self.messages.get(name)).any(|message| {
            message.field.iter().any(|f| f.r#type() == Type::Message && is_tensor(f.type_name()))
        })
    }

    /// The fields of a message in JSON: of an update those of its resource that may change, and none
    /// that a route takes from elsewhere.
    pub(crate) fn shown(&self, name: &str) -> Vec<Shown> {
        let message = self.message(name);
        let is_update = message.field.iter().any(|field| field.name() == "update_mask");
        let bound = self.bound(name);
        let mut shown = Vec::new();
        for (index, field) in (0..).zip(&message.field) {
            if is_elsewhere(field.name(), &bound) {
                continue;
            }
            if is_update && field.r#type() == Type::Message {
                let resource = field.type_name();
                for (index, part) in (0..).zip(&self.message(resource).field) {
                    if self.field(resource, part.name()).changeable {
                        let of = (resource.to_owned(), index);
                        let inside = Some(field.name().to_owned());
                        shown.push(Shown { field: part.clone(), of, inside });
                    }
                }
                continue;
            }
            let of = (name.to_owned(), index);
            shown.push(Shown { field: field.clone(), of, inside: None });
        }
        shown
    }

    /// The field of a request that the paths of its routes give. Bodies with tensors may repeat it.
    fn bound(&self, message: &str) -> Vec<String> {
        let mine = self.rpcs.iter().filter(|rpc| rpc.input == message);
        let routes = mine.flat_map(|rpc| &rpc.routes);
        let alone = routes.filter(|r| !r.by_hand && (!r.tensors || r.method == "GET"));
        alone.map(|r| r.id.clone()).filter(|id| !id.is_empty()).collect()
    }
}

/// A field as JSON has it.
pub(crate) struct Shown {
    pub(crate) field: FieldDescriptorProto,
    /// The message that declares it, and its place there.
    pub(crate) of: (String, i32),
    /// The field of an update in which it is.
    pub(crate) inside: Option<String>,
}

impl Shown {
    /// Its name in JSON.
    pub(crate) fn name(&self, contract: &Contract) -> String {
        let name = self.field.name();
        let is_nested = contract.field(&self.of.0, name).form == Form::Nested;
        name.strip_suffix("_json").filter(|_| is_nested).unwrap_or(name).to_owned()
    }
}

fn is_elsewhere(field: &str, bound: &[String]) -> bool {
    ELSEWHERE.contains(&field) || bound.iter().any(|id| id == field)
}

pub(crate) fn is_tensor(name: &str) -> bool {
    name.ends_with(".Tensor")
}

pub(crate) fn is_repeated(field: &FieldDescriptorProto) -> bool {
    field.label() == Label::Repeated
}

fn rpcs(set: &FileDescriptorSet, pool: &DescriptorPool) -> Vec<Rpc> {
    let mut rpcs = Vec::new();
    for service in pool.services() {
        let of_all = extension(&service.options(), pool, "scope_of_all");
        let file = service.parent_file().name().to_owned();
        let described = set.file.iter().find(|f| f.name() == file).unwrap();
        let at = described.service.iter().position(|s| s.name() == service.name()).unwrap();
        for (index, method) in (0..).zip(service.methods()) {
            let options = method.options();
            let Some(scope) = extension(&options, pool, "scope").or_else(|| of_all.clone()) else {
                assert_eq!(service.name(), "WorkerRollouts", "{} has no scope", method.full_name());
                continue;
            };
            let routes = match extension(&options, pool, "route") {
                Some(Value::List(routes)) => routes,
                _ => Vec::new(),
            };
            let output = format!(".{}", method.output().full_name());
            rpcs.push(Rpc {
                package: service.package_name().to_owned(),
                service: service.name().to_owned(),
                name: method.name().to_owned(),
                input: format!(".{}", method.input().full_name()),
                is_streaming: method.is_server_streaming(),
                scope: scope_word(pool, &scope),
                audited: matches!(extension(&options, pool, "audited"), Some(Value::Bool(true))),
                routes: routes.iter().map(|r| route(r, method.output().fields().len())).collect(),
                output,
                place: (file.clone(), i32::try_from(at).unwrap(), index),
            });
        }
    }
    rpcs
}

fn route(value: &Value, fields_of_reply: usize) -> Route {
    let Value::Message(route) = value else { panic!("a route is a message") };
    let methods = ["get", "post", "put", "patch", "delete"];
    let given = methods.into_iter().find(|method| route.has_field_by_name(method));
    let method = given.expect("a route has a method");
    let path = text(route, method);
    let id = Some(text(route, "id")).filter(|id| !id.is_empty()).unwrap_or("name".to_owned());
    let status = match number(route, "status") {
        0 if fields_of_reply == 0 => 204,
        0 => 200,
        status => status,
    };
    Route {
        method: method.to_uppercase(),
        id: if path.contains("{id}") { id } else { String::new() },
        path,
        status,
        location: text(route, "location"),
        secret: flag(route, "secret"),
        tensors: flag(route, "tensors"),
        by_hand: flag(route, "by_hand"),
    }
}

fn scope_word(pool: &DescriptorPool, scope: &Value) -> String {
    let Value::EnumNumber(number) = scope else { panic!("a scope is a word") };
    let scopes = pool.get_enum_by_name("bendtwin.v1.Scope").unwrap();
    scopes.get_value(*number).unwrap().name().to_owned()
}

/// The value of an option that is given.
fn extension(options: &DynamicMessage, pool: &DescriptorPool, name: &str) -> Option<Value> {
    let of = options.descriptor();
    let named = format!("bendtwin.v1.{name}");
    let found = pool.all_extensions().find(|extension| {
        extension.full_name() == named
            && extension.containing_message().full_name() == of.full_name()
    })?;
    options.has_extension(&found).then(|| options.get_extension(&found).into_owned())
}

fn text(message: &DynamicMessage, field: &str) -> String {
    let value = message.get_field_by_name(field).unwrap();
    value.as_str().unwrap().to_owned()
}

fn flag(message: &DynamicMessage, field: &str) -> bool {
    message.get_field_by_name(field).unwrap().as_bool().unwrap()
}

fn number(message: &DynamicMessage, field: &str) -> u32 {
    match *message.get_field_by_name(field).unwrap() {
        Value::EnumNumber(number) => u32::try_from(number).unwrap(),
        ref value => value.as_u32().unwrap(),
    }
}
