use bendtwin_core::{
    Graph, Identifiability, NodeKind, Params, Pin, Skin, Timing, Twin, identifiability::Region,
};
use bendtwin_proto::v1::{
    CreateTwinRequest, ExportTwinRequest, GetTwinGeometryRequest, ListTwinsRequest, Tensor,
    TwinMetadata, create_twin_request::Part,
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
    let twin = Twin::new(graph, params, Timing { fps: 30.0, substeps: 20 });
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
    assert_eq!(server.purge(&format!("/v1/{name}")).await.0, 204);
    assert_eq!(server.purge(&format!("/v1/{}", copy.name)).await.0, 204);
    assert_eq!(server.blob_files(), 0);
}

#[tokio::test]
async fn the_geometry_of_a_twin_is_served_over_both_transports() {
    let server = Server::start().await;
    let mut twin = Twin::decode(&twin_file()).unwrap();
    twin.graph.control_rest = vec![[0.0, 0.0, 0.1], [0.5, 0.0, 0.1], [0.0, 0.05, 0.1]];
    twin.graph.springs.push([1, 3]);
    twin.graph.pins = vec![Pin { node: 0, control: 2, offset_m: [0.0; 3] }];
    twin.params.rest_lengths_m.push(0.3);
    twin.params.spring_stiffness.push(1.0);
    twin.params.spring_dashpot.push(1.0);
    twin.mass_kg = Some(0.5);
    let none = [Skin::NO_FRAME; 3];
    twin.skin.push(Graph::NOT_OBSERVED, &[(0, 0.25), (1, 0.75)], none, [0.0, 0.0, 0.5]);
    let region = |name: &str| Region { name: name.into(), center: [0.0; 3], nodes: 1 };
    twin.quality.identifiability = Some(Identifiability {
        summary: vec!["The free end is open.".into()],
        regions: vec![region("near the hand"), region("free end")],
        node_regions: vec![0, 1],
        point_sd_m: vec![0.001, 0.002, 0.004],
        ..Identifiability::default()
    });
    let request = server.http.post(server.url("/v1/twins")).body(twin.encode().unwrap());
    let (_, stored) = read(request.send().await.unwrap()).await;
    assert_eq!(stored["mass_kg"], json!(0.5));
    let report = &stored["quality"]["identifiability"];
    assert_eq!(report["summary"], json!(["The free end is open."]));
    assert_eq!(report["regions"][1]["name"], json!("free end"));
    let name = stored["name"].as_str().unwrap();
    let request = GetTwinGeometryRequest { name: name.to_owned() };
    let geometry = server.twins().get_twin_geometry(request).await.unwrap().into_inner();
    let numbers = |tensor: &Option<Tensor>| tensor.as_ref().unwrap().unpack::<u32>("t").unwrap();
    assert_eq!(numbers(&geometry.edges), (vec![2, 2], vec![0, 1, 1, 3]));
    assert_eq!(numbers(&geometry.hands), (vec![3], vec![0, 1, 0]));
    assert_eq!(numbers(&geometry.pins), (vec![1, 2], vec![0, 2]));
    let (_, masses) = geometry.masses.as_ref().unwrap().unpack::<f32>("m").unwrap();
    assert_eq!(masses, [0.25; 2]);
    let stiffness = |tensor: &Option<Tensor>| tensor.as_ref().unwrap().unpack::<f32>("s").unwrap();
    assert_eq!(stiffness(&geometry.spring_stiffness), (vec![2], vec![25.0, 0.25]));
    assert_eq!(stiffness(&geometry.bend_stiffness), (vec![0], vec![]));
    let regions = geometry.node_regions.as_ref().unwrap().unpack::<u8>("r").unwrap();
    assert_eq!(regions, (vec![2], vec![0, 1]));
    assert_eq!(stiffness(&geometry.skin_sd), (vec![3], vec![0.001, 0.002, 0.004]));
    assert_eq!((geometry.surface_count, geometry.fps, geometry.substeps), (2, 30.0, 20));
    assert!((geometry.spacing_m - 0.1).abs() < 1e-6, "{}", geometry.spacing_m);
    assert_eq!(geometry.ground.unwrap().normal, [0.0, 0.0, 1.0]);
    let skin = geometry.skin.unwrap();
    let (shape, at_rest) = skin.rest_positions.as_ref().unwrap().unpack_points("t").unwrap();
    assert_eq!((shape, at_rest), (vec![3], twin.skin.positions(&twin.graph.rest_positions)));
    assert_eq!(numbers(&skin.observed_points), (vec![3], vec![0, 1, u32::MAX]));
    assert_eq!(numbers(&skin.weight_counts), (vec![3], vec![1, 1, 2]));
    assert_eq!(numbers(&skin.weight_nodes), (vec![4], vec![0, 1, 0, 1]));
    let (_, weights) = skin.weights.unwrap().unpack::<f32>("t").unwrap();
    assert_eq!(weights, [1.0, 1.0, 0.25, 0.75]);
    assert_eq!(numbers(&skin.frames), (vec![3, 3], vec![u32::MAX; 9]));
    let (_, offsets) = skin.offsets.unwrap().unpack_points("t").unwrap();
    assert_eq!(offsets, [[0.0; 3], [0.0; 3], [0.0, 0.0, 0.5]]);

    let (status, lists) = server.get(&format!("/v1/{name}/geometry")).await;
    assert_eq!((status, &lists["edges"]), (200, &json!([[0, 1], [1, 3]])));
    assert_eq!((&lists["mass_kg"], &lists["kinds"]), (&json!(0.5), &json!([0, 0])));
    assert_eq!(lists["skin"]["offsets"][2], json!([0.0, 0.0, 0.5]));
    let (_, packed) = server.get(&format!("/v1/{name}/geometry?tensors=base64")).await;
    assert_eq!(packed["hands"]["shape"], json!([3]));
    let absent = name.replace(|c: char| c.is_ascii_digit(), "0");
    assert_eq!(server.get(&format!("/v1/{absent}/geometry")).await.0, 404);
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
