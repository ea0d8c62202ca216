use super::*;

#[test]
fn a_sentence_comes_apart_at_its_last_colon_and_together_again() {
    let text = "`a.zip`: entry 3 is damaged: copy it again";
    let finding = Finding::from_sentence(Severity::Error, "FILE_DAMAGED", text);
    assert_eq!(finding.message, "`a.zip`: entry 3 is damaged");
    assert_eq!(finding.advice, "copy it again");
    assert_eq!(finding.sentence(), text);
    assert_eq!(finding.clone().split(), finding);
    let plain = Finding::from_sentence(Severity::Info, "STILL", "nothing moves");
    assert_eq!((plain.advice.as_str(), plain.sentence().as_str()), ("", "nothing moves"));
}

#[test]
fn values_without_use_in_json_are_left_out() {
    let finding = Finding::warning("A", "b").number("x_m", f64::NAN).number("y_m", 1.5);
    let finding = finding.frames(0..50).cameras([2]);
    assert_eq!((finding.numbers.len(), finding.frames.len()), (1, 20));
    let json = serde_json::to_string(&finding).unwrap();
    assert_eq!(serde_json::from_str::<Finding>(&json).unwrap(), finding);
}

#[test]
fn findings_without_advice_are_still_read() {
    let old = r#"{"severity": "warning", "code": "A", "message": "b"}"#;
    assert_eq!(serde_json::from_str::<Finding>(old).unwrap(), Finding::warning("A", "b"));
}
