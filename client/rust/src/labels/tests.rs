use std::collections::BTreeSet;

use bendtwin_proto::{json::Fields as _, v1::CaptureMetadata};

use super::*;

#[test]
fn facts_of_an_upload_are_those_of_its_message() {
    let stated = serde_json::to_value(CaptureFacts {
        ingest_requirements: Requirements { backend: "cpu".to_owned(), ..Requirements::default() },
        ..CaptureFacts::default()
    });
    let stated: BTreeSet<String> = stated.unwrap().as_object().unwrap().keys().cloned().collect();
    // The client itself computes these.
    let own = ["digest", "request_id"];
    let fields = CaptureMetadata::FIELDS.iter().filter(|field| !own.contains(field));
    assert_eq!(stated, fields.map(|&field| field.to_owned()).collect());
}

#[test]
fn texts_are_sent_plain_and_others_as_json() {
    let labels = vec!["lab=2".to_owned()];
    let facts = CaptureFacts {
        recorded_by: Some("Ada".to_owned()),
        ingest_requirements: Requirements { labels, ..Requirements::default() },
        ..CaptureFacts::from("a \"rope\"")
    };
    let requirements = r#"{"backend":"","labels":["lab=2"],"memory_bytes":0}"#;
    let pair = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let expected = [
        pair("display_name", "a \"rope\""),
        pair("ingest_requirements", requirements),
        pair("recorded_by", "Ada"),
    ];
    assert_eq!(facts.pairs().unwrap(), expected);
    assert_eq!(CaptureFacts::default().pairs().unwrap(), []);
}
