use proptest::prelude::*;

use super::*;
use crate::{Limits, limits::Budget};

fn file(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn what_is_written_is_read() {
    for shape in [&[][..], &[1], &[2, 0], &[1, 2, 3]] {
        let count: usize = shape.iter().product();
        let numbers: Vec<f32> = (0..count).map(|i| i as f32).collect();
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let written = write("<f4", shape, &bytes);
        assert_eq!((written.len() - bytes.len()) % ALIGN, 0);
        let array = read("a.npy", &written).unwrap();
        assert_eq!(array.shape, shape);
        let floats = array.floats(&mut Budget::new(&Limits::default())).unwrap();
        assert_eq!(floats, numbers);
    }
}

#[test]
fn numpys_own_header_is_read() {
    // As numpy.save writes numpy.arange(6, dtype="<i2").reshape(2, 3, order="F").
    let header = "{'descr': '<i2', 'fortran_order': True, 'shape': (2, 3), }    \n";
    let data: Vec<u8> = [0_i16, 3, 1, 4, 2, 5].iter().flat_map(|x| x.to_le_bytes()).collect();
    let bytes = file(header, &data);
    let array = read("a.npy", &bytes).unwrap();
    let numbers = array.integers(&mut Budget::new(&Limits::default())).unwrap();
    assert_eq!(numbers, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn headers_are_not_believed() {
    let header = |descr: &str, shape: &str| {
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n")
    };
    let reason = |bytes: &[u8]| bendtwin_core::Problem::reason(&read("a.npy", bytes).unwrap_err());
    assert_eq!(reason(&file(&header("<f8", "(1000000000000,)"), &[])), "HEADER_CLAIMS_TOO_MUCH");
    let overflow = header("<f8", "(4294967296, 4294967296, 3)");
    assert_eq!(reason(&file(&overflow, &[])), "HEADER_CLAIMS_TOO_MUCH");
    assert_eq!(reason(&file(&header(">f8", "(1,)"), &[0; 8])), "WRONG_DTYPE");
    assert_eq!(reason(&file(&header("|O", "(1,)"), &[0; 8])), "WRONG_DTYPE");
    assert_eq!(reason(&file(&header("<f4", "(-1,)"), &[])), "FILE_DAMAGED");
    assert_eq!(reason(&file(&"[".repeat(9000), &[])), "FILE_DAMAGED");
    let structured = "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1,), }";
    assert_eq!(reason(&file(structured, &[0; 4])), "FILE_DAMAGED");
    let many = format!("({})", "1,".repeat(100));
    assert_eq!(reason(&file(&header("<f4", &many), &[0; 4])), "FILE_DAMAGED");
    let mut long = MAGIC.to_vec();
    long.extend([2, 0, 0xff, 0xff, 0xff, 0xff]);
    assert_eq!(reason(&long), "FILE_DAMAGED");
}

proptest! {
    #[test]
    fn mutated_files_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        len in any::<prop::sample::Index>(),
    ) {
        let mut bytes = write("<f4", &[2, 3], &[0; 24]);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(len.index(bytes.len() + 1));
        if let Ok(array) = read("a.npy", &bytes) {
            let _ = array.points(&mut Budget::new(&Limits::default()));
            let _ = array.integers(&mut Budget::new(&Limits::default()));
        }
    }
}
