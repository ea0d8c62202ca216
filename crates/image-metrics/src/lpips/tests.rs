//! Values of onnxruntime 1.32 for `testdata/tiny.onnx`, printed by `testdata/tiny_network.py`.

use prost::Message;

use super::{
    onnx::{GraphMessage, Model, NodeMessage, ValueMessage},
    *,
};
use crate::test_images::{Scene, smooth, tiles};

const TINY: &[u8] = include_bytes!("../../testdata/tiny.onnx");

#[test]
fn distances_are_those_of_onnxruntime() {
    let network = Lpips::decode(TINY).unwrap();
    for (scene, expected) in [(tiles(), 0.112_648_949), (smooth(), 0.091_369_651)] {
        let found = network.distance(&scene.pair(None)).unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}");
    }
}

#[test]
fn equal_images_have_no_distance_and_masked_pixels_do_not_count() {
    let network = Lpips::decode(TINY).unwrap();
    let Scene { width, height, a, b } = tiles();
    let same = Scene { width, height, a: a.clone(), b: a.clone() };
    assert_eq!(network.distance(&same.pair(None)).unwrap(), 0.0);
    let scene = Scene { width, height, a, b };
    assert_eq!(network.distance(&scene.pair(Some(&vec![false; scene.a.len()]))).unwrap(), 0.0);
}

#[test]
fn a_file_is_read_and_a_missing_one_is_named() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata");
    assert!(Lpips::open(&folder.join("tiny.onnx")).is_ok());
    let error = Lpips::open(&folder.join("none.onnx")).err().unwrap().to_string();
    assert!(error.contains("none.onnx"), "{error}");
}

#[test]
fn unknown_operators_and_images_too_small_are_explained() {
    let error = Lpips::decode(&model("Gelu", &["a", "b"]).encode_to_vec()).err().unwrap();
    assert!(error.to_string().contains("Gelu"), "{error}");
    let error = Lpips::decode(&model("Add", &["a"]).encode_to_vec()).err().unwrap();
    assert!(error.to_string().contains("1 inputs"), "{error}");
    let network = Lpips::decode(TINY).unwrap();
    let one = Scene { width: 1, height: 1, a: vec![[0.5; 3]], b: vec![[0.4; 3]] };
    let error = network.distance(&one.pair(None)).unwrap_err();
    assert!(error.to_string().contains("smaller than a window"), "{error}");
    // Two images added are no distance.
    let added = Lpips::decode(&model("Add", &["a", "b"]).encode_to_vec()).unwrap();
    let error = added.distance(&tiles().pair(None)).unwrap_err();
    assert!(error.to_string().contains("5760 numbers"), "{error}");
}

#[test]
fn damaged_files_give_errors() {
    let scene = tiles();
    for at in 0..TINY.len() {
        let mut bytes = TINY.to_vec();
        bytes[at] ^= 1 << (at % 8);
        // Most of the file is weights, which may have any value.
        if let Ok(network) = Lpips::decode(&bytes)
            && at % 61 == 0
        {
            let _ = network.distance(&scene.pair(None));
        }
        let _ = Lpips::decode(&TINY[..at]);
    }
}

fn model(operator: &str, inputs: &[&str]) -> Model {
    let value = |name: &str| ValueMessage { name: name.to_owned() };
    let node = NodeMessage {
        input: vec!["a".to_owned(), "b".to_owned()],
        output: vec!["out".to_owned()],
        op_type: operator.to_owned(),
        ..Default::default()
    };
    let graph = GraphMessage {
        node: vec![node],
        input: inputs.iter().map(|name| value(name)).collect(),
        output: vec![value("out")],
        ..Default::default()
    };
    Model { graph: Some(graph) }
}
