use proptest::prelude::*;

use super::*;
use crate::{shapes::creature, write_glb};

mod glb;

fn limits() -> Limits {
    Limits::default()
}

fn reason(name: &str, bytes: &[u8]) -> &'static str {
    use bendtwin_core::Problem;
    parse(name, bytes, &limits()).map_or_else(|e| e.reason(), |_| "no error")
}

const ASCII_PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3\n3 0 1 2\n";

/// The mesh in binary.
fn binary_ply(big: bool) -> Vec<u8> {
    let name = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut out = format!(
        "ply\nformat {name} 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty short z\n\
         element face 2\nproperty uchar flags\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put =
        |bytes: Vec<u8>| out.extend(if big { bytes.into_iter().rev().collect() } else { bytes });
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        put(f64::to_le_bytes(x).to_vec());
        put(f32::to_le_bytes(y as f32).to_vec());
        put(i16::to_le_bytes(0).to_vec());
    }
    for face in [&[0_u32, 1, 2, 3][..], &[0, 1, 2]] {
        put(vec![7]);
        put(vec![face.len() as u8]);
        face.iter().for_each(|i| put(i.to_le_bytes().to_vec()));
    }
    out
}

#[test]
fn all_kinds_of_ply_say_the_same() {
    let ascii = parse("a.ply", ASCII_PLY.as_bytes(), &limits()).unwrap();
    assert_eq!(ascii.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    for big in [false, true] {
        assert_eq!(parse("A.PLY", &binary_ply(big), &limits()).unwrap(), ascii);
    }
}

#[test]
fn ply_headers_that_lie_are_refused() {
    let with = |from: &str, to: &str| reason("a.ply", ASCII_PLY.replace(from, to).as_bytes());
    assert_eq!(with("vertex 4", "vertex 99999999999"), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(with("face 2", "face 4000000000"), "MESH_CLAIMS_TOO_MUCH");
    assert_eq!(with("vertex 4", "vertex 5"), "MESH_DAMAGED");
    assert_eq!(with("4 0 1 2 3", "4 0 1 2 9"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("4 0 1 2 3", "4 0 1 2 -3"), "MESH_DAMAGED");
    assert_eq!(with("4 0 1 2 3", "4e9 0 1 2 3"), "MESH_DAMAGED");
    assert_eq!(with("1 1 0 9", "nan 1 0 9"), "MESH_NOT_FINITE");
    assert_eq!(with("end_header", "end_heade"), "MESH_DAMAGED");
    assert_eq!(with("float z", "quaternion z"), "MESH_DAMAGED");
    assert_eq!(with("property float z\n", ""), "MESH_DAMAGED");
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        element nothing 99999999999999\nend_header\n0 0 0\n";
    assert_eq!(reason("a.ply", points.as_bytes()), "MESH_DAMAGED");
    assert_eq!(
        reason("a.ply", points.replace("element nothing 99999999999999\n", "").as_bytes()),
        "MESH_EMPTY"
    );
    assert_eq!(reason("a.ply", &[b'x'; 1 << 20]), "MESH_DAMAGED");
}

#[test]
fn obj_faces_of_all_spellings() {
    let text = "# comment\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 \\\n0\nvn 0 0 1\nv 0 1 0\nf 1/1 2/2/1 3//1 4\nf -4 -3 -2\r\nl 1 2\n";
    let mesh = parse("a.obj", text.as_bytes(), &limits()).unwrap();
    assert_eq!(mesh.vertices.len(), 4);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
}

#[test]
fn broken_obj_is_refused() {
    let with =
        |face: &str| reason("a.obj", format!("v 0 0 0\nv 1 0 0\nv 1 1 0\n{face}\n").as_bytes());
    assert_eq!(with("f 1 2 3"), "no error");
    assert_eq!(with("f 1 2 4"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("f 0 1 2"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("f 1 2 -4"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("f 1 2 99999999999"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("f 1 2 -9223372036854775808"), "MESH_INDEX_OUT_OF_RANGE");
    assert_eq!(with("f a b c"), "MESH_DAMAGED");
    assert_eq!(with("v 1 2"), "MESH_DAMAGED");
    assert_eq!(with("v inf 1 2\nf 1 2 3"), "MESH_NOT_FINITE");
    assert_eq!(with("f 1 1 2"), "MESH_EMPTY");
    assert_eq!(with("f"), "MESH_EMPTY");
}

#[test]
fn limits_and_formats() {
    use bendtwin_core::Problem;
    let glb = write_glb(&creature());
    let tight = |limits: Limits| parse("a.glb", &glb, &limits).unwrap_err().reason();
    assert_eq!(tight(Limits { vertices: 10, ..limits() }), "MESH_TOO_MANY");
    assert_eq!(tight(Limits { triangles: 10, ..limits() }), "MESH_TOO_MANY");
    assert_eq!(tight(Limits { file_bytes: 10, ..limits() }), "MESH_TOO_LARGE");
    assert_eq!(reason("a.stl", b"solid"), "UNKNOWN_MESH_FORMAT");
    assert_eq!(reason("glb", b"solid"), "UNKNOWN_MESH_FORMAT");
    assert_eq!(reason("a.gltf", b"{}"), "MESH_EXTERNAL_DATA");
}

proptest! {
    #[test]
    fn noise_is_refused_and_nothing_panics(
        kind in prop::sample::select(vec!["a.glb", "a.obj", "a.ply"]),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
        shall_cut in any::<bool>(),
    ) {
        let mut bytes = match kind {
            "a.glb" => write_glb(&creature()),
            "a.ply" => binary_ply(false),
            _ => b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf -1 -2 -3\n".to_vec(),
        };
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if shall_cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(mesh) = parse(kind, &bytes, &limits()) {
            prop_assert!(mesh.vertices.iter().flatten().all(|x| x.is_finite()));
            prop_assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < mesh.vertices.len()));
        }
    }
}
