//! Pickles: of arrays as numpy writes them, and programs that no array needs.

use rand::RngExt as _;

use crate::{Fault, Rng, archives, damage, samples};

/// Faults of pickles.
pub const FAULTS: &[Fault] = &[
    Fault { what: "a pickle with damage", make: |rng| damage::any(rng, &valid()) },
    Fault { what: "a pickle that calls a function", make: call },
    Fault { what: "a pickle that contains itself", make: recursion },
    Fault { what: "a pickle that doubles its memo", make: doubling },
    Fault { what: "a pickle that jumps in its memo", make: jump },
    Fault { what: "a pickle that nests", make: nesting },
    Fault { what: "a pickle that only marks", make: |rng| repeated(rng, b"(") },
    Fault { what: "a pickle that only copies", make: |rng| repeated(rng, b"]2") },
    Fault { what: "a pickle of text without end", make: long_text },
    Fault { what: "a pickle of an array of a huge shape", make: huge },
    Fault { what: "a pickle of arrays that share bytes", make: shared },
    Fault { what: "a pickle of instructions by chance", make: program },
];

/// Captures with such pickles.
pub const IN_CAPTURES: &[Fault] = &[
    Fault { what: "points in a faulty pickle", make: |rng| put(rng, "final_data.pkl", true) },
    Fault { what: "tracks in a faulty pickle", make: |rng| put(rng, "gt_track_3d.pkl", true) },
    Fault {
        what: "a calibration in a faulty pickle",
        make: |rng| put(rng, "calibrate.pkl", false),
    },
];

/// The data of a valid case.
pub fn valid() -> Vec<u8> {
    samples::case().remove("final_data.pkl").expect("the case has it")
}

/// A dictionary of values, each as opcodes that leave it on the stack.
pub fn dictionary(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut out = b"\x80\x03}(".to_vec();
    for (key, value) in entries {
        out.extend(text(key));
        out.extend(value);
    }
    out.extend(b"u.");
    out
}

/// Opcodes of an array of 64-bit floats.
pub fn floats(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    array("f8", shape, &bytes)
}

/// Opcodes of an array of any type.
pub fn array(dtype: &str, shape: &[usize], bytes: &[u8]) -> Vec<u8> {
    let mut out = shaped(dtype, shape);
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(bytes);
    out.extend(b"tb");
    out
}

/// The opcodes up to the length of the bytes.
fn shaped(dtype: &str, shape: &[usize]) -> Vec<u8> {
    let mut out =
        b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01("
            .to_vec();
    for side in shape {
        out.extend(b"\x8a\x08");
        out.extend((*side as u64).to_le_bytes());
    }
    out.extend(b"tcnumpy\ndtype\n");
    out.extend(text(dtype));
    out.extend(b"K\x00K\x01\x87R(K\x03X\x01\x00\x00\x00<NNN");
    out.extend(b"J\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B");
    out
}

/// Opcodes of a word.
pub fn text(text: &str) -> Vec<u8> {
    [b"X", (text.len() as u32).to_le_bytes().as_slice(), text.as_bytes()].concat()
}

fn call(rng: &mut Rng) -> Vec<u8> {
    let call: &[u8] = match rng.random_range(0..6) {
        0 => b"\x80\x03cos\nsystem\nX\x04\x00\x00\x00true\x85R.",
        1 => b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93\x8c\x011\x85R.",
        2 => b"cposix\nsystem\n(S'true'\ntR.",
        3 => b"\x80\x02cnumpy.core.multiarray\nfromfile\n(X\x0b\x00\x00\x00/etc/passwdtR.",
        4 => b"\x80\x03ccopyreg\n_reconstructor\n(c__main__\nA\nc__builtin__\nobject\nNtR.",
        _ => b"\x80\x03(cos\nsystem\nX\x04\x00\x00\x00trueo.",
    };
    call.to_vec()
}

fn recursion(rng: &mut Rng) -> Vec<u8> {
    let own: &[u8] = match rng.random_range(0..4) {
        0 => b"\x80\x03]q\x00h\x00a.",
        1 => b"\x80\x03}q\x00X\x0d\x00\x00\x00object_pointsh\x00s.",
        2 => b"\x80\x03]q\x00]q\x01h\x00ah\x01ah\x00h\x01a.",
        _ => b"\x80\x03]q\x00(h\x00h\x00h\x00tq\x01ah\x01.",
    };
    own.to_vec()
}

/// Each list holds the one before twice.
fn doubling(rng: &mut Rng) -> Vec<u8> {
    let mut out = b"\x80\x03]q\x00".to_vec();
    for i in 1..rng.random_range(10..250_u8) {
        out.extend([b'(', b'h', i - 1, b'h', i - 1, b'l', b'q', i]);
    }
    out.push(b'.');
    out
}

fn jump(rng: &mut Rng) -> Vec<u8> {
    let to = [1024_u32, 1 << 20, 0x7FFF_FFFF, u32::MAX][rng.random_range(0..4)];
    [b"\x80\x03Nr".as_slice(), &to.to_le_bytes(), b"j", &to.to_le_bytes(), b"."].concat()
}

fn nesting(rng: &mut Rng) -> Vec<u8> {
    let depth = rng.random_range(10..50_000);
    match rng.random_range(0..3) {
        0 => [vec![b']'; depth + 1], vec![b'a'; depth], vec![b'.']].concat(),
        1 => [vec![b'N'], vec![0x85; depth], vec![b'.']].concat(),
        _ => [vec![b'('; depth], vec![b't'; depth], vec![b'.']].concat(),
    }
}

fn repeated(rng: &mut Rng, opcodes: &[u8]) -> Vec<u8> {
    let times = rng.random_range(1..200_000 / opcodes.len());
    [b"\x80\x03".to_vec(), opcodes.repeat(times), b".".to_vec()].concat()
}

fn long_text(rng: &mut Rng) -> Vec<u8> {
    let length = [u32::MAX, 1 << 31, 5][rng.random_range(0..3)];
    let letter = [b'X', b'B', b'T'][rng.random_range(0..3)];
    [&[0x80, 3, letter], length.to_le_bytes().as_slice(), b"text."].concat()
}

fn huge(rng: &mut Rng) -> Vec<u8> {
    let side = [1_usize << 20, 1 << 32, 1 << 62, usize::MAX][rng.random_range(0..4)];
    let value = array("f8", &[side, 6, 3], &[0; 96]);
    let key = ["object_points", "controller_points", "x"][rng.random_range(0..3)];
    dictionary(&[(key, value)])
}

/// An array under many keys.
fn shared(rng: &mut Rng) -> Vec<u8> {
    let mut out = b"\x80\x03}(".to_vec();
    out.extend(text("object_points"));
    out.extend(array("f8", &[1000, 10, 3], &vec![0; 240_000]));
    out.extend(b"q\x00");
    for key in ["object_visibilities", "object_motions_valid", "controller_points"] {
        out.extend(text(key));
        out.extend(b"h\x00");
    }
    for i in 0..rng.random_range(0..1000) {
        out.extend(text(&i.to_string()));
        out.extend(b"h\x00");
    }
    out.extend(b"u.");
    out
}

fn program(rng: &mut Rng) -> Vec<u8> {
    const OPCODES: &[u8] = b"(.01}])ltdueasbR2NqhrjKJMXCB\x88\x89\x85\x86\x87\x93\x94\x95\x8a\x8c";
    let mut out = b"\x80\x04".to_vec();
    for _ in 0..rng.random_range(1..400) {
        out.push(OPCODES[rng.random_range(0..OPCODES.len())]);
        if rng.random_range(0..3) == 0 {
            out.push(rng.random_range(0..8));
        }
    }
    out.push(b'.');
    out
}

fn put(rng: &mut Rng, name: &str, tracked: bool) -> Vec<u8> {
    let bytes = (FAULTS[rng.random_range(0..FAULTS.len())].make)(rng);
    archives::with(if tracked { samples::case() } else { samples::raw_case() }, name, bytes)
}
