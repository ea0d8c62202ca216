//! docs/use/errors.md lists every reason of an error and every code of a finding, once, with what a
//! client sees of it.
//!
//! `BENDTWIN_BLESS=1 cargo test -p bendtwin-e2e reasons` rewrites the tables: names, categories and
//! statuses come from the sources, the last column stays. A new row has an empty one, which this
//! test refuses until it is filled in.

mod sources;

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use bendtwin_core::Category;
use bendtwin_proto::fault::{category_name, code};

use super::workspace;

const REASONS: &str = "| reason | category | HTTP | gRPC | what to do |\n|---|---|--:|--:|---|\n";
const CODES: &str = "| code | meaning | what to do |\n|---|---|---|\n";

#[test]
fn every_reason_and_code_is_listed_once_with_advice() {
    let words = sources::read();
    assert!(words.reasons.len() > 100, "the sources were not read");
    let path = page();
    let old = std::fs::read_to_string(&path).unwrap();
    let new = written(&old, &words);
    if std::env::var_os("BENDTWIN_BLESS").is_some() {
        std::fs::write(&path, &new).unwrap();
    } else {
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
        let missing: Vec<_> = lines(&new).difference(&lines(&old)).cloned().collect();
        let surplus: Vec<_> = lines(&old).difference(&lines(&new)).cloned().collect();
        assert!(
            old == new,
            "docs/use/errors.md is not what the sources say; `BENDTWIN_BLESS=1 cargo test -p bendtwin-e2e reasons` \
             writes it anew.\nmissing: {missing:#?}\nsurplus: {surplus:#?}"
        );
    }
    let empty: Vec<_> =
        new.lines().filter(|l| l.starts_with("| `") && l.ends_with("|  |")).collect();
    assert!(empty.is_empty(), "say what to do: {empty:#?}");
}

#[test]
fn every_word_in_capitals_is_a_reason_or_a_code() {
    let unknown = sources::read().unknown;
    assert!(
        unknown.is_empty(),
        "neither a reason beside its category nor the code of a finding; if it is something else, name its file or \
         its beginning in reasons/sources.rs: {unknown:#?}"
    );
}

fn page() -> PathBuf {
    workspace::root().join("docs/use/errors.md")
}

/// The page with both tables rewritten.
fn written(old: &str, words: &sources::Catalogue) -> String {
    let (before, rest) = old.split_once(REASONS).expect("the table of reasons");
    let (reasons, rest) = table(rest);
    let (between, rest) = rest.split_once(CODES).expect("the table of codes");
    let (codes, after) = table(rest);
    let mut text = format!("{before}{REASONS}");
    for (name, about) in &words.reasons {
        let advice = reasons.get(name).and_then(|cells| cells.last()).map_or("", |cell| cell);
        let [category, http, grpc] = seen(about);
        text += &format!("| `{name}` | {category} | {http} | {grpc} | {advice} |\n");
    }
    text += between;
    text += CODES;
    for (name, about) in &words.codes {
        let kept = || match codes.get(name).map(Vec::as_slice) {
            Some([.., meaning, advice]) => [meaning.clone(), advice.clone()],
            _ => Default::default(),
        };
        let [meaning, advice] = about.clone().unwrap_or_else(kept);
        text += &format!("| `{name}` | {meaning} | {advice} |\n");
    }
    text + after
}

/// The rows of a table by name, and what follows it.
fn table(text: &str) -> (BTreeMap<String, Vec<String>>, &str) {
    let end = text.split_inclusive('\n').take_while(|l| l.starts_with('|')).map(str::len).sum();
    let (rows, after) = text.split_at(end);
    let row = |line: &str| {
        let cells: Vec<_> =
            line.trim_matches('|').split(" | ").map(|c| c.trim().to_owned()).collect();
        (cells[0].trim_matches('`').to_owned(), cells)
    };
    (rows.lines().map(row).collect(), after)
}

/// Category, HTTP status and gRPC code.
fn seen(reason: &sources::Reason) -> [String; 3] {
    let of = |name: &String| {
        *Category::ALL
            .iter()
            .find(|c| format!("{c:?}") == *name)
            .unwrap_or_else(|| panic!("category {name}"))
    };
    let categories: Vec<_> = reason.categories.iter().map(of).collect();
    let mut http: BTreeSet<_> = reason.statuses.clone();
    let only_http = !http.is_empty() && categories == [Category::InvalidArgument];
    if !only_http {
        http.extend(categories.iter().map(|c| bendtwin_server::http_status(*c).as_u16()));
    }
    let grpc: BTreeSet<_> = categories.iter().map(|c| code(*c) as i32).collect();
    let mut names: BTreeSet<_> = categories.iter().map(|c| category_name(*c).to_owned()).collect();
    if reason.inherits {
        names.insert("that of its cause".to_owned());
    }
    let cell =
        |parts: Vec<String>| if parts.is_empty() { "-".to_owned() } else { parts.join(", ") };
    [
        cell(names.into_iter().collect()),
        cell(http.iter().map(u16::to_string).collect()),
        cell(if only_http { Vec::new() } else { grpc.iter().map(i32::to_string).collect() }),
    ]
}
