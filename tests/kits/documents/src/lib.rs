//! Commands that documents show, compared with the definition of the program: each subcommand and each
//! option must exist. Values are not parsed, since documents have placeholders for them.
//!
//! The log of changes and the pages of decisions are left out: they name what was.

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::Command;

/// Documents, and folders of documents, from the root of the source tree.
const DOCUMENTS: [&str; 6] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "client/python/README.md",
    "docs",
];
/// Folder of decisions.
const DECISIONS: &str = "docs/adr";

/// A command in a document.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Shown {
    /// File and line.
    place: String,
    /// Words after the program's name.
    words: Vec<String>,
}

/// Compares all commands in documents that begin with `program` with its definition. Returns how many
/// there are, and what is wrong with them.
pub fn compare(program: &str, mut definition: Command) -> (usize, Vec<String>) {
    definition.build();
    let shown = all(program);
    let wrong = |shown: &Shown| {
        let fault = fault(&definition, &shown.words)?;
        Some(format!("{}: {program} {}: {fault}", shown.place, shown.words.join(" ")))
    };
    (shown.len(), shown.iter().filter_map(wrong).collect())
}

/// What is wrong with the words of a command.
fn fault(definition: &Command, words: &[String]) -> Option<String> {
    let (mut command, mut is_open) = (definition, true);
    let mut words = words.iter();
    while let Some(word) = words.next() {
        if let Some(option) = word.strip_prefix("--") {
            let (name, value) =
                option.split_once('=').map_or((option, None), |(n, v)| (n, Some(v)));
            let mut arguments = command.get_arguments();
            match arguments.find(|argument| argument.get_long() == Some(name)) {
                Some(argument) if argument.get_action().takes_values() && value.is_none() => {
                    words.next();
                }
                Some(_) => {}
                None if name.is_empty() => {}
                None => return Some(format!("`{}` has no option --{name}", command.get_name())),
            }
        } else if is_open && command.has_subcommands() {
            match command.find_subcommand(word) {
                Some(next) => command = next,
                // A command may have arguments instead.
                None if command.get_positionals().next().is_some() => is_open = false,
                None => return Some(format!("`{}` has no command {word}", command.get_name())),
            }
        } else {
            is_open = false;
        }
    }
    None
}

fn all(program: &str) -> Vec<Shown> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut files = Vec::new();
    DOCUMENTS.iter().for_each(|name| collect(&root, name, &mut files));
    assert!(files.len() > 20, "the documents were not found: {files:?}");
    let mut shown = Vec::new();
    for (name, path) in files {
        let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (line, words) in in_text(program, &text) {
            shown.push(Shown { place: format!("{name}:{line}"), words });
        }
    }
    shown
}

/// Adds the documents of a file or a folder with their names.
fn collect(root: &Path, name: &str, files: &mut Vec<(String, PathBuf)>) {
    let path = root.join(name);
    if path.is_dir() {
        let mut names: Vec<_> = fs::read_dir(&path)
            .unwrap_or_else(|e| panic!("{name}: {e}"))
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .map(|entry| format!("{name}/{entry}"))
            .collect();
        names.sort();
        names.iter().filter(|name| *name != DECISIONS).for_each(|n| collect(root, n, files));
    } else if path.extension() == Some("md".as_ref()) {
        files.push((name.to_owned(), path));
    }
}

/// Words before a command in the same line that run it, beside variables of the environment.
const RUNNERS: [&str; 3] = ["$", "chrt", "docker"];

/// Commands of a Markdown text, each with the number of its line: those that begin a span of code, and
/// those that begin a line in a block of code or follow a runner there, up to the end of the command.
fn in_text(program: &str, text: &str) -> Vec<(usize, Vec<String>)> {
    let mut found = Vec::new();
    let mut lines = text.lines().enumerate();
    let mut is_fenced = false;
    while let Some((number, line)) = lines.next() {
        is_fenced ^= line.starts_with("```");
        let is_block = is_fenced || line.starts_with("    ");
        let mut line = line.to_owned();
        while line.ends_with('\\') {
            line.pop();
            let Some((_, next)) = lines.next() else { break };
            line.push_str(next);
        }
        let starts = line.match_indices(program).filter(|(at, _)| {
            let (before, after) = (&line[..*at], &line[at + program.len()..]);
            let runner = before.split_whitespace().next().unwrap_or(RUNNERS[0]);
            let runs = (RUNNERS.contains(&runner) || runner.contains('='))
                && !before.ends_with(|c: char| c != ' ');
            let is_command = before.ends_with('`') || is_block && runs;
            let is_version = after.trim_start().starts_with(|c: char| c.is_ascii_digit());
            is_command && after.starts_with(' ') && !is_version
        });
        for (at, _) in starts {
            let rest = &line[at + program.len()..];
            found.push((number + 1, words(rest)));
        }
    }
    found
}

/// Words of a command up to its end. Brackets mark what may be left out.
fn words(text: &str) -> Vec<String> {
    let end = text.find(['`', '|', '&', ';', '>']).unwrap_or(text.len());
    let words = text[..end].split_whitespace().take_while(|word| !word.starts_with('#'));
    let plain = words.map(|word| word.trim_matches(['[', ']', ',']).to_owned());
    plain.filter(|word| !word.is_empty() && word != "...").collect()
}

#[cfg(test)]
mod tests {
    use clap::{Arg, ArgAction};

    use super::*;

    fn definition() -> Command {
        let flag = |name: &'static str| Arg::new(name).long(name).action(ArgAction::SetTrue);
        let seed = Arg::new("seed").long("seed");
        let start = Command::new("start").arg(flag("watch")).arg(seed).arg(Arg::new("name"));
        let fit = Command::new("fit").subcommand(start);
        let json = flag("json").global(true);
        let mut program = Command::new("twin").arg(json).subcommand(fit);
        program.build();
        program
    }

    #[test]
    fn commands_are_found_in_blocks_and_in_spans() {
        let text = "Text about twin fits.\n\n    chrt twin fit start \\\n        a --watch   # comment\n\
                    Or `twin fit` and `twin --json | jq`.\n";
        let found = in_text("twin", text);
        let words = |words: &[&str]| words.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
        assert_eq!(
            found,
            [
                (3, words(&["fit", "start", "a", "--watch"])),
                (5, words(&["fit"])),
                (5, words(&["--json"])),
            ]
        );
    }

    #[test]
    fn unknown_commands_and_options_are_faults() {
        let fault = |text: &str| fault(&definition(), &words(text));
        assert_eq!(fault(" --json fit start captures/... [--watch] --seed 3 --help"), None);
        assert!(fault(" fits start").unwrap().contains("no command fits"));
        assert!(fault(" fit stop").unwrap().contains("no command stop"));
        assert!(fault(" fit start a --wait").unwrap().contains("no option --wait"));
    }
}
