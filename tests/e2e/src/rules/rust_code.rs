//! The code of a Rust file without its comments and literals, for rules about words in code.

/// The text with every comment, string and character blanked out; lines keep their numbers.
pub(crate) fn code_only(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = match c {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            '"' => quoted(rest, '"'),
            '\'' if is_character(rest) => quoted(rest, '\''),
            'r' if !code.ends_with(is_word) => raw(rest),
            _ => 0,
        };
        let (token, is_blank) =
            if length > 0 { (&rest[..length], true) } else { (&rest[..c.len_utf8()], false) };
        if is_blank {
            code.extend(token.chars().map(|c| if c == '\n' { c } else { ' ' }));
        } else {
            code.push_str(token);
        }
        rest = &rest[token.len()..];
    }
    code
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Length of the literal at the start [bytes], both quotes included.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// True for a character, false for a lifetime.
fn is_character(text: &str) -> bool {
    let mut after = text.chars().skip(1);
    after.next() == Some('\\') || after.next() == Some('\'')
}

/// Length of the raw string at the start [bytes]; 0 without one.
fn raw(text: &str) -> usize {
    let hashes = text[1..].bytes().take_while(|b| *b == b'#').count();
    let Some(inside) = text[1 + hashes..].strip_prefix('"') else { return 0 };
    let end = format!("\"{}", "#".repeat(hashes));
    let length = inside.find(&end).map_or(inside.len(), |at| at + end.len());
    2 + hashes + length
}

#[test]
fn literals_and_comments_are_blank() {
    for (text, code) in [
        ("a // b\nc", "a     \nc"),
        ("a /* b\n */ c", "a     \n    c"),
        ("f(\"b \\\" c\")", "f(        )"),
        ("f('\"', g)", "f(   , g)"),
        ("f('\\'', g)", "f(    , g)"),
        ("fn f<'a>(x: &'a str)", "fn f<'a>(x: &'a str)"),
        ("r#\"b \" c\"# d", "           d"),
        ("for r in \"é\"", "for r in    "),
        ("\"b \\\n c\" d", "    \n    d"),
    ] {
        assert_eq!(code_only(text), code, "{text}");
    }
}
