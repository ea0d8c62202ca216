use super::*;

#[test]
fn the_document_has_every_code_with_its_advice() {
    let document = include_str!("../../../../docs/use/errors.md");
    for code in CODES {
        let row = format!("| `{}` | {} | {} |", code.name, code.meaning, code.advice);
        assert!(document.contains(&row), "docs/use/errors.md lacks: {row}");
    }
}

#[test]
fn codes_are_unique() {
    for (i, code) in CODES.iter().enumerate() {
        assert_eq!(rank(code.name), i + 1, "{}", code.name);
    }
    assert_eq!(rank("FILE_DAMAGED"), 0, "what cannot be read comes first");
}
