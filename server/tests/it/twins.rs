use bendtwin_core::{
    Environment, Graph, NodeKind, Params, Quality, Timing, Twin, environment::ControlVelocity,
    twin::Provenance,
};
use bendtwin_proto::v1::{
    CreateTwinRequest, ExportTwinRequest, ListTwinsRequest, TwinMetadata, create_twin_request::Part,
};
use bytes::Bytes;
use serde_json::json;

use crate::harness::{Server, read};

/// Two nodes and a spring.
pub(crate) fn twin_file() -> Vec<u8> {
    let graph = Graph {
        rest_positions: vec![[0.0; 3], [0.1, 0.0, 0.0]],
        kinds: vec![NodeKind::Observed; 2],
        masses: vec![1.0; 2],
        object_ids: vec![0; 2],
        observed_points: vec![0, 1],
        springs: vec![[0, 1]],
        ..Graph::default()
    };
    let params = Params {
        rest_lengths_m: vec![0.1],
        spring_stiffness: vec![100.0],
        spring_dashpot: vec![1.0],
        ..Params::default()
    };
    let twin = Twin {
        graph,
        params,
        environment: Environment::Z_UP,
        timing: Timing { fps: 30.0, substeps: 20 },
        control_velocity: ControlVelocity::True,
        provenance: Provenance::default(),
        quality: Quality::default(),
    };
    twin.encode().unwrap()
}

#[tokio::test]
async fn a_twin_file_is_imported_listed_exported_and_deleted() {
    let server = Server::start().await;
    let file = twin_file();
    let request = server.http.post(server.url("/v1/twins?display_name=toy")).body(file.clone());
    let (status, twin) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 201, "{twin}");
    assert_eq!((&twin["node_count"], &twin["spring_count"]), (&json!(2), &json!(1)));
    assert_eq!((&twin["fps"], &twin["substeps"]), (&json!(30.0), &json!(20)));
    assert_eq!((&twin["capture"], &twin["fit"]), (&json!(null), &json!(null)));
    let name = twin["name"].as_str().unwrap();
    assert_eq!(server.get(&format!("/v1/{name}")).await, (200, twin.clone()));
    assert_eq!(server.get("/v1/twins").await.1["twins"], json!([twin]));
    let content = server.http.get(server.url(&format!("/v1/{name}/content"))).send().await.unwrap();
    assert!(content.bytes().await.unwrap() == file);

    let mut twins = server.twins();
    let mut chunks =
        twins.export_twin(ExportTwinRequest { name: name.to_owned() }).await.unwrap().into_inner();
    let mut exported = Vec::new();
    while let Some(chunk) = chunks.message().await.unwrap() {
        exported.extend(chunk.chunk);
    }
    assert!(exported == file);
    let parts = [Part::Metadata(TwinMetadata::default()), Part::Chunk(Bytes::from(file))];
    let parts = parts.map(|part| CreateTwinRequest { part: Some(part) });
    let copy = twins.create_twin(futures::stream::iter(parts)).await.unwrap().into_inner();
    assert_eq!(copy.digest, twin["digest"].as_str().unwrap());
    let list = twins.list_twins(ListTwinsRequest::default()).await.unwrap().into_inner();
    assert_eq!(list.twins.len(), 2);
    assert_eq!(server.blob_files(), 1);
    assert_eq!(server.delete(&format!("/v1/{name}")).await.0, 204);
    assert_eq!(server.delete(&format!("/v1/{}", copy.name)).await.0, 204);
    assert_eq!(server.blob_files(), 0);
}

#[tokio::test]
async fn what_is_no_twin_is_refused() {
    let server = Server::start().await;
    let mut damaged = twin_file();
    damaged.truncate(damaged.len() - 1);
    for body in [Vec::new(), b"hello".to_vec(), vec![0xff; 100], damaged] {
        let request = server.http.post(server.url("/v1/twins")).body(body);
        let (status, problem) = read(request.send().await.unwrap()).await;
        assert_eq!((status, &problem["reason"]), (400, &json!("INVALID_TWIN_FILE")));
    }
}
