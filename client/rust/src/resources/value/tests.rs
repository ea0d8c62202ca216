use bendtwin_proto::DESCRIPTORS;
use prost::Message as _;
use prost_types::FileDescriptorSet;

use super::*;
use crate::{Caller, Capture, Fit, Key, OwnerUsage, Session, Share, Supplement, Twin, Worker};

#[test]
fn a_resource_has_every_field_of_its_message() {
    let files = FileDescriptorSet::decode(DESCRIPTORS).unwrap().file;
    let messages: Vec<_> = files.into_iter().flat_map(|file| file.message_type).collect();
    for (name, names) in [
        ("Caller", Caller::NAMES),
        ("Capture", Capture::NAMES),
        ("Fit", Fit::NAMES),
        ("Job", Job::NAMES),
        ("Key", Key::NAMES),
        ("OwnerUsage", OwnerUsage::NAMES),
        ("Session", Session::NAMES),
        ("Share", Share::NAMES),
        ("Supplement", Supplement::NAMES),
        ("Twin", Twin::NAMES),
        ("Worker", Worker::NAMES),
    ] {
        let message = messages.iter().find(|message| message.name() == name).unwrap();
        for field in &message.field {
            assert!(names.contains(&field.name()), "{name} has no {}", field.name());
        }
    }
}

#[test]
fn what_a_message_leaves_out_is_none_or_refused() {
    let capture: Option<CaptureId> = FromWire::from_wire(String::new(), "capture").unwrap();
    assert_eq!(capture, None);
    let fault = CaptureId::from_wire(String::new(), "capture").unwrap_err();
    assert!(fault.to_string().contains("capture"), "{fault}");
    let fault = Timestamp::from_wire(None, "create_time").unwrap_err();
    assert!(fault.to_string().contains("create_time is missing"), "{fault}");
    assert_eq!(
        Option::<Timestamp>::from_wire(None::<prost_types::Timestamp>, "end_time").unwrap(),
        None
    );
    assert_eq!(Option::<DeviceMemory>::from_wire((0, 0), "memory").unwrap(), None);
    assert!(JobState::from_wire(0, "state").is_err());
    assert!(JobState::from_wire(77, "state").is_err());
    assert!(Duration::from_wire(f64::NAN, "idle_timeout_s").is_err());
    assert!(serde_json::Value::from_wire("{".to_owned(), "settings").is_err());
}

/// Format for scripts: `bendtwin --json` prints resources in this form.
#[test]
fn jobs_are_json_with_words_nulls_and_nested_settings() {
    let wire = v1::Job {
        state: JobState::Running.into(),
        settings_json: r#"{"seed":7}"#.into(),
        progress: Some(v1::Progress {
            stage: "search".into(),
            loss: Some(0.5),
            ..Default::default()
        }),
        create_time: Some(prost_types::Timestamp { seconds: 60, nanos: 0 }),
        ..Default::default()
    };
    let job = Job::try_from(wire).unwrap();
    let expected = concat!(
        r#"{"state":"RUNNING","settings":{"seed":7},"#,
        r#""progress":{"stage":"search","variant":"","iteration":0,"iterations":0,"fraction":0.0,"#,
        r#""loss":0.5,"best_loss":null,"eta_s":null,"note":null,"models":[],"error_m":null},"#,
        r#""fault":null,"attempt_faults":[],"attempts":0,"worker":null,"cancel_requested":false,"#,
        r#""create_time":"1970-01-01T00:01:00Z","start_time":null,"end_time":null,"revision":0,"#,
        r#""run_s":0.0}"#,
    );
    assert_eq!(serde_json::to_string(&job).unwrap(), expected);
}
