//! Reasons of errors and codes of findings, read from the Rust sources: from the attributes that the
//! derive of `Problem` reads, from faults that are built by name, and from what the crates of captures
//! report.

#[path = "../../../../../crates/problem-derive/src/attribute.rs"]
#[expect(dead_code, reason = "the derive reads more of an attribute")]
mod attribute;

use std::collections::{BTreeMap, BTreeSet};

use quote::ToTokens as _;
use reqwest::StatusCode;
use syn::{
    Attribute, Expr, ExprAssign, ExprCall, ExprLit, ExprMethodCall, ExprStruct, ExprTuple, Fields,
    File, Item, ItemImpl, Lit, LitStr, Macro, visit, visit::Visit,
};

use self::attribute::{Category, Origin, Problem};
use crate::rules::workspace;

/// The file of the trait, the only one that may implement it by hand.
const TRAIT: &str = "crates/core/src/error.rs";

/// Crates whose words in capitals are codes of findings where they are no reasons.
const FINDERS: [&str; 8] = [
    "crates/calibrate/",
    "crates/capture/",
    "crates/core/",
    "crates/flow/",
    "crates/ingest/",
    "crates/inspect/",
    "crates/lift/",
    "crates/segment/",
];

/// Files with words in capitals of other vocabularies.
const OTHERS: [&str; 10] = [
    "client/cli/src/access/console.rs",
    "client/cli/src/rollout/implausible.rs",
    "crates/calibrate/src/board/dictionary.rs",
    "crates/calibrate/src/colmap/model.rs",
    "crates/capture/src/mocap/markers/c3d.rs",
    "crates/capture/src/raw/nerfstudio/",
    "crates/contract/src/rollout/implausible.rs",
    "crates/cuda/",
    "crates/exchange/src/gltf.rs",
    "proto/src/fault.rs",
];

/// Beginnings of words that name environment variables.
const ENVIRONMENT: [&str; 9] = [
    "AWS_",
    "BENDTWIN_",
    "CARGO_",
    "NO_COLOR",
    "OTEL_",
    "OUT_DIR",
    "RAYON_NUM_THREADS",
    "RUST_",
    "XDG_",
];

/// Public facts of a reason. Several where it is raised in several places.
#[derive(Debug, Default)]
pub(super) struct Reason {
    /// Names of the variants of `Category`.
    pub(super) categories: BTreeSet<String>,
    /// Statuses that only HTTP has.
    pub(super) statuses: BTreeSet<u16>,
    /// True if the category is that of the cause.
    pub(super) inherits: bool,
}

/// Everything that was found.
#[derive(Debug, Default)]
pub(super) struct Catalogue {
    /// Sources by reason.
    pub(super) reasons: BTreeMap<String, Reason>,
    /// Sources by code: meaning and advice where a table of the sources has them.
    pub(super) codes: BTreeMap<String, Option<[String; 2]>>,
    /// Words in capitals that are neither, with their file.
    pub(super) unknown: BTreeSet<(String, String)>,
}

/// Reads all sources but those of tests.
pub(super) fn read() -> Catalogue {
    let mut words = Catalogue::default();
    let mut loose = Vec::new();
    for (name, path) in workspace::files() {
        let tests = name.starts_with("tests/") || name.ends_with("tests.rs");
        let beside = ["/tests/", "/benches/", "/examples/", "/testing"];
        if !name.ends_with(".rs") || tests || beside.iter().any(|part| name.contains(part)) {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let file: File = syn::parse_file(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut visitor = Visitor {
            words: &mut words,
            file: &name,
            loose: Vec::new(),
            finds: FINDERS.iter().any(|finder| name.starts_with(finder))
                && !OTHERS.iter().any(|other| name.starts_with(other)),
            status: None,
            category: None,
        };
        visitor.visit_file(&file);
        loose.extend(visitor.loose.into_iter().map(|word| (word, name.clone())));
    }
    for (word, file) in loose {
        let known = words.reasons.contains_key(&word)
            || words.codes.contains_key(&word)
            || ENVIRONMENT.iter().any(|prefix| word.starts_with(prefix))
            || OTHERS.iter().any(|other| file.starts_with(other));
        if known {
            continue;
        }
        if FINDERS.iter().any(|finder| file.starts_with(finder)) {
            words.codes.entry(word).or_default();
        } else {
            words.unknown.insert((word, file));
        }
    }
    words
}

/// True for a text like `UPPER_SNAKE_CASE`, with an underscore.
fn in_capitals(text: &str) -> bool {
    let letter = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit();
    text.contains('_') && text.split('_').all(|p| !p.is_empty() && p.chars().all(letter))
}

struct Visitor<'a> {
    words: &'a mut Catalogue,
    /// Name of the file.
    file: &'a str,
    /// Words in capitals that were not recognised by their place.
    loose: Vec<String>,
    /// True if the first text of a call is the code of a finding.
    finds: bool,
    /// The category that was assigned last.
    category: Option<String>,
    /// The constant of `StatusCode` that was named last.
    status: Option<u16>,
}

impl Visitor<'_> {
    fn reason(&mut self, reason: &str, category: Option<String>) {
        let entry = self.words.reasons.entry(reason.to_owned()).or_default();
        match category {
            Some(category) => {
                entry.categories.insert(category);
            }
            None => entry.inherits = true,
        }
    }

    /// The reason beside a variant or a type.
    fn problem(&mut self, attribute: &Attribute) {
        let found = Problem::all(std::slice::from_ref(attribute));
        for problem in found.unwrap_or_else(|e| panic!("{}: {e}", self.file)) {
            // A transparent error passes on the reason of its cause.
            let Origin::Stated { category, reason } = problem.origin else { continue };
            let category = match category {
                Category::Named(name) => Some(name.to_string()),
                Category::Computed(_) => None,
            };
            self.reason(&reason.value(), category);
        }
    }

    fn code(&mut self, arguments: &[String]) {
        let Some(code) = arguments.first().filter(|a| in_capitals(a)) else { return };
        let about = match arguments {
            [_, meaning, advice] => Some([meaning.clone(), advice.clone()]),
            _ => None,
        };
        let entry = self.words.codes.entry(code.clone()).or_default();
        *entry = entry.take().or(about);
    }

    /// Recognises a category and a reason that stand in one list of arguments.
    fn arguments<'e>(&mut self, arguments: impl Iterator<Item = &'e Expr>) {
        let arguments: Vec<_> = arguments.collect();
        let category = arguments.iter().find_map(|a| category_of(a));
        let passed_on = arguments.iter().any(|a| a.to_token_stream().to_string() == "category");
        let reason = arguments.iter().find_map(|a| text_of(a)).filter(|r| is_reason(r));
        match reason {
            Some(reason) if category.is_some() || passed_on => self.reason(&reason, category),
            Some(code) if self.finds && in_capitals(&code) => {
                self.words.codes.entry(code).or_default();
            }
            _ => {}
        }
    }
}

impl<'ast> Visit<'ast> for Visitor<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes: &[Attribute] = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            _ => &[],
        };
        if !attributes.iter().any(|a| a.to_token_stream().to_string().contains("cfg (test)")) {
            visit::visit_item(self, item);
        }
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        self.problem(attribute);
    }

    fn visit_item_impl(&mut self, item: &'ast ItemImpl) {
        let of = item.trait_.as_ref().and_then(|(path, _)| path.segments.last());
        let by_hand = of.is_some_and(|of| of.ident == "Problem") && self.file != TRAIT;
        assert!(!by_hand, "{}: derive `Problem`", self.file);
        visit::visit_item_impl(self, item);
    }

    fn visit_expr_assign(&mut self, expr: &'ast ExprAssign) {
        if let Expr::Field(field) = &*expr.left {
            match field.member.to_token_stream().to_string().as_str() {
                "category" => self.category = category_of(&expr.right),
                "reason" => {
                    if let Some(reason) = text_of(&expr.right) {
                        self.reason(&reason, self.category.clone());
                    }
                }
                _ => {}
            }
        }
        visit::visit_expr_assign(self, expr);
    }

    fn visit_expr_struct(&mut self, expr: &'ast ExprStruct) {
        self.arguments(expr.fields.iter().map(|field| &field.expr));
        for field in &expr.fields {
            if field.member.to_token_stream().to_string() == "code" {
                self.code(&text_of(&field.expr).into_iter().collect::<Vec<_>>());
            }
        }
        visit::visit_expr_struct(self, expr);
    }

    fn visit_expr_tuple(&mut self, expr: &'ast ExprTuple) {
        self.arguments(expr.elems.iter());
        visit::visit_expr_tuple(self, expr);
    }

    fn visit_expr_method_call(&mut self, expr: &'ast ExprMethodCall) {
        self.arguments(expr.args.iter());
        visit::visit_expr_method_call(self, expr);
    }

    fn visit_expr_call(&mut self, expr: &'ast ExprCall) {
        let path = expr.func.to_token_stream().to_string();
        let texts: Vec<_> = expr.args.iter().filter_map(text_of).collect();
        self.arguments(expr.args.iter());
        visit::visit_expr_call(self, expr);
        if path.ends_with("http_only")
            && let (Some(reason), Some(status)) = (texts.first(), self.status)
        {
            self.reason(reason, Some("InvalidArgument".to_owned()));
            self.words.reasons.entry(reason.clone()).or_default().statuses.insert(status);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<_> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if let [.., of, name] = &segments[..]
            && of == "StatusCode"
        {
            self.status = status(name).or(self.status);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, mac: &'ast Macro) {
        if mac.path.is_ident("codes") {
            let tokens = mac.tokens.clone().into_iter();
            let texts: Vec<_> = tokens
                .filter_map(|token| syn::parse2::<LitStr>(token.into()).ok())
                .map(|text| text.value())
                .collect();
            texts.chunks(3).for_each(|about| self.code(about));
            return;
        }
        for word in mac.tokens.to_string().split('"').skip(1).step_by(2) {
            if in_capitals(word) {
                self.loose.push(word.to_owned());
            }
        }
    }

    fn visit_lit_str(&mut self, text: &'ast LitStr) {
        if in_capitals(&text.value()) {
            self.loose.push(text.value());
        }
    }

    fn visit_fields(&mut self, _: &'ast Fields) {}
}

fn is_reason(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c == '_' || c.is_ascii_uppercase())
}

/// The status of a constant of `StatusCode`.
fn status(name: &str) -> Option<u16> {
    (100..600).find(|&code| {
        let reason = StatusCode::from_u16(code).ok().and_then(|s| s.canonical_reason());
        reason.is_some_and(|r| r.to_uppercase().replace([' ', '-'], "_") == name)
    })
}

/// A text literal, also where it is made a `String` of.
fn text_of(expr: &Expr) -> Option<String> {
    match expr {
        Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
        Expr::MethodCall(call) if call.args.is_empty() => text_of(&call.receiver),
        Expr::Reference(reference) => text_of(&reference.expr),
        _ => None,
    }
}

/// The variant of `Category` that an expression names.
fn category_of(expr: &Expr) -> Option<String> {
    let Expr::Path(path) = expr else { return None };
    let segments: Vec<_> = path.path.segments.iter().map(|s| s.ident.to_string()).collect();
    match &segments[..] {
        [.., of, name] if of == "Category" => Some(name.clone()),
        _ => None,
    }
}
