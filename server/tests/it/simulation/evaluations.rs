use bendtwin_core::ids::CaptureId;
use bendtwin_proto::v1::{EvaluateTwinRequest, evaluation_service_client::EvaluationServiceClient};
use serde_json::json;
use tonic::Code;

use super::rollouts::twin;
use crate::{harness::Server, worker::Worker};

#[tokio::test]
async fn an_evaluation_goes_to_a_worker_and_names_it() {
    let server = Server::start().await;
    let mut worker = Worker::register(&server).await;
    let twin = twin(&server, &mut worker).await;
    let (_, list) = server.get("/v1/captures").await;
    let capture = list["captures"][0]["name"].as_str().unwrap().to_owned();

    let mut client = EvaluationServiceClient::new(server.channel.clone());
    let request = |capture: &str| EvaluateTwinRequest {
        twin: twin.clone(),
        capture: capture.into(),
        motion: None,
    };
    let reply = client.evaluate_twin(request(&capture)).await.unwrap().into_inner();
    assert_eq!((reply.twin, reply.worker), (twin.clone(), worker.id.to_string()));
    assert_eq!(reply.quality_json, r#"{"scores":[]}"#);

    let path = format!("/v1/{twin}/evaluations");
    let (status, reply) = server.post(&path, json!({"capture": capture})).await;
    assert_eq!(status, 200, "{reply}");
    assert_eq!(reply["quality"], json!({"scores": []}));
    assert_eq!(reply["capture"], json!(capture));

    assert_eq!(reply["motion"], json!(null));
    let asked = json!({"capture": capture, "motion": {"sequence": 2}});
    let (_, reply) = server.post(&path, asked.clone()).await;
    let motion = &reply["motion"];
    assert_eq!((&motion["sequence"], &motion["train_frame_count"]), (&json!(2), &json!(1)));
    assert_eq!(motion["positions"], json!([[[1.0, 2.0, 3.0]]]));
    assert_eq!(motion["track_m"], json!([0.5, null]));
    let (_, reply) = server.post(&format!("{path}?tensors=base64"), asked).await;
    assert_eq!(reply["motion"]["positions"]["shape"], json!([1, 1, 3]), "{reply}");

    // Unknown names are reported before a worker is asked.
    let nowhere = CaptureId::generate().to_string();
    let missing = client.evaluate_twin(request(&nowhere)).await.unwrap_err();
    assert_eq!(missing.code(), Code::NotFound);
    let (status, problem) = server.post(&path, json!({"capture": "fits/x"})).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_NAME")), "{problem}");
    let (status, _) = server.post(&path, json!({"recording": capture})).await;
    assert_eq!(status, 400);
    let late = format!("{path}?timeout_s=-1");
    let (status, problem) = server.post(&late, json!({"capture": capture})).await;
    assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_FIELD")));
}
