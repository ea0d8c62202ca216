//! The sentences of documentation comments, and the rule on how they open.

use crate::doc_comments::DocComment;

/// Words that announce what a sentence is about instead of naming it.
const QUESTION_WORDS: [&str; 7] = ["Who", "Whose", "What", "How", "Where", "Which", "Whether"];

/// A sentence of a documentation comment.
#[derive(Debug, PartialEq)]
pub(crate) struct Sentence {
    /// Number of the line on which it begins, counted from 1.
    pub(crate) line: usize,
    pub(crate) text: String,
}

impl Sentence {
    /// True if it opens with a question word.
    pub(crate) fn asks(&self) -> bool {
        let opening = self.text.trim_start_matches(['*', '_', '(', '"', '\'']);
        let word: String = opening.chars().take_while(|c| c.is_alphanumeric()).collect();
        QUESTION_WORDS.contains(&word.as_str())
    }
}

/// The sentences of a comment; code blocks are left out.
pub(crate) fn sentences(comment: &DocComment) -> Vec<Sentence> {
    let mut found = Vec::new();
    let mut paragraph = Paragraph::default();
    let mut is_code = false;
    for (offset, line) in comment.lines.iter().enumerate() {
        let line = line.trim();
        let is_fence = line.starts_with("```");
        if is_fence || line.is_empty() || is_item(line) {
            paragraph.end(&mut found);
        }
        is_code ^= is_fence;
        if !is_fence && !is_code && !line.is_empty() {
            paragraph
                .add(comment.line + offset, line.trim_start_matches(['*', '-', '|', '#', ' ']));
        }
        if line.starts_with('#') {
            paragraph.end(&mut found);
        }
    }
    paragraph.end(&mut found);
    found
}

/// True for a line that begins an item of a list, a row of a table or a heading.
fn is_item(line: &str) -> bool {
    ["* ", "- ", "|", "#"].iter().any(|marker| line.starts_with(marker))
}

/// Lines that belong together, each with its number.
#[derive(Default)]
struct Paragraph(Vec<(usize, String)>);

impl Paragraph {
    fn add(&mut self, number: usize, line: &str) {
        self.0.push((number, line.to_owned()));
    }

    /// Splits the paragraph into sentences and empties it.
    fn end(&mut self, found: &mut Vec<Sentence>) {
        let mut open: Option<Sentence> = None;
        for (number, line) in self.0.drain(..) {
            for word in line.split_whitespace() {
                match &mut open {
                    Some(sentence) if !(ends(&sentence.text) && begins(word)) => {
                        sentence.text.push(' ');
                        sentence.text.push_str(word);
                    }
                    _ => {
                        let text = word.to_owned();
                        found.extend(open.replace(Sentence { line: number, text }));
                    }
                }
            }
        }
        found.extend(open);
    }
}

fn ends(text: &str) -> bool {
    let text = text.trim_end_matches(['*', '_', ')', '"', '\'']);
    text.ends_with(['.', ':', ';', '!', '?']) && !["e.g.", "i.e."].iter().any(|a| text.ends_with(a))
}

fn begins(word: &str) -> bool {
    let word = word.trim_start_matches(['*', '_', '(', '"', '\'']);
    word.starts_with(|c: char| c.is_uppercase() || c == '`' || c == '[')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(lines: &[&str]) -> Vec<(usize, String)> {
        let lines = lines.iter().map(|line| (*line).to_owned()).collect();
        let comment = DocComment { line: 1, is_public: true, lines };
        sentences(&comment).into_iter().map(|s| (s.line, s.text)).collect()
    }

    fn asks(text: &str) -> bool {
        Sentence { line: 1, text: text.to_owned() }.asks()
    }

    #[test]
    fn sentences_end_at_punctuation_before_a_capital() {
        let found = split(&["One two. Three", "four; `five` six. And 1.5 of 7. eight"]);
        let expected =
            [(1, "One two."), (1, "Three four;"), (2, "`five` six."), (2, "And 1.5 of 7. eight")];
        assert_eq!(found, expected.map(|(line, text)| (line, text.to_owned())));
    }

    #[test]
    fn paragraphs_items_and_headings_are_apart() {
        let found = split(&["# Errors", "If a", "fails", "", "* one", "  two", "* three"]);
        let expected = [(1, "Errors"), (2, "If a fails"), (5, "one two"), (7, "three")];
        assert_eq!(found, expected.map(|(line, text)| (line, text.to_owned())));
    }

    #[test]
    fn code_and_abbreviations_do_not_count() {
        assert_eq!(split(&["A.", "```", "What. How.", "```", "B."]).len(), 2);
        assert_eq!(split(&["Units, e.g. Newton, are given."]).len(), 1);
    }

    #[test]
    fn questions_are_known_by_their_first_word() {
        for text in ["What it is.", "Whether so.", "**How** it goes.", "(Who it is)", "Which"] {
            assert!(asks(text), "{text}");
        }
        for text in ["Whatever it is.", "Time at which.", "`What`", "However.", "What's"] {
            assert_eq!(asks(text), text == "What's", "{text}");
        }
    }
}
