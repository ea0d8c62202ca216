//! Forms of fields in JSON that options of the contract ask for.

use bendtwin_proto::{
    json::{Fields, Read, TensorFormat, Write, from_query},
    v1::{
        CaptureMetadata, CreateFitRequest, CreateKeyRequest, Job, ListFitsRequest, Twin,
        UpdateTwinRequest, Worker, job::State,
    },
};
use serde_json::{Value, json};

fn written<M: Fields>(message: &M) -> Value {
    serde_json::to_value(Write { message, tensors: TensorFormat::Lists }).unwrap()
}

fn read<M: Fields>(json: &Value) -> Result<M, String> {
    let read = serde_json::from_str::<Read<M>>(&json.to_string());
    read.map(|Read(message)| message).map_err(|e| e.to_string())
}

#[test]
fn documents_are_nested_and_what_is_absent_is_null() {
    let time = |seconds, nanos| Some(prost_types::Timestamp { seconds, nanos });
    let job = Job {
        state: State::Running.into(),
        settings_json: r#"{"a": [1, 2]}"#.to_owned(),
        create_time: time(0, 500_000_000),
        start_time: time(-1, 999_999_999),
        ..Job::default()
    };
    let json = written(&job);
    assert_eq!(json["settings"], json!({"a": [1, 2]}));
    assert_eq!(json["create_time"], "1970-01-01T00:00:00.5Z");
    assert_eq!(json["start_time"], "1969-12-31T23:59:59.999999999Z");
    for absent in ["progress", "fault", "worker", "end_time"] {
        assert_eq!(json.get(absent), Some(&Value::Null), "{absent}");
    }
    // What is no JSON does not break the reply.
    let broken = Job { settings_json: "{".to_owned(), ..Job::default() };
    assert_eq!(written(&broken)["settings"], Value::Null);
    assert!(written(&Twin::default()).get("mass_kg").is_none(), "left out, as it was");
    let worker = written(&Worker { memory_total_bytes: 5, ..Worker::default() });
    assert_eq!(
        (&worker["memory_used_bytes"], &worker["memory_total_bytes"]),
        (&json!(null), &json!(5))
    );
}

#[test]
fn times_are_read_as_they_are_written() {
    let order = |time: &str| json!({"display_name": "a", "scopes": [], "expire_time": time});
    let key: CreateKeyRequest = read(&order("1969-12-31T23:59:59.25Z")).unwrap();
    let time = key.expire_time.unwrap();
    assert_eq!((time.seconds, time.nanos), (-1, 250_000_000));
    let fault = read::<CreateKeyRequest>(&order("soon")).unwrap_err();
    assert!(fault.starts_with("`expire_time` is not an RFC 3339 time"), "{fault}");
}

#[test]
fn an_update_changes_what_is_given() {
    let change: UpdateTwinRequest =
        read(&json!({"display_name": "", "note": null, "tags": ["a"], "add_tags": ["b"]})).unwrap();
    assert_eq!(change.update_mask.unwrap().paths, ["display_name", "tags"]);
    assert_eq!((change.twin.unwrap().tags, change.add_tags), (vec!["a".into()], vec!["b".into()]));
    assert!(read::<UpdateTwinRequest>(&json!({"name": "twins/x"})).is_err());
    assert!(read::<UpdateTwinRequest>(&json!({"size_bytes": 1})).is_err());
}

#[test]
fn what_has_to_be_given_is_asked_for() {
    let fault = read::<CreateFitRequest>(&json!({"priority": 1})).unwrap_err();
    assert!(fault.starts_with("`capture` is missing"), "{fault}");
    let order = json!({"capture": "captures/x", "request_id": "a"});
    assert!(read::<CreateFitRequest>(&order).is_err(), "it is a header");
}

#[test]
fn a_query_is_a_message() {
    let list: ListFitsRequest =
        from_query("page_size=5&state=FAILED&search=a%26b&tag=&page_token=ab%3D").unwrap();
    let wanted = ListFitsRequest {
        page_size: 5,
        state: State::Failed.into(),
        search: "a&b".to_owned(),
        page_token: "ab=".to_owned(),
        ..ListFitsRequest::default()
    };
    assert_eq!(list, wanted);
    for wrong in ["page_size=x", "colour=red", "state=ENDED", "tag=a&tag=b"] {
        assert!(from_query::<ListFitsRequest>(wrong).is_err(), "{wrong}");
    }
    let upload = "ingest=%7B%22a%22&ingest_requirements=%7B%22labels%22%3A%5B%22a%22%5D%7D";
    let upload: CaptureMetadata = from_query(upload).unwrap();
    assert_eq!(upload.ingest_json, r#"{"a""#, "the use case says what is wrong with it");
    assert_eq!(upload.ingest_requirements.unwrap().labels, ["a"]);
    assert!(from_query::<CaptureMetadata>("ingest_requirements=%7B").is_err());
    assert!(from_query::<CaptureMetadata>("request_id=a").is_err());
}

#[test]
fn an_empty_parameter_is_absent_and_its_name_is_checked() {
    let read = from_query::<ListFitsRequest>;
    assert_eq!(read("state=&page_size=&tag=").unwrap(), ListFitsRequest::default());
    for wrong in ["colour=", "state=&state="] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}
