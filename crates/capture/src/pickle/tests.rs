//! The golden pickles under `testdata` were written by Python's pickle and numpy.

use proptest::prelude::*;

use super::*;

const PROTOCOLS: [&[u8]; 7] = [
    include_bytes!("../../testdata/arrays-p0.pkl"),
    include_bytes!("../../testdata/arrays-p1.pkl"),
    include_bytes!("../../testdata/arrays-p2.pkl"),
    include_bytes!("../../testdata/arrays-p3.pkl"),
    include_bytes!("../../testdata/arrays-p4.pkl"),
    include_bytes!("../../testdata/arrays-p5.pkl"),
    include_bytes!("../../testdata/arrays-numpy1.pkl"),
];

fn load(bytes: &[u8]) -> Result<Pickle<'_>, Error> {
    let limits = Limits { total_bytes: 1 << 20, ..Limits::default() };
    read("a.pkl", bytes, &limits, &mut Budget::new(&limits))
}

fn refused(bytes: &[u8]) -> Error {
    load(bytes).map(|_| ()).unwrap_err()
}

fn budget() -> Budget {
    Budget::new(&Limits::default())
}

#[test]
fn arrays_of_every_protocol_are_read() {
    for bytes in PROTOCOLS {
        let pickle = load(bytes).unwrap();
        let array = |key| pickle.entry(key).unwrap().unwrap();
        let numbers = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(array("c").shape, [2, 3]);
        assert_eq!(array("c").floats(&mut budget()).unwrap(), numbers);
        // Fortran order comes out row-major.
        assert_eq!(array("f").shape, [2, 3]);
        assert_eq!(array("f").floats(&mut budget()).unwrap(), numbers);
        assert_eq!(array("b").bools(&mut budget()).unwrap(), [true, false, true]);
        assert_eq!(array("i").integers(&mut budget()).unwrap(), [1, -2, 300, 4]);
        assert_eq!(array("e").points(&mut budget()).unwrap(), [[0.0; 3]; 0]);
        assert!(pickle.entry("missing").unwrap().is_none());
        assert!(pickle.entry("t").unwrap_err().to_string().contains("a tuple"));
        assert!(pickle.entry("s").unwrap_err().to_string().contains("a float"));
        assert!(pickle.array().unwrap_err().to_string().contains("a dict"));
    }
}

/// Protocol 0 of Python 2 has its arrays as literals.
#[test]
fn lines_of_text_are_values() {
    let array = b"cnumpy.core.multiarray\n_reconstruct\np1\n(cnumpy\nndarray\np2\n(I0\ntp3\nS'b'\np4\ntp5\nRp6\n\
        (I1\n(I2\ntp7\ncnumpy\ndtype\np8\n(S'u1'\np9\nI0\nI1\ntp10\nRp11\n\
        (I3\nS'|'\np12\nNNNI-1\nI-1\nI0\ntp13\nbI00\nS'\\xff\\n'\np14\ntp15\nb.";
    let array = load(array).unwrap().array().unwrap();
    assert_eq!(array.bytes(&mut budget()).unwrap(), [255, 10]);
    let numbers = b"(dp0\nVa\\u00e4\np1\nF2.5\nsVb\np2\nL7L\nsS\"it's\"\np3\nI-3\ns.";
    let pickle = load(numbers).unwrap();
    let found = ["a\u{e4}", "b", "it's"].map(|key| pickle.number(key).unwrap());
    assert_eq!(found, [Some(2.5), Some(7.0), Some(-3.0)]);
    for damaged in [
        &b"I1x\n."[..],
        b"F\n.",
        b"S'a\n.",
        b"S'\\x0'\n.",
        b"V\\u12\n.",
        b"V\\ud800\n.",
        b"g1\n.",
        b"I1\np-1\n.",
        b"I99999999999999999999\n.",
        b"I1",
    ] {
        assert!(matches!(refused(damaged), Error::Damaged { .. }), "{damaged:?}");
    }
    assert!(matches!(refused(b"I1\np99999999\n."), Error::Pickle { .. }));
}

#[test]
fn anything_outside_the_allow_list_is_refused_by_name() {
    for (bytes, name) in [
        (&b"\x80\x02cos\nsystem\nX\x02\x00\x00\x00ls\x85R."[..], "os.system"),
        (b"\x80\x04\x8c\x08builtins\x8c\x04eval\x93\x8c\x011\x85R.", "builtins.eval"),
        (b"\x80\x02cnumpy.core.multiarray\nfromfile\n.", "numpy.core.multiarray.fromfile"),
        (b"\x80\x02cnumpy._core._evil\n_reconstruct\n.", "numpy._core._evil._reconstruct"),
        (b"\x80\x02cnumpy.coremultiarray\n_reconstruct\n.", "numpy.coremultiarray._reconstruct"),
    ] {
        match refused(bytes) {
            Error::PickleGlobal { global, .. } => assert_eq!(global, name),
            other => panic!("{name}: {other}"),
        }
    }
    // NEWOBJ, PERSID, EXT1, INST: no plain array needs them.
    for opcode in [
        b"\x80\x02)\x81.",
        &b"\x80\x02Pid\n."[..],
        b"\x80\x02\x82\x01.",
        b"\x80\x02(ios\nsystem\n.",
    ] {
        assert!(matches!(refused(opcode), Error::Pickle { .. }));
    }
}

#[test]
fn nesting_costs_a_message_and_no_stack() {
    let mut lists = b"\x80\x02".to_vec();
    lists.extend(std::iter::repeat_n(b']', 5000));
    lists.extend(std::iter::repeat_n(b'a', 4999));
    lists.push(b'.');
    assert!(refused(&lists).to_string().contains("nests deeper"));
    let mut tuples = b"\x80\x02)".to_vec();
    tuples.extend(std::iter::repeat_n(0x85, 100_000));
    assert!(refused(&tuples).to_string().contains("nests deeper"));
    let marks = vec![b'('; 100_000];
    assert!(refused(&marks).to_string().contains("nests deeper"));
}

#[test]
fn a_list_may_contain_itself() {
    assert!(load(b"\x80\x02]q\x00h\x00a.").is_ok());
}

#[test]
fn lengths_and_memo_jumps_allocate_nothing() {
    let claims_2_gib = b"\x80\x04B\xff\xff\xff\x7fabc.";
    assert!(matches!(refused(claims_2_gib), Error::Damaged { .. }));
    let claims_2_to_62 = b"\x80\x04\x8e\xff\xff\xff\xff\xff\xff\xff\x3fabc.";
    assert!(matches!(refused(claims_2_to_62), Error::Damaged { .. }));
    assert!(refused(b"\x80\x02Nr\xff\xff\xff\xff.").to_string().contains("memo entry"));
}

#[test]
fn opcodes_are_counted() {
    let mut bytes = b"\x80\x02".to_vec();
    bytes.extend(b"N0".repeat(1000));
    bytes.push(b'.');
    let limits = Limits { pickle_opcodes: 100, ..Limits::default() };
    let error = read("a.pkl", &bytes, &limits, &mut Budget::new(&limits)).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("more than 100 opcodes"));
}

#[test]
fn big_endian_and_object_arrays_are_refused() {
    let big = refused(include_bytes!("../../testdata/big-endian.pkl"));
    assert!(big.to_string().contains("big-endian"), "{big}");
    let objects = refused(include_bytes!("../../testdata/objects.pkl"));
    assert!(
        objects.to_string().contains("Python objects")
            || objects.to_string().contains("without bytes")
    );
}

#[test]
fn every_truncation_is_an_error() {
    for bytes in PROTOCOLS {
        for len in 0..bytes.len() - 1 {
            assert!(load(&bytes[..len]).is_err());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn mutated_pickles_never_panic(
        which in 0..PROTOCOLS.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut bytes = PROTOCOLS[which].to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(pickle) = load(&bytes) {
            for key in ["c", "f", "b", "i", "e"] {
                if let Ok(Some(array)) = pickle.entry(key) {
                    let _ = array.floats(&mut budget());
                    let _ = array.points(&mut budget());
                    let _ = array.bools(&mut budget());
                    let _ = array.integers(&mut budget());
                }
            }
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = load(&bytes);
        let mut framed = b"\x80\x04".to_vec();
        framed.extend(bytes);
        let _ = load(&framed);
    }
}
