use bendtwin_core::{
    Graph, Identifiability, NodeKind, Params, Pin, Point, Skin, Surface, Timing, Twin,
    identifiability::Region,
    quality::{Assessment, Level},
};
use bendtwin_proto::v1::{
    CreateTwinRequest, ExportTwinRequest, GetTwinGeometryRequest, GetTwinSurfaceRequest,
    ListTwinsRequest, Tensor, TwinMetadata, create_twin_request::Part,
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

/// A twin of one triangle, in one colour.
fn triangle() -> Twin {
    let mut twin = Twin::decode(&twin_file()).unwrap();
    let mut carriers = Skin { starts: vec![0], ..Skin::default() };
    for (node, offset) in [(0, [0.0; 3]), (1, [0.0; 3]), (0, [0.0, 0.0, 0.2])] {
        carriers.push(Graph::NOT_OBSERVED, &[(node, 1.0)], [Skin::NO_FRAME; 3], offset);
    }
    let colors = vec![[10, 200, 30]; 3];
    twin.surface =
        Some(Surface { carriers, triangles: vec![[0, 1, 2]], colors, ..Surface::default() });
    twin
}

#[tokio::test]
async fn a_surface_is_served_drawn_and_exported() {
    let server = Server::start().await;
    let twin = triangle();
    let request = server.http.post(server.url("/v1/twins")).body(twin.encode().unwrap());
    let (_, stored) = read(request.send().await.unwrap()).await;
    let path = format!("/v1/{}", stored["name"].as_str().unwrap());
    let request = GetTwinSurfaceRequest { name: stored["name"].as_str().unwrap().to_owned() };
    let surface = server.twins().get_twin_surface(request).await.unwrap().into_inner();
    let triangles = surface.triangles.unwrap().unpack::<u32>("t").unwrap();
    assert_eq!(triangles, (vec![1, 3], vec![0, 1, 2]));
    assert_eq!(surface.node_count, 2);
    let (status, lists) = server.get(&format!("{path}/surface")).await;
    assert_eq!((status, &lists["colors"][1]), (200, &json!([10, 200, 30])));
    assert_eq!(lists["carriers"]["offsets"][2][2].as_f64().map(|z| z as f32), Some(0.2));

    let get = async |path: String| server.http.get(server.url(&path)).send().await.unwrap();
    let picture = get(format!("{path}/thumbnail?width=64")).await;
    assert_eq!(picture.headers()["content-type"], "image/png");
    let tag = picture.headers()["etag"].clone();
    let bytes = picture.bytes().await.unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!((&bytes[16..20], &bytes[20..24]), (&[0, 0, 0, 64][..], &[0, 0, 0, 48][..]));
    assert_eq!(get(format!("{path}/thumbnail?width=64")).await.bytes().await.unwrap(), bytes);
    let again = server.http.get(server.url(&format!("{path}/thumbnail?width=64")));
    assert_eq!(again.header("if-none-match", tag).send().await.unwrap().status(), 304);
    for width in ["0", "15", "1025", "x", "-1"] {
        assert_eq!(get(format!("{path}/thumbnail?width={width}")).await.status(), 400, "{width}");
    }

    let file = get(format!("{path}/export?format=glb")).await;
    let name = file.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(name.ends_with(".glb\""), "{name}");
    assert_eq!(&file.bytes().await.unwrap()[..4], b"glTF");
    let file = get(format!("{path}/export?format=twin")).await.bytes().await.unwrap();
    assert_eq!(Twin::decode(&file).unwrap().surface, twin.surface);
    let page = get(format!("{path}/export?format=html")).await;
    let name = page.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(name.starts_with("attachment") && name.ends_with(".html\""), "{name}");
    assert!(page.text().await.unwrap().starts_with("<!doctype html>"));
    for (format, reason) in [("stl", "INVALID_FIELD"), ("splats", "EXPORT_NO_SPLATS")] {
        let (status, problem) = server.get(&format!("{path}/export?format={format}")).await;
        assert_eq!((status, &problem["reason"]), (400, &json!(reason)));
    }
}

#[tokio::test]
async fn a_twin_without_a_surface_gets_one_unless_its_points_are_too_few() {
    let server = Server::start().await;
    let mut few = Twin::decode(&twin_file()).unwrap();
    // A spring between two nodes would be a cable.
    few.graph.springs.clear();
    few.params.rest_lengths_m.clear();
    few.params.spring_stiffness.clear();
    few.params.spring_dashpot.clear();
    let request = server.http.post(server.url("/v1/twins")).body(few.encode().unwrap());
    let (_, stored) = read(request.send().await.unwrap()).await;
    let path = format!("/v1/{}", stored["name"].as_str().unwrap());
    for part in ["surface", "thumbnail"] {
        let (status, problem) = server.get(&format!("{path}/{part}")).await;
        assert_eq!((status, &problem["reason"]), (404, &json!("SURFACE_MISSING")), "{part}");
    }
    // It is written as what it has.
    let file = server.http.get(server.url(&format!("{path}/export?format=ply"))).send().await;
    assert_eq!(&file.unwrap().bytes().await.unwrap()[..3], b"ply");

    let side = 6;
    let at = |i: usize| (i % side) as f32 * 0.02;
    let points: Vec<Point> =
        (0..side.pow(3)).map(|i| [at(i), at(i / side), at(i / side / side)]).collect();
    let count = points.len();
    let graph = Graph {
        rest_positions: points,
        kinds: vec![NodeKind::Observed; count],
        masses: vec![1.0; count],
        object_ids: vec![0; count],
        observed_points: vec![Graph::NOT_OBSERVED; count],
        ..Graph::default()
    };
    let block = Twin::new(graph, Params::default(), Timing { fps: 30.0, substeps: 10 });
    let request = server.http.post(server.url("/v1/twins")).body(block.encode().unwrap());
    let (status, stored) = read(request.send().await.unwrap()).await;
    assert_eq!(status, 201, "{stored}");
    let path = format!("/v1/{}", stored["name"].as_str().unwrap());
    let (status, surface) = server.get(&format!("{path}/surface")).await;
    assert_eq!(status, 200, "{surface}");
    assert!(surface["triangles"].as_array().unwrap().len() > 100);
    assert_eq!(server.get(&format!("{path}/thumbnail")).await.0, 200);
}

#[tokio::test]
async fn twins_are_filtered_by_their_level_and_lists_are_counted() {
    let server = Server::start().await;
    for level in [Some(Level::Fair), Some(Level::Good), Some(Level::Fair), None] {
        let mut twin = Twin::decode(&twin_file()).unwrap();
        twin.quality.assessment =
            level.map(|level| Assessment { level, why: "It is.".into(), next: String::new() });
        let request = server.http.post(server.url("/v1/twins")).body(twin.encode().unwrap());
        assert_eq!(request.send().await.unwrap().status(), 201);
    }
    let count = async |query: &str| {
        let (status, list) = server.get(&format!("/v1/twins{query}")).await;
        assert_eq!(status, 200, "{list}");
        (list["twins"].as_array().map_or(0, Vec::len), list["total_size"].clone())
    };
    assert_eq!(count("").await, (4, json!(4)));
    assert_eq!(count("?level=fair&page_size=1").await, (1, json!(2)));
    assert_eq!(count("?level=poor").await, (0, json!(0)));
    let (_, list) = server.get("/v1/twins?level=fair&page_size=1").await;
    let next = list["next_page_token"].as_str().unwrap();
    let (_, list) =
        server.get(&format!("/v1/twins?level=fair&page_size=1&page_token={next}")).await;
    assert_eq!(list.get("total_size"), None, "only the first page is counted");
    // A token belongs to its list.
    assert_eq!(server.get(&format!("/v1/twins?level=good&page_token={next}")).await.0, 400);
    assert_eq!(server.get("/v1/twins?level=best").await.0, 400);
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
