//! The golden files under `testdata/phystwin` were written by `torch.save` (torch 2.15) with the
//! entries of PhysTwin's trainer, an Adam state among them, and by Python's pickle with those of its
//! search, which are numpy's numbers.

use std::io::{Cursor, Write as _};

use zip::{ZipWriter, write::SimpleFileOptions};

use super::*;

const PARAMS: &[u8] = include_bytes!("../../../testdata/phystwin/optimal_params.pkl");
const BEST: &[u8] = include_bytes!("../../../testdata/phystwin/best_12.pth");

fn train(bytes: &[u8]) -> Result<TrainResult, Error> {
    TrainResult::decode("best.pth", bytes, &Limits::default())
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6 * b.abs().max(1.0)
}

#[test]
fn the_search_result_has_its_twelve_numbers() {
    let result = SearchResult::decode("a.pkl", PARAMS, &Limits::default()).unwrap();
    assert!(near(result.stiffness, 1e4) && near(result.object_radius_m, 0.016_909_09));
    assert_eq!((result.object_max_neighbours, result.control_max_neighbours), (19, 37));
    assert!(near(result.control_radius_m, 0.032_272_726));
    let ContactResult { ground, object } = result.contact;
    let found = [ground[0], ground[1], object[0], object[1], result.collision_distance_m];
    let expected = [0.463_636_37, 1.072_727_3, 0.609_090_9, 1.363_636_4, 0.040_181_816];
    assert!(found.into_iter().zip(expected).all(|(a, b)| near(a, b)), "{found:?}");
    assert!(near(result.drag, 16.545_454) && near(result.dashpot, 180.0));
}

#[test]
fn torch_s_own_archive_is_read_past_the_optimizer() {
    let result = train(BEST).unwrap();
    assert_eq!(result.object_spring_count, Some(5));
    let expected = (0..7).map(|i| 1000.0 + 1000.0 / 6.0 * f64::from(i));
    assert_eq!(result.stiffness.len(), 7);
    assert!(result.stiffness.iter().zip(expected).all(|(k, e)| (f64::from(*k) - e).abs() < 1e-3));
    assert_eq!(result.contact, ContactResult { ground: [1.25, 0.25], object: [-0.5, 0.75] });
}

fn text(text: &str) -> Vec<u8> {
    [b"X", (text.len() as u32).to_le_bytes().as_slice(), text.as_bytes()].concat()
}

/// A tensor of floats in a storage, with the given offset, size and stride.
fn tensor(key: &str, offset: u8, size: u8, stride: u8) -> Vec<u8> {
    let id = [b"(".to_vec(), text("storage"), b"ctorch\nFloatStorage\n".to_vec(), text(key)];
    let id = [id.concat(), text("cpu"), b"K\x00tQ".to_vec()].concat();
    let view = [b'K', offset, b'K', size, 0x85, b'K', stride, 0x85, 0x89];
    let call = b"ccollections\nOrderedDict\n)RtR".to_vec();
    [b"ctorch._utils\n_rebuild_tensor_v2\n(".to_vec(), id, view.to_vec(), call].concat()
}

/// The entries of a result, with the given springs.
fn entries(springs: Vec<u8>) -> Vec<(&'static str, Vec<u8>)> {
    let one = || tensor("1", 0, 1, 1);
    vec![
        ("spring_Y", springs),
        ("collide_elas", one()),
        ("collide_fric", one()),
        ("collide_object_elas", one()),
        ("collide_object_fric", one()),
    ]
}

fn program(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let each = entries.iter().flat_map(|(key, value)| [text(key), value.clone()]);
    [b"\x80\x02}(".to_vec(), each.collect::<Vec<_>>().concat(), b"u.".to_vec()].concat()
}

/// An archive with storage 0 of `springs` and storage 1 of one float.
fn archive(program: &[u8], springs: &[f32]) -> Vec<u8> {
    let bytes: Vec<u8> = springs.iter().flat_map(|x| x.to_le_bytes()).collect();
    let half = 0.5_f32.to_le_bytes();
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in [
        ("a/data.pkl", program),
        ("a/byteorder", b"little"),
        ("a/data/0", &bytes),
        ("a/data/1", &half),
    ] {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn of_tensor(springs: Vec<u8>) -> Result<TrainResult, Error> {
    train(&archive(&program(&entries(springs)), &[10.0, 20.0, 30.0]))
}

#[test]
fn a_tensor_is_a_view_of_its_storage() {
    assert_eq!(of_tensor(tensor("0", 1, 2, 1)).unwrap().stiffness, [20.0, 30.0]);
    assert!(of_tensor(tensor("0", 0, 0, 1)).unwrap().stiffness.is_empty());
    let beyond = of_tensor(tensor("0", 2, 2, 1)).unwrap_err();
    assert!(matches!(beyond, Error::Absurd { .. }), "{beyond}");
    assert!(of_tensor(tensor("0", 0, 2, 2)).unwrap_err().to_string().contains("contiguous"));
    let missing = of_tensor(tensor("7", 0, 2, 1)).unwrap_err();
    assert!(matches!(missing, Error::MissingFile(_)), "{missing}");
    let outside = of_tensor(tensor("../data.pkl", 0, 2, 1)).unwrap_err();
    assert!(matches!(outside, Error::MissingFile(_)), "{outside}");
}

#[test]
fn nothing_but_tensors_is_built() {
    for (calls, name) in [
        (&b"cos\nsystem\nX\x02\x00\x00\x00ls\x85R"[..], "os.system"),
        (b"cbuiltins\neval\nX\x01\x00\x00\x001\x85R", "builtins.eval"),
        (b"ctorch.storage\n_load_from_bytes\nC\x01a\x85R", "torch.storage._load_from_bytes"),
    ] {
        let error = of_tensor(calls.to_vec()).unwrap_err();
        assert!(
            matches!(error, Error::Pickle { .. }) && error.to_string().contains(name),
            "{error}"
        );
    }
    for odd in [
        &b"ctorch\nFloatStorage\n)R"[..],
        b"ccollections\nOrderedDict\n]\x85R",
        b"ctorch._utils\n_rebuild_tensor_v2\n(K\x00K\x00)))tR",
        b"K\x01Q",
        b"X\x01\x00\x00\x00a)\x86Q",
        b"N",
        b"K\x05",
    ] {
        assert!(of_tensor(odd.to_vec()).is_err(), "{odd:?}");
    }
    // A capture's pickle has no business with torch.
    let pickle = program(&entries(tensor("0", 0, 3, 1)));
    let budget = &mut Budget::new(&Limits::default());
    let refused =
        pickle::read("a.pkl", &pickle, &Limits::default(), budget).map(|_| ()).unwrap_err();
    assert!(matches!(refused, Error::PickleGlobal { .. }), "{refused}");
}

#[test]
fn damaged_and_impossible_results_are_refused() {
    let good = program(&entries(tensor("0", 0, 3, 1)));
    assert!(train(&archive(&good, &[1.0, 2.0, 3.0])).is_ok());
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let error = train(&archive(&good, &[1.0, bad, 3.0])).unwrap_err();
        assert!(matches!(error, Error::Document { .. }), "{error}");
    }
    let several = [entries(tensor("0", 0, 3, 1)), vec![("collide_elas", tensor("0", 0, 2, 1))]];
    let error = train(&archive(&program(&several.concat()), &[1.0; 3])).unwrap_err();
    assert!(matches!(error, Error::Shape { .. }), "{error}");
    let count = [entries(tensor("0", 0, 3, 1)), vec![("num_object_springs", b"K\x04".to_vec())]];
    assert!(train(&archive(&program(&count.concat()), &[1.0; 3])).is_err());
    let lacks = &entries(tensor("0", 0, 3, 1))[..4];
    let error = train(&archive(&program(lacks), &[1.0; 3])).unwrap_err();
    assert!(error.to_string().contains("collide_object_fric"), "{error}");
    assert!(train(b"\x80\x02\x8a\x0al\xfc\x9cF").unwrap_err().to_string().contains("1.6"));
    for cut in 0..BEST.len() {
        assert!(train(&BEST[..cut]).is_err(), "{cut}");
    }

    let search = |bytes: &[u8]| SearchResult::decode("a.pkl", bytes, &Limits::default());
    for cut in 0..PARAMS.len() {
        assert!(search(&PARAMS[..cut]).is_err(), "{cut}");
    }
    let error = search(&program(&[("global_spring_Y", b"G\xbf\xf0\0\0\0\0\0\0".to_vec())]));
    assert!(error.unwrap_err().to_string().contains("is -1"));
    let error = search(&program(&[("global_spring_Y", text("soft"))])).unwrap_err();
    assert!(matches!(error, Error::Dtype { .. }), "{error}");
}
