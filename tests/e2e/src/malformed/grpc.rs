//! Malformed requests over gRPC.

use bendtwin_contract::rollout::TwinShape;
use bendtwin_contract_kit::registration;
use bendtwin_proto::v1::{
    CaptureMetadata, CreateCaptureRequest, CreateFitRequest, CreateTwinRequest, GetTwinRequest,
    ListFitsRequest, PlanRequest, RegisterStateRequest, Twin, TwinMetadata, create_capture_request,
    create_twin_request,
};
use bytes::Bytes;
use prost::Message;
use tonic::Code;

use super::{Fixture, bad_names, fields, rollouts};
use crate::harness::{raw, reference::capture, within};

const ANSWER: std::time::Duration = std::time::Duration::from_secs(60);

/// Description of calls whose bytes are no message.
const UNREADABLE: &str = "bytes that are no message:";

/// A malformed call: its fault, the method, the messages.
type Call = (String, &'static str, Vec<Bytes>);

#[tokio::test]
async fn malformed_calls_are_refused_with_their_code() {
    let fixture = Fixture::new().await;
    let unknown_capture = "captures/0190a000-0000-7000-8000-00000000dead".to_owned();
    let mut calls = names();
    calls.extend(lists());
    calls.extend(fits(&unknown_capture));
    calls.extend(uploads(&capture().await, &fixture.file));
    calls.extend(broken_bytes());
    for (what, request) in rollouts::requests(&fixture.twin, &fixture.file) {
        let message = Bytes::from(request.encode_to_vec());
        calls.push((what.clone(), "RolloutService/RollOut", vec![message.clone()]));
        calls.push((what.clone(), "RolloutService/StreamRollOut", vec![message]));
        let plan = PlanRequest { rollout: Some(request), ..PlanRequest::default() };
        calls.push((what, "PlanningService/Plan", vec![plan.encode_to_vec().into()]));
    }
    calls.extend(registrations(&fixture.twin));
    assert!(calls.len() >= 200, "only {} calls", calls.len());

    let channel = fixture.server.api().channel;
    let mut wrong = Vec::new();
    for (what, method, messages) in &calls {
        let path = format!("/bendtwin.v1.{method}");
        let answer = raw::call(&channel, &path, messages.clone());
        let code = within(&format!("{method}, {what}"), ANSWER, answer).await;
        // For bytes that are no message gRPC itself prescribes INTERNAL, which its library answers.
        let unreadable = what.starts_with(UNREADABLE) && code == Code::Internal;
        // A session that was lost and one that never existed cannot be distinguished.
        let lost = method.starts_with("SessionService") && code == Code::Aborted;
        if !is_the_clients(code) && !unreadable && !lost {
            let what: String = what.chars().take(100).collect();
            wrong.push(format!("{method}, {what}: {code:?}"));
        }
    }
    fixture.still_stands(calls.len(), &wrong).await;
}

/// Codes of faults in the request, not in the server.
fn is_the_clients(code: Code) -> bool {
    matches!(
        code,
        Code::InvalidArgument
            | Code::NotFound
            | Code::AlreadyExists
            | Code::FailedPrecondition
            | Code::OutOfRange
            | Code::ResourceExhausted
            | Code::Unimplemented
            | Code::Unauthenticated
    )
}

fn call(what: impl Into<String>, method: &'static str, message: &impl Message) -> Call {
    (what.into(), method, vec![message.encode_to_vec().into()])
}

/// Every method that takes a name, with every bad name.
fn names() -> Vec<Call> {
    const METHODS: [(&str, &str); 21] = [
        ("captures", "CaptureService/GetCapture"),
        ("captures", "CaptureService/DeleteCapture"),
        ("fits", "FitService/GetFit"),
        ("fits", "FitService/CancelFit"),
        ("fits", "FitService/DeleteFit"),
        ("fits", "FitService/WatchFit"),
        ("twins", "TwinService/GetTwin"),
        ("twins", "TwinService/DeleteTwin"),
        ("twins", "TwinService/ExportTwin"),
        ("twins", "RegistrationService/RegisterState"),
        ("twins", "EvaluationService/EvaluateTwin"),
        ("workers", "WorkerService/GetWorker"),
        ("captures", "FitService/CreateFit"),
        ("twins", "SessionService/OpenSession"),
        ("sessions", "SessionService/GetSession"),
        ("sessions", "SessionService/GetSessionStates"),
        ("sessions", "SessionService/AdvanceSession"),
        ("sessions", "SessionService/ForkSession"),
        ("sessions", "SessionService/ResetSession"),
        ("sessions", "SessionService/CorrectSession"),
        ("sessions", "SessionService/RenderSession"),
    ];
    let mut calls = Vec::new();
    for (collection, method) in METHODS {
        for name in bad_names(collection) {
            // The name is field 1 in every one of these messages.
            calls.push(call(format!("name {name:?}"), method, &GetTwinRequest { name }));
        }
    }
    calls
}

fn registrations(twin: &Twin) -> Vec<Call> {
    let shape = TwinShape {
        nodes: u64::from(twin.node_count),
        controls: u64::from(twin.control_count),
        ..TwinShape::default()
    };
    let call = |case: registration::Case| {
        let request = RegisterStateRequest { twin: twin.name.clone(), ..case.request };
        call(case.what, "RegistrationService/RegisterState", &request)
    };
    registration::malformed(&shape).into_iter().map(call).collect()
}

fn lists() -> Vec<Call> {
    const METHODS: [&str; 4] = [
        "CaptureService/ListCaptures",
        "FitService/ListFits",
        "TwinService/ListTwins",
        "FitService/ListFits",
    ];
    let mut calls = Vec::new();
    for (i, page_token) in fields::bad_page_tokens().into_iter().enumerate() {
        let request = ListFitsRequest { page_token: page_token.clone(), ..Default::default() };
        calls.push(call(
            format!("page token {page_token:?}"),
            METHODS[i % METHODS.len()],
            &request,
        ));
    }
    for name in bad_names("captures").into_iter().filter(|n| !n.is_empty()) {
        if name.ends_with("dead") && name.starts_with("captures/") {
            continue; // A list of the fits of a capture that is gone is empty, not wrong.
        }
        let request = ListFitsRequest { capture: name.clone(), ..Default::default() };
        calls.push(call(format!("fits of {name:?}"), "FitService/ListFits", &request));
        calls.push(call(format!("twins of {name:?}"), "TwinService/ListTwins", &request));
    }
    calls
}

fn fits(capture: &str) -> Vec<Call> {
    let base = CreateFitRequest { capture: capture.to_owned(), ..Default::default() };
    let create =
        |what: String, request: &CreateFitRequest| call(what, "FitService/CreateFit", request);
    let mut calls: Vec<_> = fields::bad_settings()
        .into_iter()
        .map(|settings_json| {
            let start: String = settings_json.chars().take(80).collect();
            let request = CreateFitRequest { settings_json, ..base.clone() };
            create(format!("settings {start}"), &request)
        })
        .collect();
    for priority in [i32::MIN, -101, 101, i32::MAX] {
        let request = CreateFitRequest { priority, ..base.clone() };
        calls.push(create(format!("priority {priority}"), &request));
    }
    let request = CreateFitRequest { request_id: fields::too_long(), ..base };
    calls.push(create("a long request id".to_owned(), &request));
    calls
}

fn uploads(archive: &Bytes, twin_file: &Bytes) -> Vec<Call> {
    use create_capture_request::Part;
    let capture = |what: &str, parts: Vec<Option<Part>>| {
        let messages = parts.into_iter().map(|part| CreateCaptureRequest { part });
        let messages = messages.map(|m| Bytes::from(m.encode_to_vec())).collect();
        (format!("upload, {what}"), "CaptureService/CreateCapture", messages)
    };
    let metadata = |m: CaptureMetadata| Some(Part::Metadata(m));
    let plain = || metadata(CaptureMetadata::default());
    let chunk = || Some(Part::Chunk(archive.slice(..1000)));
    let named = CaptureMetadata { display_name: fields::too_long(), ..Default::default() };
    let keyed = CaptureMetadata { request_id: fields::too_long(), ..Default::default() };
    let mut calls = vec![
        capture("nothing", vec![]),
        capture("no content", vec![plain()]),
        capture("an empty chunk only", vec![plain(), Some(Part::Chunk(Bytes::new()))]),
        capture("no metadata", vec![chunk()]),
        capture("metadata twice", vec![plain(), chunk(), plain()]),
        capture("an empty message", vec![None, chunk()]),
        capture("a long display name", vec![metadata(named), chunk()]),
        capture("a long request id", vec![metadata(keyed), chunk()]),
    ];
    for digest in fields::bad_digests() {
        let what = format!("digest {digest:?}");
        let about = CaptureMetadata { digest, ..Default::default() };
        calls.push(capture(&what, vec![metadata(about), chunk()]));
    }
    calls.extend(twin_files(twin_file));
    calls
}

/// Twin files that are damaged or contradict themselves.
fn twin_files(good: &Bytes) -> Vec<Call> {
    let patched = |at: usize, value: u8| {
        let mut bytes = good.to_vec();
        bytes[at] = value;
        bytes
    };
    let header = |length: u64| [&length.to_le_bytes()[..], &good[8..]].concat();
    let json = |text: &str| [&(text.len() as u64).to_le_bytes()[..], text.as_bytes()].concat();
    let huge = r#"{"nodes.mass":{"dtype":"F32","shape":[1000000000000],"data_offsets":[0,4000000000000]}}"#;
    let files = [
        ("empty", vec![]),
        ("eight bytes", good[..8].to_vec()),
        ("the first half", good[..good.len() / 2].to_vec()),
        ("all but the last byte", good[..good.len() - 1].to_vec()),
        ("one byte more", [&good[..], &[0]].concat()),
        ("a header of 2^63 bytes", header(1 << 63)),
        ("a header of 2^64 - 1 bytes", header(u64::MAX)),
        ("a header of no bytes", header(0)),
        ("a damaged header", patched(9, b'!')),
        ("no metadata", json("{}")),
        ("a tensor of 10^12 numbers", json(huge)),
        ("deep JSON", json(&"[".repeat(50_000))),
        ("a ZIP", b"PK\x03\x04not a twin".to_vec()),
    ];
    let upload = |content: Vec<u8>| {
        use create_twin_request::Part;
        let parts = [Part::Metadata(TwinMetadata::default()), Part::Chunk(content.into())];
        let messages = parts.map(|part| CreateTwinRequest { part: Some(part) }.encode_to_vec());
        messages.map(Bytes::from).to_vec()
    };
    files
        .map(|(what, file)| (format!("twin file, {what}"), "TwinService/CreateTwin", upload(file)))
        .into()
}

/// Bytes that are no message, methods that do not exist.
fn broken_bytes() -> Vec<Call> {
    let bytes: [(&str, &'static [u8]); 8] = [
        ("a tag alone", b"\x0a"),
        ("a truncated string", b"\x0a\x30twins/"),
        ("a length of 2^63", b"\x0a\xff\xff\xff\xff\xff\xff\xff\xff\x7f"),
        ("an endless varint", b"\x08\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff"),
        ("field number 0", b"\x02\x01x"),
        ("wire type 7", b"\x0f"),
        ("bad UTF-8", b"\x0a\x04\xff\xfe\x80\xc0"),
        ("an unopened group", b"\x0c"),
    ];
    let mut calls = Vec::new();
    for (what, bytes) in bytes {
        for method in [
            "TwinService/GetTwin",
            "RolloutService/RollOut",
            "FitService/WatchFit",
            "SessionService/OpenSession",
            "SessionService/ControlSession",
        ] {
            calls.push((format!("{UNREADABLE} {what}"), method, vec![Bytes::from_static(bytes)]));
        }
    }
    let name = Bytes::from_static(b"\x0a\x01x");
    for method in ["TwinService/Nothing", "NoService/GetTwin", "TwinService", "TwinService/getTwin"]
    {
        calls.push(("no such method".to_owned(), method, vec![name.clone()]));
    }
    calls.push((format!("{UNREADABLE} nothing"), "TwinService/GetTwin", vec![]));
    calls.push(("two messages".to_owned(), "TwinService/GetTwin", vec![name.clone(), name]));
    calls
}
