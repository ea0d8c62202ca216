use super::*;

#[test]
fn the_document_has_every_code_with_its_advice() {
    let document = include_str!("../../../../docs/use/errors.md");
    for code in Code::ALL {
        let row = format!("| `{}` | {} | {} |", code.name(), code.meaning(), code.advice());
        assert!(document.contains(&row), "docs/use/errors.md lacks: {row}");
    }
}

#[test]
fn names_are_unique_and_in_their_order() {
    for (place, &code) in Code::ALL.iter().enumerate() {
        assert_eq!((Code::named(code.name()), Code::rank(code.name())), (Some(code), place));
    }
    assert_eq!(Code::rank("FILE_DAMAGED"), 0, "what cannot be read comes first");
}
