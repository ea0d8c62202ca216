//! Meshes.

use bendtwin_mesh::{Limits, parse, write_glb};

/// A GLB file.
pub fn glb(data: &[u8]) {
    read("fuzz.glb", data);
}

/// An OBJ file.
pub fn obj(data: &[u8]) {
    read("fuzz.obj", data);
}

/// A PLY file.
pub fn ply(data: &[u8]) {
    read("fuzz.ply", data);
}

fn read(name: &str, data: &[u8]) {
    let limits = Limits { file_bytes: 1 << 20, vertices: 10_000, triangles: 20_000 };
    let Ok(mesh) = parse(name, data, &limits) else { return };
    assert!(mesh.vertices.len() <= limits.vertices && mesh.triangles.len() <= limits.triangles);
    assert!(mesh.vertices.iter().flatten().all(|x| x.is_finite()));
    assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < mesh.vertices.len()));
    let again = parse("again.glb", &write_glb(&mesh), &limits);
    assert_eq!(again.expect("what was written is read"), mesh);
}
