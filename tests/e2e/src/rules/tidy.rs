//! The rules of CONTRIBUTING.md that a program can check.

use std::path::Path;

use super::workspace;

const MAX_LINES: usize = 600;

/// Words that no text of the project has. Split, so that this file does not have them either.
const FORBIDDEN: [(&str, &str); 7] = [
    ("TO", "DO"),
    ("FIX", "ME"),
    ("XX", "X"),
    ("to", "do!"),
    ("unimple", "mented!"),
    ("/wo", "rk/"),
    ("/ro", "ot/"),
];

/// Names that do not describe their content.
const EMPTY_NAMES: [&str; 6] = ["util", "utils", "helper", "helpers", "common", "misc"];

#[test]
fn files_are_small() {
    let long: Vec<_> = texts()
        .filter(|(name, _)| has_extension(name, &["rs", "py", "cu", "ts", "proto"]))
        .map(|(name, text)| (name, text.lines().count()))
        .filter(|(_, lines)| *lines > MAX_LINES)
        .collect();
    assert!(long.is_empty(), "over {MAX_LINES} lines, is there a second idea inside? {long:?}");
}

#[test]
fn nothing_is_left_for_later_and_no_machine_is_named() {
    let mut found = Vec::new();
    for (name, text) in texts() {
        for (number, line) in text.lines().enumerate() {
            for (a, b) in FORBIDDEN {
                let word = format!("{a}{b}");
                if contains_word(line, &word) {
                    found.push(format!("{name}:{}: {word}", number + 1));
                }
            }
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn modules_are_named_after_their_content() {
    let vague = |name: &str| {
        let path = Path::new(name);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let parts = path.components().map(|c| c.as_os_str().to_string_lossy());
        (has_extension(name, &["rs"]) && stem == "mod")
            || EMPTY_NAMES.contains(&stem.as_ref())
            || parts.into_iter().any(|p| EMPTY_NAMES.contains(&p.as_ref()))
    };
    let found: Vec<_> = texts().map(|(name, _)| name).filter(|name| vague(name)).collect();
    assert!(
        found.is_empty(),
        "foo.rs and foo/ instead of mod.rs, and names that say what is inside: {found:?}"
    );
}

#[test]
fn every_rust_file_says_what_it_is() {
    let silent: Vec<_> = texts()
        .filter(|(name, _)| has_extension(name, &["rs"]) && !name.ends_with("tests.rs"))
        .filter(|(name, _)| !name.contains("/tests/"))
        .filter(|(_, text)| !text.starts_with("//!"))
        .map(|(name, _)| name)
        .collect();
    assert!(silent.is_empty(), "start with `//!` and what the file is for: {silent:?}");
}

#[test]
fn links_between_documents_lead_somewhere() {
    let mut dead = Vec::new();
    for (name, text) in texts().filter(|(name, _)| has_extension(name, &["md"])) {
        let file = workspace::root().join(&name);
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
            let outside = path.contains("://") || path.starts_with("mailto:");
            let linked = match path {
                "" => file.clone(),
                path => file.parent().unwrap().join(path),
            };
            let is_dead = !linked.exists()
                || !anchor.is_empty()
                    && has_extension(path, &["", "md"])
                    && !has_heading(&linked, anchor);
            if !outside && is_dead {
                dead.push(format!("{name}: {target}"));
            }
        }
    }
    assert!(dead.is_empty(), "\n{}", dead.join("\n"));
}

/// True if a document has a heading with this anchor: in lower case, hyphens for spaces, without
/// punctuation.
fn has_heading(document: &Path, anchor: &str) -> bool {
    let text = std::fs::read_to_string(document).unwrap();
    let is_kept = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| line.trim_start_matches('#').trim().to_lowercase())
        .map(|heading| heading.chars().filter(is_kept).collect::<String>().replace(' ', "-"))
        .any(|heading| heading == anchor)
}

/// All files that are text.
fn texts() -> impl Iterator<Item = (String, String)> {
    let files = workspace::files();
    assert!(files.len() > 50, "the source tree was not found");
    files.into_iter().filter_map(|(name, path)| {
        let bytes = std::fs::read(path).unwrap();
        String::from_utf8(bytes).ok().map(|text| (name, text))
    })
}

fn has_extension(name: &str, wanted: &[&str]) -> bool {
    let extension = Path::new(name).extension().unwrap_or_default().to_string_lossy();
    wanted.contains(&extension.as_ref())
}

/// True if `word` is in the line with no letter right before or after it.
fn contains_word(line: &str, word: &str) -> bool {
    line.match_indices(word).any(|(at, _)| {
        let letter = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        !letter(line[..at].chars().next_back()) && !letter(line[at + word.len()..].chars().next())
    })
}
