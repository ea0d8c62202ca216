//! Documentation comments of source files, by language: Rust, protocol buffers, CUDA and Python.

/// A documentation comment.
#[derive(Debug, PartialEq)]
pub(crate) struct DocComment {
    /// Number of its first line, counted from 1.
    pub(crate) line: usize,
    /// True for docs of the public API: of modules, of `pub` items, of messages, Python docstrings.
    pub(crate) is_public: bool,
    /// Lines without comment markers.
    pub(crate) lines: Vec<String>,
}

/// The documentation comments of a file; none for other languages.
pub(crate) fn doc_comments(name: &str, text: &str) -> Vec<DocComment> {
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("rs") => rust(text),
        Some("proto") => slashes(text, true),
        Some("cu" | "cuh") => slashes(text, false),
        Some("py") => docstrings(text),
        _ => Vec::new(),
    }
}

/// Comments that begin with `///` or `//!`.
fn rust(text: &str) -> Vec<DocComment> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut comments = Vec::new();
    let mut at = 0;
    while let Some(line) = lines.get(at) {
        let Some(marker) = ["///", "//!"].into_iter().find(|m| line.starts_with(m)) else {
            at += 1;
            continue;
        };
        let rest = lines[at..].iter();
        let block: Vec<String> =
            rest.map_while(|l| l.strip_prefix(marker)).map(|l| l.trim().to_owned()).collect();
        let after = at + block.len();
        let is_public = marker == "//!" || item(&lines[after..]).starts_with("pub ");
        comments.push(DocComment { line: at + 1, is_public, lines: block });
        at = after;
    }
    comments
}

/// The first line that is not part of an attribute.
fn item<'a>(lines: &[&'a str]) -> &'a str {
    let mut depth = 0;
    for line in lines {
        if depth == 0 && !line.starts_with("#[") {
            return line;
        }
        let count = |c: char| line.matches(c).count() as isize;
        depth += count('[') - count(']');
    }
    ""
}

/// Comments that begin with `//`, on separate lines or at the end of a line.
fn slashes(text: &str, is_public: bool) -> Vec<DocComment> {
    let mut comments: Vec<DocComment> = Vec::new();
    let mut continues = false;
    for (number, line) in text.lines().enumerate() {
        let Some((code, comment)) = line.split_once("//") else {
            continues = false;
            continue;
        };
        let comment = comment.trim_start_matches('/').trim().to_owned();
        let is_alone = code.trim().is_empty();
        match comments.last_mut() {
            Some(last) if continues && is_alone => last.lines.push(comment),
            _ => comments.push(DocComment { line: number + 1, is_public, lines: vec![comment] }),
        }
        continues = is_alone;
    }
    comments
}

/// Strings in triple quotes that begin a line.
fn docstrings(text: &str) -> Vec<DocComment> {
    const QUOTES: &str = "\"\"\"";
    let mut comments = Vec::new();
    let mut open: Option<DocComment> = None;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        let rest = match (&open, line.trim_start_matches('r').strip_prefix(QUOTES)) {
            (None, None) => continue,
            (None, Some(rest)) => {
                open = Some(DocComment { line: number + 1, is_public: true, lines: Vec::new() });
                rest
            }
            (Some(_), _) => line,
        };
        let Some(comment) = &mut open else { continue };
        match rest.split_once(QUOTES) {
            None => comment.lines.push(rest.to_owned()),
            Some((end, _)) => {
                comment.lines.push(end.to_owned());
                comments.extend(open.take());
            }
        }
    }
    comments
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comments(name: &str, text: &str) -> Vec<(usize, bool, String)> {
        let found = doc_comments(name, text).into_iter();
        found.map(|c| (c.line, c.is_public, c.lines.join("|"))).collect()
    }

    #[test]
    fn rust_docs_belong_to_the_item_below() {
        let text = "//! A.\n\n/// B.\n/// C.\n#[derive(\n    Debug,\n)]\npub struct S {\n    /// D.\n    \
                    pub(crate) d: u32,\n    /// E.\n    #[arg(long)]\n    pub e: u32,\n}\n// No doc.\n";
        let expected = [(1, true, "A."), (3, true, "B.|C."), (9, false, "D."), (11, true, "E.")];
        let expected = expected.map(|(line, is_public, text)| (line, is_public, text.to_owned()));
        assert_eq!(comments("a.rs", text), expected);
    }

    #[test]
    fn comments_of_messages_are_public_and_those_of_kernels_are_not() {
        let text = "// A\n// b.\nmessage M {\n  int32 x = 1; // C.\n  // D.\n}\n";
        let expected = [(1, "A|b."), (4, "C."), (5, "D.")];
        for (name, is_public) in [("a.proto", true), ("a.cu", false)] {
            let expected = expected.map(|(line, text)| (line, is_public, text.to_owned()));
            assert_eq!(comments(name, text), expected);
        }
    }

    #[test]
    fn docstrings_begin_a_line() {
        let text = "\"\"\"A.\"\"\"\ndef f():\n    r\"\"\"B.\n\n    C.\n    \"\"\"\n    x = \"\"\"D.\"\"\"\n";
        let expected = [(1, true, "A.".to_owned()), (3, true, "B.||C.|".to_owned())];
        assert_eq!(comments("a.py", text), expected);
    }

    #[test]
    fn other_files_have_none() {
        assert_eq!(comments("a.md", "// A.\n"), []);
    }
}
