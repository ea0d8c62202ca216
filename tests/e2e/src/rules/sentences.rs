//! Markdown has one sentence a line: a line of prose ends where a sentence does, so that an edit
//! shows as the sentence that changed.

use super::workspace;

#[test]
fn sentences_of_markdown_are_not_wrapped() {
    let mut found = Vec::new();
    for (name, path) in workspace::files() {
        if name.ends_with(".md") {
            let text = std::fs::read_to_string(path).unwrap();
            found.extend(wrapped(&text).map(|line| format!("{name}:{line}")));
        }
    }
    assert!(found.is_empty(), "one sentence a line, please:\n{}", found.join("\n"));
}

#[test]
fn tables_lists_and_code_are_no_sentences() {
    let text = "A sentence.\nAnother one\nthat is wrapped.\n\n- an item\n- another\n\n```\na\nb\n```\n| a |\n| b |\n";
    assert_eq!(wrapped(text).collect::<Vec<_>>(), [2]);
}

/// Numbers of the lines that continue in the next one.
fn wrapped(text: &str) -> impl Iterator<Item = usize> {
    let mut in_code = false;
    let prose: Vec<_> = text
        .lines()
        .map(|line| {
            let fence = line.trim_start().starts_with("```");
            in_code ^= fence;
            let start = line.trim_start().chars().next();
            let other = start.is_none_or(|c| "|#<!".contains(c)) || line.starts_with("    ");
            (!fence && !in_code && !other).then(|| line.trim().to_owned())
        })
        .collect();
    let is_under_load = move |pair: &[Option<String>]| match pair {
        [Some(line), Some(next)] => !ends(line) && !is_item(next),
        _ => false,
    };
    let numbers: Vec<_> = prose.windows(2).map(is_under_load).collect();
    (1..).zip(numbers).filter(|(_, is_under_load)| *is_under_load).map(|(number, _)| number)
}

fn ends(line: &str) -> bool {
    line.trim_end_matches([')', '"', '`', '*', '_', ']']).ends_with(['.', ':', ';', '!', '?', '…'])
}

fn is_item(line: &str) -> bool {
    let number = line.trim_start_matches(|c: char| c.is_ascii_digit());
    line.starts_with("- ")
        || line.starts_with("* ")
        || (number.len() < line.len() && number.starts_with(". "))
}
