//! Requests: rollouts as JSON and as messages, registrations, settings, headers of uploads, and the report that
//! the reader of a capture hands to its worker.

use bendtwin_contract::{
    registration::{check_registration, memory_bytes, registration_work},
    rollout::{Limits, TwinShape, check_for},
};
use bendtwin_core::{
    FitSettings,
    settings::{ingest::IngestSettings, layers},
};
use bendtwin_inspect::Report;
use bendtwin_proto::{
    json::{Read, TensorFormat, Write},
    v1::{RegisterStateRequest, RollOutRequest},
};
use prost::Message as _;

/// The twin that requests are checked against.
pub(crate) const SHAPE: TwinShape = TwinShape {
    nodes: 3,
    springs: 3,
    triplets: 1,
    controls: 1,
    skin_points: Some(4),
    rods: Some(0),
    substeps: 50,
    fast_substeps: Some(10),
    planner: None,
    has_capture: true,
};

/// A rollout request as JSON.
pub fn rollout_json(data: &[u8]) {
    let Ok(Read(request)) = serde_json::from_slice::<Read<RollOutRequest>>(data) else { return };
    expect_checked(&request);
    let message = &request;
    let written = serde_json::to_vec(&Write { message, tensors: TensorFormat::Base64 });
    let written = written.expect("bytes can always be written");
    let again: Read<RollOutRequest> =
        serde_json::from_slice(&written).expect("what was written is read");
    assert_eq!(again.0, request);
    // Lists cannot hold every tensor, but that is an error and no panic.
    let _ = serde_json::to_vec(&Write { message, tensors: TensorFormat::Lists });
}

/// A rollout request as a message.
pub fn rollout_message(data: &[u8]) {
    let Ok(request) = RollOutRequest::decode(data) else { return };
    expect_checked(&request);
    let again = RollOutRequest::decode(request.encode_to_vec().as_slice());
    // Compared as bytes, because NaN is no equal of itself.
    assert_eq!(again.map(|again| again.encode_to_vec()), Ok(request.encode_to_vec()));
}

/// A registration as a message.
pub fn registration_message(data: &[u8]) {
    let Ok(request) = RegisterStateRequest::decode(data) else { return };
    let limits = Limits { memory_bytes: 64 << 20, ..Limits::default() };
    if check_registration(&request, &SHAPE, &limits).is_ok() {
        assert!(memory_bytes(request.observation.as_ref(), &SHAPE) <= limits.memory_bytes);
        assert!(registration_work(&request, &SHAPE) <= limits.work);
    }
    let again = RegisterStateRequest::decode(request.encode_to_vec().as_slice());
    assert_eq!(again.map(|again| again.encode_to_vec()), Ok(request.encode_to_vec()));
}

/// What passes the check is within the limits.
fn expect_checked(request: &RollOutRequest) {
    let limits = Limits { instances: 1000, frames: 1000, costs: 16, ..Limits::default() };
    let Ok(batch) = check_for(request, &SHAPE, &limits, 0) else { return };
    assert!((1..=limits.instances).contains(&batch.instances));
    assert!((1..=limits.frames).contains(&batch.frames));
    assert!(batch.knots >= 2);
    assert!(request.costs.len() as u64 <= limits.costs);
}

/// Settings of a fit and of an ingest.
pub fn settings(data: &[u8]) {
    if let Ok(fit) = serde_json::from_slice::<FitSettings>(data) {
        let _ = fit.validate();
        let _ = layers::changes(&fit);
        let written = serde_json::to_vec(&fit).expect("settings can be written");
        assert_eq!(serde_json::from_slice::<FitSettings>(&written).ok(), Some(fit));
    }
    if let Ok(ingest) = serde_json::from_slice::<IngestSettings>(data) {
        let _ = ingest.validate();
        let written = serde_json::to_vec(&ingest).expect("settings can be written");
        assert_eq!(serde_json::from_slice::<IngestSettings>(&written).ok(), Some(ingest));
    }
    if let Ok(document) = serde_json::from_slice::<serde_json::Value>(data) {
        let _ = layers::unknown_fields(&document);
        let mut merged = serde_json::to_value(FitSettings::default()).expect("they can be written");
        layers::merge(&mut merged, document.clone());
        let once = merged.clone();
        layers::merge(&mut merged, document);
        assert_eq!(merged, once, "a layer changes nothing when it is laid again");
    }
}

/// Headers of a resumable upload: a line each, `name: value`.
#[cfg(feature = "uploads")]
pub fn tus(data: &[u8]) {
    let lines = data.split(|byte| *byte == b'\n');
    let headers = lines.filter_map(|line| {
        let at = line.iter().position(|byte| *byte == b':')?;
        Some((&line[..at], line[at + 1..].trim_ascii()))
    });
    bendtwin_server::read_upload_headers(headers);
}

/// The report of an ingest, as the worker reads it from the process that read the capture.
pub fn report(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(report) = Report::from_json(text) else { return };
    let written = report.to_json();
    let again = Report::from_json(&written).expect("what was written is read");
    assert_eq!(again.to_json(), written);
    report.to_html();
}
