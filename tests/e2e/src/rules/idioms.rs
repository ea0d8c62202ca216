//! Idioms that have a plainer form, counted by folder. `tests/e2e/idioms.txt` has the ceilings, which
//! only go down: `BENDTWIN_BLESS=1 cargo test -p bendtwin-e2e idioms` lowers them to the present counts.
//! CONTRIBUTING.md has the plainer forms.

use std::collections::BTreeMap;

use super::{doc_comments::doc_comments, workspace};

/// Idioms, word by word. "None" with a capital is Python's, so that `none` is compared exactly.
const IDIOMS: [&[&str]; 19] = [
    &["so", "many"],
    &["so", "much"],
    &["at", "once"],
    &["go", "on"],
    &["goes", "on"],
    &["going", "on"],
    &["went", "on"],
    &["of", "its", "own"],
    &["of", "their", "own"],
    &["as", "it", "is"],
    &["as", "they", "are"],
    &["whatever"],
    &["whoever"],
    &["is", "none"],
    &["none", "that"],
    &["told"],
    &["let", "go", "of"],
    &["lets", "go", "of"],
    &["letting", "go", "of"],
];

/// Words after "of its own" where it ends a phrase: "a thread of its own for". Before a noun, "nodes
/// of its own graph", it is plain.
const AFTER_OWN: [&str; 22] = [
    "", "and", "as", "at", "behind", "beside", "but", "by", "for", "from", "if", "in", "is", "on",
    "or", "over", "so", "that", "to", "where", "which", "with",
];

/// First words of documentation comments that leave out the name of the thing.
const OPENINGS: [&str; 7] = ["Its", "It", "Of", "As", "By", "One", "None"];

/// Kinds of files that are read.
const EXTENSIONS: [&str; 9] = ["rs", "md", "py", "ts", "proto", "cu", "cuh", "toml", "yaml"];

/// The file that has the idioms themselves.
const SELF: &str = "tests/e2e/src/rules/idioms.rs";

#[test]
fn idioms_get_fewer() {
    let found = in_the_tree();
    let path = workspace::root().join("tests/e2e/idioms.txt");
    let mut ceilings = ceilings(&std::fs::read_to_string(&path).unwrap());
    let count = |folder: &str| found.get(folder).map_or(0, Vec::len);
    if std::env::var_os("BENDTWIN_BLESS").is_some() {
        for (folder, ceiling) in &mut ceilings {
            *ceiling = count(folder).min(*ceiling);
        }
        ceilings.retain(|_, ceiling| *ceiling > 0);
        let lines: String = ceilings.iter().map(|(f, n)| format!("{f} {n}\n")).collect();
        std::fs::write(&path, lines).unwrap();
    }
    let ceiling = |folder: &str| ceilings.get(folder).copied().unwrap_or(0);
    let above: Vec<_> = found
        .iter()
        .filter(|(folder, places)| places.len() > ceiling(folder))
        .map(|(folder, places)| {
            let (count, ceiling) = (places.len(), ceiling(folder));
            format!("{folder}: {count}, at most {ceiling}:\n{}", places.join("\n"))
        })
        .collect();
    assert!(above.is_empty(), "use a plainer form (CONTRIBUTING.md):\n{}", above.join("\n"));
    let below: Vec<_> = ceilings.keys().filter(|folder| count(folder) < ceiling(folder)).collect();
    assert!(
        below.is_empty(),
        "fewer than tests/e2e/idioms.txt says in {below:?}: `BENDTWIN_BLESS=1 cargo test -p bendtwin-e2e idioms` \
         lowers its numbers"
    );
}

/// Largest number of idioms by folder, from lines of both.
fn ceilings(text: &str) -> BTreeMap<String, usize> {
    let line = |line: &str| {
        let (folder, count) = line.split_once(' ').unwrap();
        (folder.to_owned(), count.parse().unwrap())
    };
    text.lines().map(line).collect()
}

/// Places of idioms in the source tree, by folder.
fn in_the_tree() -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, path) in workspace::files() {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        if name == SELF || !EXTENSIONS.contains(&extension) {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        for (line, idiom) in idioms(&name, &text) {
            let places = found.entry(folder(&name)).or_default();
            places.push(format!("  {name}:{line}: {idiom}"));
        }
    }
    found
}

/// The folder that a file is counted with: a crate, or a part of the project.
fn folder(name: &str) -> String {
    let parts: Vec<_> = name.split('/').collect();
    let depth = match parts[0] {
        "crates" | "client" | "docs" | "tests" => 2,
        _ => 1,
    };
    match parts.len() > depth {
        true => parts[..depth].join("/"),
        false => name.to_owned(),
    }
}

/// Idioms of a file, each with the number of its line.
fn idioms(name: &str, text: &str) -> Vec<(usize, String)> {
    let words = words(text);
    let mut found = Vec::new();
    for at in 0..words.len() {
        for idiom in IDIOMS {
            let rest = words[at..].iter().map(|(_, word)| *word);
            let is_same = |(word, part): (&str, &&str)| match *part {
                "none" => word == *part,
                part => word.eq_ignore_ascii_case(part),
            };
            let after = words.get(at + idiom.len()).map_or("", |(_, word)| *word);
            let is_plain = idiom.ends_with(&["own"]) && !AFTER_OWN.contains(&after);
            if words.len() - at >= idiom.len() && rest.zip(idiom).all(is_same) && !is_plain {
                found.push((words[at].0, idiom.join(" ")));
            }
        }
    }
    for comment in doc_comments(name, text) {
        let first = comment.lines.iter().flat_map(|line| line.split_whitespace()).next();
        let opening = first.and_then(|word| OPENINGS.into_iter().find(|o| *o == word));
        found.extend(opening.map(|word| (comment.line, format!("a comment begins with {word}"))));
    }
    found.sort();
    found
}

/// Words with the numbers of their lines; an empty word where punctuation separates two.
fn words(text: &str) -> Vec<(usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || "_'-".contains(c);
    let is_neutral = |c: char| c.is_whitespace() || "/!*#\"`".contains(c);
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut rest = line;
        while let Some(first) = rest.chars().next() {
            let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            if end > 0 {
                found.push((number + 1, &rest[..end]));
                rest = &rest[end..];
                continue;
            }
            if !is_neutral(first) {
                found.push((number + 1, ""));
            }
            rest = &rest[first.len_utf8()..];
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idioms_are_found_over_line_breaks_and_not_over_punctuation() {
        let text = "// All of them at\n// once. So many,\n// many (so: much) more.\n";
        let expected = [(1, "at once".to_owned()), (2, "so many".to_owned())];
        assert_eq!(idioms("a.rs", text), expected);
    }

    #[test]
    fn identifiers_and_pythons_none_are_no_idioms() {
        assert_eq!(idioms("a.py", "if at_once is None or goes_on: told_so = 1\n"), []);
        assert_eq!(idioms("a.md", "This is none that we know.\n").len(), 2);
    }

    #[test]
    fn own_before_a_noun_is_plain() {
        assert_eq!(idioms("a.md", "Nodes of its own graph, of their own twin.\n"), []);
        assert_eq!(idioms("a.md", "A thread of its own, files of their own for each.\n").len(), 2);
    }

    #[test]
    fn openings_count_in_documentation_alone() {
        let text = "/// Its length.\nfn f() {} // By hand.\n/// The length.\n/// Of course.\n";
        let expected = [(1, "a comment begins with Its".to_owned())];
        assert_eq!(idioms("a.rs", text), expected);
        assert_eq!(idioms("a.py", "\"\"\"One row.\"\"\"\n").len(), 1);
    }

    #[test]
    fn files_count_with_their_crate() {
        let folders = ["crates/core/src/a.rs", "server/src/a.rs", "README.md", "docs/README.md"];
        let expected = ["crates/core", "server", "README.md", "docs/README.md"];
        assert_eq!(folders.map(folder), expected);
    }
}
