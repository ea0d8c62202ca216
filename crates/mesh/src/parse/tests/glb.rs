use serde_json::{Value, json};

use super::{limits, parse, reason};
use crate::{shapes::creature, write_glb};

/// A GLB file of a document and data.
fn file(document: &Value, data: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + json.len() + data.len()) as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&json);
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(data);
    out
}

/// A square of four corners, interleaved with other data, as a fan.
fn square() -> (Value, Vec<u8>) {
    let mut data = Vec::new();
    for [x, y] in [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        for number in [x, y, 0.0, 77.0] {
            data.extend(number.to_le_bytes());
        }
    }
    let document = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 64, "byteStride": 16}],
        "buffers": [{"byteLength": 64}],
    });
    (document, data)
}

/// The reason for which the square is refused with one value of its document changed.
fn changed(pointer: &str, key: &str, value: Value) -> &'static str {
    let (mut document, data) = square();
    document.pointer_mut(pointer).unwrap()[key] = value;
    reason("a.glb", &file(&document, &data))
}

#[test]
fn what_was_written_is_read() {
    let mesh = creature();
    assert_eq!(parse("a.glb", &write_glb(&mesh), &limits()).unwrap(), mesh);
}

#[test]
fn strips_fans_and_strides() {
    let (mut document, data) = square();
    let read = |document: &Value| parse("a.glb", &file(document, &data), &limits()).unwrap();
    let fan = read(&document);
    assert_eq!(fan.vertices[2], [1.0, 1.0, 0.0]);
    assert_eq!(fan.triangles, [[0, 1, 2], [0, 2, 3]]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(5);
    assert_eq!(read(&document).triangles, [[0, 1, 2], [2, 1, 3]]);
}

#[test]
fn transforms_of_all_nodes_apply_and_mirrors_turn_faces() {
    let (mut document, data) = square();
    let half = 0.5_f64.sqrt();
    document["scene"] = json!(0);
    document["scenes"] = json!([{"nodes": [0]}]);
    document["nodes"] = json!([
        {"children": [1, 2], "translation": [10.0, 0.0, 0.0]},
        {"mesh": 0, "rotation": [0.0, 0.0, half, half], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]},
        {"mesh": 0},
    ]);
    let mesh = parse("a.glb", &file(&document, &data), &limits()).unwrap();
    // The last node is not in the scene.
    assert_eq!(mesh.vertices.len(), 8);
    for (found, expected) in mesh.vertices[1].iter().zip([10.0, 2.0, 0.0]) {
        assert!((found - expected).abs() < 1e-6);
    }
    assert_eq!(mesh.vertices[5], [9.0, 0.0, 5.0]);
    assert_eq!(mesh.triangles[2], [4, 6, 5]);
}

#[test]
fn quantized_positions_are_scaled() {
    let (mut document, _) = square();
    document["accessors"][0] = json!({"bufferView": 0, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3"});
    document["bufferViews"][0] = json!({"buffer": 0, "byteLength": 12, "byteStride": 4});
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let data = [255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 51, 9];
    let mesh = parse("a.glb", &file(&document, &data), &limits()).unwrap();
    assert_eq!(mesh.vertices, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.2]]);
}

#[test]
fn compression_and_data_elsewhere_are_named() {
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {}}});
    assert_eq!(changed("/meshes/0/primitives/0", "extensions", draco), "MESH_COMPRESSED");
    let meshopt = json!({"EXT_meshopt_compression": {}});
    assert_eq!(changed("/bufferViews/0", "extensions", meshopt), "MESH_COMPRESSED");
    let required = json!(["KHR_draco_mesh_compression"]);
    assert_eq!(changed("", "extensionsRequired", required), "MESH_COMPRESSED");
    assert_eq!(changed("", "extensionsRequired", json!(["EXT_odd"])), "MESH_UNSUPPORTED");
    assert_eq!(changed("/buffers/0", "uri", json!("a.bin")), "MESH_EXTERNAL_DATA");
    assert_eq!(changed("/accessors/0", "sparse", json!({"count": 1})), "MESH_UNSUPPORTED");
}

#[test]
fn documents_that_lie_are_refused() {
    assert_eq!(changed("/accessors/0", "count", json!(5)), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(changed("/accessors/0", "count", json!(u64::MAX)), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(changed("/accessors/0", "byteOffset", json!(u64::MAX)), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(changed("/bufferViews/0", "byteOffset", json!(u64::MAX)), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(changed("/bufferViews/0", "byteLength", json!(u64::MAX)), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(changed("/bufferViews/0", "byteStride", json!(0)), "MESH_DAMAGED");
    assert_eq!(changed("/bufferViews/0", "buffer", json!(1)), "MESH_DAMAGED");
    assert_eq!(changed("/accessors/0", "type", json!("VEC2")), "MESH_DAMAGED");
    assert_eq!(changed("/accessors/0", "componentType", json!(1)), "MESH_DAMAGED");
    assert_eq!(changed("/accessors/0", "bufferView", json!(9)), "MESH_DAMAGED");
    assert_eq!(changed("/meshes/0/primitives/0", "indices", json!(0)), "MESH_DAMAGED");
    assert_eq!(changed("/meshes/0/primitives/0", "mode", json!(0)), "MESH_EMPTY");
    assert_eq!(changed("/nodes/0", "mesh", json!(9)), "MESH_DAMAGED");
    assert_eq!(changed("/nodes/0", "rotation", json!([0, 0, 0, 0])), "MESH_NOT_FINITE");
    assert_eq!(changed("/nodes/0", "scale", json!([1e300, 1, 1])), "MESH_NOT_FINITE");
    assert_eq!(changed("", "scenes", json!([{"nodes": [0, 0]}])), "MESH_DAMAGED");
    assert_eq!(
        changed("", "nodes", json!([{"children": [1]}, {"children": [1], "mesh": 0}])),
        "MESH_DAMAGED"
    );
    assert_eq!(
        changed("", "nodes", json!([{"children": [1]}, {"children": [0], "mesh": 0}])),
        "MESH_EMPTY"
    );
    assert_eq!(reason("a.glb", b"glTF"), "MESH_DAMAGED");
    assert_eq!(reason("a.glb", &[0; 64]), "MESH_DAMAGED");
    let deep = [b"glTF\x02\0\0\0\xff\xff\xff\xff".as_slice(), &[b'['; 100]].concat();
    assert_eq!(reason("a.glb", &deep), "MESH_CLAIMS_TOO_MUCH");
}

#[test]
fn deep_and_large_json_is_refused() {
    let raw = |json: &[u8]| {
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((20 + json.len() as u32).to_le_bytes());
        out.extend((json.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(json);
        out
    };
    assert_eq!(reason("a.glb", &raw(&[b'['; 100_000])), "MESH_DAMAGED");
    assert_eq!(reason("a.glb", &raw(&vec![b' '; 5 << 20])), "MESH_TOO_LARGE");
    // Empty parts shown again and again cost time only.
    let many = json!({
        "meshes": [{"primitives": vec![json!({"mode": 0}); 3000]}],
        "nodes": vec![json!({"mesh": 0}); 3000],
    });
    assert_eq!(reason("a.glb", &raw(many.to_string().as_bytes())), "MESH_TOO_MANY");
}
