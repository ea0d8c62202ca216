//! Writes a mesh as binary glTF, for made recordings.

use crate::Mesh;

/// A GLB file with one mesh, in the mesh's own axes and unit.
pub fn write_glb(mesh: &Mesh) -> Vec<u8> {
    let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let positions: Vec<u8> = mesh.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let [low, high] = mesh.bounds().unwrap_or_default();
    let document = serde_json::json!({
        "asset": {"version": "2.0", "generator": "bendtwin"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5125, "count": mesh.triangles.len() * 3, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": mesh.vertices.len(), "type": "VEC3",
             "min": low, "max": high},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": indices.len()},
            {"buffer": 0, "byteOffset": indices.len(), "byteLength": positions.len()},
        ],
        "buffers": [{"byteLength": indices.len() + positions.len()}],
    });
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = [indices, positions].concat();

    let mut out = Vec::with_capacity(28 + json.len() + data.len());
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&((28 + json.len() + data.len()) as u32).to_le_bytes());
    for (kind, content) in [(b"JSON", json), (b"BIN\0", data)] {
        out.extend_from_slice(&(content.len() as u32).to_le_bytes());
        out.extend_from_slice(kind);
        out.extend_from_slice(&content);
    }
    out
}
