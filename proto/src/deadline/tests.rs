use super::*;

fn parse(text: &'static str) -> Option<Duration> {
    let mut metadata = MetadataMap::new();
    metadata.insert("grpc-timeout", text.parse().unwrap());
    timeout(&metadata)
}

#[test]
fn units_are_grpcs() {
    assert_eq!(parse("2H"), Some(Duration::from_secs(7200)));
    assert_eq!(parse("3M"), Some(Duration::from_secs(180)));
    assert_eq!(parse("4S"), Some(Duration::from_secs(4)));
    assert_eq!(parse("250m"), Some(Duration::from_millis(250)));
    assert_eq!(parse("7u"), Some(Duration::from_micros(7)));
    assert_eq!(parse("99999999n"), Some(Duration::from_nanos(99_999_999)));
}

#[test]
fn what_is_malformed_sets_no_deadline() {
    for text in ["", "S", "5", "5x", "-1S", "1.5S", "123456789S"] {
        assert_eq!(parse(text), None, "{text}");
    }
    assert_eq!(timeout(&MetadataMap::new()), None);
}
