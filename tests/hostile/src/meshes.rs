//! Meshes: GLB, OBJ and PLY with wrong lengths, indices and counts.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, samples};

/// Faults of GLB files.
pub const GLB: &[Fault] = &[
    Fault { what: "a GLB with damage", make: |rng| damage::any(rng, &glb()) },
    Fault { what: "a GLB of a wrong length", make: wrong_length },
    Fault { what: "a GLB with another number in its document", make: number },
    Fault { what: "a GLB that shows its mesh without end", make: instances },
    Fault { what: "a GLB of nodes in circles", make: circle },
    Fault { what: "a GLB of nested brackets", make: brackets },
];

/// Faults of OBJ files.
pub const OBJ: &[Fault] = &[
    Fault { what: "an OBJ with damage", make: |rng| damage::any(rng, OBJ_TEXT) },
    Fault { what: "an OBJ with other numbers", make: |rng| reworded(rng, OBJ_TEXT) },
    Fault { what: "an OBJ with a face without end", make: long_face },
    Fault {
        what: "an OBJ that is one line",
        make: |rng| b"v ".repeat(rng.random_range(1..50_000)),
    },
];

/// Faults of PLY files.
pub const PLY: &[Fault] = &[
    Fault {
        what: "a PLY with damage",
        make: |rng| {
            let p = ply(rng);
            damage::any(rng, &p)
        },
    },
    Fault {
        what: "a PLY with other numbers",
        make: |rng| {
            let p = ply(rng);
            reworded(rng, &p)
        },
    },
    Fault { what: "a PLY that claims counts", make: claimed },
    Fault { what: "a PLY of lists without end", make: lists },
];

/// Captures with such meshes.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "a shape in a faulty GLB", make: |rng| put(rng, GLB, "glb") },
    Fault { what: "a shape in a faulty OBJ", make: |rng| put(rng, OBJ, "obj") },
    Fault { what: "a shape in a faulty PLY", make: |rng| put(rng, PLY, "ply") },
];

/// A tetrahedron as OBJ.
pub const OBJ_TEXT: &[u8] =
    b"# a tetrahedron\no toy\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0 1.0\nv 0 0 1e-1\n\
    vn 0 0 1\nf 1 3 2\nf 1//1 2//1 4//1\nf -3 -2 -1\nf 3/1/1 1/1/1 4/1/1\n";

/// A tetrahedron as PLY in text.
pub const PLY_TEXT: &[u8] = b"ply\nformat ascii 1.0\ncomment a tetrahedron\nelement vertex 4\n\
    property float x\nproperty float y\nproperty float z\nelement face 4\n\
    property list uchar int vertex_indices\nend_header\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n\
    3 1 2 3\n3 2 0 3\n";

/// A tetrahedron as GLB.
pub fn glb() -> Vec<u8> {
    bendtwin_mesh::write_glb(&samples::mesh())
}

/// A tetrahedron as PLY in numbers.
pub fn binary_ply() -> Vec<u8> {
    let mut out = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n\
        property float y\nproperty float z\nelement face 4\n\
        property list uchar int vertex_indices\nend_header\n"
        .to_vec();
    let mesh = samples::mesh();
    out.extend(mesh.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for triangle in &mesh.triangles {
        out.push(3);
        out.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
    }
    out
}

/// A GLB file of a document and data.
pub fn glb_of(document: &[u8], data: &[u8]) -> Vec<u8> {
    let mut json = document.to_vec();
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

/// The document and the data of the valid mesh.
fn parts() -> (Vec<u8>, Vec<u8>) {
    let bytes = glb();
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    (bytes[20..20 + length].to_vec(), bytes[28 + length..].to_vec())
}

fn ply(rng: &mut Rng) -> Vec<u8> {
    if rng.random() { PLY_TEXT.to_vec() } else { binary_ply() }
}

fn wrong_length(rng: &mut Rng) -> Vec<u8> {
    let mut bytes = glb();
    let (document, _) = parts();
    let at = [8, 12, 20 + document.len()][rng.random_range(0..3)];
    let length = [0, 1, 3, 1 << 20, u32::MAX - 3, u32::MAX][rng.random_range(0..6)];
    bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
    bytes
}

fn reworded(rng: &mut Rng, text: &[u8]) -> Vec<u8> {
    let from = ["0.1", " 0 ", "3 ", "4", "1", "-3", "float", "uchar", "int", "1e-1"];
    let to = [
        "nan",
        "inf",
        "-1e39",
        "1e999",
        "18446744073709551616",
        "-9223372036854775808",
        "4294967295",
        "",
        "double",
        "0x10",
        "1000000000",
    ];
    damage::reword(rng, text, &from, &to)
}

fn number(rng: &mut Rng) -> Vec<u8> {
    let (document, data) = parts();
    let from = [
        "\"count\":12",
        "\"count\":4",
        "5125",
        "5126",
        "\"mode\":4",
        "\"byteLength\":48",
        "\"byteOffset\":48",
        "\"buffer\":0",
        "\"bufferView\":1",
        "\"nodes\":[0]",
        "\"mesh\":0",
    ];
    let to = [
        "\"count\":4294967295",
        "\"count\":18446744073709551615",
        "5121",
        "5123",
        "\"mode\":5",
        "\"byteLength\":-1",
        "\"byteOffset\":18446744073709551615",
        "\"bufferView\":99",
        "\"count\":1e300",
        "\"byteStride\":4,\"byteOffset\":44",
        "\"nodes\":[0,0,0,7]",
        "\"mesh\":9",
    ];
    glb_of(&damage::reword(rng, &document, &from, &to), &data)
}

/// Each node shows the two after it.
fn instances(rng: &mut Rng) -> Vec<u8> {
    let (document, data) = parts();
    let depth = rng.random_range(10..200);
    let nodes: Vec<String> = (0..depth)
        .map(|i| {
            if i + 1 == depth {
                "{\"mesh\":0}".to_owned()
            } else {
                format!("{{\"children\":[{},{}]}}", i + 1, i + 1)
            }
        })
        .collect();
    glb_of(&with_nodes(&document, &nodes.join(",")), &data)
}

fn circle(rng: &mut Rng) -> Vec<u8> {
    let (document, data) = parts();
    let nodes = match rng.random_range(0..3) {
        0 => "{\"mesh\":0,\"children\":[0]}",
        1 => "{\"mesh\":0,\"children\":[1]},{\"children\":[0]}",
        _ => "{\"mesh\":0,\"scale\":[1e30,1e30,1e30],\"rotation\":[0,0,0,0],\"children\":[1,1]},{}",
    };
    glb_of(&with_nodes(&document, nodes), &data)
}

fn with_nodes(document: &[u8], nodes: &str) -> Vec<u8> {
    let text = String::from_utf8_lossy(document);
    text.replace("\"nodes\":[{\"mesh\":0}]", &format!("\"nodes\":[{nodes}]")).into_bytes()
}

fn brackets(rng: &mut Rng) -> Vec<u8> {
    let open = ["[", "{\"a\":"][rng.random_range(0..2)];
    glb_of(open.repeat(rng.random_range(100..50_000)).as_bytes(), &[0; 4])
}

fn long_face(rng: &mut Rng) -> Vec<u8> {
    [OBJ_TEXT, b"f", &b" 1 2 3".repeat(rng.random_range(100..20_000)), b"\n"].concat()
}

fn claimed(rng: &mut Rng) -> Vec<u8> {
    let text = ply(rng);
    let counts =
        ["element vertex 4294967295", "element vertex 18446744073709551615", "element face 0"];
    damage::reword(rng, &text, &["element vertex 4"], &counts)
}

fn lists(rng: &mut Rng) -> Vec<u8> {
    let count = rng.random_range(1..200_u32);
    let mut out = b"ply\nformat binary_big_endian 1.0\nelement face 4000000\n".to_vec();
    for _ in 0..count {
        out.extend(b"property list uchar uchar a\n");
    }
    out.extend(b"end_header\n");
    out.extend(vec![0; rng.random_range(0..10_000)]);
    out
}

fn put(rng: &mut Rng, faults: &[Fault], extension: &str) -> Vec<u8> {
    let mesh = (faults[rng.random_range(0..faults.len())].make)(rng);
    let mut files = samples::raw_bundle();
    files.remove("mesh.glb");
    if let Some(manifest) = files.get_mut("capture.json") {
        let text = String::from_utf8_lossy(manifest);
        *manifest = text.replace("mesh.glb", &format!("mesh.{extension}")).into_bytes();
    }
    archives::with(files, &format!("mesh.{extension}"), mesh)
}
