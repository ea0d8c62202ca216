//! Documentation comments of source files, by language: Rust, protocol buffers, CUDA and Python.

/// A documentation comment.
#[derive(Debug, PartialEq)]
pub(crate) struct DocComment {
    /// Number of its first line, counted from 1.
    pub(crate) line: usize,
    /// Lines without comment markers.
    pub(crate) lines: Vec<String>,
}

/// The documentation comments of a file; none for other languages.
pub(crate) fn doc_comments(name: &str, text: &str) -> Vec<DocComment> {
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("rs") => rust(text),
        Some("proto" | "cu" | "cuh") => slashes(text),
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
        comments.push(DocComment { line: at + 1, lines: block });
        at = after;
    }
    comments
}

/// Comments that begin with `//`, alone on a line or at the end of one.
fn slashes(text: &str) -> Vec<DocComment> {
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
            _ => comments.push(DocComment { line: number + 1, lines: vec![comment] }),
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
                open = Some(DocComment { line: number + 1, lines: Vec::new() });
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

    fn comments(name: &str, text: &str) -> Vec<(usize, String)> {
        doc_comments(name, text).into_iter().map(|c| (c.line, c.lines.join("|"))).collect()
    }

    fn expected<const N: usize>(comments: [(usize, &str); N]) -> Vec<(usize, String)> {
        comments.map(|(line, text)| (line, text.to_owned())).to_vec()
    }

    #[test]
    fn rust_docs_have_three_slashes() {
        let text = "//! A.\n\n/// B.\n/// C.\npub struct S {\n    /// D.\n    pub d: u32,\n}\n// No doc.\n";
        assert_eq!(comments("a.rs", text), expected([(1, "A."), (3, "B.|C."), (6, "D.")]));
    }

    #[test]
    fn all_comments_of_messages_and_kernels_are_docs() {
        let text = "// A\n// b.\nmessage M {\n  int32 x = 1; // C.\n  // D.\n}\n";
        for name in ["a.proto", "a.cu"] {
            assert_eq!(comments(name, text), expected([(1, "A|b."), (4, "C."), (5, "D.")]));
        }
    }

    #[test]
    fn docstrings_begin_a_line() {
        let text = "\"\"\"A.\"\"\"\ndef f():\n    r\"\"\"B.\n\n    C.\n    \"\"\"\n    x = \"\"\"D.\"\"\"\n";
        assert_eq!(comments("a.py", text), expected([(1, "A."), (3, "B.||C.|")]));
    }

    #[test]
    fn other_files_have_none() {
        assert_eq!(comments("a.md", "// A.\n"), []);
    }
}
