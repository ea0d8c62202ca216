//! Archives of torch with a fit by PhysTwin: a pickle of tensors, and their storages beside it.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, pickles, samples::FileMap};

/// Faults of such archives.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a training with damage", make: |rng| damage::any(rng, &valid()) },
    Fault { what: "a training whose pickle is damaged", make: damaged },
    Fault { what: "a training whose pickle is another", make: foreign },
    Fault { what: "a tensor that reaches beyond its storage", make: beyond },
    Fault { what: "a tensor of a huge size", make: huge },
    Fault { what: "a tensor whose elements overlap", make: overlapping },
    Fault { what: "a storage that is not there or elsewhere", make: elsewhere },
    Fault { what: "a storage of no kind", make: kind },
    Fault { what: "stiffnesses that are none", make: not_finite },
    Fault { what: "tensors by chance", make: program },
];

/// Springs of the valid training.
const SPRINGS: usize = 4;

/// A valid training.
pub fn valid() -> Vec<u8> {
    with(&valid_program())
}

/// The archive with this pickle.
pub fn with(program: &[u8]) -> Vec<u8> {
    archive(program, &[1000.0, 2000.0, 3000.0, 4000.0])
}

/// The pickle of the valid training.
pub fn valid_program() -> Vec<u8> {
    program_of(&springs("0", 0, &[SPRINGS as u64], &[1]))
}

fn archive(program: &[u8], stiffness: &[f32; SPRINGS]) -> Vec<u8> {
    let bytes = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let files: FileMap = [
        ("best/data.pkl", program.to_vec()),
        ("best/byteorder", b"little".to_vec()),
        ("best/data/0", bytes(stiffness)),
        ("best/data/1", bytes(&[0.5])),
        ("best/version", b"3\n".to_vec()),
    ]
    .map(|(name, content)| (name.to_owned(), content))
    .into();
    archives::pack(&files)
}

/// The pickle of a training with these opcodes of its springs.
fn program_of(springs: &[u8]) -> Vec<u8> {
    let one = tensor("FloatStorage", "1", 0, &[1], &[1]);
    let keys = ["collide_elas", "collide_fric", "collide_object_elas", "collide_object_fric"];
    let mut entries =
        vec![("spring_Y", springs.to_vec()), ("num_object_springs", b"K\x03".to_vec())];
    entries.extend(keys.map(|key| (key, one.clone())));
    pickles::dictionary(&entries)
}

fn springs(key: &str, offset: u64, size: &[u64], stride: &[u64]) -> Vec<u8> {
    tensor("FloatStorage", key, offset, size, stride)
}

/// Opcodes of a tensor.
fn tensor(kind: &str, key: &str, offset: u64, size: &[u64], stride: &[u64]) -> Vec<u8> {
    let mut out = b"ctorch._utils\n_rebuild_tensor_v2\n((".to_vec();
    out.extend(pickles::text("storage"));
    out.extend(format!("ctorch\n{kind}\n").bytes());
    for word in [key, "cuda:0"] {
        out.extend(pickles::text(word));
    }
    out.extend(b"K\x04tQ");
    out.extend(number(offset));
    for extents in [size, stride] {
        out.push(b'(');
        out.extend(extents.iter().flat_map(|n| number(*n)));
        out.push(b't');
    }
    out.extend(b"\x89ccollections\nOrderedDict\n)RtR");
    out
}

fn number(n: u64) -> Vec<u8> {
    [b"\x8a\x08".as_slice(), &n.to_le_bytes()].concat()
}

fn damaged(rng: &mut Rng) -> Vec<u8> {
    with(&damage::any(rng, &valid_program()))
}

fn foreign(rng: &mut Rng) -> Vec<u8> {
    with(&(pickles::FAULTS[rng.random_range(0..pickles::FAULTS.len())].make)(rng))
}

fn extreme(rng: &mut Rng) -> u64 {
    [3, 1 << 20, 1 << 31, 1 << 62, i64::MAX as u64, u64::MAX][rng.random_range(0..6)]
}

fn beyond(rng: &mut Rng) -> Vec<u8> {
    let (offset, size) = (extreme(rng), rng.random_range(2..6));
    with(&program_of(&springs("0", offset, &[size], &[1])))
}

fn huge(rng: &mut Rng) -> Vec<u8> {
    let size: Vec<u64> = (0..rng.random_range(1..40)).map(|_| extreme(rng)).collect();
    let stride = vec![1; size.len()];
    with(&program_of(&springs("0", 0, &size, &stride)))
}

fn overlapping(rng: &mut Rng) -> Vec<u8> {
    let size = [4, 1 << 31, 1 << 62][rng.random_range(0..3)];
    let stride = [0, 2, u64::MAX][rng.random_range(0..3)];
    with(&program_of(&springs("0", 0, &[size], &[stride])))
}

fn elsewhere(rng: &mut Rng) -> Vec<u8> {
    let long = "9".repeat(10_000);
    let keys = ["7", "", "../data.pkl", "/etc/passwd", "0/", "..\\0", &long];
    with(&program_of(&springs(keys[rng.random_range(0..keys.len())], 0, &[4], &[1])))
}

fn kind(rng: &mut Rng) -> Vec<u8> {
    let kinds = ["LongStorage", "BoolStorage", "HalfStorage", "storage", "load", "Tensor"];
    let kind = kinds[rng.random_range(0..kinds.len())];
    with(&program_of(&tensor(kind, "0", 0, &[4], &[1])))
}

fn not_finite(rng: &mut Rng) -> Vec<u8> {
    let mut stiffness = [1000.0; SPRINGS];
    stiffness[rng.random_range(0..SPRINGS)] =
        [f32::NAN, f32::INFINITY, -1.0, f32::MAX][rng.random_range(0..4)];
    archive(&valid_program(), &stiffness)
}

/// Parts of tensors in any order.
fn program(rng: &mut Rng) -> Vec<u8> {
    let storage = [b"ctorch\nFloatStorage\n".to_vec(), pickles::text("storage")].concat();
    let parts: [&[u8]; 14] = [
        b"ctorch._utils\n_rebuild_tensor_v2\n",
        b"ctorch._utils\n_rebuild_parameter\n",
        b"ccollections\nOrderedDict\n",
        &storage,
        b"Q",
        b"R",
        b"(",
        b"t",
        b")",
        b"}",
        b"s",
        b"u",
        b"K\x01",
        b"b",
    ];
    let mut out = b"\x80\x02".to_vec();
    for _ in 0..rng.random_range(1..60) {
        out.extend(parts[rng.random_range(0..parts.len())]);
    }
    out.push(b'.');
    with(&out)
}
